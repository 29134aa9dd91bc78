// Filters that are products of two functions of one variable, drawn from by tables.
#pragma once

#include <memory>
#include <vector>

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
    float AbsoluteIntegral() const { return x_.absoluteIntegral * y_.absoluteIntegral; }
    FilterSample Sample(Point2 u) const override {
        const Cell &x = x_.CellAt(u.x), &y = y_.CellAt(u.y);
        const float weight = AbsoluteIntegral();
        return {{x.Sample(u.x, radius_.x), y.Sample(u.y, radius_.y)},
                x.isNegative != y.isNegative ? -weight : weight};
    }

  private:
    /// Where the function is the same, and which numbers lead there.
    struct Cell {
        float u = 0;       ///< the first of them
        float offset = 0;  ///< that this one leads to
        float perU = 0;
        bool isNegative = false;
        float Sample(float number, float radius) const {
            return std::min(offset + (number - u) * perU, radius);
        }
    };
    /// PiecewiseConstant1D does the same and sees to it that rounding leaves every offset in its cell, which
    /// only those who ask for its density need. Each sample of an image draws two offsets.
    struct Axis {
        Axis(const Profile& profile, float radius) {
            const int count = std::max(1, int(32 * radius));
            const float width = 2 * radius / float(count);
            std::vector<float> values;
            double sum = 0, absoluteSum = 0;
            for (int i = 0; i < count; ++i) {
                values.push_back(profile((float(i) + 0.5f) * width - radius));
                sum += double(values.back());
                absoluteSum += double(std::abs(values.back()));
            }
            integral = float(sum * double(width));
            absoluteIntegral = float(absoluteSum * double(width));
            constexpr double kSmallest = 1e-9;  // smaller shares would be met by 0 alone, or by no number
            double below = 0;
            for (int i = 0; i < count; ++i) {
                double share = double(std::abs(values[size_t(i)])) / absoluteSum;
                if (!(share > kSmallest)) share = 0;
                cells.push_back({float(below), float(i) * width - radius,
                                 share > 0 ? float(double(width) / share) : 0.f, values[size_t(i)] < 0});
                below += share;
            }
            // No number is as large, whatever the sums have rounded to.
            cells.push_back({.u = 1});
            for (int k = 0, i = 0; k < count; ++k) {
                while (i + 1 < count && cells[size_t(i) + 1].u <= float(k) / float(count)) ++i;
                guide.push_back(i);
            }
        }
        const Cell& CellAt(float u) const {
            auto i = size_t(guide[std::min(size_t(u * float(guide.size())), guide.size() - 1)]);
            while (cells[i + 1].u <= u) ++i;
            return cells[i];
        }
        std::vector<Cell> cells;
        std::vector<int> guide;  ///< cell at u = k/size
        float integral = 0, absoluteIntegral = 0;
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
