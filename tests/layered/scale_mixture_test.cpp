// Half-vector sampling by scale mixtures of Gaussians.
#include "layered/paths/mixtures/scale_mixture.h"

#include <gtest/gtest.h>

#include "layered/agreement.h"
#include "layered/path_bias.h"
#include "layered/paths/mixtures/slope_mixtures.h"

namespace lacquer::layered::test::scale_mixture_test {

namespace {

constexpr double kFamily = 1e-3;  ///< chance that a test of many cases raises a false alarm
constexpr auto kImportance = TransportMode::Importance;

// ---- Scales -------------------------------------------------------------------------------------------

/// Facets seen from above: all slopes at alpha = 1 as the mixture has them, at a distance r.
double MixtureDensity(const SlopeScales& scales, double r) {
    PathEnd end;
    end.scales = &scales;
    return double(VisibleSlopeMixture(end).At({float(r), 0})) / (2 * double(Pi));
}
/// Variance of p/q' for slopes within 12 alpha, p being Trowbridge and Reitz' density and q' nine parts of
/// the mixture and one of p.
double VarianceOfScales(const SlopeScales& scales) {
    constexpr int kSteps = 100000;
    double mean = 0, square = 0, within = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double r2 = 144 * (i + 0.5) / kSteps, area = double(Pi) * 144 / kSteps;
        const double p = 1 / (double(Pi) * (1 + r2) * (1 + r2));
        const double q = 0.9 * MixtureDensity(scales, std::sqrt(r2)) + 0.1 * p;
        within += area * q;
        mean += area * p;
        square += area * p * p / q;
    }
    // The variance for a density of q alone, where both are cut off.
    return square * within / (mean * mean) - 1;
}

TEST(SlopeScales, ReproduceTrowbridgeAndReitz) {
    const SlopeScales& scales = ScalesOf(MicrofacetModel::TrowbridgeReitz);
    EXPECT_NEAR(SumOf(scales.weight), 1, 1e-6f);
    EXPECT_LT(VarianceOfScales(scales), 0.01);
    // Negative control: one Gaussian.
    EXPECT_GT(VarianceOfScales(ScalesOf(MicrofacetModel::Beckmann)), 0.3);
}

TEST(SlopeScales, BeckmannIsOneOfThem) {
    const SlopeScales& scales = ScalesOf(MicrofacetModel::Beckmann);
    for (const double r : {0., 0.5, 1., 2.})
        EXPECT_NEAR(MixtureDensity(scales, r) * double(Pi) * std::exp(r * r), 1, 1e-5);
}

// ---- Densities of facets ------------------------------------------------------------------------------

PathEnd MakePathEnd(Vec3 w, float alpha, float eta, MicrofacetModel model) {
    PathEnd end;
    end.w = Normalize(w);
    end.covariance = {0.5f * alpha * alpha, 0, 0.5f * alpha * alpha};
    end.maxAlpha = alpha;
    end.eta = eta;
    end.scales = &ScalesOf(model);
    return end;
}

struct FacetCase {
    float alphaA, alphaB, alphaBetween, kappa, eta;
    MicrofacetModel model = kGGX;
};
constexpr FacetCase kFacetCases[] = {{0.1f, 0.1f, 0.1f, -1, 1.5f},   {0.3f, 0.3f, 0.05f, -1, 1.5f},
                                     {0.05f, 0.05f, 0.5f, -1, 2},    {0.2f, 0.1f, 0.3f, 1.2f, 1.5f},
                                     {0.1f, 0.1f, 0.2f, -1, 0.8f},   {0.2f, 0.2f, 0.2f, -1, 1.5f, kBeckmann},
                                     {0.02f, 0.3f, 0.1f, 0.8f, 1.3f}};

JoiningFacets FacetsBetween(const FacetCase& row) {
    const float variance = 0.5f * Sqr(row.alphaBetween);
    return {row.kappa, {variance, 0, variance}, &ScalesOf(row.model)};
}

/// Mean of g/pdf over draws, g being a known density: 1 if draws follow a density that integrates to 1.
/// g is a Gaussian around the mean of some draws and narrower than they are: so quotients stay bounded.
template <class Facets>
RunningMean MeanQuotient(const Facets& facets, Rng& rng, float pdfScale) {
    RunningMean x, y;
    for (int i = 0; i < 2000; ++i) {
        const Slope m = facets.Sample(rng);
        x.Add(double(std::clamp(m.x, -1.f, 1.f)));
        y.Add(double(std::clamp(m.y, -1.f, 1.f)));
    }
    const double overVarianceX = 3 / x.Variance(), overVarianceY = 3 / y.Variance();
    RunningMean quotients;
    for (int i = 0; i < Scaled(40000); ++i) {
        const Slope m = facets.Sample(rng);
        const double dx = double(m.x) - x.Mean(), dy = double(m.y) - y.Mean();
        const double g = std::sqrt(overVarianceX * overVarianceY) / (2 * double(Pi)) *
                         std::exp(-0.5 * (dx * dx * overVarianceX + dy * dy * overVarianceY));
        quotients.Add(g / double(pdfScale * facets.Pdf(m)));
    }
    return quotients;
}

/// Both facets of one case, between directions in the lobe.
std::pair<Outcome, Outcome> FacetOutcomes(const FacetCase& row, uint64_t seed, float pdfScale) {
    Rng rng(seed);
    const EndModel a(MakePathEnd({0.5f, 0.1f, 0.8f}, row.alphaA, row.eta, row.model));
    const EndModel b(MakePathEnd(row.kappa < 0 ? Vec3(-0.4f, 0.1f, 0.8f) : Vec3(0.4f, 0.1f, 0.8f), row.alphaB,
                                 row.eta, row.model));
    const FirstFacet first(a, b, FacetsBetween(row));
    const SecondFacet second(b, Normalize(a.inner), FacetsBetween(row));
    EXPECT_TRUE(first.IsUsable() && second.IsUsable());
    return {ZTest(MeanQuotient(first, rng, pdfScale), 1, 1e-4, "first facet"),
            ZTest(MeanQuotient(second, rng, pdfScale), 1, 1e-4, "second facet")};
}

// Power: standard errors are 0.3 to 1 %.
TEST(SlopeMixtures, DrawsFollowTheDensities) {
    constexpr int kTests = 2 * int(std::size(kFacetCases));
    for (size_t i = 0; i < std::size(kFacetCases); ++i) {
        const std::string name = FullTestName() + std::to_string(i);
        EXPECT_TRUE(Passes(name + "first", SidakAlpha(kFamily, kTests),
                           [&](uint64_t seed) { return FacetOutcomes(kFacetCases[i], seed, 1).first; }));
        EXPECT_TRUE(Passes(name + "second", SidakAlpha(kFamily, kTests),
                           [&](uint64_t seed) { return FacetOutcomes(kFacetCases[i], seed, 1).second; }));
    }
}

TEST(SlopeMixtures, NegativeControlWeightsThatDoNotSumToOneAreFound) {
    const float scale = Scaled(8) == 8 ? 1.06f : 1.2f;
    const auto [first, second] = FacetOutcomes(kFacetCases[0], SeedOf(FullTestName()), scale);
    EXPECT_LT(first.pValue, 1e-4) << first.details;
    EXPECT_LT(second.pValue, 1e-4) << second.details;
}

// ---- Estimates ----------------------------------------------------------------------------------------

std::vector<PathCase> Cases() {
    const Layer sheet = Dielectric(0.2f, 1 / 1.5f);
    return {
        {"coat", {Dielectric(0.1f, 1.5f), Metal(0.1f)}},
        {"smooth", {Dielectric(0.02f, 1.5f), Metal(0.02f)}, false, false, kImportance},
        {"smooth_over_rough", {Dielectric(0.05f, 1.5f), Metal(0.5f)}},
        {"rough_over_smooth", {Dielectric(0.3f, 1.5f), Metal(0.02f)}, false, false, kImportance},
        {"rough", {Dielectric(0.5f, 1.5f), Metal(0.5f)}},
        {"index_2", {Dielectric(0.2f, 2.f), Metal(0.2f)}, false, false, kImportance},
        {"index_1.25", {Dielectric(0.3f, 1.25f), Metal(0.1f)}},
        {"smaller_index", {Dielectric(0.1f, 0.8f), Metal(0.2f)}, false, false, kImportance},
        {"absorber", {Dielectric(0.2f, 1.4f), Absorber(Lanes(0.2f, 0.5f, 1, 2)), Metal(0.2f)}},
        {"beckmann", {Dielectric(0.2f, 1.5f, kBeckmann), Metal(0.1f, kBeckmann)}},
        {"mixed", {Dielectric(0.3f, 1.5f), Metal(0.1f, kBeckmann)}, false, false, kImportance},
        {"sheet", {Dielectric(0.1f, 1.5f), sheet}, true},
        {"smooth_sheet", {Dielectric(0.02f, 1.5f), Dielectric(0.05f, 1 / 1.5f)}, true, false, kImportance},
        {"rough_sheet", {Dielectric(0.5f, 1.5f), Dielectric(0.3f, 1 / 1.5f)}, true},
        {"sheet_from_below", {Dielectric(0.1f, 1.5f), sheet}, true, true, kImportance},
        {"sheet_reflects", {Dielectric(0.1f, 1.5f), sheet}},
        {"sheet_reflects_below", {Dielectric(0.1f, 1.5f), Absorber(0.5f), sheet}, false, true, kImportance},
        {"gap", {Dielectric(0.1f, 0.7f), Dielectric(0.2f, 1.4f)}, true},
        {"three", {Dielectric(0.1f, 1.5f), Dielectric(0.2f, 1.2f), sheet}, true, false, kImportance},
        {"brushed", {Dielectric(0.1f, 1.5f), Rotated(40, Metal(Alphas(0.3f, 0.05f)))}},
        {"brushed_coat",
         {Rotated(-30, Dielectric(Alphas(0.05f, 0.2f), 1.5f)), Rotated(20, Metal(Alphas(0.1f, 0.3f)))},
         false,
         false,
         kImportance},
        {"perturbed_coat", {Tilted({0.3f, -0.1f, 1}, Dielectric(0.2f, 1.5f)), Metal(0.1f)}},
        {"perturbed_brushed",
         {Tilted({-0.2f, 0.2f, 1}, Dielectric(0.1f, 1.5f)),
          Turned({0.3f, 0.2f, 1}, 40, Metal(Alphas(0.2f, 0.05f)))},
         false,
         false,
         kImportance},
        {"perturbed_sheet_from_below",
         {Turned({0.2f, 0.3f, 1}, 30, Dielectric(Alphas(0.2f, 0.1f), 1.5f)),
          Tilted({-0.3f, 0, 1}, Dielectric(0.1f, 1 / 1.5f))},
         true,
         true},
        {"perturbed_three",
         {Tilted({0.2f, 0, 1}, Dielectric(0.1f, 1.5f)),
          Turned({0, -0.3f, 1}, 20, Dielectric(Alphas(0.2f, 0.1f), 1.2f)), Tilted({-0.1f, 0.2f, 1}, sheet)},
         true,
         false,
         kImportance},
        {"perturbed_mixed", {Tilted({0.25f, 0.2f, 1}, Dielectric(0.3f, 1.5f)), Metal(0.1f, kBeckmann)}},
        {"three_below", {Dielectric(0.05f, 1.5f), Absorber(1), Dielectric(0.1f, 0.9f), sheet}, true, true},
    };
}

int NumSamples() { return Scaled(60000); }

SampledSpectrum Estimate(const InterfacePath& path, const BxDFContext& context) {
    return EstimateByScaleMixture(path, context);
}

// Power: the differences have standard errors of 0.1 to 1 % (recorded; 2 % for rough_over_smooth), most of it
// from the walks; five of them are found.
TEST(ScaleMixture, IsRightOnAverage) {
    const auto rows = Cases();
    for (const PathCase& row : rows) {
        double error = 0;
        EXPECT_TRUE(
            Passes(FullTestName() + row.name, SidakAlpha(kFamily, int(rows.size())), [&](uint64_t seed) {
                const PathBias bias = JudgeByWalks(row, Estimate, NumSamples(), seed);
                error = bias.RelativeError();
                return BiasOutcome(row, bias);
            }));
        RecordProperty(row.name, std::to_string(100 * error) + " %");
    }
}

TEST(ScaleMixture, NegativeControlForgottenWalksAreFound) {
    const auto forgetful = [](const InterfacePath& path, const BxDFContext& context) {
        return EstimateByScaleMixture(path, context, false);
    };
    for (const size_t i : {size_t(0), size_t(11)}) {
        const PathCase row = Cases()[i];
        const PathBias bias = CompareWithWalks(row, forgetful, 4 * NumSamples(), SeedOf(FullTestName()));
        EXPECT_LT(BiasOutcome(row, bias).pValue, 1e-4)
            << row.name << ' ' << bias.Relative() << " +- " << bias.RelativeError();
    }
}

TEST(ScaleMixture, IsLessNoisyThanWalks) {
    for (const size_t i : {size_t(0), size_t(11)}) {
        Arena arena;
        const PathCase row = Cases()[i];
        const Stack stack = row.Build(arena);
        Rng rng(SeedOf(FullTestName()));
        const BxDFContext context{row.mode, Lobes::BothSides, &rng, false};
        RunningMean gain;
        for (const auto& [wo, wi] : PairsOf(row, stack, 32, rng)) {
            InterfacePath path;
            ASSERT_TRUE(FindShortestPath(stack, wo, wi, 3, &path));
            RunningMean walks, facets;
            for (int k = 0; k < 2000; ++k) {
                ConnectionWalk<WalkPolicy> walk(stack, context, path.numEvents);
                walks.Add(double(walk.Estimate(wo, wi).Average()));
                facets.Add(double(Estimate(path, context).Average()));
            }
            // Independent directions may be joined by no walk at all.
            if (walks.Mean() > 0) gain.Add(0.5 * std::log(walks.Variance() / facets.Variance()));
        }
        EXPECT_GT(std::exp(gain.Mean()), 1.5) << row.name;
    }
}

TEST(ScaleMixture, IsWorthwhileOverSmootherBases) {
    Arena arena;
    const Vec3 wo = Normalize(Vec3(0.1f, 0, 1)), wi = Normalize(Vec3(-0.2f, 0.1f, 1));
    InterfacePath path;
    const auto find = [&](const std::vector<Layer>& layers) {
        const Stack stack = PathCase{"", layers}.Build(arena);
        return FindShortestPath(stack, wo, wi, 3, &path);
    };
    ASSERT_TRUE(find({Dielectric(0.1f, 1.5f), Metal(0.1f)}));
    EXPECT_TRUE(ScaleMixtureIsWorthwhile(path));
    ASSERT_TRUE(find({Dielectric(0.1f, 1.5f), Metal(0.8f)}));
    EXPECT_FALSE(ScaleMixtureIsWorthwhile(path));
    ASSERT_TRUE(find({Dielectric(0.1f, 1.5f), Turned({0.3f, 0, 1}, 30, Metal(Alphas(0.1f, 0.2f)))}));
    EXPECT_TRUE(ScaleMixtureIsWorthwhile(path));
}

// Alphas from a thousandth to 3, all indices, grazing directions from all sides.
TEST(ScaleMixture, StaysFiniteEverywhere) {
    Rng rng(SeedOf(FullTestName()));
    const auto alpha = [&] { return 1e-3f * std::pow(3000.f, rng.Uniform()); };
    const auto eta = [&] { return 0.4f * std::pow(6.f, rng.Uniform()); };
    int numPositive = 0;
    for (int i = 0; i < Scaled(4000); ++i) {
        Arena arena;
        PathCase row;
        // A third of the normals lean by up to 45 degrees; alphas along and across are within a factor of
        // 100.
        const auto boundary = [&](MicrofacetModel model) {
            const float lean = std::max(0.f, 3 * rng.Uniform() - 2), azimuth = 2 * Pi * rng.Uniform(),
                        a = alpha(), b = i % 2 ? a : std::clamp(alpha(), 0.01f * a, 100 * a);
            return Turned({lean * std::cos(azimuth), lean * std::sin(azimuth), 1}, 360 * rng.Uniform(),
                          Dielectric(Alphas(a, b), eta(), model));
        };
        row.layers = {boundary(i % 3 ? kGGX : kBeckmann), boundary(kGGX)};
        if (i % 4 == 0) row.layers.push_back(boundary(kGGX));
        const Stack stack = row.Build(arena);
        Vec3 wo = SampleCosineHemisphere(rng.Uniform2D()), wi = SampleCosineHemisphere(rng.Uniform2D());
        if (i % 5 == 0) wo = Normalize(Vec3(wo.x, wo.y, 1e-3f * wo.z));
        if (i % 7 == 0) wi = {0, 0, 1};
        if (i % 11 == 0) wi = Normalize(Vec3(wi.x, wi.y, 1e-6f));
        if (i % 2) wo = -wo;
        if (i % 8 < 4) wi = -wi;
        InterfacePath path;
        if (wo.z == 0 || wi.z == 0 || !FindShortestPath(stack, wo, wi, 3, &path)) continue;
        for (int k = 0; k < 8; ++k) {
            const BxDFContext context{i % 2 ? kImportance : TransportMode::Radiance, Lobes::BothSides, &rng};
            const SampledSpectrum value = Estimate(path, context);
            ASSERT_TRUE(value.IsValid()) << i;
            numPositive += bool(value);
        }
    }
    EXPECT_GT(numPositive, Scaled(4000));
}

}  // namespace
}  // namespace lacquer::layered::test::scale_mixture_test
