// Pixel reconstruction filters, drawn from instead of splatted.
#pragma once

#include <memory>

#include "pbrt/core/params.h"
#include "pbrt/core/registry.h"

namespace lacquer {

/// Offset from the pixel centre and the weight f/pdf of a sample there (constant but for its sign).
struct FilterSample {
    Point2 offset{0};
    float weight = 1;
};

class Filter {
  public:
    virtual ~Filter() = default;
    /// Half extent of the support [pixels].
    virtual Vec2 Radius() const = 0;
    virtual float Evaluate(Point2 offset) const = 0;
    /// Integral over the support.
    virtual float Integral() const = 0;
    /// An offset distributed as |f|.
    virtual FilterSample Sample(Point2 u) const = 0;
};

struct FilterKind {
    static constexpr const char* kKind = "pixel filter";
    using Factory = std::unique_ptr<Filter> (*)(const Params&);
};

}  // namespace lacquer
