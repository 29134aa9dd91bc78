// Sensor and pixels.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "pbrt/base/filter.h"
#include "pbrt/core/params.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/rng.h"
#include "pbrt/core/sampled_spectrum.h"
#include "pbrt/core/transform.h"

namespace lacquer {

class Image;
struct FirstHit;
struct StateArray;

/// What a film or a set of auxiliary outputs wants to know of the first surface that a camera ray meets.
struct FirstHitNeeds {
    bool any = false;
    bool albedo = false;    ///< costs samples of the BxDF at each hit
    bool slopes = false;    ///< how the point moves from one pixel to the next
    bool coverage = false;  ///< what media cover on the way to it
    bool motion = false;    ///< how far the surface moves on the image while the shutter is open
    FirstHitNeeds operator|(const FirstHitNeeds& o) const {
        return {any || o.any, albedo || o.albedo, slopes || o.slopes, coverage || o.coverage,
                motion || o.motion};
    }
};

/// Largest width or height [pixels].
inline constexpr int kMaxFilmSide = 1 << 16;

/// The halves of a pixel's samples, whose difference tells the noise, take `block` samples in turn.
///
/// Good samplers distribute each run of samples evenly, and the longer the better: with long blocks the
/// halves are nearly as good as a render of half the samples, where halves of every second sample have more
/// noise and know of each other.
struct Halves {
    int block = 1;
    int firstSample = 0;  ///< index of the first one that a pixel gets
    /// The same of each pixel, rows from the top, where they differ; else null.
    std::shared_ptr<const std::vector<int>> firstSamples = nullptr;
    /// Which of two blocks goes to the first half is drawn for each pair of them and each pixel. In turn, the
    /// halves of some samplers ("halton", "sobol") are strips of a pixel, and their difference does not fall
    /// as the noise does.
    bool isDrawn = false;
    /// @param taken  samples that the pixel got before
    /// @param pixel  its number, rows from the top
    bool IsFirst(int taken, size_t pixel = 0) const {
        const int number = ((firstSamples ? (*firstSamples)[pixel] : firstSample) + taken) / block;
        const bool isSwapped = isDrawn && (Hash(pixel, number / 2) >> 63) != 0;
        return (number % 2 == 0) != isSwapped;
    }
};

/// Collects samples. AddSample may be called from many threads as long as no two work on one pixel.
class Film {
  public:
    virtual ~Film() = default;
    Int2 Resolution() const { return resolution_; }
    /// The pixels to render, within the full image.
    Bounds2i PixelBounds() const { return pixelBounds_; }
    const lacquer::Filter& Filter() const { return *filter_; }
    const std::string& Filename() const { return filename_; }
    const lacquer::ColorSpace& ColorSpace() const { return *colorSpace_; }
    /// True if the scene asks for half floats; floats are the default.
    bool SavesHalf() const { return savesHalf_; }
    /// Diagonal of the full image on the film [mm], for cameras with a real lens.
    float Diagonal() const { return diagonal_; }

