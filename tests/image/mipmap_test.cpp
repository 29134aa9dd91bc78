#include "pbrt/image/mipmap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pbrt/image/texture_source.h"

namespace lacquer::mipmap_test {
namespace {

constexpr TextureFilter kFilters[] = {TextureFilter::Point, TextureFilter::Bilinear, TextureFilter::Trilinear,
                                      TextureFilter::EWA};

MipMap Make(const Image& image, WrapMode wrap = WrapMode::Repeat) {
    return MipMap::Make(image, wrap, "image.exr", {"scene.pbrt", 4, 2});
}

Image Constant(Int2 resolution, std::vector<float> values, std::vector<std::string> channels) {
    Image image(resolution, std::move(channels));
    for (size_t i = 0; i < image.Pixels().size(); ++i) image.Pixels()[i] = values[i % values.size()];
    return image;
}

Image Random(Int2 resolution, std::vector<std::string> channels) {
    Image image(resolution, std::move(channels));
    uint32_t state = 7;
    for (float& v : image.Pixels()) v = float((state = state * 1664525 + 1013904223) >> 8) * 0x1p-24f;
    return image;
}

TEST(TextureSurvey, LooksAtEveryValue) {
    // More than one group of values at a time, and a rest; each position in turn.
    constexpr size_t kCount = 21;
    const auto surveyOf = [](const std::vector<float>& values) {
        TextureSurvey survey({"Y"});
        survey.AddPixels(values.data(), values.size());
        return survey;
    };
    const auto isRefused = [](const TextureSurvey& survey) {
        try {
            survey.UsedChannels("image.exr", {"scene.pbrt", 4, 2});
        } catch (const SceneError&) {
            return true;
        }
        return false;
    };
    for (size_t i = 0; i < kCount; ++i) {
        std::vector<float> values(kCount, 0.5f);
        EXPECT_FALSE(isRefused(surveyOf(values)));
        for (const float bad : {NAN, INFINITY, -INFINITY}) {
            values[i] = bad;
            EXPECT_TRUE(isRefused(surveyOf(values))) << i << " " << bad;
        }
        for (const float low : {-3.f, -std::numeric_limits<float>::max()}) {
            values[i] = low;
            EXPECT_EQ(surveyOf(values).Lowest(), low) << i;
            EXPECT_FALSE(isRefused(surveyOf(values)));
        }
    }
    // What is added later counts as well, and what was found before stays.
    TextureSurvey survey({"Y"});
    for (const float value : {2.f, -1.f, NAN, 4.f}) survey.AddPixels(&value, 1);
    EXPECT_EQ(survey.Lowest(), -1);
    EXPECT_TRUE(isRefused(survey));
}

TEST(MipMap, TexelsAreWhereTheImageHasThem) {
    // Higher and wider than a tile of memory, as high, and lower, and so for each format and channel.
    for (const PixelFormat format : {PixelFormat::Byte, PixelFormat::Half, PixelFormat::Float})
        for (const Int2 resolution :
             {Int2(32, 16), Int2(8, 8), Int2(4, 64), Int2(64, 2), Int2(1, 16), Int2(16, 1), Int2(1, 1)})
            for (const std::vector<std::string>& channels :
                 std::vector<std::vector<std::string>>{{"Y"}, {"R", "G", "B"}, {"R", "G", "B", "A"}}) {
                Image image(resolution, channels);
                image.format = format;
                // Bytes hold these as they are, and the largest number of texels is no multiple of 251.
                for (size_t i = 0; i < image.Pixels().size(); ++i) image.Pixels()[i] = float(i % 251) / 255;
                const MipMap map = Make(image);
                for (int y = 0; y < resolution.y; ++y)
                    for (int x = 0; x < resolution.x; ++x)
                        for (int c = 0; c < int(channels.size()); ++c)
                            ASSERT_NEAR(map.Texel(0, {x, y}, c), image.Get({x, y}, c), 3e-4f)
                                << x << " " << y << " " << c;
            }
}

TEST(MipMap, ConstantImageStaysConstantAtAllLevels) {
    for (const PixelFormat format : {PixelFormat::Byte, PixelFormat::Half, PixelFormat::Float})
        for (const Int2 resolution :
             {Int2(1, 1), Int2(8, 8), Int2(7, 5), Int2(64, 48), Int2(1, 9), Int2(100, 3)}) {
            Image image = Constant(resolution, {0.2f, 0.4f, 0.8f}, {"R", "G", "B"});
            image.format = format;
            image.encoding = {ColorEncoding::Kind::SRGB, 1};
            const MipMap map = Make(image);
            EXPECT_EQ(map.Resolution(map.NumLevels() - 1), Int2(1));
            for (int level = 0; level < map.NumLevels(); ++level)
                for (int c = 0; c < 3; ++c) {
                    const float expected = image.Pixels()[size_t(c)], actual = map.Texel(level, {0, 0}, c);
                    // A byte's half step, in stored values; half a unit in the last place of a half.
                    if (format == PixelFormat::Byte)
                        EXPECT_NEAR(image.encoding.FromLinear(actual), image.encoding.FromLinear(expected),
                                    0.51f / 255);
                    else
                        EXPECT_NEAR(actual, expected, format == PixelFormat::Half ? 3e-4f : 1e-6f);
                }
        }
}

TEST(MipMap, EveryLevelHasTheMeanOfTheImage) {
    const Image image = Random({32, 8}, {"Y"});
    double mean = 0;
    for (const float v : image.Pixels()) mean += double(v) / double(image.Pixels().size());
    const MipMap map = Make(image);
    for (int level = 0; level < map.NumLevels(); ++level) {
        double sum = 0;
        const Int2 resolution = map.Resolution(level);
        for (int y = 0; y < resolution.y; ++y)
            for (int x = 0; x < resolution.x; ++x) sum += double(map.Texel(level, {x, y}, 0));
        EXPECT_NEAR(sum / (resolution.x * resolution.y), mean, 1e-6) << level;
    }
}

TEST(MipMap, CoarserTexelsAreMeansOfFour) {
    const Image image = Random({8, 8}, {"Y"});
    const MipMap map = Make(image);
    const float expected =
        (image.Get({2, 4}, 0) + image.Get({3, 4}, 0) + image.Get({2, 5}, 0) + image.Get({3, 5}, 0)) / 4;
    EXPECT_FLOAT_EQ(map.Texel(1, {1, 2}, 0), expected);
}

TEST(MipMap, EnlargingKeepsASlowWave) {
    // The 4-tap windowed sinc follows a wave of 24 pixels a period within 2 %, also across the seam of the
    // repetition.
    Image image({48, 48}, {"Y"});
    const auto wave = [](float u) { return 0.5f + 0.4f * std::sin(4 * Pi * u); };
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 48; ++x) image.Set({x, y}, 0, wave((float(x) + 0.5f) / 48));
    const MipMap map = Make(image);
    ASSERT_EQ(map.Resolution(0), Int2(64));
    for (int x = 0; x < 64; ++x)
        EXPECT_NEAR(map.Texel(0, {x, 31}, 0), wave((float(x) + 0.5f) / 64), 0.02f) << x;
}

TEST(MipMap, EnlargingMakesNoNegativeValues) {
    Image image({6, 6}, {"Y"});
    image.Set({3, 3}, 0, 100);
    const MipMap map = Make(image);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) EXPECT_GE(map.Texel(0, {x, y}, 0), 0);
}

