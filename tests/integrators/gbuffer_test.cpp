// The film gbuffer, rendered: what its channels hold for scenes whose geometry is known.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"

namespace lacquer::gbuffer_test {
namespace {

/// A slope z = 4 + x from an orthographic camera that is turned by a right angle about y, at (1, 2, 3).
std::string Slope(const std::string& film, const std::string& integrator = "path", int samples = 4) {
    return "Film \"gbuffer\" \"integer xresolution\" 10 \"integer yresolution\" 10 " + film +
           "Sampler \"independent\" \"integer pixelsamples\" " + std::to_string(samples) + " Integrator \"" +
           integrator +
           "\""
           " PixelFilter \"box\" LookAt 1 2 3  2 2 3  0 1 0 Camera \"orthographic\" \"float screenwindow\" "
           "[-1 1 -1 1] "
           "WorldBegin "
           "CoordSysTransform \"camera\" LightSource \"infinite\" "
           "Material \"diffuse\" \"rgb reflectance\" [.25 .25 .25] "
           "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
           "\"point3 P\" [-.8 -.8 3.2  .8 -.8 4.8  .8 .8 4.8  -.8 .8 3.2]";
}

/// The mean of a pixel's channels, by name.
float At(const Image& image, const std::string& channel, Int2 pixel = {3, 4}) {
    return image.Get(pixel, image.FindChannel(channel));
}

TEST(GBufferFilm, HasTheChannelsOfTheFormatInTheirOrder) {
    const std::vector<std::string> expected = {"R",
                                               "G",
                                               "B",
                                               "Albedo.R",
                                               "Albedo.G",
                                               "Albedo.B",
                                               "P.X",
                                               "P.Y",
                                               "P.Z",
                                               "dzdx",
                                               "dzdy",
                                               "N.X",
                                               "N.Y",
                                               "N.Z",
                                               "Ns.X",
                                               "Ns.Y",
                                               "Ns.Z",
                                               "u",
                                               "v",
                                               "Variance.R",
                                               "Variance.G",
                                               "Variance.B",
                                               "RelativeVariance.R",
                                               "RelativeVariance.G",
                                               "RelativeVariance.B"};
    EXPECT_EQ(test::RenderText(Slope(""))->Channels(), expected);
}

TEST(GBufferFilm, DescribesTheFirstHitInCameraSpace) {
    const auto image = test::RenderText(Slope("", "path", 64));
    const float d = std::sqrt(0.5f);
    // The pixel (3, 4) is at x = -0.3, y = 0.1, and 0.2 wide; its samples are 0.06 from that in the mean of
    // any coordinate: a third of the width, over 8 for 64 samples, 6 times.
    for (const auto& [channel, value, tolerance] : {std::tuple("P.X", -0.3f, 0.06f),
                                                    {"P.Y", 0.1f, 0.06f},
                                                    {"P.Z", 3.7f, 0.06f},
                                                    {"dzdx", 0.2f, 1e-4f},
                                                    {"dzdy", 0.f, 1e-4f},
                                                    {"N.X", d, 1e-5f},
                                                    {"N.Y", 0.f, 1e-5f},
                                                    {"N.Z", -d, 1e-5f},
                                                    {"Ns.X", d, 1e-5f},
                                                    {"Ns.Z", -d, 1e-5f},
                                                    {"Albedo.R", 0.25f, 1e-4f},
                                                    {"Albedo.B", 0.25f, 1e-4f}})
        EXPECT_NEAR(At(*image, channel), value, tolerance) << channel;
    EXPECT_FLOAT_EQ(At(*image, "P.Z"), 4 + At(*image, "P.X"));
    // Nothing is seen beside the slope.
    for (const std::string& channel : image->Channels()) {
        const bool isColor = channel == "R" || channel == "G" || channel == "B";
        EXPECT_TRUE(isColor || At(*image, channel, {0, 0}) == 0) << channel;
    }
}

TEST(GBufferFilm, DescribesItInTheWorldIfAsked) {
    const auto image = test::RenderText(Slope("\"string coordinatesystem\" \"world\" ", "path", 64));
    const float d = std::sqrt(0.5f);
    // Camera (x, y, z) is world (1, 2, 3) + (z, y, -x).
    EXPECT_NEAR(At(*image, "P.X"), 1 + 3.7f, 0.06f);
    EXPECT_NEAR(At(*image, "P.Y"), 2 + 0.1f, 0.06f);
    EXPECT_NEAR(At(*image, "P.Z"), 3 + 0.3f, 0.06f);
    EXPECT_NEAR(At(*image, "N.X"), -d, 1e-5f);
    EXPECT_NEAR(At(*image, "N.Z"), -d, 1e-5f);
    EXPECT_NEAR(At(*image, "dzdx"), 0.2f, 1e-4f);
}

/// The relative variance is the variance over the squared mean of the sensor's triple, which the colours
/// tell where the whole pixel is covered.
TEST(GBufferFilm, VariancesAreThoseOfTheSensor) {
    const auto image = test::RenderText(Slope("", "path", 256));
    const XYZ mean = ColorSpace::SRGB().ToXYZ({At(*image, "R"), At(*image, "G"), At(*image, "B")});
    const char* const names[] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        const float variance = At(*image, std::string("Variance.") + names[c]);
        EXPECT_GT(variance, 0);
        EXPECT_NEAR(At(*image, std::string("RelativeVariance.") + names[c]) * mean[c] * mean[c] / variance, 1,
                    1e-4f);
    }
}

/// Integrators that look at first hits supply the same geometry.
TEST(GBufferFilm, DoesNotDependOnTheIntegrator) {
    const auto path = test::RenderText(Slope("")), simple = test::RenderText(Slope("", "simplepath"));
    for (const char* channel : {"Albedo.R", "P.X", "N.Z", "Ns.X", "dzdx", "u"})
        EXPECT_NEAR(At(*path, channel), At(*simple, channel), 1e-6f) << channel;
}

}  // namespace
}  // namespace lacquer::gbuffer_test
