// views.json in both forms, what can be wrong with it, and the photographs that it names.
#include "capture/svbrdf/views_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/svbrdf/scratch_folder.h"
#include "capture/svbrdf/svbrdf_model.h"
#include "pbrt/core/error.h"
#include "pbrt/image/image.h"

namespace lacquer::capture::views_file_test {
namespace {

using test::ScratchFolder;

constexpr const char* kOurs = R"({
 "unit": "cm", "size": 10.88, "response": "srgb", "lightPower": [1500, 1400, 1300],
 "views": [
  {"image": "a.png", "camera": [0, 0, 25], "light": [1, 0, 25], "use": "test"},
  {"image": "b.png", "camera": [3, -2, 20.5]}
 ]
})";

TEST(ViewsFile, ReadsOurForm) {
    const ViewSet set = ParseViews(kOurs, "views.json");
    EXPECT_EQ(set.size, 10.88);
    EXPECT_EQ(set.response, Response::SRGB);
    EXPECT_EQ(set.lightPower, (std::array<double, 3>{1500, 1400, 1300}));
    ASSERT_EQ(set.views.size(), 2U);
    EXPECT_EQ(set.views[0].image, "a.png");
    EXPECT_EQ(set.views[0].light, (Point{1, 0, 25}));
    EXPECT_TRUE(set.views[0].isTest);
    EXPECT_EQ(set.views[1].camera, (Point{3, -2, 20.5}));
    EXPECT_EQ(set.views[1].light, set.views[1].camera);
    EXPECT_FALSE(set.views[1].isTest);
}

TEST(ViewsFile, ReadsThePublishedForm) {
    const ViewSet set = ParseViews(R"({"im_size": 6.848, "camera_pos": [[0,0,16],[1,0,16],[2,0,16]],
        "light_pos": [[0,1,16],[1,1,16],[2,1,16]], "light_pow": 1200, "idx": [2, 0]})",
                                   "target.json");
    EXPECT_EQ(set.size, 6.848);
    EXPECT_EQ(set.response, Response::Gamma22);
    EXPECT_EQ(set.lightPower, (std::array<double, 3>{1200, 1200, 1200}));
    ASSERT_EQ(set.views.size(), 2U);
    EXPECT_EQ(set.views[0].image, "02.png");
    EXPECT_EQ(set.views[0].light, (Point{2, 1, 16}));
    EXPECT_EQ(set.views[1].image, "00.png");
    const ViewSet all = ParseViews(R"({"im_size": 6.848, "camera_pos": [[0,0,16],[1,0,16]]})", "target.json");
    EXPECT_EQ(all.views.size(), 2U);
    EXPECT_EQ(all.views[1].light, (Point{1, 0, 16}));
    EXPECT_EQ(all.lightPower, ViewSet{}.lightPower);
}

TEST(ViewsFile, WritesWhatItReads) {
    const ScratchFolder folder;
    ViewSet set = ParseViews(kOurs, "views.json");
    set.views[1].camera[0] = 1. / 3;
    WriteViews(set, folder.File("views.json"));
    const ViewSet again = ReadViews(folder.File("views.json"));
    EXPECT_EQ(again.size, set.size);
    EXPECT_EQ(again.response, set.response);
    EXPECT_EQ(again.lightPower, set.lightPower);
    ASSERT_EQ(again.views.size(), set.views.size());
    for (size_t i = 0; i < set.views.size(); ++i) {
        EXPECT_EQ(again.views[i].image, set.views[i].image);
        EXPECT_EQ(again.views[i].camera, set.views[i].camera);
        EXPECT_EQ(again.views[i].light, set.views[i].light);
        EXPECT_EQ(again.views[i].isTest, set.views[i].isTest);
    }
}

