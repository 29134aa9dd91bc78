#include "pbrt/scene/planned.h"

#include <algorithm>
#include <array>
#include <utility>

namespace lacquer {

bool IsPlanned(std::string_view kind, std::string_view name) {
    static constexpr std::array<std::pair<std::string_view, std::string_view>, 16> kPlanned{{
        {"camera", "realistic"},
        {"film", "gbuffer"},
        {"film", "spectral"},
        {"sampler", "pmj02bn"},
        {"integrator", "ambientocclusion"},
        {"integrator", "bdpt"},
        {"integrator", "function"},
        {"integrator", "lightpath"},
        {"integrator", "mlt"},
        {"integrator", "sppm"},
        {"material", "hair"},
        {"material", "measured"},
        {"material", "subsurface"},
        {"float texture", "ptex"},
        {"spectrum texture", "ptex"},
        {"shape", "curve"},
    }};
    return std::find(kPlanned.begin(), kPlanned.end(), std::pair(kind, name)) != kPlanned.end();
}

}  // namespace lacquer
