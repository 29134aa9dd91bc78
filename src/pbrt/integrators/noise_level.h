// How much noise an image has, as one number: where a render may stop.
#pragma once

#include <vector>

#include "pbrt/base/film.h"

namespace lacquer {

/// Side of the window for the values that a noise level is relative to [pixels].
constexpr int kNoiseScaleWindow = 4;

/// For each pixel value^2 + e^2, by which its squared errors are divided: value^2 is the mean over the
/// channels of the squared mean of window x window pixels, and e a quarter of the image's mean, below which
/// the eye sees errors as such and not as parts of a value.
std::vector<double> SquaredScales(Int2 size, const std::vector<RGB>& values, int window);

/// The relative standard error that 95 % of the pixels are below. That of a pixel is the root of the
/// mean over 8 x 8 pixels around it, and over the channels, of d^2 / (value^2 + e^2), as of SquaredScales()
/// with kNoiseScaleWindow, d being the difference between the mean of all samples of a pixel and that of
/// their first half (Film::Halves()). Of independent samples this is the standard error; of others it is
/// more, for halves are not as well distributed as the whole. The film keeps halves, each pixel has as many
/// samples in either, and no splats. Cost: that of developing the film.
double NoiseLevel(const Film& film);

}  // namespace lacquer