TEST(MipMap, BytesStayBytes) {
    Image image = Random({64, 64}, {"R", "G", "B"});
    image.format = PixelFormat::Byte;
    EXPECT_EQ(Make(image).Bytes(), 3u * (4 * 64 * 64 - 1) / 3);
    image.format = PixelFormat::Half;
    EXPECT_EQ(Make(image).Bytes(), 6u * (4 * 64 * 64 - 1) / 3);
}

TEST(MipMap, PointFootprintsShowTheFullImage) {
    const Image image = Random({16, 16}, {"Y"});
    const MipMap map = Make(image);
    for (const Point2 st : {Point2(0.31f, 0.77f), Point2(0.01f, 0.99f)}) {
        const float expected = image.Bilinear(st, 0, WrapMode::Repeat);
        for (const TextureFilter filter :
             {TextureFilter::Bilinear, TextureFilter::Trilinear, TextureFilter::EWA})
            EXPECT_NEAR(map.FilterFloat({st, Vec2(0), Vec2(0)}, filter, 8), expected, 1e-5f);
    }
    EXPECT_EQ(map.FilterFloat({{3.4f / 16, 7.7f / 16}, Vec2(0), Vec2(0)}, TextureFilter::Point, 8),
              image.Get({3, 7}, 0));
}

