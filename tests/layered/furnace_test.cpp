// White surroundings: what arrives leaves again, except for what interfaces lose by themselves.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "layered/agreement.h"
#include "pbrt/core/sampling.h"

namespace lacquer::layered::test::furnace_test {

namespace {

Vec3 At(float deg) { return SphericalDirection(std::sin(Radians(deg)), std::cos(Radians(deg)), 0.7f); }

/// Energy that leaves a stack by LayeredBxDF::Sample, specular paths included. Importance is not scaled by
/// refraction: it counts energy.
RunningMean SampledEnergy(const BxDF& bxdf, Vec3 wo, int numSamples, uint64_t seed) {
    RunningMean energy;
    VisitSamples(bxdf, wo, TransportMode::Importance, Lobes::BothSides, numSamples, seed,
                 [&](const std::optional<BxDFSample>& sample) {
                     energy.Add(sample ? double(sample->weight.Average()) : 0.);
                 });
    return energy;
}

/// Energy of the paths of specular events, by the walks.
double SpecularEnergy(const Stack& stack, Vec3 wo, int numWalks, uint64_t seed, double* error) {
    RunningMean energy;
    Rng rng(seed);
    for (int i = 0; i < numWalks; ++i) {
        const auto exit = AnalogWalk(stack, wo, TransportMode::Importance, kMaxPathVertices, rng);
        energy.Add(exit && exit->isSpecular ? double(exit->weight.Average()) : 0.);
    }
    *error = energy.StandardError();
    return energy.Mean();
}

constexpr float kAngles[] = {5, 60, 85, 120};

TEST(LayeredFurnace, SamplingLosslessStacksGivesAllBack) {
    // No weight differs from 1 by more than rounding: no noise at all, and 0.1 % is far away.
    const LayeredOptions options{.estimator = FindEstimator("bidirectional")};
    int numTested = 0;
    for (const StackCase& row : StackCases()) {
        if (!row.isLossless) continue;
        Arena arena;
        const LayeredBxDF* bxdf = row.MakeBxDF(arena, options);
        for (const float angle : kAngles) {
            if (angle > 90 && !Transmits(bxdf->GetStack())) continue;
            const RunningMean energy =
                SampledEnergy(*bxdf, At(angle), 20000, SeedOf(fmt::format("{} {}", row.name, angle)));
            EXPECT_NEAR(energy.Mean(), 1, 1e-3) << row.name << " at " << angle;
            EXPECT_LT(energy.StandardError(), 2.5e-4) << row.name << " at " << angle;
            ++numTested;
        }
    }
    EXPECT_GE(numTested, 12);
}

// What values give, and what the specular paths carry beside them. Power: 1 % in the fast subset, 0.1 % in
// the full set.
TEST(LayeredFurnace, ValuesOfLosslessStacksAddUpToOne) {
    const int numValues = IsFullRun() ? 4000000 : Scaled(20000);
    const double tolerance = IsFullRun() ? 1e-3 : 1e-2;
    for (const StackCase& row : StackCases()) {
        if (!row.isLossless || (!row.isSmall && !IsFullRun())) continue;
        for (const std::string name : {"bidirectional", "unidirectional", "forward"}) {
            Arena arena;
            const LayeredBxDF* bxdf = row.MakeBxDF(arena, {.estimator = FindEstimator(name)});
            const LobeQuery query{bxdf->GetStack(), At(40), TransportMode::Importance};
            const uint64_t seed = SeedOf(row.name + name);
            double specular = 0, specularError = 0;
            if (row.isSmooth)
                specular = SpecularEnergy(query.stack, query.wo, numValues, Hash(seed, 1), &specularError);
            const Moments values = MomentsByValues(query, GuideOf(query, Hash(seed, 2)), numValues, seed,
                                                   ValuesOf(*bxdf, query.wo, query.mode));
            EXPECT_NEAR(values.Albedo() + specular, 1,
                        tolerance + 3.3 * std::hypot(values.AlbedoError(), specularError))
                << row.name << " " << name;
        }
    }
}

/// The energy that one interface keeps for itself, by direction: a table over angles of 2 degrees.
class SingleLoss {
  public:
    SingleLoss(const StackInterface& interface, uint64_t seed) {
        for (int i = 0; i < 90; ++i) {
            const RunningMean energy =
                i >= 45 && !interface.transmits
                    ? RunningMean()
                    : SampledEnergy(*interface.bxdf, At(float(2 * i + 1)), Scaled(4000), Hash(seed, i));
            losses_.push_back(1 - energy.Mean());
            EXPECT_LE(energy.Mean(), 1 + 5 * energy.StandardError() + 1e-5);
        }
    }
    double operator()(Vec3 w) const {
        const double x = std::clamp(double(Degrees(SafeACos(w.z))) / 2 - 0.5, 0., 88.999);
        const size_t i = size_t(x);
        return losses_[i] + (x - double(i)) * (losses_[i + 1] - losses_[i]);
    }