    virtual SampledWavelengths SampleWavelengths(float u) const {
        return SampledWavelengths::SampleVisible(u);
    }
    /// Adds one camera sample to its pixel. L that is not finite, or negative, counts as 0 and returns false.
    virtual bool AddSample(Int2 pixel, SampledSpectrum L, const SampledWavelengths& lambda, float weight) = 0;
    /// By which AddSample() scales a sample down, of films that limit them.
    virtual float LimitOf(SampledSpectrum /*L*/, const SampledWavelengths& /*lambda*/) const { return 1; }
    /// Makes room for the splats of `threads` threads. Does nothing the second time. Default: SceneError,
    /// such a film takes none. Errors: OverrideError if that takes more memory than a film may have.
    virtual void PrepareForSplats(int threads);
    /// Adds light at a point of the film, wherever the camera sample that found it belongs to: L is what one
    /// path from the lights contributes, in the unit in which the mean of L over paths and over the whole
    /// film is that of the image. Every camera sample stands for one such path. Each pixel whose filter
    /// reaches `p` gets its share. May be called by all threads of one parallel loop at once. L as for
    /// AddSample().
    virtual bool AddSplat(Point2 p, SampledSpectrum L, const SampledWavelengths& lambda);
    /// Bytes of what is added up for the pixels, without splats.
    virtual size_t MemoryBytes() const = 0;
    /// Bytes that splats take, of all threads.
    virtual size_t SplatBytes() const { return 0; }
    /// Corners of the rectangle of points whose splats reach some pixel.
    std::array<Point2, 2> SplatRange() const {
        const Vec2 reach = filter_->Radius() - Vec2(0.5f);
        return {Vec2(pixelBounds_.min) - reach, Vec2(pixelBounds_.max) + reach};
    }
    /// True for points in it.
    bool IsInSplatRange(Point2 p) const {
        const auto [first, last] = SplatRange();
        return p.x >= first.x && p.y >= first.y && p.x <= last.x && p.y <= last.y;
    }
    /// Camera samples that the pixel has got, invalid ones included.
    virtual int SampleCount(Int2 pixel) const = 0;
    /// That of all pixels, rows from the top.
    std::vector<int> SampleCounts() const {
        std::vector<int> counts;
        for (int y = pixelBounds_.min.y; y < pixelBounds_.max.y; ++y)
            for (int x = pixelBounds_.min.x; x < pixelBounds_.max.x; ++x)
                counts.push_back(SampleCount({x, y}));
        return counts;
    }
    /// Films that keep the geometry of first hits say so, and get it after each AddSample(), with the same L
    /// (0 if it was invalid).
    virtual FirstHitNeeds Needs() const { return {}; }
    virtual void AddFirstHit(Int2 /*pixel*/, const FirstHit& /*hit*/, SampledSpectrum /*L*/,
                             const SampledWavelengths& /*lambda*/) {}
    /// Makes room for parts of the light of each pixel, which are summed as colours are. Errors:
    /// OverrideError if that takes more memory than a film may have.
    /// @param layers  their names
    virtual void KeepPasses(std::vector<std::string> layers) = 0;
    /// Parts of the light of the camera sample that was just added, one for each layer. They are scaled as
    /// that sample was.
    virtual void AddPasses(Int2 pixel, SampledSpectrum L, std::span<const SampledSpectrum> passes,
                           const SampledWavelengths& lambda, float weight) = 0;
    /// Appends layers NAME.R, NAME.G, NAME.B to an image of the film.
    virtual std::unique_ptr<Image> AppendPasses(const Image& image) const = 0;
    /// The image so far, linear RGB in the film's colour space.
    virtual std::unique_ptr<Image> Develop() const = 0;
    /// Appends all that was added up, for files and for adding (film/render_state.h); not while others add.
    virtual void AppendState(std::vector<StateArray>* arrays) = 0;
    /// How the samples of a pixel go to its halves, before the first one.
    void SetHalves(const Halves& halves) { halves_ = halves; }
    const lacquer::Halves& Halves() const { return halves_; }

  protected:
    Film() = default;
    Int2 resolution_{0};
    Bounds2i pixelBounds_;
    std::unique_ptr<lacquer::Filter> filter_;
    std::string filename_;
    const lacquer::ColorSpace* colorSpace_ = nullptr;
    bool savesHalf_ = false;
    float diagonal_ = 35;
    lacquer::Halves halves_;
};

/// The longest block by which `count` samples are halved evenly: a power of two. 1 for an odd count.
inline int HalfBlockOf(int count) { return count > 0 && count % 2 == 0 ? (count & -count) / 2 : 1; }

/// What the command line says about the film.
struct FilmOverrides {
    std::optional<Int2> resolution;
    std::optional<Bounds2i> pixelBounds;
    std::optional<std::array<float, 4>> cropWindow;  ///< x0 x1 y0 y1, fractions
    std::string filename;                            ///< empty: the scene's
    bool quick = false;                              ///< a quarter of the resolution
    bool keepsHalves =
        false;  ///< also the mean of the first half of samples, as channels Half.R, Half.G, Half.B
};
/// The overrides leave nothing to render: no fault of the scene's.
class OverrideError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};
struct FilmArgs {
    const Params& params;
    const FilmOverrides& overrides;
    std::unique_ptr<Filter> filter;
    float shutterTime = 1;  ///< shutterclose - shutteropen
    Transform renderFromWorld = {};
    AnimatedTransform renderFromCamera = {};
};
struct FilmKind {
    static constexpr const char* kKind = "film";
    using Factory = std::unique_ptr<Film> (*)(FilmArgs);
};

}  // namespace lacquer