TEST(MipMap, LevelFollowsTheFootprint) {
    const MipMap map = Make(Random({16, 16}, {"Y"}));  // levels 0..4
    const Point2 st(2.5f / 8, 5.5f / 8);               // centre of a texel of level 1
    // Width 2 * 1/16 is one texel of level 1: level 4 + log2(1/8) = 1. A little more is still level 1 for the
    // bilinear filter, which takes the finer of the two neighbours.
    for (const float width : {1.f / 16, 1.9f / 16})
        EXPECT_NEAR(map.FilterFloat({st, {width, 0}, {0, 0.1f * width}}, TextureFilter::Bilinear, 8),
                    map.Texel(1, {2, 5}, 0), 1e-6f);
    // Trilinear at level 1.5 is the mean of both neighbours.
    const float width = std::sqrt(2.f) / 16;
    EXPECT_NEAR(map.FilterFloat({st, {0, width}, Vec2(0)}, TextureFilter::Trilinear, 8),
                0.5f * (map.FilterFloat({st, {0, 1.f / 16}, Vec2(0)}, TextureFilter::Bilinear, 8) +
                        map.FilterFloat({st, {0, 2.f / 16}, Vec2(0)}, TextureFilter::Bilinear, 8)),
                1e-5f);
    for (const TextureFilter filter : kFilters)
        EXPECT_EQ(map.FilterFloat({st, {3, 0}, {0, 3}}, filter, 8), map.Texel(4, {0, 0}, 0));
}

TEST(MipMap, AllFiltersKeepAConstant) {
    const MipMap map = Make(Constant({20, 13}, {0.25f, 0.5f, 0.75f}, {"R", "G", "B"}));
    for (const TextureFilter filter : kFilters)
        for (const Vec2 dx : {Vec2(0), Vec2(0.01f, 0), Vec2(0.1f, 0.3f), Vec2(0.002f, -0.4f), Vec2(2, 2)})
            for (const Vec2 dy : {Vec2(0), Vec2(0, 0.01f), Vec2(-0.05f, 0.02f), Vec2(0, 1e-9f)}) {
                const RGB rgb = map.FilterRGB({{0.3f, 0.9f}, dx, dy}, filter, 8);
                for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], 0.25f * float(c + 1), 1e-5f);
            }
}

TEST(MipMap, EwaBlursAlongTheFootprintOnly) {
    // Stripes that vary with t alone; a footprint that is long in s must keep their contrast, where the other
    // filters take a level at which they have vanished.
    Image image({64, 64}, {"Y"});
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) image.Set({x, y}, 0, y / 4 % 2 ? 1.f : 0.f);
    const MipMap map = Make(image);
    const TextureFootprint f{{0.5f, 6.f / 64}, {0.25f, 0}, {0, 1.f / 64}};
    EXPECT_GT(map.FilterFloat(f, TextureFilter::EWA, 32), 0.95f);
    EXPECT_NEAR(map.FilterFloat(f, TextureFilter::Trilinear, 32), 0.5f, 0.05f);
    // Turned by a right angle, it averages.
    EXPECT_NEAR(map.FilterFloat({f.st, {0, 0.25f}, {1.f / 64, 0}}, TextureFilter::EWA, 32), 0.5f, 0.1f);
}

TEST(MipMap, AbsurdFootprintsGiveFiniteValues) {
    const float nan = std::nanf("");
    for (const WrapMode wrap :
         {WrapMode::Repeat, WrapMode::Clamp, WrapMode::Black, WrapMode::OctahedralSphere}) {
        const MipMap map = Make(Random({33, 65}, {"R", "G", "B"}), wrap);
        for (const TextureFilter filter : kFilters)
            for (const float a : {0.f, 1e-38f, 1e-9f, 0.3f, 1e9f, 1e30f, Infinity, nan})
                for (const float b : {0.f, 1e-38f, 1e-3f, 1e9f, -Infinity, nan}) {
                    EXPECT_TRUE(
                        IsFinite(map.FilterRGB({{a, b}, {b, a}, {a, -b}}, filter, MipMap::kMaxAnisotropy)));
                    EXPECT_TRUE(std::isfinite(map.FilterFloat({{0.3f, 0.2f}, {a, a}, {b, b}}, filter, 8)));
                }
    }
}

