// The auxiliary output "motion": displacements on the image that are known in closed form.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"
#include "pbrt/integrators/rendered_image.h"

namespace lacquer::motion_test {
namespace {

constexpr int kSide = 16;
/// Pixels of a unit of the screen, which reaches from -1 to 1.
constexpr double kScale = kSide / 2.;
constexpr double kDegree = double(Pi) / 180;

struct Settings {
    std::string camera = R"(Camera "perspective" "float fov" 90)";
    std::string integrator = "path";
    int samples = 1;
    /// False: at the middle of pixels and of the shutter.
    bool isJittered = false;
};

std::unique_ptr<Image> Rendered(const std::string& world, const Settings& settings = {}) {
    const RenderSetup setup = test::BuildText(fmt::format(
        R"({1} Film "rgb" "integer xresolution" {0} "integer yresolution" {0} PixelFilter "box"
           Sampler "independent" "integer pixelsamples" {2} Integrator "{3}"
           WorldBegin {4})",
        kSide, settings.camera, settings.samples, settings.integrator, world));
    const auto aovs = MakeAovBuffer({"motion", "alpha"}, 6, setup);
    RenderOptions options;
    options.aovs = aovs.get();
    options.jitter.pixels = settings.isJittered;
    test::RenderAll(setup, options);
    return aovs->AppendTo(*setup.film->Develop());
}

struct Displacement {
    double x, y;
};
Displacement At(const Image& image, Int2 pixel) {
    return {double(image.Get(pixel, image.FindChannel("motion.X"))),
            double(image.Get(pixel, image.FindChannel("motion.Y")))};
}
/// Middle of a pixel on the screen, y up.
Displacement ScreenOf(Int2 pixel) { return {(pixel.x + 0.5) / kScale - 1, 1 - (pixel.y + 0.5) / kScale}; }

/// Largest difference from what is expected, over all pixels. @param expected  of the pixel's place on the
/// screen
template <class Expected>
double LargestError(const Image& image, const Expected& expected) {
    double largest = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const Displacement is = At(image, {x, y}), should = expected(ScreenOf({x, y}));
            largest = std::max({largest, std::abs(is.x - should.x), std::abs(is.y - should.y)});
        }
    return largest;
}
/// Raster positions are floats of up to 16: some tens of roundings of 2^-20 pixels.
constexpr double kRounding = 1e-4;

const std::string kSky = R"(LightSource "infinite" )";
/// Wider than the view, facing it. @param motion  from when the shutter opens to when it closes
std::string Wall(const std::string& motion, const std::string& place = "Translate 0 0 4") {
    return fmt::format(R"({} AttributeBegin ActiveTransform EndTime {} ActiveTransform All {}
                          Shape "disk" "float radius" 50 AttributeEnd )",
                       kSky, motion, place);
}
std::string MovingCamera(const std::string& motion,
                         const std::string& camera = R"("perspective" "float fov" 90)") {
    return fmt::format("ActiveTransform EndTime {} ActiveTransform All Camera {}", motion, camera);
}
constexpr const char* kOrthographic = R"("orthographic" "float screenwindow" [-1 1 -1 1])";

TEST(Motion, OfWhatIsAtRestIsZero) {
    for (const std::string& world :
         {kSky, Wall(""),
          kSky + R"(ObjectBegin "a" Shape "disk" ObjectEnd Translate 0 0 3 ObjectInstance "a")"})
        EXPECT_EQ(LargestError(*Rendered(world), [](auto) { return Displacement{0, 0}; }), 0) << world;
}

/// The camera goes to the right and up, so the world goes to the left and down, by a quarter of it at
/// depth 4.
TEST(Motion, OfAPerspectiveCameraThatMoves) {
    const auto image = Rendered(Wall(""), {.camera = MovingCamera("Translate -.5 -.25 0")});
    const auto expected = [](auto) { return Displacement{-kScale * .5 / 4, -kScale * .25 / 4}; };
    EXPECT_LT(LargestError(*image, expected), kRounding);
}

TEST(Motion, OfAnOrthographicCameraThatMoves) {
    const auto image = Rendered(Wall(""), {.camera = MovingCamera("Translate -.5 -.25 0", kOrthographic)});
    EXPECT_LT(LargestError(*image,
                           [](auto) {
                               return Displacement{-kScale * .5, -kScale * .25};
                           }),
              kRounding);
}

