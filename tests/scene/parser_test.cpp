// What directives mean.
#include "pbrt/scene/parser.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "scene/scene_text.h"

namespace lacquer::test::parser_test {
namespace {

const ShapeEntity& OnlyShape(const SceneDescription& scene) {
    EXPECT_EQ(scene.shapes.size(), 1u);
    return scene.shapes.at(0);
}

// Coordinates here are below 100, so a few roundings stay below 1e-5 of that.
void ExpectNear(Vec3 a, Vec3 b) {
    EXPECT_NEAR(a.x, b.x, 1e-4f);
    EXPECT_NEAR(a.y, b.y, 1e-4f);
    EXPECT_NEAR(a.z, b.z, 1e-4f);
}

Vec3 ImageOf(const std::string& transforms, Vec3 p) {
    return OnlyShape(ParseWorld(transforms + " Shape \"sphere\"")).worldFromObject.start.Point(p);
}

const Parameter* FindParameter(const std::vector<Parameter>& parameters, const std::string& name) {
    const Parameter* found = nullptr;
    for (const Parameter& p : parameters)
        if (p.name == name) found = &p;
    return found;
}

Params ShapeParams(const SceneDescription& scene, size_t i) {
    return MakeParams(scene.shapes.at(i), "shape", scene.FilesOf(scene.shapes.at(i)));
}

TEST(Parser, DefaultsAreThoseOfPbrt) {
    const SceneDescription scene = ParseScene("WorldBegin");
    EXPECT_EQ(scene.camera.type, "perspective");
    EXPECT_TRUE(scene.camera.cameraFromWorld.start.IsIdentity());
    EXPECT_EQ(scene.sampler.type, "zsobol");
    EXPECT_EQ(scene.filter.type, "gaussian");
    EXPECT_EQ(scene.integrator.type, "volpath");
    EXPECT_EQ(scene.accelerator.type, "bvh");
    EXPECT_EQ(scene.film.type, "rgb");
    EXPECT_EQ(scene.film.colorSpace, &ColorSpace::SRGB());
    ASSERT_EQ(scene.materials.size(), 1u);
    EXPECT_EQ(scene.materials[0].type, "diffuse");
    EXPECT_FALSE(scene.coordinateSystems.contains("camera"));
    EXPECT_TRUE(scene.coordinateSystems.contains("world"));
    EXPECT_EQ(scene.startTime, 0.f);
    EXPECT_EQ(scene.endTime, 1.f);
}

TEST(Parser, OptionBlockKeepsTheLastOfEachKind) {
    const SceneDescription scene = ParseScene(
        "Film \"rgb\" \"integer xresolution\" 5 Film \"gbuffer\" \"string filename\" \"a.exr\"\n"
        "Sampler \"halton\" \"integer pixelsamples\" [ 8 ]\nPixelFilter \"box\" Integrator \"path\"\n"
        "Accelerator \"kdtree\" WorldBegin");
    EXPECT_EQ(scene.film.type, "gbuffer");
    ASSERT_EQ(scene.film.parameters.size(), 1u);
    EXPECT_EQ(scene.film.parameters[0].strings, std::vector<std::string>{"a.exr"});
    EXPECT_EQ(scene.sampler.type, "halton");
    EXPECT_EQ(scene.sampler.parameters[0].integers, std::vector<int>{8});
    EXPECT_EQ(scene.sampler.loc.ToString(), "scene.pbrt:2:1");
    EXPECT_EQ(scene.sampler.parameters[0].loc.ToString(), "scene.pbrt:2:18");
    EXPECT_EQ(scene.filter.type, "box");
    EXPECT_EQ(scene.integrator.type, "path");
    EXPECT_EQ(scene.accelerator.type, "kdtree");
}

TEST(Parser, ParametersOfEveryTypeKeepTheirValues) {
    const SceneDescription scene = ParseWorld(
        "Shape \"x\" \"float f\" 1.5 \"integer i\" [1 -2] \"bool b\" [true false] \"string s\" [\"a\" \"b\"] "
        "\"point2 p2\" [1 2] \"vector2 v2\" [1 2] \"point3 p3\" [1 2 3] \"vector3 v3\" [1 2 3] \"normal n\" "
        "[0 0 1] "
        "\"rgb c\" [.1 .2 .3] \"blackbody t\" 3000 \"spectrum e\" \"metal-Cu-eta\" \"spectrum l\" [300 1 900 "
        "2] "
        "\"texture x\" \"tex\" \"  float \t spaced  \" 4 \"string none\" [ ]");
    const std::vector<Parameter>& p = OnlyShape(scene).parameters;
    ASSERT_EQ(p.size(), 16u);
    EXPECT_EQ(p[0].floats, std::vector<float>{1.5f});
    EXPECT_EQ(p[1].integers, (std::vector<int>{1, -2}));
    EXPECT_EQ(p[2].bools, (std::vector<unsigned char>{1, 0}));
    EXPECT_EQ(p[3].strings, (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(p[6].floats, (std::vector<float>{1, 2, 3}));
    EXPECT_EQ(p[10].type, "blackbody");
    EXPECT_EQ(p[11].strings, std::vector<std::string>{"metal-Cu-eta"});
    EXPECT_EQ(p[12].floats.size(), 4u);
    EXPECT_EQ(p[14].type, "float");
    EXPECT_EQ(p[14].name, "spaced");
    EXPECT_EQ(p[15].kind, Parameter::Values::Strings);
}

TEST(Parser, LastDuplicateParameterWinsWithoutComplaint) {
    const SceneDescription scene = ParseWorld("Shape \"sphere\" \"float radius\" 1 \"float radius\" 2");
    const Params params = ShapeParams(scene, 0);
    EXPECT_EQ(params.GetFloat("radius", 0), 2.f);
    EXPECT_TRUE(params.UnusedParameters().empty());
}

TEST(Parser, TheTransformNearestTheObjectActsFirst) {
    ExpectNear(ImageOf("Translate 10 0 0 Scale 2 3 4", {1, 1, 1}), {12, 3, 4});
    ExpectNear(ImageOf("Scale 2 3 4 Translate 10 0 0", {1, 1, 1}), {22, 3, 4});
    // A right-hand turn by 90 degrees about z takes x to y.
    ExpectNear(ImageOf("Rotate 90 0 0 2", {1, 0, 0}), {0, 1, 0});
    ExpectNear(ImageOf("Translate 5 5 5 Identity", {1, 2, 3}), {1, 2, 3});
}

TEST(Parser, MatricesAreColumnMajor) {
    const std::string matrix = "[0 1 0 0  -1 0 0 0  0 0 1 0  7 8 9 1]";
    ExpectNear(ImageOf("Scale 2 2 2 Transform " + matrix, {1, 0, 0}), {7, 9, 9});
    ExpectNear(ImageOf("Scale 2 2 2 ConcatTransform " + matrix, {1, 0, 0}), {14, 18, 18});
}

TEST(Parser, LookAtMapsTheEyeToTheOriginAndTheTargetToPlusZ) {
    const SceneDescription scene = ParseScene("LookAt 1 2 3  1 2 8  0 1 0 Camera \"perspective\" WorldBegin");
    const Transform& m = scene.camera.cameraFromWorld.start;
    ExpectNear(m.Point({1, 2, 3}), {0, 0, 0});
    ExpectNear(m.Point({1, 2, 8}), {0, 0, 5});
    ExpectNear(m.Point({1, 3, 3}), {0, 1, 0});
    ExpectNear(m.Point({2, 2, 3}), {1, 0, 0});
}

TEST(Parser, CameraKeepsItsTransformTimesAndMedium) {
    const SceneDescription scene = ParseScene(
        "TransformTimes 0.25 0.75 MediumInterface \"\" \"fog\" Translate 1 0 0 ActiveTransform EndTime "
        "Translate 1 0 0 "
        "Camera \"orthographic\" \"float shutterclose\" 2 MakeNamedMedium \"fog\" \"string type\" "
        "\"homogeneous\" "
        "WorldBegin CoordSysTransform \"camera\" Shape \"sphere\"");
    EXPECT_EQ(scene.camera.type, "orthographic");
    EXPECT_EQ(scene.camera.medium, "fog");
    EXPECT_EQ(scene.camera.startTime, 0.25f);
    EXPECT_EQ(scene.camera.endTime, 0.75f);
    EXPECT_EQ(scene.startTime, 0.25f);
    EXPECT_TRUE(scene.camera.cameraFromWorld.IsAnimated());
    ExpectNear(scene.camera.cameraFromWorld.end.Point({0, 0, 0}), {2, 0, 0});
    // The named system is the inverse, for both times.
    ExpectNear(OnlyShape(scene).worldFromObject.start.Point({0, 0, 0}), {-1, 0, 0});
    ExpectNear(OnlyShape(scene).worldFromObject.end.Point({0, 0, 0}), {-2, 0, 0});
}

TEST(Parser, WorldBeginResetsTransformsAndNothingElse) {
    const SceneDescription scene = ParseScene(
        "Translate 1 2 3 ActiveTransform StartTime ColorSpace \"rec2020\" MediumInterface \"m\" "
        "Attribute \"shape\" \"float radius\" 3 MakeNamedMedium \"m\" \"string type\" \"homogeneous\" "
        "WorldBegin Translate 5 0 0 Shape \"sphere\"");
    const ShapeEntity& shape = OnlyShape(scene);
    ExpectNear(shape.worldFromObject.start.Point({0, 0, 0}), {5, 0, 0});
    EXPECT_FALSE(shape.worldFromObject.IsAnimated());
    EXPECT_EQ(shape.colorSpace, ColorSpace::Find("rec2020"));
    EXPECT_EQ(shape.insideMedium, "m");
    EXPECT_EQ(shape.outsideMedium, "m");
    EXPECT_EQ(ShapeParams(scene, 0).GetFloat("radius", 1), 3.f);
    // Media keep the transform of their own place.
    ExpectNear(scene.media.at(0).worldFromMedium.Point({0, 0, 0}), {1, 2, 3});
}

TEST(Parser, ActiveTransformChoosesWhichMatrixChanges) {
    const SceneDescription scene = ParseWorld(
        "Translate 1 0 0 ActiveTransform StartTime Translate 0 1 0 ActiveTransform EndTime Translate 0 0 1 "
        "ActiveTransform All Translate 1 0 0 Shape \"sphere\"");
    ExpectNear(OnlyShape(scene).worldFromObject.start.Point({0, 0, 0}), {2, 1, 0});
    ExpectNear(OnlyShape(scene).worldFromObject.end.Point({0, 0, 0}), {2, 0, 1});
}

TEST(Parser, NamedCoordinateSystemsStoreBothMatrices) {
    const SceneDescription scene = ParseWorld(
        "ActiveTransform EndTime Translate 0 0 4 CoordinateSystem \"here\" ActiveTransform All Translate 9 9 "
        "9 "
        "CoordSysTransform \"here\" Shape \"sphere\" CoordSysTransform \"world\" Shape \"sphere\"");
    ASSERT_EQ(scene.shapes.size(), 2u);
    ExpectNear(scene.shapes[0].worldFromObject.start.Point({0, 0, 0}), {0, 0, 0});
    ExpectNear(scene.shapes[0].worldFromObject.end.Point({0, 0, 0}), {0, 0, 4});
    EXPECT_TRUE(scene.shapes[1].worldFromObject.end.IsIdentity());
    EXPECT_TRUE(scene.coordinateSystems.contains("here"));
}

TEST(Parser, AttributeEndRestoresTheWholeState) {
    const SceneDescription scene = ParseWorld(
        "AttributeBegin Translate 1 0 0 Material \"conductor\" AreaLightSource \"diffuse\" "
        "ReverseOrientation "
        "MediumInterface \"in\" \"out\" ColorSpace \"aces2065-1\" Attribute \"shape\" \"float radius\" 7 "
        "Shape \"sphere\" AttributeEnd Shape \"sphere\" "
        "MakeNamedMedium \"in\" \"string type\" \"homogeneous\" MakeNamedMedium \"out\" \"string type\" "
        "\"homogeneous\"");
    ASSERT_EQ(scene.shapes.size(), 2u);
    const ShapeEntity &first = scene.shapes[0], &second = scene.shapes[1];
    EXPECT_EQ(first.material.index, 1);
    EXPECT_EQ(scene.materials.at(1).type, "conductor");
    EXPECT_EQ(first.areaLight, 0);
    EXPECT_TRUE(first.reverseOrientation);
    EXPECT_EQ(first.insideMedium, "in");
    EXPECT_EQ(first.outsideMedium, "out");
    EXPECT_EQ(first.colorSpace, ColorSpace::Find("aces2065-1"));
    EXPECT_TRUE(second.worldFromObject.start.IsIdentity());
    EXPECT_EQ(second.material.index, 0);
    EXPECT_EQ(second.areaLight, -1);
    EXPECT_FALSE(second.reverseOrientation);
    EXPECT_EQ(second.insideMedium, "");
    EXPECT_EQ(second.colorSpace, &ColorSpace::SRGB());
    EXPECT_EQ(second.attributes, nullptr);
}

TEST(Parser, TransformBeginRestoresMaterialsTooAndWarnsOnce) {
    const SceneDescription scene = ParseWorld(
        "TransformBegin Material \"conductor\" TransformEnd TransformBegin TransformEnd Shape \"sphere\"");
    EXPECT_EQ(OnlyShape(scene).material.index, 0);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].message.find("TransformBegin"), std::string::npos);
}

TEST(Parser, ReverseOrientationToggles) {
    const SceneDescription scene = ParseWorld("ReverseOrientation ReverseOrientation Shape \"sphere\"");
    EXPECT_FALSE(OnlyShape(scene).reverseOrientation);
}

TEST(Parser, AttributesAreDefaultsThatTheMostRecentWins) {
    const SceneDescription scene = ParseWorld(
        "Attribute \"shape\" \"float radius\" 2 \"float alpha\" .5 Attribute \"shape\" \"float radius\" 3 "
        "Shape \"sphere\" Shape \"sphere\" \"float radius\" 4");
    EXPECT_EQ(ShapeParams(scene, 0).GetFloat("radius", 1), 3.f);
    const Params own = ShapeParams(scene, 1);
    EXPECT_EQ(own.GetFloat("radius", 1), 4.f);
    EXPECT_TRUE(own.UnusedParameters().empty());  // alpha is inherited and may stay unused
    EXPECT_EQ(own.GetFloat("alpha", 1), .5f);
}

TEST(Parser, AttributesReachTheirTargetOnly) {
    const SceneDescription scene = ParseWorld(
        "Attribute \"light\" \"float scale\" 2 Attribute \"material\" \"float roughness\" .1 "
        "Attribute \"medium\" \"float g\" .3 Attribute \"texture\" \"float vscale\" 4 "
        "Shape \"sphere\" LightSource \"point\" AreaLightSource \"diffuse\" Material \"conductor\" "
        "MakeNamedMaterial \"m\" \"string type\" \"diffuse\" MakeNamedMedium \"fog\" \"string type\" "
        "\"homogeneous\" "
        "Texture \"t\" \"float\" \"checkerboard\"");
    const auto attributeOf = [](const PluginEntity& entity) {
        return entity.attributes && entity.attributes->size() == 1 ? entity.attributes->at(0).name
                                                                   : std::string();
    };
    EXPECT_EQ(OnlyShape(scene).attributes, nullptr);
    EXPECT_EQ(attributeOf(scene.lights.at(0)), "scale");
    EXPECT_EQ(attributeOf(scene.areaLights.at(0)), "scale");
    EXPECT_EQ(attributeOf(scene.materials.at(1)), "roughness");
    EXPECT_EQ(attributeOf(scene.namedMaterials.at(0)), "roughness");
    EXPECT_EQ(attributeOf(scene.media.at(0)), "g");
    EXPECT_EQ(attributeOf(scene.textures.at(0)), "vscale");
}

TEST(Parser, AttributesKeepTheColorSpaceOfTheirPlace) {
    const SceneDescription scene = ParseWorld(
        "ColorSpace \"Rec2020\" Attribute \"light\" \"rgb I\" [1 0 0] ColorSpace \"sRGB\" LightSource "
        "\"point\"");
    EXPECT_EQ(scene.lights.at(0).attributes->at(0).colorSpace, ColorSpace::Find("rec2020"));
    EXPECT_EQ(scene.lights.at(0).colorSpace, &ColorSpace::SRGB());
}

TEST(Parser, TypeOfANamedThingIsTakenFromItsParameters) {
    const SceneDescription scene = ParseWorld(
        "Attribute \"medium\" \"string type\" \"homogeneous\" MakeNamedMedium \"a\" "
        "MakeNamedMaterial \"b\" \"float roughness\" 1 \"string type\" \"conductor\" NamedMaterial \"b\" "
        "Shape \"sphere\"");
    EXPECT_EQ(scene.media.at(0).type, "homogeneous");
    EXPECT_EQ(scene.namedMaterials.at(0).type, "conductor");
    EXPECT_EQ(FindParameter(scene.namedMaterials[0].parameters, "type"), nullptr);
    EXPECT_EQ(OnlyShape(scene).material.name, "b");
}

TEST(Parser, MaterialNoneIsInterfaceWithAWarning) {
    const SceneDescription scene = ParseWorld("Material \"none\" Shape \"sphere\"");
    EXPECT_EQ(scene.materials.at(1).type, "interface");
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0].ToString(),
              "scene.pbrt:1:12: warning: the material \"none\" is deprecated; use \"interface\"");
}

