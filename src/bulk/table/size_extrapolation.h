// From balls of several sizes to a medium without a surface.
#pragma once

#include <span>
#include <vector>

#include "bulk/averages/scattering_sums.h"
#include "bulk/table/bulk_computation.h"

namespace lacquer::bulk {

/// Particles at the surface of a ball have fewer neighbours, so what a ball gives differs from what the
/// medium would by a part that goes as 1/R.
/// @param radii   of the balls, at least two, all different    @param values  means with standard errors
/// @return  the value at 1/R = 0 of the straight line through them by least squares, each weighted with its
/// error, and its standard error: larger where the line does not pass within the errors
ScatteringAverage::Value ExtrapolateInSize(std::span<const double> radii,
                                           std::span<const ScatteringAverage::Value> values);

/// Coefficients [1/mm] and g of a ball, or of the medium, at each wavelength.
struct SizeResult {
    int count = 0;          ///< mean number of particles; 0: extrapolated
    double ballRadius = 0;  ///< [um]
    std::vector<ScatteringAverage::Value> sigmaS, sigmaA, g;
};
/// @param rows  Rows() of the computation
SizeResult ResultOf(const BulkComputation& computation, std::span<const BulkRow> rows);
SizeResult Extrapolate(std::span<const SizeResult> sizes);

}  // namespace lacquer::bulk