TEST(Motion, OfAnObjectThatMoves) {
    const std::string wall = Wall("Translate 1 -.5 0");
    EXPECT_LT(LargestError(*Rendered(wall),
                           [](auto) {
                               return Displacement{kScale / 4, -kScale / 8};
                           }),
              kRounding);
    const Settings orthographic{.camera = std::string("Camera ") + kOrthographic};
    const auto parallel = [](auto) { return Displacement{kScale, -kScale / 2}; };
    EXPECT_LT(LargestError(*Rendered(wall, orthographic), parallel), kRounding);
    // Along the axis of a parallel projection nothing is seen to move.
    EXPECT_LT(LargestError(*Rendered(Wall("Translate 0 0 1"), orthographic),
                           [](auto) {
                               return Displacement{0, 0};
                           }),
              kRounding);
}

/// From depth 4 to depth 2: what is seen at depth 3 at s was at 3 s / 4 and will be at 3 s / 2.
TEST(Motion, OfAnObjectThatComesNearer) {
    const auto expected = [](Displacement s) { return Displacement{kScale * .75 * s.x, kScale * .75 * s.y}; };
    EXPECT_LT(LargestError(*Rendered(Wall("Translate 0 0 -2")), expected), kRounding);
}

/// By 90 degrees about the middle of the image, counterclockwise: from 45 degrees before to 45 after.
TEST(Motion, OfAnObjectThatTurns) {
    const double root = std::sqrt(2.);
    const auto expected = [&](Displacement s) {
        return Displacement{-kScale * root * s.y, kScale * root * s.x};
    };
    for (const std::string& camera : {std::string("Camera ") + kOrthographic, Settings().camera})
        EXPECT_LT(LargestError(*Rendered(Wall("Rotate 90 0 0 1"), {.camera = camera}), expected), kRounding)
            << camera;
}

/// A camera that turns by 20 degrees about its y axis. A direction at tan(a) on the screen was 10 degrees
/// before that and will be 10 after it, and its height goes with the depth.
Displacement OfAPan(Displacement s) {
    const auto at = [&](double degrees) {
        const double turned = std::atan(s.x) + degrees * kDegree, length = std::sqrt(1 + s.x * s.x);
        return Displacement{std::tan(turned), s.y / (length * std::cos(turned))};
    };
    const Displacement first = at(-10), last = at(10);
    return {kScale * (last.x - first.x), kScale * (last.y - first.y)};
}
TEST(Motion, OfTheSkyFollowsTheCamera) {
    const auto turning = Rendered(kSky, {.camera = MovingCamera("Rotate 20 0 1 0")});
    EXPECT_LT(LargestError(*turning, OfAPan), kRounding);
    EXPECT_GT(std::abs(At(*turning, {0, 0}).y), 0.1);
    const auto nowhere = [](auto) { return Displacement{0, 0}; };
    EXPECT_LT(LargestError(*Rendered(kSky, {.camera = MovingCamera("Translate 3 2 1")}), nowhere), kRounding);
    EXPECT_EQ(
        LargestError(*Rendered(kSky, {.camera = MovingCamera("Rotate 20 0 1 0", kOrthographic)}), nowhere),
        0);
}
/// So does a wall, about the same centre.
TEST(Motion, OfAWallUnderAPanIsThatOfTheSky) {
    EXPECT_LT(LargestError(*Rendered(Wall(""), {.camera = MovingCamera("Rotate 20 0 1 0")}), OfAPan),
              kRounding);
}

/// What goes along with the camera stays where it is, though each of them moves: both count.
TEST(Motion, OfCameraAndObjectTogether) {
    const std::string camera = MovingCamera("Translate -1 0 0"), wall = Wall("Translate 1 0 0");
    EXPECT_LT(LargestError(*Rendered(wall, {.camera = camera}),
                           [](auto) {
                               return Displacement{0, 0};
                           }),
              kRounding);
    // The control: without either of them it does not.
    EXPECT_GT(At(*Rendered(wall), {3, 3}).x, 1);
    EXPECT_LT(At(*Rendered(Wall(""), {.camera = camera}), {3, 3}).x, -1);
}

