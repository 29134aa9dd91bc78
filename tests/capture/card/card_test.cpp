// The card as it is drawn: where its tags lie, and that the drawing and the image show them.
#include "capture/card/card.h"

#include <gtest/gtest.h>

#include <regex>

#include "capture/card/tags.h"

namespace lacquer::capture::card_test {
namespace {

using Eigen::Vector2d;

TEST(Card, IdsRunClockwiseFromTheTopLeft) {
    EXPECT_EQ(TagCenter(0), Vector2d(-8, 8));
    EXPECT_EQ(TagCenter(3), Vector2d(4, 8));
    EXPECT_EQ(TagCenter(4), Vector2d(8, 8));
    EXPECT_EQ(TagCenter(5), Vector2d(8, 4));
    EXPECT_EQ(TagCenter(8), Vector2d(8, -8));
    EXPECT_EQ(TagCenter(9), Vector2d(4, -8));
    EXPECT_EQ(TagCenter(12), Vector2d(-8, -8));
    EXPECT_EQ(TagCenter(13), Vector2d(-8, -4));
    EXPECT_EQ(TagCenter(15), Vector2d(-8, 4));
    // The size is the outer edge of the square of tags.
    EXPECT_DOUBLE_EQ(TagCorners(4, 17)[2].x() - TagCorners(12, 17)[0].x(), 17);
}

/// Corners in the image where TagCorner() has them; the largest distance [pixels].
double LargestError(const Image& image, int pixelsPerUnit) {
    const TagDetection found = DetectTags(image);
    EXPECT_EQ(found.tags.size(), size_t(kNumTags));
    EXPECT_TRUE(found.Missing().empty() && found.twice.empty() && found.unknown.empty());
    double worst = 0;
    for (const DetectedTag& tag : found.tags)
        for (int c = 0; c < 4; ++c) {
            const Vector2d corner = TagCorner(tag.id, c);
            const Vector2d expected =
                Vector2d(corner.x() + kPageUnits / 2, kPageUnits / 2 - corner.y()) * pixelsPerUnit;
            worst = std::max(worst, (tag.corners[size_t(c)] - expected).norm());
        }
    return worst;
}

TEST(Card, TheImageShowsAllTagsWhereTheyBelong) {
    for (const int pixelsPerUnit : {16, 29, 40}) {
        const double error = LargestError(CardImage(17, pixelsPerUnit), pixelsPerUnit);
        EXPECT_LT(error, 0.02) << pixelsPerUnit;
    }
}

/// The rectangles of all paths of a drawing, drawn into an image of so many pixels a unit.
Image Rasterize(const std::string& svg, double mmPerUnit, int pixelsPerUnit) {
    const int side = int(kPageUnits) * pixelsPerUnit;
    Image image({side, side}, {"Y"});
    for (float& v : image.Pixels()) v = 1;
    const std::regex rect(R"(M([\d.e+-]+) ([\d.e+-]+)h([\d.e+-]+)v([\d.e+-]+)h-)");
    for (std::sregex_iterator i(svg.begin(), svg.end(), rect), end; i != end; ++i) {
        double n[4];
        for (int k = 0; k < 4; ++k) n[k] = std::stod((*i)[size_t(k) + 1]) * pixelsPerUnit / mmPerUnit;
        for (int y = std::max(0, int(n[1] + 0.5)); y < std::min(side, int(n[1] + n[3] + 0.5)); ++y)
            for (int x = std::max(0, int(n[0] + 0.5)); x < std::min(side, int(n[0] + n[2] + 0.5)); ++x)
                image.Set({x, y}, 0, 0);
    }
    return image;
}

TEST(Card, TheDrawingHasItsSizeAndAllTags) {
    for (const double size : {5., 17., 100.}) {
        const std::string svg = CardSvg(size);
        std::smatch match;
        ASSERT_TRUE(
            std::regex_search(svg, match, std::regex("width=\"([0-9.]+)mm\" height=\"([0-9.]+)mm\"")));
        const double mmPerUnit = 10 * size / kUnitsPerSize;
        EXPECT_NEAR(std::stod(match[1]), kPageUnits * mmPerUnit, 1e-3);
        EXPECT_EQ(match[1], match[2]);
        EXPECT_LT(LargestError(Rasterize(svg, mmPerUnit, 32), 32), 0.02);
        EXPECT_NE(svg.find(">15<"), std::string::npos);
    }
    EXPECT_NE(CardSvg(17).find("tags: 17 cm"), std::string::npos);
    EXPECT_NE(CardSvg(17).find("this bar has 10 cm"), std::string::npos);
    EXPECT_NE(CardSvg(17).find("is 1.7 times"), std::string::npos);
    EXPECT_THROW(CardSvg(0), std::invalid_argument);
    EXPECT_THROW(CardSvg(std::nan("")), std::invalid_argument);
}

TEST(Card, TheScaleBarIsRoundAndFitsTheCard) {
    EXPECT_DOUBLE_EQ(ScaleBarLength(17), 10);
    EXPECT_DOUBLE_EQ(ScaleBarLength(10), 5);
    EXPECT_DOUBLE_EQ(ScaleBarLength(3.5), 2);
    EXPECT_DOUBLE_EQ(ScaleBarLength(1), 0.5);
    const std::vector<CardRect> marks = CardMarks(17);
    double least = 0, most = 0;
    for (const CardRect& r : marks)
        if (r.max.y() < -9) {
            least = std::min(least, r.min.x());
            most = std::max(most, r.max.x());
        }
    EXPECT_NEAR((most - least) * 17 / kUnitsPerSize, 10, 1e-12);
}

TEST(Card, TheTextureOfThePracticeSceneIsTheCard) {
    const std::string path = LACQUER_SOURCE_DIR "/scenes/capture/card.png";
    const Image card = CardImage(17, 16);
    const Image file = ReadImage(path, {ColorEncoding::Kind::SRGB, 1}, {path});
    ASSERT_EQ(file.Resolution(), card.Resolution());
    // Files of bytes are dithered.
    for (size_t i = 0; i < card.Pixels().size(); ++i)
        ASSERT_NEAR(file.Pixels()[i * size_t(file.NumChannels())], card.Pixels()[i], 0.01);
}

}  // namespace
}  // namespace lacquer::capture::card_test
