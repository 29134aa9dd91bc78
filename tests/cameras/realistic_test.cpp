// The camera "realistic": exposure, orientation, apertures, parameters.
#include <gtest/gtest.h>

#include <fstream>

#include "pbrt/base/camera.h"
#include "pbrt/cameras/realistic_aperture.h"
#include "pbrt/core/rng.h"
#include "support/scene_parts.h"
#include "support/statistics.h"

namespace lacquer::realistic_test {
namespace {

using test::FullTestName;
using test::SeedOf;

/// A lens file that vanishes with the object.
class LensFile {
  public:
    explicit LensFile(const std::string& content)
        : path_(testing::TempDir() + "/lacquer-" + std::to_string(SeedOf(FullTestName() + content)) +
                ".dat") {
        std::ofstream(path_) << content;
    }
    ~LensFile() { std::remove(path_.c_str()); }
    LensFile(const LensFile&) = delete;
    LensFile& operator=(const LensFile&) = delete;
    const std::string& Path() const { return path_; }

  private:
    std::string path_;
};

// A wide thin lens of focal length 100 mm and a stop next to the film: the stop is its own exit pupil.
const std::string kStopBehind = "100 0.01 1.5 90\n-100 1 0 90\n0 100 0 30\n";
constexpr Int2 kResolution(300, 200);

std::unique_ptr<Camera> MakeCamera(const LensFile& file, const std::string& text, float diagonal = 43.2666f,
                                   Observer* observer = nullptr) {
    const Params params =
        test::ParamsFromText("camera", "\"string lensfile\" \"" + file.Path() + "\" " + text);
    auto camera = Registry<CameraKind>::Find("realistic")(
        {params, AnimatedTransform(), kResolution, diagonal, observer});
    params.CheckAllUsed();
    return camera;
}

/// Mean weight at a film position over a grid of lens samples.
double Exposure(const Camera& camera, Point2 film, int side = 300) {
    double sum = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const Point2 u((float(x) + 0.5f) / float(side), (float(y) + 0.5f) / float(side));
            if (const auto ray = camera.GenerateRay({film, u, 0})) sum += double(ray->weight);
        }
    return sum / (double(side) * side);
}

/// Irradiance from a disk of radiance 1 and radius `a` in a parallel plane at distance z, at r from its axis.
double DiskIrradiance(double a, double z, double r) {
    const double s = z * z + r * r;
    return double(Pi) / 2 * (1 - (s - a * a) / std::sqrt((s + a * a) * (s + a * a) - 4 * r * r * a * a));
}

TEST(RealisticCamera, ExposureIsTheIrradianceFromTheExitPupil) {
    const LensFile file(kStopBehind);
    for (const float diameter : {30.f, 10.f}) {
        const auto camera = MakeCamera(
            file, "\"float focusdistance\" 2 \"float aperturediameter\" " + std::to_string(diameter));
        // Principal planes lie at the thin lens, 1 mm before the stop: z + 1 is the image distance to 0.01
        // mm.
        const double f = 100, d = 2000, z = d / 2 - std::sqrt(d * d / 4 - f * d) - 1;
        for (const float x : {150.f, 225.f, 300.f}) {
            const double r = double(x - 150) * 36 / 300;
            const double expected = DiskIrradiance(double(diameter) / 2, z, r);
            // A grid of 300 x 300 knows the area of a disk to about 2e-3 at worst.
            EXPECT_NEAR(Exposure(*camera, {x, 100}) / expected, 1, 3e-3) << diameter << " " << x;
        }
        // Away from the x axis as on it.
        const double r = std::hypot(12., 12.);
        EXPECT_NEAR(Exposure(*camera, {50, 200}) / DiskIrradiance(double(diameter) / 2, z, r), 1, 3e-3);
    }
}

TEST(RealisticCamera, AllAperturesExposeAlikeOnTheAxis) {
    const LensFile file(kStopBehind);
    const std::string open = "\"float focusdistance\" 50 \"float aperturediameter\" 4 ";
    const auto roundStop = MakeCamera(file, open);
    const double round = Exposure(*roundStop, {150, 100}), roundSide = Exposure(*roundStop, {250, 150});
    for (const std::string& name : ApertureMask::Names()) {
        const auto camera = MakeCamera(file, open + "\"string aperture\" \"" + name + "\"");
        // Over 4 mm at 100 mm the cosines differ by 1e-3; edges of masks are resolved to half a per cent.
        EXPECT_NEAR(Exposure(*camera, {150, 100}) / round, 1, 6e-3) << name;
        // Nor are their corners cut at other azimuths of the film.
        const double side = Exposure(*camera, {250, 150});
        EXPECT_NEAR(side / roundSide, 1, 1e-2) << name;
    }
}

TEST(RealisticCamera, TheUpperLeftOfTheImageIsUpAndLeftInTheScene) {
    const LensFile file(kStopBehind);
    const auto camera = MakeCamera(file, "\"float focusdistance\" 20 \"float aperturediameter\" 2");
    const auto ray = camera->GenerateRay({{0, 0}, {0.5f, 0.5f}, 0}).value();
    // 18 mm to the side and 12 mm up at an image distance of 100.5 mm; the lens sits that far before the
    // film.
    EXPECT_NEAR(ray.ray.d.x / ray.ray.d.z, -18 / 100.5f, 4e-3f);
    EXPECT_NEAR(ray.ray.d.y / ray.ray.d.z, 12 / 100.5f, 3e-3f);
    EXPECT_NEAR(ray.ray.o.z, 0.1005f, 1e-3f);
    EXPECT_NEAR(Length(ray.ray.d), 1, 1e-6f);
    // Half the film, half the field of view.
    const auto small = MakeCamera(file, "\"float focusdistance\" 20 \"float aperturediameter\" 2", 21.6333f);
    const auto narrow = small->GenerateRay({{0, 0}, {0.5f, 0.5f}, 0}).value();
    EXPECT_NEAR(narrow.ray.d.x / narrow.ray.d.z, -9 / 100.5f, 2e-3f);
}

TEST(RealisticCamera, RaysMeetInThePlaneOfFocusAndNeighboursOnePixelFurther) {
    const LensFile file(kStopBehind);
    const auto camera = MakeCamera(file, "\"float focusdistance\" 3 \"float aperturediameter\" 4");
    const float image = 1.5f - std::sqrt(Sqr(1.5f) - 0.1f * 3);  // [m], thin lens
    const float pixel = 0.036f / 300 * (3 - image) / image;
    const auto atFocus = [](Point3 o, Vec3 d) { return o + (3 - o.z) / d.z * d; };
    Rng rng(SeedOf(FullTestName()));
    for (const Point2 film : {Point2(150, 100), Point2(120, 90), Point2(190, 130)}) {
        const Point2 expected = pixel * Point2(film.x - 150, 100 - film.y);
        int passed = 0;
        for (int i = 0; i < 200; ++i) {
            const auto ray = camera->GenerateRay({film, rng.Uniform2D(), 0});
            if (!ray) continue;
            ++passed;
            const Point3 p = atFocus(ray->ray.o, ray->ray.d);
            // A simple lens at f/25 blurs by field curvature and coma; a fifth of a pixel.
            EXPECT_NEAR(p.x, expected.x, 0.2f * pixel + 0.01f * std::abs(expected.x));
            EXPECT_NEAR(p.y, expected.y, 0.2f * pixel + 0.01f * std::abs(expected.y));
            const Vec3 right = atFocus(ray->rxOrigin, ray->rxDirection) - p,
                       down = atFocus(ray->ryOrigin, ray->ryDirection) - p;
            // Differences of floats: 2^-24 of 3 m, a few times, of 3 mm.
            EXPECT_NEAR(right.x, pixel, 0.03f * pixel);
            EXPECT_NEAR(right.y, 0, 0.03f * pixel);
            EXPECT_NEAR(down.y, -pixel, 0.03f * pixel);
            EXPECT_NEAR(down.x, 0, 0.03f * pixel);
        }
        EXPECT_GT(passed, 100);
    }
}

TEST(ApertureMask, TheUpperEdgeOfAnImageIsUp) {
    Image image({8, 8}, {"R", "G", "B", "A"});
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 8; ++x)
            for (int c = 0; c < 3; ++c) image.Set({x, y}, c, float(c + 1));
    const ApertureMask mask(image);
    EXPECT_NEAR(mask.At({0, 0.5f}), 2 * PiOver4, 1e-6f);
    EXPECT_EQ(mask.At({0, -0.5f}), 0);
    EXPECT_EQ(mask.At({0, 1.2f}), 0);
    EXPECT_NEAR(mask.Extent(), std::sqrt(2.f), 1e-6f);
    EXPECT_THROW(ApertureMask(Image({4, 4}, {"Y"})), std::invalid_argument);
}

