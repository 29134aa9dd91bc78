// The option "forcediffuse": every surface is matte, with the albedo of its material.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"

namespace lacquer::forced_diffuse_test {
namespace {

using test::CenterRadiance;
using test::FullTestName;
using test::Outcome;
using test::Passes;
using test::RunningMean;

constexpr double kAlpha = 1e-5;  // about ten runs in this file

/// A large disk in white surroundings, seen head-on. @param world  its material, and what that needs
RenderSetup Disk(const std::string& world, const std::string& integrator = "path", bool forced = true,
                 uint64_t seed = 1) {
    BuildOptions options;
    options.given.Set(&SceneOptions::forceDiffuse, forced);
    options.keepNames = true;
    options.given.Set(&SceneOptions::seed, int(seed % 1000003));
    return BuildScene(
        ParseText("Camera \"perspective\" \"float fov\" 2 Film \"rgb\" \"integer xresolution\" 48 \"integer "
                  "yresolution\" 48 "
                  "Sampler \"independent\" Integrator \"" +
                      integrator +
                      "\" WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1] LightSource \"distant\" " +
                      "\"point3 from\" [0 3 -4] \"point3 to\" [0 0 0] \"rgb L\" [2 2 2] Translate 0 0 5 " +
                      world + " ReverseOrientation Shape \"disk\" \"float radius\" 50",
                  "scene.pbrt", "", nullptr),
        options, nullptr);
}

/// Radiance of a matte surface of that albedo: 1 of the surroundings, and 2 cos / pi of the distant light.
double Expected(double albedo) { return albedo * (1 + 2 * 0.8 / double(Pi)); }

/// Power: the standard error is 0.4 % or less; an albedo that is off by 3 % is more than seven of them.
testing::AssertionResult HasAlbedo(const std::string& material, const std::string& integrator,
                                   double albedo) {
    const RenderSetup setup = Disk(material, integrator);
    const std::string name = FullTestName() + "/" + integrator + "/" + material;
    return Passes(name, kAlpha, [&](uint64_t seed) {
        return ZTest(CenterRadiance(setup, 20000, seed), Expected(albedo), 1e-4 * albedo, "radiance");
    });
}

/// Fresnel reflectance of index 1.5 at normal incidence, and what pbrt-v4 calls the albedo of such glass: its
/// transmitted radiance is divided by the square of the index.
constexpr double kFresnel = 0.04, kGlass = kFresnel + (1 - kFresnel) / 2.25;
const std::string kMirror =
    R"(Material "conductor" "spectrum eta" [300 1 900 1] "spectrum k" [300 4 900 4] )";
constexpr double kMirrorAlbedo = 16. / 20;  // k^2 / (4 + k^2)

TEST(ForcedDiffuse, SurfacesHaveTheAlbedoOfTheirMaterial) {
    EXPECT_TRUE(HasAlbedo(kMirror, "path", kMirrorAlbedo));
    EXPECT_TRUE(HasAlbedo(R"(Material "dielectric" "float eta" 1.5 )", "path", kGlass));
    EXPECT_TRUE(HasAlbedo(R"(Material "diffuse" "rgb reflectance" [.3 .3 .3] )", "path", 0.3));
    EXPECT_TRUE(HasAlbedo(R"(Material "diffusetransmission" )", "path", 0.5));
    EXPECT_TRUE(
        HasAlbedo(R"(Material "subsurface" "string name" "Skin1" "float eta" 1.5 )", "volpath", kGlass));
}

TEST(ForcedDiffuse, IntegratorsAgree) {
    for (const char* integrator : {"volpath", "simplepath"})
        EXPECT_TRUE(HasAlbedo(kMirror, integrator, kMirrorAlbedo)) << integrator;
    // Connections and light paths ask for the surface from both ends: the pixels' mean over the small image.
    EXPECT_TRUE(Passes(FullTestName() + "/bdpt", kAlpha, [&](uint64_t seed) {
        const RenderSetup setup = Disk(kMirror, "bdpt", true, seed);
        test::RenderAll(setup);
        return ZTest(test::PixelLuminance(*setup.film->Develop()), Expected(kMirrorAlbedo), 1e-3,
                     "luminance");
    }));
}

TEST(ForcedDiffuse, MixturesAreOfTheMatteMaterials) {
    const std::string mix =
        "MakeNamedMaterial \"a\" \"string type\" \"dielectric\" MakeNamedMaterial \"b\" \"string type\" "
        "\"diffuse\" "
        "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"a\" \"b\"] \"float "
        "amount\" ";
    EXPECT_TRUE(HasAlbedo(mix + "0 NamedMaterial \"m\" ", "path", kGlass));
    EXPECT_TRUE(HasAlbedo(mix + "1 NamedMaterial \"m\" ", "path", 0.5));
}

// The check finds both a material that is what it was and an albedo that is a few per cent off.
TEST(ForcedDiffuse, TheCheckNoticesOthers) {
    const RenderSetup mirror = Disk(kMirror, "path", false);
    const RunningMean plain = CenterRadiance(mirror, 20000);
    EXPECT_NEAR(plain.Mean(), kMirrorAlbedo, 1e-3);
    EXPECT_LT(ZTest(plain, Expected(kMirrorAlbedo), 0, "radiance").pValue, kAlpha);
    const RunningMean matte = CenterRadiance(Disk(kMirror), 20000);
    EXPECT_LT(ZTest(matte, Expected(1.03 * kMirrorAlbedo), 0, "radiance").pValue, kAlpha);
}

TEST(ForcedDiffuse, NamesAndInterfacesStay) {
    const RenderSetup setup =
        Disk("MakeNamedMaterial \"steel\" \"string type\" \"conductor\" NamedMaterial \"steel\" ");
    SurfaceInteraction si;
    ASSERT_TRUE(test::NearestHit(setup, {setup.renderFromWorld.Point({0, 0, 0}), {0, 0, 1}, 0}, &si));
    const auto& names = setup.scene->Names().materials;
    ASSERT_EQ(names.front().second, "steel");
    EXPECT_EQ(names.front().first, si.material);
    EXPECT_TRUE(Disk("Material \"interface\" ").scene->HasInterfaces());
}

}  // namespace
}  // namespace lacquer::forced_diffuse_test
