// Film "spectral": beside RGB, radiance in buckets of equal width over a range of wavelengths. The parameters
// of "rgb", and
//
//   "integer nbuckets"                    16        1 to 512
//   "float lambdamin", "float lambdamax"  360, 830  the range [nm]
//   "float maxcomponentvalue"             infinity  limits the radiance in a bucket as well
//
// EXR files only; their channels and attributes follow the spectral layout of [Fichet et al. 2021], so that
// its tools read them.
#include <fmt/format.h>

#include "pbrt/film/render_state.h"
#include "pbrt/film/rgb.h"
#include "pbrt/image/image.h"

namespace lacquer {
namespace {

constexpr int kMaxBuckets = 512;
/// Sums of all buckets; a quarter of it again is taken while an image is written.
constexpr size_t kMaxBytes = size_t(4) << 30;

class SpectralFilm final : public RGBFilm {
  public:
    explicit SpectralFilm(FilmArgs args)
        : RGBFilm({args.params, args.overrides, std::move(args.filter), args.shutterTime}) {
        const Params& params = args.params;
        numBuckets_ = params.GetIntInRange("nbuckets", 16, 1, kMaxBuckets);
        lambdaMin_ = params.GetFloatInRange("lambdamin", kLambdaMin, kLambdaMin, kLambdaMax);
        lambdaMax_ = params.GetFloatInRange("lambdamax", kLambdaMax, kLambdaMin, kLambdaMax);
        maxRadiance_ = params.GetFloat("maxcomponentvalue", Infinity);
        if (!(lambdaMax_ > lambdaMin_))
            params.Fail(params.Has("lambdamax") ? "lambdamax" : "lambdamin",
                        fmt::format("lambdamax is {} nm and lambdamin {} nm; it must be larger", lambdaMax_,
                                    lambdaMin_));
        RequireEXR("spectral", params, args.overrides);
        const size_t count = size_t(pixelBounds_.Area()) * size_t(numBuckets_);
        if (count * kBytesOfBucket > kMaxBytes)
            params.Fail(
                "nbuckets",
                fmt::format("{} x {} pixels of {} buckets are more than the {} buckets that one film may "
                            "hold; render it in crop windows",
                            pixelBounds_.Width(), pixelBounds_.Height(), numBuckets_,
                            kMaxBytes / kBytesOfBucket));
        buckets_ = ExactSums(2 * count);
    }

    SampledWavelengths SampleWavelengths(float u) const override {
        return SampledWavelengths::SampleUniform(u, lambdaMin_, lambdaMax_);
    }

    bool AddSample(Int2 p, SampledSpectrum L, const SampledWavelengths& lambda, float weight) override {
        const bool isValid = RGBFilm::AddSample(p, L, lambda, weight);
        if (!isValid) L = SampledSpectrum(0);
        const float largest = LargestRadiance(L);
        if (largest > maxRadiance_) L *= maxRadiance_ / largest;

        // A path that was dispersed stands for all wavelengths with the one that it followed: the mean over a
        // bucket must count it as often as the others.
        const float uniform = 1 / (lambdaMax_ - lambdaMin_);
        const size_t first = FirstBucketOf(p);
        for (int i = 0; i < kNumWavelengths; ++i) {
            if (lambda.Pdf()[i] == 0) continue;
            const double share = double(weight) * double(uniform / lambda.Pdf()[i]);
            const size_t bucket = first + size_t(BucketOf(lambda[i]));
            buckets_.Add(2 * bucket, share * double(L[i]));
            buckets_.Add(2 * bucket + 1, share);
        }
        return isValid;
    }

    /// Light that is traced from the lights would be in RGB but not in the buckets: it is refused.
    void PrepareForSplats(int threads) override {
        Film::PrepareForSplats(threads);  // NOLINT(bugprone-parent-virtual-call): not RGBFilm's
    }

    size_t MemoryBytes() const override { return RGBFilm::MemoryBytes() + buckets_.Bytes(); }

    void AppendState(std::vector<StateArray>* arrays) override {
        RGBFilm::AppendState(arrays);
        arrays->push_back({"buckets", &buckets_});
    }

    std::unique_ptr<Image> Develop() const override {
        const std::unique_ptr<Image> rgb = RGBFilm::Develop();
        std::vector<std::string> channels = rgb->Channels();
        for (int b = 0; b < numBuckets_; ++b) channels.push_back(ChannelName(b));
        auto image = std::make_unique<Image>(rgb->Resolution(), channels);
        image->dataWindow = rgb->dataWindow;
        image->fullResolution = rgb->fullResolution;
        image->SetColorSpace(rgb->ColorSpace());
        image->metadata["spectralLayoutVersion"] = std::string("1.0");
        image->metadata["emissiveUnits"] = std::string("W.m^-2.sr^-1");
        // Lights are given in photometric units, that is, their spectra are divided by this integral.
        // Radiometric values have it back.
        constexpr double kScale = double(kCieYIntegral);
        const std::vector<float>& colors = rgb->Pixels();
        const auto numColors = size_t(rgb->NumChannels());
        float* out = image->Pixels().data();
        for (size_t pixel = 0; pixel * numColors < colors.size(); ++pixel) {
            out = std::copy_n(&colors[pixel * numColors], numColors, out);
            for (size_t b = 0; b < size_t(numBuckets_); ++b) {
                const size_t bucket = pixel * size_t(numBuckets_) + b;
                const double sum = buckets_[2 * bucket], weight = buckets_[2 * bucket + 1];
                *out++ = weight == 0 ? 0.f : float(kScale * sum / weight);
            }
        }
        return image;
    }

  private:
    /// What a path found by one wavelength, the first one, counts for all of them: "volpath" gives it as a
    /// sum.
    static float LargestRadiance(SampledSpectrum L) {
        const bool isOne = L == SampledSpectrum(SampledSpectrum::Lanes{L[0]});
        return isOne ? L[0] / kNumWavelengths : L.MaxComponent();
    }
    static constexpr size_t kBytesOfBucket = 34;
    size_t FirstBucketOf(Int2 p) const {
        const Int2 q = p - pixelBounds_.min;
        return (size_t(q.y) * size_t(pixelBounds_.Width()) + size_t(q.x)) * size_t(numBuckets_);
    }
    int BucketOf(float lambda) const {
        const float position = (lambda - lambdaMin_) / (lambdaMax_ - lambdaMin_);
        return std::clamp(int(position * float(numBuckets_)), 0, numBuckets_ - 1);
    }
    /// "S0.374,688nm": S0 is unpolarised emission, and the comma keeps the number in one part of the name.
    std::string ChannelName(int b) const {
        const double position = (double(b) + 0.5) / double(numBuckets_);
        const double centre = double(lambdaMin_) + position * (double(lambdaMax_) - double(lambdaMin_));
        std::string number = fmt::format("{:.3f}", centre);
        std::replace(number.begin(), number.end(), '.', ',');
        return "S0." + number + "nm";
    }

    int numBuckets_ = 0;
    float lambdaMin_ = kLambdaMin, lambdaMax_ = kLambdaMax;
    float maxRadiance_ = Infinity;
    ExactSums buckets_;  ///< [pixel][bucket]: radiance, weight
};

std::unique_ptr<Film> CreateSpectralFilm(FilmArgs args) {
    return std::make_unique<SpectralFilm>(std::move(args));
}

}  // namespace

LACQUER_REGISTER(FilmKind, "spectral", CreateSpectralFilm);

}  // namespace lacquer
