// Tone curves: from linear values to those of an image, and the way back of derivatives.
#pragma once

#include "estimate/photo/flash_photo.h"

namespace lacquer::estimate {

enum class ToneCurve {
    SRGB,     ///< the curve of sRGB
    Gamma22,  ///< a power of 1 / 2.2 [Guo et al. 2020]
    Linear    ///< for images that are linear
};

/// What a tone curve leaves of linear values. Values are clamped to [0, 1]; where they are clamped,
/// derivatives are 0. Below kDarkest the power curve, which starts with an infinite slope, is continued by a
/// straight line from 0.
constexpr double kDarkest = 1e-6;
void ApplyTone(ToneCurve curve, const PlanarImage& linear, PlanarImage* toned);
/// Turns derivatives by toned values to those by linear values, in place.
void ToneAdjoint(ToneCurve curve, const PlanarImage& linear, const PlanarImage& toned, PlanarImage* by);

/// Means of squares of `count` x `count` values, which are clamped to [0, 1] before.
void AverageClamped(const PlanarImage& fine, int count, PlanarImage* means);
/// Derivatives by the fine values from those by the means.
PlanarImage AverageAdjoint(const PlanarImage& fine, int count, const PlanarImage& byMeans);

/// To the nearest of the 256 values that files of bytes have.
void RoundToBytes(PlanarImage* toned);

/// Part of the values that the curve clamps at 1.
double ClippedShare(const PlanarImage& linear);

}  // namespace lacquer::estimate
