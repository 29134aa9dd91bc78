#include "compare/color_map.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"
#include "pbrt/core/embedded.h"

namespace lacquer::compare {

Image ColoredErrors(const std::vector<float>& errors, Int2 resolution, float largest) {
    LACQUER_CHECK(errors.size() == size_t(resolution.x) * size_t(resolution.y));
    const std::vector<std::vector<double>> colors = EmbeddedTable("colormaps/magma.txt");
    const std::array<float, 256> linear = ColorEncoding{ColorEncoding::Kind::SRGB, 1}.ByteTable();
    Image image(resolution, {"R", "G", "B"});
    for (size_t i = 0; i < errors.size(); ++i) {
        const float share = largest > 0 ? std::min(errors[i] / largest, 1.f) : 0;
        const bool isFinite = std::isfinite(errors[i]);
        const auto& color = colors[isFinite ? size_t(std::lround(255 * std::max(share, 0.f))) : 0];
        for (size_t c = 0; c < 3; ++c)
            image.Pixels()[3 * i + c] = isFinite ? linear[size_t(color[c])] : c == 1 ? 1.f : 0.f;
    }
    return image;
}

}  // namespace lacquer::compare
