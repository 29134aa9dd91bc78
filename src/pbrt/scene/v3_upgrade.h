// From pbrt-v3 scene files to pbrt-v4's.
#pragma once

#include <vector>

#include "pbrt/core/error.h"
#include "pbrt/scene/statements.h"

namespace lacquer {

/// Rewrites the names, types and values of pbrt-v3 in place; what is spelled as in pbrt-v4 stays. The text is
/// taken as pbrt-v3: where a default is another one in pbrt-v4, it is written out.
/// @return  with their places: errors for what stays because nothing in pbrt-v4 is the same,
///          warnings for what was left out or will look different
std::vector<Diagnostic> UpgradeFromV3(SceneText* scene);

}  // namespace lacquer
