#include <gtest/gtest.h>

#include "pbrt/base/film.h"
#include "pbrt/film/sensor.h"
#include "pbrt/image/image.h"
#include "support/scene_parts.h"

namespace lacquer::rgb_test {
namespace {

struct FilmSetup {
    std::string text;
    FilmOverrides overrides{};
    float shutterTime = 1;
    std::string space = "srgb";
};
std::unique_ptr<Film> MakeFilm(const FilmSetup& setup) {
    const Params params = test::ParamsFromText("film", setup.text, setup.space);
    auto film = Registry<FilmKind>::Find("rgb")(
        {params, setup.overrides, Registry<FilterKind>::Find("box")(Params()), setup.shutterTime});
    params.CheckAllUsed();
    return film;
}
const std::string kOnePixel = "\"integer xresolution\" 1 \"integer yresolution\" 1 ";
std::string ErrorOf(const FilmSetup& setup) {
    try {
        MakeFilm(setup);
    } catch (const SceneError& e) {
        return e.what();
    } catch (const SceneErrors& e) {
        return e.what();
    }
    return "";
}

/// `count` samples of a spectrum at evenly spread wavelengths: the integral over wavelengths, all but
/// exactly.
void AddSpectrum(Film& film, Int2 pixel, const Spectrum& s, float scale, int count = 2000, float weight = 1) {
    for (int i = 0; i < count; ++i) {
        const SampledWavelengths lambda = film.SampleWavelengths((float(i) + 0.5f) / float(count));
        film.AddSample(pixel, s.Sample(lambda) * scale, lambda, weight);
    }
}
RGB PixelOf(const Film& film, Int2 p = {0, 0}) {
    const auto image = film.Develop();
    return {image->Get(p, 0), image->Get(p, 1), image->Get(p, 2)};
}
// 2000 midpoints of functions that change by a few per cent from one nanometre to the next: 1e-3 is generous.
void ExpectNear(RGB a, RGB b, float tolerance = 1e-3f) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << "component " << c;
}
const DenselySampledSpectrum& White() { return ColorSpace::SRGB().Illuminant(); }

TEST(RGBFilm, HalfFloatsAreSavedOnlyWhereTheSceneAsksForThem) {
    EXPECT_FALSE(MakeFilm({kOnePixel})->SavesHalf());
    EXPECT_TRUE(MakeFilm({kOnePixel + "\"bool savefp16\" true"})->SavesHalf());
}

TEST(RGBFilm, TheWhiteOfItsColorSpaceIsOneOneOne) {
    for (const std::string& name : ColorSpace::Names()) {
        const auto film = MakeFilm({kOnePixel, {}, 1, name});
        EXPECT_EQ(&film->ColorSpace(), ColorSpace::Find(name));
        AddSpectrum(*film, {0, 0}, ColorSpace::Find(name)->Illuminant(), 1 / kCieYIntegral);
        ExpectNear(PixelOf(*film), RGB(1));
    }
}

TEST(RGBFilm, ColorsReturnFromTheirSpectra) {
    for (const RGB rgb : {RGB(0.25f, 0.5f, 2), RGB(0.9f, 0.1f, 0.2f), RGB(10, 7, 8)}) {
        const auto film = MakeFilm({kOnePixel});
        AddSpectrum(*film, {0, 0}, *ColorSpace::SRGB().MakeSpectrum(rgb, SpectrumKind::Illuminant),
                    1 / kCieYIntegral);
        // The RGB table errs by up to 1e-3 of the scale at such colours.
        ExpectNear(PixelOf(*film), rgb, 3e-3f * 2 * MaxComponent(rgb));
    }
}

TEST(RGBFilm, AFlatSpectrumHasTheColorOfTheFormatsCheckValue) {
    const auto film = MakeFilm({kOnePixel});
    AddSpectrum(*film, {0, 0}, ConstantSpectrum(5), 1 / (5 * kCieYIntegral));
    ExpectNear(PixelOf(*film), {1.2048f, 0.9483f, 0.9088f}, 2e-3f);
}

TEST(RGBFilm, SamplesAreAveragedByWeight) {
    const auto film = MakeFilm({kOnePixel});
    AddSpectrum(*film, {0, 0}, White(), 4 / kCieYIntegral, 2000, 3);
    AddSpectrum(*film, {0, 0}, White(), 8 / kCieYIntegral, 2000, 1);
    ExpectNear(PixelOf(*film), RGB(5), 5e-3f);
}

TEST(RGBFilm, NegativeWeightsSubtract) {
    const auto film = MakeFilm({kOnePixel});
    AddSpectrum(*film, {0, 0}, White(), 4 / kCieYIntegral, 2000, 1.5f);
    AddSpectrum(*film, {0, 0}, White(), 2 / kCieYIntegral, 2000, -0.5f);
    ExpectNear(PixelOf(*film), RGB(1.5f * 4 - 0.5f * 2), 6e-3f);
}

TEST(RGBFilm, PixelsWithoutSamplesAreBlack) {
    const auto film = MakeFilm({kOnePixel});
    EXPECT_EQ(PixelOf(*film), RGB(0));
}

TEST(RGBFilm, HalfCoveredPixelsHaveHalfTheRadiance) {
    const auto film = MakeFilm({kOnePixel});
    for (int i = 0; i < 4000; ++i) {
        const SampledWavelengths lambda = film->SampleWavelengths((float(i / 2) + 0.5f) / 2000);
        film->AddSample({0, 0}, i % 2 ? White().Sample(lambda) / kCieYIntegral : SampledSpectrum(0), lambda,
                        1);
    }
    ExpectNear(PixelOf(*film), RGB(0.5f));
}

TEST(RGBFilm, InvalidSamplesAreReportedAndCountAsBlack) {
    for (const float bad : {NAN, Infinity, -Infinity, -1.f})
        for (int lane = 0; lane < kNumWavelengths; ++lane) {
            const auto film = MakeFilm({kOnePixel});
            const SampledWavelengths lambda = film->SampleWavelengths(0.4f);
            const SampledSpectrum good = SampledSpectrum(1);
            SampledSpectrum L = good;
            L.Set(lane, bad);
            EXPECT_TRUE(film->AddSample({0, 0}, good, lambda, 1));
            const RGB alone = PixelOf(*film);
            EXPECT_FALSE(film->AddSample({0, 0}, L, lambda, 1));
            const RGB both = PixelOf(*film);
            for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(both[c], alone[c] / 2);
        }
}

TEST(RGBFilm, ResponsesThatOverflowAreReportedAndCountAsBlack) {
    const auto film = MakeFilm({kOnePixel + "\"float iso\" 1e6"});
    const SampledWavelengths lambda = film->SampleWavelengths(0.5f);
    EXPECT_FALSE(film->AddSample({0, 0}, SampledSpectrum(1e36f), lambda, 1));
    EXPECT_EQ(PixelOf(*film), RGB(0));
    // Just inside of the range, the output matrix may overflow; the pixel is finite all the same.
    EXPECT_TRUE(film->AddSample({0, 0}, SampledSpectrum(1e31f), lambda, 1));
    EXPECT_TRUE(IsFinite(PixelOf(*film)));
}

TEST(RGBFilm, IsoAndShutterScaleTheExposure) {
    const auto film = MakeFilm({kOnePixel + "\"float iso\" 300", {}, 0.5f});
    AddSpectrum(*film, {0, 0}, White(), 1 / kCieYIntegral);
    ExpectNear(PixelOf(*film), RGB(1.5f), 2e-3f);
}

TEST(RGBFilm, MaxComponentValueScalesEachSampleBySensorValues) {
    const auto limited = MakeFilm({kOnePixel + "\"float maxcomponentvalue\" 2"}),
               free = MakeFilm({kOnePixel});
    const Params none = test::ParamsFromText("film", "");
    const Sensor sensor(none, 1, ColorSpace::SRGB());
    Vec3 sum(0);
    constexpr int kSamples = 50;
    for (int i = 0; i < kSamples; ++i) {
        const SampledWavelengths lambda = limited->SampleWavelengths((float(i) + 0.5f) / kSamples);
        const SampledSpectrum L = White().Sample(lambda) * (float(i % 5) / kCieYIntegral);
        limited->AddSample({0, 0}, L, lambda, 1);
        Vec3 xyz = sensor.Response(L, lambda);
        if (MaxComponent(xyz) > 2) xyz = xyz * (2 / MaxComponent(xyz));
        sum += xyz;
    }
    ExpectNear(PixelOf(*limited), sensor.RGBFromSensor() * (sum / float(kSamples)), 1e-5f);
    // One bright sample: the largest of XYZ becomes the limit, the ratios stay.
    const auto film = MakeFilm({kOnePixel + "\"float maxcomponentvalue\" 0.25"});
    const SampledWavelengths lambda = film->SampleWavelengths(0.3f);
    film->AddSample({0, 0}, SampledSpectrum(7), lambda, 1);
    free->AddSample({0, 0}, SampledSpectrum(7), lambda, 1);
    const XYZ clamped = ColorSpace::SRGB().ToXYZ(PixelOf(*film)),
              raw = ColorSpace::SRGB().ToXYZ(PixelOf(*free));
    EXPECT_NEAR(MaxComponent(clamped), 0.25f, 1e-5f);
    ExpectNear(clamped / MaxComponent(clamped), raw / MaxComponent(raw), 1e-5f);
}

TEST(RGBFilm, WhiteBalanceMakesItsDaylightWhite) {
    for (const float kelvin : {3000.f, 5000.f, 9000.f}) {
        const auto film = MakeFilm({kOnePixel + "\"float whitebalance\" " + std::to_string(kelvin)});
        const auto daylight = DaylightSpectrum(kelvin);
        AddSpectrum(*film, {0, 0}, *daylight, 1 / InnerProduct(*daylight, CieY()));
        ExpectNear(PixelOf(*film), RGB(1), 2e-3f);
    }
    // Off by default: daylight of 9000 K is blue.
    const auto film = MakeFilm({kOnePixel});
    const auto daylight = DaylightSpectrum(9000);
    AddSpectrum(*film, {0, 0}, *daylight, 1 / InnerProduct(*daylight, CieY()));
    EXPECT_GT(PixelOf(*film).z, 1.2f);
}

TEST(RGBFilm, ImagesKnowTheirWindow) {
    const auto film = MakeFilm(
        {"\"integer xresolution\" 10 \"integer yresolution\" 20 \"integer pixelbounds\" [2 5 3 99]"});
    EXPECT_EQ(film->PixelBounds(), (Bounds2i{{2, 3}, {5, 20}}));
    film->AddSample({4, 7}, SampledSpectrum(1), film->SampleWavelengths(0.5f), 1);
    const auto image = film->Develop();
    EXPECT_EQ(image->Resolution(), Int2(3, 17));
    EXPECT_EQ(image->dataWindow, film->PixelBounds());
    EXPECT_EQ(image->fullResolution, Int2(10, 20));
    EXPECT_EQ(image->ColorSpace(), &ColorSpace::SRGB());
    EXPECT_NE(image->Get({2, 4}, 1), 0);
    EXPECT_EQ(image->Get({1, 4}, 1), 0);
}

TEST(RGBFilm, CropWindowsAreRoundedUpOnBothEnds) {
    const std::string ten = "\"integer xresolution\" 10 \"integer yresolution\" 10 ";
    const auto bounds = [&](const std::string& text, const FilmOverrides& overrides = {}) {
        return MakeFilm({ten + text, overrides})->PixelBounds();
    };
    EXPECT_EQ(bounds("\"float cropwindow\" [0.25 0.85 0.5 0.51]"), (Bounds2i{{3, 5}, {9, 6}}));
    // Sorted, clamped, and stronger than pixel bounds.
    EXPECT_EQ(bounds("\"float cropwindow\" [0.85 0.25 -3 7] \"integer pixelbounds\" [0 1 0 1]"),
              (Bounds2i{{3, 0}, {9, 10}}));
    FilmOverrides crop;
    crop.cropWindow = {0, 0.5f, 0, 0.3f};
    EXPECT_EQ(bounds("\"float cropwindow\" [0.25 0.85 0.5 0.51]", crop), (Bounds2i{{0, 0}, {5, 3}}));
    FilmOverrides pixels;
    pixels.pixelBounds = Bounds2i{{8, 8}, {100, 9}};
    EXPECT_EQ(bounds("\"float cropwindow\" [0.25 0.85 0.5 0.51]", pixels), (Bounds2i{{8, 8}, {10, 9}}));
    // Adjacent windows share no pixel and leave none out.
    EXPECT_EQ(bounds("\"float cropwindow\" [0 0.33 0 1]").max.x,
              bounds("\"float cropwindow\" [0.33 1 0 1]").min.x);
}

TEST(RGBFilm, OverridesChangeResolutionAndName) {
    EXPECT_EQ(MakeFilm({""})->Resolution(), Int2(1280, 720));
    FilmOverrides quick;
    quick.quick = true;
    EXPECT_EQ(MakeFilm({"\"integer xresolution\" 10 \"integer yresolution\" 3", quick})->Resolution(),
              Int2(2, 1));
    FilmOverrides other;
    other.resolution = Int2(7, 5);
    other.filename = "other.exr";
    const auto film = MakeFilm({"\"string filename\" \"a.exr\"", other});
    EXPECT_EQ(film->Resolution(), Int2(7, 5));
    EXPECT_EQ(film->Filename(), "other.exr");
    EXPECT_EQ(MakeFilm({"\"string filename\" \"a.exr\""})->Filename(), "a.exr");
}

TEST(RGBFilm, MistakesAreSaidWithTheirPlace) {
    struct Case {
        std::string text, part;
    };
    for (const Case& c : {
             Case{"\"integer xresolution\" 0", "xresolution"},
             Case{"\"integer yresolution\" 2000000000", "yresolution"},
             Case{"\"integer xresolution\" 65536 \"integer yresolution\" 65536", "render it in crop windows"},
             Case{"\"float cropwindow\" [0 1]", "cropwindow has 2 values; four are expected: x0 x1 y0 y1"},
             Case{"\"float cropwindow\" [0.5 0.5 0 1]", "leaves no pixel of the 1280 x 720 image to render"},
             Case{"\"integer pixelbounds\" [5 5 0 9]", "leaves no pixel of the 1280 x 720 image to render"},
             Case{"\"integer pixelbounds\" [1 2 3]", "pixelbounds has 3 values"},
             Case{"\"float maxcomponentvalue\" 0", "maxcomponentvalue is 0; it must be positive"},
             Case{"\"float iso\" -1", "iso"},
             Case{"\"float whitebalance\" 30",
                  "whitebalance is 30 K; it must be 0 or lie between 500 and 25000"},
             Case{"\"string sensor\" \"foo\"", "not \"foo\""},
             Case{"\"integer xresolutoin\" 3", "did you mean \"xresolution\""},
         }) {
        const std::string error = ErrorOf({c.text});
        EXPECT_NE(error.find(c.part), std::string::npos) << c.text << " says: " << error;
        EXPECT_NE(error.find("scene.pbrt:1:"), std::string::npos) << error;
    }
}

TEST(RGBFilm, OverridesThatLeaveNothingAreNoFaultOfTheScene) {
    FilmOverrides pixels;
    pixels.pixelBounds = Bounds2i{{50, 0}, {60, 5}};
    EXPECT_THROW(MakeFilm({kOnePixel, pixels}), OverrideError);
    FilmOverrides crop;
    crop.cropWindow = {0.5f, 0.5f, 0, 1};
    EXPECT_THROW(MakeFilm({kOnePixel, crop}), OverrideError);
}

}  // namespace
}  // namespace lacquer::rgb_test
