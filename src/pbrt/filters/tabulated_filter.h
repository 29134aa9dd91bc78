// Filters that are products of two functions of one variable, drawn from by tables.
#pragma once

#include <memory>
#include <vector>

#include "pbrt/core/sampling.h"
#include "pbrt/filters/filter_params.h"

namespace lacquer {

/// f(x, y) = profileX(x) profileY(y). Samples follow the absolute value of the piecewise constant function
/// that has the values of f at the centres of int(32 r) equal cells along [-r, r]; since f is a product, so
/// is their density, and a table for each axis is all it takes. Integral() is that of the piecewise constant
/// function.
/// @tparam Profile  callable, float(float offset), 0 beyond the radius
template <class Profile>
class TabulatedFilter final : public Filter {
  public:
    TabulatedFilter(Vec2 radius, Profile profileX, Profile profileY)
        : radius_(radius),
          profileX_(profileX),
          profileY_(profileY),
          x_(profileX, radius.x),
          y_(profileY, radius.y) {}

    Vec2 Radius() const override { return radius_; }
    float Evaluate(Point2 offset) const override { return profileX_(offset.x) * profileY_(offset.y); }
    float Integral() const override { return x_.integral * y_.integral; }
    /// Integral of |f|: the absolute weight of every sample.
    float AbsoluteIntegral() const { return x_.magnitude.Integral() * y_.magnitude.Integral(); }
    FilterSample Sample(Point2 u) const override {
        int cellX, cellY;
        const float x = x_.magnitude.Sample(u.x, nullptr, &cellX),
                    y = y_.magnitude.Sample(u.y, nullptr, &cellY);
        const bool isNegative = x_.isNegative[size_t(cellX)] != y_.isNegative[size_t(cellY)];
        return {{x, y}, isNegative ? -AbsoluteIntegral() : AbsoluteIntegral()};
    }

  private:
    struct Axis {
        Axis(const Profile& profile, float radius) {
            const int count = std::max(1, int(32 * radius));
            const float width = 2 * radius / float(count);
            std::vector<float> magnitudes;
            double sum = 0;
            for (int i = 0; i < count; ++i) {
                const float value = profile((float(i) + 0.5f) * width - radius);
                magnitudes.push_back(std::abs(value));
                isNegative.push_back(value < 0);
                sum += double(value);
            }
            magnitude = PiecewiseConstant1D(magnitudes, -radius, radius);
            integral = float(sum * double(width));
        }
        PiecewiseConstant1D magnitude;
        std::vector<unsigned char> isNegative;
        float integral = 0;
    };

    Vec2 radius_;
    Profile profileX_, profileY_;
    Axis x_, y_;
};

/// The filter, once it is known that it can be drawn from.
/// Errors: SceneError at `parameter` if the function vanishes or overflows on its cells.
template <class Profile>
std::unique_ptr<Filter> MakeTabulatedFilter(const Params& params, const char* parameter, Vec2 radius,
                                            Profile profileX, Profile profileY) {
    auto filter = std::make_unique<TabulatedFilter<Profile>>(radius, profileX, profileY);
    const float weight = filter->AbsoluteIntegral();
    if (!std::isnormal(weight) || !std::isfinite(filter->Integral()))
        params.Fail(parameter, "the filter is zero or infinite everywhere with this value");
    return filter;
}

}  // namespace lacquer
