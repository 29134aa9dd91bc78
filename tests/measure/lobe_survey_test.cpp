// Measured numbers of materials against closed forms, and against surfaces that are wrong on purpose.
#include "measure/lobe_survey.h"

#include <gtest/gtest.h>

#include "measure/lobe_images.h"
#include "measure/measure_fixtures.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"
#include "pbrt/scattering/fresnel.h"
#include "support/statistics.h"

namespace lacquer::measure::lobe_survey_test {
namespace {

using test::DirectionAt;
using test::FromText;

constexpr const char* kRoughGlass =
    R"(MakeNamedMaterial "m" "string type" "dielectric" "float roughness" .4 "bool remaproughness" false)";
constexpr const char* kRoughCopper =
    R"(MakeNamedMaterial "m" "string type" "conductor" "float roughness" .2 "bool remaproughness" false)";

std::string Diffuse(const std::string& reflectance) {
    return R"(MakeNamedMaterial "m" "string type" "diffuse" "rgb reflectance" [)" + reflectance + "]";
}

// ---- BsdfSubject ----

TEST(BsdfSubject, WhiteIsWhite) {
    const SceneMaterial white = FromText(Diffuse("1 1 1"), "m");
    const SampledLobe lobe = SampleLobe({*white.bsdf, DirectionAt(30, 0), TransportMode::Importance, 1}, 64);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(lobe.reflected.Mean()[c], 1, 1e-5) << c;
}

TEST(BsdfSubject, ColoursComeBackAsTheyWereGiven) {
    // 64 wavelengths integrate the smooth spectrum of an RGB colour to about 1e-3.
    const SceneMaterial colored = FromText(Diffuse(".2 .5 .8"), "m");
    const SampledLobe lobe =
        SampleLobe({*colored.bsdf, DirectionAt(30, 0), TransportMode::Importance, 1}, 64);
    const glm::dvec3 expected(0.2, 0.5, 0.8);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(lobe.reflected.Mean()[c], expected[c], 3e-3) << c;
    EXPECT_FALSE(colored.bsdf->IsStochastic());
    EXPECT_EQ(colored.bsdf->NumVariants(), 1);
}

TEST(BsdfSubject, AMixIsShownAsDrawsOfIt) {
    const SceneMaterial mix = FromText(R"(
        MakeNamedMaterial "black" "string type" "diffuse" "rgb reflectance" [0 0 0]
        MakeNamedMaterial "white" "string type" "diffuse" "rgb reflectance" [1 1 1]
        MakeNamedMaterial "m" "string type" "mix" "string materials" ["black" "white"] "float amount" .25)",
                                       "m");
    EXPECT_EQ(mix.bsdf->NumVariants(), 64);
    const SampledLobe lobe = SampleLobe({*mix.bsdf, DirectionAt(30, 0), TransportMode::Importance, 1}, 64);
    // 64 draws of probability 1/4: a standard deviation of 0.054; the draws are a hash, always the same.
    EXPECT_NEAR(lobe.reflected.Luminance(), 0.25, 4 * 0.054);
    EXPECT_GT(lobe.reflected.Luminance(), 0);
}

TEST(BsdfSubject, NothingToShowIsAnError) {
    EXPECT_THROW(FromText(R"(MakeNamedMaterial "m" "string type" "interface")", "m"), SceneError);
}

// ---- BuildMaterial ----

TEST(BuildMaterial, MakesOnlyWhatTheMaterialNeeds) {
    const std::string text = R"(
        MakeNamedMaterial "broken" "string type" "diffuse" "spectrum reflectance" "no-such-file.spd"
        MakeNamedMaterial "red" "string type" "diffuse" "rgb reflectance" [1 0 0]
        MakeNamedMaterial "blue" "string type" "diffuse" "rgb reflectance" [0 0 1]
        MakeNamedMaterial "m" "string type" "mix" "string materials" ["red" "blue"])";
    const SceneMaterial mix = FromText(text, "m");
    EXPECT_EQ(mix.setup.owned.size(), 3u);
    EXPECT_ANY_THROW(FromText(text, "broken"));
}

TEST(BuildMaterial, UnknownNameGetsTheNearestOne) {
    try {
        FromText("MakeNamedMaterial \"copper\" \"string type\" \"conductor\"", "coper");
        FAIL() << "no error";
    } catch (const SceneError& e) {
        EXPECT_EQ(
            e.Message(),
            "there is no material \"coper\" in the scene; did you mean \"copper\"? (the scene has copper)");
    }
}

