// Filter "example": of all positions the centre.
// Stands in src/pbrt/filters. Scene: PixelFilter "example"
#include "pbrt/filters/filter_params.h"

namespace lacquer {
namespace {

class Example final : public Filter {
  public:
    Vec2 Radius() const override { return Vec2(0.5f); }
    float Evaluate(Point2) const override { return 1; }
    float Integral() const override { return 1; }
    FilterSample Sample(Point2) const override { return {Point2(0), 1}; }
};

std::unique_ptr<Filter> Create(const Params&) { return std::make_unique<Example>(); }

}  // namespace

LACQUER_REGISTER(FilterKind, "example", Create);

}  // namespace lacquer
