// The light "goniometric": orientation, units, and what it rejects.
#include "light_fixtures.h"
#include "support/statistics.h"

namespace lacquer::test::goniometric_test {
namespace {

constexpr int kSize = 16;

/// Luminance of what arrives at p, 0 if nothing does.
double At(const Light& light, Point3 p) {
    const auto sample = light.SampleLi(LightReference(p), Point2(0.5f), Wavelengths());
    return sample ? double(sample->L[0]) / WhiteAt(Wavelengths()) : 0;
}
/// Grey of a different brightness in each texel, 0.25 to 2.25.
RGB Noise(Int2 p) { return RGB(0.25f + 2 * UnitFloat(Hash(p.x, p.y))); }
double MeanOfNoise() {
    double sum = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) sum += double(Noise({x, y}).x);
    return sum / (kSize * kSize);
}
std::unique_ptr<Light> MakeLamp(const TemporaryImage& image, std::vector<Parameter> more = {},
                                const Transform& renderFromLight = {}) {
    more.push_back(StringParam("filename", image.Path()));
    return MakeLight("goniometric", std::move(more), renderFromLight);
}

TEST(GoniometricLight, CentreIsPlusYCornersAreMinusYRowsRunAlongZ) {
    const TemporaryImage image(".exr", {kSize, kSize},
                               [](Int2 p) { return RGB(float(p.x + 1) * (p.y >= kSize / 2 ? 100.f : 1.f)); });
    const auto light = MakeLamp(image);
    // Just off the axes, to be inside of texels. +x is the middle of the right edge, +z that of the lower
    // one.
    EXPECT_NEAR(At(*light, Normalize(Vec3(1, 0.02f, 0.02f))), 1600, 0.1);
    EXPECT_NEAR(At(*light, Normalize(Vec3(1, 0.02f, -0.02f))), 16, 1e-3);
    EXPECT_NEAR(At(*light, Normalize(Vec3(-1, 0.02f, -0.02f))), 1, 1e-4);
    EXPECT_NEAR(At(*light, Normalize(Vec3(0.02f, 0.02f, 1))), 900, 0.1);
    EXPECT_NEAR(At(*light, Normalize(Vec3(0.02f, 1, 0.02f))), 900, 0.1);
    EXPECT_NEAR(At(*light, Normalize(Vec3(0.02f, -1, 0.02f))), 1600, 0.1);
    EXPECT_NEAR(At(*light, Normalize(Vec3(-0.02f, -1, -0.02f))), 1, 1e-4);
}

TEST(GoniometricLight, WithAWhiteImageIsAPointLight) {
    const TemporaryImage white(".exr", {1, 1}, [](Int2) { return RGB(1); });
    const std::vector<Parameter> intensity = {FloatParam("I", {3, 2, 1}, "rgb"), FloatParam("scale", {5})};
    const auto lamp = MakeLamp(white, intensity), point = MakeLight("point", intensity);
    EXPECT_FLOAT_EQ(lamp->Power(), point->Power());
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 100; ++i) {
        const LightReference ref(Point3(rng.Uniform(), rng.Uniform(), rng.Uniform()) * 8.f - Vec3(4));
        const auto a = lamp->SampleLi(ref, Point2(0), Wavelengths()),
                   b = point->SampleLi(ref, Point2(0), Wavelengths());
        ASSERT_TRUE(a && b);
        EXPECT_LT(Length(a->wi - b->wi), 1e-6f);
        EXPECT_EQ(a->p, b->p);
        EXPECT_EQ(a->pdf, 1.f);
        for (int lane = 0; lane < 4; ++lane) EXPECT_FLOAT_EQ(a->L[lane], b->L[lane]);
        EXPECT_EQ(lamp->PdfLi(ref, a->wi, nullptr), 0.f);
    }
    EXPECT_FALSE(lamp->SampleLi(LightReference(Point3(0)), Point2(0), Wavelengths()));
}

TEST(GoniometricLight, EmitsTheGivenPower) {
    const TemporaryImage image(".exr", {kSize, kSize}, Noise);
    const auto light = MakeLamp(image, {FloatParam("power", {50}), FloatParam("I", {4000}, "blackbody")});
    EXPECT_NEAR(light->Power(), 50, 1e-3);
    // A blackbody of 4000 K is no white: the integral is over one wavelength, and scaled by what it has
    // of 50.
    const double share = LuminanceOf([&](const SampledWavelengths& lambda) {
                             return light->SampleLi(LightReference(Point3(0, 1, 0)), Point2(0.5f), lambda)->L;
                         }) /
                         At(*light, {0, 1, 0});
    // With its axes exchanged as the light does, the midpoints of 256^2 cells lie inside of texels: no error
    // but rounding.
    const auto exchanged = [&](Vec3 w) { return At(*light, {w.x, w.z, w.y}); };
    EXPECT_NEAR(share * SphereIntegral(256, exchanged), 50, 0.01);
    // Any other way, cells straddle the edges of texels: of 1024/16 across, two in 64.
    const auto turned = MakeLamp(image, {FloatParam("power", {50})}, Transform::Rotate(40, {1, 2, 0.5f}));
    EXPECT_NEAR(SphereIntegral(1024, [&](Vec3 w) { return At(*turned, w); }), 50, 0.1);
}

