// From files to rectified images: rendered photographs of a card and a sample, and what is wrong with files.
#include "capture/card/capture_photographs.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "capture/card/card_photographs.h"
#include "capture/card/photograph.h"
#include "capture/photograph_scene.h"
#include "pbrt/core/parallel.h"
#include "support/statistics.h"

namespace lacquer::capture::capture_photographs_test {
namespace {

using test::SeedOf;
using namespace test_cards;

/// Files in a folder of the test's own.
class CaptureFiles : public testing::Test {
  protected:
    void SetUp() override {
        folder_ =
            std::filesystem::temp_directory_path() /
            (std::string("lacquer-capture-") + testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string Write(const std::string& name, const Image& grey, const Metadata& metadata = {}) const {
        Image image(grey.Resolution(), {"R", "G", "B"});
        for (size_t i = 0; i < image.Pixels().size(); ++i) image.Pixels()[i] = grey.Pixels()[i / 3];
        image.metadata = metadata;
        const std::string path = (folder_ / name).string();
        WriteImage(image, path);
        return path;
    }
    std::string ErrorsOf(const std::vector<std::string>& files, const CaptureOptions& options = {}) const {
        try {
            CapturePhotographs(files, options);
        } catch (const std::exception& e) {
            std::string text = e.what();
            for (size_t at; (at = text.find(folder_.string() + "/")) != std::string::npos;)
                text.erase(at, folder_.string().size() + 1);
            return text;
        }
        return {};
    }

    std::filesystem::path folder_;
};

Metadata ExifOf(float time, int iso, float aperture, int focal35mm) {
    return {{"ExposureTime", time},
            {"FNumber", aperture},
            {"Exif:PhotographicSensitivity", iso},
            {"Exif:FocalLengthIn35mmFilm", focal35mm}};
}

std::vector<CameraPose> ThreePoses() { return {NinePoses()[0], NinePoses()[2], NinePoses()[7]}; }

TEST_F(CaptureFiles, RenderedPhotographsGiveCamerasAndTheSample) {
    test::PhotographScene scene;
    scene.material = R"(
Texture "red" "spectrum" "constant" "rgb value" [.6 .1 .1]
Texture "grey" "spectrum" "constant" "rgb value" [.3 .3 .3]
Texture "fields" "spectrum" "checkerboard" "float uscale" 4 "float vscale" 2 "texture tex1" "red" "texture tex2" "grey"
Material "diffuse" "texture reflectance" "fields")";
    scene.flash = {1.5, 0.5, 0};
    scene.resolution = {360, 360};
    scene.maxDepth = 1;
    const std::string texture = test::WriteCardTexture(folder_.string(), scene.size);
    Intrinsics bent = scene.Intrinsics();
    bent.k1 = 0.06;
    std::vector<std::string> files;
    for (const CameraPose& pose : ThreePoses()) {
        const Image photograph = Distorted(RenderPhotograph(scene, pose, texture), scene.Intrinsics(), bent);
        files.push_back((folder_ / fmt::format("{}.exr", files.size())).string());
        WriteImage(WithNoise(photograph, 0.005, SeedOf(files.back().substr(folder_.string().size()))),
                   files.back());
    }
    CaptureOptions options;
    options.response = Response::Linear;
    options.flash = {1.5, 0.5, 0};
    options.resolution = 128;
    const CapturedPhotographs found = CapturePhotographs(files, options);
    EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
    ASSERT_EQ(found.views.views.size(), 3u);
    EXPECT_NEAR(found.views.size, 10.88, 1e-12);
    for (size_t i = 0; i < 3; ++i) {
        // In the frame of the sample, which is 0.1 cm below the card's.
        const Eigen::Vector3d up(0, 0, 0.1), camera = ThreePoses()[i].position + up,
                                             light = scene.Light(ThreePoses()[i]) + up;
        const View& view = found.views.views[i];
        EXPECT_LT((Eigen::Vector3d(view.camera.data()) - camera).norm(), 0.05);
        EXPECT_LT((Eigen::Vector3d(view.light.data()) - light).norm(), 0.05);
        // The middles of fields: a Lambertian surface under the light, red at the upper right.
        const auto expected = [&](double x, double y, double albedo) {
            const Eigen::Vector3d to = light - Eigen::Vector3d(x, y, 0);
            return 1500 * albedo / M_PI * to.z() / std::pow(to.norm(), 3);
        };
        const auto mean = [&](int column, int row, int c) {
            double sum = 0;
            for (int k = 0; k < 64; ++k)
                sum +=
                    double(found.photographs[i].rectified.Get({column - 4 + k % 8, row - 4 + k / 8}, c)) / 64;
            return sum;
        };
        const double x = 10.88 * 3 / 8, y = 10.88 / 4;
        EXPECT_NEAR(mean(112, 32, 0) / expected(x, y, 0.6), 1, 0.03);
        EXPECT_NEAR(mean(112, 32, 1) / expected(x, y, 0.1), 1, 0.05);
        EXPECT_NEAR(mean(112, 96, 0) / expected(x, -y, 0.3), 1, 0.03);
        EXPECT_NEAR(mean(112, 96, 1) / expected(x, -y, 0.3), 1, 0.03);
        EXPECT_NEAR(mean(16, 32, 0) / expected(-x, y, 0.3), 1, 0.03);
    }
}

TEST_F(CaptureFiles, ExposuresAreDividedOutAndResultsDoNotDependOnThreads) {
    std::vector<std::string> files;
    const std::vector<CameraPose> poses = ThreePoses();
    for (size_t i = 0; i < 3; ++i) {
        Photographer photographer;
        photographer.exposure = i == 1 ? 0.8 : 0.4;
        photographer.samplesPerEdge = 3;
        files.push_back(Write(fmt::format("{}.jpg", i), TakePhotograph({}, photographer, poses[i]),
                              ExifOf(i == 1 ? 1 / 50.F : 1 / 100.F, 100, 1.8F, 28)));
    }
    EXPECT_EQ(PhotographsOfFolder(folder_.string()), files);
    CaptureOptions options;
    options.response = Response::SRGB;
    options.resolution = 64;
    const CapturedPhotographs found = CapturePhotographs(files, options);
    ASSERT_EQ(found.notes.size(), 1u);
    EXPECT_NE(found.notes[0].find("1.jpg: exposed 2 times as much as the darkest one, which is divided out"),
              std::string::npos);
    EXPECT_NEAR(found.photographs[1].exposureFactor, 0.5, 1e-3);
    EXPECT_EQ(found.photographs[0].exposureFactor, 1);
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(found.photographs[i].rectified.Get({32, 32}, 1), 0.4 * 0.4, 0.01) << i;
        EXPECT_LT((found.photographs[i].pose.pose.position - poses[i].position).norm(), 0.05);
    }
    const ThreadLimit one(1);
    const CapturedPhotographs again = CapturePhotographs(files, options);
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(again.views.views[i].camera, found.views.views[i].camera);
        EXPECT_EQ(again.photographs[i].rectified.Pixels(), found.photographs[i].rectified.Pixels());
    }
    // Codes of the response are in the files that are written.
    WriteRectified(found, folder_.string());
    const Image written = ReadImage((folder_ / "01.png").string(), EncodingOf(Response::SRGB), {});
    for (int i = 0; i < 64; i += 5)
        EXPECT_NEAR(written.Get({i, 20}, 0), found.photographs[1].rectified.Get({i, 20}, 0), 0.006);
}

TEST_F(CaptureFiles, OnePhotographByItsMetadata) {
    const Photographer photographer;
    const CameraPose pose = NinePoses()[8];
    const int focal = 32;  // of 605 pixels: 31.94
    const std::string file =
        Write("a.jpg", TakePhotograph({}, photographer, pose), ExifOf(0.01F, 100, 2, focal));
    const CapturedPhotographs found = CapturePhotographs({file}, {.resolution = 32});
    EXPECT_DOUBLE_EQ(found.calibration.intrinsics.f, FocalInPixels(focal, photographer.resolution));
    EXPECT_LT((found.photographs[0].pose.pose.position - pose.position).norm(), 0.1);
    const std::string bare = Write("b.png", TakePhotograph({}, photographer, pose));
    EXPECT_EQ(
        ErrorsOf({bare}),
        "b.png: error: the focal length is unknown: the file does not tell FocalLengthIn35mmFilm; give it in "
        "pixels, or three photographs");
    EXPECT_EQ(ErrorsOf({bare}, {.focal = 605}), "");
}

TEST_F(CaptureFiles, WhatIsWrongWithFilesIsNamed) {
    Photographer photographer;
    photographer.samplesPerEdge = 2;
    const std::string good = Write("good.png", TakePhotograph({}, photographer, NinePoses()[4]));
    photographer.resolution = {500, 512};
    const std::string narrow = Write("narrow.png", TakePhotograph({}, photographer, NinePoses()[4]));
    const std::string blank = Write("blank.png", Image({640, 512}, {"Y"}));
    EXPECT_EQ(
        ErrorsOf({good, narrow, narrow}, {.focal = 605}).substr(0, 93),
        "narrow.png: error: the photograph has 500 x 512 pixels, good.png has 640 x 512; expected one ");
    EXPECT_NE(ErrorsOf({good, blank}, {.focal = 605}).find("blank.png: error: no tags of the card are seen"),
              std::string::npos);
    EXPECT_NE(ErrorsOf({good, (folder_ / "none.png").string()}).find("none.png"), std::string::npos);
    EXPECT_NE(ErrorsOf({}).find("there are no photographs"), std::string::npos);
    EXPECT_NE(ErrorsOf({good}, {.size = -1}).find("the card has a size of -1 cm"), std::string::npos);
    EXPECT_NE(ErrorsOf({good}, {.sampleShare = 0.8}).find("at most 0.667, its window"), std::string::npos);
    EXPECT_THROW(PhotographsOfFolder((folder_ / "none").string()), FileError);
}

// Held out of the fit, a photograph that is also fitted would judge itself.
TEST_F(CaptureFiles, APhotographCountsOnce) {
    const std::vector<CameraPose> poses = ThreePoses();
    std::vector<std::string> files;
    Photographer photographer;
    photographer.samplesPerEdge = 2;
    for (size_t i = 0; i < 3; ++i)
        files.push_back(Write(fmt::format("{}.png", i), TakePhotograph({}, photographer, poses[i])));
    EXPECT_EQ(ErrorsOf(files), "");
    EXPECT_NE(ErrorsOf(files, {.flash = {0, 0, 100}}).find("0.png: error: by --flash the light is"),
              std::string::npos);
    std::filesystem::copy_file(files[0], folder_ / "copy.png");
    files.push_back((folder_ / "copy.png").string());
    files.push_back(files[1]);
    const std::string errors = ErrorsOf(files);
    EXPECT_NE(errors.find("copy.png: error: is the same photograph as 0.png"), std::string::npos) << errors;
    EXPECT_NE(errors.find("1.png: error: is the same photograph as 1.png"), std::string::npos) << errors;
}

TEST_F(CaptureFiles, WarnsOfOverexposedSamplesAndOfPixelsThatShowNothing) {
    PhotographedCard card;
    card.sample = [](double x, double) { return x > 2 ? 3 : 0.3; };
    const std::string file = Write("a.png", TakePhotograph(card, {}, NinePoses()[4]));
    const CapturedPhotographs found = CapturePhotographs({file}, {.resolution = 512, .focal = 605});
    std::string all;
    for (const std::string& warning : found.warnings) all += warning + "\n";
    EXPECT_NE(all.find("a.png: 32 % of the sample is overexposed"), std::string::npos) << all;
    EXPECT_NE(all.find("pixels along the edge of the sample: the 512 asked for show no more"),
              std::string::npos)
        << all;
}

}  // namespace
}  // namespace lacquer::capture::capture_photographs_test