std::string ErrorOf(const std::string& text) {
    try {
        ParseViews(text, "views.json");
    } catch (const SceneError& error) {
        return error.what();
    }
    return "";
}
/// The text with a part of it replaced.
std::string With(const std::string& from, const std::string& to, std::string text = kOurs) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(ViewsFile, ErrorsHaveTheirPlaces) {
    const std::pair<std::string, std::string> cases[] = {
        {With("\"size\"", "\"sise\""),
         "views.json:2:16: error: unknown key \"sise\"; did you mean \"size\"?"},
        {With("\"camera\"", "\"kamera\""),
         "views.json:4:22: error: unknown key \"kamera\"; did you mean \"camera\"?"},
        {With("10.88", "-1"), "views.json:2:24: error: found -1; expected a length above 0, up to 100000 cm"},
        {With("10.88", "\"large\""),
         "views.json:2:24: error: found \"large\"; expected a length above 0, up to 100000 cm"},
        {With("10.88", "1e999"), "views.json:2:24: error: 1e999 is beyond the range of numbers"},
        {With("\"cm\"", "\"mm\""), "views.json:2:10: error: found \"mm\"; expected \"cm\", the only unit"},
        {With("\"srgb\"", "\"sRGB\""),
         "views.json:2:43: error: found \"sRGB\"; expected one of gamma2.2, srgb, linear; did you mean "
         "\"srgb\"?"},
        {With("\"test\"", "\"tset\""),
         "views.json:4:72: error: found \"tset\"; expected one of fit, test; did you mean \"test\"?"},
        {With("[0, 0, 25]", "[0, 25]"),
         "views.json:4:32: error: this list has 2 numbers; expected 3, x, y and z [cm]"},
        {With("[0, 0, 25]", "[0, 0, -25]"),
         "views.json:4:39: error: z is -25; expected a place above the sample, which lies at 0"},
        {With("[1, 0, 25]", "[1, 0, 0]"),
         "views.json:4:60: error: z is 0; expected a place above the sample, which lies at 0"},
        {With("[0, 0, 25]", "[null, 0, 25]"),
         "views.json:4:33: error: found null; expected a number in [-100000, 100000]"},
        {With("1400", "0"), "views.json:2:72: error: found 0; expected a light"},
        {With("[1500, 1400, 1300]", "[1500, 1400]"),
         "views.json:2:65: error: this list has 2 numbers; expected 3, red, green and blue"},
        {With("\"b.png\"", "7"), "views.json:5:13: error: found 7; expected the name of a file"},
        {With("\"image\": \"b.png\", ", ""), "views.json:5:3: error: there is no \"image\""},
        {With("[3, -2, 20.5]}", "[3, -2, 20.5], \"use\": \"test\"}"),
         "views.json:3:11: error: all views are for tests; expected one at least to be fitted"},
        {R"({"size": 1, "views": []})",
         "views.json:1:22: error: found a list of 0; expected a list of views"},
        {R"({"size": 1})", "views.json:1:1: error: there is no \"views\""},
        {R"([1])", "views.json:1:1: error: found a list of 1; expected an object, the views of a sample"},
        {R"({"im_size": 1, "camera_pos": [[0,0,1]], "light_pos": [[0,0,1],[0,0,1]]})",
         "views.json:1:54: error: there are 2 lights and 1 cameras; expected one for each"},
        {R"({"im_size": 1, "camera_pos": [[0,0,1]], "idx": [1]})",
         "views.json:1:49: error: found 1; expected a number in [0, 0]"},
        {R"({"im_size": 1, "camera_pos": [[0,0,1],[0,0,1]], "idx": [1, 1]})",
         "views.json:1:60: error: view 1 is listed twice"},
        {R"({"im_size": 1, "camera_pos": [[0,0,1]], "size": 1})",
         "views.json:1:41: error: unknown key \"size\""},
    };
    for (const auto& [text, message] : cases) EXPECT_EQ(ErrorOf(text), message);
    EXPECT_THROW(ReadViews("/nowhere/views.json"), FileError);
}

