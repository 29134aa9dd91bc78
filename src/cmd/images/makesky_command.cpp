// lacquer makesky: the sky as an environment map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "pbrt/core/parallel.h"
#include "pbrt/scattering/clear_sky.h"
#include "pbrt/scattering/sun_position.h"

namespace lacquer::cmd {
namespace {

struct MakeSkyArguments {
    std::string outfile, time, colorSpace = "aces2065-1";
    double elevation = 10, azimuth = 0, turbidity = 3, albedo = 0.5, ozone = 300;
    std::optional<double> latitude, longitude;
    int resolution = 2048;
    bool sun = false, ground = false, quiet = false;
};

void AddMakeSkyOptions(CLI::App& app, MakeSkyArguments& a) {
    AddOutfile(app, a.outfile);
    auto* elevation = app.add_option("--elevation", a.elevation, "Of the sun over the horizon [degrees]")
                          ->check(CLI::Range(-18., 90.))
                          ->capture_default_str();
    auto* azimuth =
        app.add_option("--azimuth", a.azimuth, "Of the sun, clockwise from north, which is +y [degrees]")
            ->check(CLI::Range(-360., 360.))
            ->capture_default_str();
    auto* time = app.add_option("--time", a.time, "Instead of these: \"2026-06-21 15:30 +02:00\", with")
                     ->excludes(elevation)
                     ->excludes(azimuth);
    app.add_option("--latitude", a.latitude, "[degrees], north is positive")
        ->check(CLI::Range(-90., 90.))
        ->needs(time);
    app.add_option("--longitude", a.longitude, "[degrees], east is positive")
        ->check(CLI::Range(-180., 180.))
        ->needs(time);
    app.add_option("--turbidity", a.turbidity, "1 is air without aerosol, 3 clear, 6 hazy")
        ->check(CLI::Range(1., 30.))
        ->capture_default_str();
    app.add_option("--albedo", a.albedo, "Of the ground")->check(CLI::Range(0., 1.))->capture_default_str();
    app.add_option("--ozone", a.ozone, "Of the column [Dobson units]")
        ->check(CLI::Range(0., 1000.))
        ->capture_default_str();
    app.add_option("--resolution", a.resolution, "Pixels a side")
        ->check(CLI::Range(1, 8192))
        ->capture_default_str();
    app.add_flag("--sun", a.sun, "With the disk of the sun");
    app.add_flag("--ground", a.ground, "With the ground below the horizon, which is black else");
    app.add_option("--colorspace", a.colorSpace, "Primaries of the image")
        ->check(OneOf(ColorSpace::Names()))
        ->capture_default_str();
    app.add_flag("--quiet", a.quiet, "No information");
}

/// Elevation and azimuth [degrees].
SunPosition SunOf(const MakeSkyArguments& a) {
    if (a.time.empty()) return {a.elevation, a.azimuth};
    const std::optional<Instant> instant = ParseInstant(a.time);
    if (!instant) BadOption("time", a.time, "a time like \"2026-06-21 15:30 +02:00\"");
    if (!a.latitude || !a.longitude) throw CLI::ValidationError("--time needs --latitude and --longitude");
    const SunPosition sun = SunPositionAt(*instant, *a.latitude, *a.longitude);
    if (sun.elevation < double(kLowestSun))
        throw CLI::ValidationError(
            fmt::format("--time {}: the sun is {:.1f} degrees below the horizon, and it is night", a.time,
                        -sun.elevation));
    return sun;
}

/// Points a side of a pixel, so that they are `distance` [radians] apart or nearer.
int PointsAlongPixel(int resolution, double distance) {
    constexpr int kMax = 4096;
    const double pixel = std::sqrt(4 * double(Pi)) / resolution;
    return std::clamp(int(std::ceil(pixel / distance)), 1, kMax);
}

/// Mean of n x n points of a pixel. The sun and the horizon may be smaller than it.
XYZ MeanOfPixel(const ClearSky& sky, ClearSky::Part part, Point2 corner, int resolution, int n) {
    XYZ mean(0);
    for (int y = 0; y < n; ++y) {
        XYZ row(0);
        for (int x = 0; x < n; ++x) {
            const Point2 inPixel = (Point2(float(x), float(y)) + 0.5f) / float(n);
            row += sky.ToXYZ(EqualAreaSquareToSphere((corner + inPixel) / float(resolution)), part);
        }
        mean += row / (float(n) * float(n));
    }
    return mean;
}

ExitStatus RunMakeSky(const MakeSkyArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    CheckImageOutput(a.outfile);
    const SunPosition sun = SunOf(a);
    ClearSkySettings settings{.sun = DirectionOfSun(float(sun.elevation), float(sun.azimuth)),
                              .turbidity = float(a.turbidity),
                              .ozone = float(a.ozone)};
    settings.groundAlbedo.fill(float(a.albedo));
    settings.hasSun = a.sun;
    settings.hasGround = a.ground;
    const ClearSky sky(settings);
    const ColorSpace* space = ColorSpace::Find(a.colorSpace);
    Image image(Int2(a.resolution), {"R", "G", "B"});
    image.SetColorSpace(space);
    const double sunRadius = std::sqrt(double(ClearSky::DiskSolidAngle() / Pi));
    const int skyPoints = PointsAlongPixel(a.resolution, 1. / 512),
              sunPoints = std::max(8, PointsAlongPixel(a.resolution, sunRadius / 16));
    ParallelFor(a.resolution, [&](int64_t y) {
        for (int x = 0; x < a.resolution; ++x) {
            const Point2 corner{float(x), float(y)};
            XYZ xyz = MeanOfPixel(sky, ClearSky::Part::Sky, corner, a.resolution, skyPoints);
            const Vec3 middle = EqualAreaSquareToSphere((corner + 0.5f) / float(a.resolution));
            if (sky.IsNearDisk(middle, 8 / float(a.resolution)))
                xyz += MeanOfPixel(sky, ClearSky::Part::Sun, corner, a.resolution, sunPoints);
            const RGB rgb = space->ToRGB(xyz);
            for (int c = 0; c < 3; ++c) image.Set({x, int(y)}, c, std::max(rgb[c], 0.f));
        }
    });
    WriteImage(image, a.outfile);
    console.Info(fmt::format("{}: the sun {:.1f} degrees over the horizon, azimuth {:.1f}", a.outfile,
                             sun.elevation, sun.azimuth));
    return ExitStatus::Complete;
}

constexpr const char* kMakeSkySynopsis =
    "Makes an environment map of a clear sky, for pbrt-v4 or Lacquer. z is up. In Lacquer,\n"
    "LightSource \"infinite\" \"string model\" \"sky\" is such a light, spectral and with a sharp sun; its "
    "defaults are in docs/lights.md.";

}  // namespace

LACQUER_REGISTER(CommandKind, "makesky", (CommandOf<MakeSkyArguments, AddMakeSkyOptions, RunMakeSky>::Make),
                 {.synopsis = kMakeSkySynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