TEST(GoniometricLight, PowerIsTheMeanOfTheImage) {
    const TemporaryImage image(".exr", {kSize, kSize}, Noise);
    EXPECT_NEAR(MakeLamp(image)->Power(), 4 * double(Pi) * MeanOfNoise(), 1e-4);
    // The luminance of "rgb I" multiplies a given power too; power 0 is one that is not given.
    EXPECT_NEAR(MakeLamp(image, {FloatParam("power", {7}), FloatParam("I", {2, 2, 2}, "rgb")})->Power(), 14,
                1e-4);
    EXPECT_NEAR(MakeLamp(image, {FloatParam("power", {0})})->Power(), 4 * double(Pi) * MeanOfNoise(), 1e-4);
}

TEST(GoniometricLight, TakesTheMeanOfRgbOrChannelY) {
    const TemporaryImage colour(".exr", {1, 1}, [](Int2) { return RGB(0.25f, 0.5f, 1.5f); });
    EXPECT_NEAR(At(*MakeLamp(colour), {0, 0, 1}), 0.75, 1e-5);
    // A negative brightness, as filters leave them, is none.
    const TemporaryImage negative("_negative.exr", {1, 1}, [](Int2) { return RGB(-1, -2, 0.5f); });
    EXPECT_EQ(At(*MakeLamp(negative), {0, 0, 1}), 0);
    const std::string path = colour.Path() + ".grey.exr";
    Image grey({2, 2}, {"Y"});
    for (float& value : grey.Pixels()) value = 0.4f;
    WriteImage(grey, path);
    EXPECT_NEAR(At(*MakeLight("goniometric", {StringParam("filename", path)}), {0, 0, 1}), 0.4, 1e-5);
    std::filesystem::remove(path);
}

TEST(GoniometricLight, FollowsItsTransformButNotItsScale) {
    const TemporaryImage image(".exr", {kSize, kSize},
                               [](Int2 p) { return RGB(p.x < kSize / 2 ? 0.f : 1.f); });
    const auto light = MakeLamp(
        image, {},
        Transform::Translate({0, 10, 0}) * Transform::Rotate(90, {0, 0, 1}) * Transform::Scale(Vec3(3)));
    // +x, the bright side, turned by 90 degrees about z is +y.
    EXPECT_NEAR(At(*light, {0, 12, 0}), 0.25, 1e-5);
    EXPECT_EQ(At(*light, {0, 8, 0}), 0);
    const TemporaryImage noise("_noise.exr", {kSize, kSize}, Noise);
    const auto plain = MakeLamp(noise);
    Rng rng(SeedOf(FullTestName()));
    for (const float size : {0.01f, 3.f}) {
        const auto scaled = MakeLamp(noise, {}, Transform::Scale(Vec3(size)));
        int numDifferent = 0;
        for (int i = 0; i < 1000; ++i) {
            const Vec3 w = EqualAreaSquareToSphere(rng.Uniform2D());
            numDifferent += std::abs(At(*scaled, w) - At(*plain, w)) > 1e-4;
        }
        // Directions within rounding of a texel's edge: 1000 * 16 * 2 * 1e-6 * 4 of them.
        EXPECT_LE(numDifferent, 3) << size;
    }
}

/// What MakeLight() says is wrong.
std::string ErrorOf(std::vector<Parameter> parameters) {
    try {
        MakeLight("goniometric", std::move(parameters));
    } catch (const std::exception& e) {
        return e.what();
    }
    return "";
}

TEST(GoniometricLight, MistakesAreSaid) {
    const auto in = [](Int2 size, float value) {
        return TemporaryImage("_" + std::to_string(size.x) + ".exr", size,
                              [value](Int2) { return RGB(value); });
    };
    const auto says = [](const TemporaryImage& image, const char* part, std::vector<Parameter> more = {}) {
        more.push_back(StringParam("filename", image.Path()));
        const std::string error = ErrorOf(std::move(more));
        EXPECT_NE(error.find(part), std::string::npos) << error;
    };
    EXPECT_NE(ErrorOf({}).find("needs \"string filename\""), std::string::npos);
    says(in({8, 4}, 1), "must be square (equal-area octahedral), this image has 8 x 4 pixels");
    says(in({4, 4}, NAN), "pixel (0, 0) is not a finite number");
    says(in({4, 4}, 0), "the image is black: no scale gives this light a power", {FloatParam("power", {1})});
    says(in({4, 4}, 1), "scale", {FloatParam("scale", {-1})});
    says(in({4, 4}, 1e30f), "must be finite", {FloatParam("scale", {1e30f})});
}

}  // namespace
}  // namespace lacquer::test::goniometric_test
