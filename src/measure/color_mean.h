// Means of colours with their errors.
#pragma once

#include <cstdint>

#include "pbrt/core/vec.h"

namespace lacquer::measure {

/// Luminance of linear sRGB.
inline double Luminance(glm::dvec3 rgb) { return 0.212639 * rgb.x + 0.715169 * rgb.y + 0.072192 * rgb.z; }

/// Mean of colours and of their luminance, with standard errors.
class ColorMean {
  public:
    void Add(glm::dvec3 rgb);
    void Merge(const ColorMean& other);
    int64_t Count() const { return count_; }
    glm::dvec3 Mean() const { return glm::dvec3(Component(0), Component(1), Component(2)); }
    glm::dvec3 Error() const { return {ErrorOf(0), ErrorOf(1), ErrorOf(2)}; }
    double Luminance() const { return Component(3); }
    double LuminanceError() const { return ErrorOf(3); }

  private:
    double Component(int c) const { return count_ > 0 ? sum_[c] / double(count_) : 0; }
    double ErrorOf(int c) const;
    int64_t count_ = 0;
    glm::dvec4 sum_{0}, squares_{0};  ///< R, G, B, luminance
};

}  // namespace lacquer::measure
