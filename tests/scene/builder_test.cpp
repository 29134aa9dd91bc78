#include "pbrt/scene/builder.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <fmt/format.h>

#include "pbrt/core/parallel.h"
#include "scene/scene_text.h"
#include "support/scene_parts.h"

namespace lacquer::builder_test {
namespace {

using test::BuildErrorsOf;
using test::BuildText;
using test::WarningList;

const std::string kSmall = "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 ";

bool Contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}
size_t Lines(const std::string& text) {
    return text.empty() ? 0 : size_t(std::count(text.begin(), text.end(), '\n')) + (text.back() != '\n');
}

/// Distance from a point to the first surface in a direction; infinity if there is none.
float Distance(const RenderSetup& setup, Point3 world, Vec3 d) {
    const Ray ray{setup.renderFromWorld.Point(world), setup.renderFromWorld.Vector(d), 0};
    SurfaceInteraction si;
    return test::NearestHit(setup, ray, &si) ? Length(si.p - ray.o) : Infinity;
}

TEST(Builder, MakesEverythingThatARenderNeeds) {
    const RenderSetup setup = BuildText(kSmall + "WorldBegin LightSource \"point\" Shape \"sphere\"");
    ASSERT_TRUE(setup.scene && setup.film && setup.sampler && setup.integrator);
    EXPECT_EQ(setup.film->Resolution(), Int2(4, 4));
    EXPECT_EQ(setup.scene->Resolution(), Int2(4, 4));
    EXPECT_EQ(setup.scene->Lights().size(), 1u);
    EXPECT_EQ(setup.scene->NumPrimitives(), 1);
    EXPECT_GT(setup.scene->GeometryBytes(), 0u);
    // The defaults of the format.
    EXPECT_EQ(setup.sampler->SamplesPerPixel(), 16);
    EXPECT_EQ(setup.film->Filter().Radius(), Vec2(1.5f));
}

TEST(Builder, UnknownNamesAreNamedWithTheNearest) {
    struct Case {
        std::string text, message;
    };
    for (const Case& c : {
             Case{"Camera \"perspectve\" WorldBegin",
                  "1:1: error: unknown camera \"perspectve\"; did you mean \"perspective\"?"},
             Case{"Film \"rbg\" WorldBegin", "unknown film \"rbg\"; did you mean \"rgb\"?"},
             Case{"Sampler \"zsobel\" WorldBegin", "unknown sampler \"zsobel\"; did you mean \"zsobol\"?"},
             Case{"PixelFilter \"gausian\" WorldBegin",
                  "unknown pixel filter \"gausian\"; did you mean \"gaussian\"?"},
             Case{"Integrator \"paht\" WorldBegin", "unknown integrator \"paht\"; did you mean \"path\"?"},
             Case{"Accelerator \"bhv\" WorldBegin", "unknown accelerator \"bhv\"; did you mean \"bvh\"?"},
             Case{"WorldBegin LightSource \"pont\"",
                  "1:12: error: unknown light \"pont\"; did you mean \"point\"?"},
             Case{"WorldBegin AreaLightSource \"diffus\" Shape \"sphere\"",
                  "unknown area light \"diffus\"; did you mean \"diffuse\"?"},
             Case{"WorldBegin Material \"diffse\"", "unknown material \"diffse\"; did you mean \"diffuse\"?"},
             Case{"WorldBegin Texture \"a\" \"float\" \"imagmap\"",
                  "unknown float texture \"imagmap\"; did you mean \"imagemap\"?"},
             Case{"WorldBegin Texture \"a\" \"spectrum\" \"marbel\"",
                  "unknown spectrum texture \"marbel\"; did you mean \"marble\"?"},
             Case{"WorldBegin Shape \"shpere\"", "unknown shape \"shpere\"; did you mean \"sphere\"?"},
             Case{"WorldBegin Shape \"icosahedron\"", "unknown shape \"icosahedron\""},
             Case{"Integrator \"path\" \"string lightsampler\" \"bhv\" WorldBegin", "did you mean \"bvh\"?"},
         }) {
        const std::string errors = BuildErrorsOf(c.text);
        EXPECT_TRUE(Contains(errors, c.message)) << c.text << "\nsays: " << errors;
        EXPECT_TRUE(Contains(errors, "scene.pbrt:1:")) << errors;
        EXPECT_EQ(Lines(errors), 1u) << errors;
    }
}

TEST(Builder, ReportsSeveralMistakesTogetherInFileOrder) {
    const std::string errors = BuildErrorsOf(
        "Film \"rgb\" \"integer xresolution\" 0\nSampler \"sobool\"\nIntegrator \"paht\"\n"
        "WorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [2 0 0]\n"
        "LightSource \"point\" \"float pover\" 3\nShape \"sphere\" \"float radus\" 2\n"
        "Texture \"unused\" \"float\" \"dotz\"\n");
    EXPECT_EQ(Lines(errors), 7u) << errors;
    size_t last = 0;
    for (const std::string line : {"1:", "2:", "3:", "5:", "6:", "7:", "8:"}) {
        const size_t at = errors.find("scene.pbrt:" + line);
        ASSERT_NE(at, std::string::npos) << line << "\n" << errors;
        EXPECT_GE(at, last) << errors;
        last = at;
    }
}

/// Shapes with a warning each, meshes of files, and lights; some of them wrong.
std::string ManyPlugins(const test::TestFolder& folder, bool withMistakes) {
    std::string text = kSmall + "WorldBegin\n";
    for (int i = 0; i < 200; ++i) {
        const std::string file = fmt::format("{}.ply", i % 40);
        folder.Write(
            file,
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0 1 0 0 0 1 0 0 0 1\n3 0 1 2 2 0 1\n");
        text += fmt::format("Shape \"plymesh\" \"string filename\" \"{}\"\n", folder.Path(file));
        text += "Shape \"loopsubdiv\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2 0 0 1]\n";
        for (int k = 0; k < 25; ++k)  // more than are made together
            text += fmt::format("LightSource \"point\" \"rgb I\" [{} 1 1]\n", 25 * i + k);
        if (withMistakes && i % 20 == 7) text += "Shape \"sphere\" \"float radus\" 2\n";
        if (withMistakes && i % 50 == 9) text += "LightSource \"point\" \"float power\" [1 2]\n";
    }
    return text;
}

TEST(Builder, SaysAndMakesTheSameWhateverTheThreads) {
    const test::TestFolder folder;
    const std::string text = ManyPlugins(folder, false);
    struct Said {
        std::string warnings;
        std::vector<std::pair<std::string, int>> files;  // and the lines that name them
        std::vector<float> powers;
        bool operator==(const Said&) const = default;
    };
    const auto build = [&](int threads) {
        const ThreadLimit limit(threads);
        WarningList warnings;
        const RenderSetup setup = BuildText(text, &warnings);
        EXPECT_EQ(setup.scene->NumPrimitives(), 200 * (1 + 64));
        Said said{warnings.text, {}, {}};
        for (const FileUse& use : setup.files) said.files.emplace_back(use.path, use.loc.line);
        for (const auto& light : setup.scene->Lights()) said.powers.push_back(light->Power());
        return said;
    };
    const Said alone = build(1);
    EXPECT_EQ(Lines(alone.warnings), 400u);
    ASSERT_EQ(alone.files.size(), 200u);
    EXPECT_TRUE(std::is_sorted(alone.files.begin(), alone.files.end(),
                               [](const auto& a, const auto& b) { return a.second < b.second; }));
    EXPECT_TRUE(std::is_sorted(alone.powers.begin(), alone.powers.end()));
    for (int i = 0; i < 5; ++i) EXPECT_TRUE(build(7) == alone) << i;
}

TEST(Builder, ReportsMistakesInFileOrderWhateverTheThreads) {
    const test::TestFolder folder;
    const std::string text = ManyPlugins(folder, true);
    const auto errors = [&](int threads) {
        const ThreadLimit limit(threads);
        return BuildErrorsOf(text);
    };
    const std::string alone = errors(1);
    EXPECT_EQ(Lines(alone), 14u) << alone;
    for (int i = 0; i < 5; ++i) EXPECT_EQ(errors(7), alone);
}

TEST(Builder, SaysOneMistakeOnceHoweverOftenItIsUsed) {
    const std::string errors = BuildErrorsOf(
        "WorldBegin Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [-1 0 0] Material \"diffuse\" "
        "\"texture reflectance\" \"a\" "
        "Shape \"sphere\" Shape \"disk\" Material \"diffuse\" \"texture reflectance\" \"a\" Shape \"disk\"");
    EXPECT_EQ(Lines(errors), 1u) << errors;
}

TEST(Builder, StopsAfterTwentyMistakes) {
    std::string text = "WorldBegin\n";
    for (int i = 0; i < 50; ++i) text += "Shape \"sphere\" \"float radius\" -1\n";
    const std::string errors = BuildErrorsOf(text);
    EXPECT_EQ(Lines(errors), 21u);
    EXPECT_TRUE(errors.ends_with("error: stopped after 20 errors")) << errors;
}

TEST(Builder, UnusedParametersSayWhatWasMeant) {
    for (const auto& [text, part] : {
             std::pair<std::string, std::string>("WorldBegin Shape \"sphere\" \"float radus\" 2",
                                                 "\"float radus\""),
             {"WorldBegin Shape \"sphere\" \"integer radius\" 2", "\"float radius\""},
             {"WorldBegin Material \"diffuse\" \"float reflectance\" 0.5", "reflectance"},
             {"WorldBegin LightSource \"infinite\" \"float power\" 3", "\"float power\""},
             {"Camera \"perspective\" \"float fovv\" 3 WorldBegin", "did you mean"},
             {"Sampler \"stratified\" \"integer pixelsamples\" 3 WorldBegin", "pixelsamples"},
             {"Accelerator \"bvh\" \"integer maxprim\" 3 WorldBegin", "maxprim"},
         }) {
        const std::string errors = BuildErrorsOf(text);
        EXPECT_TRUE(Contains(errors, part)) << text << "\nsays: " << errors;
        EXPECT_EQ(Lines(errors), 1u) << errors;
    }
    EXPECT_EQ(BuildErrorsOf(kSmall + "Accelerator \"kdtree\" \"integer maxprims\" 3 WorldBegin"), "");
    EXPECT_EQ(
        BuildErrorsOf(kSmall +
                      "WorldBegin Attribute \"shape\" \"float radius\" 3 Shape \"trianglemesh\" \"point3 P\" "
                      "[0 0 0 1 0 0 0 1 0]"),
        "");
}

TEST(Builder, AttributesThatNothingReadsAreTold) {
    const auto warnings = [](const std::string& world) {
        WarningList list;
        BuildText(kSmall + "WorldBegin " + world, &list);
        return list.text;
    };
    const std::string light = "LightSource \"point\" ", two = "Shape \"sphere\" Shape \"disk\" ";
    const std::string misspelt = warnings("Attribute \"light\" \"string gruop\" \"key\" " + light + light);
    EXPECT_EQ(Lines(misspelt), 1u) << misspelt;
    EXPECT_TRUE(Contains(misspelt, "no parameter \"string gruop\"; did you mean \"group\"?")) << misspelt;
    EXPECT_TRUE(
        Contains(warnings("Attribute \"light\" \"float group\" 3 " + light), "expects \"string group\""));
    // What one of several reads is no mistake, nor what nothing was there to read.
    for (const std::string& fine :
         {"Attribute \"light\" \"string group\" \"key\" " + light,
          "Attribute \"shape\" \"float height\" 3 " + two,
          "Attribute \"light\" \"string gruop\" \"key\" " + two,
          "Attribute \"light\" \"string group\" \"key\" " + light + "\"string group\" \"fill\""})
        EXPECT_EQ(warnings(fine), "") << fine;
}

TEST(Builder, UnusedTexturesAreCheckedToo) {
    EXPECT_TRUE(Contains(BuildErrorsOf("WorldBegin Texture \"a\" \"float\" \"constant\" \"float valeu\" 3"),
                         "valeu"));
}

TEST(Builder, EmittersThatNoShapeTakesAreCheckedToo) {
    EXPECT_TRUE(
        Contains(BuildErrorsOf("WorldBegin AreaLightSource \"bogus\""), "unknown area light \"bogus\""));
    EXPECT_TRUE(Contains(BuildErrorsOf("WorldBegin AreaLightSource \"diffuse\" \"float x\" 3"),
                         "no parameter \"float x\""));
    EXPECT_EQ(BuildErrorsOf("WorldBegin AreaLightSource \"diffuse\" \"rgb L\" [1 2 3]"), "");
}

TEST(Builder, TexturesMayBeUsedBeforeTheyAreDefinedButNotInCircles) {
    EXPECT_EQ(BuildErrorsOf(kSmall + "WorldBegin Texture \"a\" \"float\" \"scale\" \"texture tex\" \"b\" "
                                     "Texture \"b\" \"float\" \"constant\" \"float value\" 3"),
              "");
    for (const std::string circle : {
             "Texture \"a\" \"float\" \"scale\" \"texture tex\" \"a\"",
             "Texture \"a\" \"float\" \"scale\" \"texture tex\" \"b\" Texture \"b\" \"float\" \"mix\" "
             "\"texture tex1\" \"a\"",
             "Texture \"a\" \"spectrum\" \"scale\" \"texture tex\" \"b\" Texture \"b\" \"spectrum\" "
             "\"scale\" \"texture tex\" \"a\" "
             "Material \"diffuse\" \"texture reflectance\" \"b\"",
         })
        EXPECT_TRUE(Contains(BuildErrorsOf("WorldBegin " + std::string(circle)), "depends on itself"))
            << circle;
    // The two namespaces are separate: a float and a spectrum texture of one name make no circle.
    EXPECT_EQ(
        BuildErrorsOf(kSmall +
                      "WorldBegin Texture \"a\" \"float\" \"constant\" Texture \"a\" \"spectrum\" \"mix\" "
                      "\"texture amount\" \"a\""),
        "");
}

TEST(Builder, TexturesOfTheWrongTypeOrNameAreExplained) {
    const std::string texture = "WorldBegin Texture \"stripes\" \"float\" \"constant\" ";
    EXPECT_TRUE(
        Contains(BuildErrorsOf(texture + "Material \"diffuse\" \"texture reflectance\" \"stripes\""),
                 "texture \"stripes\" is not a spectrum texture; a spectrum texture is expected here"));
    EXPECT_TRUE(Contains(BuildErrorsOf(texture + "Material \"diffuse\" \"texture displacement\" \"strips\""),
                         "there is no float texture \"strips\"; did you mean \"stripes\"?"));
}

TEST(Builder, SpectrumTexturesAreCheckedForTheirUse) {
    const std::string bright =
        kSmall + "WorldBegin Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [3 2 2] ";
    EXPECT_EQ(BuildErrorsOf(bright), "");
    EXPECT_EQ(BuildErrorsOf(bright + "Material \"conductor\" \"texture eta\" \"a\" \"texture k\" \"a\""), "");
    EXPECT_NE(BuildErrorsOf(bright + "Material \"diffuse\" \"texture reflectance\" \"a\""), "");
}

TEST(Builder, InstancesKeepTheTransformOfTheDefinition) {
    // World point = CTM of the instance * CTM of the definition * p.
    const RenderSetup setup = BuildText(
        kSmall +
        "WorldBegin Translate 0 0 10 ObjectBegin \"ball\" Scale 2 2 2 Shape \"sphere\" ObjectEnd "
        "Identity Translate 5 0 0 ObjectInstance \"ball\" Identity Rotate 180 0 1 0 ObjectInstance \"ball\"");
    EXPECT_NEAR(Distance(setup, {5, 0, 0}, {0, 0, 1}), 8, 1e-4f);
    EXPECT_NEAR(Distance(setup, {0, 0, 0}, {0, 0, -1}), 8, 1e-4f);
    EXPECT_EQ(Distance(setup, {0, 0, 0}, {0, 0, 1}), Infinity);
    // One definition, however many instances.
    EXPECT_EQ(setup.scene->NumPrimitives(), 1);
}

TEST(Builder, DefinitionsWithoutInstancesAreNotSeen) {
    const RenderSetup setup =
        BuildText(kSmall + "WorldBegin ObjectBegin \"ball\" Shape \"sphere\" ObjectEnd");
    EXPECT_EQ(Distance(setup, {0, 0, -5}, {0, 0, 1}), Infinity);
    // And instances of nothing are no mistake.
    EXPECT_EQ(BuildErrorsOf(kSmall + "WorldBegin ObjectBegin \"none\" ObjectEnd ObjectInstance \"none\""),
              "");
}

TEST(Builder, InstancesShowTheirNormalsAndMaterialsInTheWorld) {
    const RenderSetup setup = BuildText(kSmall +
                                        "WorldBegin ObjectBegin \"tile\" Shape \"disk\" ObjectEnd Scale -1 1 "
                                        "3 Rotate 60 0 1 0 Scale 1 1 0.5 ObjectInstance \"tile\"");
    const Transform t =
        Transform::Scale({-1, 1, 3}) * Transform::Rotate(60, {0, 1, 0}) * Transform::Scale({1, 1, 0.5f});
    SurfaceInteraction si;
    const Point3 from = setup.renderFromWorld.Point(t.Point({0.2f, 0.1f, 2}));
    const Vec3 d = Normalize(t.Vector({0, 0, -1}));
    ASSERT_TRUE(test::NearestHit(setup, {from, d, 0}, &si));
    EXPECT_LT(Length(si.p - setup.renderFromWorld.Point(t.Point({0.2f, 0.1f, 0}))), 1e-5f);
    EXPECT_NEAR(std::abs(Dot(si.n, Normalize(t.Normal({0, 0, 1})))), 1, 1e-5f);
    EXPECT_NEAR(Dot(si.n, si.dpdu), 0, 1e-5f);
    EXPECT_NE(si.material, nullptr);
    EXPECT_EQ(si.wo, -d);
}

TEST(Builder, DerivativesOfNormalsAreFoundWhereABumpMayReadThem) {
    const auto derivativeOn = [](const std::string& material) {
        const std::string surface =
            "Texture \"height\" \"float\" \"fbm\" MakeNamedMaterial \"flat\" \"string type\" \"diffuse\" "
            "MakeNamedMaterial \"bumped\" \"string type\" \"conductor\" \"texture displacement\" "
            "\"height\" " +
            material;
        const RenderSetup world = BuildText(kSmall + "WorldBegin " + surface + " Shape \"sphere\""),
                          placed = BuildText(kSmall + "WorldBegin " + surface +
                                             " ObjectBegin \"o\" Shape \"sphere\" ObjectEnd Scale 2 2 2 "
                                             "ObjectInstance \"o\"");
        SurfaceInteraction inWorld, inObject;
        const Vec3 d = Normalize(Vec3(0.05f, 0.1f, 1));
        EXPECT_TRUE(test::NearestHit(world, {world.renderFromWorld.Point({0, 0, -5}), d, 0}, &inWorld));
        EXPECT_TRUE(test::NearestHit(placed, {placed.renderFromWorld.Point({0, 0, -5}), d, 0}, &inObject));
        EXPECT_EQ(Length(inWorld.shading.dndu) > 0, Length(inObject.shading.dndu) > 0) << material;
        return Length(inWorld.shading.dndu);
    };
    for (const std::string type : {"diffuse", "conductor", "dielectric", "thindielectric", "coateddiffuse",
                                   "coatedconductor", "diffusetransmission", "subsurface", "openpbr"}) {
        EXPECT_GT(derivativeOn("Material \"" + type + "\" \"texture displacement\" \"height\""), 0.1f)
            << type;
    }
    EXPECT_GT(derivativeOn("Material \"mix\" \"string materials\" [\"flat\" \"bumped\"]"), 0.1f);
    EXPECT_GT(derivativeOn("Material \"layered\" \"string stack\" [\"bumped\"]"), 0.1f);
    // The controls: nobody reads them.
    EXPECT_EQ(derivativeOn("Material \"diffuse\""), 0);
    EXPECT_EQ(derivativeOn("Material \"coatedconductor\""), 0);
    EXPECT_EQ(derivativeOn("Material \"mix\" \"string materials\" [\"flat\" \"flat\"]"), 0);
}

TEST(Builder, MovingShapesAreWhereTheirTimeSays) {
    const RenderSetup setup = BuildText(
        kSmall + "WorldBegin ActiveTransform EndTime Translate 4 0 0 ActiveTransform All Shape \"sphere\"");
    EXPECT_TRUE(setup.scene->IsMoving());
    EXPECT_FALSE(BuildText(kSmall + "WorldBegin Shape \"sphere\"").scene->IsMoving());
    EXPECT_TRUE(
        BuildText("ActiveTransform EndTime Translate 4 0 0 ActiveTransform All Camera \"perspective\" " +
                  kSmall + "WorldBegin Shape \"sphere\"")
            .scene->IsMoving())
        << "the camera";
    SurfaceInteraction si;
    RayCounts counts;
    for (const float time : {0.f, 0.25f, 1.f}) {
        ASSERT_TRUE(
            test::NearestHit(setup, {setup.renderFromWorld.Point({4 * time, 0, -5}), {0, 0, 1}, time}, &si));
        EXPECT_NEAR(Length(si.p - setup.renderFromWorld.Point({4 * time, 0, -1})), 0, 1e-4f);
        EXPECT_EQ(si.time, time);
        EXPECT_FALSE(setup.scene->Occluded(
            {setup.renderFromWorld.Point({4 * time + 1.5f, 0, -5}), {0, 0, 1}, time}, Infinity, counts));
    }
    EXPECT_TRUE(Contains(BuildErrorsOf("WorldBegin AreaLightSource \"diffuse\" ActiveTransform EndTime "
                                       "Translate 4 0 0 Shape \"sphere\""),
                         "a moving shape cannot be an area light"));
}

TEST(Builder, InterfaceShapesDoNotEmit) {
    WarningList warnings;
    const RenderSetup setup = BuildText(
        kSmall + "WorldBegin Material \"interface\" AreaLightSource \"diffuse\" Shape \"sphere\"", &warnings);
    EXPECT_TRUE(setup.scene->Lights().empty());
    EXPECT_TRUE(setup.scene->HasInterfaces());
    EXPECT_TRUE(Contains(warnings.text,
                         "a shape of the interface material cannot be an area light; its light is left out"))
        << warnings.text;
    EXPECT_TRUE(Contains(warnings.text, "scene.pbrt:1:")) << warnings.text;
}

TEST(Builder, ZSobolSaysHowManySamplesItTakes) {
    const auto warningsOf = [](int samples) {
        WarningList warnings;
        BuildText("Sampler \"zsobol\" \"integer pixelsamples\" " + std::to_string(samples) + " WorldBegin",
                  &warnings);
        return warnings.text;
    };
    EXPECT_TRUE(Contains(warningsOf(100), "scene.pbrt:1:18: warning: sampler \"zsobol\" takes 64 samples"));
    EXPECT_EQ(warningsOf(64), "");
}

// The format allows normal maps on all materials, whether or not they have a use for them.
TEST(Builder, HairAndMixturesMayHaveNormalMaps) {
    EXPECT_EQ(
        BuildErrorsOf(
            "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"hair\" \"string normalmap\" \"n.png\" "
            "Material \"mix\" \"string materials\" [\"a\" \"a\"] \"string normalmap\" \"n.png\""),
        "");
}

TEST(Builder, EveryPrimitiveOfAnEmitterIsALight) {
    const RenderSetup setup = BuildText(kSmall +
                                        "WorldBegin Shape \"sphere\" AttributeBegin AreaLightSource "
                                        "\"diffuse\" Translate 0 0 3 Shape \"trianglemesh\" "
                                        "\"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 1 "
                                        "3 2] AttributeEnd LightSource \"infinite\"");
    ASSERT_EQ(setup.scene->Lights().size(), 3u);
    EXPECT_EQ(setup.scene->InfiniteLights().size(), 1u);
    // Uniform environments are not sampled.
    EXPECT_EQ(setup.scene->SampledLights().size(), 2u);
    SurfaceInteraction first, second;
    ASSERT_TRUE(
        test::NearestHit(setup, {setup.renderFromWorld.Point({0.2f, 0.2f, 5}), {0, 0, -1}, 0}, &first));
    ASSERT_TRUE(
        test::NearestHit(setup, {setup.renderFromWorld.Point({0.8f, 0.8f, 5}), {0, 0, -1}, 0}, &second));
    EXPECT_EQ(first.areaLight, setup.scene->Lights()[0]);
    EXPECT_EQ(second.areaLight, setup.scene->Lights()[1]);
}

TEST(Builder, AScaledEmitterWarnsWhereItsAreaIsWrong) {
    WarningList warnings;
    BuildText(kSmall + "WorldBegin AreaLightSource \"diffuse\" Scale 2 2 2 Shape \"sphere\"", &warnings);
    EXPECT_TRUE(Contains(warnings.text, "the transform of this area light scales")) << warnings.text;
    WarningList none;
    BuildText(kSmall +
                  "WorldBegin AreaLightSource \"diffuse\" Scale 2 2 2 Shape \"trianglemesh\" \"point3 P\" [0 "
                  "0 0 1 0 0 0 1 0]",
              &none);
    EXPECT_EQ(none.text, "");
}

TEST(Builder, RenderSpaceChangesNoDistances) {
    const std::string scene =
        "LookAt 100 20 -30  0 0 0  0 1 0 Camera \"perspective\" " + kSmall + "WorldBegin Shape \"sphere\"";
    for (const std::string space : {"camera", "cameraworld", "world"}) {
        const RenderSetup setup = BuildText("Option \"rendercoordsys\" \"" + space + "\" " + scene);
        EXPECT_NEAR(Distance(setup, {0, 0, -4}, {0, 0, 1}), 3, 1e-4f) << space;
        const Point3 eye = setup.scene->Camera().RenderFromCamera().Start().Point(Point3(0));
        EXPECT_LT(Length(eye - setup.renderFromWorld.Point({100, 20, -30})), 1e-4f) << space;
        EXPECT_EQ(Length(eye) < 1e-4f, space != "world") << space;
    }
}

TEST(Builder, RenderSpaceNeverScalesOrMirrors) {
    for (const char* transform : {"Scale 10 10 10", "Scale -1 1 1", "Translate 1 2 3"}) {
        const RenderSetup setup =
            BuildText(std::string(transform) +
                      " LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" "
                      "Option \"rendercoordsys\" \"camera\" WorldBegin Shape \"sphere\"");
        EXPECT_FALSE(setup.renderFromWorld.HasScale()) << transform;
        EXPECT_FALSE(setup.renderFromWorld.SwapsHandedness()) << transform;
    }
}

TEST(Builder, OptionsOfTheFileWinOverTheCommandLine) {
    BuildOptions options;
    options.given.Set(&SceneOptions::seed, 3);
    options.samplesPerPixel = 5;
    const auto build = [&](const std::string& text) {
        return BuildScene(ParseText(text, "scene.pbrt", "", nullptr), options, nullptr);
    };
    EXPECT_EQ(build(kSmall + "WorldBegin").options.seed, 3);
    EXPECT_EQ(build("Option \"seed\" 8 " + kSmall + "WorldBegin").options.seed, 8);
    EXPECT_EQ(build("Sampler \"sobol\" \"integer pixelsamples\" 64 " + kSmall + "WorldBegin")
                  .sampler->SamplesPerPixel(),
              5);
}

TEST(Builder, MixturesSeeNamedMaterialsMadeBefore) {
    const std::string mix =
        "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"a\" \"b\"] ";
    const std::string a = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" ",
                      b = "MakeNamedMaterial \"b\" \"string type\" \"diffuse\" ";
    EXPECT_EQ(BuildErrorsOf(kSmall + "WorldBegin " + a + b + mix), "");
    EXPECT_TRUE(Contains(BuildErrorsOf("WorldBegin " + a + mix + b), "\"b\""))
        << BuildErrorsOf("WorldBegin " + a + mix + b);
    // A material that failed is not blamed on the mixture that uses it.
    EXPECT_EQ(
        Lines(BuildErrorsOf("WorldBegin MakeNamedMaterial \"a\" \"string type\" \"difuse\" " + b + mix)), 1u);
}

}  // namespace
}  // namespace lacquer::builder_test
