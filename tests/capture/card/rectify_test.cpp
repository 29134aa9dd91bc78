// Rectified photographs: where points of the sample come to lie, and what becomes of their values.
#include "capture/card/rectify.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/card/calibration.h"
#include "capture/card/card_photographs.h"
#include "support/statistics.h"

namespace lacquer::capture::rectify_test {
namespace {

using test::SeedOf;
using namespace test_cards;
using Eigen::Vector2d;

/// Values a(x, y) of grey in three channels.
Image Filled(Int2 size, const std::function<double(double, double)>& value) {
    Image image(size, {"R", "G", "B"});
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (int c = 0; c < 3; ++c) image.Set({x, y}, c, float(value(x + 0.5, y + 0.5)));
    return image;
}

Image Colored(const Image& grey) {
    return Filled(grey.Resolution(), [&](double x, double y) { return grey.Get({int(x), int(y)}, 0); });
}

/// A camera straight above whose pixels are 1/20 cm wide, in a photograph of 200 x 200.
constexpr Intrinsics kAbove{500, 100, 100, 0, 0};
const CameraPose kPoseAbove = LookAtCard({0, 0, 25});

TEST(Rectify, PixelsThatCoincideAreCopiedAndSquaresOfThemAveraged) {
    const auto value = [](double x, double y) { return 0.5 + 0.3 * std::sin(1.3 * x) * std::cos(0.9 * y); };
    const Image photograph = Filled({200, 200}, value);
    const RectifiedPhotograph same = Rectify(photograph, kAbove, kPoseAbove, {5, 0, 100});
    const RectifiedPhotograph half = Rectify(photograph, kAbove, kPoseAbove, {5, 0, 50});
    for (int row = 0; row < 50; row += 7)
        for (int column = 0; column < 50; column += 3) {
            EXPECT_NEAR(same.linear.Get({column, row}, 1), value(column + 50.5, row + 50.5), 1e-5);
            double mean = 0;
            for (int i = 0; i < 4; ++i) mean += value(50.5 + 2 * column + i % 2, 50.5 + 2 * row + i / 2) / 4;
            EXPECT_NEAR(half.linear.Get({column, row}, 1), mean, 1e-5);
        }
    EXPECT_EQ(same.outsideShare, 0);
}

TEST(Rectify, MagnifiedParabolasAreExact) {
    const auto value = [](double x, double y) {
        return 0.2 + 0.004 * x + 1e-5 * (x - 90) * (y - 70) + 1e-5 * x * x;
    };
    const RectifiedPhotograph fine = Rectify(Filled({200, 200}, value), kAbove, kPoseAbove, {5, 0, 700});
    for (int row = 10; row < 700; row += 37)
        for (int column = 5; column < 700; column += 41)
            EXPECT_NEAR(fine.linear.Get({column, row}, 0),
                        value(50 + (column + 0.5) / 7, 50 + (row + 0.5) / 7), 1e-5);
}

TEST(Rectify, TellsWhatIsClippedOrOutside) {
    const Image photograph = Filled({200, 200}, [](double x, double) { return x < 60 ? 1. : 0.5; });
    RectifiedPhotograph found = Rectify(photograph, kAbove, kPoseAbove, {5, 0, 100});
    EXPECT_NEAR(found.clippedShare, 0.1, 0.02);
    found = Rectify(photograph, kAbove, kPoseAbove, {12, 0, 60});
    EXPECT_NEAR(found.outsideShare, 1 - std::pow(10. / 12, 2), 0.02);
}

/// A dark sample with bright spots, n x n of them at equal distances.
struct Spots {
    int n = 5;
    double spacing = 2, width = 0.12;  // cm
    Vector2d At(int i) const { return spacing * Vector2d(i % n - (n - 1) / 2., i / n - (n - 1) / 2.); }
    /// Spots do not reach each other: the nearest one counts.
    double operator()(double x, double y) const {
        const double last = (n - 1) / 2., u = std::clamp(std::round(x / spacing), -last, last) * spacing,
                     v = std::clamp(std::round(y / spacing), -last, last) * spacing;
        return 0.05 + 0.7 * std::exp(-(Vector2d(x - u, y - v)).squaredNorm() / (2 * width * width));
    }
};

/// Where the spot is in a rectified image, as the centroid of what is brighter than around it [pixels].
Vector2d Centroid(const Image& image, const Vector2d& expected) {
    Vector2d at = expected;
    for (int iteration = 0; iteration < 5; ++iteration) {
        Vector2d sum(0, 0);
        double weight = 0;
        for (int y = int(at.y()) - 14; y <= int(at.y()) + 14; ++y)
            for (int x = int(at.x()) - 14; x <= int(at.x()) + 14; ++x) {
                const Vector2d p(x + 0.5, y + 0.5);
                if ((p - at).norm() > 9) continue;
                const double w = std::max(0., double(image.Get({x, y}, 0)) - 0.08);
                sum += w * p;
                weight += w;
            }
        at = sum / weight;
    }
    return at;
}

double WorstSpot(const RectifiedPhotograph& rectified, const Spots& spots, double square) {
    const int n = rectified.linear.Resolution().x;
    double worst = 0;
    for (int i = 0; i < spots.n * spots.n; ++i) {
        // Columns along x, rows against y.
        const Vector2d expected((spots.At(i).x() / square + 0.5) * n, (0.5 - spots.At(i).y() / square) * n);
        worst = std::max(worst, (Centroid(rectified.linear, expected) - expected).norm());
    }
    return worst;
}

/// The requirement is 0.3 of 256 pixels.
TEST(Rectify, PointsOfTheSampleComeToLieWhereTheyBelong) {
    PhotographedCard card;
    card.depth = 0.3;
    const Spots spots;
    card.sample = spots;
    Photographer photographer;
    photographer.intrinsics = {605, 329, 250, 0.08, -0.05};
    photographer.vignetting = 0.1;  // moves centroids itself
    const std::vector<CameraPose> poses = {NinePoses()[0], NinePoses()[2], NinePoses()[4], NinePoses()[7]};
    std::vector<Image> images;
    for (size_t i = 0; i < poses.size(); ++i)
        images.push_back(WithNoise(TakePhotograph(card, photographer, poses[i]), 0.01, SeedOf("spots") + i));
    CalibrationOptions options;
    options.resolution = photographer.resolution;
    const Calibration found = Calibrate(Detect(images), options);
    for (size_t i = 0; i < poses.size(); ++i) {
        const auto worst = [&](const Intrinsics& intrinsics, double depth) {
            return WorstSpot(
                Rectify(Colored(images[i]), intrinsics, found.photographs[i].pose, {10.88, depth, 256}),
                spots, 10.88);
        };
        EXPECT_LT(worst(found.intrinsics, 0.3), 0.2) << i;
        // What the measure sees: another depth, and distortion that is left as it is.
        if (i == 0) {
            EXPECT_GT(worst(found.intrinsics, 0), 1);
        }
        Intrinsics straight = found.intrinsics;
        straight.k1 = straight.k2 = 0;
        EXPECT_GT(worst(straight, 0.3), 0.3) << i;
    }
    std::vector<CameraPose> estimated;
    for (const PhotographPose& p : found.photographs) estimated.push_back(p.pose);
    EXPECT_NEAR(PixelsAcross(found.intrinsics, estimated, 10.88, 0.3), 605 * 10.88 / 25, 40);
}

}  // namespace
}  // namespace lacquer::capture::rectify_test
