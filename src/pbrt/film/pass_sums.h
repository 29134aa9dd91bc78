// Passes of the pixels of a film: parts of their light, summed as colours are.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pbrt/core/vec.h"
#include "pbrt/film/exact_sums.h"

namespace lacquer {

class Image;

/// Three sums for each pass and pixel: 51 bytes.
class PassSums {
  public:
    /// Bytes that all passes together may take.
    static constexpr size_t kMaxBytes = size_t(8) << 30;

    /// Errors: OverrideError beyond kMaxBytes.
    void Prepare(std::vector<std::string> layers, size_t numPixels);
    void Add(size_t pixel, size_t pass, Vec3 response, double weight) {
        const size_t first = FirstOf(pixel, pass);
        for (int c = 0; c < 3; ++c) sums_.Add(first + size_t(c), weight * double(response[c]));
    }
    size_t NumPasses() const { return layers_.size(); }
    size_t Bytes() const { return sums_.Bytes(); }
    ExactSums& Sums() { return sums_; }
    const std::vector<std::string>& Layers() const { return layers_; }
    glm::dvec3 Sum(size_t pixel, size_t pass) const {
        const size_t first = FirstOf(pixel, pass);
        return {sums_[first], sums_[first + 1], sums_[first + 2]};
    }

  private:
    size_t FirstOf(size_t pixel, size_t pass) const { return 3 * (pixel * layers_.size() + pass); }

    std::vector<std::string> layers_;
    ExactSums sums_;  ///< [pixel][pass][component]
};

}  // namespace lacquer
