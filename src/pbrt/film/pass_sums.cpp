#include "pbrt/film/pass_sums.h"

#include <fmt/format.h>

#include "pbrt/base/film.h"

namespace lacquer {

namespace {
constexpr size_t kBytesOfPass = 51;
}  // namespace

void PassSums::Prepare(std::vector<std::string> layers, size_t numPixels) {
    const size_t bytes = layers.size() * numPixels * kBytesOfPass;
    if (bytes > kMaxBytes)
        throw OverrideError(fmt::format(
            "{} passes of {} pixels take {} MB, more than the {} that are possible; render crop windows",
            layers.size(), numPixels, bytes >> 20, kMaxBytes >> 20));
    layers_ = std::move(layers);
    sums_ = ExactSums(3 * layers_.size() * numPixels);
}

}  // namespace lacquer
