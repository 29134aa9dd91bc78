// The best parameters by a posterior that is cheap and smooth: that of an emulator.
#pragma once

#include "estimate/infer/target.h"
#include "estimate/parameters.h"

namespace lacquer::estimate {

/// The most probable parameters, in natural units and as the density of these has it (not that of logits),
/// which does not depend on the transform: the best of several climbs by L-BFGS.
/// @param starts  logits, a column for each climb
Vector FindMode(const ParameterSpace& space, const Target& target, const Matrix& starts);

}  // namespace lacquer::estimate
