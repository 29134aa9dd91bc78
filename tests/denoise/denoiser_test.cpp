// The denoiser on images whose truth is known.
#include "denoise/denoiser.h"

#include <gtest/gtest.h>

#include <functional>

#include "denoise/method.h"
#include "denoise/oidn.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::denoise::denoiser_test {
namespace {

constexpr Int2 kSize(72, 48);
constexpr int kSamples = 16;

using ColorAt = std::function<RGB(Int2)>;

/// A render with white noise of deviation `noise` a sample, and features without noise: albedo as given, a
/// normal that turns, a depth that grows.
Image Render(const ColorAt& color, const ColorAt& albedo, double noise, uint64_t seed) {
    Image image(kSize, {"R",
                        "G",
                        "B",
                        "Half.R",
                        "Half.G",
                        "Half.B",
                        "Variance.Y",
                        "Albedo.R",
                        "Albedo.G",
                        "Albedo.B",
                        "Ns.X",
                        "Ns.Y",
                        "Ns.Z",
                        "Z",
                        "Half.Albedo.R",
                        "Half.Albedo.G",
                        "Half.Albedo.B",
                        "Half.Ns.X",
                        "Half.Ns.Y",
                        "Half.Ns.Z",
                        "Half.Z"});
    image.metadata["samplesPerPixel"] = kSamples;
    Rng rng(seed);
    const auto normal = [&] {
        return std::sqrt(-2 * std::log(1 - double(rng.Uniform()))) *
               std::cos(2 * double(Pi) * double(rng.Uniform()));
    };
    for (int y = 0; y < kSize.y; ++y)
        for (int x = 0; x < kSize.x; ++x) {
            const Int2 p(x, y);
            const float angle = float(x) / 40;
            const float features[7] = {albedo(p).x, albedo(p).y,     albedo(p).z,     std::sin(angle),
                                       0,           std::cos(angle), 5 + float(y) / 9};
            for (int c = 0; c < 3; ++c) {
                const double scale = noise / std::sqrt(kSamples / 2.0);
                const double a = double(color(p)[c]) + scale * normal(),
                             b = double(color(p)[c]) + scale * normal();
                image.Set(p, c, float((a + b) / 2));
                image.Set(p, 3 + c, float(a));
            }
            image.Set(p, 6, float(noise * noise));
            for (int i = 0; i < 7; ++i)
                for (const int first : {7, 14}) image.Set(p, first + i, features[i]);
        }
    return image;
}

double Rmse(const Image& image, const ColorAt& truth) {
    double sum = 0;
    for (int y = 0; y < kSize.y; ++y)
        for (int x = 0; x < kSize.x; ++x)
            for (int c = 0; c < 3; ++c) {
                const double d = double(image.Get({x, y}, c) - truth({x, y})[c]);
                sum += d * d;
            }
    return std::sqrt(sum / (3.0 * kSize.x * kSize.y));
}

RGB Grey(Int2) { return RGB(0.5f); }
RGB Checks(Int2 p) { return (p.x / 6 + p.y / 6) % 2 ? RGB(0.8f, 0.3f, 0.2f) : RGB(0.1f, 0.5f, 0.7f); }
/// Light that changes slowly.
float Light(Int2 p) { return 1 + 0.5f * std::sin(float(p.x) / 20) + 0.01f * float(p.y); }

struct Runs {
    double before, after, estimated;
};
Runs RunOn(const ColorAt& color, const ColorAt& albedo, double noise, uint64_t seed) {
    Image image = Render(color, albedo, noise, seed);
    const double before = Rmse(image, color);
    const Denoised denoised = Denoise(BuffersOf(image), {});
    SetColors(denoised.color, &image);
    return {before, Rmse(image, color), double(denoised.noiseAfter)};
}

TEST(Denoiser, TakesNoiseAndTellsWhatIsLeft) {
    const ColorAt lit = [](Int2 p) { return Checks(p) * Light(p); };
    const Runs runs = RunOn(lit, Checks, 0.8, 1);
    EXPECT_NEAR(runs.before, 0.8 / std::sqrt(double(kSamples)), 0.01);
    EXPECT_LT(runs.after, 0.35 * runs.before);
    // The rest is what the filter has blurred.
    EXPECT_LT(runs.estimated, 1.1 * runs.after);
    EXPECT_GT(runs.estimated, 0.4 * runs.after);
    // The control: without the albedo of the checks, the same noise leaves much more.
    const Runs blind = RunOn(lit, Grey, 0.8, 1);
    EXPECT_GT(blind.after, 1.5 * runs.after);
}

TEST(Denoiser, KeepsWhatHasNoNoise) {
    const ColorAt stripes = [](Int2 p) { return RGB(p.x % 2 ? 1.f : 0.2f, 0.5f, float(p.y % 3)); };
    EXPECT_LT(RunOn(stripes, Grey, 1e-6, 2).after, 1e-3);
}

/// Detail of one deviation of the noise that no feature tells: patches look alike, and a filter takes it
/// away.
TEST(Denoiser, LeavesWhatNoFilterMakesBetter) {
    const ColorAt detail = [](Int2 p) { return RGB(1 + 0.1f * (Rng(Hash(p.x, p.y)).Uniform() - 0.5f)); };
    const Runs runs = RunOn(detail, Grey, 0.08, 5);
    EXPECT_NEAR(runs.before, 0.02, 0.001);
    // The filters alone would leave 1.3 times the noise.
    EXPECT_LT(runs.after, 1.1 * runs.before);
}

TEST(Denoiser, KeepsTheMean) {
    // Weights from the other half do not prefer dark or bright values.
    const ColorAt color = [](Int2 p) { return RGB(Light(p)); };
    Image image = Render(color, Grey, 1, 3);
    SetColors(Denoise(BuffersOf(image), {}).color, &image);
    double sum = 0, truth = 0;
    for (int y = 0; y < kSize.y; ++y)
        for (int x = 0; x < kSize.x; ++x) {
            sum += double(image.Get({x, y}, 1));
            truth += double(color({x, y}).y);
        }
    // Of the mean of all pixels, the noise is 0.25 / sqrt(3456) = 0.004 of 1.3.
    EXPECT_NEAR(sum / truth, 1, 0.015);
}

TEST(Denoiser, HasTheSameBitsForAllThreads) {
    const Image image = Render([](Int2 p) { return Checks(p) * Light(p); }, Checks, 0.5, 4);
    std::vector<std::vector<std::array<float, 3>>> results;
    for (const int threads : {1, 2, 7}) {
        const ThreadLimit limit(threads);
        results.push_back(Denoise(BuffersOf(image), {}).color.All());
    }
    EXPECT_TRUE(results[0] == results[1] && results[0] == results[2]);
}

TEST(Denoiser, SaysWhatIsMissing) {
    const Image image = Render(Grey, Grey, 1, 5);
    const auto why = [](const Image& i) -> std::string {
        try {
            BuffersOf(i);
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
        return {};
    };
    EXPECT_EQ(why(image), "");
    EXPECT_NE(why(image.Part({{0, 0}, kSize}, {0, 1, 2})).find("Half.R"), std::string::npos);
    Image one = image;
    one.metadata["samplesPerPixel"] = 1;
    EXPECT_NE(why(one).find("at least 1"), std::string::npos);
    Image bad = image;
    bad.Set({3, 4}, 1, NAN);
    EXPECT_NE(why(bad).find("NaN"), std::string::npos);
    bad = image;
    bad.metadata.erase("samplesPerPixel");
    EXPECT_NE(why(bad).find("samplesPerPixel"), std::string::npos);
}

TEST(DenoiseMethod, NforIsOurs) {
    const ColorAt lit = [](Int2 p) { return Checks(p) * Light(p); };
    Image image = Render(lit, Checks, 0.8, 1), same = image;
    const NoiseReport report = DenoiseImage(Method::Nfor, &image, nullptr);
    const Denoised denoised = Denoise(BuffersOf(same), {});
    SetColors(denoised.color, &same);
    EXPECT_EQ(image.Pixels(), same.Pixels());
    EXPECT_TRUE(report.IsKnown());
    EXPECT_EQ(report.after, denoised.noiseAfter);
    EXPECT_EQ(report.before, denoised.noiseBefore);
}

TEST(DenoiseMethod, OidnNeedsItsGuidesAndToBeBuiltIn) {
    Image image = Render(Grey, Grey, 1, 5);
    const Image before = image;
    Image plain = image.Part({{0, 0}, kSize}, {0, 1, 2});
    EXPECT_THROW(DenoiseImage(Method::Oidn, &plain, nullptr), std::invalid_argument);
    EXPECT_EQ(WhyUnavailable(Method::Nfor), "");
    EXPECT_EQ(WhyUnavailable(Method::Oidn).empty(), HasOidn());
    if (HasOidn()) return;
    EXPECT_THROW(DenoiseImage(Method::Oidn, &image, nullptr), std::runtime_error);
    EXPECT_EQ(image.Pixels(), before.Pixels());
}

TEST(DenoiseMethod, SaysBeforeARenderWhatCannotBeDenoised) {
    EXPECT_EQ(WhyNot(Method::Nfor, 2, false), "");
    EXPECT_NE(WhyNot(Method::Nfor, 1, false), "");
    EXPECT_NE(WhyNot(Method::Nfor, 8, true), "");
    EXPECT_EQ(WhyNot(Method::Oidn, 1, true), "");
    for (const std::string& name : MethodNames()) EXPECT_FALSE(AovsOf(MethodOf(name)).empty()) << name;
}

}  // namespace
}  // namespace lacquer::denoise::denoiser_test
