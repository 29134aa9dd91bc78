// Rays that begin at lights: their density, what they carry, and that together they carry the light's power.
#include "light_fixtures.h"
#include "support/statistics.h"

namespace lacquer::test::emitted_rays_test {
namespace {

constexpr double kAlpha = 1e-5;
const Bounds3 kScene(Point3(-1, -2, -1), Point3(2, 1, 3));

struct EmitterCase {
    std::string name;
    std::shared_ptr<Light> light;
    bool keepsPower = true;  ///< Power() is the flux, and no guess
};

std::string ImageFile() {
    const std::string path = testing::TempDir() + "/emitted_rays.pfm";
    Image image(Int2(8, 8), {"R", "G", "B"});
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
            for (int c = 0; c < 3; ++c) image.Set({x, y}, c, float((x * 3 + y * 5) % 7) + 0.5f);
    WriteImage(image, path, false);
    return path;
}

std::vector<EmitterCase> Emitters() {
    const Parameter from = FloatParam("from", {0.1f, 0.2f, 0.3f}, "point3");
    const Parameter imageFile = StringParam("filename", ImageFile());
    const Transform turned = Transform::Translate({1, 2, 3}) * Transform::Rotate(40, {1, 2, 3});
    std::vector<EmitterCase> cases;
    const auto add = [&](const std::string& name, std::unique_ptr<Light> light, bool keepsPower = true) {
        light->Preprocess(kScene);
        cases.push_back({name, std::move(light), keepsPower});
    };
    add("point", MakeLight("point", {from}));
    add("spot", MakeLight("spot", {from}, turned));
    add("wide spot", MakeLight("spot", {FloatParam("coneangle", {170}), FloatParam("conedeltaangle", {60})}));
    // A squeezed cone is no cone of the power that its light states.
    add("squeezed spot", MakeLight("spot", {from}, Transform::Scale({1, 3, 2})), false);
    add("distant", MakeLight("distant", {from}));
    add("uniform infinite", MakeLight("infinite", {}));
    add("image infinite", MakeLight("infinite", {imageFile}, turned));
    add("squeezed image infinite", MakeLight("infinite", {imageFile}, Transform::Scale({1, 3, 2})), false);
    add("portal", MakeLight("infinite", {imageFile, FloatParam("portal", {0, 0, 0, 0, 1, 0, 2, 1, 0, 2, 0, 0},
                                                               "point3")}));
    add("goniometric", MakeLight("goniometric", {imageFile}, turned));
    // Power() counts each texel with the solid angle at its centre: 8 x 8 texels over 90 degrees miss 0.3 %.
    add("projection", MakeLight("projection", {imageFile, FloatParam("fov", {40})}, turned));
    static const Parallelogram plane({0, 0, 0}, {1, 0, 0}, {0.5f, 2, 0});
    add("area", std::move(MakeAreaLights(plane, {})[0]));
    add("two-sided area", std::move(MakeAreaLights(plane, {BoolParam("twosided", true)})[0]));
    return cases;
}

float Uniform(Rng& rng) { return rng.Uniform(); }
std::optional<LightEmission> Draw(const Light& light, Rng& rng) {
    const Point2 a(Uniform(rng), Uniform(rng)), b(Uniform(rng), Uniform(rng));
    return light.SampleLe(a, b, Wavelengths());
}

TEST(EmittedRays, HaveTheDensityThatTheLightStates) {
    for (const EmitterCase& c : Emitters()) {
        Rng rng(SeedOf(c.name));
        int drawn = 0;
        for (int i = 0; i < 500; ++i) {
            const auto e = Draw(*c.light, rng);
            if (!e) continue;
            ++drawn;
            const EmissionDensity pdf = c.light->PdfLe(e->n, e->w);
            EXPECT_NEAR(pdf.position, e->pdfPosition, 1e-3f * e->pdfPosition) << c.name;
            EXPECT_NEAR(pdf.direction, e->pdfDirection, 2e-3f * e->pdfDirection) << c.name;
        }
        EXPECT_GT(drawn, 400) << c.name;
    }
}

TEST(EmittedRays, CarryWhatTheLightSendsThatWay) {
    for (const EmitterCase& c : Emitters()) {
        Rng rng(SeedOf(c.name));
        int wrong = 0;
        for (int i = 0; i < 500; ++i) {
            const auto e = Draw(*c.light, rng);
            if (!e) continue;
            float expected = 0;
            if (e->n != Normal3(0)) {
                expected = c.light->L(e->p, e->n, e->uv, e->w, Wavelengths())[0];
            } else if (c.light->IsInfinite()) {
                // From a point in front of the portal, or anywhere.
                const Point3 beyond = c.name == "portal" ? e->p + 8.f * e->w : Point3(0);
                expected = c.light->Le({beyond, -e->w, 0}, Wavelengths())[0];
                if (c.name == "portal" && expected == 0) continue;  // not yet through the portal
            } else {
                const auto seen =
                    c.light->SampleLi(LightReference(e->p + 3.f * e->w), Point2(0.5f), Wavelengths());
                if (seen)
                    expected = seen->L[0] * (c.light->GetKind() == Light::Kind::DeltaPosition ? 9.f : 1.f);
            }
            // Directions within rounding of a texel's edge may fall to either side.
            wrong += std::abs(expected - e->L[0]) > 1e-3f * e->L[0];
        }
        EXPECT_LE(wrong, 2) << c.name;
    }
}

/// Mean flux of the rays, over Power().
Outcome Flux(const EmitterCase& c, double scale, uint64_t seed) {
    Rng rng(seed);
    RunningMean mean;
    for (int i = 0; i < 20000; ++i) {
        const auto e = Draw(*c.light, rng);
        double flux = 0;
        if (e) {
            const float cosine = e->n == Normal3(0) ? 1.f : AbsDot(e->n, e->w);
            flux = double(e->L[0] * cosine / (e->pdfPosition * e->pdfDirection)) / WhiteAt(Wavelengths());
        }
        mean.Add(scale * flux / double(c.light->Power()));
    }
    // Images are grey: one wavelength tells all. The bias is that of projection lights' Power().
    return ZTest(mean, 1, 2e-3, c.name);
}

// Power: the standard errors lie between 0 (uniform lights) and 0.6 % (images); an error of 5 % is 8 of them.
TEST(EmittedRays, CarryThePowerOfTheLight) {
    for (const EmitterCase& c : Emitters()) {
        if (!c.keepsPower) continue;
        EXPECT_TRUE(Passes(FullTestName() + c.name, kAlpha, [&](uint64_t seed) { return Flux(c, 1, seed); }));
        EXPECT_LT(Flux(c, 1.05, SeedOf(c.name)).pValue, kAlpha) << c.name;
    }
}

/// Integral of the density of directions over the sphere, by rays' own draws against a uniform grid.
TEST(EmittedRays, DensitiesOfDirectionsIntegrateToOne) {
    for (const EmitterCase& c : Emitters()) {
        if (c.light->GetKind() == Light::Kind::DeltaDirection) continue;
        const double integral = SphereIntegral(
            300, [&](Vec3 w) { return double(c.light->PdfLe(Normal3(0, 0, 1), w).direction); });
        // The rims of cones and texels cross the cells of the grid.
        EXPECT_NEAR(integral, 1, 0.01) << c.name;
    }
}

}  // namespace
}  // namespace lacquer::test::emitted_rays_test
