// The lights behind the name "infinite": uniform, image, portal.
#include "light_fixtures.h"
#include "pbrt/core/progress.h"
#include "support/statistics.h"

namespace lacquer::test::infinite_test {
namespace {

const SampledWavelengths kLambda = Wavelengths();

double Radiance(const Light& light, Vec3 w, Point3 origin = Point3(0)) {
    return double(light.Le({origin, w}, kLambda)[0]) / WhiteAt(kLambda);
}
double Pdf(const Light& light, Vec3 w, Point3 p = Point3(0)) {
    return double(light.PdfLi(LightReference(p), w, nullptr));
}

/// Grey noise from 0.5 to 1, and two bright texels.
RGB Noise(Int2 p) {
    if (p == Int2(3, 5)) return RGB(40);
    if (p == Int2(12, 13)) return RGB(8);
    return RGB(0.5f + 0.5f * UnitFloat(Hash(p.x, p.y)));
}
constexpr int kSize = 16;
const Transform kTurned = Transform::Rotate(40, {1, 2, 0.5f});

TEST(UniformInfiniteLight, IsTheSameEverywhere) {
    const auto light = MakeLight("infinite", {FloatParam("L", {2, 2, 2}, "rgb"), FloatParam("scale", {3})});
    EXPECT_TRUE(light->IsUniformInfinite());
    for (const Vec3 w : {Vec3(0, 0, 1), Vec3(0, -1, 0), Vec3(3, 4, 0)})
        EXPECT_NEAR(Radiance(*light, w), 6, 1e-4);
    EXPECT_NEAR(Pdf(*light, {0, 0, 1}), 1 / (4 * double(Pi)), 1e-7);
    const auto lit = MakeLight("infinite", {FloatParam("illuminance", {5})});
    EXPECT_NEAR(Radiance(*lit, {1, 0, 0}) * double(Pi), 5, 1e-4);
}

TEST(ImageInfiniteLight, CentreIsUpCornersAreDownRowsRunAlongY) {
    const TemporaryImage image(".exr", {kSize, kSize}, [](Int2 p) {
        return RGB(float(p.x + 1), float(p.x + 1), float(p.x + 1)) * (p.y >= kSize / 2 ? 100.f : 1.f);
    });
    const auto light = MakeLight("infinite", {StringParam("filename", image.Path())});
    // Just off the axes, to be inside of texels. +x is the middle of the right edge, +y that of the lower
    // one.
    EXPECT_NEAR(Radiance(*light, Normalize(Vec3(1, 0.02f, 0.02f))), 1600, 2);
    EXPECT_NEAR(Radiance(*light, Normalize(Vec3(1, -0.02f, 0.02f))), 16, 0.02);
    EXPECT_NEAR(Radiance(*light, Normalize(Vec3(-1, -0.02f, 0.02f))), 1, 2e-3);
    EXPECT_NEAR(Radiance(*light, Normalize(Vec3(0.02f, 1, 0.02f))), 900, 1);
    EXPECT_NEAR(Radiance(*light, Normalize(Vec3(0.02f, 0.02f, 1))), 900, 1);
    EXPECT_NEAR(Radiance(*light, Normalize(Vec3(0.02f, 0.02f, -1))), 1600, 2);
}

/// Keeps warnings.
class Warnings final : public Observer {
  public:
    void Begin(const std::string&, int64_t, const std::string&) override {}
    void Advance(int64_t) override {}
    void End() override {}
    void Warn(const std::string& message) override { messages.push_back(message); }
    bool ShouldStop() override { return false; }
    std::vector<std::string> messages;
};

TEST(ImageInfiniteLight, LatitudeLongitudeIsGuessedAloudAndMappingsAreTheSameLight) {
    // Red grows from -z to +z, green along +x.
    const auto color = [](Vec3 w) { return RGB(1.5f + w.z, 1.5f + w.x, 1); };
    const TemporaryImage image(".exr", {256, 128}, [&](Int2 p) {
        const float phi = 2 * Pi * (float(p.x) + 0.5f) / 256, theta = Pi * (float(p.y) + 0.5f) / 128;
        return color({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    });
    const TemporaryImage square("_square.exr", {128, 128}, [&](Int2 p) {
        return color(EqualAreaSquareToSphere((Point2(float(p.x), float(p.y)) + 0.5f) / 128.f));
    });
    NoTextures textures;
    const auto make = [&](const TemporaryImage& file, std::vector<Parameter> parameters, Observer* observer) {
        parameters.push_back(StringParam("filename", file.Path()));
        const Params params = MakeParams(std::move(parameters));
        auto light = Registry<LightKind>::Find("infinite")({params, {}, {}, textures, observer});
        params.CheckAllUsed();
        return light;
    };
    Warnings warnings;
    const auto guessed = make(image, {}, &warnings);
    ASSERT_EQ(warnings.messages.size(), 1u);
    EXPECT_NE(warnings.messages[0].find("latitude-longitude"), std::string::npos);
    const auto said = make(image, {StringParam("mapping", "latlong")}, &warnings);
    const auto equalArea = make(square, {}, &warnings);
    EXPECT_EQ(warnings.messages.size(), 1u);
    for (const Vec3 w :
         {Vec3(0, 0, 1), Vec3(1, 0, 0), Normalize(Vec3(-1, 2, -1)), Normalize(Vec3(1, -2, 3))}) {
        const double expected = Radiance(*equalArea, w);
        EXPECT_NEAR(Radiance(*guessed, w), expected, 0.02 * expected);
        EXPECT_EQ(Radiance(*said, w), Radiance(*guessed, w));
    }
}

TEST(ImageInfiniteLight, DensityIntegratesToOneUnderAnyTransform) {
    const TemporaryImage image(".exr", {kSize, kSize}, Noise);
    for (const Transform& t : {Transform(), kTurned, kTurned * Transform::Scale({-1, 1, 1}),
                               kTurned * Transform::Scale({1, 1.6f, 0.8f})}) {
        const auto light = MakeLight("infinite", {StringParam("filename", image.Path())}, t);
        // 1024^2 midpoints; cells that straddle the edge of a bright texel matter: of 1024/16 across, two
        // in 64.
        EXPECT_NEAR(SphereIntegral(1024, [&](Vec3 w) { return Pdf(*light, w); }), 1, 5e-3);
    }
}

TEST(ImageInfiniteLight, SamplesHaveTheRadianceAndTheDensityOfTheirDirection) {
    const TemporaryImage image(".exr", {kSize, kSize}, Noise);
    const auto light = MakeLight("infinite", {StringParam("filename", image.Path())},
                                 kTurned * Transform::Scale({1, 1.6f, 0.8f}));
    light->Preprocess(Bounds3(Point3(-5), Point3(5)));
    Rng rng(SeedOf(FullTestName()));
    int different = 0;
    for (int i = 0; i < 10000; ++i) {
        const auto s = light->SampleLi(LightReference(Point3(0)), rng.Uniform2D(), kLambda);
        ASSERT_TRUE(s);
        EXPECT_NEAR(Length(s->wi), 1, 1e-5);
        EXPECT_GT(Length(s->p), 9);
        const bool isEqual = std::abs(Pdf(*light, s->wi) - double(s->pdf)) < 1e-3 * double(s->pdf) &&
                             light->Le({Point3(0), s->wi}, kLambda) == s->L;
        different += !isEqual;
    }
    // Directions within rounding (1e-6 of the square) of a texel's edge may fall into the neighbour: 16 * 2 *
    // 1e-6 * 4 of all.
    EXPECT_LE(different, 5);
}

/// E[Y cos+ / pdf] against quadrature.
Outcome EstimateAgainstQuadrature(const Light& light, uint64_t seed, double gain, Point3 p = Point3(0)) {
    const Vec3 n = Normalize(Vec3(1, 2, 3));
    const double expected = SphereIntegral(
        1024, [&](Vec3 w) { return Radiance(light, w, p) * double(std::max(0.f, Dot(w, n))); });
    Rng rng(seed);
    RunningMean mean;
    for (int i = 0; i < 200000; ++i) {
        const auto s = light.SampleLi(LightReference(p), rng.Uniform2D(), kLambda);
        mean.Add(s ? gain * double(s->L[0] * std::max(0.f, Dot(s->wi, n)) / s->pdf) / WhiteAt(kLambda) : 0.);
    }
    // The quadrature is good to a part in a thousand (midpoints against the edges of texels and windows).
    return ZTest(mean, expected, 1e-3 * expected, "irradiance");
}

TEST(ImageInfiniteLight, LightSamplesAloneAreUnbiased) {
    const TemporaryImage image(".exr", {kSize, kSize}, Noise);
    const auto light = MakeLight("infinite", {StringParam("filename", image.Path())}, kTurned);
    EXPECT_TRUE(Passes(FullTestName(), 1e-4,
                       [&](uint64_t seed) { return EstimateAgainstQuadrature(*light, seed, 1); }));
    // Standard error: about 0.5 % of the mean; 4 % are found at 8 sigma.
    EXPECT_LT(EstimateAgainstQuadrature(*light, SeedOf(FullTestName()), 1.04).pValue, 1e-4);
}

TEST(ImageInfiniteLight, DensityIsCompensatedForMultipleImportanceSampling) {
    // Three quarters of luminance 1, one quarter of 5: the mean is 2, the weights are 0.05 and 3.
    const TemporaryImage image(".exr", {kSize, kSize},
                               [](Int2 p) { return RGB(p.x < 8 && p.y < 8 ? 5.f : 1.f); });
    const auto light = MakeLight("infinite", {StringParam("filename", image.Path())});
    const double dim = Pdf(*light, Normalize(Vec3(1, 1, 1))),
                 bright = Pdf(*light, Normalize(Vec3(-1, -1, 1)));
    EXPECT_NEAR(bright / dim, 3 / 0.05, 0.1);
    EXPECT_NEAR((0.25 * bright + 0.75 * dim) * 4 * double(Pi), 1, 1e-4);
    // A constant map leaves nothing above its mean: back to the plain density.
    const TemporaryImage flat("_flat.exr", {kSize, kSize}, [](Int2) { return RGB(3); });
    const auto constant = MakeLight("infinite", {StringParam("filename", flat.Path())});
    EXPECT_NEAR(Pdf(*constant, Normalize(Vec3(1, 1, 1))), 1 / (4 * double(Pi)), 1e-5);
}

TEST(ImageInfiniteLight, IlluminanceIsTwiceTooStrongAsInPbrt) {
    const TemporaryImage white(".exr", {512, 512}, [](Int2) { return RGB(7); });
    const auto light =
        MakeLight("infinite", {StringParam("filename", white.Path()), FloatParam("illuminance", {1})});
    EXPECT_NEAR(Radiance(*light, {0, 0, 1}), 2 / double(Pi), 1e-3);
}

TEST(ImageInfiniteLight, BlackMapsHaveNoSamples) {
    const TemporaryImage black(".exr", {4, 4}, [](Int2) { return RGB(0); });
    const auto light = MakeLight("infinite", {StringParam("filename", black.Path())});
    EXPECT_FALSE(light->SampleLi(LightReference(Point3(0)), {0.3f, 0.7f}, kLambda));
    EXPECT_EQ(light->Power(), 0.f);
    EXPECT_THROW(
        MakeLight("infinite", {StringParam("filename", black.Path()), FloatParam("illuminance", {1})}),
        SceneError);
}

TEST(ImageInfiniteLight, RejectsUnusableMaps) {
    const TemporaryImage oblong(".exr", {8, 5}, [](Int2) { return RGB(1); });
    EXPECT_THROW(MakeLight("infinite", {StringParam("filename", oblong.Path())}), SceneError);
    for (const float bad : {NAN, Infinity}) {
        const TemporaryImage broken("_bad.exr", {4, 4},
                                    [&](Int2 p) { return RGB(p == Int2(2, 1) ? bad : 1.f); });
        EXPECT_THROW(MakeLight("infinite", {StringParam("filename", broken.Path())}), SceneError) << bad;
    }
    EXPECT_THROW(MakeLight("infinite", {StringParam("filename", "/nowhere/map.exr")}), FileError);
    EXPECT_THROW(MakeLight("infinite", {StringParam("filename", "x.exr"), FloatParam("L", {1, 1, 1}, "rgb")}),
                 SceneError);
}

/// A window 2 wide and 1 high at z = -2, seen along +z.
Parameter PortalParam(std::vector<float> points = {-1, 0, -2, -1, 1, -2, 1, 1, -2, 1, 0, -2}) {
    return FloatParam("portal", std::move(points), "point3");
}

TEST(PortalInfiniteLight, ShinesThroughItsRectangleOnly) {
    // p3 - p0 = +x and p1 - p0 = +y: the frame's z is +z, so light is seen along +z, from z < -2.
    const auto light = MakeLight("infinite", {PortalParam(), FloatParam("L", {1, 1, 1}, "rgb")});
    EXPECT_NEAR(Radiance(*light, {0, 0.5f, 1}, {0, 0, -3}), 1, 1e-4);
    EXPECT_EQ(Radiance(*light, {0, -0.1f, 1}, {0, 0, -3}), 0);
    EXPECT_EQ(Radiance(*light, {1.1f, 0.5f, 1}, {0, 0, -3}), 0);
    EXPECT_NEAR(Radiance(*light, {0.9f, 0.5f, 1}, {0, 0, -3}), 1, 1e-4);
    EXPECT_EQ(Radiance(*light, {0, 0.5f, -1}, {0, 0, -1}), 0) << "from behind";
    EXPECT_FALSE(light->SampleLi(LightReference(Point3(0, 0, -1)), Point2(0.5f), kLambda));
}

TEST(PortalInfiniteLight, DensityIntegratesToOneFromAnywhere) {
    const TemporaryImage image(".exr", {kSize, kSize}, Noise);
    const auto light = MakeLight("infinite", {StringParam("filename", image.Path()), PortalParam()}, kTurned);
    for (const Point3 p : {Point3(0, 0, -3), Point3(-3, 2, -2.5f), Point3(0.5f, 0.5f, -2.2f)})
        // As for the image, plus the edge of the window; a small window has few of the 1024^2 directions.
        EXPECT_NEAR(SphereIntegral(1024, [&](Vec3 w) { return Pdf(*light, w, p); }), 1, 0.015);
}

TEST(PortalInfiniteLight, SamplesHaveTheRadianceAndTheDensityOfTheirDirection) {
    const TemporaryImage image(".exr", {kSize, kSize}, Noise);
    const auto light = MakeLight("infinite", {StringParam("filename", image.Path()), PortalParam()}, kTurned);
    Rng rng(SeedOf(FullTestName()));
    const Point3 p(0.2f, 0.4f, -2.5f);
    int different = 0;
    for (int i = 0; i < 10000; ++i) {
        const auto s = light->SampleLi(LightReference(p), rng.Uniform2D(), kLambda);
        ASSERT_TRUE(s);
        const bool isEqual = std::abs(Pdf(*light, s->wi, p) - double(s->pdf)) < 1e-3 * double(s->pdf) &&
                             light->Le({p, s->wi}, kLambda) == s->L;
        different += !isEqual;
    }
    EXPECT_LE(different, 5);  // rounding at the edges of texels and of the window, as above
}

TEST(PortalInfiniteLight, LightSamplesAloneAreUnbiased) {
    const TemporaryImage image(".exr", {kSize, kSize}, Noise);
    const auto light = MakeLight("infinite", {StringParam("filename", image.Path()), PortalParam()}, kTurned);
    const Point3 p(0.2f, 0.4f, -2.5f);
    const auto check = [&](uint64_t seed, double gain) {
        return EstimateAgainstQuadrature(*light, seed, gain, p);
    };
    EXPECT_TRUE(Passes(FullTestName(), 1e-4, [&](uint64_t seed) { return check(seed, 1); }));
    EXPECT_LT(check(SeedOf(FullTestName()), 1.04).pValue, 1e-4);
}

TEST(PortalInfiniteLight, WhiteLightThroughItIsARectangleOfRadianceOne) {
    const auto light = MakeLight("infinite", {PortalParam()});
    // Point under corner p0, facing the window: configuration factor of a rectangle 2 x 1 at distance 1.5.
    const Point3 p(-1, 0, -3.5f);
    const double A = 2 / 1.5, B = 1 / 1.5;
    const double factor = (A / std::hypot(1, A) * std::atan(B / std::hypot(1, A)) +
                           B / std::hypot(1, B) * std::atan(A / std::hypot(1, B))) /
                          (2 * double(Pi));
    constexpr int kStrata = 256;
    double sum = 0;
    for (int y = 0; y < kStrata; ++y)
        for (int x = 0; x < kStrata; ++x) {
            const auto s = light->SampleLi(LightReference(p),
                                           (Point2(float(x), float(y)) + 0.5f) / float(kStrata), kLambda);
            ASSERT_TRUE(s);
            sum += double(s->L[0] * s->wi.z / s->pdf);
        }
    EXPECT_NEAR(sum / (kStrata * kStrata) / WhiteAt(kLambda), double(Pi) * factor, 1e-3);
    // The flux of white light through an area of 2 is 2 pi, but for the grid of one texel.
    EXPECT_GT(light->Power(), 0.f);
}

TEST(PortalInfiniteLight, IsPlacedInTheWorld) {
    const auto light = MakeLight("infinite", {PortalParam()}, Transform::Translate({50, 0, 0}),
                                 Transform::Translate({0, 0, 10}));
    EXPECT_NEAR(Radiance(*light, {0, 0.5f, 1}, {0, 0, 7}), 1, 1e-4);
}

TEST(PortalInfiniteLight, RejectsWhatIsNoRectangle) {
    const std::vector<std::vector<float>> bad = {
        {0, 0, 0, 0, 1, 0, 1, 1, 0},                           // three points
        {0, 0, 0, 0, 1, 0, 1, 1, 0.5f, 1, 0, 0},               // not planar
        {0, 0, 0, 0, 1, 0, 2, 1, 0, 1, 0, 0},                  // not parallel
        {0, 0, 0, 1, 1, 0, 2, 1, 0, 1, 0, 0},                  // no right angles
        {0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0},                  // no area
        {0, 0, 0, 0, NAN, 0, 1, 1, 0, 1, 0, 0},                // not a number
        {0, 0, 0, 0, 3e38f, 0, 3e38f, 3e38f, 0, 3e38f, 0, 0},  // too large
    };
    for (const std::vector<float>& points : bad)
        EXPECT_THROW(MakeLight("infinite", {PortalParam(points)}), SceneError);
}

}  // namespace
}  // namespace lacquer::test::infinite_test