TEST(Parser, NamedThingsMayBeDefinedAfterTheirUse) {
    const SceneDescription scene = ParseWorld(
        "NamedMaterial \"later\" MediumInterface \"fog\" \"\" Shape \"sphere\" ObjectInstance \"thing\" "
        "MakeNamedMaterial \"later\" \"string type\" \"diffuse\" MakeNamedMedium \"fog\" \"string type\" "
        "\"homogeneous\" "
        "ObjectBegin \"thing\" ObjectEnd");
    EXPECT_EQ(OnlyShape(scene).material.name, "later");
    EXPECT_EQ(OnlyShape(scene).insideMedium, "fog");
    EXPECT_EQ(OnlyShape(scene).outsideMedium, "");
    EXPECT_EQ(scene.instances.at(0).name, "thing");
}

TEST(Parser, TexturesKeepNameKindClassTransformAndOrder) {
    const SceneDescription scene = ParseWorld(
        "Scale 2 2 2 Texture \"a\" \"float\" \"constant\" \"float value\" 3 Texture \"a\" \"spectrum\" "
        "\"imagemap\"");
    ASSERT_EQ(scene.textures.size(), 2u);
    EXPECT_EQ(scene.textures[0].name, "a");
    EXPECT_FALSE(scene.textures[0].isSpectrum);
    EXPECT_EQ(scene.textures[0].type, "constant");
    ExpectNear(scene.textures[0].worldFromTexture.Point({1, 1, 1}), {2, 2, 2});
    EXPECT_TRUE(scene.textures[1].isSpectrum);  // another namespace, so the same name is no error
}

