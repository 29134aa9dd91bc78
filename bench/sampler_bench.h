// The ways to draw visible Beckmann normals, side by side.
#pragma once

namespace lacquer::bench {

/// Prints the time of each way and checks the moments of what it draws, for several alphas and angles.
/// @param seconds  of each way in each row. False if a moment is off by more than 5 standard errors.
bool RunSamplerBench(double seconds);

}  // namespace lacquer::bench