TEST(BuildMaterial, FindsUnnamedMaterialsByTheirNumber) {
    const SceneMaterial second =
        FromText("Material \"diffuse\" \"rgb reflectance\" [.1 .1 .1]\nMaterial \"conductor\"", "@2");
    EXPECT_EQ(second.setup.entity.type, "conductor");
}

// ---- DirectionGuide ----

TEST(DirectionGuide, DensityIntegratesToOneOverBothDisks) {
    Rng rng(::lacquer::test::SeedOf(::lacquer::test::FullTestName()));
    std::vector<Vec3> directions;
    for (int i = 0; i < 20000; ++i) {
        const Vec3 narrow = Normalize(Vec3(0.3f, 0.2f, 0.9f) + 0.01f * SampleUniformSphere(rng.Uniform2D()));
        directions.push_back(i % 3 ? narrow : -SampleCosineHemisphere(rng.Uniform2D()));
    }
    const DirectionGuide guide(directions, true, true);
    // The density is constant on cells of the square down to 2^-16: a grid of 1024 sees cells down to 2^-10,
    // which narrower lobes than this one would pass.
    constexpr int kSide = 1024;
    double sum = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const Point2 d =
                SampleUniformDiskConcentric({(float(x) + 0.5f) / kSide, (float(y) + 0.5f) / kSide});
            const float z = std::sqrt(std::max(1e-12f, 1 - d.x * d.x - d.y * d.y));
            sum += guide.DiskDensity({d.x, d.y, z}) + guide.DiskDensity({d.x, d.y, -z});
        }
    EXPECT_NEAR(sum / kSide / kSide, 1, 1e-3);
}

TEST(DirectionGuide, DrawsHaveTheDensityTheySay) {
    Rng rng(::lacquer::test::SeedOf(::lacquer::test::FullTestName()));
    std::vector<Vec3> directions;
    for (int i = 0; i < 5000; ++i) directions.push_back(SampleUniformHemisphere(rng.Uniform2D()));
    const DirectionGuide guide(directions, true, false);
    for (int i = 0; i < 1000; ++i) {
        const auto draw = guide.Sample({rng.Uniform(), rng.Uniform(), rng.Uniform(), rng.Uniform()});
        EXPECT_GT(draw.w.z, 0);
        EXPECT_NEAR(draw.diskDensity, guide.DiskDensity(draw.w), 0.35 * draw.diskDensity);  // at cell edges
    }
}

TEST(DirectionGuide, EvenAMisleadingGuideGivesUnbiasedIntegrals) {
    // Learnt from a narrow lobe, used for a constant one: the reflectance comes out all the same.
    const SceneMaterial gray = FromText(Diffuse(".5 .5 .5"), "m");
    const std::vector<Vec3> elsewhere(5000, DirectionAt(60, 10));
    const LobeQuery query{*gray.bsdf, DirectionAt(20, 0), TransportMode::Importance,
                          ::lacquer::test::SeedOf(::lacquer::test::FullTestName())};
    const LobeEnergy energy = IntegrateLobe(query, DirectionGuide(elsewhere, true, false), 1, 1 << 14);
    EXPECT_NEAR(energy.reflected.Luminance(), 0.5, 5 * energy.reflected.LuminanceError() + 2e-3);
    EXPECT_LT(energy.reflected.LuminanceError(), 0.02);
}

// ---- Energies ----

TEST(SampleLobe, SmoothGlassHasThePeaksOfFresnel) {
    const SceneMaterial glass =
        FromText(R"(MakeNamedMaterial "m" "string type" "dielectric" "float eta" 1.5)", "m");
    const Vec3 w = DirectionAt(50, 30);
    const SampledLobe lobe = SampleLobe(
        {*glass.bsdf, w, TransportMode::Importance, ::lacquer::test::SeedOf(::lacquer::test::FullTestName())},
        1 << 13);
    const double F = double(FresnelDielectric(w.z, 1.5f));
    ASSERT_EQ(lobe.peaks.size(), 2u);
    // Probabilities F and 1 - F with weight 1: binomial errors, 5 of them.
    const double error = std::sqrt(F * (1 - F) / double(1 << 16));
    EXPECT_NEAR(Luminance(lobe.peaks[1].energy), F, 8 * error);
    EXPECT_NEAR(Luminance(lobe.peaks[0].energy), 1 - F, 8 * error);
    EXPECT_NEAR(double(lobe.peaks[1].w.x), double(-w.x), 1e-5);
    EXPECT_NEAR(lobe.eta, 1.5, 1e-6);
    EXPECT_EQ(lobe.smoothReflected.Luminance(), 0);
    EXPECT_TRUE(lobe.directions.empty());
}