TEST(Parser, LightsKeepTransformAndOutsideMedium) {
    const SceneDescription scene = ParseWorld(
        "Translate 1 2 3 MediumInterface \"a\" \"b\" LightSource \"point\" \"rgb I\" [1 2 3] "
        "MakeNamedMedium \"b\" \"string type\" \"homogeneous\"");
    ExpectNear(scene.lights.at(0).worldFromLight.Point({0, 0, 0}), {1, 2, 3});
    EXPECT_EQ(scene.lights[0].medium, "b");
}

TEST(Parser, AreaLightHoldsForFollowingShapesUntilTheScopeEnds) {
    const SceneDescription scene = ParseWorld(
        "AttributeBegin AreaLightSource \"diffuse\" Shape \"a\" AreaLightSource \"diffuse\" Shape \"b\" "
        "Shape \"c\" "
        "AttributeEnd Shape \"d\"");
    ASSERT_EQ(scene.shapes.size(), 4u);
    EXPECT_EQ(scene.shapes[0].areaLight, 0);
    EXPECT_EQ(scene.shapes[1].areaLight, 1);
    EXPECT_EQ(scene.shapes[2].areaLight, 1);
    EXPECT_EQ(scene.shapes[3].areaLight, -1);
    EXPECT_EQ(scene.areaLights.size(), 2u);
}

