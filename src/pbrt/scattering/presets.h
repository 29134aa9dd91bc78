// Measured scattering of milk, marble, skin and others, by name.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

/// Coefficients of a medium [1/mm], as unbounded linear sRGB. What was measured is the reduced scattering
/// sigma_s (1 - g): whoever uses it scatters isotropically.
struct ScatteringPreset {
    RGB reducedSigma_s{0};
    RGB sigma_a{0};
};

/// The preset of that name (case matters), or empty. Read from data/scattering/presets.txt at the first call;
/// thread-safe. Sources: [Jensen et al. 2001] fig. 5, [Narasimhan et al. 2006].
std::optional<ScatteringPreset> FindScatteringPreset(std::string_view name);
/// All names, in the order of the file.
std::vector<std::string> ScatteringPresetNames();

}  // namespace lacquer