TEST(ApertureMask, ShapesHaveTheirCornersAndTheMeanOfADisk) {
    for (const std::string& name : ApertureMask::Names()) {
        const ApertureMask mask = ApertureMask::Named(name).value();
        double sum = 0;
        constexpr int kSide = 512;
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                sum += double(
                    mask.At({(float(x) + 0.5f) / (kSide / 2) - 1, (float(y) + 0.5f) / (kSide / 2) - 1}));
        // Bilinear weights keep the sum but for the outermost pixels.
        EXPECT_NEAR(sum / (kSide * kSide), double(PiOver4), 3e-3) << name;
        EXPECT_GT(mask.At({0, 0}), 0) << name;
    }
    const auto at = [](const char* name, Point2 p) { return ApertureMask::Named(name)->At(p) > 0; };
    EXPECT_TRUE(at("square", {0.48f, 0.48f}));
    EXPECT_FALSE(at("square", {0.52f, 0}));
    EXPECT_TRUE(at("pentagon", {0, -0.78f}));
    EXPECT_FALSE(at("pentagon", {0, 0.7f}));
    EXPECT_TRUE(at("star", {-0.95f, 0}));
    EXPECT_FALSE(at("star", {0.5f, 0}));
    EXPECT_TRUE(at("gaussian", {0.9f, 0}));
    EXPECT_FALSE(at("gaussian", {0.8f, 0.8f}));
    EXPECT_FALSE(ApertureMask::Named("hexagon").has_value());
}

