// Positions of cameras from photographs of a card, against the truth, and what is no card.
#include "capture/card/calibration.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "capture/card/card_photographs.h"
#include "pbrt/core/error.h"
#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::capture::calibration_test {
namespace {

using test::SeedOf;
using namespace test_cards;
using Eigen::Vector3d;

/// What a capture needs [cm]: an angle of 0.2 degrees at 17 cm.
constexpr double kNeeded = 0.05;

CalibrationOptions OptionsOf(const Photographer& photographer) {
    CalibrationOptions options;
    options.resolution = photographer.resolution;
    return options;
}

Calibration CalibrateCard(const PhotographedCard& card, const Photographer& photographer,
                          const std::vector<CameraPose>& poses) {
    return Calibrate(TakeAndDetect(card, photographer, poses, SeedOf(test::FullTestName())),
                     OptionsOf(photographer));
}

/// The largest distance between a position and the truth [cm].
double WorstPosition(const Calibration& found, const std::vector<CameraPose>& poses) {
    double worst = 0;
    for (size_t i = 0; i < poses.size(); ++i)
        worst = std::max(worst, (found.photographs[i].pose.position - poses[i].position).norm());
    return worst;
}

std::vector<CameraPose> SomePoses(std::initializer_list<size_t> indices) {
    std::vector<CameraPose> poses;
    for (const size_t i : indices) poses.push_back(NinePoses()[i]);
    return poses;
}

TEST(Calibration, FindsCamerasOfNinePhotographsWithDistortionAndNoise) {
    Photographer photographer;
    photographer.intrinsics = {605, 329, 250, 0.1, -0.1};
    const Calibration found = CalibrateCard({}, photographer, NinePoses());
    EXPECT_LT(WorstPosition(found, NinePoses()), kNeeded / 5);
    EXPECT_LT(std::abs(found.intrinsics.f - 605), 4 * found.focalError);
    EXPECT_LT(found.focalError, 0.3);
    EXPECT_NEAR(found.intrinsics.cx, 329, 0.5);
    EXPECT_NEAR(found.intrinsics.cy, 250, 0.5);
    EXPECT_NEAR(found.intrinsics.k1, 0.1, 0.01);
    EXPECT_LT(found.rms, 0.1);
    EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
    for (const PhotographPose& p : found.photographs) EXPECT_EQ(p.tags.size(), 16u);
}

/// Noisy photographs from one set of poses, again and again: normalised squares of the error of the first
/// position, over its standard errors times `scale`. 3 degrees of freedom each.
double SumOfNormalizedSquares(int repeats, double scale, uint64_t seed, Vector3d* meanError) {
    Photographer photographer;
    photographer.resolution = {480, 400};
    photographer.intrinsics = {455, 247, 196, 0.05, 0};
    photographer.samplesPerEdge = 11;  // with 5, its own errors are seen
    const std::vector<CameraPose> poses = SomePoses({0, 5, 7});
    std::vector<Image> clean;
    for (const CameraPose& pose : poses) clean.push_back(TakePhotograph({}, photographer, pose));
    double sum = 0;
    *meanError = Vector3d::Zero();
    for (int k = 0; k < repeats; ++k) {
        std::vector<Image> noisy;
        for (size_t i = 0; i < clean.size(); ++i)
            noisy.push_back(WithNoise(clean[i], 0.04, Hash(seed, k, i)));
        const Calibration found = Calibrate(Detect(noisy), OptionsOf(photographer));
        const Vector3d error = found.photographs[0].pose.position - poses[0].position;
        sum += error.dot(found.photographs[0].covariance.inverse() * error) / (scale * scale);
        *meanError += error.cwiseQuotient(found.photographs[0].PositionError()) / repeats;
    }
    return sum;
}

/// Of 40 positions with 3 numbers each, chi-square has 120 degrees of freedom and a deviation of 13 %: at
/// this level, standard errors that are wrong by a quarter are found nine times of ten.
TEST(Calibration, StandardErrorsOfPositionsAreHonest) {
    const int repeats = test::Scaled(40);
    Vector3d meanError;
    const auto outcome = [&](double sum) {
        const double p = test::ChiSquareSurvival(sum, 3 * repeats);
        return test::Outcome{2 * std::min(p, 1 - p), fmt::format("chi-square {} of {}", sum, 3 * repeats)};
    };
    const auto check = [&](uint64_t seed) {
        return outcome(SumOfNormalizedSquares(repeats, 1, seed, &meanError));
    };
    const uint64_t seed = SeedOf("standard errors of positions");
    const double sum = SumOfNormalizedSquares(repeats, 1, seed, &meanError);
    EXPECT_TRUE(test::PassesAt(seed, "standard errors of positions", 1e-3, outcome(sum), check));
    EXPECT_LT(meanError.cwiseAbs().maxCoeff(), 4 / std::sqrt(repeats));
    if (repeats == 40) {
        for (const double wrong : {0.7, 1.5}) EXPECT_LT(outcome(sum / (wrong * wrong)).pValue, 1e-3) << sum;
    }
}

TEST(Calibration, WrongTagsDoNotCountAndAreNamed) {
    PhotographedCard card;
    card.PutTag(3, 10);  // swapped
    card.PutTag(10, 3);
    card.PutTag(6, 77);  // of no card
    card.Cover(13);
    const std::vector<CameraPose> poses = SomePoses({0, 2, 4, 7});
    const Calibration found = CalibrateCard(card, {}, poses);
    EXPECT_LT(WorstPosition(found, poses), kNeeded / 3);
    EXPECT_EQ(found.photographs[1].rejected, (std::vector<int>{3, 10}));
    ASSERT_EQ(found.warnings.size(), 12u);
    EXPECT_EQ(found.warnings[0],
              "p0: tags 6 and 13 are not seen: the position of the camera is less certain");
    EXPECT_EQ(found.warnings[1], "p0: tags 3 and 10 are not where the card has them, and do not count");
    EXPECT_EQ(found.warnings[2], "p0: tags 77 are of no card, and do not count");
}

/// As a tag whose corner bends up, or whose edge a shadow moves: too little for the homography to see.
TEST(Calibration, ATagThatIsOffByAPixelDoesNotCount) {
    const std::vector<CameraPose> poses = SomePoses({0, 2, 4, 7});
    std::vector<CardPhotograph> photographs = TakeAndDetect({}, {}, poses, SeedOf("off"));
    for (Eigen::Vector2d& corner : photographs[2].detection.tags[5].corners)
        corner += Eigen::Vector2d(0.8, -0.6);
    const Calibration found = Calibrate(photographs, OptionsOf({}));
    EXPECT_EQ(found.photographs[2].rejected, std::vector<int>{5});
    EXPECT_TRUE(found.photographs[1].rejected.empty());
    EXPECT_LT(WorstPosition(found, poses), kNeeded / 3);
    ASSERT_EQ(found.warnings.size(), 1u);
    EXPECT_EQ(found.warnings[0], "p2: tags 5 lie off from where the others say, and do not count");
}

/// Every second tag, and a whole row with its neighbours: positions stay good enough, and errors tell by how
/// much.
TEST(Calibration, EightTagsAroundTheWindowAreEnough) {
    const std::vector<CameraPose> poses = NinePoses();
    const std::vector<CardPhotograph> all = TakeAndDetect({}, {}, poses, SeedOf("eight"));
    const Calibration whole = Calibrate(all, OptionsOf({}));
    for (const std::vector<int>& missing : {std::vector<int>{0, 2, 4, 6, 8, 10, 12, 14}, {0, 1, 2, 3, 4}}) {
        std::vector<CardPhotograph> some = all;
        for (CardPhotograph& p : some)
            std::erase_if(p.detection.tags, [&](const DetectedTag& t) {
                return std::find(missing.begin(), missing.end(), t.id) != missing.end();
            });
        const Calibration found = Calibrate(some, OptionsOf({}));
        EXPECT_LT(WorstPosition(found, poses), kNeeded / 3);
        for (size_t i = 0; i < poses.size(); ++i) {
            const double error = std::sqrt(found.photographs[i].covariance.trace()),
                         before = std::sqrt(whole.photographs[i].covariance.trace());
            EXPECT_LT(error, 2.5 * before);
            EXPECT_GT(error, before);
            EXPECT_LT((found.photographs[i].pose.position - poses[i].position).norm(), 4 * error);
        }
    }
}

TEST(Calibration, OnePhotographTakesTheFocalLengthOfItsMetadata) {
    const Photographer photographer;
    for (const size_t pose : {0u, 4u, 8u}) {
        const std::vector<CameraPose> poses = SomePoses({pose});
        const auto photographs = TakeAndDetect({}, photographer, poses, SeedOf("one"));
        CalibrationOptions options = OptionsOf(photographer);
        EXPECT_THROW(Calibrate(photographs, options), SceneError);
        options.focal = 605;
        const Calibration known = Calibrate(photographs, options);
        EXPECT_EQ(known.intrinsics.f, 605);
        EXPECT_EQ(known.focalError, 0);
        EXPECT_LT(WorstPosition(known, poses), kNeeded / 3);
        // Metadata are wrong by 2 %: so is the distance, and the standard errors know it.
        options.focal = {};
        options.focalOfMetadata = 605 * 1.02;
        const Calibration found = Calibrate(photographs, options);
        EXPECT_EQ(found.intrinsics.f, 605 * 1.02);
        EXPECT_EQ(found.intrinsics.k1, 0);
        EXPECT_NEAR(found.focalError / found.intrinsics.f, 0.03, 1e-12);
        EXPECT_GT(WorstPosition(found, poses), 0.3);
        EXPECT_LT(WorstPosition(found, poses), 2 * std::sqrt(found.photographs[0].covariance.trace()));
    }
}

/// Tags are looked for in a smaller image, and their edges in the whole one.
TEST(Calibration, LargePhotographsAreAsExactAsTheirPixels) {
    Photographer photographer;
    photographer.resolution = {2600, 2080};
    photographer.intrinsics = {2450, 1300, 1040, 0, 0};
    photographer.samplesPerEdge = 3;
    CalibrationOptions options = OptionsOf(photographer);
    options.focal = 2450;
    const std::vector<CameraPose> poses = SomePoses({7});
    const Calibration found = Calibrate(TakeAndDetect({}, photographer, poses, SeedOf("large")), options);
    EXPECT_EQ(found.photographs[0].tags.size(), 16u);
    EXPECT_LT(found.rms, 0.1);
    EXPECT_LT(WorstPosition(found, poses), kNeeded / 10);
}

/// Nothing but a ruler sees a print of another size: positions are in proportion.
TEST(Calibration, AWrongSizeScalesPositions) {
    const std::vector<CameraPose> poses = SomePoses({0, 2, 4, 7});
    const auto photographs = TakeAndDetect({}, {}, poses, SeedOf("size"));
    CalibrationOptions options = OptionsOf({});
    const Calibration right = Calibrate(photographs, options);
    options.size = 17 * 0.97;
    const Calibration wrong = Calibrate(photographs, options);
    for (size_t i = 0; i < poses.size(); ++i)
        EXPECT_LT((wrong.photographs[i].pose.position - 0.97 * right.photographs[i].pose.position).norm(),
                  1e-3);
    EXPECT_GT(WorstPosition(wrong, poses), 10 * kNeeded);
}

TEST(Calibration, WarnsOfEqualPositionsAndOfViewsThatTellLittle) {
    const CameraPose above = LookAtCard({0, 0, 25}), turned = LookAtCard({0, 0.1, 25}, {0, 0.1}, 50);
    const CameraPose aside = LookAtCard({2, 1, 26}, {2, 1}, 90);
    const Calibration found = CalibrateCard({}, {}, {above, turned, aside});
    std::string all;
    for (const std::string& warning : found.warnings) all += warning + "\n";
    EXPECT_NE(all.find("p0 and p1 were taken from the same position"), std::string::npos) << all;
    EXPECT_EQ(all.find("p0 and p2"), std::string::npos) << all;
    EXPECT_NE(all.find("cm only; photographs from more slanted directions"), std::string::npos) << all;
    EXPECT_NE(all.find("the photographs tell the focal length to"), std::string::npos) << all;
    // What they say is known is.
    for (size_t i = 0; i < 3; ++i) {
        const std::vector<CameraPose> poses{above, turned, aside};
        EXPECT_LT((found.photographs[i].pose.position - poses[i].position).norm(),
                  3 * std::sqrt(found.photographs[i].covariance.trace()));
    }
}

/// The message of what is refused, with its places; empty if nothing is.
std::string RefusalOf(const std::vector<CardPhotograph>& photographs, std::optional<double> focal = {}) {
    CalibrationOptions options = OptionsOf({});
    options.focal = focal;
    try {
        Calibrate(photographs, options);
    } catch (const std::runtime_error& e) {
        return e.what();
    }
    return {};
}

TEST(Calibration, PhotographsThatCannotBeUsedAreNamedTogether) {
    const std::vector<CameraPose> poses = SomePoses({0, 4, 7});
    std::vector<CardPhotograph> photographs = TakeAndDetect({}, {}, poses, SeedOf("unusable"));
    EXPECT_EQ(RefusalOf(photographs), "");
    EXPECT_EQ(RefusalOf({}), "error: there are no photographs");
    photographs[0].detection.tags.clear();
    photographs[1].detection.twice = {3, 5};
    std::erase_if(photographs[2].detection.tags,
                  [](const DetectedTag& t) { return t.id == 0 || t.id == 1 || t.id == 15; });
    EXPECT_EQ(RefusalOf(photographs),
              "p0: error: no tags of the card are seen; expected the ids 0 to 15, sharp and not mirrored\n"
              "p1: error: tags are seen more than once: 3 and 5; expected one card\n"
              "p2: error: 13 of the 16 tags are seen, 0, 1 and 15 are missing; expected at least 8, at each "
              "corner of "
              "the card one of its three");
}

TEST(Calibration, WhatIsNoFlatPrintOfTheCardIsRefused) {
    const std::vector<CameraPose> poses = SomePoses({0, 2, 7});
    const auto refusalOfOne = [&](const PhotographedCard& card) {
        return RefusalOf(TakeAndDetect(card, {}, SomePoses({4}), SeedOf("no print")), 605);
    };
    const auto refusal = [&](const PhotographedCard& card) {
        return RefusalOf(TakeAndDetect(card, {}, poses, SeedOf("no print")));
    };
    PhotographedCard mirrored;
    mirrored.Mirror();
    EXPECT_NE(refusalOfOne(mirrored).find("no tags of the card are seen"), std::string::npos);
    PhotographedCard order;  // counter-clockwise from the top left
    for (int place = 0; place < 16; ++place) order.PutTag(place, (16 - place) % 16);
    EXPECT_NE(refusalOfOne(order).find("are not where the card has them; expected a print of this card"),
              std::string::npos);
    PhotographedCard twice;
    twice.PutTag(9, 2);
    EXPECT_NE(refusalOfOne(twice).find("seen more than once: 2;"), std::string::npos);
    PhotographedCard bent;  // as paper that was rolled
    bent.bend = 1.2;
    EXPECT_NE(refusal(bent).find("the card is not flat, or not a print of ours: its tags are"),
              std::string::npos);
    bent.bend = 0.4;
    const Calibration found = CalibrateCard(bent, {}, poses);
    ASSERT_EQ(found.warnings.size(), 1u);
    EXPECT_NE(found.warnings[0].find("the card is not quite flat"), std::string::npos) << found.warnings[0];
    PhotographedCard stretched;
    stretched.aspect = 1.06;
    EXPECT_NE(refusal(stretched).find("or not a print of ours"), std::string::npos);
}

}  // namespace
}  // namespace lacquer::capture::calibration_test