TEST(SampleLobe, WhiteFurnaceOfSmoothGlassIsOneFromBothSides) {
    const SceneMaterial glass =
        FromText(R"(MakeNamedMaterial "m" "string type" "dielectric" "float eta" 1.5)", "m");
    for (const float thetaDeg : {30.f, 150.f}) {
        const SampledLobe lobe =
            SampleLobe({*glass.bsdf, DirectionAt(thetaDeg, 0), TransportMode::Radiance, 1}, 512);
        EXPECT_NEAR(lobe.reflected.Luminance() + lobe.transmitted.Luminance(), 1, 1e-5) << thetaDeg;
    }
}

TEST(IntegrateLobe, AgreesWithSamplesInBothModes) {
    const SceneMaterial glass = FromText(kRoughGlass, "m");
    for (const TransportMode mode : {TransportMode::Importance, TransportMode::Radiance}) {
        const LobeQuery query{*glass.bsdf, DirectionAt(40, 20), mode,
                              ::lacquer::test::SeedOf(::lacquer::test::FullTestName())};
        const SampledLobe sampled = SampleLobe(query, 1 << 13);
        const LobeEnergy integrated = IntegrateLobe(query, LearnGuide(query, sampled), sampled.eta, 1 << 13);
        for (const auto& [a, b] : {std::pair(sampled.reflected, integrated.reflected),
                                   std::pair(sampled.transmitted, integrated.transmitted)})
            EXPECT_NEAR(a.Luminance(), b.Luminance(), 5 * std::hypot(a.LuminanceError(), b.LuminanceError()));
        // Errors this small see a quotient of indices squared that is forgotten (a factor of 1.8 to 2.25).
        EXPECT_LT(integrated.transmitted.LuminanceError(), 0.01 * integrated.transmitted.Luminance());
    }
}

TEST(MeasureReciprocity, RoughGlassIsReciprocalWithItsIndexAndNotWithoutIt) {
    const SceneMaterial glass = FromText(kRoughGlass, "m");
    const Vec3 w = DirectionAt(40, 0);
    const Reciprocity right = MeasureReciprocity(*glass.bsdf, w, 1.5, 200, 1, 1);
    EXPECT_LT(right.maxRelative, 1e-3);  // rounding of a density with a width of 0.4
    EXPECT_GT(right.numPairs, 50);
    EXPECT_GT(MeasureReciprocity(*glass.bsdf, w, 1, 200, 1, 1).maxRelative, 0.5);
    // From below it is the inverse.
    EXPECT_LT(MeasureReciprocity(*glass.bsdf, -w, 1 / 1.5, 200, 1, 1).maxRelative, 1e-3);
}

// ---- Images ----

LobeImage Brightened(LobeImage image, double factor) {
    for (auto& value : image.value) value *= factor;
    return image;
}

TEST(Compare, SeesNoiseOnlyWhereTheImagesAgree) {
    const SceneMaterial copper = FromText(kRoughCopper, "m");
    const LobeQuery query{*copper.bsdf, DirectionAt(40, 20), TransportMode::Importance,
                          ::lacquer::test::SeedOf(::lacquer::test::FullTestName())};
    DensityPair pdf, density;
    const LobePair evaluated = EvaluateImages(query, 64, 16, &pdf);
    const LobePair sampled = SampleImages(query, 64, 1 << 19, &density);
    const Difference same = Compare(evaluated.reflection, sampled.reflection);
    ASSERT_GT(same.numBlocks, 500);
    // The rms of n standard normal numbers is 1 within 1 / sqrt(2 n); 5 of these, and 4 % because pixels with
    // few samples are not normal.
    EXPECT_NEAR(same.rms, 1, 5 / std::sqrt(2.0 * same.numBlocks) + 0.04);
    // Negative control: an image that is 10 % too bright.
    EXPECT_GT(Compare(Brightened(evaluated.reflection, 1.1), sampled.reflection).rms, 1.3);
    // The same holds of the densities: their sums over blocks agree as well as counts can.
    double fromPdf = 0, fromSamples = 0;
    for (size_t i = 0; i < pdf.reflection.size(); ++i) {
        fromPdf += pdf.reflection[i];
        fromSamples += density.reflection[i];
    }
    EXPECT_NEAR(fromSamples / fromPdf, 1, 0.01);
}

