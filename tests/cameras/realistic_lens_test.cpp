// Lenses of glass: refraction, cardinal points, focus, and the bounds of exit pupils.
#include "pbrt/cameras/realistic_lens.h"

#include <gtest/gtest.h>

#include <fstream>

#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"
#include "support/statistics.h"

namespace lacquer::realistic_lens_test {
namespace {

using test::FullTestName;
using test::SeedOf;

/// Radii +-100 mm, index 1.5, so thin that the focal length is R / (2 (n - 1)) = 100 mm.
const std::vector<LensSurface> kThinLens = {{100, 0.01f, 1.5f, 40}, {-100, 100, 1, 40}};
/// Lee's double Gauss as in scenes/lenses.
const std::vector<LensSurface> kDoubleGauss = {
    {38.3f, 4, 1.61f, 26.5f},        {197.4f, 0.25f, 1, 26},   {20.05f, 7.5f, 1.615f, 25},
    {51.75f, 2.2f, 1.6134f, 21},     {12.85f, 5.5f, 1, 17.6f}, {0, 5.5f, 1, 16.3f},
    {-15.5f, 2.25f, 1.6469f, 17.4f}, {25, 7.85f, 1.6437f, 21}, {-20.75f, 0.25f, 1, 21.6f},
    {70, 4.05f, 1.6234f, 23},        {-50.5f, 33.9f, 1, 23}};

LensRays RaysThrough(Point3 from, Point3 to) {
    LensRays rays{};
    const Vec3 d = Normalize(to - from);
    for (int i = 0; i < LensRays::kCount; ++i) {
        rays.ox[i] = from.x, rays.oy[i] = from.y, rays.oz[i] = from.z;
        rays.dx[i] = d.x, rays.dy[i] = d.y, rays.dz[i] = d.z;
    }
    return rays;
}
/// Where lane 0 meets the plane z.
Point2 AtPlane(const LensRays& rays, float z) {
    const float t = (z - rays.oz[0]) / rays.dz[0];
    return {rays.ox[0] + t * rays.dx[0], rays.oy[0] + t * rays.dy[0]};
}
bool Passes(const LensSystem& lens, LensRays* rays) {
    return lens.Trace(rays, 1, LensSystem::Stops::Block)[0] != 0;
}

TEST(LensSystem, ASphereHasAplanaticPoints) {
    // All rays from the point at R/n from the centre of a ball of index n seem to come from the point at n R,
    // however steep they are [Born and Wolf 1999, sec. 4.2.3].
    const float radius = 10, n = 1.5f;
    const LensSystem lens({{radius, radius + radius / n, n, 2 * radius}}, 1);
    const float source = radius / n - n * radius;
    for (const float slope : {0.f, 0.1f, 0.5f, 1.f, 1.1f}) {
        LensRays rays = RaysThrough({0, 0, 0}, {slope, slope / 2, 1});
        ASSERT_TRUE(Passes(lens, &rays)) << slope;
        const float length = std::sqrt(Sqr(rays.dx[0]) + Sqr(rays.dy[0]) + Sqr(rays.dz[0]));
        EXPECT_NEAR(length, 1, 1e-5f);
        // 20 mm with a few roundings of 2^-24 each.
        EXPECT_NEAR(AtPlane(rays, source).x, 0, 2e-5f) << slope;
        EXPECT_NEAR(AtPlane(rays, source).y, 0, 2e-5f) << slope;
    }
}

TEST(LensSystem, TotalReflectionAndMissedSurfacesStopARay) {
    // Out of glass through a nearly plane surface: the critical angle has the sine 1/1.5, a slope of 0.894.
    const LensSystem plane({{1e5f, 10, 1.5f, 1000}}, 1);
    LensRays below = RaysThrough({0, 0, 0}, {0.88f, 0, 1}), above = RaysThrough({0, 0, 0}, {0.91f, 0, 1});
    EXPECT_TRUE(Passes(plane, &below));
    EXPECT_FALSE(Passes(plane, &above));
    // Outside of the diameter, which this surface reaches 2 mm before the plane of its vertex; beside the
    // sphere.
    const LensSystem lens(kThinLens, 1);
    LensRays inside = RaysThrough({0, 0, 0}, {19.4f, 0, 100}),
             outside = RaysThrough({0, 0, 0}, {19.8f, 0, 100});
    EXPECT_TRUE(Passes(lens, &inside));
    EXPECT_FALSE(Passes(lens, &outside));
    LensRays beside = RaysThrough({0, 0, 0}, {500, 0, 100});
    EXPECT_FALSE(Passes(lens, &beside));
    // Lanes that are not to be blocked go on where there is glass in theory, but not beside the sphere.
    LensRays lanes = RaysThrough({0, 0, 0}, {1, 0, 100});
    const LensRays steep = RaysThrough({0, 0, 0}, {25, 0, 100});
    lanes.dx[1] = steep.dx[0], lanes.dz[1] = steep.dz[0];
    lanes.dx[2] = beside.dx[0], lanes.dz[2] = beside.dz[0];
    const LensRays::Mask alive = lens.Trace(&lanes, 1, LensSystem::Stops::Block);
    EXPECT_TRUE(alive[0]);
    EXPECT_TRUE(alive[1]);
    EXPECT_FALSE(alive[2]);
}

TEST(LensSystem, CardinalPointsOfAThickLensFollowTheLensmakersEquation) {
    // [Born and Wolf 1999, sec. 4.4.3]: 1/f = (n-1) (1/R1 - 1/R2 + (n-1) d / (n R1 R2)), the principal planes
    // at f (n-1) d / (n R2) behind the front and before the rear vertex.
    const float r1 = 50, r2 = -80, d = 12, n = 1.6f, back = 60;
    const CardinalPoints c = LensSystem({{r1, d, n, 20}, {r2, back, 1, 20}}, 1).Cardinals();
    const float f = 1 / ((n - 1) * (1 / r1 - 1 / r2 + (n - 1) * d / (n * r1 * r2)));
    EXPECT_NEAR(c.focalLength, f, 1e-4f * f);
    EXPECT_NEAR(c.frontPrincipal, back + d + f * (n - 1) * d / (n * r2), 1e-3f);
    EXPECT_NEAR(c.rearPrincipal, back + f * (n - 1) * d / (n * r1), 1e-3f);
    // The patent's lens: 0.9994 of the stated 50 mm, which a matrix product by hand gives as well.
    EXPECT_NEAR(LensSystem(kDoubleGauss, 20).Cardinals().focalLength, 49.971f, 0.01f);
}

TEST(LensSystem, AThinLensObeysTheThinLensEquation) {
    for (const float distance : {450.f, 1000.f, 10000.f}) {
        LensSystem lens(kThinLens, 40);
        ASSERT_TRUE(lens.Focus(distance));
        // s + s' = distance, 1/s + 1/s' = 1/f; the lens's own thickness of 0.01 mm is the error.
        const float f = 100, image = distance / 2 - std::sqrt(Sqr(distance / 2) - f * distance);
        EXPECT_NEAR(lens.RearZ(), image, 0.02f) << distance;
        const float magnification = (distance - image) / image;
        for (const float x : {0.f, 1.f, 3.f})
            for (const Point2 pupil :
                 {Point2(0, 0), Point2(0.5f, 0), Point2(0, -0.5f), Point2(-0.5f, 0.5f)}) {
                LensRays rays = RaysThrough({x, 0, 0}, {pupil.x, pupil.y, lens.RearZ()});
                ASSERT_TRUE(Passes(lens, &rays));
                // Aberrations so near to the axis, and 1e-4 of the image distance for its thickness.
                const Point2 p = AtPlane(rays, distance);
                EXPECT_NEAR(p.x, -magnification * x, 0.004f * magnification) << distance;
                EXPECT_NEAR(p.y, 0, 0.004f * magnification) << distance;
            }
    }
}

TEST(LensSystem, DoesNotFocusNearerThanFourFocalLengthsAndNotWithoutConvergence) {
    LensSystem lens(kThinLens, 40);
    EXPECT_NEAR(lens.NearestFocus(), 400, 0.1f);
    const float before = lens.RearZ();
    EXPECT_FALSE(lens.Focus(399));
    EXPECT_EQ(lens.RearZ(), before);
    EXPECT_TRUE(lens.Focus(401));
    LensSystem diverging({{-100, 1, 1.5f, 40}, {100, 100, 1, 40}}, 40);
    EXPECT_LT(diverging.Cardinals().focalLength, 0);
    EXPECT_FALSE(diverging.Focus(1e5f));
}

TEST(LensSystem, TheDoubleGaussIsSharpWhereItIsFocused) {
    // Through all of the pupil at f/4: what is left are aberrations, far below what a misplaced surface
    // leaves.
    LensSystem lens(kDoubleGauss, 8);
    ASSERT_TRUE(lens.Focus(2000));
    const ExitPupils pupils(lens, 20, 1);
    Rng rng(SeedOf(FullTestName()));
    for (const float x : {0.f, 5.f}) {
        test::RunningMean spread;
        double sum = 0;
        for (int i = 0; i < 2000; ++i) {
            const ExitPupils::Box& box = pupils.At(x);
            const Point2 u = rng.Uniform2D(), p = box.min + u * (box.max - box.min);
            LensRays rays = RaysThrough({x, 0, 0}, {p.x, p.y, lens.RearZ()});
            if (!Passes(lens, &rays)) continue;
            spread.Add(double(AtPlane(rays, 2000).x));
            sum += 1;
        }
        ASSERT_GT(sum, 1000);
        // The pupil is 12 mm wide: out of focus by a tenth of a millimetre at the film, the spot would have a
        // standard deviation of 0.25 mm in a plane at 40 times the film's distance.
        EXPECT_LT(std::sqrt(spread.Variance()), 0.5) << x;
    }
}

/// Fraction of the rays through `box` that pass; `numMissed` counts the passing ones outside of the box.
double FractionThrough(const LensSystem& lens, const ExitPupils& pupils, float filmRadius, float shrink,
                       Rng& rng, int* numMissed) {
    int through = 0, inBox = 0;
    // A disk in which everything that meets the surface next to the film lies: half as much again.
    const float reach = 1.5f * lens.RearRadius();
    for (int i = 0; i < 60000; ++i) {
        const float radius = filmRadius * rng.Uniform();
        const Point2 p = reach * SampleUniformDiskConcentric(rng.Uniform2D());
        ExitPupils::Box box = pupils.At(radius);
        const Vec2 cut = shrink / 2 * (box.max - box.min);
        box = {box.min + cut, box.max - cut};
        const bool isIn = p.x >= box.min.x && p.x <= box.max.x && p.y >= box.min.y && p.y <= box.max.y;
        LensRays rays = RaysThrough({radius, 0, 0}, {p.x, p.y, lens.RearZ()});
        const bool passes = Passes(lens, &rays);
        if (passes && !isIn) ++*numMissed;
        through += passes && isIn;
        inBox += isIn;
    }
    return double(through) / std::max(inBox, 1);
}

TEST(ExitPupils, HoldAllRaysThatPassAndLittleElse) {
    Rng rng(SeedOf(FullTestName()));
    for (const float stop : {16.3f, 4.f, 1.f}) {
        LensSystem lens(kDoubleGauss, stop);
        ASSERT_TRUE(lens.Focus(1500));
        const ExitPupils pupils(lens, 21.6f, 1);
        int missed = 0;
        const double fraction = FractionThrough(lens, pupils, 21.6f, 0, rng, &missed);
        EXPECT_EQ(missed, 0) << stop;
        // A disk fills pi/4 of its box; margins, and the lens-shaped pupils near the corners, take some more.
        EXPECT_GT(fraction, 0.55) << stop;
    }
}

TEST(ExitPupils, BoxesThatAreFourPerCentTooSmallAreFound) {
    Rng rng(SeedOf(FullTestName()));
    LensSystem lens(kDoubleGauss, 16.3f);
    ASSERT_TRUE(lens.Focus(1500));
    int missed = 0;
    FractionThrough(lens, ExitPupils(lens, 21.6f, 1), 21.6f, 0.12f, rng, &missed);
    EXPECT_GT(missed, 10);  // margins are 8 % of the width; the cut takes 12 %
}

TEST(ExitPupils, FindAStopAsSmallAsAHair) {
    LensSystem lens(kDoubleGauss, 0.02f);
    ASSERT_TRUE(lens.Focus(1500));
    const ExitPupils pupils(lens, 21.6f, 1);
    Rng rng(SeedOf(FullTestName()));
    for (const float radius : {0.f, 7.f, 15.f}) {
        const ExitPupils::Box& box = pupils.At(radius);
        EXPECT_LT(box.Area(), 0.05f) << radius;
        int through = 0;
        for (int i = 0; i < 500; ++i) {
            const Point2 p = box.min + rng.Uniform2D() * (box.max - box.min);
            LensRays rays = RaysThrough({radius, 0, 0}, {p.x, p.y, lens.RearZ()});
            through += Passes(lens, &rays);
        }
        // The box holds the pupil of a whole ring, and that moves by more than its width.
        EXPECT_GT(through, 10) << radius;
    }
}

/// Reads a lens file with this content; its error if it has one.
std::string ErrorOfFile(const std::string& content) {
    const std::string path = testing::TempDir() + "/lacquer-lens-test.dat";
    std::ofstream(path) << content;
    try {
        ReadLensFile(path, {});
    } catch (const SceneError& e) {
        return std::string(e.what()).substr(path.size());
    }
    return "";
}

TEST(LensFile, MistakesAreNamedWithTheirPlace) {
    EXPECT_EQ(ErrorOfFile("# two\n50 2 1.5 20\n-50 10 0 20\n"), "");
    EXPECT_EQ(ErrorOfFile("50 2 1.5 20 -50 10 0 20"), "");
    EXPECT_EQ(ErrorOfFile("# nothing\n"),
              ": error: the lens file has no surfaces: no rows of radius of curvature, "
              "thickness, index of refraction, diameter");
    const auto says = [](const std::string& content, const std::string& part) {
        const std::string error = ErrorOfFile(content);
        EXPECT_NE(error.find(part), std::string::npos) << error;
    };
    says("50 2 1.5 20\n-50 10 20\n", ":2:1: error: a surface has 3 of its four numbers here (radius");
    says("50 2 1.5 20 7\n", ":1:1: error: a surface has 1 of its four numbers here");
    says("50 2 glass 20\n", ":1:6: error: \"glass\" is not a number");
    says("50 -2 1.5 20\n", ":1:4: error: a thickness of -2 mm");
    says("50 2 0.5 20\n", ":1:6: error: an index of refraction of 0.5");
    says("50 2 1.5 0\n", ":1:10: error: a diameter of 0 mm");
    says("1e9 2 1.5 20\n", ":1:1: error: a radius of curvature of 1000000000 mm");
}

}  // namespace
}  // namespace lacquer::realistic_lens_test
