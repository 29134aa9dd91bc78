// Properties of single queries: reciprocity, one side alone, cut lengths, randomness.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "layered/agreement.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"

namespace lacquer::layered::test::query_test {

namespace {

const Vec3 kOblique = SphericalDirection(std::sin(Radians(50)), std::cos(Radians(50)), 1.1f);
const char* const kEstimators[] = {"forward", "unidirectional", "bidirectional"};

/// Two directions in which the lobe of wo is not negligible, above and, where light passes, below.
std::vector<Vec3> LitDirections(const LobeQuery& query, uint64_t seed) {
    const GuideDensity guide = GuideOf(query, seed);
    Rng rng(Hash(seed, 9));
    std::vector<Vec3> found;
    for (const bool above : {true, false}) {
        if ((query.wo.z > 0) != above && !Transmits(query.stack)) continue;
        for (int n = 0; n < 2;) {
            const Vec3 w = guide.Sample(rng).w;
            if ((w.z > 0) == above && std::abs(w.z) > 0.1f) {
                found.push_back(w);
                ++n;
            }
        }
    }
    return found;
}

RunningMean MeanValue(const BxDF& bxdf, Vec3 wo, Vec3 wi, TransportMode mode, Lobes sides, int numValues,
                      uint64_t seed) {
    RunningMean mean;
    Rng rng(seed);
    for (int i = 0; i < numValues; ++i)
        mean.Add(double(bxdf.Evaluate(wo, wi, {mode, sides, &rng, false}).f.Average()));
    return mean;
}

/// p-value of two means being in the ratio `scale`.
double Agree(const RunningMean& a, const RunningMean& b, double scale = 1) {
    const double sigma =
        std::hypot(a.StandardError(), scale * b.StandardError()) + 1e-5 * std::abs(a.Mean()) + 1e-12;
    return NormalTwoSided((a.Mean() - scale * b.Mean()) / sigma);
}

std::vector<const StackCase*> SmallRows() {
    std::vector<const StackCase*> rows;
    for (const StackCase& row : StackCases())
        if (row.isSmall || IsFullRun()) rows.push_back(&row);
    return rows;
}

bool HasPerturbedNormal(const Stack& stack) {
    return std::any_of(stack.interfaces.begin(), stack.interfaces.end(),
                       [](const StackInterface& i) { return i.frame.z.z < 0.9999f; });
}

// At 4,000 values of about one standard deviation a pair shows an error of 10 %, and all 250 together one of
// 1 %. Narrow lobes have rare bright values; a pair that fails must fail again with 16 times as many.
TEST(LayeredQuery, IsReciprocalUpToTheIndicesOutside) {
    const int numValues = IsFullRun() ? 200000 : Scaled(3000);
    const double alpha = SidakAlpha(1e-3, 2000);
    double sum = 0, variance = 0;
    const auto check = [&](const BxDF& bxdf, Vec3 wo, Vec3 wi, TransportMode mode, Vec3 wo2, Vec3 wi2,
                           TransportMode mode2, double scale, const std::string& what) {
        double p = 0;
        RunningMean a, b;
        for (int n = numValues, round = 0; p < alpha && round < 2; ++round, n *= 16) {
            const uint64_t seed = Hash(SeedOf(what), round);
            a = MeanValue(bxdf, wo, wi, mode, Lobes::BothSides, n, Hash(seed, 1));
            b = MeanValue(bxdf, wo2, wi2, mode2, Lobes::BothSides, n, Hash(seed, 2));
            p = Agree(a, b, scale);
        }
        EXPECT_GE(p, alpha) << fmt::format("{}: {:.6g} +- {:.2g} against {:.6g} +- {:.2g} times {}", what,
                                           a.Mean(), a.StandardError(), b.Mean(), b.StandardError(), scale);
        const double common = (a.Mean() + scale * b.Mean()) / 2;
        if (!(common > 0)) return;
        sum += (a.Mean() - scale * b.Mean()) / common;
        variance += (Sqr(a.StandardError()) + Sqr(scale * b.StandardError())) / Sqr(common);
    };
    for (const StackCase* row : SmallRows()) {
        Arena arena;
        const LayeredBxDF* bxdf = row->MakeBxDF(arena, {.estimator = FindEstimator("bidirectional")});
        const Stack& stack = bxdf->GetStack();
        int i = 0;
        for (const Vec3 wi : LitDirections({stack, kOblique}, SeedOf(row->name))) {
            const std::string what = fmt::format("{} #{}", row->name, i++);
            check(*bxdf, kOblique, wi, TransportMode::Radiance, wi, kOblique, TransportMode::Importance, 1,
                  what + " adjoint");
            // Perturbed normals are reciprocal in the sense of the adjoint only.
            if (HasPerturbedNormal(stack)) continue;
            const double scale = wi.z > 0 ? 1 : 1 / double(Sqr(stack.eta));
            check(*bxdf, kOblique, wi, TransportMode::Radiance, kOblique, wi, TransportMode::Importance,
                  scale, what + " modes");
        }
    }
    EXPECT_GE(NormalTwoSided(sum / std::sqrt(variance)), 1e-3) << "a common bias";
}

TEST(LayeredQuery, OneSideAloneGivesThatSide) {
    const int numValues = Scaled(4000);
    const double alpha = SidakAlpha(1e-3, 500);
    for (const char* name : {"pane_020_010", "rough_pane_medium", "coat_medium_metal", "pane_smooth_rough"}) {
        Arena arena;
        const StackCase& row = FindStackCase(name);
        const LayeredBxDF* bxdf = row.MakeBxDF(arena, {.estimator = FindEstimator("bidirectional")});
        const LobeQuery query{bxdf->GetStack(), kOblique};
        const uint64_t seed = SeedOf(name);
        for (const Vec3 wi : LitDirections(query, seed)) {
            const Lobes side = wi.z > 0 ? Lobes::Reflection : Lobes::Transmission;
            const Lobes other = wi.z > 0 ? Lobes::Transmission : Lobes::Reflection;
            const auto mean = [&](Lobes sides, int salt) {
                return MeanValue(*bxdf, kOblique, wi, query.mode, sides, numValues, Hash(seed, salt));
            };
            EXPECT_GE(Agree(mean(side, 1), mean(Lobes::BothSides, 2)), alpha) << name;
            EXPECT_GT(mean(side, 1).Mean(), 0) << name;
            EXPECT_EQ(mean(other, 3).Mean(), 0) << name;
        }
    }
}

TEST(LayeredQuery, CutPathsAgreeWithCutWalks) {
    const double alpha = SidakAlpha(1e-3, 8 * 5 * 3 * kNumMoments);
    const Effort effort{Scaled(20000), Scaled(5000), 1, Scaled(5000)};
    for (const char* name : {"coat_030_metal_010", "smooth_coat_metal_020", "three_panes", "v1",
                             "rough_pane_medium", "two_media", "nothing_over_metal", "smooth_medium_diffuse"})
        for (const char* estimator : kEstimators) {
            Arena arena;
            for (const int maxVertices : {1, 2, 3, 4, 7}) {
                const LayeredBxDF* bxdf = FindStackCase(name).MakeBxDF(
                    arena, {.estimator = FindEstimator(estimator), .maxVertices = maxVertices});
                const LobeQuery query{bxdf->GetStack(), kOblique, TransportMode::Radiance, maxVertices};
                const std::string what = fmt::format("{} {} {}", name, estimator, maxVertices);
                const Agreement a =
                    Examine(query, ValuesOf(*bxdf, kOblique, query.mode), effort, SeedOf(what), kSuspicious);
                EXPECT_GE(NormalTwoSided(a.WorstZ()), alpha)
                    << what << ": " << a.comparison.Describe(a.values, a.walks);
            }
        }
}

TEST(LayeredQuery, LongerCutsNeverLoseWalks) {
    for (const char* name : {"coat_030_metal_010", "rough_pane_medium"}) {
        Arena arena;
        const Stack stack = FindStackCase(name).Build(arena);
        for (uint64_t i = 0; i < 2000; ++i) {
            bool wasFound = false;
            for (const int maxVertices : {1, 2, 3, 4, 6, 20, kMaxPathVertices}) {
                Rng rng(Hash(SeedOf(name), i));
                const auto exit = AnalogWalk(stack, kOblique, TransportMode::Radiance, maxVertices, rng);
                EXPECT_LE(wasFound, exit.has_value());
                EXPECT_LE(exit ? exit->numVertices : 0, maxVertices);
                wasFound = exit.has_value();
            }
        }
    }
}

/// Values of one query with a generator that goes on.
std::vector<float> Repeat(const BxDF& bxdf, Vec3 wi, int count, uint64_t seed) {
    std::vector<float> values;
    Rng rng(seed);
    for (int i = 0; i < count; ++i)
        values.push_back(
            bxdf.Evaluate(kOblique, wi, {TransportMode::Radiance, Lobes::BothSides, &rng, true}).f[0]);
    return values;
}

TEST(LayeredQuery, RandomnessIsTheCallersAndNothingElse) {
    const Vec3 wi = Normalize(Vec3(-0.5f, -0.8f, 0.7f));
    for (const char* name : {"coat_030_metal_010", "v1", "coat_medium_metal"})
        for (const char* estimator : kEstimators) {
            Arena arena;
            const LayeredOptions options{.estimator = FindEstimator(estimator), .pdf = FindPdf("unbiased")};
            const LayeredBxDF* bxdf = FindStackCase(name).MakeBxDF(arena, options);
            // The same state gives the same bits, on any thread ...
            const std::vector<float> once = Repeat(*bxdf, wi, 64, 7);
            std::vector<std::vector<float>> again(8);
            ParallelFor(8, [&](int64_t i) { again[size_t(i)] = Repeat(*bxdf, wi, 64, 7); });
            for (const auto& values : again) EXPECT_EQ(values, once) << name << " " << estimator;
            // ... and another one gives another estimate.
            EXPECT_GT(std::set<float>(once.begin(), once.end()).size(), 8u) << name << " " << estimator;
        }
}

// Directions in the surface, almost in it, straight up, equal and opposite; and media that are hardly there
// or very thick.
TEST(LayeredQuery, IsFiniteAndNotNegativeInDegenerateDirections) {
    std::vector<StackCase> rows = StackCases();
    rows.push_back(
        {.name = "thickest", .layers = {Dielectric(0.3f, 1.5f), Medium(1e4f, 0.5f, HG(0.9f)), Metal(0.1f)}});
    rows.push_back(
        {.name = "thinnest", .layers = {Dielectric(0.3f, 1.5f), Medium(1e-30f, 1, HG(0.9f)), Metal(0.1f)}});
    rows.push_back(
        {.name = "sharpest",
         .layers = {Dielectric(0.0011f, 3), Medium(1, 1, HG(0.999f)), Dielectric(0.0011f, 1 / 3.f)}});
    rows.push_back(
        {.name = "indices", .layers = {Dielectric(0.3f, 100), Dielectric(0.3f, 0.01f), Metal(0.1f)}});
    std::vector<Vec3> directions;
    for (const float z : {1.f, 0.7f, 1e-3f, 1e-7f, 1e-20f, 0.f})
        for (const float sign : {1.f, -1.f})
            for (const float phi : {0.f, 2.f})
                directions.push_back(SphericalDirection(SafeSqrt(1 - z * z), sign * z, phi));
    const LayeredPdf* const pdfs[] = {FindPdf("approximate"), FindPdf("unbiased")};
    for (const StackCase& row : rows)
        for (int k = 0; k < 3; ++k) {
            Arena arena;
            const LayeredBxDF* bxdf =
                row.MakeBxDF(arena, {.estimator = FindEstimator(kEstimators[k]), .pdf = pdfs[k % 2]});
            Rng rng(SeedOf(row.name));
            for (const Vec3 wo : directions)
                for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance}) {
                    const BxDFContext context{mode, Lobes::BothSides, &rng};
                    const float lobe = rng.Uniform();
                    const auto sample = bxdf->Sample(wo, {lobe, rng.Uniform2D()}, context);
                    EXPECT_TRUE(!sample || sample->weight.IsValid()) << row.name;
                    for (const Vec3 wi : directions) {
                        const BxDFValue value = bxdf->Evaluate(wo, wi, context);
                        EXPECT_TRUE(value.f.IsValid() && value.pdf >= 0 && std::isfinite(value.pdf))
                            << row.name << " " << kEstimators[k] << " " << wo.z << " " << wi.z << " "
                            << value.f[0] << " " << value.f[3] << " " << value.pdf;
                        EXPECT_TRUE((wo.z != 0 && wi.z != 0) || !value.f) << row.name;
                    }
                }
        }
}