TEST(Parser, ObjectsKeepTheTransformOfTheirDefinition) {
    const SceneDescription scene = ParseWorld(
        "Translate 1 0 0 ObjectBegin \"o\" Translate 0 1 0 Material \"conductor\" Shape \"sphere\" ObjectEnd "
        "Translate 0 0 1 ObjectInstance \"o\" Shape \"disk\"");
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.objects[0].name, "o");
    ASSERT_EQ(scene.objects[0].shapes.size(), 1u);
    ExpectNear(scene.objects[0].shapes[0].worldFromObject.start.Point({0, 0, 0}), {1, 1, 0});
    ExpectNear(scene.instances.at(0).worldFromInstance.start.Point({0, 0, 0}), {1, 0, 1});
    EXPECT_EQ(OnlyShape(scene).material.index, 0);  // ObjectEnd restores the state
}

TEST(Parser, LightsInsideOfObjectsAreGlobal) {
    const SceneDescription scene = ParseWorld("ObjectBegin \"o\" LightSource \"point\" ObjectEnd");
    EXPECT_EQ(scene.lights.size(), 1u);
}

TEST(Parser, AreaLightsInsideOfObjectsAreDroppedWithAWarning) {
    const SceneDescription scene = ParseWorld(
        "ObjectBegin \"o\" AreaLightSource \"diffuse\" Shape \"sphere\" Shape \"sphere\" ObjectEnd");
    EXPECT_EQ(scene.objects.at(0).shapes.at(1).areaLight, -1);
    EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(Parser, MovingTexturesLightsAndMediaUseTheStartWithAWarning) {
    const SceneDescription scene = ParseWorld(
        "ActiveTransform EndTime Translate 1 0 0 Texture \"t\" \"float\" \"constant\" LightSource \"point\" "
        "MakeNamedMedium \"m\" \"string type\" \"homogeneous\"");
    EXPECT_EQ(scene.warnings.size(), 3u);
    EXPECT_TRUE(scene.lights.at(0).worldFromLight.IsIdentity());
}

TEST(Parser, AScaledCameraIsAWarning) {
    EXPECT_EQ(ParseScene("Scale 2 2 2 Camera \"perspective\" WorldBegin").warnings.size(), 1u);
    EXPECT_EQ(ParseScene("Scale -1 1 1 Camera \"perspective\" WorldBegin").warnings.size(), 0u);
}

TEST(Parser, UnknownCoordinateSystemIsAWarningThatNamesTheNearest) {
    const SceneDescription scene = ParseWorld("Translate 1 0 0 CoordSysTransform \"wrold\" Shape \"sphere\"");
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].message.find("did you mean \"world\"?"), std::string::npos);
    ExpectNear(OnlyShape(scene).worldFromObject.start.Point({0, 0, 0}), {1, 0, 0});
}