// In all that memory holds; tiles are compared with these in texture_files_test.cpp.
TEST(MipMap, ImagesRepeatFarOutside) {
    const Vec2 x(1.f / 32, 0), y(0, 1.f / 32);
    for (const PixelFormat format : {PixelFormat::Byte, PixelFormat::Half, PixelFormat::Float})
        for (const auto& channels :
             std::vector<std::vector<std::string>>{{"Y"}, {"R", "G", "B"}, {"R", "G", "B", "A"}}) {
            Image image = Random({16, 8}, channels);
            image.format = format;
            const MipMap map = Make(image);
            ASSERT_EQ(map.NumChannels(), int(channels.size()));
            for (const TextureFilter filter : kFilters)
                for (const Point2 st : {Point2(0.25f, 0.625f), Point2(0.0625f, 0.96875f)})
                    for (const Vec2 images : {Vec2(3, 0), Vec2(0, -5), Vec2(-2000, 17), Vec2(2, 2)}) {
                        const TextureFootprint near{st, x, y}, far{st + images, x, y};
                        EXPECT_EQ(map.FilterFloat(far, filter, 8), map.FilterFloat(near, filter, 8));
                        EXPECT_EQ(map.FilterRGB(far, filter, 8), map.FilterRGB(near, filter, 8));
                    }
        }
}

TEST(MipMap, BlackWrapFadesToZeroOutside) {
    const MipMap map = Make(Constant({8, 8}, {1}, {"Y"}), WrapMode::Black);
    EXPECT_EQ(map.FilterFloat({{1.5f, 0.5f}, Vec2(0), Vec2(0)}, TextureFilter::Bilinear, 8), 0);
    EXPECT_FLOAT_EQ(map.FilterFloat({{1, 0.5f}, Vec2(0), Vec2(0)}, TextureFilter::Bilinear, 8), 0.5f);
}

TEST(MipMap, NumbersFromColoursFollowPbrt) {
    const TextureFootprint point{{0.5f, 0.5f}, Vec2(0), Vec2(0)}, wide{{0.5f, 0.5f}, Vec2(2), Vec2(2)};
    const MipMap rgb = Make(Constant({8, 8}, {0.1f, 0.2f, 0.6f}, {"R", "G", "B"}));
    EXPECT_NEAR(rgb.FilterFloat(point, TextureFilter::Bilinear, 8), 0.3f, 1e-6f);
    EXPECT_NEAR(rgb.FilterFloat(point, TextureFilter::Point, 8), 0.1f, 1e-6f);
    EXPECT_NEAR(rgb.FilterFloat(wide, TextureFilter::Bilinear, 8), 0.1f, 1e-6f);
    const MipMap rgba = Make(Constant({8, 8}, {0.1f, 0.2f, 0.6f, 0.5f}, {"R", "G", "B", "A"}));
    EXPECT_NEAR(rgba.FilterFloat(point, TextureFilter::Trilinear, 8), 0.5f, 1e-6f);
    EXPECT_NEAR(rgba.FilterFloat(point, TextureFilter::Point, 8), 0.1f, 1e-6f);
    EXPECT_NEAR(rgba.FilterRGB(point, TextureFilter::Bilinear, 8).z, 0.6f, 1e-6f);
    EXPECT_EQ(Make(Constant({8, 8}, {0.1f, 0.2f, 0.6f, 1.f}, {"R", "G", "B", "A"})).NumChannels(), 3);
    EXPECT_EQ(Make(Constant({8, 8}, {0.3f}, {"Y"})).FilterRGB(point, TextureFilter::Bilinear, 8), RGB(0.3f));
}

TEST(MipMap, UnsuitableImagesAreErrors) {
    EXPECT_THROW(Make(Constant({4, 4}, {1}, {"X", "Y", "Z"})), SceneError);
    EXPECT_THROW(Make(Constant({4, 4}, {1}, {"Y", "A"})), SceneError);
    EXPECT_THROW(Make(Constant({4, 4}, {1, std::nanf("")}, {"Y"})), SceneError);
    EXPECT_THROW(Make(Constant({4, 4}, {Infinity}, {"R", "G", "B"})), SceneError);
}

}  // namespace
}  // namespace lacquer::mipmap_test
