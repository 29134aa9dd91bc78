// The coat of OpenPBR in a frame of its own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "layered/layered_bxdf.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/core/sampling.h"
#include "support/direction_image.h"
#include "support/material_bxdf.h"

namespace lacquer::layered::openpbr_frames_test {
namespace {

using lacquer::test::DirectionImage;
using lacquer::test::MaterialFromText;

const SampledWavelengths kLambda = SampledWavelengths::SampleVisible(0.3f);
const std::string kCoat = "\"float coat_weight\" 1 \"float coat_roughness\" 0.5 ";
/// A base that reflects nothing, so that all light is the coat's.
const std::string kBlack =
    "\"rgb base_color\" [0 0 0] \"float specular_weight\" 0 \"bool multiscatter\" false ";
const std::string kWhite = "\"rgb base_color\" [1 1 1] \"float specular_roughness\" 0.5 ";

const Stack& StackOf(const std::string& parameters, Arena& arena) {
    const MaterialFromText material("\"openpbr\" " + parameters);
    return dynamic_cast<const LayeredBxDF&>(*material.MakeBxDF(kLambda, arena)).GetStack();
}

TEST(OpenPBRFrames, CoatAndBaseHaveTheirOwn) {
    const Vec3 n = Normalize(Vec3(0.2f, 0.1f, 1));
    const DirectionImage map(n);
    Arena arena;
    const Stack& coated = StackOf(kCoat + map.Parameter("coat_normalmap"), arena);
    EXPECT_LT(Length(coated.interfaces[0].frame.z - n), 1e-5f);
    EXPECT_TRUE(coated.interfaces[1].HasUnperturbedNormal() && coated.interfaces[2].HasUnperturbedNormal());
    const Stack& based = StackOf(kCoat + map.Parameter("normalmap") + "\"float coat_rotation\" 90", arena);
    EXPECT_LT(Length(based.interfaces[0].frame.x - Vec3(0, 1, 0)), 1e-5f);
    EXPECT_TRUE(based.interfaces[0].HasUnperturbedNormal());
    for (const int i : {1, 2}) EXPECT_LT(Length(based.interfaces[size_t(i)].frame.z - n), 1e-5f) << i;
    // Fuzz lies in the frame of the surface. Without a coat the base keeps its normal.
    const Stack& fuzzy = StackOf(kCoat + "\"float fuzz_weight\" 1 " + map.Parameter("coat_normalmap"), arena);
    EXPECT_TRUE(fuzzy.interfaces[0].HasUnperturbedNormal());
    EXPECT_LT(Length(fuzzy.interfaces[1].frame.z - n), 1e-5f);
    const Stack& metal =
        StackOf("\"float base_metalness\" 1 \"float coat_rotation\" 9 " + map.Parameter("normalmap"), arena);
    ASSERT_EQ(metal.interfaces.size(), 1u);
    EXPECT_LT(Length(metal.interfaces[0].frame.z - n), 1e-5f);
}

// What the coat reflects is what its boundary does in a frame that was turned by hand.
TEST(OpenPBRFrames, CoatReflectsAsATurnedBoundary) {
    const Vec3 n = Normalize(Vec3(0.2f, 0, 1));
    const DirectionImage map(n);
    const MaterialFromText tilted("\"openpbr\" " + kBlack + kCoat + map.Parameter("coat_normalmap"));
    const MaterialFromText turned("\"openpbr\" " + kBlack + kCoat +
                                  "\"float coat_roughness_anisotropy\" 0.8 \"float coat_rotation\" 30");
    const MaterialFromText straight("\"openpbr\" " + kBlack + kCoat +
                                    "\"float coat_roughness_anisotropy\" 0.8");
    Arena arena;
    Rng rng(1);
    const Frame tilt = Frame::FromZX(n, {1, 0, 0});
    const DielectricBxDF<TrowbridgeReitz> facets(Alphas(0.25f, 0.25f), 1.6f);
    const auto inPlane = [](Vec3 w) {
        const float c = std::cos(Pi / 6), s = std::sin(Pi / 6);
        return Vec3(c * w.x + s * w.y, c * w.y - s * w.x, w.z);
    };
    for (int i = 0; i < 200; ++i) {
        const Vec3 wo = SampleCosineHemisphere(rng.Uniform2D()), wi = SampleCosineHemisphere(rng.Uniform2D());
        const Vec3 woTilted = tilt.ToLocal(wo), wiTilted = tilt.ToLocal(wi);
        if (woTilted.z < 0.05f || wiTilted.z < 0.05f || wo.z < 0.05f || wi.z < 0.05f) continue;
        // The cosine is that with the perturbed normal.
        const float expected = facets.Evaluate(woTilted, wiTilted, {.rng = &rng}).f[0] * wiTilted.z / wi.z;
        const float value = tilted.MakeBxDF(kLambda, arena)->Evaluate(wo, wi, {.rng = &rng}).f[0];
        EXPECT_NEAR(value, expected, 1e-4f * expected + 1e-6f);
        const float before =
            straight.MakeBxDF(kLambda, arena)->Evaluate(inPlane(wo), inPlane(wi), {.rng = &rng}).f[0];
        const float after = turned.MakeBxDF(kLambda, arena)->Evaluate(wo, wi, {.rng = &rng}).f[0];
        EXPECT_NEAR(after, before, 1e-3f * before + 1e-6f);
        arena.Reset();
    }
}

struct Albedos {
    double bySample, byValue, error;
};
Albedos AlbedosOf(const std::string& parameters, float cosTheta) {
    const MaterialFromText material("\"openpbr\" " + parameters);
    Arena arena;
    Rng rng(7);
    const BxDF* bxdf = material.MakeBxDF(kLambda, arena);
    const Vec3 wo(std::sqrt(1 - cosTheta * cosTheta), 0, cosTheta);
    test::RunningMean bySample, byValue;
    for (int i = 0; i < 20000; ++i) {
        const auto s = bxdf->Sample(wo, {rng.Uniform(), rng.Uniform2D()}, {.rng = &rng});
        bySample.Add(s ? double(s->weight.Average()) : 0);
        const Vec3 wi = SampleCosineHemisphere(rng.Uniform2D());
        byValue.Add(double(bxdf->Evaluate(wo, wi, {.rng = &rng, .needsPdf = false}).f.Average()) *
                    double(Pi));
    }
    return {bySample.Mean(), byValue.Mean(), std::hypot(bySample.StandardError(), byValue.StandardError())};
}

// A white furnace: nothing is gained under a tilted coat, values agree with samples, and what is lost is what
// leaves on the wrong side of one of the two normals, less than a tenth of the light.
TEST(OpenPBRFrames, TiltedCoatsGainNothing) {
    const DirectionImage map(Normalize(Vec3(0.15f, 0.1f, 1)));
    for (const float cosTheta : {1.f, 0.6f, 0.3f}) {
        const Albedos a = AlbedosOf(kWhite + kCoat + map.Parameter("coat_normalmap"), cosTheta);
        EXPECT_NEAR(a.bySample, a.byValue, 4.5 * a.error + 1e-3) << cosTheta;
        EXPECT_LT(a.bySample, 1 + 4.5 * a.error + 1e-3) << cosTheta;
        EXPECT_GT(a.bySample, 0.9) << cosTheta;
        // The check would see a coat that lets nothing through.
        EXPECT_LT(AlbedosOf(kBlack + kCoat + map.Parameter("coat_normalmap"), cosTheta).bySample, 0.6);
    }
}

}  // namespace
}  // namespace lacquer::layered::openpbr_frames_test
