// Materials made matte: the option "forcediffuse".
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "pbrt/base/material.h"

namespace lacquer {

/// From materials to their matte counterparts.
using MatteCounterparts = std::unordered_map<const Material*, const Material*>;

/// Appends to `materials` a matte counterpart of each (ForcedDiffuseBxDF); the interface material has none.
/// They bump as the originals do, let no light through, and stand for them as surfaces only: the originals
/// must live on.
std::shared_ptr<const MatteCounterparts> AddMatteCounterparts(
    std::vector<std::unique_ptr<Material>>* materials);

}  // namespace lacquer
