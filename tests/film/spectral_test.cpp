// The film "spectral": buckets, names of channels, attributes, and its RGB.
#include <gtest/gtest.h>

#include <filesystem>

#include "pbrt/base/film.h"
#include "pbrt/image/image.h"
#include "support/scene_parts.h"

namespace lacquer::spectral_test {
namespace {

std::unique_ptr<Film> MakeFilm(const std::string& kind, const std::string& text,
                               const FilmOverrides& overrides = {}) {
    const Params params = test::ParamsFromText(
        "film", "\"integer xresolution\" 2 \"integer yresolution\" 1 \"string filename\" \"a.exr\" " + text);
    auto film =
        Registry<FilmKind>::Find(kind)({params, overrides, Registry<FilterKind>::Find("box")(Params()), 1});
    params.CheckAllUsed();
    return film;
}
std::string ErrorOf(const std::string& text, const FilmOverrides& overrides = {}) {
    try {
        MakeFilm("spectral", text, overrides);
    } catch (const std::exception& e) {
        return e.what();
    }
    return "";
}

constexpr int kSamples = 4700;
/// A spectrum at kSamples evenly spread draws of wavelengths in pixel (1, 0).
void AddSpectrum(Film& film, const Spectrum& s, float scale = 1) {
    for (int i = 0; i < kSamples; ++i) {
        const SampledWavelengths lambda = film.SampleWavelengths((float(i) + 0.5f) / float(kSamples));
        film.AddSample({1, 0}, s.Sample(lambda) * scale, lambda, 0.5f);
    }
}
std::vector<float> BucketsOf(const Image& image) {
    std::vector<float> values;
    for (int c = 3; c < image.NumChannels(); ++c) values.push_back(image.Get({1, 0}, c));
    return values;
}

TEST(SpectralFilm, ChannelsAreNamedByTheirCentres) {
    const auto image = MakeFilm("spectral", "")->Develop();
    ASSERT_EQ(image->NumChannels(), 3 + 16);
    EXPECT_EQ(image->Channels()[0], "R");
    // The first of 16 parts of 470 nm has its centre at 374.6875 nm.
    EXPECT_EQ(image->Channels()[3], "S0.374,688nm");
    EXPECT_EQ(image->Channels()[18], "S0.815,312nm");
    const auto three =
        MakeFilm("spectral", "\"integer nbuckets\" 3 \"float lambdamin\" 400 \"float lambdamax\" 700")
            ->Develop();
    EXPECT_EQ(three->Channels(),
              (std::vector<std::string>{"R", "G", "B", "S0.450,000nm", "S0.550,000nm", "S0.650,000nm"}));
}

// Halves stand between colours and buckets, and take nothing of them.
TEST(SpectralFilm, KeepsHalvesBesideBuckets) {
    FilmOverrides overrides;
    overrides.keepsHalves = true;
    const auto film = MakeFilm("spectral", "\"integer nbuckets\" 2", overrides);
    const auto plain = MakeFilm("spectral", "\"integer nbuckets\" 2");
    for (Film* f : {film.get(), plain.get()}) AddSpectrum(*f, ConstantSpectrum(0.5f));
    const auto image = film->Develop(), without = plain->Develop();
    ASSERT_EQ(image->NumChannels(), 3 + 3 + 2);
    for (int x = 0; x < 2; ++x)
        for (const std::string& channel : without->Channels())
            EXPECT_EQ(image->Get({x, 0}, image->FindChannel(channel)),
                      without->Get({x, 0}, without->FindChannel(channel)))
                << channel;
    // Every second sample of evenly spread wavelengths, some 50.
    EXPECT_NEAR(image->Get({1, 0}, 4), image->Get({1, 0}, 1), 3e-3f);
}

TEST(SpectralFilm, FilesHaveTheChannelsAndTheAttributesOfTheLayout) {
    const auto film = MakeFilm("spectral", "\"integer nbuckets\" 4");
    AddSpectrum(*film, ConstantSpectrum(0.5f));
    const auto image = film->Develop();
    const std::string path = testing::TempDir() + "/lacquer-spectral-test.exr";
    WriteImage(*image, path);
    const Image read = ReadImage(path, {}, {});
    std::filesystem::remove(path);
    EXPECT_EQ(std::get<std::string>(read.metadata.at("spectralLayoutVersion")), "1.0");
    EXPECT_EQ(std::get<std::string>(read.metadata.at("emissiveUnits")), "W.m^-2.sr^-1");
    for (int c = 0; c < image->NumChannels(); ++c) {
        const int found = read.FindChannel(image->Channels()[size_t(c)]);
        ASSERT_GE(found, 0) << image->Channels()[size_t(c)];
        EXPECT_EQ(read.Get({1, 0}, found), image->Get({1, 0}, c));
    }
}

TEST(SpectralFilm, AnEqualEnergySpectrumFillsAllBucketsAlike) {
    const auto film = MakeFilm("spectral", "");
    AddSpectrum(*film, ConstantSpectrum(1 / kCieYIntegral), 3);
    for (const float value : BucketsOf(*film->Develop())) EXPECT_NEAR(value, 3, 1e-5f);
    // Pixels without samples are black.
    EXPECT_EQ(film->Develop()->Get({0, 0}, 5), 0);
}

TEST(SpectralFilm, ABucketIsTheMeanOverItsWavelengths) {
    // Radiance lambda: the mean over a bucket is its centre.
    const auto film =
        MakeFilm("spectral", "\"integer nbuckets\" 7 \"float lambdamin\" 400 \"float lambdamax\" 750");
    AddSpectrum(*film, PiecewiseLinearSpectrum({300, 900}, {300 / kCieYIntegral, 900 / kCieYIntegral}));
    const std::vector<float> buckets = BucketsOf(*film->Develop());
    ASSERT_EQ(buckets.size(), 7u);
    // Thousands of wavelengths over 350 nm, evenly: some hundredths of a nm from one to the next.
    for (size_t b = 0; b < 7; ++b) EXPECT_NEAR(buckets[b], 425 + 50 * float(b), 0.05f);
    // A line at 500 nm, 2 nm wide, belongs to the bucket that ends there and to the next one.
    const auto line = MakeFilm("spectral", "\"integer nbuckets\" 47");
    AddSpectrum(*line, PiecewiseLinearSpectrum({498, 499, 501, 502}, {0, 1, 1, 0}));
    const std::vector<float> narrow = BucketsOf(*line->Develop());
    for (size_t b = 0; b < 47; ++b)
        EXPECT_NEAR(narrow[b] / kCieYIntegral, b == 13 || b == 14 ? 0.15f : 0.f, 2e-3f) << b;
}

TEST(SpectralFilm, RgbIsThatOfTheRgbFilmOverTheWholeRange) {
    const auto daylight = DaylightSpectrum(4500);
    const auto spectral = MakeFilm("spectral", ""), rgb = MakeFilm("rgb", "");
    AddSpectrum(*spectral, *daylight);
    AddSpectrum(*rgb, *daylight);
    const auto a = spectral->Develop(), b = rgb->Develop();
    // Both are integrals by 4700 even draws of functions of 471 steps: 1e-3 is generous.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a->Get({1, 0}, c) / b->Get({1, 0}, c), 1, 1e-3f) << c;
    // Buckets know nothing of exposure: radiance is radiance.
    const auto exposed = MakeFilm("spectral", "\"float iso\" 200");
    AddSpectrum(*exposed, *daylight);
    EXPECT_NEAR(exposed->Develop()->Get({1, 0}, 0) / a->Get({1, 0}, 0), 2, 1e-5f);
    EXPECT_EQ(BucketsOf(*exposed->Develop()), BucketsOf(*a));
}

/// Multiples of the golden ratio fall evenly into [0,1).
float Fraction(double x) { return float(0.9999999 * (x - std::floor(x))); }

TEST(SpectralFilm, DispersedPathsCountAsMuchAsOthers) {
    // Half of the paths bring 1 at all their wavelengths, the other half 3 at the one that they followed: the
    // mean is 2 in each bucket. A mean over all lanes alike would be 1.4 (lanes left out) or less.
    const auto film = MakeFilm("spectral", "\"integer nbuckets\" 5");
    for (int i = 0; i < 20000; ++i) {
        SampledWavelengths lambda = film->SampleWavelengths(Fraction(0.618033989 * i));
        if (i % 2 == 0) lambda.TerminateSecondary();
        film->AddSample({1, 0}, SampledSpectrum((i % 2 == 0 ? 3 : 1) / kCieYIntegral), lambda, 1);
    }
    // Even spread: each bucket gets its share of both kinds to a part in a thousand.
    for (const float value : BucketsOf(*film->Develop())) EXPECT_NEAR(value, 2, 5e-3f);
}

TEST(SpectralFilm, BadSamplesAreBlackAndLargeOnesAreLimited) {
    const auto film = MakeFilm("spectral", "\"integer nbuckets\" 1 \"float maxcomponentvalue\" 10");
    const SampledWavelengths lambda = film->SampleWavelengths(0.3f);
    EXPECT_TRUE(film->AddSample({1, 0}, SampledSpectrum(40), lambda, 1));
    EXPECT_NEAR(BucketsOf(*film->Develop())[0], 10 * kCieYIntegral, 1e-2f);
    EXPECT_FALSE(film->AddSample({1, 0}, SampledSpectrum(-1), lambda, 1));
    EXPECT_NEAR(BucketsOf(*film->Develop())[0], 5 * kCieYIntegral, 1e-2f);
}

// As "volpath" gives what it finds after a dispersive event: at the first wavelength, times their number.
TEST(SpectralFilm, LimitsWhatOneWavelengthFoundByWhatItStandsFor) {
    for (const auto& [radiance, limited] : {std::pair{9.f, 9.f}, {20.f, 10.f}}) {
        const auto film = MakeFilm("spectral", "\"integer nbuckets\" 1 \"float maxcomponentvalue\" 10");
        SampledSpectrum L(0);
        L.Set(0, kNumWavelengths * radiance);
        EXPECT_TRUE(film->AddSample({1, 0}, L, film->SampleWavelengths(0.3f), 1));
        EXPECT_NEAR(BucketsOf(*film->Develop())[0], limited * kCieYIntegral, 1e-2f);
    }
}

TEST(SpectralFilm, TakesNoLightThatIsTracedFromTheLights) {
    EXPECT_THROW(MakeFilm("spectral", "")->PrepareForSplats(1), SceneError);
}

TEST(SpectralFilm, MistakesAreExplained) {
    const auto says = [](const std::string& error, const std::string& part) {
        EXPECT_NE(error.find(part), std::string::npos) << error;
    };
    says(ErrorOf("\"float lambdamin\" 300"), "\"float lambdamin\" must lie in [360, 830], is 300");
    says(ErrorOf("\"float lambdamax\" 900"), "\"float lambdamax\" must lie in [360, 830], is 900");
    says(ErrorOf("\"float lambdamin\" 600 \"float lambdamax\" 500"), "it must be larger");
    says(ErrorOf("\"integer nbuckets\" 0"), "\"integer nbuckets\" must lie in [1, 512], is 0");
    FilmOverrides large;
    large.resolution = Int2(8000, 4000);
    says(ErrorOf("\"integer nbuckets\" 100", large), "render it in crop windows");
    FilmOverrides overrides;
    overrides.filename = "b.png";
    says(ErrorOf("", overrides), "needs an EXR file for its channels; \"b.png\"");
}

}  // namespace
}  // namespace lacquer::spectral_test
