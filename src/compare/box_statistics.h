// How noisy the runs of several estimators are in a part of the image, and how sure that is.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "compare/box.h"
#include "compare/reference.h"

namespace lacquer::compare {

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
    /// Difference in standard errors, kept within a million.
    double Z() const {
        if (meanDifference == 0) return 0;
        return std::clamp(meanDifference / std::max(standardError, 1e-300), -1e6, 1e6);
    }
};

/// How an estimator stands to that of the least error.
enum class Verdict {
    Best,               ///< it has the least error
    Indistinguishable,  ///< a difference to the best was not shown
    Worse,              ///< it has more error than the best
    Untested            ///< nothing to say: no interval, or a reference too noisy for it or another one
};

/// What the runs of one estimator say about one box. All errors are of linear RGB, averaged over the
/// channels.
struct BoxResult {
    /// Root of the mean squared error over the runs in each pixel, averaged over the pixels ([Xia et al.
    /// 2020] sec. 8).
    Interval rmse;
    /// The same without the noise of the reference: scaled by sqrt(1 - referenceNoiseShare). NaN if that is
    /// more than half.
    double rmseCorrected = 0;
    /// Mean of (x - r)^2 / (r^2 + 0.01) over pixels and runs.
    Interval relativeMse;
    /// Mean variance of the reference, and its part of the mean squared error, from 0 to 1.
    double referenceNoise = 0, referenceNoiseShare = 0;
    std::optional<BiasCheck> bias;  ///< none with a single run
    /// The part of the squared error without the reference's noise that is the same in all runs, from 0 to 1:
    /// the square of what the expectation of each pixel is wrong by. 0 but for noise where an estimator is
    /// unbiased. NaN with a single run.
    double systematicShare = 0;
    /// By how much intervals are wider since errors of whole images go together; 1: no sign of that.
    double sharedErrors = 1;
    /// rmseCorrected of the baseline over this one's, and the square of that: the reduction of time at equal
    /// error. Exactly 1 for the baseline itself.
    Interval rmseReduction, timeReduction;
    /// This one's rmseCorrected over the least of all, and what a test of the two says.
    Interval rmseOverBest;
    Verdict verdict = Verdict::Untested;
    /// Probability of a difference as large as that to the best, or larger, between any two estimators of the
    /// box if all had the same error. 1 for the best, NaN where it is untested.
    double pEqual = 1;
};

/// Runs of one estimator: images of one size, in R, G, B first.
using Runs = std::vector<const Image*>;

/// Measures a box.
/// @param pixels    in the images' own pixels
/// @param runs      one for each estimator, equally many (at least one) images each; all runs are independent
/// @param baseline  index of the estimator that others are compared with
/// @param seed      of the bootstrap
/// @param seconds   what the runs of each estimator took: where they differ, ratios are those at equal time,
///                  with errors that fall with its root. Empty: all alike
///
/// The best are told apart by a test of two samples, since no runs share random numbers: the difference of
/// logarithms of rmseCorrected over its standard error in the bootstrap is taken as normal, and its
/// probability corrected for all pairs of estimators [Sidak 1967], for which is the best was not known
/// before.
///
/// Intervals are from a bootstrap (Efron) of 1000 replicates that draws the runs with replacement, anew in
/// each block of 4 x 4 pixels, and the same ones for all estimators: the pixels of the box stay what they
/// are. Logarithms of replicates are taken relative to their mean, which takes out the bias of the square
/// root under resampling, and stretched by sqrt(n / (n - 1)) for n runs, for resampling n values shows only
/// that part of their spread. With one run the blocks are drawn instead, which also counts the differences
/// between them. Boxes of a few pixels have too few values: their intervals are too narrow.
///
/// Samplers that stratify share random numbers among all pixels (digits of halton, the order of zsobol), and
/// the error of a whole image then depends on its seed, by which blocks are not independent. That shows in
/// how the squared error of the box varies from run to run, over what its blocks would make it vary: where
/// the mean of this over the estimators is more than chance explains (5 %), replicates are stretched by its
/// root, and by what Student's t of so few runs is wider than a normal number. Of two runs of two estimators
/// that is a factor of two beside the root; more runs are better. What stays below chance is not seen: up to
/// a variance of 2 with four runs of two.
///
/// The reference's noise is its own where it is known. Else it is estimated from the runs: the errors of two
/// independent runs of an unbiased estimator have only the reference in common, so the mean product of the
/// errors of different runs is the reference's variance. A bias adds its square, so the least of the
/// estimators' figures is taken. Where the noise is more than half of the squared error, nothing is corrected
/// and no ratio given.
std::vector<BoxResult> MeasureBox(const Bounds2i& pixels, const Reference& reference,
                                  const std::vector<Runs>& runs, size_t baseline, uint64_t seed,
                                  const std::vector<double>& seconds = {});

/// Mean over a box of the per-pixel root of mean squared error, from squared errors summed over `runs` runs.
/// @param sums       one for each pixel of an image `width` wide
/// @param noise      mean variance of the reference in the box, taken out of the result
double RmseOfSums(const std::vector<float>& sums, int width, const Bounds2i& pixels, int runs, double noise);

/// Per-pixel squared error, averaged over R, G and B.
std::vector<float> SquaredErrors(const Image& image, const Image& reference);

}  // namespace lacquer::compare