std::string ErrorOf(const LensFile& file, const std::string& text) {
    try {
        MakeCamera(file, text);
    } catch (const std::exception& e) {
        return e.what();
    }
    return "";
}

TEST(RealisticCamera, MistakesAreExplained) {
    const LensFile file(kStopBehind), diverging("-100 1 1.5 20\n100 50 0 20\n");
    const auto says = [](const std::string& error, const std::string& part) {
        EXPECT_NE(error.find(part), std::string::npos) << error;
    };
    says(ErrorOf(file, "\"float focusdistance\" 0.3"), "this lens of 100 mm focuses from 0.4 m on");
    says(ErrorOf(file, "\"float focusdistance\" 0"), "focusdistance is 0 m; it must be positive");
    says(ErrorOf(file, "\"float aperturediameter\" -1"), "aperturediameter is -1 mm; it must be positive");
    says(ErrorOf(file, "\"string aperture\" \"pentagram\""), "did you mean \"pentagon\"?");
    says(ErrorOf(diverging, ""), "the lens makes no image");
    test::WarningList warnings;
    MakeCamera(file, "\"float aperturediameter\" 31", 35, &warnings);
    says(warnings.text, "aperturediameter is 31 mm, but the stop of the lens opens to 30 mm only");
}

}  // namespace
}  // namespace lacquer::realistic_test