TEST(EvaluateImages, OfALambertianSurfaceAreCosines) {
    const SceneMaterial gray = FromText(Diffuse(".5 .5 .5"), "m");
    const LobeQuery query{*gray.bsdf, DirectionAt(40, 20), TransportMode::Importance,
                          ::lacquer::test::SeedOf(::lacquer::test::FullTestName())};
    DensityPair density;
    const LobeImage evaluated = EvaluateImages(query, 16, 64, nullptr).reflection;
    const LobeImage sampled = SampleImages(query, 16, 1 << 20, &density).reflection;
    for (int y = 4; y < 12; ++y)
        for (int x = 4; x < 12; ++x) {
            const double px = (x + 0.5) / 8 - 1, py = 1 - (y + 0.5) / 8;
            const double cosine = std::sqrt(1 - px * px - py * py);
            const size_t i = size_t(y) * 16 + size_t(x);
            // The mean over a pixel differs from the value at its centre by less than 1 %.
            EXPECT_NEAR(evaluated.LuminanceAt(i), 0.5 * cosine / double(Pi), 0.01 * 0.5 / double(Pi));
            // About 5000 samples a pixel: 5 standard errors are 7 %.
            EXPECT_NEAR(sampled.LuminanceAt(i), 0.5 * cosine / double(Pi), 0.08 * 0.5 / double(Pi));
            EXPECT_NEAR(density.reflection[i], cosine / double(Pi), 0.08 / double(Pi));
        }
}

TEST(EvaluateImages, AreBlackOutsideAndFinite) {
    const SceneMaterial glass = FromText(kRoughGlass, "m");
    const LobeQuery query{*glass.bsdf, DirectionAt(50, 200), TransportMode::Importance, 3};
    const LobePair pair = EvaluateImages(query, 32, 16, nullptr);
    for (const LobeImage* lobe : {&pair.reflection, &pair.transmission}) {
        const Image image = ToImage(*lobe);
        EXPECT_FALSE(image.HasNonFinite());
        EXPECT_EQ(image.Get({0, 0}, 0), 0);
        EXPECT_EQ(image.Get({31, 31}, 1), 0);
        EXPECT_GT(image.Get({16, 16}, 1), 0);
    }
}

TEST(EvaluateImages, PutTheMirrorDirectionOppositeOfTheLight) {
    // x to the right, y upward: light from the upper right is reflected to the lower left.
    const SceneMaterial copper = FromText(kRoughCopper, "m");
    const LobeQuery query{*copper.bsdf, DirectionAt(40, 45), TransportMode::Importance, 3};
    const LobeImage image = EvaluateImages(query, 32, 16, nullptr).reflection;
    const double r = std::sin(40 * double(Pi) / 180) / std::sqrt(2.0);
    const int mirrorX = int((1 - r) * 16), mirrorY = int((1 + r) * 16);
    const size_t mirror = size_t(mirrorY) * 32 + size_t(mirrorX);
    const size_t opposite = size_t(31 - mirrorY) * 32 + size_t(31 - mirrorX);
    EXPECT_GT(image.LuminanceAt(mirror), 20 * image.LuminanceAt(opposite));
}

TEST(Survey, DoesNotDependOnThreads) {
    const SceneMaterial glass = FromText(kRoughGlass, "m");
    const LobeQuery query{*glass.bsdf, DirectionAt(40, 20), TransportMode::Importance, 9};
    const auto run = [&](int threads) {
        const ThreadLimit limit(threads);
        const SampledLobe sampled = SampleLobe(query, 1000);
        const LobeEnergy energy = IntegrateLobe(query, LearnGuide(query, sampled), sampled.eta, 1000);
        DensityPair density;
        const LobePair images = SampleImages(query, 16, 50000, &density);
        return std::tuple(sampled.reflected.Luminance(), energy.transmitted.Luminance(),
                          images.transmission.value[100].x, density.reflection[120]);
    };
    EXPECT_EQ(run(1), run(3));
}

}  // namespace
}  // namespace lacquer::measure::lobe_survey_test
