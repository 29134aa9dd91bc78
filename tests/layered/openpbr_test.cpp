// OpenPBR surfaces: their layers, mixtures and energy.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "measure/scene_material.h"
#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/rough_diffuse.h"
#include "pbrt/core/sampling.h"
#include "pbrt/scattering/fresnel.h"
#include "pbrt/scene/parser.h"
#include "support/material_bxdf.h"

namespace lacquer::layered::openpbr_test {
namespace {

using lacquer::test::MaterialFromText;

const SampledWavelengths kLambda = SampledWavelengths::SampleVisible(0.3f);
constexpr const char* kWhite = "\"rgb base_color\" [1 1 1] ";
constexpr const char* kPolished = "\"float specular_roughness\" 0 ";

/// Mean and standard error of some numbers.
struct Estimate {
    double mean, error;
};
template <class Draw>
Estimate MeanOf(int count, const Draw& draw) {
    double sum = 0, sum2 = 0;
    for (int i = 0; i < count; ++i) {
        const double x = draw(i);
        sum += x;
        sum2 += x * x;
    }
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(0.0, sum2 / count - mean * mean) / count)};
}

class OpenPBR : public testing::Test {
  protected:
    static MaterialFromText Make(const std::string& parameters) {
        return MaterialFromText("\"openpbr\" " + parameters);
    }
    /// Part of the light from an angle that leaves again, by samples.
    static Estimate Albedo(const std::string& parameters, float cosTheta, int count = 20000) {
        const MaterialFromText material = Make(parameters);
        Arena arena;
        Rng rng(5);
        const Vec3 wo(std::sqrt(1 - cosTheta * cosTheta), 0, cosTheta);
        const BxDF* bxdf = material.MakeBxDF(kLambda, arena);
        return MeanOf(count, [&](int) {
            const BxDFRandom u{rng.Uniform(), rng.Uniform2D()};
            const auto s = bxdf->Sample(wo, u, {.mode = TransportMode::Importance, .rng = &rng});
            return s ? double(s->weight.Average()) : 0;
        });
    }
    /// The same of Evaluate(), over the upper hemisphere.
    static Estimate AlbedoByValue(const std::string& parameters, float cosTheta, int count = 20000) {
        const MaterialFromText material = Make(parameters);
        Arena arena;
        Rng rng(6);
        const Vec3 wo(std::sqrt(1 - cosTheta * cosTheta), 0, cosTheta);
        const BxDF* bxdf = material.MakeBxDF(kLambda, arena);
        return MeanOf(count, [&](int) {
            const Vec3 wi = SampleCosineHemisphere(rng.Uniform2D());
            return double(bxdf->Evaluate(wo, wi, {.rng = &rng, .needsPdf = false}).f.Average()) * double(Pi);
        });
    }
};

// ---- Energy: nothing is lost where nothing absorbs and no facet is rough; nothing is gained anywhere
// -------

TEST_F(OpenPBR, WhiteSurfacesLoseNothing) {
    const std::string white = std::string(kWhite) + kPolished;
    const std::string cases[] = {
        white,
        white + "\"float base_diffuse_roughness\" 1",
        white + "\"float coat_weight\" 1",
        white + "\"float fuzz_weight\" 1",
        white + "\"float fuzz_weight\" 1 \"float fuzz_roughness\" 0.1 \"float coat_weight\" 1",
        white + "\"float subsurface_weight\" 1 \"rgb subsurface_color\" [1 1 1]",
        white + "\"float thin_film_weight\" 1",
        white + "\"float transmission_weight\" 1",
        white + "\"float transmission_weight\" 1 \"float coat_weight\" 1 \"bool geometry_thin_walled\" true",
        white +
            "\"float subsurface_weight\" 1 \"rgb subsurface_color\" [1 1 1] \"bool geometry_thin_walled\" "
            "true",
        white + "\"float base_metalness\" 1",
        white + "\"float geometry_opacity\" 0",
        kWhite + std::string("\"float specular_roughness\" 1"),
        kWhite + std::string("\"float specular_roughness\" 0.3"),
        kWhite + std::string(
                     "\"float specular_roughness\" 0.6 \"float coat_weight\" 1 \"float coat_roughness\" 1"),
        kWhite + std::string("\"float specular_roughness\" 0.7 \"float base_metalness\" 1"),
    };
    for (const std::string& c : cases)
        for (const float cosTheta : {1.f, 0.5f, 0.1f}) {
            const Estimate albedo = Albedo(c, cosTheta);
            EXPECT_NEAR(albedo.mean, 1, 4.5 * albedo.error + 2e-4) << c << ' ' << cosTheta;
        }
    // The check sees a loss: that of facets that scatter once.
    EXPECT_LT(
        Albedo(std::string(kWhite) + "\"float specular_roughness\" 0.8 \"bool multiscatter\" false", 0.5f)
            .mean,
        0.9);
}

