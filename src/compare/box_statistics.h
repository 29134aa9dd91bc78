// How noisy the runs of several estimators are in a part of the picture, and how sure that is.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "compare/box.h"
#include "compare/reference.h"

namespace lacquer {

/// A measured value and the 95 % confidence interval around it.
struct Interval {
    double value = 0, low = 0, high = 0;
};

/// Mean difference to the reference, in luminance, over all pixels and runs.
struct BiasCheck {
    double meanDifference = 0;
    double standardError =
        0;                ///< from the spread over the runs in each pixel, and from the reference's noise
    double relative = 0;  ///< meanDifference over the mean luminance of the reference
    /// Difference in standard errors.
    double Z() const { return standardError > 0 ? meanDifference / standardError : 0; }
};

/// What the runs of one estimator say about one box. All errors are of linear RGB, averaged over the
/// channels.
struct BoxResult {
    /// Root of the mean squared error over the runs in each pixel, averaged over the pixels ([Xia20] 8).
    Interval rmse;
    /// The same without the noise of the reference: scaled by sqrt(1 - referenceNoiseShare).
    double rmseCorrected = 0;
    /// Mean of (x - r)^2 / (r^2 + 0.01) over pixels and runs.
    Interval relativeMse;
    /// Mean variance of the reference, and its part of the mean squared error, from 0 to 1.
    double referenceNoise = 0, referenceNoiseShare = 0;
    std::optional<BiasCheck> bias;  ///< none with a single run
    /// rmseCorrected of the baseline over this one's, and the square of that: the reduction of time at equal
    /// error. Exactly 1 for the baseline itself.
    Interval rmseReduction, timeReduction;
};

/// Runs of one estimator: images of one size, in R, G, B first.
using Runs = std::vector<const Image*>;

/// Measures a box.
/// @param pixels    in the images' own pixels
/// @param runs      one for each estimator, equally many (at least one) images each; all runs are independent
/// @param baseline  index of the estimator that others are compared with
/// @param seed      of the bootstrap
///
/// Intervals are from a bootstrap (Efron) of 1000 replicates that draws, with replacement, the runs (the same
/// for all estimators, since runs in turn share the state of the machine) and blocks of 4 x 4 pixels
/// (likewise). Logarithms of replicates are taken relative to their mean, which takes out the bias of the
/// square root under resampling, and stretched by sqrt(n / (n - 1)) for n runs, for resampling n values shows
/// only that part of their spread. With one run only the pixels are drawn.
///
/// The reference's noise is its own where it is known. Else it is estimated from the runs: the errors of two
/// independent unbiased runs have only the reference in common, so the mean product of the errors of
/// different runs is the reference's variance. (A common bias of all estimators would be taken for it; the
/// check of the bias still finds it.)
std::vector<BoxResult> MeasureBox(const Bounds2i& pixels, const Reference& reference,
                                  const std::vector<Runs>& runs, size_t baseline, uint64_t seed);

/// Mean over a box of the per-pixel root of mean squared error, from squared errors summed over `runs` runs.
/// @param sums       one for each pixel of an image `width` wide
/// @param noise      mean variance of the reference in the box, taken out of the result
double RmseOfSums(const std::vector<float>& sums, int width, const Bounds2i& pixels, int runs, double noise);

/// Per-pixel squared error, averaged over R, G and B.
std::vector<float> SquaredErrors(const Image& image, const Image& reference);

}  // namespace lacquer