  private:
    std::vector<double> losses_;
};

// A rough interface loses what would scatter between its facets again; nothing else of these stacks does. So
// what is missing is the loss of all visits of all walks, and no more. Power: 0.5 %.
TEST(LayeredFurnace, RoughStacksFallShortByTheLossOfTheirInterfacesOnly) {
    struct Row {
        const char* name;
        std::vector<Layer> layers;
    };
    const float up = 1 / 1.5f;
    const Row rows[] = {
        {"coat_mirror", {Dielectric(0.3f, 1.5f), Mirror(0.2f)}},
        {"coat_mirror_beckmann", {Dielectric(0.5f, 1.5f, kBeckmann), Mirror(0.1f, kBeckmann)}},
        {"coat_medium_mirror", {Dielectric(0.3f, 1.5f), Medium(1, 1, HG(0.5f)), Mirror(0.3f)}},
        {"pane", {Dielectric(0.4f, 1.5f), Dielectric(0.2f, up)}},
        {"pane_medium", {Dielectric(0.2f, 1.5f), Medium(0.5f, 1, Isotropic()), Dielectric(0.2f, up)}},
    };
    for (const Row& row : rows) {
        Arena arena;
        const StackCase stackCase{.name = row.name, .layers = row.layers};
        const LayeredBxDF* bxdf = stackCase.MakeBxDF(arena, {.estimator = FindEstimator("bidirectional")});
        const Stack& stack = bxdf->GetStack();
        std::vector<SingleLoss> losses;
        for (size_t i = 0; i < stack.interfaces.size(); ++i)
            losses.emplace_back(stack.interfaces[i], Hash(SeedOf(row.name), i));
        for (const float angle : {10.f, 60.f}) {
            const RunningMean energy = SampledEnergy(*bxdf, At(angle), Scaled(60000), SeedOf(row.name));
            RunningMean loss;
            Rng rng(SeedOf(std::string(row.name) + " visits"));
            std::vector<AnalogVisit> visits;
            for (int i = 0; i < Scaled(40000); ++i) {
                visits.clear();
                AnalogWalk(stack, At(angle), TransportMode::Importance, kMaxPathVertices, rng, &visits);
                double sum = 0;
                for (const AnalogVisit& visit : visits)
                    sum += visit.energy * losses[size_t(visit.interface)](visit.wo);
                loss.Add(sum);
            }
            EXPECT_LE(energy.Mean(), 1 + 4 * energy.StandardError()) << row.name << " at " << angle;
            EXPECT_NEAR(energy.Mean(), 1 - loss.Mean(),
                        0.003 + 4 * std::hypot(energy.StandardError(), loss.StandardError()))
                << row.name << " at " << angle;
        }
    }
}

}  // namespace
}  // namespace lacquer::layered::test::furnace_test
