// The light "projection": where its image falls, its units, its bounds, and what it rejects.
#include "light_fixtures.h"
#include "support/statistics.h"

namespace lacquer::test::projection_test {
namespace {

constexpr Int2 kWide(32, 16), kTall(16, 32);

/// Luminance of what arrives at p, 0 if nothing does. For grey images.
double At(const Light& light, Point3 p) {
    const auto sample = light.SampleLi(LightReference(p), Point2(0.5f), Wavelengths());
    return sample ? double(sample->L[0]) / WhiteAt(Wavelengths()) : 0;
}
RGB White(Int2) { return RGB(1); }
/// Grey of a different brightness in each texel, 0.25 to 2.25.
RGB Noise(Int2 p) { return RGB(0.25f + 2 * UnitFloat(Hash(p.x, p.y))); }
std::unique_ptr<Light> MakeProjector(const TemporaryImage& imageFile, std::vector<Parameter> more = {},
                                     const Transform& renderFromLight = {}) {
    more.push_back(StringParam("filename", imageFile.Path()));
    return MakeLight("projection", std::move(more), renderFromLight);
}

TEST(ProjectionLight, TheImageIsUprightWithItsRightSideAtPlusX) {
    const TemporaryImage imageFile(
        ".exr", kWide, [](Int2 p) { return RGB((p.x < 16 ? 1.f : 2.f) * (p.y < 8 ? 1.f : 10.f)); });
    const auto light = MakeProjector(imageFile);
    // Times the square of the distance, 1.5.
    EXPECT_NEAR(At(*light, {-0.5f, 0.5f, 1}) * 1.5, 1, 1e-4);
    EXPECT_NEAR(At(*light, {0.5f, 0.5f, 1}) * 1.5, 2, 1e-4);
    EXPECT_NEAR(At(*light, {-0.5f, -0.5f, 1}) * 1.5, 10, 1e-3);
    EXPECT_NEAR(At(*light, {0.5f, -0.5f, 1}) * 1.5, 20, 1e-3);
}

TEST(ProjectionLight, FovSpansTheShorterAxis) {
    const float t = std::tan(Radians(30));
    for (const Int2 size : {kWide, kTall}) {
        const TemporaryImage imageFile(".exr", size, White);
        const auto light = MakeProjector(imageFile, {FloatParam("fov", {60})});
        const Vec2 half = size == kWide ? Vec2(2 * t, t) : Vec2(t, 2 * t);
        for (const float side : {-1.f, 1.f}) {
            EXPECT_GT(At(*light, {side * 0.999f * half.x, 0, 1}), 0);
            EXPECT_EQ(At(*light, {side * 1.001f * half.x, 0, 1}), 0);
            EXPECT_GT(At(*light, {0, side * 0.999f * half.y, 1}), 0);
            EXPECT_EQ(At(*light, {0, side * 1.001f * half.y, 1}), 0);
        }
        EXPECT_EQ(At(*light, {0, 0, -1}), 0);
        EXPECT_EQ(At(*light, {1, 0, 0}), 0);
        EXPECT_FALSE(light->SampleLi(LightReference(Point3(0)), Point2(0), Wavelengths()));
    }
}

TEST(ProjectionLight, FollowsTheInverseSquareLaw) {
    const TemporaryImage imageFile(".exr", {1, 1}, White);
    const auto light = MakeProjector(imageFile, {FloatParam("scale", {3})});
    for (const float d : {0.5f, 1.f, 4.f, 1000.f})
        EXPECT_NEAR(At(*light, {0, 0, d}) * double(d * d), 3, 1e-4);
    const LightReference ref(Point3(0, 0, 2));
    const auto sample = light->SampleLi(ref, Point2(0), Wavelengths());
    EXPECT_EQ(sample->wi, Vec3(0, 0, -1));
    EXPECT_EQ(sample->p, Point3(0));
    EXPECT_EQ(sample->pdf, 1.f);
    EXPECT_EQ(light->PdfLi(ref, sample->wi, nullptr), 0.f);
}

TEST(ProjectionLight, EmitsTheGivenPower) {
    for (const Int2 size : {kWide, kTall})
        for (const float fov : {20.f, 90.f}) {
            const TemporaryImage imageFile(".exr", size, Noise);
            const auto light =
                MakeProjector(imageFile, {FloatParam("power", {50}), FloatParam("fov", {fov})});
            EXPECT_NEAR(light->Power(), 50, 1e-3);
            // Midpoints on the sphere: the edge of the smaller image, 200 x 400 cells, cuts one cell in
            // 130. cos^3 at the centres of texels: h^2/24 times the sum of its second derivatives, -6 on the
            // axis and less elsewhere, with h = 1/8 in the larger image: 4e-3 at most.
            const double flux = SphereIntegral(2048, [&](Vec3 w) { return At(*light, w); });
            EXPECT_NEAR(flux, 50, 0.25) << fov;
        }
}

TEST(ProjectionLight, PowerOfWhiteIsTheSolidAngleOfTheImage) {
    const TemporaryImage imageFile(".exr", {64, 64}, White);
    // A square pyramid of apex angle a: 4 asin(sin^2(a/2)).
    for (const double deg : {1., 40., 90., 120.}) {
        const double s = std::sin(deg / 2 * double(Pi) / 180);
        const double power = double(MakeProjector(imageFile, {FloatParam("fov", {float(deg)})})->Power());
        EXPECT_NEAR(power / (4 * std::asin(s * s)), 1, 1e-3) << deg;
    }
    EXPECT_NEAR(MakeProjector(imageFile, {FloatParam("power", {0}), FloatParam("scale", {2})})->Power(),
                2 * 4 * std::asin(0.5), 4e-3);
}

TEST(ProjectionLight, ColoursAreIlluminantsOfTheImagesSpace) {
    const std::string path = (std::filesystem::temp_directory_path() / (FullTestName() + ".exr")).string();
    for (const char* name : {"srgb", "aces2065-1"}) {
        const ColorSpace& space = *ColorSpace::Find(name);
        const RGB rgb(0.3f, 0.6f, 0.2f);
        Image image({1, 1}, {"R", "G", "B"});
        for (int c = 0; c < 3; ++c) image.Set({0, 0}, c, rgb[c]);
        image.SetColorSpace(&space);
        WriteImage(image, path);
        const auto light = MakeLight("projection", {StringParam("filename", path)});
        double largest = 0;
        for (const float u : {0.1f, 0.4f, 0.7f}) {
            const auto lambda = SampledWavelengths::SampleVisible(u);
            const auto sample = light->SampleLi(LightReference(Point3(0, 0, 2)), Point2(0), lambda);
            const SampledSpectrum expected =
                space.MakeSpectrum(rgb, SpectrumKind::Illuminant)->Sample(lambda) / (4 * kCieYIntegral);
            ASSERT_TRUE(sample);
            for (int lane = 0; lane < 4; ++lane)
                largest = std::max(largest, double(std::abs(sample->L[lane] / expected[lane] - 1)));
        }
        EXPECT_LT(largest, 1e-4) << name;
    }
    std::filesystem::remove(path);
}

TEST(ProjectionLight, FollowsItsTransformButNotItsScale) {
    const TemporaryImage imageFile(".exr", kWide, White);
    const auto light = MakeProjector(
        imageFile, {},
        Transform::Translate({0, 10, 0}) * Transform::Rotate(90, {1, 0, 0}) * Transform::Scale(Vec3(1e-4f)));
    // +z turned by 90 degrees about x is -y.
    EXPECT_NEAR(At(*light, {0, 8, 0}), 0.25, 1e-5);
    EXPECT_EQ(At(*light, {0, 12, 0}), 0);
}

/// Points in the light of random projectors at which the light sampler never draws them.
/// @param turn  by which the projectors differ from what the sampler was told
int NumMissed(uint64_t seed, const Transform& turn, int* numLit) {
    const TemporaryImage imageFile(".exr", kWide, White);
    Rng rng(seed);
    const auto vector = [&](float size) {
        return size * (2.f * Vec3(rng.Uniform(), rng.Uniform(), rng.Uniform()) - Vec3(1));
    };
    int numMissed = 0;
    *numLit = 0;
    for (int i = 0; i < 100; ++i) {
        const float fov = 2 + 160 * rng.Uniform(), t = std::tan(Radians(fov) / 2);
        // Half of the transforms shear and mirror.
        const Transform told =
            Transform::Translate(vector(3)) * Transform::Rotate(360 * rng.Uniform(), vector(1)) *
            Transform::Scale(i % 2 ? vector(3) : Vec3(1)) * Transform::Rotate(360 * rng.Uniform(), vector(1));
        const auto light = MakeProjector(imageFile, {FloatParam("fov", {fov})}, told * turn);
        const auto known = MakeProjector(imageFile, {FloatParam("fov", {fov})}, told);
        const auto other = MakeLight("point", {});
        const std::vector<const Light*> lights = {known.get(), other.get()};
        const auto sampler = Registry<LightSamplerKind>::Find("bvh")(lights);
        for (int k = 0; k < 100; ++k) {
            // Every second point near an edge.
            Vec3 inLight(1.998f * (rng.Uniform2D() - Point2(0.5f)), 1);
            if (k % 2) inLight[k / 2 % 2] = k % 8 < 4 ? -0.999f : 0.999f;
            inLight *= Vec3(2 * t, t, 1);
            const LightReference ref((told * turn).Point(5 * rng.Uniform() * inLight));
            if (!(At(*light, ref.p) > 0)) continue;
            ++*numLit;
            numMissed += !(sampler->Pmf(ref, known.get()) > 0);
        }
    }
    return numMissed;
}

TEST(ProjectionLight, BoundsHoldAllOfItsLight) {
    int numLit = 0;
    EXPECT_EQ(NumMissed(SeedOf(FullTestName()), {}, &numLit), 0);
    EXPECT_GT(numLit, 9000);  // of 10,000; rounding at the edge takes some
    // Projectors that look 15 degrees past what their bounds say, along the longer axis. Its edge lies at
    // most 3.2 degrees inside of the cone around the corners, and the sampler allows for 5.8 more. An eighth
    // of the points is there; it is found where the cone is narrower than half a sphere and not squeezed too
    // much.
    EXPECT_GT(NumMissed(SeedOf(FullTestName()), Transform::Rotate(15, {0, 1, 0}), &numLit), 300);
}

TEST(ProjectionLight, BoundsAreTighterThanAllDirections) {
    const TemporaryImage imageFile(".exr", kWide, White);
    const auto bounds = MakeProjector(imageFile, {FloatParam("fov", {20})})->Bounds();
    ASSERT_TRUE(bounds);
    const double t = std::tan(10 * double(Pi) / 180);
    EXPECT_NEAR(bounds->cosTheta_o, 1 / std::sqrt(1 + 5 * t * t), 1e-5);
    EXPECT_NEAR(bounds->axis.z, 1, 1e-6);
}

/// What MakeLight() says is wrong.
std::string ErrorOf(std::vector<Parameter> parameters) {
    try {
        MakeLight("projection", std::move(parameters));
    } catch (const std::exception& e) {
        return e.what();
    }
    return "";
}

TEST(ProjectionLight, MistakesAreSaid) {
    const auto of = [](float value) {
        return TemporaryImage(".exr", kWide, [value](Int2) { return RGB(value); });
    };
    const auto says = [](const TemporaryImage& imageFile, const char* part,
                         std::vector<Parameter> more = {}) {
        more.push_back(StringParam("filename", imageFile.Path()));
        const std::string error = ErrorOf(std::move(more));
        EXPECT_NE(error.find(part), std::string::npos) << error;
    };
    EXPECT_NE(ErrorOf({}).find("needs \"string filename\""), std::string::npos);
    says(of(NAN), "pixel (0, 0) is not a finite number");
    says(of(0), "the image is black: no scale gives this light a power", {FloatParam("power", {1})});
    says(of(1), "scale", {FloatParam("scale", {-1})});
    says(of(1e30f), "must be finite", {FloatParam("scale", {1e30f})});
    for (const float fov : {0.f, -5.f, 180.f, 1e9f})
        says(of(1), "degrees; it must lie between 0 and 180", {FloatParam("fov", {fov})});
    // The narrowest and the widest angle below the limits have no infinite values.
    for (const float fov : {1e-30f, 179.9999f}) {
        const TemporaryImage imageFile(".exr", kWide, White);
        const auto light = MakeProjector(imageFile, {FloatParam("fov", {fov})});
        EXPECT_TRUE(std::isfinite(light->Power()));
        EXPECT_TRUE(std::isfinite(At(*light, {0, 0, 1})));
        EXPECT_TRUE(std::isfinite(At(*light, {1, 1, 1e-6f})));
    }
}

}  // namespace
}  // namespace lacquer::test::projection_test
