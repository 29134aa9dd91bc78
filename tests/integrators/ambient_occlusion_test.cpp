// Ambient occlusion where it is known.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"

namespace lacquer::ambient_occlusion_test {
namespace {

using test::BuildText;
using test::CenterRadiance;
using test::FullTestName;
using test::Outcome;
using test::Passes;

std::string Scene(const std::string& parameters, const std::string& world) {
    return "LookAt 0 0 -3  0 0 0  0 1 0 Camera \"perspective\" Film \"rgb\" \"integer xresolution\" 4 "
           "\"integer "
           "yresolution\" 4 Sampler \"independent\" Integrator \"ambientocclusion\" " +
           parameters + " WorldBegin " + world;
}
const std::string kWall = "Shape \"disk\" \"float radius\" 1 ";
/// A wall in a box that is open behind the camera: a hemisphere of occluders at distance 2 but for a cone.
const std::string kBowl =
    kWall +
    "AttributeBegin Rotate 180 1 0 0 Shape \"sphere\" \"float radius\" 2 \"float zmin\" 0 \"float "
    "zmax\" 1.7320508 AttributeEnd ";

TEST(AmbientOcclusion, OpenSurfacesAreWhiteAndNothingIsBlack) {
    for (const std::string how : {"", "\"bool cossample\" false"}) {
        const auto setup = BuildText(Scene(how, kWall));
        EXPECT_TRUE(Passes(FullTestName() + how, 1e-5, [&](uint64_t seed) {
            return ZTest(CenterRadiance(setup, 2000, seed), 1, 1e-5, "an open wall");
        }));
    }
    EXPECT_EQ(CenterRadiance(BuildText(Scene("", "Translate 5 0 0 " + kWall)), 10).Mean(), 0);
}

// Seen from the wall the cone of half angle 30 degrees is open: sin^2(30) = 1/4 of the cosine-weighted sky.
// Power: the standard error is 0.003 by the cosine and 0.004 otherwise; a share of 0.28 is seven of them
// away.
TEST(AmbientOcclusion, FindsTheOpenShareOfTheSky) {
    for (const std::string how : {"", "\"bool cossample\" false"}) {
        const auto setup = BuildText(Scene(how, kBowl));
        const auto check = [&](double expected) {
            return [&setup, expected](uint64_t seed) {
                return ZTest(CenterRadiance(setup, 20000, seed), expected, 1e-5, "a wall in a bowl");
            };
        };
        EXPECT_TRUE(Passes(FullTestName() + how, 1e-5, check(0.25)));
        EXPECT_LT(check(0.28)(1).pValue, 1e-5);
    }
}

TEST(AmbientOcclusion, WhatIsFarAwayDoesNotCount) {
    const auto near = BuildText(Scene("\"float maxdistance\" 1.9", kBowl));
    EXPECT_NEAR(CenterRadiance(near, 200).Mean(), 1, 1e-5);
    const auto far = BuildText(Scene("\"float maxdistance\" 2.1", kBowl));
    EXPECT_LT(CenterRadiance(far, 200).Mean(), 0.5);
    EXPECT_NE(test::BuildErrorsOf(Scene("\"float maxdistance\" 0", kWall)).find("maxdistance is 0"),
              std::string::npos);
}

}  // namespace
}  // namespace lacquer::ambient_occlusion_test