TEST(LayeredQuery, AveragesAsManyEstimatesAsAsked) {
    const Vec3 wi = Normalize(Vec3(-0.5f, -0.8f, 0.7f));
    Arena arena;
    const StackCase& row = FindStackCase("coat_030_metal_010");
    const auto variance = [&](int numSamples) {
        const LayeredBxDF* bxdf =
            row.MakeBxDF(arena, {.estimator = FindEstimator("bidirectional"), .numSamples = numSamples});
        return MeanValue(*bxdf, kOblique, wi, TransportMode::Radiance, Lobes::BothSides, 10000, 3).Variance();
    };
    EXPECT_NEAR(variance(8) * 8 / variance(1), 1, 0.4);
}

TEST(LayeredQuery, TwoSidedStacksAreTurnedOver) {
    Arena arena;
    const LayeredBxDF* bxdf =
        FindStackCase("coat_030_metal_010")
            .MakeBxDF(arena, {.estimator = FindEstimator("bidirectional"), .isTwoSided = true});
    const Vec3 wi = Normalize(Vec3(-0.5f, -0.8f, 0.7f));
    const auto value = [&](Vec3 o, Vec3 i) {
        Rng rng(5);
        return bxdf->Evaluate(o, i, {TransportMode::Radiance, Lobes::BothSides, &rng, false}).f;
    };
    EXPECT_EQ(value(-kOblique, -wi), value(kOblique, wi));
    EXPECT_EQ(value(-kOblique, wi), SampledSpectrum(0));
    EXPECT_GT(value(kOblique, wi).Average(), 0);
}

}  // namespace
}  // namespace lacquer::layered::test::query_test
