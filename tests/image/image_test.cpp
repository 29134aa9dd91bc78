#include "pbrt/image/image.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pbrt/image/half.h"

namespace lacquer::image_test {
namespace {

Image Ramp(Int2 resolution) {
    Image image(resolution, {"Y"});
    for (int y = 0; y < resolution.y; ++y)
        for (int x = 0; x < resolution.x; ++x) image.Set({x, y}, 0, float(x + 10 * y));
    return image;
}

TEST(ColorEncoding, ToLinearAndFromLinearAreInverse) {
    for (const char* name : {"sRGB", "linear", "gamma 2.2", "gamma 1.8"}) {
        const auto encoding = ColorEncoding::Parse(name);
        ASSERT_TRUE(encoding) << name;
        // Two powers of rounding 2^-24 each; near 0 the curves are at most 13 times as steep.
        for (int i = 0; i <= 100; ++i) {
            const float v = float(i) / 100;
            EXPECT_NEAR(encoding->FromLinear(encoding->ToLinear(v)), v, 2e-6f) << name << " " << v;
        }
        EXPECT_EQ(encoding->ToLinear(0), 0);
        EXPECT_NEAR(encoding->ToLinear(1), 1, 1e-6f);
    }
}

TEST(ColorEncoding, SrgbByte188IsHalf) {
    // ((188/255 + 0.055) / 1.055)^2.4
    EXPECT_NEAR(ColorEncoding::Parse("sRGB")->ByteTable()[188], 0.50289f, 1e-5f);
}

TEST(ColorEncoding, UnknownNamesAndAbsurdGammasAreRefused) {
    for (const char* name : {"", "srgb", "SRGB", "gamma", "gamma ", "gamma x", "gamma 0", "gamma -1",
                             "gamma nan", "gamma inf", "gamma 1e9", "gamma 2.2x"})
        EXPECT_FALSE(ColorEncoding::Parse(name)) << name;
}

TEST(Half, EveryHalfSurvivesTheRoundTrip) {
    for (uint32_t h = 0; h < 0x10000; ++h) {
        const float f = HalfToFloat(uint16_t(h));
        if (std::isnan(f)) {
            EXPECT_TRUE(std::isnan(HalfToFloat(FloatToHalf(f))));
        } else {
            EXPECT_EQ(FloatToHalf(f), h) << f;
        }
    }
    EXPECT_EQ(HalfToFloat(0x3c00), 1.f);
    EXPECT_EQ(HalfToFloat(0x7bff), kMaxHalf);
    EXPECT_EQ(HalfToFloat(0x0001), 0x1p-24f);
}

TEST(Half, RoundsToNearestAndTiesToEven) {
    const float step = 0x1p-10f;  // of halves from 1 to 2
    EXPECT_EQ(HalfToFloat(FloatToHalf(1 + 0.49f * step)), 1.f);
    EXPECT_EQ(HalfToFloat(FloatToHalf(1 + 0.51f * step)), 1 + step);
    EXPECT_EQ(HalfToFloat(FloatToHalf(1 + 0.5f * step)), 1.f);
    EXPECT_EQ(HalfToFloat(FloatToHalf(1 + 1.5f * step)), 1 + 2 * step);
    EXPECT_EQ(FloatToHalf(1e6f), 0x7c00);
}

TEST(WrapMode, RepeatIsPeriodic) {
    const Image image = Ramp({4, 3});
    for (int x = -9; x < 9; ++x)
        for (int y = -7; y < 7; ++y)
            EXPECT_EQ(image.GetWrapped({x, y}, 0, WrapMode::Repeat), float(Mod(x, 4) + 10 * Mod(y, 3)));
}

TEST(WrapMode, ClampTakesTheNearestAndBlackIsZero) {
    const Image image = Ramp({4, 3});
    EXPECT_EQ(image.GetWrapped({-5, 1}, 0, WrapMode::Clamp), 10);
    EXPECT_EQ(image.GetWrapped({9, 9}, 0, WrapMode::Clamp), 23);
    EXPECT_EQ(image.GetWrapped({-1, 1}, 0, WrapMode::Black), 0);
    EXPECT_EQ(image.GetWrapped({1, 3}, 0, WrapMode::Black), 0);
    EXPECT_EQ(image.GetWrapped({1, 2}, 0, WrapMode::Black), 21);
}

TEST(WrapMode, OctahedralNeighboursAreNeighboursOnTheSphere) {
    // Independent check: the direction of the wrapped pixel is next to that of the edge pixel it was reached
    // from. A pixel of a 64^2 map spans about sqrt(4 pi)/64 = 0.055 rad; its octahedral shape stretches that
    // by up to 2.5.
    constexpr int n = 64;
    const auto direction = [](Int2 p) {
        return EqualAreaSquareToSphere({(float(p.x) + 0.5f) / n, (float(p.y) + 0.5f) / n});
    };
    for (int i = 0; i < n; ++i)
        for (const auto& [inside, outside] :
             {std::pair(Int2(0, i), Int2(-1, i)), std::pair(Int2(n - 1, i), Int2(n, i)),
              std::pair(Int2(i, 0), Int2(i, -1)), std::pair(Int2(i, n - 1), Int2(i, n))}) {
            Int2 wrapped = outside;
            ASSERT_TRUE(WrapPixel(&wrapped, {n, n}, WrapMode::OctahedralSphere));
            EXPECT_LT(AngleBetween(direction(inside), direction(wrapped)), 0.14f)
                << outside.x << " " << outside.y;
        }
}

TEST(WrapMode, NamesAreParsed) {
    EXPECT_EQ(ParseWrapMode("repeat"), WrapMode::Repeat);
    EXPECT_EQ(ParseWrapMode("octahedralsphere"), WrapMode::OctahedralSphere);
    EXPECT_FALSE(ParseWrapMode("mirror"));
}

TEST(Image, BilinearInterpolatesBetweenPixelCentres) {
    const Image image = Ramp({4, 4});
    EXPECT_FLOAT_EQ(image.Bilinear({1.5f / 4, 2.5f / 4}, 0, WrapMode::Clamp), 21);
    EXPECT_FLOAT_EQ(image.Bilinear({2.f / 4, 2.5f / 4}, 0, WrapMode::Clamp), 21.5f);
    EXPECT_FLOAT_EQ(image.Bilinear({2.f / 4, 2.f / 4}, 0, WrapMode::Clamp), 16.5f);
    EXPECT_FLOAT_EQ(image.Bilinear({0, 0.5f / 4}, 0, WrapMode::Repeat), 1.5f);  // halfway from 3 to 0
}

TEST(Image, AbsurdCoordinatesGiveFiniteValues) {
    const Image image = Ramp({4, 4});
    for (WrapMode wrap : {WrapMode::Repeat, WrapMode::Clamp, WrapMode::Black, WrapMode::OctahedralSphere})
        for (float x : {1e30f, -1e30f, 3e9f, Infinity, -Infinity, std::nanf("")})
            EXPECT_TRUE(std::isfinite(image.Bilinear({x, 0.3f}, 0, wrap)));
}

TEST(Image, NonFinitePixelsAreFound) {
    Image image = Ramp({4, 4});
    EXPECT_FALSE(image.HasNonFinite());
    image.Set({1, 1}, 0, Infinity);
    EXPECT_TRUE(image.HasNonFinite());
    image.Set({1, 1}, 0, std::nanf(""));
    EXPECT_TRUE(image.HasNonFinite());
}

TEST(Image, PartsKeepWhatTheirChannelsNeed) {
    Image image({2, 1}, {"R", "Depth.Z"});
    image.floatChannels = {"Depth.Z"};
    const Image depth = image.OnlyChannels([](const std::string& name) { return name != "R"; });
    EXPECT_EQ(depth.Channels(), std::vector<std::string>{"Depth.Z"});
    EXPECT_EQ(depth.floatChannels, std::set<std::string>{"Depth.Z"});
    const Image color = image.OnlyChannels([](const std::string& name) { return name == "R"; });
    EXPECT_TRUE(color.floatChannels.empty());
}

TEST(Image, RoomForChannelsLeavesTheOthers) {
    const Image image = Ramp({3, 2});
    const Image wider = image.WithRoomFor({"more", "most"});
    ASSERT_EQ(wider.NumChannels(), image.NumChannels() + 2);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 3; ++x) {
            for (int c = 0; c < image.NumChannels(); ++c)
                EXPECT_EQ(wider.Get({x, y}, c), image.Get({x, y}, c));
            EXPECT_EQ(wider.Get({x, y}, image.NumChannels() + 1), 0);
        }
}

TEST(Image, HasRgbGoesByNames) {
    EXPECT_TRUE(Image({1, 1}, {"R", "G", "B", "A"}).HasRGB());
    EXPECT_FALSE(Image({1, 1}, {"X", "Y", "Z"}).HasRGB());
    EXPECT_FALSE(Image({1, 1}, {"R", "G"}).HasRGB());
}

}  // namespace
}  // namespace lacquer::image_test