TEST(Parser, OneSampleSpectrumIsAWarning) {
    EXPECT_EQ(ParseWorld("LightSource \"point\" \"spectrum I\" [500 1]").warnings.size(), 1u);
}

TEST(Parser, WarningsReachTheObserver) {
    struct Recorder : Observer {
        void Warn(const std::string& message) override { messages.push_back(message); }
        std::vector<std::string> messages;
    } recorder;
    ParseText("WorldBegin\nCoordSysTransform \"q\"\nCoordSysTransform \"q\"", "s", "", &recorder);
    ASSERT_EQ(recorder.messages.size(), 1u);
    EXPECT_EQ(recorder.messages[0].rfind("s:2:1: warning: ", 0), 0u);
}

TEST(Parser, OptionsAreReadWhateverTheirSpelling) {
    const SceneDescription scene = ParseScene(
        "Option \"disablepixeljitter\" true Option \"Disable_Texture-Filtering\" false Option "
        "\"disablewavelengthjitter\" "
        "true Option \"forcediffuse\" true Option \"pixelstats\" true Option \"wavefront\" false Option "
        "\"seed\" 17 "
        "Option \"displacementedgescale\" .5 Option \"msereferenceimage\" \"a.exr\" Option "
        "\"msereferenceout\" \"b.txt\" "
        "WorldBegin Option \"rendercoordsys\" \"world\"");
    const SceneOptions& o = scene.options.Values();
    EXPECT_EQ(o.disablePixelJitter, true);
    EXPECT_EQ(o.disableTextureFiltering, false);
    EXPECT_EQ(o.disableWavelengthJitter, true);
    EXPECT_EQ(o.forceDiffuse, true);
    EXPECT_EQ(o.pixelStats, true);
    EXPECT_EQ(o.wavefront, false);
    EXPECT_EQ(o.seed, 17);
    EXPECT_EQ(o.displacementEdgeScale, .5f);
    EXPECT_EQ(o.mseReferenceImage, "a.exr");
    EXPECT_EQ(o.mseReferenceOut, "b.txt");
    EXPECT_EQ(o.renderCoordSys, "world");
    for (const SceneOption& option : OptionTable()) {
        EXPECT_TRUE(scene.options.IsGiven(option.field)) << option.name;
        EXPECT_FALSE(ParseScene("WorldBegin").options.IsGiven(option.field)) << option.name;
    }
}

