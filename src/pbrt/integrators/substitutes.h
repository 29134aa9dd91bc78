// "volpath" in the place of another integrator.
#pragma once

#include <string>

#include "pbrt/base/integrator.h"

namespace lacquer {

/// "volpath" with the parameters that it has in common with the one that was asked for.
/// @param why  for the warning: 'integrator "mlt" is not in Lacquer'
/// Errors: SceneError with `why` unless IntegratorArgs::mayBeReplaced.
std::unique_ptr<Integrator> VolPathInstead(const IntegratorArgs& args, const std::string& why);

}  // namespace lacquer
