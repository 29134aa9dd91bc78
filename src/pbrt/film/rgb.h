// The film of RGB pixels, and the base of films that keep more.
#pragma once

#include "pbrt/base/film.h"
#include "pbrt/film/exact_sums.h"
#include "pbrt/film/pass_sums.h"
#include "pbrt/film/sensor.h"
#include "pbrt/film/splats.h"

namespace lacquer {

class RGBFilm : public Film {
  public:
    explicit RGBFilm(FilmArgs args);
    bool AddSample(Int2 pixel, SampledSpectrum L, const SampledWavelengths& lambda, float weight) override;
    void PrepareForSplats(int threads) override { splats_.Prepare(pixelBounds_, threads); }
    float LimitOf(SampledSpectrum L, const SampledWavelengths& lambda) const override;
    bool AddSplat(Point2 p, SampledSpectrum L, const SampledWavelengths& lambda) override;
    size_t MemoryBytes() const override {
        return counts_.size() * sizeof(int) + sums_.Bytes() + halves_.Bytes() + passes_.Bytes();
    }
    size_t SplatBytes() const override { return splats_.Bytes(); }
    int SampleCount(Int2 pixel) const override { return counts_[Index(pixel)]; }
    void KeepPasses(std::vector<std::string> layers) override {
        passes_.Prepare(std::move(layers), counts_.size());
    }
    void AddPasses(Int2 pixel, SampledSpectrum L, std::span<const SampledSpectrum> passes,
                   const SampledWavelengths& lambda, float weight) override;
    std::unique_ptr<Image> AppendPasses(const Image& image) const override;
    std::unique_ptr<Image> Develop() const override;
    void AppendState(std::vector<StateArray>* arrays) override;

  protected:
    /// For films of more than colours. Errors: OverrideError, or SceneError at "filename", for other files
    /// than EXR.
    void RequireEXR(const char* film, const Params& params, const FilmOverrides& overrides) const;
    /// The sensor's response to one camera sample, scaled down to maxcomponentvalue; empty for radiance that
    /// is not finite, is negative, or overflows in the sensor.
    std::optional<Vec3> Response(SampledSpectrum L, const SampledWavelengths& lambda) const;

  private:
    /// By which maxcomponentvalue scales a response; 1 if it does not exceed it.
    float LimitingScale(Vec3 response) const;
    size_t Index(Int2 p) const {
        const Int2 q = p - pixelBounds_.min;
        return size_t(q.y) * size_t(pixelBounds_.Width()) + size_t(q.x);
    }
    /// From sums of splats to pixels: every camera sample, of whichever pixel, stands for a path that could
    /// have reached any point of the full image. 0 if there was none.
    double SplatScale() const;
    void ReadResolution(const Params& params, const FilmOverrides& overrides);
    void ReadBounds(const Params& params, const FilmOverrides& overrides);

    Sensor sensor_;
    float maxComponentValue_;
    /// Of each pixel the sensor's response and the weight, as all sums of colours.
    static constexpr size_t kNumSums = 4;
    static void AddTo(ExactSums* sums, size_t pixel, const std::optional<Vec3>& response, double weight) {
        if (response)
            for (int c = 0; c < 3; ++c)
                sums->Add(kNumSums * pixel + size_t(c), weight * double((*response)[c]));
        sums->Add(kNumSums * pixel + 3, weight);
    }
    /// The mean of a pixel; 0 if it has no weight.
    static glm::dvec3 MeanOf(const ExactSums& sums, size_t pixel);

    std::vector<int> counts_;
    ExactSums sums_;
    ExactSums halves_;  ///< of the first half of the samples (Film::Halves()); empty if they are not kept
    SplatSums splats_;
    PassSums passes_;
};

}  // namespace lacquer
