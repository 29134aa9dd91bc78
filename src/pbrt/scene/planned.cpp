#include "pbrt/scene/planned.h"

#include <algorithm>
#include <array>
#include <utility>

namespace lacquer {

bool IsPlanned(std::string_view kind, std::string_view name) {
    static constexpr auto kPlanned = std::to_array<std::pair<std::string_view, std::string_view>>({
        {"film", "gbuffer"},
        {"float texture", "ptex"},
        {"spectrum texture", "ptex"},
        {"medium", "uniformgrid"},
        {"medium", "rgbgrid"},
        {"medium", "cloud"},
        {"medium", "nanovdb"},
    });
    return std::find(kPlanned.begin(), kPlanned.end(), std::pair(kind, name)) != kPlanned.end();
}

}  // namespace lacquer
