// Pixel filter "box": constant over its support.
//
//   "float xradius", "float yradius"  0.5, 0.5  half width and half height of the support, in (0, 64]
//                                               [pixels]
#include "pbrt/filters/filter_params.h"

namespace lacquer {

namespace {

class BoxFilter final : public Filter {
  public:
    explicit BoxFilter(Vec2 radius) : radius_(radius) {}
    Vec2 Radius() const override { return radius_; }
    float Evaluate(Point2 offset) const override {
        return std::abs(offset.x) <= radius_.x && std::abs(offset.y) <= radius_.y ? 1.f : 0.f;
    }
    float Integral() const override { return 4 * radius_.x * radius_.y; }
    FilterSample Sample(Point2 u) const override { return {(2.f * u - Point2(1, 1)) * radius_, Integral()}; }

  private:
    Vec2 radius_;
};

std::unique_ptr<Filter> CreateBox(const Params& params) {
    return std::make_unique<BoxFilter>(ReadFilterRadius(params, 0.5f));
}

}  // namespace

LACQUER_REGISTER(FilterKind, "box", CreateBox);

}  // namespace lacquer
