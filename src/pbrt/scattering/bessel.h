// Modified Bessel functions.
#pragma once

#include "pbrt/core/math.h"

namespace lacquer {

/// exp(-x) I0(x) for x >= 0, finite for all x; relative error below 1e-6. Source: the polynomials of
/// [Abramowitz and Stegun 1964, 9.8.1 and 9.8.2].
inline float BesselI0Scaled(float x) {
    constexpr float kBorder = 3.75f;
    if (x < kBorder) {
        const float t = Sqr(x / kBorder);
        const float i0 =
            1 +
            t * (3.5156229f +
                 t * (3.0899424f + t * (1.2067492f + t * (0.2659732f + t * (0.0360768f + t * 0.0045813f)))));
        return i0 * Exp(-x);
    }
    const float t = kBorder / x;
    const float p =
        0.39894228f +
        t * (0.01328592f +
             t * (0.00225319f +
                  t * (-0.00157565f +
                       t * (0.00916281f +
                            t * (-0.02057706f + t * (0.02635537f + t * (-0.01647633f + t * 0.00392377f)))))));
    return p / std::sqrt(x);
}

}  // namespace lacquer
