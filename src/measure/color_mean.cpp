#include "measure/color_mean.h"

#include <algorithm>
#include <cmath>

namespace lacquer::measure {

void ColorMean::Add(glm::dvec3 rgb) {
    const glm::dvec4 v(rgb, measure::Luminance(rgb));
    ++count_;
    sum_ += v;
    squares_ += v * v;
}

void ColorMean::Merge(const ColorMean& other) {
    count_ += other.count_;
    sum_ += other.sum_;
    squares_ += other.squares_;
}

double ColorMean::ErrorOf(int c) const {
    if (count_ < 2) return 0;
    const double n = double(count_), mean = sum_[c] / n;
    return std::sqrt(std::max(0.0, squares_[c] / n - mean * mean) / (n - 1));
}

}  // namespace lacquer::measure
