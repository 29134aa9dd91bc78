// The film of RGB pixels, and the base of films that keep more.
#pragma once

#include "pbrt/base/film.h"
#include "pbrt/film/pass_sums.h"
#include "pbrt/film/sensor.h"
#include "pbrt/film/splats.h"

namespace lacquer {

class RGBFilm : public Film {
  public:
    explicit RGBFilm(FilmArgs args);
    bool AddSample(Int2 pixel, SampledSpectrum L, const SampledWavelengths& lambda, float weight) override;
    void PrepareForSplats(int threads) override { splats_.Prepare(pixelBounds_, threads); }
    bool AddSplat(Point2 p, SampledSpectrum L, const SampledWavelengths& lambda) override;
    size_t MemoryBytes() const override {
        return pixels_.size() * sizeof(Pixel) + halves_.size() * sizeof(Half) + passes_.Bytes();
    }
    size_t SplatBytes() const override { return splats_.Bytes(); }
    int SampleCount(Int2 pixel) const override { return pixels_[Index(pixel)].count; }
    void KeepPasses(std::vector<std::string> layers) override {
        passes_.Prepare(std::move(layers), pixels_.size());
    }
    void AddPasses(Int2 pixel, SampledSpectrum L, std::span<const SampledSpectrum> passes,
                   const SampledWavelengths& lambda, float weight) override;
    std::unique_ptr<Image> AppendPasses(const Image& image) const override;
    std::unique_ptr<Image> Develop() const override;

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
    /// Sums in double, so that partial films merge without loss.
    struct Pixel {
        double sum[3] = {0, 0, 0};
        double weight = 0;
        int count = 0;
    };
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
    std::vector<Pixel> pixels_;
    /// Of the first half of the samples of each pixel (IsOfFirstHalf()); empty if they are not kept.
    struct Half {
        double sum[3] = {0, 0, 0};
        double weight = 0;
    };
    std::vector<Half> halves_;
    SplatSums splats_;
    PassSums passes_;
};

}  // namespace lacquer
