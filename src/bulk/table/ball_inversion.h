// From a ball of a medium, in which light is scattered several times, to the medium.
#pragma once

#include <span>
#include <vector>

#include "bulk/averages/scattering_sums.h"

namespace lacquer::bulk {

/// What a ball does with the light that falls on it, beside its mean field: shares of that light, with
/// standard errors.
struct BallLosses {
    ScatteringAverage::Value scattered, absorbed;
    double Sum() const { return scattered.mean + absorbed.mean; }
};

/// A medium, by a ball of it.
struct MediumOfBall {
    /// Optical thicknesses of the ball across its middle: its diameter times sigma_s and sigma_a. Errors are
    /// as large as they are if those of the losses help each other.
    ScatteringAverage::Value scattering, absorption;
    std::vector<double> phase;  ///< p at the angles of the ball's; integrates to 1
    double single = 1;          ///< of the light that the ball scatters, the share that it scatters once
};

/// Of the light that falls on a ball, what its mean field loses.
/// @param thickness  sigma_t times the diameter
double LostShare(double thickness);
/// Largest LostShare() that InvertBall() takes: beyond, so little light gets through that the thickness is
/// not known.
inline constexpr double kLargestLostShare = 0.97;

/// The medium that makes a ball scatter and absorb these shares, with light on straight rays and without
/// phases between events (radiative transfer): for balls much larger than the wavelength. Random walks with
/// seeds of their own, the same bits each time; a few tenths of a second.
/// @param losses  scattered > 0, absorbed >= 0, together at most kLargestLostShare
/// @param angles  [degrees], growing from 0 to 180   @param phase  of the light that leaves the ball; linear
/// in
///                the cosine between angles, integrates to 1
MediumOfBall InvertBall(const BallLosses& losses, std::span<const double> angles,
                        std::span<const double> phase);

}  // namespace lacquer::bulk
