#include "pbrt/scene/planned.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace lacquer {

bool IsPlanned(std::string_view kind, std::string_view name) {
    static constexpr std::pair<std::string_view, std::string_view> kPlanned[]{
        {"camera", "realistic"},
        {"film", "gbuffer"},
        {"film", "spectral"},
        {"sampler", "pmj02bn"},
        {"material", "hair"},
        {"material", "measured"},
        {"material", "subsurface"},
        {"float texture", "ptex"},
        {"spectrum texture", "ptex"},
        {"shape", "curve"},
        {"medium", "uniformgrid"},
        {"medium", "rgbgrid"},
        {"medium", "cloud"},
        {"medium", "nanovdb"},
    };
    return std::find(std::begin(kPlanned), std::end(kPlanned), std::pair(kind, name)) != std::end(kPlanned);
}

}  // namespace lacquer
