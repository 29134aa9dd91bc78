// Pixel filter "triangle": the product of two tents.
//
//   "float xradius", "float yradius"  2, 2  half width and half height of the support, in (0, 64] [pixels]
#include "pbrt/core/sampling.h"
#include "pbrt/filters/filter_params.h"

namespace lacquer {

namespace {

class TriangleFilter final : public Filter {
  public:
    explicit TriangleFilter(Vec2 radius) : radius_(radius) {}
    Vec2 Radius() const override { return radius_; }
    float Evaluate(Point2 offset) const override {
        return std::max(0.f, radius_.x - std::abs(offset.x)) * std::max(0.f, radius_.y - std::abs(offset.y));
    }
    float Integral() const override { return Sqr(radius_.x) * Sqr(radius_.y); }
    FilterSample Sample(Point2 u) const override {
        return {{SampleTent(u.x, radius_.x), SampleTent(u.y, radius_.y)}, Integral()};
    }

  private:
    Vec2 radius_;
};

std::unique_ptr<Filter> CreateTriangle(const Params& params) {
    return std::make_unique<TriangleFilter>(ReadFilterRadius(params, 2));
}

}  // namespace

LACQUER_REGISTER(FilterKind, "triangle", CreateTriangle);

}  // namespace lacquer
