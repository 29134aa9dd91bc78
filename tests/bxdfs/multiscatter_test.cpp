// Rough boundaries with all bounces between their facets: nothing is lost, values are what samples find, and
// colours saturate.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <mutex>

#include "layered/lobe_moments.h"
#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/multiscatter_conductor.h"
#include "pbrt/bxdfs/multiscatter_dielectric.h"
#include "pbrt/core/arena.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"
#include "support/lanes.h"
#include "support/statistics.h"

namespace lacquer::test::multiscatter_test {
namespace {

/// True if the environment asks for all directions to 0.1 %: minutes.
bool IsFullRun() {
    const char* full = std::getenv("LACQUER_FULL");
    return full && *full && *full != '0';
}

struct Boundary {
    MicrofacetModel model;
    Alphas alphas;
    float eta = 0;      ///< 0: a metal that reflects everything
    int maxEvents = 0;  ///< 0: the default
    std::string Name() const {
        return fmt::format("{} {} {} eta {}", model == MicrofacetModel::Beckmann ? "Beckmann" : "GGX",
                           alphas.x, alphas.y, eta);
    }
};

template <class Distribution>
const BxDF* MakeRescattering(const Boundary& b, Arena& arena) {
    using Metal = MultiscatterConductorBxDF<Distribution>;
    using Glass = MultiscatterDielectricBxDF<Distribution>;
    if (b.eta == 0)
        return arena.New<Metal>(b.alphas, SampledSpectrum(0), SampledSpectrum(1),
                                b.maxEvents > 0 ? b.maxEvents : Metal::kMaxBounces);
    return arena.New<Glass>(b.alphas, b.eta, b.maxEvents > 0 ? b.maxEvents : Glass::kMaxEvents);
}
const BxDF* MakeRescattering(const Boundary& b, Arena& arena) {
    return b.model == MicrofacetModel::Beckmann ? MakeRescattering<Beckmann>(b, arena)
                                                : MakeRescattering<TrowbridgeReitz>(b, arena);
}
/// Directions of a known density for integrals: as dense as samples are, with a cosine lobe on either side.
/// However it was made, what is integrated by it has no bias.
class Guide {
  public:
    Guide(const BxDF& bxdf, Vec3 wo, const std::string& name) {
        std::vector<Vec3> directions;
        Rng rng(SeedOf("guide " + name));
        for (int i = 0; i < 6000; ++i) {
            const float lobe = rng.Uniform();
            if (const auto s = bxdf.Sample(wo, {lobe, rng.Uniform2D()}, Context(rng)))
                directions.push_back(s->wi);
        }
        const bool hasBothSides = wo.z < 0 || Any(bxdf.Flags(), Lobes::Transmission);
        density_.emplace(directions, std::vector<double>(directions.size(), 1), hasBothSides);
    }
    auto Sample(Rng& rng) const { return density_->Sample(rng); }
    static BxDFContext Context(Rng& rng) { return {TransportMode::Importance, Lobes::BothSides, &rng}; }

