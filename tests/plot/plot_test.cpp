// Font, colours and scales of the contact sheet.
#include <gtest/gtest.h>

#include <cmath>

#include "plot/canvas.h"
#include "plot/plot.h"

namespace lacquer::plot::plot_test {
namespace {

TEST(StrokeFont, HasAllOfAsciiAndTheSignsOfTheSheet) {
    for (char32_t c = 32; c < 127; ++c) EXPECT_TRUE(StrokeFont::Plain().Has(c)) << char(c);
    for (const char32_t c : DecodeUtf8("°±²·×−–…θφρσωχ∫"))
        EXPECT_TRUE(StrokeFont::Plain().Has(c)) << unsigned(c);
    EXPECT_FALSE(StrokeFont::Plain().Has(U'字'));
    EXPECT_FALSE(StrokeFont::Plain().Find(U'字').strokes.empty());  // a box
}

TEST(StrokeFont, DigitsHaveOneAdvance) {
    for (char32_t c = U'0'; c <= U'9'; ++c)
        EXPECT_EQ(StrokeFont::Plain().Find(c).advance, StrokeFont::Plain().Find(U'0').advance);
}

TEST(StrokeFont, RefusesWhatItDoesNotUnderstand) {
    EXPECT_THROW(StrokeFont("x 4 L 1 2 3"), std::logic_error);
    EXPECT_THROW(StrokeFont("x 4 A 1 2 3"), std::logic_error);
    EXPECT_THROW(StrokeFont("xy 4 L 1 2 3 4"), std::logic_error);
    EXPECT_NO_THROW(StrokeFont("# comment\nx 4 L 1 2 3 4\n"));
}

TEST(DecodeUtf8, ReplacesBytesThatAreNoCharacter) {
    EXPECT_EQ(DecodeUtf8("aθ"), U"aθ");
    EXPECT_EQ(DecodeUtf8("a\xff"), U"a\xfffd");
    EXPECT_EQ(DecodeUtf8("\xce"), U"\xfffd");
}

TEST(Canvas, TextStaysWithinItsWidth) {
    Canvas canvas(200, 40, RGB(0));
    const float width = canvas.Text({20, 30}, 14, RGB(1), "f cos θ 0.25");
    EXPECT_FLOAT_EQ(width, Canvas::TextWidth(14, "f cos θ 0.25"));
    double inside = 0, outside = 0;
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 200; ++x)
            (x >= 19 && float(x) <= 21 + width ? inside : outside) += double(canvas.AsImage().Get({x, y}, 0));
    EXPECT_GT(inside, 200);
    EXPECT_EQ(outside, 0);
}

TEST(Canvas, ShapesHaveTheirArea) {
    Canvas canvas(64, 64, RGB(0));
    canvas.FillCircle({32.3f, 31.6f}, 20, RGB(1));
    double area = 0;
    for (const float v : canvas.AsImage().Pixels()) area += double(v) / 3;
    EXPECT_NEAR(area, double(Pi) * 400, 3);
    canvas.FillRectangle(-100, -100, 1000, 1000, RGB(0.25f));  // what lies outside is left out
    EXPECT_FLOAT_EQ(canvas.AsImage().Get({63, 63}, 2), 0.25f);
}

TEST(ColorScale, SequentialStepsAreEqualInLightness) {
    for (int i = 0; i <= 50; ++i) {
        const RGB color = ColorScale::Sequential().At(i / 50.0);
        for (int c = 0; c < 3; ++c) {
            EXPECT_GE(color[c], 0);
            EXPECT_LE(color[c], 1);
        }
        const double lightness = double(OklabFromLinear(color).x);
        EXPECT_NEAR(lightness, 0.14 + 0.835 * i / 50.0, 1e-3);
    }
}

TEST(ColorScale, DivergingIsLightestInTheMiddleAndBlueBelow) {
    const ColorScale& scale = ColorScale::Diverging();
    for (const double side : {0.1, 0.2, 0.3, 0.4}) {
        const Vec3 low = OklabFromLinear(scale.At(0.5 - side)), high = OklabFromLinear(scale.At(0.5 + side));
        EXPECT_NEAR(low.x, high.x, 1e-3);  // of equal lightness: neither side weighs more
        EXPECT_LT(low.x, OklabFromLinear(scale.At(0.5)).x);
        EXPECT_LT(low.z, -0.02f);
        EXPECT_GT(high.y, 0.02f);
    }
    EXPECT_EQ(scale.At(std::nan("")), scale.At(0));
}

TEST(Scales, TicksAreRoundAndOnTheScale) {
    EXPECT_EQ(TicksOf({0, 1, false}).labelled,
              (std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1}));
    const ValueScale scale{0.003, 3, true};
    const Ticks ticks = TicksOf(scale);
    ASSERT_EQ(ticks.labelled.size(), 3u);
    EXPECT_NEAR(ticks.labelled[0], 0.01, 1e-9);
    EXPECT_NEAR(scale.Position(3), 1, 1e-12);
    EXPECT_EQ(ShortNumber(0.01), "0.01");
    EXPECT_EQ(ShortNumber(1e-5), "1e-5");
    EXPECT_EQ(ShortNumber(-4), "-4");
}

TEST(Scales, LogScaleHoldsOneToFiveDecades) {
    EXPECT_NEAR(LogScaleOf({1, 1, 1, 1}).low, 0.1, 1e-12);
    std::vector<double> wide(1000);
    for (size_t i = 0; i < wide.size(); ++i) wide[i] = std::pow(10, -0.02 * double(i));
    EXPECT_NEAR(LogScaleOf(wide).low, 1e-5, 1e-12);
    const ValueScale empty = LogScaleOf({0, 0, std::nan("")});
    EXPECT_LT(empty.low, empty.high);
}

}  // namespace
}  // namespace lacquer::plot::plot_test
