// How much noise an image has, as one number: where a render may stop.
#pragma once

#include <vector>

#include "pbrt/base/film.h"

namespace lacquer {

/// For each pixel value^2 + e^2, by which its squared errors are divided: value^2 is the mean over the
/// channels of the squared mean of 4 x 4 pixels, and e a quarter of the image's mean, below which the eye
/// sees errors as such and not as parts of a value.
std::vector<double> SquaredScales(Int2 size, const std::vector<RGB>& values);

/// The relative standard error that 95 % of the pixels are below. That of a pixel is the root of the
/// mean over 8 x 8 pixels around it, and over the channels, of d^2 / (value^2 + e^2), as of SquaredScales(),
/// d being the difference between the mean of all samples of a pixel and that of their first half
/// (Film::Halves()). Of independent samples this is the standard error; of others it is more, for halves are
/// not as well distributed as the whole. The film keeps halves, each pixel has as many samples in either, and
/// no splats. Cost: that of developing the film.
double NoiseLevel(const Film& film);

}  // namespace lacquer
