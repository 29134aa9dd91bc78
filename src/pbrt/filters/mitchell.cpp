// Pixel filter "mitchell": piecewise cubic [Mitchell and Netravali 1988].
//
//   "float xradius", "float yradius"  2, 2      half width and half height of the support, in (0, 64]
//                                               [pixels]
//   "float B", "float C"              1/3, 1/3  its two parameters
#include "pbrt/filters/tabulated_filter.h"

namespace lacquer {

namespace {

/// The cubic on [-2, 2], stretched to the radius [Mitchell and Netravali 1988, eq. 8].
struct MitchellProfile {
    float b, c, radius;
    float operator()(float offset) const {
        const float x = std::abs(2 * offset / radius);
        if (!(x < 2)) return 0;
        if (x > 1)
            return (((-b - 6 * c) * x + (6 * b + 30 * c)) * x * x + (-12 * b - 48 * c) * x +
                    (8 * b + 24 * c)) /
                   6;
        return (((12 - 9 * b - 6 * c) * x + (-18 + 12 * b + 6 * c)) * x * x + (6 - 2 * b)) / 6;
    }
};

std::unique_ptr<Filter> CreateMitchell(const Params& params) {
    constexpr float kMaxCoefficient = 1e3f;
    const Vec2 radius = ReadFilterRadius(params, 2);
    const float b = params.GetFloatInRange("B", 1.f / 3, -kMaxCoefficient, kMaxCoefficient);
    const float c = params.GetFloatInRange("C", 1.f / 3, -kMaxCoefficient, kMaxCoefficient);
    return MakeTabulatedFilter(params, "B", radius, MitchellProfile{b, c, radius.x},
                               MitchellProfile{b, c, radius.y});
}

}  // namespace

LACQUER_REGISTER(FilterKind, "mitchell", CreateMitchell);

}  // namespace lacquer