TEST_F(OpenPBR, NothingIsGained) {
    Rng rng(17);
    for (int trial = 0; trial < 60; ++trial) {
        std::string parameters;
        for (const char* name :
             {"base_diffuse_roughness", "base_metalness", "specular_roughness",
              "specular_roughness_anisotropy", "transmission_weight", "subsurface_weight", "fuzz_weight",
              "fuzz_roughness", "coat_weight", "coat_roughness", "thin_film_weight"})
            parameters +=
                fmt::format("\"float {}\" {} ", name, trial % 3 ? rng.Uniform() : std::round(rng.Uniform()));
        parameters += fmt::format("\"float specular_ior\" {} \"float coat_ior\" {} ",
                                  1 + 1.5f * rng.Uniform(), 1 + rng.Uniform());
        const float cosTheta = trial % 2 ? rng.Uniform() : 0.05f;
        const Estimate albedo = Albedo(parameters + kWhite, std::max(cosTheta, 1e-3f), 4000);
        EXPECT_LT(albedo.mean, 1 + 4.5 * albedo.error + 1e-3) << parameters << cosTheta;
    }
}

TEST_F(OpenPBR, ValuesAgreeWithSamples) {
    const std::string base = "\"float specular_roughness\" 0.6 ";
    for (const std::string& layers :
         {std::string(),
          std::string(
              "\"float coat_weight\" 1 \"float coat_roughness\" 0.5 \"rgb coat_color\" [0.9 0.5 0.2] "),
          std::string("\"float fuzz_weight\" 1 "), std::string("\"float subsurface_weight\" 1 "),
          std::string("\"float base_metalness\" 1 \"rgb specular_color\" [0.9 0.6 0.4] "),
          std::string("\"float base_diffuse_roughness\" 0.8 \"rgb specular_color\" [0.9 0.6 0.4] ")})
        for (const float cosTheta : {0.95f, 0.3f}) {
            const Estimate a = Albedo(base + layers, cosTheta), b = AlbedoByValue(base + layers, cosTheta);
            EXPECT_NEAR(a.mean, b.mean, 4.5 * std::hypot(a.error, b.error) + 1e-3) << layers << cosTheta;
        }
}

// ---- Layers ---------------------------------------------------------------------------------------------

TEST_F(OpenPBR, IsTheStackThatItSays) {
    Arena arena;
    const MaterialFromText openPBR =
        Make("\"spectrum base_color\" [360 0.8 830 0.8] \"bool multiscatter\" false");
    const float inside = DiffuseReflectance(1.5f).fromBelow, below = 0.8f / (1 - 0.2f * inside);
    const MaterialFromText stack(
        fmt::format("\"coateddiffuse\" \"float thickness\" 0 \"spectrum reflectance\" [360 {0} 830 {0}] "
                    "\"float eta\" 1.5 "
                    "\"float roughness\" 0.09 \"bool remaproughness\" false \"integer maxdepth\" 100",
                    below));
    Rng rng(1);
    for (const Vec3 wi : {Vec3(0.3f, 0.1f, 0.9f), Vec3(-0.5f, 0.2f, 0.6f), Vec3(0.9f, 0, 0.2f)}) {
        const Vec3 wo = Normalize(Vec3(-0.3f, 0, 0.8f)), w = Normalize(wi);
        const float a = openPBR.MakeBxDF(kLambda, arena)->Evaluate(wo, w, {.rng = &rng}).f[0];
        const float b = stack.MakeBxDF(kLambda, arena)->Evaluate(wo, w, {.rng = &rng}).f[0];
        EXPECT_NEAR(a, b, 1e-4f * b) << w.x;
    }
}

// The colour of the base is that of all light which has passed its interface, as it leaves.
TEST_F(OpenPBR, BaseColorIsWhatLeavesThroughTheInterface) {
    const DiffuseFresnel fresnel = DiffuseReflectance(1.5f);
    for (const char* slot : {"base_color", "subsurface_color"}) {
        const MaterialFromText material =
            Make(fmt::format("\"spectrum {}\" [360 0.4 830 0.4] \"float subsurface_weight\" {} {}", slot,
                             slot[0] == 's' ? 1 : 0, kPolished));
        Arena arena;
        Rng rng(4);
        const BxDF* bxdf = material.MakeBxDF(kLambda, arena);
        const Estimate albedo = MeanOf(60000, [&](int) {
            const Vec3 wo = SampleCosineHemisphere(rng.Uniform2D());
            const auto s = bxdf->Sample(wo, {rng.Uniform(), rng.Uniform2D()}, {.rng = &rng});
            return s ? double(s->weight.Average()) : 0;
        });
        const double expected = double(fresnel.fromAbove + (1 - fresnel.fromAbove) * 0.4f);
        // Subsurface light leaves by an approximation of its albedo.
        EXPECT_NEAR(albedo.mean, expected, 4.5 * albedo.error + (slot[0] == 's' ? 0.02 : 1e-4)) << slot;
    }
}

