// Transforms that something depends on.
#pragma once

#include <fmt/format.h>

#include "pbrt/core/params.h"
#include "pbrt/core/transform.h"

namespace lacquer {

/// For plugins that use the transform of their directive; others do not mind a singular one. Errors:
/// SceneError at the directive if it has no inverse.
inline void RequireInvertible(const Params& params, const Transform& transform) {
    if (transform.IsSingular())
        throw SceneError(params.Loc(),
                         fmt::format("{}: the current transformation is singular: it has no inverse within "
                                     "the range of floats",
                                     params.Owner()));
}

}  // namespace lacquer
