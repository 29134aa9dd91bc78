// The shape of a lens's stop where it is not round.
#pragma once

#include "pbrt/image/image.h"

namespace lacquer {

/// What a stop lets through, as an image over the square around it; 1 on average over a round stop's area, so
/// that the exposure is that of a round stop.
class ApertureMask {
  public:
    /// A shape of the format: "gaussian", "square", "pentagon" or "star"; empty for other names.
    static std::optional<ApertureMask> Named(const std::string& name);
    /// The mean of an image's channels; its upper edge lies in +y.
    /// Errors: std::invalid_argument for an image with negative or infinite values, or without any light.
    explicit ApertureMask(const Image& image);
    static const std::vector<std::string>& Names();

    /// Weight at a point of the stop, in units of its radius from its centre; 0 outside of the square.
    float At(Point2 p) const { return values_.Bilinear({(p.x + 1) / 2, (1 - p.y) / 2}, 0, WrapMode::Black); }
    /// Largest distance from the centre of a point with weight, in units of the stop's radius.
    float Extent() const { return extent_; }

  private:
    Image values_;
    float extent_ = 0;
};

}  // namespace lacquer
