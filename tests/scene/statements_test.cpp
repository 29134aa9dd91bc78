// Scene files as they are written: formatting changes the looks and nothing else.
#include "pbrt/scene/statements.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "compare/fingerprint.h"
#include "pbrt/scene/parser.h"
#include "pbrt/scene/scene_to_ply.h"
#include "pbrt/scene/v3_upgrade.h"

namespace lacquer::statements_test {
namespace {

namespace fs = std::filesystem;

std::string TextOf(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string Format(const std::string& text) { return WriteSceneText(ReadSceneText(SourceOf("text", text))); }

std::string Upgraded(const std::string& text, std::vector<Diagnostic>* diagnostics = nullptr) {
    SceneText scene = ReadSceneText(SourceOf("text", text));
    const std::vector<Diagnostic> found = UpgradeFromV3(&scene);
    if (diagnostics) *diagnostics = found;
    return WriteSceneText(scene);
}

/// All scene files below a folder that is looked for beside the sources.
std::vector<fs::path> ScenesBelow(const fs::path& folder) {
    std::vector<fs::path> scenes;
    std::error_code error;
    for (const auto& entry : fs::recursive_directory_iterator(folder, error))
        if (entry.path().extension() == ".pbrt") scenes.push_back(entry.path());
    std::sort(scenes.begin(), scenes.end());
    return scenes;
}

/// Formats each, and compares what the two texts mean. Pieces that are no scenes by themselves are only
/// formatted.
/// @return number of scenes compared
int ExpectSameScenes(const fs::path& folder) {
    int compared = 0;
    for (const fs::path& path : ScenesBelow(folder)) {
        SCOPED_TRACE(path.string());
        const std::string text = TextOf(path), formatted = Format(text);
        EXPECT_EQ(Format(formatted), formatted);
        uint64_t before = 0;
        try {
            before = compare::FingerprintOf(ParseFile(path.string(), nullptr));
        } catch (const std::exception&) {
            continue;
        }
        EXPECT_EQ(
            compare::FingerprintOf(ParseText(formatted, "formatted", path.parent_path().string(), nullptr)),
            before);
        ++compared;
    }
    return compared;
}

TEST(SceneText, FormattedConformanceScenesMeanTheSame) {
    EXPECT_GE(ExpectSameScenes(fs::path(LACQUER_SOURCE_DIR) / "tests/conformance"), 90);
}

TEST(SceneText, FormattedScenesOfOursMeanTheSame) {
    EXPECT_GE(ExpectSameScenes(fs::path(LACQUER_SOURCE_DIR) / "scenes"), 1);
}

TEST(SceneText, FormattedRealScenesMeanTheSame) {
    const fs::path folder = fs::path(LACQUER_SOURCE_DIR) / "../shared/scenes";
    if (!fs::exists(folder)) GTEST_SKIP() << "no real scenes at hand";
    EXPECT_GE(ExpectSameScenes(folder), 3);
}

TEST(SceneText, TheComparisonSeesOtherNumbers) {
    const auto fingerprint = [](const std::string& text) {
        return compare::FingerprintOf(ParseText(text, "t", ".", nullptr));
    };
    EXPECT_NE(fingerprint("WorldBegin Shape \"sphere\" \"float radius\" 1"),
              fingerprint("WorldBegin Shape \"sphere\" \"float radius\" 1.0000001"));
}

TEST(SceneText, LongListsAreBroken) {
    std::string text = "Shape \"trianglemesh\" \"point3 P\" [";
    for (int i = 0; i < 300; ++i) text += " " + std::to_string(i);
    const std::string formatted = Format(text + "]");
    size_t longest = 0;
    for (size_t at = 0, end; at < formatted.size(); at = end + 1) {
        end = formatted.find('\n', at);
        longest = std::max(longest, end - at);
    }
    EXPECT_LE(longest, 112u);
    EXPECT_EQ(Format(formatted), formatted);
}

TEST(SceneText, BlankLinesAndScopesStay) {
    EXPECT_EQ(
        Format("WorldBegin\n\n\n\nAttributeBegin\nObjectBegin \"a\" Shape \"sphere\" # s\n ObjectEnd "
               "AttributeEnd"),
        "WorldBegin\n\nAttributeBegin\n    ObjectBegin \"a\"\n        Shape \"sphere\"  # s\n    ObjectEnd\n"
        "AttributeEnd\n");
    EXPECT_EQ(Format("AttributeEnd AttributeEnd Identity"), "AttributeEnd\nAttributeEnd\nIdentity\n");
    EXPECT_EQ(Format(""), "");
    EXPECT_EQ(Format("# only\r\n\r\n# comments\r\n"), "# only\n\n# comments\n");
}

TEST(SceneText, MeshesGoToTheirFiles) {
    SceneText scene = ReadSceneText(SourceOf("text",
                                             "Shape \"trianglemesh\" \"float alpha\" 1 \"point3 P\" [0 0 0 1 "
                                             "0 0 0 1 .1] \"integer indices\" [2 1 0]"));
    std::string bytes;
    EXPECT_EQ(MoveMeshesToPly(&scene, 2, [](const std::string&) { return "no.ply"; }), 0);
    EXPECT_EQ(MoveMeshesToPly(&scene, 1, [&](const std::string& b) { return bytes = b, "m.ply"; }), 1);
    EXPECT_EQ(WriteSceneText(scene), "Shape \"plymesh\" \"string filename\" \"m.ply\" \"float alpha\" 1\n");
    const size_t head = bytes.find("end_header\n") + 11;
    ASSERT_EQ(bytes.size(), head + 9 * 4 + 1 + 3 * 4);
    float z = 0;
    std::memcpy(&z, bytes.data() + head + 8 * 4, 4);
    EXPECT_EQ(z, .1f);
}

// ---- From pbrt-v3 ----

TEST(UpgradeV3, TypesAndValues) {
    EXPECT_EQ(Upgraded("LightSource \"point\" \"point from\" [0 1 2] \"color I\" [1 2 3]"),
              "LightSource \"point\" \"point3 from\" [ 0 1 2 ] \"rgb I\" [ 1 2 3 ]\n");
    EXPECT_EQ(Upgraded("Shape \"x\" \"vector a\" [0 1 2] \"bool b\" \"true\""),
              "Shape \"x\" \"vector3 a\" [ 0 1 2 ] \"bool b\" true\n");
}

TEST(UpgradeV3, Options) {
    EXPECT_EQ(Upgraded("PixelFilter \"gaussian\" \"float xwidth\" 3 \"float alpha\" 8"),
              "PixelFilter \"gaussian\" \"float xradius\" 3 \"float sigma\" 0.25 \"float yradius\" 2\n");
    EXPECT_EQ(Upgraded("Film \"image\" \"float scale\" 2 \"float maxsampleluminance\" 5"),
              "Film \"rgb\" \"float iso\" 200 \"float maxcomponentvalue\" 5\n");
    EXPECT_EQ(Upgraded("Sampler \"maxmindist\""), "Sampler \"pmj02bn\"\n");
    EXPECT_EQ(Upgraded("Sampler \"02sequence\""), "Sampler \"paddedsobol\"\n");
    EXPECT_EQ(Upgraded("Sampler \"lowdiscrepancy\""), "Sampler \"paddedsobol\"\n");
    EXPECT_EQ(Upgraded("Sampler \"random\""), "Sampler \"independent\"\n");
    EXPECT_EQ(Upgraded("Integrator \"directlighting\" \"integer maxdepth\" 9"),
              "Integrator \"path\" \"integer maxdepth\" 1\n");
    EXPECT_EQ(Upgraded("Integrator \"sppm\" \"integer imagewritefrequency\" 9 \"integer numiterations\" 3"),
              "Integrator \"sppm\"\n");
    EXPECT_EQ(
        Upgraded("Integrator \"volpath\" \"float rrthreshold\" 1 \"string lightsamplestrategy\" \"spatial\""),
        "Integrator \"volpath\" \"string lightsampler\" \"bvh\"\n");
    EXPECT_EQ(Upgraded("Integrator \"path\" \"string lightsamplestrategy\" \"power\""),
              "Integrator \"path\" \"string lightsampler\" \"power\"\n");
    EXPECT_EQ(Upgraded("Camera \"environment\""),
              "Camera \"spherical\" \"string mapping\" \"equirectangular\"\n");
    EXPECT_EQ(Upgraded("Camera \"realistic\" \"bool simpleweighting\" \"true\""), "Camera \"realistic\"\n");
    EXPECT_EQ(Upgraded("MakeNamedMedium \"m\" \"string type\" \"heterogeneous\""),
              "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\"\n");
    EXPECT_EQ(Upgraded("TransformBegin TransformEnd # t\nWorldEnd # w"),
              "AttributeBegin\nAttributeEnd  # t\n# w\n");
}

TEST(UpgradeV3, Textures) {
    EXPECT_EQ(Upgraded("Texture \"a\" \"color\" \"scale\" \"texture tex1\" \"b\" \"color tex2\" [2 2 2]"),
              "Texture \"a\" \"spectrum\" \"scale\" \"texture tex\" \"b\" \"float scale\" 2\n");
    EXPECT_EQ(Upgraded("Texture \"a\" \"color\" \"scale\" \"color tex1\" [2 2 2] \"texture tex2\" \"b\""),
              "Texture \"a\" \"spectrum\" \"scale\" \"float scale\" 2 \"texture tex\" \"b\"\n");
    EXPECT_EQ(
        Upgraded("Texture \"a\" \"color\" \"imagemap\" \"bool trilinear\" \"true\" \"bool gamma\" \"true\""),
        "Texture \"a\" \"spectrum\" \"imagemap\" \"string filter\" \"trilinear\" \"string encoding\" "
        "\"sRGB\"\n");
    EXPECT_EQ(
        Upgraded("Texture \"a\" \"float\" \"imagemap\" \"float gamma\" 2.2"),
        "Texture \"a\" \"float\" \"imagemap\" \"string encoding\" \"gamma 2.2\" \"string filter\" \"EWA\"\n");
}

TEST(UpgradeV3, Materials) {
    EXPECT_EQ(Upgraded("Material \"matte\" \"texture Kd\" \"t\" \"texture bumpmap\" \"b\""),
              "Material \"diffuse\" \"texture reflectance\" \"t\" \"texture displacement\" \"b\"\n");
    EXPECT_EQ(Upgraded("Material \"plastic\""),
              "Material \"coateddiffuse\" \"rgb reflectance\" [ 0.25 0.25 0.25 ] \"float roughness\" 0.1\n");
    EXPECT_EQ(Upgraded("MakeNamedMaterial \"a\" \"string type\" \"glass\" \"float index\" 2"),
              "MakeNamedMaterial \"a\" \"string type\" \"dielectric\" \"float eta\" 2\n");
    EXPECT_EQ(Upgraded("Material \"metal\" \"float uroughness\" .2"),
              "Material \"conductor\" \"float uroughness\" .2\n");
    EXPECT_EQ(Upgraded("Material \"mirror\""),
              "Material \"conductor\" \"rgb reflectance\" [ 0.9 0.9 0.9 ]\n");
    EXPECT_EQ(Upgraded("Material \"kdsubsurface\" \"color Kd\" [1 1 1]"),
              "Material \"subsurface\" \"rgb reflectance\" [ 1 1 1 ]\n");
    EXPECT_EQ(Upgraded("Material \"translucent\" \"texture Kd\" \"t\""),
              "Material \"diffusetransmission\" \"texture reflectance\" \"t\" \"texture transmittance\" "
              "\"t\" \"float "
              "scale\" 0.5\n");
    EXPECT_EQ(
        Upgraded("Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"color "
                 "amount\" [.3 .3 .3]"),
        "Material \"mix\" \"string materials\" [ \"b\" \"a\" ] \"float amount\" 0.3\n");
    EXPECT_EQ(Upgraded("Material \"none\" Material \"\""),
              "Material \"interface\"\nMaterial \"interface\"\n");
}

TEST(UpgradeV3, LightsAndShapes) {
    std::vector<Diagnostic> said;
    EXPECT_EQ(Upgraded("LightSource \"infinite\" \"string mapname\" \"a.exr\" \"rgb scale\" [2 2 2] "
                       "\"integer samples\" 4",
                       &said),
              "LightSource \"infinite\" \"string filename\" \"a.exr\" \"float scale\" 2\n");
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].ToString().find("text:1:24: warning: the image of an infinite light is square"),
              std::string::npos)
        << said[0].ToString();
    EXPECT_EQ(Upgraded("LightSource \"point\" \"rgb I\" [1 2 3] \"rgb scale\" [2 1 .5]"),
              "LightSource \"point\" \"rgb I\" [ 2 2 1.5 ]\n");
    EXPECT_EQ(Upgraded("AreaLightSource \"area\" \"integer nsamples\" 2"), "AreaLightSource \"diffuse\"\n");
    EXPECT_EQ(Upgraded("Shape \"loopsubdiv\" \"integer nlevels\" 2"),
              "Shape \"loopsubdiv\" \"integer levels\" 2\n");
    EXPECT_EQ(
        Upgraded(
            "Shape \"trianglemesh\" \"float st\" [0 0] \"float shadowalpha\" 1 \"bool discarddegenerateUVs\" "
            "\"true\""),
        "Shape \"trianglemesh\" \"point2 uv\" [ 0 0 ]\n");
    EXPECT_EQ(Upgraded("Shape \"trianglemesh\" \"float uv\" [0 0]"),
              "Shape \"trianglemesh\" \"point2 uv\" [ 0 0 ]\n");
}

TEST(UpgradeV3, CommentsOfWhatGoesStay) {
    EXPECT_EQ(Upgraded("LightSource \"point\"\n# many\n\"integer nsamples\" 4 # four\n\"rgb I\" [1 1 1]"),
              "# many\n# four\nLightSource \"point\" \"rgb I\" [ 1 1 1 ]\n");
}

TEST(UpgradeV3, ScenesOfV4Stay) {
    for (const fs::path& path : ScenesBelow(fs::path(LACQUER_SOURCE_DIR) / "tests/conformance")) {
        const std::string text = TextOf(path);
        // The defaults of these two differ: a scene that does not say them is taken as one of pbrt-v3.
        if (text.find("gaussian") != std::string::npos || text.find("imagemap") != std::string::npos)
            continue;
        EXPECT_EQ(Upgraded(text), Format(text)) << path;
    }
}

}  // namespace
}  // namespace lacquer::statements_test
