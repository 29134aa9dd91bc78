// Pixel filter "gaussian": a Gaussian minus its value at the radius, so that it ends at zero.
//
//   "float xradius", "float yradius"  1.5, 1.5  half width and half height of the support, in (0, 64]
//                                               [pixels]
//   "float sigma"                     0.5       standard deviation, in [1e-6, 1e3] [pixels]
#include "pbrt/filters/tabulated_filter.h"

namespace lacquer {

namespace {

/// Normalised Gaussian density of standard deviation sigma, minus its value at the radius.
struct GaussianProfile {
    double sigma, radius;
    float operator()(float offset) const {
        const double t = double(offset);
        if (!(std::abs(t) < radius)) return 0;
        // G(t) - G(r) = G(t) (1 - exp((t^2 - r^2) / 2 sigma^2)) keeps its digits for wide Gaussians.
        const double density = std::exp(-t * t / (2 * sigma * sigma)) / (sigma * std::sqrt(2 * double(Pi)));
        return float(-density * std::expm1((t * t - radius * radius) / (2 * sigma * sigma)));
    }
};

std::unique_ptr<Filter> CreateGaussian(const Params& params) {
    const Vec2 radius = ReadFilterRadius(params, 1.5f);
    const auto sigma = double(ReadFilterWidth(params, "sigma", 0.5f));
    return MakeTabulatedFilter(params, "sigma", radius, GaussianProfile{sigma, double(radius.x)},
                               GaussianProfile{sigma, double(radius.y)});
}

}  // namespace

LACQUER_REGISTER(FilterKind, "gaussian", CreateGaussian);

}  // namespace lacquer
