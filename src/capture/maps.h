// The maps of a sample: nine numbers for each texel.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lacquer::capture {

/// Channels of the maps in the order of [Guo et al. 2020b]: albedo, x and y of the normal, roughness,
/// specular albedo. All are stored in [-1,1]; what they stand for is in svbrdf_model.h.
inline constexpr size_t kNumChannels = 9;
inline constexpr size_t kAlbedo = 0, kNormal = 3, kRoughness = 5, kSpecular = 6;

/// A square of texels, each channel together; rows from the top (from large y).
struct Maps {
    int size = 0;  ///< texels along an edge
    std::vector<double> values;

    Maps() = default;
    /// @param n  above 0
    explicit Maps(int n);
    size_t NumTexels() const { return size_t(size) * size_t(size); }
    std::span<double> Channel(size_t c) { return std::span(values).subspan(c * NumTexels(), NumTexels()); }
    std::span<const double> Channel(size_t c) const {
        return std::span(values).subspan(c * NumTexels(), NumTexels());
    }
};

}  // namespace lacquer::capture