TEST(Parser, FilmRemembersTheColorSpaceOfItsPlace) {
    const SceneDescription scene =
        ParseScene("ColorSpace \"DCI-P3\" Film \"rgb\" ColorSpace \"srgb\" WorldBegin");
    EXPECT_EQ(scene.film.colorSpace, ColorSpace::Find("dci-p3"));
}

TEST(Parser, NamesThatAreNotAsciiMatchByteByByte) {
    const SceneDescription scene = ParseWorld(
        "MakeNamedMaterial \"m\xC3\xA9tal\" \"string type\" \"diffuse\" NamedMaterial \"m\xC3\xA9tal\" Shape "
        "\"sphere\"");
    EXPECT_EQ(OnlyShape(scene).material.name, "m\xC3\xA9tal");
}

TEST(Parser, MovingParametersOutLeavesNoCopies) {
    SceneDescription scene = ParseWorld("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]");
    ShapeEntity& shape = scene.shapes.at(0);
    const float* numbers = shape.parameters.at(0).floats.data();
    const Params params = MakeParams(std::move(shape), "shape", scene.resolvers.at(0));
    EXPECT_EQ(params.All().at(0).floats.data(), numbers);
    EXPECT_EQ(params.Owner(), "shape \"trianglemesh\"");
}

}  // namespace
}  // namespace lacquer::test::parser_test
