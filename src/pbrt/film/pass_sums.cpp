#include "pbrt/film/pass_sums.h"

#include <fmt/format.h>

#include "pbrt/base/film.h"

namespace lacquer {

void PassSums::Prepare(std::vector<std::string> layers, size_t numPixels) {
    const size_t bytes = layers.size() * numPixels * 3 * sizeof(double);
    if (bytes > kMaxBytes)
        throw OverrideError(fmt::format(
            "{} passes of {} pixels take {} MB, more than the {} that are possible; render crop windows",
            layers.size(), numPixels, bytes >> 20, kMaxBytes >> 20));
    layers_ = std::move(layers);
    sums_.assign(bytes / sizeof(double), 0);
}

}  // namespace lacquer
