#include "textures/texture_fixture.h"

#include <filesystem>

#include "pbrt/base/constant_texture.h"
#include "pbrt/textures/noise.h"

namespace lacquer::textures_test {
namespace {

using namespace testing_support;

void ExpectSpectrum(SampledSpectrum actual, SampledSpectrum expected, float tolerance = 1e-5f) {
    for (int i = 0; i < kNumWavelengths; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance);
}

TEST_F(Textures, ConstantIsTheValue) {
    EXPECT_EQ(MakeFloat("constant", {})->Evaluate(At(0, 0)), 1);
    const FloatTexture* half = MakeFloat("constant", {Numbers("float", "value", {0.5f})});
    EXPECT_EQ(half->Evaluate(At(0, 0)), 0.5f);
    EXPECT_EQ(half->Constant(), 0.5f);
    const SpectrumTexture* red = MakeSpectrum("constant", {Numbers("rgb", "value", {0.5f, 0.1f, 0.1f})});
    EXPECT_TRUE(red->IsConstant());
    ExpectSpectrum(red->Evaluate(At(0, 0), lambda),
                   SampleRGB(ColorSpace::SRGB(), {0.5f, 0.1f, 0.1f}, SpectrumKind::Albedo, lambda));
}

TEST_F(Textures, ConstantFollowsItsKind) {
    const std::vector<Parameter> bright = {Numbers("rgb", "value", {2, 4, 6})};
    for (const SpectrumKind kind : {SpectrumKind::Unbounded, SpectrumKind::Illuminant})
        ExpectSpectrum(MakeSpectrum("constant", bright, kind)->Evaluate(At(0, 0), lambda),
                       SampleRGB(ColorSpace::SRGB(), {2, 4, 6}, kind, lambda), 1e-4f);
    EXPECT_THROW(MakeSpectrum("constant", bright, SpectrumKind::Albedo), SceneError);
}

TEST_F(Textures, ScaleMultiplies) {
    EXPECT_EQ(MakeFloat("scale", {Numbers("float", "tex", {3}), Numbers("float", "scale", {0.5f})})
                  ->Evaluate(At(0, 0)),
              1.5f);
    library.floats["f"] = MakeFloat("bilerp", {Numbers("float", "v11", {4})});
    EXPECT_EQ(MakeFloat("scale", {Text("texture", "tex", "f"), Numbers("float", "scale", {0.5f})})
                  ->Evaluate(At(1, 1)),
              2);
    ExpectSpectrum(
        MakeSpectrum("scale", {Numbers("rgb", "tex", {0.5f, 0.5f, 0.5f}), Text("texture", "scale", "f")})
            ->Evaluate(At(1, 1), lambda),
        SampledSpectrum(2));
}

TEST_F(Textures, MixShowsTex2AtAmountOne) {
    for (const auto& [amount, expected] : {std::pair(0.f, 2.f), {1.f, 6.f}, {0.25f, 3.f}}) {
        EXPECT_FLOAT_EQ(MakeFloat("mix", {Numbers("float", "tex1", {2}), Numbers("float", "tex2", {6}),
                                          Numbers("float", "amount", {amount})})
                            ->Evaluate(At(0, 0)),
                        expected);
        ExpectSpectrum(MakeSpectrum("mix", {Numbers("rgb", "tex1", {.2f, .2f, .2f}),
                                            Numbers("rgb", "tex2", {.6f, .6f, .6f}),
                                            Numbers("float", "amount", {amount})})
                           ->Evaluate(At(0, 0), lambda),
                       SampledSpectrum(expected / 10));
    }
    EXPECT_EQ(MakeFloat("mix", {})->Evaluate(At(0, 0)), 0.5f);
}

TEST_F(Textures, DirectionMixShowsTex1AlongTheDirection) {
    const Transform turn = Transform::Rotate(90, {0, 0, 1});  // x to y
    const FloatTexture* texture = MakeFloat(
        "directionmix",
        {Numbers("float", "tex1", {3}), Numbers("float", "tex2", {5}), Numbers("vector3", "dir", {2, 0, 0})},
        turn);
    TextureContext context;
    for (const auto& [n, expected] : {std::pair(Vec3(0, 1, 0), 3.f),
                                      {Vec3(0, -1, 0), 3.f},
                                      {Vec3(1, 0, 0), 5.f},
                                      {Vec3(0, 0.6f, 0.8f), 3.8f}}) {
        context.n = n;
        EXPECT_NEAR(texture->Evaluate(context), expected, 1e-5f);
    }
    context.n = {0, 1, 0};
    ExpectSpectrum(MakeSpectrum("directionmix", {})->Evaluate(context, lambda), SampledSpectrum(0));
    // On a surface the geometry decides, whatever its shading normals are.
    SurfaceInteraction si;
    si.n = {0, 0.6f, 0.8f};
    si.shading.n = {0, 1, 0};
    EXPECT_NEAR(texture->Evaluate(TextureContext(si)), 3.8f, 1e-5f);
    EXPECT_THROW(MakeFloat("directionmix", {Numbers("vector3", "dir", {0, 0, 0})}), SceneError);
}

TEST_F(Textures, BilerpHasSFirst) {
    const FloatTexture* texture =
        MakeFloat("bilerp", {Numbers("float", "v00", {1}), Numbers("float", "v01", {2}),
                             Numbers("float", "v10", {3}), Numbers("float", "v11", {5})});
    EXPECT_EQ(texture->Evaluate(At(0, 0)), 1);
    EXPECT_EQ(texture->Evaluate(At(0, 1)), 2);
    EXPECT_EQ(texture->Evaluate(At(1, 0)), 3);
    EXPECT_FLOAT_EQ(texture->Evaluate(At(0.5f, 0.5f)), 2.75f);
    EXPECT_FLOAT_EQ(MakeFloat("bilerp", {})->Evaluate(At(0.7f, 0.25f)), 0.25f);
    ExpectSpectrum(MakeSpectrum("bilerp", {})->Evaluate(At(0.7f, 0.25f), lambda), SampledSpectrum(0.25f));
    EXPECT_TRUE(
        std::isfinite(MakeFloat("bilerp", {Numbers("float", "uscale", {3e38f})})->Evaluate(At(7, 7))));
}

TEST_F(Textures, CheckerboardStartsWithTex1) {
    const FloatTexture* texture =
        MakeFloat("checkerboard", {Numbers("float", "tex1", {3}), Numbers("float", "tex2", {5})});
    EXPECT_EQ(texture->Evaluate(At(0.5f, 0.5f)), 3);
    EXPECT_EQ(texture->Evaluate(At(1.5f, 0.5f)), 5);
    EXPECT_EQ(texture->Evaluate(At(1.5f, 1.5f)), 3);
    EXPECT_EQ(texture->Evaluate(At(-0.5f, 0.5f)), 5);
    EXPECT_EQ(MakeSpectrum("checkerboard", {})->Evaluate(At(0.5f, 0.5f), lambda), SampledSpectrum(1));
    const FloatTexture* solid = MakeFloat("checkerboard", {Integer("dimension", 3)});
    EXPECT_EQ(solid->Evaluate(At(Point3(0.5f, 0.5f, 0.5f))), 1);
    EXPECT_EQ(solid->Evaluate(At(Point3(0.5f, 0.5f, -0.5f))), 0);
    EXPECT_THROW(MakeFloat("checkerboard", {Integer("dimension", 4)}), SceneError);
}

TEST_F(Textures, CheckerboardFiltersWithATent) {
    // Against quadrature of the square wave under the tent of half width 1.5 |ds|, along s at a cell centre
    // of t.
    const FloatTexture* texture = MakeFloat("checkerboard", {});
    for (const float s : {0.1f, 0.5f, 0.93f, 1.4f, -3.7f})
        for (const float ds : {0.05f, 0.2f, 0.7f, 3.f}) {
            TextureContext context = At(s, 0.5f);
            context.dudx = ds;
            const double r = 1.5 * double(ds);
            double sum = 0;
            constexpr int n = 20000;
            for (int i = 0; i < n; ++i) {
                const double x = -r + (i + 0.5) * 2 * r / n;
                const bool even = int64_t(std::floor(double(s) + x)) % 2 == 0;
                sum += (even ? 1 : 0) * (r - std::abs(x)) / (r * r) * 2 * r / n;
            }
            EXPECT_NEAR(double(texture->Evaluate(context)), sum, 1e-3) << s << " " << ds;
        }
    TextureContext context = At(0.5f, 0.5f);
    context.dudx = context.dvdy = 1e30f;
    EXPECT_EQ(texture->Evaluate(context), 0.5f);
    EXPECT_TRUE(std::isfinite(texture->Evaluate(At(1e30f, -1e38f))));
}

TEST_F(Textures, DotsShowTheValueOfInsideAroundThem) {
    const FloatTexture* texture =
        MakeFloat("dots", {Numbers("float", "inside", {3}), Numbers("float", "outside", {5})});
    int dots = 0, cells = 0;
    for (int s = -10; s < 10; ++s)
        for (int t = -10; t < 10; ++t) {
            // Cells have integer centres; radius and shift leave their corners free.
            EXPECT_EQ(texture->Evaluate(At(float(s) + 0.49f, float(t) + 0.49f)), 3);
            const bool exists = Noise(float(s) + 0.5f, float(t) + 0.5f) > 0;
            EXPECT_EQ(texture->Evaluate(At(float(s), float(t))), exists ? 5 : 3);
            dots += exists;
            ++cells;
        }
    // About half of the cells have one.
    EXPECT_GT(dots, cells / 4);
    EXPECT_LT(dots, 3 * cells / 4);
    ExpectSpectrum(MakeSpectrum("dots", {})->Evaluate(At(0.49f, 0.49f), lambda), SampledSpectrum(1));
}

TEST_F(Textures, NoiseTexturesAreTheirSumsInTextureSpace) {
    const Transform transform = Transform::Translate({1, 2, 3});
    const Point3 p(1.3f, 3.7f, 0.8f), local(0.3f, 1.7f, -2.2f);
    const std::vector<Parameter> parameters = {Integer("octaves", 4), Numbers("float", "roughness", {0.6f})};
    EXPECT_NEAR(MakeFloat("fbm", parameters, transform)->Evaluate(At(p)),
                FractionalBrownianMotion(local, Vec3(0), Vec3(0), {0.6f, 4}), 1e-4f);
    EXPECT_NEAR(MakeFloat("wrinkled", parameters, transform)->Evaluate(At(p)),
                Turbulence(local, Vec3(0), Vec3(0), {0.6f, 4}), 1e-4f);
    EXPECT_NEAR(MakeFloat("windy", {}, transform)->Evaluate(At(p)),
                std::abs(FractionalBrownianMotion(0.1f * local, Vec3(0), Vec3(0), {0.5f, 3})) *
                    FractionalBrownianMotion(local, Vec3(0), Vec3(0), {0.5f, 6}),
                1e-4f);
    EXPECT_TRUE(std::isfinite(MakeFloat("fbm", {Integer("octaves", 2147483647)})->Evaluate(At(p))));
}

TEST_F(Textures, MarbleShowsItsSpline) {
    // Without variation the layer is y; where sin y = -1, the first control colour.
    const SpectrumTexture* texture = MakeSpectrum("marble", {Numbers("float", "variation", {0})});
    ExpectSpectrum(texture->Evaluate(At(Point3(0, -PiOver2, 0)), lambda),
                   SampleRGB(ColorSpace::SRGB(), 1.5f * RGB(.58f, .58f, .6f), SpectrumKind::Albedo, lambda));
    // sin y = 0: t = 1/2 starts the piece of colours 3 to 6.
    ExpectSpectrum(texture->Evaluate(At(Point3(0)), lambda), SampledSpectrum(0.75f));
    // sin y = 1: the end of the last piece.
    ExpectSpectrum(texture->Evaluate(At(Point3(0, PiOver2, 0)), lambda),
                   SampleRGB(ColorSpace::SRGB(), 1.5f * RGB(.58f, .58f, .6f), SpectrumKind::Albedo, lambda),
                   1e-4f);
    EXPECT_TRUE(texture->Evaluate(At(Point3(1e38f)), lambda).IsValid());
}

TEST_F(Textures, EveryTextureOfTheIssueIsRegistered) {
    const std::vector<std::string> floats = {"bilerp", "checkerboard", "constant", "directionmix",
                                             "dots",   "fbm",          "imagemap", "mix",
                                             "scale",  "windy",        "wrinkled"};
    const std::vector<std::string> spectra = {"bilerp",   "checkerboard", "constant", "directionmix", "dots",
                                              "imagemap", "marble",       "mix",      "scale"};
    for (const std::string& name : floats) EXPECT_NE(Registry<FloatTextureKind>::Find(name), nullptr) << name;
    for (const std::string& name : spectra)
        EXPECT_NE(Registry<SpectrumTextureKind>::Find(name), nullptr) << name;
}

TEST_F(Textures, ParametersMayBeValuesOrTextures) {
    library.floats["t"] = MakeFloat("constant", {Numbers("float", "value", {7})});
    const auto value = [&](std::vector<Parameter> parameters) {
        return FloatTextureParam(MakeParams(std::move(parameters)), "x", 2, library)->Constant();
    };
    EXPECT_EQ(value({}), 2);
    EXPECT_EQ(value({Numbers("float", "x", {3})}), 3);
    EXPECT_EQ(value({Text("texture", "x", "t")}), 7);
    EXPECT_THROW(value({Text("texture", "x", "missing")}), SceneError);
    EXPECT_THROW(value({Numbers("float", "x", {Infinity})}), SceneError);
    EXPECT_EQ(OptionalFloatTextureParam(MakeParams({}), "x", library), nullptr);
    EXPECT_EQ(OptionalSpectrumTextureParam(MakeParams({}), "x", SpectrumKind::Albedo, library), nullptr);
    // The directive's own value comes before what Attribute adds.
    Parameter inherited = Text("texture", "x", "t");
    inherited.fromAttribute = true;
    EXPECT_EQ(value({Numbers("float", "x", {3}), inherited}), 3);
    EXPECT_EQ(value({inherited}), 7);
}

}  // namespace
}  // namespace lacquer::textures_test
