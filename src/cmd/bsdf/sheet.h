// The contact sheet: all plots of a material beside each other.
#pragma once

#include "measure/bsdf_result.h"
#include "pbrt/image/image.h"

namespace lacquer::cmd {

/// Lobes in a logarithmic colour scale, their differences from the histogram of samples, densities, sections,
/// albedo and a table. Linear sRGB.
Image MakeSheet(const measure::BsdfResult& result);
/// The lobes of one estimator and their differences, on the scales of the sheet. @param estimator  its index
Image MakeLobeImage(const measure::BsdfResult& result, size_t estimator);

}  // namespace lacquer::cmd
