#include "light_fixtures.h"
#include "shapes/shape_test_support.h"
#include "support/statistics.h"

namespace lacquer::test::diffuse_test {
namespace {

/// A texture of one value, which says so or not.
class Alpha final : public FloatTexture {
  public:
    Alpha(float value, bool isConstant) : value_(value), isConstant_(isConstant) {}
    float Evaluate(const TextureContext&) const override { return value_; }
    std::optional<float> Constant() const override {
        return isConstant_ ? std::optional<float>(value_) : std::nullopt;
    }

  private:
    float value_;
    bool isConstant_;
};

/// Nothing where u is below a half.
class HalfAlpha final : public FloatTexture {
  public:
    float Evaluate(const TextureContext& context) const override { return context.uv.x < 0.5f ? 0.f : 1.f; }
};

/// Illuminance at p on a surface with normal n, by n^2 stratified samples at the strata's centres.
double Illuminance(const Light& light, Point3 p, Vec3 n, int strata = 256) {
    LightReference ref(p);
    ref.n = ref.ns = n;
    const SampledWavelengths lambda = Wavelengths();
    double sum = 0;
    for (int y = 0; y < strata; ++y)
        for (int x = 0; x < strata; ++x) {
            const auto s = light.SampleLi(ref, (Point2(float(x), float(y)) + 0.5f) / float(strata), lambda);
            if (s) sum += double(s->L[0] * std::max(0.f, Dot(s->wi, n)) / s->pdf);
        }
    return sum / (double(strata) * strata) / WhiteAt(lambda);
}

/// Radiance that leaves a light, over white's.
double Radiance(const Light& light, Normal3 n, Point2 uv, Vec3 w, Point3 p = Point3(0)) {
    return double(light.L(p, n, uv, w, Wavelengths())[0]) / WhiteAt(Wavelengths());
}

TEST(DiffuseLight, IrradianceOfARectangleIsThatOfTheClosedForm) {
    // [Howell, configuration factor from an element parallel to a rectangle a x b at distance c over its
    // corner]
    const double a = 2, b = 3, c = 1.5, A = a / c, B = b / c;
    const double factor = (A / std::hypot(1, A) * std::atan(B / std::hypot(1, A)) +
                           B / std::hypot(1, B) * std::atan(A / std::hypot(1, B))) /
                          (2 * double(Pi));
    const Parallelogram shape({0, 0, 1.5f}, {0, 3, 0}, {2, 0, 0});  // faces -z
    const auto lights = MakeAreaLights(shape, {FloatParam("scale", {4})});
    // Midpoint rule with 256^2 strata of a smooth integrand: below 1e-5.
    EXPECT_NEAR(Illuminance(*lights[0], Point3(0), {0, 0, 1}), 4 * double(Pi) * factor, 1e-3);
    EXPECT_NEAR(Illuminance(*lights[0], {0, 0, 3}, {0, 0, -1}), 0, 0) << "it has one side";
}

TEST(DiffuseLight, IrradianceOfASphereIsThatOfADiskOfItsSize) {
    const Ball shape({0, 0, 5}, 1.5f);
    const auto lights = MakeAreaLights(shape, {});
    // pi (r/d)^2. The horizon cuts through strata: errors of about the strata at the rim, 1/256 of the
    // visible part each way.
    EXPECT_NEAR(Illuminance(*lights[0], Point3(0), {0, 0, 1}, 512), double(Pi) * 2.25 / 25, 5e-4);
}

TEST(DiffuseLight, PowerOfASphereGivesItsRadiance) {
    const Ball shape(Point3(0), 1);
    const auto lights = MakeAreaLights(shape, {FloatParam("power", {10})});
    EXPECT_NEAR(Radiance(*lights[0], {0, 0, 1}, Point2(0), {0, 0, 1}), 10 / (4 * double(Pi) * double(Pi)),
                1e-5);
    EXPECT_NEAR(lights[0]->Power(), 10, 1e-4);
}

TEST(DiffuseLight, PowerIsPerPrimitiveAndSharedByTheSides) {
    const Parallelogram shape(Point3(0), {1, 0, 0}, {0, 2, 0}, {Vec3(0), Vec3(0, 0, 5)});
    const auto lights = MakeAreaLights(shape, {FloatParam("power", {10}), BoolParam("twosided", true)});
    ASSERT_EQ(lights.size(), 2u);
    for (const auto& light : lights) {
        EXPECT_NEAR(Radiance(*light, {0, 0, 1}, Point2(0), {0, 0, -1}), 10 / (2 * double(Pi) * 2), 1e-5);
        EXPECT_NEAR(light->Power(), 10, 1e-4);
    }
}

TEST(DiffuseLight, PowerOfAColourIsMultipliedByItsLuminance) {
    const Ball shape(Point3(0), 1);
    const auto lights = MakeAreaLights(shape, {FloatParam("power", {10}), FloatParam("L", {3, 3, 3}, "rgb")});
    EXPECT_NEAR(lights[0]->Power(), 30, 3e-3);
}

TEST(DiffuseLight, DensityIsThatOfItsSamples) {
    const Parallelogram shape({0, 0, 2}, {0, 1, 0}, {1, 0, 0});
    const auto lights = MakeAreaLights(shape, {});
    const LightReference ref(Point3(0.3f, 0.1f, -1));
    for (const float u : {0.1f, 0.5f, 0.9f}) {
        const auto sample = lights[0]->SampleLi(ref, {u, 0.3f}, Wavelengths());
        SurfaceInteraction hit;
        hit.p = sample->p;
        hit.n = sample->n;
        EXPECT_NEAR(lights[0]->PdfLi(ref, sample->wi, &hit), sample->pdf, 1e-5f * sample->pdf);
    }
}

TEST(DiffuseLight, AnInvisibleEmitterShinesAsADeltaLight) {
    const Parallelogram shape({-1, -1, 2}, {0, 2, 0}, {2, 0, 0});
    const Alpha zero(0, true);
    const auto visible = MakeAreaLights(shape, {}), invisible = MakeAreaLights(shape, {}, &zero);
    EXPECT_TRUE(invisible[0]->IsDelta());
    EXPECT_EQ(invisible[0]->SampleLi(LightReference(Point3(0)), Point2(0.5f), Wavelengths())->pdf, 1.f);
    EXPECT_NEAR(Illuminance(*invisible[0], Point3(0), {0, 0, 1}, 64),
                Illuminance(*visible[0], Point3(0), {0, 0, 1}, 64), 1e-5);
    SurfaceInteraction hit;
    EXPECT_EQ(invisible[0]->PdfLi(LightReference(Point3(0)), {0, 0, 1}, &hit), 0.f);
}

TEST(DiffuseLight, AlphaMasksThatShareOfTheEmission) {
    const Parallelogram shape({0, 0, 2}, {0, 1, 0}, {1, 0, 0});
    for (const bool isConstant : {true, false}) {
        const Alpha alpha(0.3f, isConstant);
        const auto lights = MakeAreaLights(shape, {}, &alpha);
        RunningMean mean;
        for (int i = 0; i < 100000; ++i)
            mean.Add(Radiance(*lights[0], {0, 0, 1}, Point2(0), {0, 0, 1}, Point3(float(i), 1, 2)));
        // Detects a share wrong by 0.008 (5 sigma). The hash is fixed: there is no seed to choose.
        EXPECT_GT(ZTest(mean, 0.3, 0, "share").pValue, 1e-4);
        EXPECT_LT(ZTest(mean, 0.31, 0, "negative control").pValue, 1e-4);
    }
}

TEST(DiffuseLight, ImagesAreUprightAndNormalised) {
    // Bottom left red, the rest white; v runs upward, rows run downward.
    const TemporaryImage image(".exr", {2, 2},
                               [](Int2 p) { return p == Int2(0, 1) ? RGB(1, 0, 0) : RGB(1); });
    const Parallelogram shape(Point3(0), {1, 0, 0}, {0, 1, 0});
    const auto lights =
        MakeAreaLights(shape, {StringParam("filename", image.Path()), FloatParam("scale", {2})});
    const auto luminance = [&](Point2 uv) {
        return LuminanceOf([&](const SampledWavelengths& l) {
            return lights[0]->L(Point3(0), {0, 0, 1}, uv, {0, 0, 1}, l);
        });
    };
    EXPECT_NEAR(luminance({0.1f, 0.1f}), 2 * 0.2126, 1e-2);
    EXPECT_NEAR(luminance({0.9f, 0.9f}), 2, 1e-3);
    EXPECT_NEAR(luminance({0.1f, 0.9f}), 2, 1e-3);
    const double mean = (3 + 0.2126) / 4;
    EXPECT_NEAR(lights[0]->Power(), double(Pi) * 2 * mean, 1e-3);
    const auto powered =
        MakeAreaLights(shape, {StringParam("filename", image.Path()), FloatParam("power", {7})});
    EXPECT_NEAR(powered[0]->Power(), 7, 1e-4);
    EXPECT_NEAR(Radiance(*powered[0], {0, 0, 1}, {0.9f, 0.9f}, {0, 0, 1}), 7 / (double(Pi) * mean), 1e-3);
}

/// Shapes leave out the surface parameters of light samples unless a light asks for them.
TEST(DiffuseLight, SamplesEmitWhatTheirPlaceDoes) {
    const TemporaryImage image(".exr", {4, 4}, [](Int2 p) { return RGB(1 + 2 * p.x, 1 + 3 * p.y, 2); });
    const HalfAlpha alpha;
    const LightReference ref(Point3(-5, 0.3f, 1));
    const auto sphere = MakeShape({"sphere", {}}),
               triangle = MakeShape({"trianglemesh", {Floats("point3", "P", {0, 1, 0, 0, -1, 0, 0, 0, 2})}});
    for (const Shape* shape : {sphere.get(), triangle.get()}) {
        const auto ofImage = MakeAreaLights(*shape, {StringParam("filename", image.Path())}),
                   masked = MakeAreaLights(*shape, {}, &alpha);
        Rng rng(SeedOf(FullTestName()));
        int bright = 0, dark = 0;
        for (int i = 0; i < 200; ++i) {
            const Point2 u = rng.Uniform2D();
            const auto sample = ofImage[0]->SampleLi(ref, u, Wavelengths());
            ASSERT_TRUE(sample);
            const Ray ray{ref.p, sample->wi};
            const auto hit = shape->Intersect(ray, 0, 100, 0);
            if (!hit) continue;  // by rounding, at the rim
            SurfaceInteraction si;
            shape->Interaction(ray, *hit, 0, &si);
            const SampledSpectrum expected = ofImage[0]->L(si.p, si.n, si.uv, -ray.d, Wavelengths());
            for (int k = 0; k < kNumWavelengths; ++k)
                EXPECT_NEAR(sample->L[k], expected[k], 2e-3f * expected[k]);
            if (std::abs(si.uv.x - 0.5f) < 1e-3f) continue;
            EXPECT_EQ(masked[0]->SampleLi(ref, u, Wavelengths()).has_value(), si.uv.x > 0.5f);
            ++(si.uv.x > 0.5f ? bright : dark);
        }
        EXPECT_GT(std::min(bright, dark), 20);
    }
}

TEST(DiffuseLight, RejectsContradictionsAndMissingFiles) {
    const Ball shape(Point3(0), 1);
    EXPECT_THROW(MakeAreaLights(shape, {FloatParam("L", {1, 1, 1}, "rgb"), StringParam("filename", "x.exr")}),
                 SceneError);
    EXPECT_THROW(MakeAreaLights(shape, {StringParam("filename", "/nowhere/x.exr")}), FileError);
    EXPECT_THROW(MakeAreaLights(shape, {FloatParam("power", {Infinity})}), SceneError);
    const TemporaryImage broken(".exr", {2, 2}, [](Int2 p) { return RGB(p.x ? NAN : 1.f); });
    EXPECT_THROW(MakeAreaLights(shape, {StringParam("filename", broken.Path())}), SceneError);
}

TEST(DiffuseLight, AShapeWithoutAreaStaysDark) {
    const Parallelogram shape(Point3(0), {1, 0, 0}, {1, 0, 0});
    const auto lights = MakeAreaLights(shape, {FloatParam("power", {10})});
    EXPECT_EQ(lights[0]->Power(), 0.f);
    EXPECT_FALSE(lights[0]->SampleLi(LightReference(Point3(0, 0, 1)), Point2(0.5f), Wavelengths()));
}

}  // namespace
}  // namespace lacquer::test::diffuse_test