  private:
    std::optional<layered::test::GuideDensity> density_;
};

/// Integral of f |cos| over all wi by values, for importance, which counts energy.
RunningMean EnergyByValues(const BxDF& bxdf, const Guide& guide, Vec3 wo, int count, uint64_t seed) {
    Rng rng(seed);
    RunningMean energy;
    const BxDFContext context{TransportMode::Importance, Lobes::BothSides, &rng, false};
    for (int i = 0; i < count; ++i) {
        const auto drawn = guide.Sample(rng);
        energy.Add(double(bxdf.Evaluate(wo, drawn.w, context).f[0]) * std::abs(double(drawn.w.z)) /
                   drawn.pdf);
    }
    return energy;
}

Vec3 At(float deg) { return SphericalDirection(std::sin(Radians(deg)), std::cos(Radians(deg)), 0.7f); }

std::vector<Boundary> Furnaces(float eta) {
    std::vector<Boundary> list;
    for (const MicrofacetModel model : {MicrofacetModel::TrowbridgeReitz, MicrofacetModel::Beckmann})
        for (const Alphas alphas :
             {Alphas(0.05f, 0.05f), Alphas(0.1f, 0.1f), Alphas(0.2f, 0.2f), Alphas(0.4f, 0.4f),
              Alphas(0.7f, 0.7f), Alphas(1, 1), Alphas(0.05f, 0.4f), Alphas(0.9f, 0.3f)})
            list.push_back({model, alphas, eta});
    return list;
}
constexpr float kAngles[] = {0, 30, 60, 75, 85, 89, 89.5f};

class MultiscatterFurnace : public testing::TestWithParam<float> {};

// Power: each direction of each boundary to some 3 % in the fast run and to 0.3 % in the full one; all
// together to 0.2 % in the fast run, to 0.03 % in the full one.
TEST_P(MultiscatterFurnace, ValuesOfLosslessBoundariesAddUpToOne) {
    const std::vector<Boundary> list = Furnaces(GetParam());
    const int numTests = int(list.size() * std::size(kAngles)),
              perTest = IsFullRun() ? 2000000 : Scaled(20000);
    std::mutex mutex;
    double sum = 0, variance = 0, worst = 0, worstError = 0;
    std::string failures, coarsest;
    ParallelFor(numTests, [&](int64_t i) {
        const Boundary& b = list[size_t(i) / std::size(kAngles)];
        const float angle = kAngles[size_t(i) % std::size(kAngles)];
        const std::string name = fmt::format("{} at {}", b.Name(), angle);
        Arena arena;
        const BxDF* bxdf = MakeRescattering(b, arena);
        const RunningMean energy = EnergyByValues(*bxdf, Guide(*bxdf, At(angle), name), At(angle), perTest,
                                                  SeedOf("furnace " + name));
        const std::lock_guard lock(mutex);
        sum += energy.Mean() - 1;
        variance += Sqr(energy.StandardError());
        worst = std::max(worst, std::abs(energy.Mean() - 1));
        if (energy.StandardError() > worstError) coarsest = name;
        worstError = std::max(worstError, energy.StandardError());
        // Rare bright values make a mean and its error too small together.
        if (std::abs(energy.Mean() - 1) > 5 * energy.StandardError() + 1e-4)
            failures += fmt::format("{}: {:.5f} +- {:.5f}\n", name, energy.Mean(), energy.StandardError());
    });
    EXPECT_EQ(failures, "");
    const double mean = sum / numTests, error = std::sqrt(variance) / numTests;
    EXPECT_LT(std::abs(mean), 4 * error + 1e-4) << mean << " +- " << error;
    const std::string summary = fmt::format(
        "{} directions: mean {:+.5f} +- {:.5f}, the worst off by {:.5f}, largest error {:.5f} ({})", numTests,
        mean, error, worst, worstError, coarsest);
    RecordProperty("summary", summary);
    if (IsFullRun()) std::cout << summary << std::endl;
}

TEST_P(MultiscatterFurnace, SamplesOfLosslessBoundariesHaveTheWeightOne) {
    for (const Boundary& b : Furnaces(GetParam()))
        for (const float angle : kAngles) {
            Arena arena;
            const BxDF* bxdf = MakeRescattering(b, arena);
            Rng rng(SeedOf(b.Name()));
            int numLost = 0, numWrong = 0;
            for (int i = 0; i < 3000; ++i) {
                const float lobe = rng.Uniform();
                const auto s = bxdf->Sample(At(angle), {lobe, rng.Uniform2D()}, Guide::Context(rng));
                numLost += !s;
                numWrong +=
                    s && (std::abs(s->weight[0] - 1) > 1e-6f || !(s->pdf > 0) || !(s->pdfReverse > 0));
            }
            EXPECT_LE(numLost, 1) << b.Name() << " at " << angle;
            EXPECT_EQ(numWrong, 0) << b.Name() << " at " << angle;
        }
}

// The density is an approximation: its integral is that of the draws to 15 % for metals, 60 % for others.
TEST_P(MultiscatterFurnace, DensitiesIntegrateToAboutOne) {
    double smallest = 10, largest = 0;
    for (const Boundary& b : Furnaces(GetParam()))
        for (const float angle : kAngles) {
            Arena arena;
            const BxDF* bxdf = MakeRescattering(b, arena);
            const Guide guide(*bxdf, At(angle), b.Name());
            Rng rng(SeedOf(b.Name()));
            RunningMean integral;
            for (int i = 0; i < Scaled(8000); ++i) {
                const auto drawn = guide.Sample(rng);
                integral.Add(double(bxdf->Pdf(At(angle), drawn.w, Guide::Context(rng))) / drawn.pdf);
            }
            smallest = std::min(smallest, integral.Mean());
            largest = std::max(largest, integral.Mean());
            EXPECT_NEAR(integral.Mean(), 1, (GetParam() == 0 ? 0.15 : 0.6) + 5 * integral.StandardError())
                << b.Name() << " at " << angle;
        }
    RecordProperty("integrals", fmt::format("{:.3f} to {:.3f}", smallest, largest));
}

std::string NameOfIndex(const testing::TestParamInfo<float>& info) {
    return info.param == 0  ? "Metal"
           : info.param < 1 ? "GlassFromInside"
           : info.param < 2 ? "Glass"
                            : "Diamond";
}
INSTANTIATE_TEST_SUITE_P(, MultiscatterFurnace, testing::Values(0.f, 1.5f, 1 / 1.5f, 2.4f), NameOfIndex);

/// The energy in each bin of the sphere of wi, by values or by samples.
using Bins = std::array<RunningMean, 48>;
size_t BinOf(Vec3 w) {
    const int i = std::min(int((w.z + 1) * 3), 5), j = std::min(int((SphericalPhi(w) * Inv2Pi) * 8), 7);
    return size_t(8 * i + j);
}
Bins BinsByValues(const BxDF& bxdf, const Guide& guide, Vec3 wo, int count, uint64_t seed) {
    Rng rng(seed);
    Bins bins;
    for (int i = 0; i < count; ++i) {
        const auto drawn = guide.Sample(rng);
        const double value = double(bxdf.Evaluate(wo, drawn.w, Guide::Context(rng)).f[0]) *
                             std::abs(double(drawn.w.z)) / drawn.pdf;
        const size_t here = BinOf(drawn.w);
        for (size_t k = 0; k < bins.size(); ++k) bins[k].Add(k == here ? value : 0.);
    }
    return bins;
}
Bins BinsBySamples(const BxDF& bxdf, Vec3 wo, Lobes sides, int count, uint64_t seed) {
    Rng rng(seed);
    Bins bins;
    for (int i = 0; i < count; ++i) {
        const float lobe = rng.Uniform();
        const auto s = bxdf.Sample(wo, {lobe, rng.Uniform2D()}, {TransportMode::Importance, sides, &rng});
        const size_t here = s ? BinOf(s->wi) : 0;
        for (size_t k = 0; k < bins.size(); ++k) bins[k].Add(s && k == here ? double(s->weight[0]) : 0.);
    }
    return bins;
}
Outcome CompareBins(const Bins& a, const Bins& b) {
    double chi2 = 0;
    int degrees = 0;
    std::string worst;
    for (size_t k = 0; k < a.size(); ++k) {
        const double variance = Sqr(a[k].StandardError()) + Sqr(b[k].StandardError());
        // Too few in a bin for a normal distribution.
        if (std::max(a[k].Mean(), b[k].Mean()) < 2e-3) continue;
        ++degrees;
        const double z2 = Sqr(a[k].Mean() - b[k].Mean()) / variance;
        chi2 += z2;
        if (z2 > 12) worst += fmt::format(" bin {}: {:.5f} {:.5f}", k, a[k].Mean(), b[k].Mean());
    }
    return {ChiSquareSurvival(chi2, std::max(degrees, 1)),
            fmt::format("chi2 {:.1f} of {}{}", chi2, degrees, worst)};
}

const Boundary kExamples[] = {
    {MicrofacetModel::TrowbridgeReitz, Alphas(0.8f, 0.8f)},
    {MicrofacetModel::Beckmann, Alphas(0.9f, 0.3f)},
    {MicrofacetModel::TrowbridgeReitz, Alphas(0.3f, 0.3f)},
    {MicrofacetModel::TrowbridgeReitz, Alphas(0.8f, 0.8f), 1.5f},
    {MicrofacetModel::Beckmann, Alphas(0.7f, 0.7f), 1 / 1.5f},
    {MicrofacetModel::TrowbridgeReitz, Alphas(0.2f, 0.6f), 1.5f},
};

// Values start at either end and, of metals, know no depths; samples start at wo and have depths. Power: 3 %
// of the energy of a bin with a tenth of it, 1 % of that of all.
TEST(Multiscatter, SamplesFollowTheValues) {
    for (const Boundary& b : kExamples)
        for (const float angle : {20.f, 70.f, 88.f, 130.f}) {
            const std::string name = fmt::format("{} {} at {}", FullTestName(), b.Name(), angle);
            Arena arena;
            const BxDF* bxdf = MakeRescattering(b, arena);
            const Guide guide(*bxdf, At(angle), b.Name());
            EXPECT_TRUE(Passes(name, SidakAlpha(1e-3, 24), [&](uint64_t seed) {
                return CompareBins(
                    BinsByValues(*bxdf, guide, At(angle), Scaled(100000), Hash(seed, 1)),
                    BinsBySamples(*bxdf, At(angle), Lobes::BothSides, Scaled(100000), Hash(seed, 2)));
            })) << name;
        }
}

TEST(Multiscatter, SamplesOfOneSideAreThoseOfBothWithoutTheOther) {
    for (const Boundary& b : kExamples) {
        if (b.eta == 0) continue;
        for (const Lobes side : {Lobes::Reflection, Lobes::Transmission})
            for (const float angle : {70.f, 130.f}) {
                const std::string name =
                    fmt::format("{} {} {} at {}", FullTestName(), b.Name(), unsigned(side), angle);
                Arena arena;
                const BxDF* bxdf = MakeRescattering(b, arena);
                const bool isUpper = (side == Lobes::Reflection) == (angle < 90);
                EXPECT_TRUE(Passes(name, SidakAlpha(1e-3, 12), [&](uint64_t seed) {
                    Bins all =
                        BinsBySamples(*bxdf, At(angle), Lobes::BothSides, Scaled(100000), Hash(seed, 1));
                    for (size_t k = 0; k < all.size(); ++k)
                        if ((k >= all.size() / 2) != isUpper) all[k] = {};
                    return CompareBins(all,
                                       BinsBySamples(*bxdf, At(angle), side, Scaled(100000), Hash(seed, 2)));
                })) << name;
            }
    }
}

// Negative controls: walks that end after two events.
TEST(Multiscatter, CutWalksFailTheFurnaceAndTheComparison) {
    for (Boundary b : {kExamples[0], kExamples[3]}) {
        Arena arena;
        const BxDF* right = MakeRescattering(b, arena);
        const Guide guide(*right, At(70), b.Name());
        b.maxEvents = 2;
        const BxDF* cut = MakeRescattering(b, arena);
        const RunningMean energy =
            EnergyByValues(*cut, guide, At(70), Scaled(200000), SeedOf(FullTestName()));
        EXPECT_LT(energy.Mean() + 5 * energy.StandardError(), 0.999) << b.Name();
        const uint64_t seed = SeedOf(FullTestName());
        EXPECT_LT(CompareBins(BinsByValues(*cut, guide, At(70), Scaled(200000), seed),
                              BinsBySamples(*right, At(70), Lobes::BothSides, Scaled(200000), ~seed))
                      .pValue,
                  1e-6)
            << b.Name();
    }
}

// The loss that the walks bring back: 1 - ln 2 is the albedo of one reflection at normal incidence.
TEST(Multiscatter, SingleReflectionsLoseTwoThirdsOfTheLightAtAlphaOne) {
    Arena arena;
    const Boundary b{MicrofacetModel::TrowbridgeReitz, Alphas(1, 1)};
    const ConductorBxDF<TrowbridgeReitz> single(b.alphas, SampledSpectrum(0), SampledSpectrum(1));
    const Guide guide(*MakeRescattering(b, arena), At(0), b.Name());
    const RunningMean energy = EnergyByValues(single, guide, At(0), Scaled(200000), SeedOf(FullTestName()));
    EXPECT_NEAR(energy.Mean(), 1 - std::log(2.), 4.5 * energy.StandardError());
}

// Each bounce takes its share: light of two and more is more saturated than that of one.
TEST(Multiscatter, ColoursSaturate) {
    using Facets = TrowbridgeReitz;
    const Alphas alphas(0.8f, 0.8f);
    // Gold at 650, 550, 500 and 450 nm, about.
    const SampledSpectrum eta = Lanes(0.16f, 0.42f, 0.86f, 1.4f), k = Lanes(3.4f, 2.4f, 1.85f, 1.9f);
    const MultiscatterConductorBxDF<Facets> all(alphas, eta, k);
    const ConductorBxDF<Facets> single(alphas, eta, k);
    Rng rng(SeedOf(FullTestName()));
    SampledSpectrum sumAll(0), sumSingle(0);
    for (int i = 0; i < 100000; ++i) {
        const Vec3 wi = SampleCosineHemisphere(rng.Uniform2D());
        const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng, false};
        sumAll += all.Evaluate(At(40), wi, context).f;
        sumSingle += single.Evaluate(At(40), wi, context).f;
    }
    const SampledSpectrum rest = sumAll - sumSingle;
    EXPECT_GT(rest[3], 0);
    EXPECT_LT(rest[3] / rest[0], 0.75f * sumSingle[3] / sumSingle[0]);
    EXPECT_LT(rest[1] / rest[0], sumSingle[1] / sumSingle[0]);
}

}  // namespace
}  // namespace lacquer::test::multiscatter_test
