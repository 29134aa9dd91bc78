// Photographs from files: the tone curve undone, the square cut out and made smaller; what is wrong with a
// file is said.
#include "estimate/photo/photograph_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

namespace lacquer::estimate::photograph_file_test {
namespace {

constexpr ColorEncoding kGamma22{ColorEncoding::Kind::Gamma, 2.2F};

/// Files in a folder of the test's own.
class PhotographFiles : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() /
                  (std::string("lacquer-photograph-") +
                   testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    using Value = std::function<float(int x, int y, int c)>;
    std::string Write(const std::string& name, Int2 size, const Value& value,
                      const std::vector<std::string>& channels = {"R", "G", "B"}) const {
        Image image(size, channels);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                for (int c = 0; c < int(channels.size()); ++c) image.Set({x, y}, c, value(x, y, c));
        const std::string path = (folder_ / name).string();
        WriteImage(image, path);
        return path;
    }
    /// The message that a file is refused with; empty if it is not.
    static std::string Refusal(const std::string& path, const PhotographReading& reading = {}) {
        try {
            ReadPhotograph(path, reading);
        } catch (const SceneError& e) {
            EXPECT_EQ(e.Loc().file, path);
            return e.Message();
        }
        return {};
    }

    std::filesystem::path folder_;
};

float Ramp(int x, int y, int c) { return 0.1F + 0.003F * float(x) + 0.001F * float(y) + 0.05F * float(c); }

TEST_F(PhotographFiles, FloatsAreLinearAndRowsComeFromTheTop) {
    PhotographReading reading;
    reading.resolution = 64;
    const PhotographFile photo = ReadPhotograph(Write("a.exr", {64, 64}, Ramp), reading);
    ASSERT_EQ(photo.linear.size, 64);
    for (const auto& [x, y] : {std::pair(0, 0), {63, 0}, {0, 63}, {17, 40}})
        for (int c = 0; c < 3; ++c)
            EXPECT_FLOAT_EQ(float(photo.linear.Channel(size_t(c))[size_t(64 * y + x)]), Ramp(x, y, c));
    EXPECT_EQ(photo.clipped, 0);
    EXPECT_TRUE(photo.notes.empty() && photo.warnings.empty());
}

TEST_F(PhotographFiles, BytesAreDecodedByTheToneCurve) {
    const std::string png = Write("a.png", {64, 64}, Ramp);  // as sRGB
    const double srgb = ReadPhotograph(png, {}).linear.Channel(1)[64 * 9 + 30];
    EXPECT_NEAR(srgb, Ramp(30, 9, 1), 0.003);
    // A code of 255 t is t^2.2 to the camera of the chapter, whatever the format.
    const double code = double(ColorEncoding{ColorEncoding::Kind::SRGB, 1}.FromLinear(float(srgb)));
    PhotographReading reading;
    reading.tone = kGamma22;
    EXPECT_NEAR(ReadPhotograph(png, reading).linear.Channel(1)[64 * 9 + 30], std::pow(code, 2.2), 1e-4);
    const std::string bmp = Write("a.bmp", {64, 64}, Ramp);
    const double ofBmp = ReadPhotograph(bmp, {}).linear.Channel(1)[64 * 9 + 30];
    const double codeOfBmp = double(ColorEncoding{ColorEncoding::Kind::SRGB, 1}.FromLinear(float(ofBmp)));
    EXPECT_NEAR(ReadPhotograph(bmp, reading).linear.Channel(1)[64 * 9 + 30], std::pow(codeOfBmp, 2.2), 1e-4);
    // The control: the curves differ by more than that.
    EXPECT_GT(std::abs(std::pow(code, 2.2) - srgb), 0.002);
}

TEST_F(PhotographFiles, TheSquareAtTheCentreIsTakenAndMadeSmallerByMeans) {
    // Stripes one pixel wide, of codes that average to something else than light does.
    const std::string path = Write("a.png", {200, 128}, [](int x, int, int) { return x % 2 ? 0.9F : 0.1F; });
    PhotographReading reading;
    reading.resolution = 64;
    const PhotographFile photo = ReadPhotograph(path, reading);
    EXPECT_EQ(photo.linear.size, 64);
    EXPECT_EQ(photo.crop, (Bounds2i{{36, 0}, {164, 128}}));
    ASSERT_EQ(photo.notes.size(), 1U);
    double sum = 0;
    for (const double v : photo.linear.Channel(0)) sum += v;
    EXPECT_NEAR(sum / (64 * 64), 0.5, 0.005);  // the mean of codes decodes to 0.37
    ASSERT_EQ(photo.warnings.size(), 1U);
    EXPECT_NE(photo.warnings[0].find("is grey"), std::string::npos);
}

TEST_F(PhotographFiles, CropsAreCut) {
    const std::string path = Write("a.exr", {200, 128}, Ramp);
    PhotographReading reading;
    reading.crop = Bounds2i{{100, 20}, {164, 84}};
    const PhotographFile photo = ReadPhotograph(path, reading);
    EXPECT_FLOAT_EQ(float(photo.linear.Channel(0)[0]), Ramp(100, 20, 0));
    EXPECT_FLOAT_EQ(float(photo.linear.Channel(2)[64 * 63 + 63]), Ramp(163, 83, 2));
    reading.crop = Bounds2i{{100, 20}, {164, 90}};
    EXPECT_NE(Refusal(path, reading).find("64 x 70 pixels; expected a square"), std::string::npos);
    reading.crop = Bounds2i{{150, 20}, {214, 84}};
    EXPECT_NE(Refusal(path, reading).find("leaves the image of 200 x 128"), std::string::npos);
}

TEST_F(PhotographFiles, SmallOnesAreNotMadeLarger) {
    const PhotographFile photo = ReadPhotograph(Write("a.exr", {100, 100}, Ramp), {});
    EXPECT_EQ(photo.linear.size, 96);
    EXPECT_EQ(photo.notes.size(), 1U);
    EXPECT_NE(Refusal(Write("b.exr", {63, 100}, Ramp)).find("at least 64 x 64"), std::string::npos);
    EXPECT_NE(Refusal(Write("c.exr", {1, 100}, Ramp)).find("at least 64 x 64"), std::string::npos);
}

TEST_F(PhotographFiles, ExposureIsJudged) {
    const auto columns = [](int clipped, float value) {
        return [=](int x, int, int c) { return x < clipped ? value : 0.2F + 0.1F * float(c); };
    };
    EXPECT_TRUE(ReadPhotograph(Write("a.png", {100, 100}, columns(19, 1)), {}).warnings.empty());
    const PhotographFile some = ReadPhotograph(Write("b.png", {100, 100}, columns(25, 1)), {});
    EXPECT_NEAR(some.clipped, 0.25, 1e-9);
    ASSERT_EQ(some.warnings.size(), 1U);
    EXPECT_NE(some.warnings[0].find("25 % of the pixels are clipped"), std::string::npos);
    EXPECT_NE(Refusal(Write("c.png", {100, 100}, columns(85, 1))).find("85 % of the pixels are clipped"),
              std::string::npos);
    const PhotographFile dark = ReadPhotograph(Write("d.png", {100, 100}, columns(85, 0)), {});
    ASSERT_EQ(dark.warnings.size(), 1U);
    EXPECT_NE(dark.warnings[0].find("85 % of the pixels are black"), std::string::npos);
    EXPECT_NE(Refusal(Write("e.png", {100, 100}, columns(100, 0))).find("every pixel is black"),
              std::string::npos);
}

TEST_F(PhotographFiles, LossesOfTheFileAreWarnedOf) {
    const PhotographFile photo = ReadPhotograph(Write("a.jpg", {100, 100}, Ramp), {});
    ASSERT_EQ(photo.warnings.size(), 1U);
    EXPECT_NE(photo.warnings[0].find("JPEG leaves out fine detail"), std::string::npos);
    const PhotographFile lossless = ReadPhotograph(Write("a.png", {100, 100}, Ramp), {});
    EXPECT_TRUE(lossless.warnings.empty());
}

TEST_F(PhotographFiles, WhatIsNoPhotographIsRefusedByPlace) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    const auto with = [](float value) {
        return [=](int x, int y, int c) { return x == 5 && y == 7 && c == 1 ? value : 0.4F; };
    };
    EXPECT_NE(
        Refusal(Write("nan.exr", {64, 64}, with(kNan))).find("pixel 5,7 has the value nan in channel G"),
        std::string::npos);
    EXPECT_NE(
        Refusal(Write("inf.exr", {64, 64}, with(std::numeric_limits<float>::infinity()))).find("pixel 5,7"),
        std::string::npos);
    EXPECT_NE(Refusal(Write("negative.exr", {64, 64}, with(-0.1F))).find("has the value -0.1"),
              std::string::npos);
    EXPECT_EQ(Refusal(Write("fine.exr", {64, 64}, with(0.5F))), "");
    const auto alpha = [](float value) {
        return [=](int x, int y, int c) { return c == 3 && x == 5 && y == 7 ? value : c == 3 ? 1.F : 0.4F; };
    };
    const std::vector<std::string> rgba = {"R", "G", "B", "A"};
    EXPECT_NE(Refusal(Write("alpha.png", {64, 64}, alpha(0.5F), rgba)).find("pixel 5,7 is transparent"),
              std::string::npos);
    EXPECT_EQ(Refusal(Write("opaque.png", {64, 64}, alpha(1), rgba)), "");
    EXPECT_NE(Refusal(Write("cmyk.exr", {64, 64}, Ramp, {"C", "M", "K"}))
                  .find("has the channels C, K, M; expected R, G and B"),
              std::string::npos);
    EXPECT_THROW(ReadPhotograph((folder_ / "nothing.png").string(), {}), FileError);
    std::filesystem::create_directories(folder_ / "folder.png");
    EXPECT_ANY_THROW(ReadPhotograph((folder_ / "folder.png").string(), {}));
}

TEST_F(PhotographFiles, TheFocalLengthTellsTheFieldOfView) {
    Image image({300, 200}, {"R", "G", "B"});
    for (float& v : image.Pixels()) v = 0.3F;
    image.Set({1, 1}, 0, 0.4F);
    image.metadata["Exif:FocalLengthIn35mmFilm"] = 26;
    const std::string path = (folder_ / "a.jpg").string();
    WriteImage(image, path);
    const PhotographFile photo = ReadPhotograph(path, {});
    // 24 of 36 x 24 mm at 26 mm.
    EXPECT_NEAR(photo.fieldOfView, 2 * std::atan(12. / 26) * 180 / M_PI, 1e-6);
    EXPECT_EQ(ReadPhotograph(Write("b.jpg", {300, 200}, Ramp), {}).fieldOfView, 0);
}

}  // namespace
}  // namespace lacquer::estimate::photograph_file_test
