// Pixel filter "sinc": the ideal low-pass filter under a Lanczos window.
//
//   "float xradius", "float yradius"  4, 4  half width and half height of the support, in (0, 64] [pixels]
//   "float tau"                       3     half width of the window in periods of the sinc, in [1e-6, 1e3]
#include "pbrt/filters/tabulated_filter.h"

namespace lacquer {

namespace {

/// sinc(t) sinc(t / tau) with sinc(u) = sin(pi u) / (pi u).
struct SincProfile {
    float tau, radius;
    float operator()(float offset) const {
        if (!(std::abs(offset) < radius)) return 0;
        return SinXOverX(Pi * offset) * SinXOverX(Pi * offset / tau);
    }
};

std::unique_ptr<Filter> CreateSinc(const Params& params) {
    const Vec2 radius = ReadFilterRadius(params, 4);
    const float tau = ReadFilterWidth(params, "tau", 3);
    return MakeTabulatedFilter(params, "tau", radius, SincProfile{tau, radius.x}, SincProfile{tau, radius.y});
}

}  // namespace

LACQUER_REGISTER(FilterKind, "sinc", CreateSinc);

}  // namespace lacquer
