// The light "infinite" with the model "sky".
#include "light_fixtures.h"
#include "support/statistics.h"

namespace lacquer::test::sky_test {
namespace {

const SampledWavelengths kLambda = Wavelengths();

std::unique_ptr<Light> Sky(std::vector<Parameter> parameters, const Transform& t = {}) {
    parameters.push_back(StringParam("model", "sky"));
    auto light = MakeLight("infinite", std::move(parameters), t);
    light->Preprocess(Bounds3(Point3(-1), Point3(1)));
    return light;
}
double Radiance(const Light& light, Vec3 w) {
    return double(light.Le({Point3(0), w}, kLambda)[1]) * double(kCieYIntegral);
}
double Pdf(const Light& light, Vec3 w) { return double(light.PdfLi(LightReference(Point3(0)), w, nullptr)); }

TEST(SkyLight, PlacesTheSunByAnglesDirectionAndTime) {
    const double inSun = 1000;  // [W m^-2 sr^-1 nm^-1]; skies are below 1
    const Vec3 southWest =
        Normalize(Vec3(1, -1, std::sqrt(2.f)));  // west is +x for cameras that do not mirror
    EXPECT_GT(Radiance(*Sky({FloatParam("elevation", {45}), FloatParam("azimuth", {225})}), southWest),
              inSun);
    EXPECT_GT(Radiance(*Sky({FloatParam("sundirection", {3, -3, 3 * std::sqrt(2.f)}, "vector3")}), southWest),
              inSun);
    EXPECT_LT(Radiance(*Sky({FloatParam("elevation", {45}), FloatParam("azimuth", {135})}), southWest), 10);
    // Noon of midsummer at Greenwich (SunPosition.AgreesWithAlmanacs).
    const float e = 61.96f * Pi / 180;
    const auto noon = Sky({StringParam("time", "2026-06-21 12:02 Z"), FloatParam("latitude", {51.4779f}),
                           FloatParam("longitude", {0})});
    EXPECT_GT(Radiance(*noon, {0, -std::cos(e), std::sin(e)}), inSun);
    EXPECT_LT(
        Radiance(*Sky({FloatParam("elevation", {45}), FloatParam("azimuth", {225}), BoolParam("sun", false)}),
                 southWest),
        10);
}

TEST(SkyLight, HasTheIrradianceOfAClearDay) {
    // High sun: about 1000 W/m^2 over all wavelengths, 45 % of it visible; a tenth to a fifth from the sky.
    const auto light = Sky({FloatParam("elevation", {60}), FloatParam("turbidity", {2})});
    Rng rng(SeedOf(FullTestName()));
    double sum = 0;
    constexpr int kSamples = 40000;
    for (int i = 0; i < kSamples; ++i) {
        const auto lambda = SampledWavelengths::SampleUniform(rng.Uniform(), 360, 830);
        const auto s = light->SampleLi(LightReference(Point3(0)), rng.Uniform2D(), lambda);
        if (s && s->wi.z > 0) sum += double(s->L[0] * s->wi.z / s->pdf) * 470;
    }
    const double irradiance = sum / kSamples * double(kCieYIntegral);
    EXPECT_GT(irradiance, 420);
    EXPECT_LT(irradiance, 600);
}

TEST(SkyLight, GroundReflectsWhatFallsOnIt) {
    const auto dark = Sky({FloatParam("groundalbedo", {0, 0, 0}, "rgb")});
    const auto bright = Sky({FloatParam("groundalbedo", {0.8f, 0.8f, 0.8f}, "rgb")});
    const auto none =
        Sky({FloatParam("groundalbedo", {0.8f, 0.8f, 0.8f}, "rgb"), BoolParam("ground", false)});
    const Vec3 down = Normalize(Vec3(0.3f, 0.4f, -0.1f)), up(0, 0, 1);
    EXPECT_EQ(Radiance(*dark, down), 0);
    EXPECT_EQ(Radiance(*none, down), 0);
    EXPECT_GT(Radiance(*bright, down), 0.05);
    EXPECT_GT(Radiance(*bright, up), 1.1 * Radiance(*dark, up));
    EXPECT_NEAR(Radiance(*none, up), Radiance(*bright, up), 1e-4 * Radiance(*none, up));
}

class SkyLightSamples : public testing::TestWithParam<float> {};

TEST_P(SkyLightSamples, HaveTheRadianceAndTheDensityOfTheirDirection) {
    const Transform t = Transform::Rotate(40, {1, 2, 0.5f}) * Transform::Scale({1, 1.6f, 0.8f});
    const auto light = Sky({FloatParam("elevation", {GetParam()}), FloatParam("azimuth", {70})}, t);
    Rng rng(SeedOf(FullTestName()));
    int different = 0;
    for (int i = 0; i < 20000; ++i) {
        const auto s = light->SampleLi(LightReference(Point3(0)), rng.Uniform2D(), kLambda);
        if (!s) continue;
        EXPECT_NEAR(Length(s->wi), 1, 1e-5);
        const SampledSpectrum L = light->Le({Point3(0), s->wi}, kLambda);
        different += !(std::abs(Pdf(*light, s->wi) - double(s->pdf)) < 2e-3 * double(s->pdf) &&
                       (L - s->L).MaxComponent() < 2e-3f * s->L.MaxComponent());
    }
    // Directions within rounding of a texel's edge or the sun's rim may fall to the other side.
    EXPECT_LE(different, 40);
}

TEST_P(SkyLightSamples, AloneAreUnbiased) {
    const auto light = Sky({FloatParam("elevation", {GetParam()}), FloatParam("azimuth", {70})});
    // Directions that cover sky and sun independently of the light's own density: half of them in a cone
    // around the sun.
    const float e = GetParam() * Pi / 180, a = 70 * Pi / 180;
    const Vec3 sun(-std::cos(e) * std::sin(a), std::cos(e) * std::cos(a), std::sin(e));
    const Frame frame = Frame::FromZ(sun);
    constexpr float kCone = 1e-4f;  // 1 - cosine: wider than the disk
    const auto estimate = [&](uint64_t seed, bool byLight, double gain) {
        Rng rng(seed);
        RunningMean mean;
        for (int i = 0; i < 100000; ++i) {
            const Point2 u = rng.Uniform2D();
            if (byLight) {
                const auto s = light->SampleLi(LightReference(Point3(0)), u, kLambda);
                mean.Add(s && s->wi.z > 0 ? gain * double(s->L[1] * s->wi.z / s->pdf) : 0.);
                continue;
            }
            Vec3 w;
            if (rng.Uniform() < 0.5f) {
                const float z = 1 - kCone * u.x, r = SafeSqrt(1 - z * z), phi = 2 * Pi * u.y;
                w = frame.FromLocal({r * std::cos(phi), r * std::sin(phi), z});
            } else {
                w = EqualAreaSquareToSphere(u);
            }
            const float pdf = 0.5f * Inv4Pi + (Dot(w, sun) >= 1 - kCone ? 0.5f / (2 * Pi * kCone) : 0.f);
            mean.Add(w.z > 0 ? double(light->Le({Point3(0), w}, kLambda)[1] * w.z / pdf) : 0.);
        }
        return mean;
    };
    const uint64_t seed = SeedOf(FullTestName());
    const RunningMean independent = estimate(seed + 1, false, 1);
    const auto differ = [&](double gain) {
        const RunningMean own = estimate(seed, true, gain);
        return std::abs(own.Mean() - independent.Mean()) /
               std::hypot(own.StandardError(), independent.StandardError());
    };
    // The density in float may err by a part in a thousand on the sun's rim. 10 % are found at 5 sigma and
    // more.
    EXPECT_LT(differ(1), 4);
    EXPECT_GT(differ(1.1), 5);
}

TEST_P(SkyLightSamples, DensityIntegratesToOne) {
    const auto light = Sky({FloatParam("elevation", {GetParam()}), BoolParam("sun", false)});
    EXPECT_NEAR(SphereIntegral(1024, [&](Vec3 w) { return Pdf(*light, w); }), 1, 5e-3);
}

INSTANTIATE_TEST_SUITE_P(Elevations, SkyLightSamples, testing::Values(60.f, 3.f, -6.f));

}  // namespace
}  // namespace lacquer::test::sky_test
