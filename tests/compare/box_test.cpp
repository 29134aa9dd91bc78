// Boxes from the command line and from scene files.
#include "compare/box.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "support/statistics.h"

namespace lacquer::compare::box_test {
namespace {

constexpr Int2 kSize{640, 360};

Bounds2i Pixels(int x0, int x1, int y0, int y1) { return {{x0, y0}, {x1, y1}}; }

/// The message of the error, empty if there is none.
std::string ErrorOf(const std::string& text, Int2 size = kSize) {
    try {
        ParseBox(text, size);
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
    return {};
}

TEST(Box, FractionsGoToTheNearestEdges) {
    const Box box = ParseBox("ball:0.1,0.5,0.2,0.3", kSize);
    EXPECT_EQ(box.name, "ball");
    EXPECT_EQ(box.pixels, Pixels(64, 320, 72, 108));
    // 0.333 * 10 = 3.33 and 0.37 * 10 = 3.7.
    EXPECT_EQ(ParseBox("a:0.333,0.37,0,1", {10, 10}).pixels, Pixels(3, 4, 0, 10));
}

TEST(Box, NumbersAboveOneCountPixels) {
    EXPECT_EQ(ParseBox("a:10,20,30,40", kSize).pixels, Pixels(10, 20, 30, 40));
    EXPECT_EQ(ParseBox("a:0,1,0,2", kSize).pixels, Pixels(0, 1, 0, 2));
    // All four from 0 to 1: fractions.
    EXPECT_EQ(ParseBox("a:0,1,0,1", kSize).pixels, Pixels(0, 640, 0, 360));
}

TEST(Box, NameMayBeLeftOutOrHoldColons) {
    EXPECT_EQ(ParseBox("1,2,3,4", kSize).name, "box");
    EXPECT_EQ(ParseBox("left: lamp:1,2,3,4", kSize).name, "left: lamp");
    EXPECT_EQ(ParseBox("a: 1, 2, 3, 4", kSize).pixels, Pixels(1, 2, 3, 4));
}

TEST(Box, IsCutToTheImage) {
    EXPECT_EQ(ParseBox("a:600,1000,-5,20", kSize).pixels, Pixels(600, 640, 0, 20));
    EXPECT_EQ(ParseBox("a:-3,1e99,0,20", kSize).pixels, Pixels(0, 640, 0, 20));
}

TEST(Box, WhatIsNoBoxIsAnError) {
    for (const char* text : {"", "a", "a:", ":1,2,3,4", "a:1,2,3", "a:1,2,3,4,5", "a:1,2,3,x", "a:1,2,3,4x",
                             "a:1,,3,4", "a:nan,1,0,1", "a:inf,1,0,1"})
        EXPECT_NE(ErrorOf(text).find("expected NAME:x0,x1,y0,y1"), std::string::npos) << text;
    EXPECT_NE(ErrorOf("a:0.5,2,3,4").find("either four fractions"), std::string::npos);
}

TEST(Box, BoxWithoutPixelIsAnError) {
    for (const char* text : {"a:2,2,3,4", "a:3,2,3,4", "a:0.5,0.5,0,1", "a:0,0.0001,0,1", "a:700,800,1,2"})
        EXPECT_NE(ErrorOf(text), "") << text;
    EXPECT_NE(ErrorOf("a:0.1,0.2,0,1", {2, 2}), "");
}

TEST(Box, SceneCommentsBeforeTheFirstDirectiveAreRead) {
    const auto path = std::filesystem::path(testing::TempDir()) /
                      ("lacquer-" + std::to_string(test::SeedOf(test::FullTestName())) + ".pbrt");
    std::ofstream(path) << "# A title with the word box in it.\n"
                           "# box ball 0.25 0.75 0.5 1\n"
                           "\n"
                           "#box near 0 0.5 0 0.5\r\n"
                           "# box broken 0.25 0.75 0.5\n"
                           "# box long 0.25 0.75 0.5 1 2\n"
                           "# box pixels 0 10 0 10\n"
                           "# box empty 0.5 0.5 0 1\n"
                           "Film \"rgb\"\n"
                           "# box late 0 1 0 1\n";
    const std::vector<Box> boxes = BoxesOfScene(path.string(), kSize);
    std::filesystem::remove(path);
    ASSERT_EQ(boxes.size(), 2u);
    EXPECT_EQ(boxes[0].name, "ball");
    EXPECT_EQ(boxes[0].pixels, Pixels(160, 480, 180, 360));
    EXPECT_EQ(boxes[1].name, "near");
    EXPECT_TRUE(BoxesOfScene(path.string(), kSize).empty()) << "the file is gone";
}

TEST(Box, FigureScenesHaveBoxesInTheImage) {
    int scenes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(LACQUER_SOURCE_DIR "/scenes/xia2020")) {
        if (!entry.path().filename().string().starts_with("fig")) continue;
        ++scenes;
        const std::vector<Box> boxes = BoxesOfScene(entry.path().string(), kSize);
        EXPECT_GE(boxes.size(), 2u) << entry.path();
        for (const Box& box : boxes) EXPECT_GE(box.pixels.Area(), 100) << entry.path() << " " << box.name;
    }
    EXPECT_GE(scenes, 8);
}

TEST(Box, WholeImageIsAll) {
    EXPECT_EQ(WholeImage(kSize).name, "all");
    EXPECT_EQ(WholeImage(kSize).pixels, Pixels(0, 640, 0, 360));
}

}  // namespace
}  // namespace lacquer::compare::box_test