Image Stripes(int size) {
    Image image({size, size}, {"R", "G", "B"});
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            for (int c = 0; c < 3; ++c) image.Set({x, y}, c, float(x % 2 + y % 2) * 0.3F + 0.1F * float(c));
    return image;
}

TEST(ViewsFile, PhotographsAreAveragedAsLight) {
    const ScratchFolder folder;
    WriteImage(Stripes(8), folder.File("stripes.exr"));
    const RectifiedImage half = ReadRectifiedImage(folder.File("stripes.exr"), Response::Linear, 4);
    for (size_t c = 0; c < 3; ++c)
        for (const double value : half.Channel(c))
            EXPECT_NEAR(std::pow(value, kModelGamma), 0.3 + 0.1 * double(c), 1e-6);
    // Pixels that lie in two cells count in both.
    const RectifiedImage odd = ReadRectifiedImage(folder.File("stripes.exr"), Response::Linear, 3);
    double sum = 0;
    for (const double value : odd.Channel(0)) sum += std::pow(value, kModelGamma);
    EXPECT_NEAR(sum / 9, 0.3, 1e-6);
    EXPECT_EQ(ReadRectifiedImage(folder.File("stripes.exr"), Response::Linear, 8).size, 8);
}

// A writer of bytes rounds sRGB values to 1/255, with dither.
TEST(ViewsFile, ResponsesDecodeBytes) {
    const ScratchFolder folder;
    WriteImage(Stripes(8), folder.File("stripes.png"));
    const double linear = 0.3 + 0.1, stored = std::pow(1.055 * std::pow(linear, 1 / 2.4) - 0.055, 1);
    const auto at = [&](Response response) {
        return ReadRectifiedImage(folder.File("stripes.png"), response, 8).Channel(1)[1];
    };
    EXPECT_NEAR(at(Response::SRGB), std::pow(linear, 1 / 2.2), 0.005);
    EXPECT_NEAR(at(Response::Gamma22), stored, 0.005);
    EXPECT_NEAR(at(Response::Linear), std::pow(stored, 1 / 2.2), 0.005);
}

TEST(ViewsFile, PhotographsThatAreNoneHaveTheirMessages) {
    const ScratchFolder folder;
    const auto errorOf = [&](const Image& image, const char* name) {
        WriteImage(image, folder.File(name));
        try {
            ReadRectifiedImage(folder.File(name), Response::Linear, 8);
        } catch (const SceneError& error) {
            return error.Message();
        }
        return std::string();
    };
    EXPECT_EQ(errorOf(Image({8, 9}, {"R", "G", "B"}), "a.exr"),
              "the image has 8 x 9 pixels; expected a square");
    EXPECT_EQ(errorOf(Stripes(4), "b.exr"), "the image has 4 x 4 pixels; expected 8 x 8 at least");
    EXPECT_EQ(errorOf(Image({8, 8}, {"U", "V"}), "c.exr"), "expected the channels R, G and B, or one alone");
    Image dark = Stripes(8);
    dark.Set({3, 2}, 1, -0.5F);
    EXPECT_EQ(errorOf(dark, "d.exr"),
              "pixel 3,2 has the value -0.5 in channel G; expected a finite number, at least 0");
    EXPECT_THROW(ReadRectifiedImage(folder.File("none.png"), Response::Linear, 8), FileError);
}

TEST(ViewsFile, ImagesStandBesideTheViews) {
    const ScratchFolder folder;
    WriteImage(Stripes(8), folder.File("a.exr"));
    ViewSet set = ParseViews(kOurs, "views.json");
    set.views[0].image = "a.exr";
    set.views[1].image = folder.File("a.exr");
    const auto images = ReadViewImages(set, folder.Path(), 8);
    ASSERT_EQ(images.size(), 2U);
    EXPECT_EQ(images[0].values, images[1].values);
}

}  // namespace
}  // namespace lacquer::capture::views_file_test
