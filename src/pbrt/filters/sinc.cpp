// The ideal low-pass filter under a Lanczos window.
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
