// Passes of the pixels of a film: parts of their light, summed as colours are.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

class Image;

/// Three doubles for each pass and pixel.
class PassSums {
  public:
    /// Bytes that all passes together may take.
    static constexpr size_t kMaxBytes = size_t(4) << 30;

    /// Errors: OverrideError beyond kMaxBytes.
    void Prepare(std::vector<std::string> layers, size_t numPixels);
    void Add(size_t pixel, size_t pass, Vec3 response, double weight) {
        double* const sum = &sums_[3 * (pixel * layers_.size() + pass)];
        for (int c = 0; c < 3; ++c) sum[c] += weight * double(response[c]);
    }
    size_t NumPasses() const { return layers_.size(); }
    size_t Bytes() const { return sums_.size() * sizeof(double); }
    const std::vector<std::string>& Layers() const { return layers_; }
    glm::dvec3 Sum(size_t pixel, size_t pass) const {
        const double* const sum = &sums_[3 * (pixel * layers_.size() + pass)];
        return {sum[0], sum[1], sum[2]};
    }

  private:
    std::vector<std::string> layers_;
    std::vector<double> sums_;  ///< [pixel][pass][component]
};

}  // namespace lacquer
