#include "pbrt/scene/planned.h"

#include <algorithm>
#include <array>
#include <utility>

namespace lacquer {

bool IsPlanned(std::string_view kind, std::string_view name) {
    // All of the format is there.
    static constexpr std::array<std::pair<std::string_view, std::string_view>, 0> kPlanned{};
    return std::find(kPlanned.begin(), kPlanned.end(), std::pair(kind, name)) != kPlanned.end();
}

}  // namespace lacquer