TEST(Motion, LastsAsLongAsTheShutterIsOpen) {
    const auto image = Rendered(
        Wall("Translate 1 0 0"),
        {.camera = R"(Camera "perspective" "float fov" 90 "float shutteropen" .25 "float shutterclose" .5)"});
    EXPECT_LT(LargestError(*image, [](auto) { return Displacement{kScale / 16, 0}; }), kRounding);
    // What moves before the shutter opens does not count.
    const auto later = Rendered(
        Wall("Translate 1 0 0"),
        {.camera = R"(Camera "perspective" "float fov" 90 "float shutteropen" 2 "float shutterclose" 3)"});
    EXPECT_LT(LargestError(*later, [](auto) { return Displacement{0, 0}; }), kRounding);
}

/// Over hits alone: where a card that moves covers a part of a pixel before a sky that does not, the pixel
/// has the motion of the card. Where the camera turns, empty pixels have that of the sky.
TEST(Motion, IsTheMeanOverHits) {
    const std::string card =
        kSky + R"(AttributeBegin ActiveTransform EndTime Translate .3 0 0 ActiveTransform All
        Shape "bilinearmesh" "point3 P" [-4 -4 4  .1 -4 4  -4 4 4  .1 4 4] AttributeEnd)";
    const auto image = Rendered(card, {.samples = 64, .isJittered = true});
    const int alpha = image->FindChannel("A");
    int numEdges = 0;
    for (int x = 0; x < kSide; ++x) {
        const float covered = image->Get({x, 8}, alpha);
        numEdges += covered > 0 && covered < 1;
        EXPECT_NEAR(At(*image, {x, 8}).x, covered > 0 ? kScale * .3 / 4 : 0, kRounding) << x;
    }
    EXPECT_GT(numEdges, 0);
}

/// Means over time and place: those of the middle where the displacement is linear in each of them. It is
/// 2 s z / 3 ... for a wall from depth 4 to 2: s z / 4 with s and z independent, whose deviations are those
/// of uniform numbers over a pixel and over two units of depth. 4 standard errors.
TEST(Motion, IsTheMeanOverTheShutter) {
    constexpr int kSamples = 400;
    const auto image = Rendered(Wall("Translate 0 0 -2"), {.samples = kSamples, .isJittered = true});
    const double deviation = kScale / 4 * std::sqrt((1 / 12. / (kScale * kScale)) * (9 + 4 / 12.) + 4 / 12.);
    const auto expected = [](Displacement s) { return Displacement{kScale * .75 * s.x, kScale * .75 * s.y}; };
    EXPECT_LT(LargestError(*image, expected), 4.5 * deviation / std::sqrt(double(kSamples)));
}

/// The first hit of the camera ray, whoever follows it; a smooth wall is one, too.
TEST(Motion, IsTheSameOfEveryIntegrator) {
    const std::string wall = R"(LightSource "point" "point3 from" [0 0 1] Material "diffuse" )" +
                             Wall("Rotate 30 0 1 1 Translate 1 0 0");
    const auto reference = Rendered(wall, {.camera = MovingCamera("Translate -.5 0 0")});
    EXPECT_GT(std::abs(At(*reference, {3, 3}).x), 1);
    for (const char* integrator :
         {"volpath", "simplepath", "randomwalk", "ambientocclusion", "bdpt", "lightpath", "mlt", "sppm"}) {
        const auto image =
            Rendered(wall, {.camera = MovingCamera("Translate -.5 0 0"), .integrator = integrator});
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const Displacement a = At(*image, {x, y}), b = At(*reference, {x, y});
                ASSERT_TRUE(a.x == b.x && a.y == b.y) << integrator << ' ' << x << ' ' << y;
            }
    }
}

TEST(Motion, NeedsACameraThatProjects) {
    const RenderSetup setup = test::BuildText(R"(Camera "spherical" WorldBegin LightSource "infinite")");
    EXPECT_THROW(CheckAovs({"motion"}, setup), OverrideError);
    EXPECT_NO_THROW(CheckAovs({"depth", "half"}, setup));
}

}  // namespace
}  // namespace lacquer::motion_test
