// What is wrong with a scene, and where: one test for each message.
#include <gtest/gtest.h>

#include "scene/scene_text.h"

namespace lacquer::test::parser_errors_test {
namespace {

TEST(ParserErrors, UnknownDirectiveNamesTheNearest) {
    ExpectOneError("WorldBegin\n  Shpae \"sphere\" \"float radius\" 1", 2, 3,
                   "unknown directive Shpae; did you mean \"Shape\"?");
    ExpectOneError("WorldBegin\nFooBarBaz 1 2 3", 2, 1, "unknown directive FooBarBaz");
    ExpectOneError("worldbegin\nShape \"sphere\"\nShape \"sphere\"", 1, 1, "did you mean \"WorldBegin\"?");
}

TEST(ParserErrors, SomethingElseThanADirective) {
    ExpectOneError("WorldBegin\n]", 2, 1, "expected a directive, found ]");
    ExpectOneError("WorldBegin \"abc\"", 1, 12, "expected a directive, found \"abc\"");
    ExpectOneError("WorldBegin Translate 1 2 3 4 Shape \"sphere\"", 1, 28, "unknown directive 4");
}

TEST(ParserErrors, MisplacedDirectives) {
    ExpectOneError("Film \"rgb\"\nShape \"sphere\"\nMaterial \"diffuse\"\nWorldBegin", 2, 1,
                   "Shape is not allowed before WorldBegin");
    ExpectOneError("WorldBegin\nFilm \"rgb\" \"integer xresolution\" 5\nShape \"sphere\"", 2, 1,
                   "Film is not allowed after WorldBegin");
    ExpectOneError("WorldBegin\nWorldBegin", 2, 1, "WorldBegin is not allowed after WorldBegin");
    ExpectOneError("AttributeBegin WorldBegin AttributeEnd", 1, 1,
                   "AttributeBegin is not allowed before WorldBegin");
    ExpectOneError("WorldBegin TransformTimes 0 1", 1, 12, "TransformTimes is not allowed after WorldBegin");
}

TEST(ParserErrors, NoWorldBegin) {
    ExpectOneError("Film \"rgb\"", 0, 0, "the scene has no WorldBegin");
    ExpectOneError("", 0, 0, "the scene has no WorldBegin");
}

TEST(ParserErrors, TheFileEndsWhereAnArgumentIsExpected) {
    ExpectOneError("WorldBegin\nTranslate 1 2", 2, 1, "Translate: the file ends where a number is expected");
    ExpectOneError("WorldBegin\nShape", 2, 1, "Shape: the file ends where a type is expected");
    ExpectOneError("WorldBegin\nShape \"sphere\" \"float radius\"", 2, 16,
                   "the file ends before the parameter's value");
    ExpectOneError("WorldBegin Shape \"s\" \"point3 P\" [1 2", 1, 33, "the list of values is never closed");
}

TEST(ParserErrors, ArgumentsOfTheWrongKind) {
    ExpectOneError("WorldBegin Shape sphere", 1, 18, "Shape: expected a type in quotes, found sphere");
    ExpectOneError("WorldBegin Translate [1 2 3]", 1, 22, "expected a number, found [");
    ExpectOneError("WorldBegin Scale 1 x 3", 1, 20, "Scale: expected a number, found x");
    ExpectOneError("WorldBegin Rotate 1 \"a\"", 1, 21, "expected a number, found \"a\"");
    ExpectOneError("WorldBegin Transform 1 0 0 0", 1, 22, "expected [ and 16 numbers, found 1");
    ExpectOneError("WorldBegin Transform [1 2 3]", 1, 28, "a matrix has 16 numbers, not 3");
    ExpectOneError("WorldBegin ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 7]", 1, 61,
                   "expected ] after 16 numbers, found 7");
    ExpectOneError("WorldBegin ActiveTransform Both", 1, 28,
                   "expected All, StartTime or EndTime, found Both");
}

TEST(ParserErrors, SingularAndHugeTransforms) {
    ExpectOneError("WorldBegin\nScale 1 0 1\nShape \"sphere\"", 3, 1, "singular since scene.pbrt:2:1");
    ExpectOneError("WorldBegin\nRotate 30 0 0 0 Shape \"sphere\"", 2, 17, "singular since scene.pbrt:2:1");
    ExpectOneError("LookAt 0 0 0 0 1 0 0 1 0 WorldBegin", 1, 1, "up must not be parallel");
    ExpectOneError("LookAt 1 1 1 1 1 1 0 1 0 WorldBegin", 1, 1,
                   "LookAt: the eye and the point looked at must differ");
    ExpectOneError("WorldBegin Transform [0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0]\nShape \"sphere\"", 2, 1,
                   "singular");
    ExpectOneError("WorldBegin\nScale 1e30 1e30 1e30\nScale 1e30 1e30 1e30\nShape \"sphere\"", 4, 1,
                   "singular since scene.pbrt:3:1: it has no inverse within the range of floats");
    ExpectOneError("WorldBegin Translate 1e39 0 0", 1, 22, "1e39 is too large for a 32-bit float");
    ExpectOneError("WorldBegin Scale 1e-44 1 1\nShape \"sphere\"", 2, 1, "singular since scene.pbrt:1:12");
}

// What has no use for the inverse does not ask for it; what has does, wherever the transform was made.
TEST(ParserErrors, SingularTransformsMatterOnlyWhereTheyAreUsed) {
    const std::string flat = "ConcatTransform [1 1 0 0 1 1 0 0 0 0 1 0 0 0 0 1]\n";
    const std::string shape = "Shape \"sphere\"", since = "singular since scene.pbrt:";
    EXPECT_TRUE(ErrorsOf("WorldBegin " + flat).empty());
    EXPECT_TRUE(ErrorsOf("WorldBegin AttributeBegin " + flat + "AttributeEnd " + shape).empty());
    EXPECT_TRUE(ErrorsOf("WorldBegin " + flat + "Identity " + shape).empty());
    EXPECT_TRUE(ErrorsOf("Scale 0 0 0 WorldBegin " + shape).empty());
    EXPECT_TRUE(ErrorsOf("Scale 0 0 0 CoordinateSystem \"flat\" WorldBegin " + shape).empty());
    ExpectOneError("CoordinateSystem \"a\"\n" + flat + "Camera \"perspective\" WorldBegin", 3, 1,
                   since + "2:1");
    ExpectOneError("WorldBegin ObjectBegin \"o\" " + shape + " ObjectEnd\n" + flat + "ObjectInstance \"o\"",
                   3, 1, since + "2:1");
    ExpectOneError("WorldBegin " + flat + "Translate 1 0 0 Rotate 30 0 0 1\n" + shape, 3, 1, since + "1:12");
    ExpectOneError(
        "WorldBegin Scale 0 1 1 CoordinateSystem \"flat\" Identity\nCoordSysTransform \"flat\"\n" + shape, 3,
        1, since + "2:1");
    ExpectOneError("WorldBegin ActiveTransform EndTime " + flat + "ActiveTransform All " + shape, 2, 21,
                   since + "1:36");
}

TEST(ParserErrors, BadTransformTimes) {
    ExpectOneError("TransformTimes 1 1 WorldBegin", 1, 1, "the start 1 must come before the end 1");
    ExpectOneError("TransformTimes 2 1 WorldBegin", 1, 1, "must come before");
}

TEST(ParserErrors, ParameterDeclarations) {
    ExpectOneError("WorldBegin Shape \"s\" \"radius\" 1", 1, 22,
                   "the parameter declaration \"radius\" has one word");
    ExpectOneError("WorldBegin Shape \"s\" \"  \" 1", 1, 22, "is blank");
    ExpectOneError("WorldBegin Shape \"s\" \"float a b\" 1", 1, 22, "has more than two words");
    ExpectOneError("WorldBegin Shape \"s\" \"flaot radius\" 1", 1, 22,
                   "unknown parameter type \"flaot\" in \"flaot radius\"; did you mean \"float\"?");
    ExpectOneError("WorldBegin Shape \"s\" \"normal3 N\" [0 0 1]", 1, 22, "did you mean \"normal\"?");
}

TEST(ParserErrors, ParameterValues) {
    ExpectOneError("WorldBegin Shape \"s\" \"float radius\" [ ]", 1, 22, "\"float radius\" has no values");
    ExpectOneError("WorldBegin Shape \"s\" \"integer i\" [ ]", 1, 22, "\"integer i\" has no values");
    ExpectOneError("WorldBegin Shape \"s\" \"float r\" \"a\"", 1, 22,
                   "the value of \"float r\" must be a number, not a string in quotes");
    ExpectOneError("WorldBegin Shape \"s\" \"float r\" true", 1, 22, "must be a number, not true or false");
    ExpectOneError("WorldBegin Shape \"s\" \"string r\" 3", 1, 22,
                   "must be a string in quotes, not a number");
    ExpectOneError("WorldBegin Shape \"s\" \"bool r\" 1", 1, 22, "must be true or false, not a number");
    ExpectOneError("WorldBegin Shape \"s\" \"texture r\" 1", 1, 22, "must be a string in quotes");
    ExpectOneError("WorldBegin Shape \"s\" \"rgb c\" \"red\"", 1, 22, "must be a number");
    ExpectOneError("WorldBegin Shape \"s\" \"float r\" [1 \"a\"]", 1, 35, "expected a number, found \"a\"");
    ExpectOneError("WorldBegin Shape \"s\" \"string r\" [\"a\" 1]", 1, 38,
                   "expected a string in quotes, found 1");
    ExpectOneError("WorldBegin Shape \"s\" \"bool r\" [true 1]", 1, 37, "expected true or false, found 1");
    ExpectOneError("WorldBegin Shape \"s\" \"float r\" [1 2f]", 1, 35, "expected a number, found 2f");
    ExpectOneError("WorldBegin Shape \"s\" \"float r\" nan", 1, 32, "expected a number, found nan");
    ExpectOneError("WorldBegin Shape \"s\" \"float r\" -inf", 1, 32, "expected a number, found -inf");
    ExpectOneError("WorldBegin Shape \"s\" \"integer i\" 4.0", 1, 34, "expected an integer, found 4.0");
    ExpectOneError("WorldBegin Shape \"s\" \"integer i\" 3000000000", 1, 34,
                   "is too large for a 32-bit integer");
    ExpectOneError("WorldBegin Shape \"s\" \"float r\" 1e99", 1, 32, "1e99 is too large for a 32-bit float");
    ExpectOneError("WorldBegin Shape \"s\" \"float r\" ]", 1, 32, "expected a value, found ]");
    ExpectOneError("WorldBegin Shape \"s\" \"float r\" [1 2\nShape \"t\"", 2, 1,
                   "\"float r\": expected a number, found Shape");
}

TEST(ParserErrors, StringsThatTheLexerRejects) {
    ExpectOneError("WorldBegin\nShape \"sphere\nShape \"t\"", 2, 7, "unterminated string");
    ExpectOneError("WorldBegin Shape \"s\\phere\"", 1, 18, "unknown escape \\p");
}

TEST(ParserErrors, UnbalancedScopes) {
    ExpectOneError("WorldBegin\nAttributeEnd", 2, 1, "AttributeEnd without AttributeBegin");
    ExpectOneError("WorldBegin\nObjectEnd", 2, 1, "ObjectEnd without ObjectBegin");
    ExpectOneError("WorldBegin\n AttributeBegin\nShape \"sphere\"", 2, 2, "AttributeBegin is never closed");
    ExpectOneError("WorldBegin\n ObjectBegin \"a\"\nShape \"sphere\"", 2, 2, "ObjectBegin is never closed");
    ExpectOneError("WorldBegin\nObjectBegin \"a\"\nAttributeEnd\nObjectEnd", 3, 1,
                   "AttributeEnd does not match the ObjectBegin at scene.pbrt:2:1");
    ExpectOneError("WorldBegin ObjectBegin \"a\"\nAttributeBegin\nObjectEnd AttributeEnd ObjectEnd", 3, 1,
                   "ObjectEnd does not match the AttributeBegin at scene.pbrt:2:1");
}

TEST(ParserErrors, ScopesMayNotBeBottomless) {
    std::string text = "WorldBegin\n";
    for (int i = 0; i < 10000; ++i) text += "AttributeBegin ";
    text += "\nAttributeBegin\n";
    const std::string end = [] {
        std::string ends;
        for (int i = 0; i < 10000; ++i) ends += "AttributeEnd ";
        return ends;
    }();
    ExpectOneError(text + end, 3, 1, "more than 10000 nested AttributeBegin");
    // Whatever follows is left unread.
    ExpectOneError(text + "AttributeBegin AttributeBegin Shpae", 3, 1,
                   "more than 10000 nested AttributeBegin");
}

TEST(ParserErrors, Objects) {
    ExpectOneError("WorldBegin\nObjectBegin \"a\"\nObjectInstance \"b\"\nObjectEnd", 3, 1,
                   "ObjectInstance inside of the definition of \"a\" at scene.pbrt:2:1");
    ExpectOneError("WorldBegin\nObjectBegin \"a\" ObjectEnd\nObjectBegin \"a\" ObjectEnd", 3, 1,
                   "object \"a\" is already defined at scene.pbrt:2:1");
    ExpectOneError("WorldBegin\nObjectBegin \"tree\" ObjectEnd\nObjectInstance \"tee\"", 3, 1,
                   "object \"tee\" is not defined; did you mean \"tree\"?");
    const std::vector<Diagnostic> nested =
        ErrorsOf("WorldBegin ObjectBegin \"a\" ObjectBegin \"b\" ObjectEnd");
    ASSERT_EQ(nested.size(), 1u);
    EXPECT_NE(nested[0].message.find("objects do not nest"), std::string::npos);
}

TEST(ParserErrors, Redefinitions) {
    ExpectOneError("WorldBegin\nTexture \"a\" \"float\" \"constant\"\nTexture \"a\" \"float\" \"scale\"", 3,
                   1, "float texture \"a\" is already defined at scene.pbrt:2:1");
    ExpectOneError("WorldBegin Texture \"a\" \"spectrum\" \"constant\"\nTexture \"a\" \"spectrum\" \"mix\"",
                   2, 1, "spectrum texture \"a\" is already defined");
    ExpectOneError(
        "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\n"
        "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"",
        2, 1, "material \"a\" is already defined");
    ExpectOneError(
        "WorldBegin MakeNamedMedium \"a\" \"string type\" \"homogeneous\"\n"
        "MakeNamedMedium \"a\" \"string type\" \"homogeneous\"",
        2, 1, "medium \"a\" is already defined");
}

TEST(ParserErrors, UndefinedNamesAreReportedWhereTheyWereChosen) {
    ExpectOneError(
        "WorldBegin MakeNamedMaterial \"gold\" \"string type\" \"conductor\"\nNamedMaterial \"gould\"\n"
        "Shape \"sphere\" Shape \"sphere\"",
        2, 1, "material \"gould\" is not defined; did you mean \"gold\"?");
    ExpectOneError("WorldBegin\nMediumInterface \"fog\"\nShape \"sphere\"", 2, 1,
                   "medium \"fog\" is not defined");
    ExpectOneError("MediumInterface \"fog\"\nCamera \"perspective\" WorldBegin", 1, 1,
                   "medium \"fog\" is not defined");
    ExpectOneError("WorldBegin MediumInterface \"\" \"fog\"\nLightSource \"point\"", 1, 12,
                   "medium \"fog\" is not defined");
    // Never used by a shape: no error.
    EXPECT_TRUE(ErrorsOf("WorldBegin NamedMaterial \"nothing\"").empty());
}

TEST(ParserErrors, ABadDefinitionIsNotReportedAsMissingToo) {
    ExpectOneError(
        "WorldBegin\nMakeNamedMaterial \"a\" \"float roughness\" x\nNamedMaterial \"a\" Shape \"sphere\"", 2,
        41, "expected a number, found x");
    ExpectOneError("WorldBegin\nMakeNamedMateriall \"a\"\nNamedMaterial \"a\" Shape \"sphere\"", 2, 1,
                   "unknown directive MakeNamedMateriall");
}

TEST(ParserErrors, NamedThingsNeedAType) {
    ExpectOneError("WorldBegin\nMakeNamedMaterial \"a\" \"float roughness\" 1", 2, 1,
                   "needs a parameter \"string type\"");
    ExpectOneError("WorldBegin\nMakeNamedMedium \"a\"", 2, 1,
                   "MakeNamedMedium needs a parameter \"string type\"");
}

TEST(ParserErrors, TextureValueTypes) {
    ExpectOneError("WorldBegin\nTexture \"a\" \"flaot\" \"constant\"", 2, 1,
                   "the value type must be \"float\" or \"spectrum\", not \"flaot\"");
}

TEST(ParserErrors, MovingAreaLights) {
    ExpectOneError(
        "WorldBegin ActiveTransform EndTime Translate 1 0 0 AreaLightSource \"diffuse\"\nShape \"sphere\"", 2,
        1, "a moving shape cannot be an area light");
}

TEST(ParserErrors, AttributeTargets) {
    ExpectOneError("WorldBegin\nAttribute \"shapes\" \"float radius\" 1", 2, 1,
                   "unknown target \"shapes\"; known are shape, light, material, medium and texture; did you "
                   "mean \"shape\"?");
}

TEST(ParserErrors, TooManyAttributes) {
    std::string text = "WorldBegin\n";
    for (int i = 0; i <= 1000; ++i) text += "Attribute \"shape\" \"float a" + std::to_string(i) + "\" 1\n";
    ExpectOneError(text, 1002, 19, "more than 1000 parameters by Attribute");
}

TEST(ParserErrors, ColorSpaces) {
    ExpectOneError("ColorSpace \"sRBG\"\nWorldBegin", 1, 1,
                   "unknown colour space \"sRBG\"; did you mean \"srgb\"?");
}

TEST(ParserErrors, Options) {
    ExpectOneError("Option \"sede\" 3\nWorldBegin", 1, 1, "unknown option \"sede\"; did you mean \"seed\"?");
    ExpectOneError("Option \"seed\" 3.5\nWorldBegin", 1, 15, "expected an integer, found 3.5");
    ExpectOneError("Option \"forcediffuse\" 1\nWorldBegin", 1, 23,
                   "expected true or false without quotes, found 1");
    ExpectOneError("Option \"wavefront\" \"true\"\nWorldBegin", 1, 20,
                   "expected true or false without quotes");
    ExpectOneError("Option \"msereferenceout\" a\nWorldBegin", 1, 26, "expected a string in quotes, found a");
    ExpectOneError(
        "Option \"rendercoordsys\" \"wrld\"\nWorldBegin", 1, 25,
        "expected \"camera\", \"cameraworld\", \"world\", found \"wrld\"; did you mean \"world\"?");
    ExpectOneError("Option seed 3\nWorldBegin", 1, 8, "expected a name in quotes, found seed");
}

TEST(ParserErrors, SeveralErrorsAreReportedTogetherInTheOrderOfTheFile) {
    const std::vector<Diagnostic> errors = ErrorsOf(
        "Flim \"rgb\" \"integer xresolution\" 5\nWorldBegin\nActiveTransform Both\nShape \"sphere\" \"flaot "
        "radius\" "
        "2 \"bool b\" 1\n"
        "Translate 1 2\nShape \"sphere\"\nAttributeEnd\nMaterial \"diffuse\" \"float x\" [1 2");
    ASSERT_EQ(errors.size(), 7u);
    const int lines[] = {1, 3, 4, 4, 6, 7, 8};
    for (size_t i = 0; i < errors.size(); ++i)
        EXPECT_EQ(errors[i].loc.line, lines[i]) << errors[i].ToString();
}

TEST(ParserErrors, StopsAfterTwentyErrors) {
    std::string text = "WorldBegin\n";
    for (int i = 0; i < 100; ++i) text += "AttributeEnd\n";
    const std::vector<Diagnostic> errors = ErrorsOf(text);
    ASSERT_EQ(errors.size(), 21u);
    EXPECT_EQ(errors.back().message, "stopped after 20 errors");
}

TEST(ParserErrors, ByteOrderMarks) {
    ExpectOneError("\xFF\xFEW", 1, 1, "UTF-16");
    ExpectOneError("\xEF\xBB\xBFWorldBegin", 1, 1, "byte-order mark");
}

TEST(ParserErrors, AV3SceneSaysSoOnceAndNamesEachNewSpelling) {
    const std::vector<Diagnostic> errors = ErrorsOf(
        "Film \"image\" \"integer xresolution\" 5\nSampler \"lowdiscrepancy\"\nWorldBegin\n"
        "Material \"matte\" \"rgb Kd\" [1 1 1]\nShape \"sphere\" \"point P\" [0 0 0]\nWorldEnd");
    ASSERT_EQ(errors.size(), 5u);
    EXPECT_EQ(errors[0].ToString(),
              "scene.pbrt:1:1: error: this is a pbrt-v3 scene, and Lacquer reads pbrt-v4 (lacquer convert "
              "--upgrade makes one of it): Film \"image\" is "
              "pbrt-v3; in "
              "pbrt-v4 it is \"rgb\"");
    EXPECT_EQ(errors[1].message, "Sampler \"lowdiscrepancy\" is pbrt-v3; in pbrt-v4 it is \"paddedsobol\"");
    EXPECT_EQ(errors[2].message, "Material \"matte\" is pbrt-v3; in pbrt-v4 it is \"diffuse\"");
    EXPECT_EQ(errors[3].message, "the parameter type \"point\" is pbrt-v3; in pbrt-v4 it is \"point3\"");
    EXPECT_EQ(errors[4].message,
              "the directive WorldEnd is pbrt-v3; in pbrt-v4 the world block ends with the file: "
              "remove the line");
    EXPECT_EQ(errors[4].loc.ToString(), "scene.pbrt:6:1");
}

TEST(ParserErrors, V3SpellingsOfPluginsAndParameters) {
    const char* v3 = "this is a pbrt-v3 scene";
    ExpectOneError("Camera \"environment\"\nWorldBegin", 1, 1, "it is \"spherical\"");
    ExpectOneError("Integrator \"path\" \"float rrthreshold\" 1 WorldBegin", 1, 19, v3);
    ExpectOneError("Integrator \"directlighting\" \"string strategy\" \"all\" WorldBegin", 1, 1,
                   "it is \"path\"");
    ExpectOneError("PixelFilter \"box\" \"float xwidth\" 1 WorldBegin", 1, 19, "it is \"float xradius\"");
    ExpectOneError("Film \"rgb\" \"float scale\" 2 WorldBegin", 1, 12, "it is \"float iso\"");
    ExpectOneError("WorldBegin MakeNamedMaterial \"a\" \"string type\" \"glass\" \"float index\" 1.5", 1, 12,
                   "it is \"dielectric\"");
    ExpectOneError("WorldBegin Material \"dielectric\" \"float index\" 1.5", 1, 34, "it is \"eta\"");
    ExpectOneError("WorldBegin Texture \"a\" \"color\" \"constant\"", 1, 12, "it is \"spectrum\"");
    ExpectOneError("WorldBegin LightSource \"infinite\" \"string mapname\" \"a.exr\"", 1, 35,
                   "it is \"string filename\"");
    ExpectOneError("WorldBegin AreaLightSource \"area\"", 1, 12, "it is \"diffuse\"");
    ExpectOneError("WorldBegin Shape \"trianglemesh\" \"float uv\" [0 0]", 1, 33, "it is \"point2 uv\"");
    ExpectOneError("WorldBegin Shape \"sphere\" \"bool b\" \"true\"", 1, 27, "stand without quotes");
    ExpectOneError("WorldBegin MakeNamedMedium \"a\" \"string type\" \"heterogeneous\"", 1, 12,
                   "it is \"uniformgrid\"");
    ExpectOneError("WorldBegin Texture \"a\" \"spectrum\" \"imagemap\" \"bool trilinear\" true", 1, 46,
                   "it is \"string filter\"");
}

TEST(ParserErrors, V4ScenesAreNotTakenForV3) {
    EXPECT_TRUE(
        ErrorsOf("WorldBegin Texture \"a\" \"spectrum\" \"mix\" \"rgb tex1\" [0 0 0] Material \"interface\" "
                 "\"rgb Kd\" [1 1 1] LightSource \"point\" \"float scale\" 2 Shape \"s\" \"point2 uv\" [0 0]")
            .empty());
}

}  // namespace
}  // namespace lacquer::test::parser_errors_test
