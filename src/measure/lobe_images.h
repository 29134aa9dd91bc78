// Plots of a lobe over the projected hemisphere, as numbers.
#pragma once

#include <string>
#include <vector>

#include "measure/lobe_survey.h"
#include "pbrt/image/image.h"

namespace lacquer::measure {

/// A square of pixels over [-1, 1]^2 that a hemisphere is projected to: a direction w lies at (w.x, w.y), x
/// to the right, y upward. Pixels are means over their area; what lies outside of the unit disk counts as 0.
struct LobeImage {
    int resolution = 0;
    std::vector<glm::dvec3> value;  ///< linear sRGB, f |cos theta| [1/sr]; rows from the top
    std::vector<double> variance;   ///< of the luminance of `value`, as a mean: falls with more samples
    std::vector<double> count;      ///< samples that fell into the pixel

    LobeImage() = default;
    explicit LobeImage(int side)
        : resolution(side), value(Size(side), glm::dvec3(0)), variance(Size(side)), count(Size(side)) {}
    bool IsEmpty() const { return resolution == 0; }
    double LuminanceAt(size_t i) const { return Luminance(value[i]); }

  private:
    static size_t Size(int side) { return size_t(side) * size_t(side); }
};

/// Reflection and transmission; the latter is empty where nothing can be transmitted.
struct LobePair {
    LobeImage reflection, transmission;
};

/// A density over solid angle [1/sr], laid out like LobeImage.
struct DensityPair {
    std::vector<double> reflection, transmission;
};

/// What Evaluate() says, at `samplesPerPixel` (a multiple of BsdfSubject::kNumSets, at least two of them)
/// points of each pixel. @param pdf  where not null, it gets the mean of the densities that come along
LobePair EvaluateImages(const LobeQuery& query, int resolution, int samplesPerPixel, DensityPair* pdf);
/// What Sample() does: histograms of its directions, weighted (f |cos theta|) and plain (`density`). Specular
/// peaks are left out.
LobePair SampleImages(const LobeQuery& query, int resolution, int64_t numSamples, DensityPair* density);

/// Signed differences of two images in standard errors, over blocks of pixels.
struct Difference {
    int resolution = 0;          ///< blocks on a side
    std::vector<double> sigmas;  ///< NaN outside of the disk and where there are too few samples
    int numBlocks = 0;           ///< that were compared
    double rms = 0;              ///< 1 if the images differ by noise only
    double largest = 0;
    double medianNoise = 0;  ///< standard error of a block over its value
};
/// Blocks with less than 32 samples of the histogram are left out, where the errors are not normal.
Difference Compare(const LobeImage& estimate, const LobeImage& histogram);

/// Channels R, G, B [1/sr] and Noise.Y, the standard error of the luminance.
Image ToImage(const LobeImage& lobe);
/// One channel Y [1/sr].
Image ToImage(const std::vector<double>& density);

}  // namespace lacquer::measure
