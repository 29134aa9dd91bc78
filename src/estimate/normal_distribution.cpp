#include "estimate/normal_distribution.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace lacquer::estimate {

namespace {

/// Ratio of two polynomials of degree 7, coefficients from the constant term on.
double Ratio(const double (&top)[8], const double (&bottom)[8], double x) {
    double a = top[7], b = bottom[7];
    for (int i = 6; i >= 0; --i) {
        a = a * x + top[i];
        b = b * x + bottom[i];
    }
    return a / b;
}

// [Wichura 1988]: the middle, the flanks and the tails.
constexpr double kMiddleTop[8] = {3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3,
                                  1.3731693765509461125e4, 4.5921953931549871457e4, 6.7265770927008700853e4,
                                  3.3430575583588128105e4, 2.5090809287301226727e3};
constexpr double kMiddleBottom[8] = {1.0,
                                     4.2313330701600911252e1,
                                     6.8718700749205790830e2,
                                     5.3941960214247511077e3,
                                     2.1213794301586595867e4,
                                     3.9307895800092710610e4,
                                     2.8729085735721942674e4,
                                     5.2264952788528545610e3};
constexpr double kFlankTop[8] = {1.42343711074968357734e0,  4.63033784615654529590e0,
                                 5.76949722146069140550e0,  3.64784832476320460504e0,
                                 1.27045825245236838258e0,  2.41780725177450611770e-1,
                                 2.27238449892691845833e-2, 7.74545014278341407640e-4};
constexpr double kFlankBottom[8] = {1.0,
                                    2.05319162663775882187e0,
                                    1.67638483018380384940e0,
                                    6.89767334985100004550e-1,
                                    1.48103976427480074590e-1,
                                    1.51986665636164571966e-2,
                                    5.47593808499534494600e-4,
                                    1.05075007164441684324e-9};
constexpr double kTailTop[8] = {6.65790464350110377720e0,  5.46378491116411436990e0,
                                1.78482653991729133580e0,  2.96560571828504891230e-1,
                                2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                2.71155556874348757815e-5, 2.01033439929228813265e-7};
constexpr double kTailBottom[8] = {1.0,
                                   5.99832206555887937690e-1,
                                   1.36929880922735805310e-1,
                                   1.48753612908506148525e-2,
                                   7.86869131145613259100e-4,
                                   1.84631831751005468180e-5,
                                   1.42151175831644588870e-7,
                                   2.04426310338993978564e-15};

/// Ends of the interval in deviations from the mean, mirrored into the lower tail if the interval lies in the
/// upper one, where differences of probabilities would cancel.
struct StandardInterval {
    double a, b;
    bool isMirrored;
    explicit StandardInterval(const TruncatedNormal& d)
        : a((d.low - d.mean) / d.sd), b((d.high - d.mean) / d.sd), isMirrored(a > 0) {
        if (isMirrored) a = -std::exchange(b, -a);
    }
};

}  // namespace

double NormalCdf(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

double NormalQuantile(double p) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    if (p <= 0) return -kInf;
    if (p >= 1) return kInf;
    const double q = p - 0.5;
    if (std::abs(q) <= 0.425) return q * Ratio(kMiddleTop, kMiddleBottom, 0.180625 - q * q);
    const double r = std::sqrt(-std::log(q < 0 ? p : 1 - p));
    const double z = r <= 5 ? Ratio(kFlankTop, kFlankBottom, r - 1.6) : Ratio(kTailTop, kTailBottom, r - 5);
    return q < 0 ? -z : z;
}

double TruncatedNormal::Mass() const {
    const StandardInterval s(*this);
    return NormalCdf(s.b) - NormalCdf(s.a);
}

double TruncatedNormal::LogDensity(double x) const {
    if (!(x >= low && x <= high)) return -std::numeric_limits<double>::infinity();
    const double z = (x - mean) / sd;
    return -0.5 * z * z - std::log(sd * std::sqrt(2 * std::numbers::pi) * Mass());
}

double TruncatedNormal::Quantile(double u) const {
    const StandardInterval s(*this);
    const double part = s.isMirrored ? 1 - u : u;
    const double below = NormalCdf(s.a), z = NormalQuantile(below + part * (NormalCdf(s.b) - below));
    return std::clamp(mean + sd * (s.isMirrored ? -z : z), low, high);
}

}  // namespace lacquer::estimate
