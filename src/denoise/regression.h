// Smoothing by weighted means and by weighted regressions on features [Bitterli et al. 2016].
#pragma once

#include "denoise/patch_weights.h"
#include "pbrt/core/progress.h"

namespace lacquer::denoise {

/// Pixels a side of what one thread works on.
inline constexpr int kTile = 32;

/// Weighted means over windows, with weights from `guide`: non-local means.
template <size_t N, size_t M>
Planes<N> WeightedMeans(const Planes<N>& values, const Guide<M>& guide, const PatchOptions& options);

/// For each window, colours as a linear function of the features, by weighted least squares; a pixel is the
/// mean of what all windows that contain it make of it, with the same weights [Bitterli et al. 2016, sec. 5].
/// @param colors     what is smoothed
/// @param guide      what the weights come from: a buffer whose noise is independent of that of `colors`
/// @param features   without noise, or nearly; in units in which the differences that matter are about 1
/// @param variances  of the features: noisy ones count less
/// The same bits for any number of threads. Cost: about 8 us a pixel of one core, of windows of 19 x 19.
Color Regress(const Color& colors, const Guide<3>& guide, const Features& features, const Features& variances,
              const PatchOptions& options, Observer* observer);

}  // namespace lacquer::denoise