TEST_F(OpenPBR, CoatColorsLightThatPassesTwice) {
    const auto mirror = [](const std::string& coat) {
        return Albedo("\"float base_metalness\" 1 \"float coat_weight\" 1 \"float coat_ior\" 1 " +
                          std::string(kWhite) + kPolished + coat,
                      1, 200)
            .mean;
    };
    EXPECT_NEAR(mirror("\"spectrum coat_color\" [360 0.36 830 0.36]"), 0.36, 1e-5);
    EXPECT_NEAR(mirror("\"spectrum coat_color\" [360 0 830 0]"), 0, 1e-5);
}

TEST_F(OpenPBR, SpecularWeightScalesTheReflectance) {
    const auto reflected = [](const std::string& parameters) {
        return Albedo("\"rgb base_color\" [0 0 0] " + std::string(kPolished) + parameters, 1, 40000);
    };
    EXPECT_NEAR(reflected("").mean, 0.04, 4.5 * reflected("").error + 1e-6);
    const Estimate half = reflected("\"float specular_weight\" 0.5");
    EXPECT_NEAR(half.mean, 0.02, 4.5 * half.error + 1e-6);
    const Estimate tinted = reflected("\"spectrum specular_color\" [360 0.25 830 0.25]");
    EXPECT_NEAR(tinted.mean, 0.01, 4.5 * tinted.error + 1e-6);
}

TEST(TintedMetal, HasItsColors) {
    const TintedMetal metal(SampledSpectrum(0.7f), SampledSpectrum(0.5f), 1);
    EXPECT_NEAR(metal.Reflectance(1)[0], 0.7f, 1e-6f);
    const float schlick = 0.7f + 0.3f * std::pow(6 / 7.f, 5.f);
    EXPECT_NEAR(metal.Reflectance(1 / 7.f)[0], 0.5f * schlick, 1e-6f);
    EXPECT_NEAR(metal.Reflectance(0)[0], 1, 1e-6f);
}

TEST(RoughDiffuse, ReturnsWhatSingleReflectionLoses) {
    Rng rng(2);
    for (const float roughness : {0.f, 0.3f, 1.f})
        for (const float c : {1.f, 0.6f, 0.1f, 0.01f}) {
            const RoughDiffuseBxDF white(SampledSpectrum(1), roughness),
                grey(SampledSpectrum(0.5f), roughness);
            const auto albedo = [&](const BxDF& bxdf) {
                return MeanOf(40000, [&](int) {
                    const BxDFRandom u{0, rng.Uniform2D()};
                    return double(bxdf.Sample({std::sqrt(1 - c * c), 0, c}, u, {})->weight[0]);
                });
            };
            const Estimate w = albedo(white), g = albedo(grey);
            EXPECT_NEAR(w.mean, 1, 4.5 * w.error + 1e-5) << roughness << ' ' << c;
            EXPECT_LT(g.mean, 0.5 + 0.02 + 4.5 * g.error) << roughness << ' ' << c;
        }
}

// ---- Mixtures ---------------------------------------------------------------------------------------------

TEST_F(OpenPBR, WeightsAreProbabilities) {
    const measure::SceneMaterial made = measure::LoadMaterial(
        ParseText(
            "WorldBegin MakeNamedMaterial \"m\" \"string type\" \"openpbr\" \"float base_metalness\" 0.3 "
            "\"float coat_weight\" 0.5 \"float geometry_opacity\" 0.8",
            "scene.pbrt", "", nullptr),
        "m", Point2(0.5f));
    std::map<const Material*, int> counts;
    Rng rng(9);
    constexpr int kDraws = 40000;
    for (int i = 0; i < kDraws; ++i)
        ++counts[made.setup.material->Choose({}, SampleUniformSphere(rng.Uniform2D()))];
    std::vector<double> shares;
    for (const auto& [part, count] : counts) shares.push_back(double(count) / kDraws);
    std::sort(shares.begin(), shares.end());
    const std::vector<double> expected = {0.8 * 0.3 * 0.5, 0.8 * 0.3 * 0.5, 0.2, 0.8 * 0.7 * 0.5,
                                          0.8 * 0.7 * 0.5};
    ASSERT_EQ(shares.size(), expected.size());
    for (size_t i = 0; i < shares.size(); ++i)
        EXPECT_NEAR(shares[i], expected[i], 4.5 * 0.5 / std::sqrt(double(kDraws)));
}

TEST_F(OpenPBR, DispersionEndsWavelengths) {
    Arena arena;
    const auto ends = [&](const std::string& parameters) {
        SampledWavelengths lambda = kLambda;
        const auto material = measure::LoadMaterial(
            ParseText("WorldBegin MakeNamedMaterial \"m\" \"string type\" \"openpbr\" " + parameters,
                      "scene.pbrt", "", nullptr),
            "m", Point2(0.5f));
        material.setup.material->Choose({}, {0, 0, 1})->MakeBxDF({}, lambda, arena);
        return lambda.SecondaryTerminated();
    };
    EXPECT_FALSE(ends("\"float transmission_weight\" 1"));
    EXPECT_TRUE(ends("\"float transmission_weight\" 1 \"float transmission_dispersion_scale\" 1"));
}

}  // namespace
}  // namespace lacquer::layered::openpbr_test
