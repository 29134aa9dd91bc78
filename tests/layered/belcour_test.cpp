// The lobes of [Belcour 2018]: what they know exactly, how far they are off elsewhere, and their sampling.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "layered/agreement.h"
#include "layered/lobes/belcour_lobes.h"
#include "layered/lobes/layer_operators.h"
#include "layered/lobes/lobe_sampler.h"
#include "pbrt/core/sampling.h"
#include "support/statistics.h"

namespace lacquer::layered::test::belcour_test {

namespace {

Vec3 At(float deg) { return SphericalDirection(std::sin(Radians(deg)), std::cos(Radians(deg)), 0.3f); }

StackCase Row(const char* name, std::vector<Layer> layers) {
    StackCase row;
    row.name = name;
    row.layers = std::move(layers);
    return row;
}

/// Albedo, and how far its light is from the mirror direction: the mean of d/(d + 0.2), d being the distance
/// in the surface's plane.
struct Shape {
    double albedo = 0, width = 0;
};
Shape ShapeOf(const StackCase& row, const char* estimator, const char* pdf, Vec3 wo, uint64_t seed) {
    Arena arena;
    const LayeredBxDF* bxdf =
        row.MakeBxDF(arena, {.estimator = FindEstimator(estimator), .pdf = FindPdf(pdf)});
    const int n = Scaled(20000);
    double sum = 0, widths = 0;
    VisitSamples(*bxdf, wo, TransportMode::Importance, Lobes::BothSides, n, seed,
                 [&](const std::optional<BxDFSample>& s) {
                     if (!s) return;
                     const double weight = double(s->weight.Average());
                     const double d = std::hypot(double(s->wi.x + wo.x), double(s->wi.y + wo.y));
                     sum += weight;
                     widths += weight * d / (d + 0.2);
                 });
    return {sum / n, widths / sum};
}

// ---- Operators ----------------------------------------------------------------------------------------

// What the header of the quadrature says, against draws of the BxDF (0.003 of noise).
TEST(BelcourLobes, FacetsReflectAndTransmitAsMuchAsTheirSamples) {
    for (const MicrofacetModel model : {kGGX, kBeckmann})
        for (const float alpha : {0.05f, 0.3f, 0.8f})
            for (const float eta : {1.5f, 1 / 1.5f})
                for (const float c : {0.1f, 0.3f, 0.6f, 1.f}) {
                    Arena arena;
                    StackBuilder builder(arena);
                    Dielectric(alpha, eta, model)(builder);
                    const Stack stack = builder.Build();
                    const InterfaceOperators found = OperatorsOf(stack.interfaces[0], true, c, 0, nullptr);
                    Rng rng(SeedOf(FullTestName()));
                    const BxDFContext context{TransportMode::Importance, Lobes::BothSides, &rng};
                    double reflected = 0, transmitted = 0;
                    const int n = Scaled(20000);
                    for (int i = 0; i < n; ++i)
                        if (const auto s = stack.interfaces[0].Sample({std::sqrt(1 - c * c), 0, c}, context))
                            (s->IsReflection() ? reflected : transmitted) += double(s->weight[0]) / n;
                    const double limit = (eta < 1 ? 0.2 : alpha <= 0.3f && c > 0.2f ? 0.025 : 0.06) + 0.01;
                    EXPECT_NEAR(double(found.reflected[0]), reflected, limit)
                        << alpha << " " << eta << " " << c;
                    EXPECT_NEAR(double(found.transmitted[0]), transmitted, limit)
                        << alpha << " " << eta << " " << c;
                }
}

TEST(BelcourLobes, SpreadAndAlphaAreInverse) {
    for (const MicrofacetModel model : {kGGX, kBeckmann})
        for (const float alpha : {1e-3f, 0.05f, 0.3f, 0.9f})
            EXPECT_NEAR(AlphaOf(model, SpreadOf(model, alpha)), alpha, 1e-5f);
}

// ---- Exact limits -------------------------------------------------------------------------------------

TEST(BelcourLobes, OneInterfaceIsExact) {
    Arena arena;
    const StackCase row = Row("glass", {Dielectric(0.3f, 1.5f)});
    const LayeredBxDF* lobes = row.MakeBxDF(arena, {.estimator = FindEstimator("belcour")});
    const LayeredBxDF* exact = row.MakeBxDF(arena, {.estimator = FindEstimator("bidirectional")});
    Rng rng(SeedOf(FullTestName()));
    BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
    context.needsPdf = false;
    for (int i = 0; i < 100; ++i) {
        const Vec3 wo = SampleCosineHemisphere(rng.Uniform2D());
        Vec3 wi = SampleCosineHemisphere(rng.Uniform2D());
        if (i % 2) wi = -wi;
        EXPECT_EQ(lobes->Evaluate(wo, wi, context).f[0], exact->Evaluate(wo, wi, context).f[0]);
    }
}

/// Light in each of the two specular directions, by Sample().
std::array<double, 2> SpecularEnergies(const StackCase& row, const char* estimator, Vec3 wo, uint64_t seed) {
    Arena arena;
    const LayeredBxDF* bxdf =
        row.MakeBxDF(arena, {.estimator = FindEstimator(estimator), .pdf = FindPdf("approximate")});
    std::array<double, 2> sums{};
    const int n = Scaled(40000);
    VisitSamples(*bxdf, wo, TransportMode::Importance, Lobes::BothSides, n, seed,
                 [&](const std::optional<BxDFSample>& s) {
                     if (s) sums[s->IsTransmission()] += double(s->weight[1]) / n;
                 });
    return sums;
}

// All reflections between smooth layers are in the adding-doubling. Power: 0.01 of the light.
TEST(BelcourLobes, SmoothStacksAreExact) {
    const float up = 1 / 1.5f;
    const StackCase rows[] = {
        Row("coated metal", {Dielectric(0, 1.5f), Metal(0)}),
        Row("pane", {Dielectric(0, 1.5f), Dielectric(0, up)}),
        Row("into water", {Dielectric(0, 1.5f), Absorber(0.3f), Dielectric(0, 1.33f * up)}),
        Row("three", {Dielectric(0, 1.5f), Absorber(0.2f), Dielectric(0, 1.4f), Mirror(0)})};
    for (const StackCase& row : rows)
        for (const float deg : {0.f, 40.f, 75.f}) {
            const auto walks = SpecularEnergies(row, "bidirectional", At(deg), SeedOf(row.name));
            const auto lobes = SpecularEnergies(row, "belcour", At(deg), Hash(SeedOf(row.name)));
            EXPECT_NEAR(lobes[0], walks[0], 0.012) << row.name << " " << deg;
            EXPECT_NEAR(lobes[1], walks[1], 0.012) << row.name << " " << deg;
        }
}

TEST(BelcourLobes, AlmostSmoothStacksHaveTheEnergyOfSmoothOnes) {
    for (const float deg : {0.f, 40.f, 60.f}) {
        const Shape smooth =
            ShapeOf(Row("", {Dielectric(0, 1.5f), Metal(0)}), "belcour", "belcour", At(deg), 1);
        const Shape rough =
            ShapeOf(Row("", {Dielectric(3e-3f, 1.5f), Metal(3e-3f)}), "belcour", "belcour", At(deg), 2);
        EXPECT_NEAR(rough.albedo, smooth.albedo, 0.02) << deg;
        EXPECT_LT(rough.width, 0.15) << deg;
    }
}

// ---- Errors -------------------------------------------------------------------------------------------

// The normalisation of wide lobes is 0.05 too high: in two of a hundred stacks that shows. The lobes do not
// know perturbed normals, but the first interface does: at grazing angles both together reflect too much.
TEST(BelcourLobesLong, NoStackGivesMuchMoreThanItGets) {
    for (const StackCase& row : StackCases()) {
        Arena arena;
        const Stack stack = row.Build(arena);
        const bool isPerturbed = !std::all_of(stack.interfaces.begin(), stack.interfaces.end(),
                                              [](const auto& i) { return i.HasUnperturbedNormal(); });
        for (const float deg : {5.f, 50.f, 80.f})
            EXPECT_LT(ShapeOf(row, "belcour", "belcour", At(deg), SeedOf(row.name)).albedo,
                      isPerturbed ? 1.25 : 1.06)
                << row.name << " " << deg;
    }
}

struct Error {
    StackCase row;
    double albedo, width;  ///< largest differences at 10 and 45 degrees
};
/// What docs/layered.md says of the model.
std::vector<Error> KnownErrors() {
    return {
        {Row("beckmann_005_005", {Dielectric(0.05f, 1.5f, kBeckmann), Metal(0.05f, kBeckmann)}), 0.02, 0.02},
        {Row("beckmann_030_010", {Dielectric(0.3f, 1.5f, kBeckmann), Metal(0.1f, kBeckmann)}), 0.07, 0.08},
        {Row("beckmann_010_030", {Dielectric(0.1f, 1.5f, kBeckmann), Metal(0.3f, kBeckmann)}), 0.08, 0.06},
        {Row("ggx_030_010", {Dielectric(0.3f, 1.5f), Metal(0.1f)}), 0.09, 0.1},
        {Row("ggx_010_030", {Dielectric(0.1f, 1.5f), Metal(0.3f)}), 0.12, 0.06},
        {Row("absorber", {Dielectric(0.1f, 1.5f), Absorber(1), Metal(0.1f)}), 0.02, 0.04},
        {Row("thin_forward", {Dielectric(0.1f, 1.5f), Medium(0.3f, 0.9f, HG(0.9f)), Metal(0.1f)}), 0.03,
         0.05},
        {Row("diffuse", {Dielectric(0.3f, 1.5f), Diffuse(0.5f)}), 0.04, 0.03},
        {Row("pane", {Dielectric(0.1f, 1.5f, kBeckmann), Dielectric(0.1f, 1 / 1.5f, kBeckmann)}), 0.02,
         0.03}};
}

double WorstExcess(const std::vector<Error>& errors, const char* estimator) {
    double worst = -1;
    for (const Error& e : errors)
        for (const float deg : {10.f, 45.f}) {
            const uint64_t seed = SeedOf(e.row.name);
            const Shape truth = ShapeOf(e.row, "bidirectional", "approximate", At(deg), seed);
            const Shape lobes = ShapeOf(e.row, estimator, "belcour", At(deg), Hash(seed));
            worst = std::max({worst, std::abs(lobes.albedo - truth.albedo) - e.albedo,
                              std::abs(lobes.width - truth.width) - e.width});
        }
    return worst;
}

// The truth is that of the walk, at 0.005 of noise.
TEST(BelcourLobes, ErrorsAreThoseThatTheDocumentsState) {
    EXPECT_LT(WorstExcess(KnownErrors(), "belcour"), 0.01);
}

// Backscattering is not in the model: the limits for thin slabs do not hold in thick ones.
TEST(BelcourLobesControls, AThickCloudIsNotFoundToAgree) {
    const std::vector<Error> cloud = {
        {Row("cloud", {Dielectric(0.1f, 1.5f), Medium(5, 0.9f, Isotropic()), Diffuse(0.5f)}), 0.12, 0.1}};
    EXPECT_GT(WorstExcess(cloud, "belcour"), 0.05);
}

// ---- Pdf "auto" -------------------------------------------------------------------------------------------

// The rule of docs/layered.md: dark and opaque stacks are drawn by lobes.
TEST(AutoPdf, DarkOpaqueStacksPreferLobes) {
    const auto prefers = [](std::vector<Layer> layers) {
        Arena arena;
        return FindPdf("auto")->PrefersLobes(Row("", std::move(layers)).Build(arena));
    };
    const Layer coat = Dielectric(0.1f, 1.5f), metal = Metal(0.1f), up = Dielectric(0.1f, 1 / 1.5f);
    EXPECT_FALSE(prefers({coat, metal}));
    EXPECT_FALSE(prefers({coat, Absorber(0.3f), metal}));
    EXPECT_TRUE(prefers({coat, Absorber(0.7f), metal}));
    EXPECT_TRUE(prefers({coat, Absorber(Lanes(2, 0.6f, 0.2f, 2)), metal}));
    EXPECT_FALSE(prefers({coat, Absorber(2), up}));
    EXPECT_TRUE(prefers({coat, Medium(5, 0.3f, Isotropic()), metal}));
    EXPECT_FALSE(prefers({coat, Medium(5, 0.98f, Isotropic()), metal}));
    EXPECT_FALSE(prefers({coat, Medium(1, 1, HG(0.5f)), metal}));
    EXPECT_TRUE(prefers({coat, Medium(1, 0.7f, HG(0.5f)), Diffuse(0.4f)}));
}

/// Mean of the squared weights of draws over the square of their mean.
double SecondMomentOfWeights(const StackCase& row, const char* pdf, Vec3 wo) {
    Arena arena;
    const LayeredBxDF* bxdf = row.MakeBxDF(arena, {.estimator = FindEstimator("auto"), .pdf = FindPdf(pdf)});
    Rng rng(SeedOf(FullTestName()));
    double sum = 0, squares = 0;
    const int n = Scaled(20000);
    for (int i = 0; i < n; ++i) {
        const BxDFRandom u{rng.Uniform(), rng.Uniform2D()};
        const auto s = bxdf->Sample(wo, u, {TransportMode::Radiance, Lobes::BothSides, &rng});
        const double weight = s ? double(s->weight[0]) : 0;
        sum += weight;
        squares += Sqr(weight);
    }
    return squares * n / Sqr(sum);
}

// Measured: 17.4 and 10.3 by walks (smooth), 17.8 and 10.9 (rough); 1.05 to 1.12 by lobes.
TEST(AutoPdf, DarkStacksAreDrawnByEnergy) {
    for (const float alpha : {0.f, 0.1f}) {
        const StackCase row = Row(
            "dark", {Dielectric(alpha, 1.5f), Absorber(1), Dielectric(0.1f, 1.2f), Absorber(1), Metal(0.2f)});
        for (const float deg : {0.f, 60.f}) {
            EXPECT_LT(SecondMomentOfWeights(row, "auto", At(deg)), 1.4) << alpha << " " << deg;
            EXPECT_GT(SecondMomentOfWeights(row, "gaussian", At(deg)), 6) << alpha << " " << deg;
        }
    }
}

// ---- Sampling -----------------------------------------------------------------------------------------

constexpr int kRows = 5, kColumns = 4;

/// Rows of equal projected area on either side, columns of half the azimuth.
size_t BinOf(Vec3 w) {
    const int row = std::min(kRows - 1, int(float(kRows) * w.z * w.z));
    const int column = std::min(kColumns - 1, int(std::abs(std::atan2(w.y, w.x)) * InvPi * kColumns));
    return size_t((w.z > 0 ? 0 : kRows * kColumns) + row * kColumns + column);
}

/// Draws against the integral of the density of another wo. Power: 4 % in one bin of twenty.
Outcome CompareSamples(const StackCase& row, Vec3 drawn, Vec3 asked, uint64_t seed) {
    Arena arena;
    const Stack stack = row.Build(arena);
    Rng rng(seed);
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
    const LobeSampler sampler(stack, drawn, context, false), density(stack, asked, context, false);
    std::vector<double> observed(2 * kRows * kColumns), expected(2 * kRows * kColumns);
    const int n = Scaled(40000);
    for (int i = 0; i < n; ++i) {
        const auto s = sampler.Sample({rng.Uniform(), rng.Uniform2D()});
        if (s && !s->isSpecular) observed[BinOf(s->wi)] += 1;
    }
    constexpr int kFine = 240;
    for (const float side : {1.f, -1.f})
        for (int a = 0; a < kFine; ++a)
            for (int b = 0; b < 2 * kFine; ++b) {
                const float c2 = (float(a) + 0.5f) / kFine, phi = ((float(b) + 0.5f) / kFine - 1) * Pi;
                Vec3 wi = SphericalDirection(std::sqrt(1 - c2), std::sqrt(c2), phi);
                // dw = d(c^2) dphi / 2c
                const float area = Pi / (2 * wi.z) / Sqr(float(kFine));
                wi.z *= side;
                expected[BinOf(wi)] += n * double(density.Pdf(wi) * area);
            }
    return ChiSquareTest(observed, expected);
}

// A smooth coat reflects about its own normal, whoever draws: with the density belcour walks take over, and
// the estimator's own lobes go where the coat does.
TEST(BelcourLobes, PerturbedSmoothCoatsReflectAboutTheirNormal) {
    const Vec3 normal = Normalize(Vec3(0.3f, 0, 1)), wo = At(45);
    const Vec3 mirror = 2 * Dot(wo, normal) * normal - wo;
    const StackCase row = Row("", {Tilted(normal, Dielectric(0, 1.5f)), Absorber(2), Metal(0.1f)});
    const std::pair<const char*, const char*> makers[] = {
        {"bidirectional", "belcour"}, {"bidirectional", "auto"}, {"belcour", "belcour"}};
    for (const auto& maker : makers) {
        const char *const estimator = maker.first, *const pdf = maker.second;  // lambdas capture no bindings
        Arena arena;
        const LayeredBxDF* bxdf =
            row.MakeBxDF(arena, {.estimator = FindEstimator(estimator), .pdf = FindPdf(pdf)});
        int numSpecular = 0;
        VisitSamples(*bxdf, wo, TransportMode::Radiance, Lobes::BothSides, 2000, SeedOf(FullTestName()),
                     [&](const std::optional<BxDFSample>& s) {
                         if (!s || !s->IsSpecular()) return;
                         ++numSpecular;
                         EXPECT_LT(Length(s->wi - mirror), 1e-4f) << estimator << " " << pdf;
                     });
        EXPECT_GT(numSpecular, 50) << estimator << " " << pdf;
    }
}

// What lobes do not know is not left to them: their floor finds it in rare draws of large weights.
TEST(AutoPdf, TakesLobesWhereTheyFit) {
    const auto prefers = [](std::vector<Layer> layers) {
        Arena arena;
        return FindPdf("auto")->PrefersLobes(Row("", std::move(layers)).Build(arena));
    };
    const Layer coat = Dielectric(0.1f, 1.5f), dark = Absorber(2);
    EXPECT_TRUE(prefers({coat, dark, Metal(0.1f)}));
    EXPECT_TRUE(prefers({Dielectric(0, 1.5f), dark, Metal(0.1f)}));
    EXPECT_TRUE(prefers({coat, Medium(5, 0.3f, HG(0.5f)), Metal(0.1f)}));
    EXPECT_FALSE(prefers({coat, Metal(0.1f)}));  // bright
    EXPECT_FALSE(prefers({coat, dark, Tilted({0.3f, 0, 1}, Metal(0.1f))}));
    EXPECT_FALSE(prefers({Dielectric(0.05f, 1.5f), dark, Metal(Alphas(0.02f, 0.4f))}));
    EXPECT_FALSE(prefers({coat, dark, RescatteringMetal(Alphas(0.1f, 0.1f))}));
    EXPECT_FALSE(prefers({coat, Medium(5, 0.3f, HG(-0.9f)), Metal(0.1f)}));
    EXPECT_FALSE(prefers({coat, Medium(5, 0.3f, SggxSheets({0, 0, 1}, 0.2f)), Metal(0.1f)}));
    EXPECT_FALSE(prefers({coat, dark, coat, dark, coat, dark, coat, dark, Metal(0.1f)}));
}

std::vector<StackCase> SampledStacks() {
    const float up = 1 / 1.5f;
    return {Row("beckmann", {Dielectric(0.3f, 1.5f, kBeckmann), Metal(0.2f, kBeckmann)}),
            Row("ggx", {Dielectric(0.2f, 1.5f), Absorber(0.5f), Metal(0.3f)}),
            Row("smooth coat", {Dielectric(0, 1.5f), Metal(0.3f)}),
            Row("pane", {Dielectric(0.3f, 1.5f), Dielectric(0.2f, up)}),
            Row("into water", {Dielectric(0.3f, 1.5f), Dielectric(0.2f, 1.33f * up)}),
            Row("medium", {Dielectric(0.2f, 1.5f), Medium(1, 0.8f, HG(0.5f)), Dielectric(0.3f, up)}),
            Row("diffuse base", {Dielectric(0.3f, 1.5f), Diffuse(0.5f)})};
}

TEST(BelcourLobes, SamplesFollowTheDensity) {
    for (const StackCase& row : SampledStacks())
        for (const float deg : {20.f, 65.f})
            for (const float side : {1.f, -1.f}) {
                const Vec3 wo = At(deg) * side;
                Arena arena;
                if (side < 0 && !Transmits(row.Build(arena))) continue;
                EXPECT_TRUE(Passes(FullTestName() + row.name, 1e-6,
                                   [&](uint64_t seed) {
                                       return CompareSamples(row, wo, wo, Hash(seed, int(deg), int(side)));
                                   }))
                    << row.name << " " << deg << " " << side;
            }
}

TEST(BelcourLobesControls, TheDensityOfADirectionSixDegreesOffIsFound) {
    for (const StackCase& row : SampledStacks()) {
        if (row.name == "diffuse base") continue;
        EXPECT_LT(CompareSamples(row, At(40), At(46), SeedOf(row.name)).pValue, 1e-6) << row.name;
    }
}

}  // namespace
}  // namespace lacquer::layered::test::belcour_test
