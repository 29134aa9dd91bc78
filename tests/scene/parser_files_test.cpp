// Scenes of several files: Include, Import, search folders, gzip, speed of long number lists.
#include <gtest/gtest.h>
#include <zlib.h>

#include <chrono>

#include "scene/scene_text.h"

namespace lacquer::test::parser_files_test {
namespace {

std::vector<Diagnostic> FileErrorsOf(const std::string& path) {
    try {
        ParseFile(path, nullptr);
    } catch (const SceneErrors& e) {
        return e.Diagnostics();
    }
    return {};
}

void ExpectOneFileError(const std::string& path, const std::string& place, const std::string& part) {
    const std::vector<Diagnostic> errors = FileErrorsOf(path);
    ASSERT_EQ(errors.size(), 1u) << (errors.empty() ? "no error"
                                                    : errors[0].ToString() + "\n" + errors.back().ToString());
    EXPECT_EQ(errors[0].loc.ToString(), place);
    EXPECT_NE(errors[0].message.find(part), std::string::npos) << errors[0].message;
}

TEST(Include, ChangesTheStateOfTheIncluder) {
    const TestFolder folder;
    folder.Write("geometry/part.pbrt", "Translate 1 0 0 Material \"conductor\"");
    const std::string main =
        folder.Write("main.pbrt", "WorldBegin Include \"geometry/part.pbrt\" Shape \"sphere\"");
    const SceneDescription scene = ParseFile(main, nullptr);
    ASSERT_EQ(scene.shapes.size(), 1u);
    EXPECT_EQ(scene.shapes[0].material.index, 1);
    EXPECT_EQ(scene.shapes[0].worldFromObject.start.Point({0, 0, 0}), Vec3(1, 0, 0));
}

TEST(Include, PathsAreRelativeToTheTopLevelFile) {
    const TestFolder folder;
    folder.Write("sub/a.pbrt", "Include \"b.pbrt\"");
    folder.Write("b.pbrt", "Shape \"sphere\"");
    folder.Write("sub/b.pbrt", "Shape \"disk\"");
    const SceneDescription scene =
        ParseFile(folder.Write("main.pbrt", "WorldBegin Include \"sub/a.pbrt\""), nullptr);
    EXPECT_EQ(scene.shapes.at(0).type, "sphere");
    EXPECT_EQ(scene.FilesOf(scene.shapes[0]).Resolve("sub/a.pbrt"), folder.Path("sub/a.pbrt"));
}

TEST(Include, AParameterListMayGoOnBehindTheEndOfAFile) {
    const TestFolder folder;
    folder.Write("a.pbrt", "Shape \"sphere\" \"float radius\" 2");
    const std::string main =
        folder.Write("main.pbrt", "WorldBegin Include \"a.pbrt\" \"float zmin\" -1 Shape \"disk\"");
    const SceneDescription scene = ParseFile(main, nullptr);
    EXPECT_EQ(scene.shapes.at(0).parameters.size(), 2u);
    EXPECT_EQ(scene.shapes.at(0).parameters.at(1).loc.file, main);
}

TEST(Include, ErrorsNameTheIncludedFile) {
    const TestFolder folder;
    const std::string part = folder.Write("a.pbrt", "\n  Shpae \"sphere\"");
    ExpectOneFileError(folder.Write("main.pbrt", "WorldBegin Include \"a.pbrt\" Shape \"disk\""),
                       part + ":2:3", "unknown directive Shpae");
}

TEST(Include, AMissingFileIsAFileErrorAtItsPlace) {
    const TestFolder folder;
    const std::string main =
        folder.Write("main.pbrt", "WorldBegin\n Include \"no.pbrt\"\nNamedMaterial \"x\" Shape \"s\"");
    try {
        ParseFile(main, nullptr);
        FAIL();
    } catch (const FileError& e) {
        EXPECT_EQ(e.Loc().ToString(), main + ":2:2");
        EXPECT_EQ(e.Message(), "no.pbrt: cannot be opened: No such file or directory (named by Include)");
    }
    // Together with another error it is one of several.
    EXPECT_EQ(FileErrorsOf(folder.Write("two.pbrt", "WorldBegin Include \"no.pbrt\" AttributeEnd")).size(),
              2u);
}

TEST(Include, AFileThatIncludesItselfIsAnError) {
    const TestFolder folder;
    const std::string main = folder.Write("main.pbrt", "WorldBegin\nInclude \"b.pbrt\"");
    const std::string b = folder.Write("b.pbrt", "Shape \"sphere\" Include \"./main.pbrt\" Shape \"disk\"");
    ExpectOneFileError(main, b + ":1:16", "the file includes itself");
    const std::string own = folder.Write("own.pbrt", "WorldBegin Import \"own.pbrt\"");
    ExpectOneFileError(own, own + ":1:12", "the file includes itself");
}

TEST(Include, ChainsOfMoreThan64FilesAreAnError) {
    const TestFolder folder;
    for (int i = 0; i < 70; ++i)
        folder.Write(
            "f" + std::to_string(i) + ".pbrt",
            (i == 0 ? "WorldBegin " : "") + std::string("Include \"f") + std::to_string(i + 1) + ".pbrt\"");
    ExpectOneFileError(folder.Path("f0.pbrt"), folder.Path("f63.pbrt") + ":1:1", "more than 64 files deep");
}

TEST(Include, ReadsGzip) {
    const TestFolder folder;
    const std::string path = folder.Path("a.pbrt.gz");
    gzFile file = gzopen(path.c_str(), "wb");
    gzputs(file, "Shape \"sphere\"");
    gzclose(file);
    const std::string main = folder.Write("main.pbrt", "WorldBegin Include \"a.pbrt.gz\"");
    EXPECT_EQ(ParseFile(main, nullptr).shapes.size(), 1u);
}

TEST(Import, WorksOnACopyOfTheState) {
    const TestFolder folder;
    folder.Write("part.pbrt", "Shape \"sphere\" Translate 5 0 0 Material \"dielectric\" Shape \"disk\"");
    const SceneDescription scene = ParseFile(
        folder.Write(
            "main.pbrt",
            "WorldBegin Translate 1 0 0 Material \"conductor\" Import \"part.pbrt\" Shape \"cylinder\""),
        nullptr);
    ASSERT_EQ(scene.shapes.size(), 3u);
    // What is imported comes where the importing file ends.
    EXPECT_EQ(scene.shapes[0].type, "cylinder");
    EXPECT_EQ(scene.shapes[0].worldFromObject.start.Point({0, 0, 0}), Vec3(1, 0, 0));
    EXPECT_EQ(scene.materials.at(size_t(scene.shapes[0].material.index)).type, "conductor");
    EXPECT_EQ(scene.materials.at(size_t(scene.shapes[1].material.index)).type, "conductor");
    EXPECT_EQ(scene.shapes[2].worldFromObject.start.Point({0, 0, 0}), Vec3(6, 0, 0));
    EXPECT_EQ(scene.materials.at(size_t(scene.shapes[2].material.index)).type, "dielectric");
}

TEST(Import, DoesNotSeeTheImportersCoordinateSystems) {
    const TestFolder folder;
    folder.Write("part.pbrt", "CoordSysTransform \"here\" CoordinateSystem \"there\"");
    const SceneDescription scene = ParseFile(
        folder.Write("main.pbrt", "WorldBegin CoordinateSystem \"here\" Import \"part.pbrt\""), nullptr);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_FALSE(scene.coordinateSystems.contains("there"));
}

TEST(Import, SharesTheNamesOfTheScene) {
    const TestFolder folder;
    folder.Write("part.pbrt",
                 "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" NamedMaterial \"b\" Shape \"sphere\" "
                 "Texture \"t\" \"float\" \"constant\" ObjectBegin \"o\" Shape \"disk\" ObjectEnd "
                 "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" LightSource \"point\"");
    const SceneDescription scene = ParseFile(
        folder.Write(
            "main.pbrt",
            "WorldBegin NamedMaterial \"a\" MediumInterface \"m\" Shape \"sphere\" ObjectInstance \"o\" "
            "Import \"part.pbrt\" MakeNamedMaterial \"b\" \"string type\" \"diffuse\""),
        nullptr);
    EXPECT_EQ(scene.namedMaterials.size(), 2u);
    EXPECT_EQ(scene.textures.size(), 1u);
    EXPECT_EQ(scene.lights.size(), 1u);
    EXPECT_EQ(scene.media.size(), 1u);
    EXPECT_EQ(scene.objects.size(), 1u);
}

TEST(Import, RedefinitionsAreFoundWhereTheFilesAreMerged) {
    const TestFolder folder;
    const std::string part =
        folder.Write("part.pbrt", "\nMakeNamedMaterial \"a\" \"string type\" \"diffuse\"");
    const std::string main = folder.Write(
        "main.pbrt", "WorldBegin Import \"part.pbrt\"\nMakeNamedMaterial \"a\" \"string type\" \"diffuse\"");
    ExpectOneFileError(main, part + ":2:1", "material \"a\" is already defined at " + main + ":2:1");
}

TEST(Import, InsideOfAnObjectItsShapesJoinTheObject) {
    const TestFolder folder;
    folder.Write("part.pbrt", "Shape \"sphere\"");
    const SceneDescription scene =
        ParseFile(folder.Write("main.pbrt",
                               "WorldBegin ObjectBegin \"o\" Import \"part.pbrt\" Shape \"disk\" ObjectEnd"),
                  nullptr);
    EXPECT_EQ(scene.shapes.size(), 0u);
    EXPECT_EQ(scene.objects.at(0).shapes.size(), 2u);
}

TEST(Import, IsForTheWorldBlockOnly) {
    const TestFolder folder;
    const std::string part = folder.Write("part.pbrt", "Film \"rgb\"");
    const std::string main = folder.Write("main.pbrt", "WorldBegin Import \"part.pbrt\"");
    ExpectOneFileError(main, part + ":1:1", "Film is not allowed in an imported file");
    const std::string early = folder.Write("early.pbrt", "Import \"empty.pbrt\" WorldBegin");
    folder.Write("empty.pbrt", "");
    ExpectOneFileError(early, early + ":1:1", "Import is not allowed before WorldBegin");
}

TEST(Import, ScopesDoNotReachAcrossIt) {
    const TestFolder folder;
    const std::string open = folder.Write("open.pbrt", "AttributeBegin");
    const std::string close = folder.Write("close.pbrt", "AttributeEnd");
    ExpectOneFileError(folder.Write("a.pbrt", "WorldBegin Import \"open.pbrt\""), open + ":1:1",
                       "never closed");
    ExpectOneFileError(folder.Write("b.pbrt", "WorldBegin AttributeBegin Import \"close.pbrt\" AttributeEnd"),
                       close + ":1:1", "AttributeEnd without AttributeBegin");
    const std::string objectEnd = folder.Write("object.pbrt", "ObjectEnd");
    ExpectOneFileError(
        folder.Write("c.pbrt", "WorldBegin ObjectBegin \"o\" Import \"object.pbrt\" ObjectEnd"),
        objectEnd + ":1:1", "ObjectEnd without ObjectBegin");
}

TEST(Files, SeveralCountAsOneSceneEachWithItsFolder) {
    const TestFolder folder;
    const std::string first =
        folder.Write("one/a.pbrt", "Film \"gbuffer\" WorldBegin AttributeBegin Translate 1 0 0");
    const std::string second = folder.Write("two/b.pbrt", "Include \"c.pbrt\" Shape \"sphere\" AttributeEnd");
    folder.Write("two/c.pbrt", "Shape \"disk\"");
    const SceneDescription scene = ParseFiles({first, second}, nullptr);
    EXPECT_EQ(scene.film.type, "gbuffer");
    EXPECT_EQ(scene.film.directory, 0);
    ASSERT_EQ(scene.shapes.size(), 2u);
    EXPECT_EQ(scene.shapes[1].directory, 1);
    EXPECT_EQ(scene.shapes[1].worldFromObject.start.Point({0, 0, 0}), Vec3(1, 0, 0));
    EXPECT_EQ(scene.FilesOf(scene.shapes[1]).Resolve("c.pbrt"), folder.Path("two/c.pbrt"));
}

TEST(Files, ATextAmongThemLooksInTheCurrentDirectory) {
    const TestFolder folder;
    const std::string first = folder.Write("one/a.pbrt", "WorldBegin AttributeBegin Translate 1 0 0");
    const SceneDescription scene = ParseInputs(
        {{first, std::nullopt}, {"<stdin>", "Shape \"sphere\" AttributeEnd Shape \"disk\""}}, nullptr);
    ASSERT_EQ(scene.shapes.size(), 2u);
    EXPECT_EQ(scene.shapes[0].worldFromObject.start.Point({0, 0, 0}), Vec3(1, 0, 0));
    EXPECT_EQ(scene.shapes[1].loc.ToString(), "<stdin>:1:29");
    EXPECT_EQ(scene.FilesOf(scene.shapes[0]).Resolve("x.ply"), "x.ply");
}

TEST(Files, AMissingTopLevelFileIsAFileError) {
    const TestFolder folder;
    EXPECT_THROW(ParseFile(folder.Path("none.pbrt"), nullptr), FileError);
    EXPECT_THROW(ParseFile(folder.Path(""), nullptr), FileError);
}

TEST(Files, RandomBytesEndInErrorsAndNotInACrash) {
    // A linear congruential generator; the text is mostly tokens of the format, so that it reaches far into
    // the parser.
    const char* pieces[] = {"Shape",
                            "\"sphere\"",
                            "\"float radius\"",
                            "[",
                            "]",
                            "1",
                            "-2.5e3",
                            "\"",
                            "WorldBegin",
                            "AttributeBegin",
                            "AttributeEnd",
                            "#",
                            "\n",
                            "true",
                            "Material",
                            "\"integer i\"",
                            "ObjectBegin",
                            "ObjectEnd",
                            "Translate",
                            "\\",
                            "Scale",
                            "0",
                            "MakeNamedMedium",
                            "\"string type\"",
                            "Transform",
                            "MediumInterface",
                            "Texture",
                            "\"rgb c\"",
                            "Option",
                            "Attribute",
                            "\xff\x01",
                            "LookAt"};
    uint64_t state = 1;
    for (int round = 0; round < 2000; ++round) {
        std::string text;
        for (int i = 0; i < 60; ++i) {
            state = state * 6364136223846793005ull + 1442695040888963407ull;
            text += pieces[(state >> 33) % std::size(pieces)];
            if ((state >> 60) > 3) text += ' ';
        }
        EXPECT_LE(ErrorsOf(text).size(), 21u);
    }
}

TEST(Files, LongNumberListsAreReadFastEnough) {
    std::string numbers = "WorldBegin Shape \"trianglemesh\" \"point3 P\" [\n";
    for (int i = 0; i < 300000; ++i) numbers += std::to_string(0.001 * i) + (i % 3 == 2 ? "\n" : " ");
    numbers += "] \"integer indices\" [";
    for (int i = 0; i < 300000; ++i) numbers += std::to_string(i) + " ";
    numbers += "]";
    const double megabytes = double(numbers.size()) / 1e6;
    const auto start = std::chrono::steady_clock::now();
    const SceneDescription scene = ParseText(std::move(numbers), "s", "", nullptr);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_EQ(scene.shapes.at(0).parameters.at(0).floats.size(), 300000u);
    EXPECT_EQ(scene.shapes.at(0).parameters.at(1).integers.back(), 299999);
    RecordProperty("megabytesPerSecond", std::to_string(megabytes / seconds));
    // More than 100 MB/s on an idle machine with optimization; the bound is for sanitizers and busy machines.
    EXPECT_LT(seconds, 5 * megabytes / 10);
}

}  // namespace
}  // namespace lacquer::test::parser_files_test
