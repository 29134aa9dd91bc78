// Reflectances as the likelihood sees them: logarithms that end at a floor.
#pragma once

#include "estimate/emulator/runs.h"
#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// What was measured, ready for a likelihood.
struct ObservedLobes {
    Vector logs;
    Vector deviations;  ///< of the logarithms, beside the noise that is estimated; 0 where not known
    double floor = 0;   ///< [unit of the values]
};

/// Part of the peak below which values tell nothing: goniometers have straylight and offsets.
inline constexpr double kFloorOfPeak = 1e-3;

/// log sqrt(f^2 + floor^2): f where it is above the floor, and the floor below it, without a kink.
Vector FlooredLogs(const Vector& values, double floor);
/// Standard errors of the same, from those of the values.
Vector FlooredErrors(const Vector& values, const Vector& errors, double floor);

/// @param values              positive
/// @param relativeDeviations  of them, 0 where not known
/// @param floor               0: kFloorOfPeak of the largest value
ObservedLobes ObserveLobes(const Vector& values, const Vector& relativeDeviations, double floor = 0);

/// Simulations of reflectances: each row of `runs` has all values, then their standard errors.
struct LobeRuns {
    Matrix values, errors;  ///< of logarithms: a row for each simulation
};
/// Logarithms of unbiased estimates are too small by half their variance, which is put back.
LobeRuns LogsOf(const Runs& runs, double floor);

}  // namespace lacquer::estimate
