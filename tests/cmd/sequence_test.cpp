// Frames of a sequence: their numbers, their files, what varies.
#include "cmd/render/sequence.h"

#include <gtest/gtest.h>

namespace lacquer::cmd::sequence_test {
namespace {

TEST(Frames, AreNumbersAndRanges) {
    EXPECT_EQ(ParseFrames("7"), std::vector<int>({7}));
    EXPECT_EQ(ParseFrames("0-3"), std::vector<int>({0, 1, 2, 3}));
    EXPECT_EQ(ParseFrames("10-20x5,1-2,8"), std::vector<int>({10, 15, 20, 1, 2, 8}));
    EXPECT_EQ(ParseFrames("1-6x4"), std::vector<int>({1, 5}));
    for (const char* wrong : {"", ",", "-1", "3-1", "1-", "1-5x0", "1-5x", "a", "1 2", "1-5,5", "1.5",
                              "1-5xx2", "0-99999999", "99999999999"})
        EXPECT_THROW(ParseFrames(wrong), CLI::ValidationError) << wrong;
}

TEST(Frames, StandInNames) {
    EXPECT_EQ(WithFrame("a.####.exr", 7), "a.0007.exr");
    EXPECT_EQ(WithFrame("a#.exr", 123), "a123.exr");
    EXPECT_EQ(WithFrame("###", 5), "005");
    EXPECT_EQ(WithFrame("plain.exr", 5), "plain.exr");
    EXPECT_THROW(WithFrame("a#b#", 5), CLI::ValidationError);
}

RenderArguments Arguments() {
    RenderArguments a;
    a.frames = "1-3";
    a.scenes = {"shot.##.pbrt", "lights.pbrt"};
    a.outfile = "a.#.exr";
    return a;
}

TEST(Frames, HaveArgumentsOfTheirOwn) {
    RenderArguments a = Arguments();
    a.checkpoint = "#.state";
    a.vary = {"camera.fov=10:20", "ball.rgb=0 0 1:0 1 0", "ball.name=a,b,c"};
    const auto all = ArgumentsOfFrames(a);
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[1].scenes, std::vector<std::string>({"shot.02.pbrt", "lights.pbrt"}));
    EXPECT_EQ(all[1].outfile, "a.2.exr");
    EXPECT_EQ(all[2].checkpoint, "3.state");
    const auto value = [&](size_t frame, size_t i) { return all[frame].settings[i].values[0]; };
    EXPECT_EQ(value(0, 0), "10");
    EXPECT_EQ(value(1, 0), "15");
    EXPECT_EQ(value(2, 0), "20");
    EXPECT_EQ(value(1, 1), "0 0.5 0.5");
    EXPECT_EQ(value(1, 2), "b");
    a.frames = "5";
    a.vary = {"camera.fov=10:20"};
    EXPECT_EQ(ArgumentsOfFrames(a)[0].settings[0].values[0], "10");
}

TEST(Frames, WriteDifferentFilesAndAreDifferent) {
    const auto refused = [](auto change) {
        RenderArguments a = Arguments();
        change(a);
        EXPECT_THROW(ArgumentsOfFrames(a), CLI::ValidationError);
    };
    EXPECT_NO_THROW(ArgumentsOfFrames(Arguments()));
    refused([](auto& a) { a.outfile = "a.exr"; });
    refused([](auto& a) { a.outfile = ""; });
    refused([](auto& a) { a.checkpoint = "a.state"; });
    refused([](auto& a) { a.statsJson = "a.json"; });
    refused([](auto& a) { a.logFile = "log"; });
    refused([](auto& a) { a.scenes = {"lights.pbrt"}; });
    refused([](auto& a) { a.restart = true; });
    refused([](auto& a) { a.vary = {"camera.fov=1,2"}; });
    refused([](auto& a) { a.vary = {"camera.fov=1:2:3"}; });
    refused([](auto& a) { a.vary = {"nonsense"}; });
}

}  // namespace
}  // namespace lacquer::cmd::sequence_test
