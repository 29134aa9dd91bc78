#include "pbrt/core/color_difference.h"

#include <numbers>

#include "pbrt/core/math.h"

namespace lacquer {

namespace {

constexpr double kDegrees = std::numbers::pi / 180;

/// Cube root that goes on as a straight line below (6/29)^3, so that black has no infinite slope.
double LabRoot(double t) {
    constexpr double kEdge = 6.0 / 29;
    return t > kEdge * kEdge * kEdge ? std::cbrt(t) : t / (3 * kEdge * kEdge) + 4.0 / 29;
}

double Pow7(double x) {
    const double x2 = x * x;
    return x2 * x2 * x2 * x;
}
/// In [0, 360); 0 for grey.
double AngleDegrees(double a, double b) {
    if (a == 0 && b == 0) return 0;
    const double degrees = std::atan2(b, a) / kDegrees;
    return degrees < 0 ? degrees + 360 : degrees;
}
double CosDegrees(double degrees) { return std::cos(degrees * kDegrees); }

/// Opposite hues are those to rounding, too: the formula jumps there.
constexpr double kOpposite = 180 + 1e-9;

/// Chroma and hue with a* stretched for colours near grey.
struct Polar {
    double chroma, hue;
};
Polar Stretched(const Lab& c, double stretch) {
    return {std::hypot(c.a * stretch, c.b), AngleDegrees(c.a * stretch, c.b)};
}
/// Of two hues [degrees]: by how much the second is farther round, in [-180, 180], and their mean.
/// @param isGrey  one of them means nothing
double HueDifference(double from, double to, bool isGrey) {
    if (isGrey) return 0;
    const double d = to - from;
    return d > kOpposite ? d - 360 : d < -kOpposite ? d + 360 : d;
}
double MeanHue(double from, double to, bool isGrey) {
    if (isGrey) return from + to;
    if (std::abs(from - to) <= kOpposite) return (from + to) / 2;
    return from + to < 360 ? (from + to + 360) / 2 : (from + to - 360) / 2;
}

}  // namespace

double Lab::HueDegrees() const { return AngleDegrees(a, b); }

Lab LabOf(glm::dvec3 xyz, glm::dvec3 white) {
    const double x = LabRoot(xyz.x / white.x), y = LabRoot(xyz.y / white.y), z = LabRoot(xyz.z / white.z);
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

// The numbers of the equations are those of [Sharma et al. 2005].
double DeltaE2000(const Lab& a, const Lab& b) {
    // Eq. 2 to 7.
    const double meanChroma7 = Pow7((a.Chroma() + b.Chroma()) / 2), k25 = Pow7(25);
    const double stretch = 1.5 - 0.5 * std::sqrt(meanChroma7 / (meanChroma7 + k25));
    const Polar p = Stretched(a, stretch), q = Stretched(b, stretch);
    // Eq. 8 to 11.
    const bool isGrey = p.chroma * q.chroma == 0;
    const double dL = b.L - a.L, dC = q.chroma - p.chroma;
    const double dH =
        2 * std::sqrt(p.chroma * q.chroma) * std::sin(HueDifference(p.hue, q.hue, isGrey) / 2 * kDegrees);
    // Eq. 12 to 21: weights of the three by the mean colour.
    const double L = (a.L + b.L) / 2, C = (p.chroma + q.chroma) / 2, h = MeanHue(p.hue, q.hue, isGrey);
    const double T = 1 - 0.17 * CosDegrees(h - 30) + 0.24 * CosDegrees(2 * h) + 0.32 * CosDegrees(3 * h + 6) -
                     0.20 * CosDegrees(4 * h - 63);
    const double L50 = Sqr(L - 50);
    const double SL = 1 + 0.015 * L50 / std::sqrt(20 + L50), SC = 1 + 0.045 * C, SH = 1 + 0.015 * C * T;
    const double RC = 2 * std::sqrt(Pow7(C) / (Pow7(C) + k25));
    const double RT = -RC * std::sin(60 * std::exp(-Sqr((h - 275) / 25)) * kDegrees);
    // Eq. 22.
    const double l = dL / SL, c = dC / SC, hue = dH / SH;
    return std::sqrt(std::max(0.0, l * l + c * c + hue * hue + RT * c * hue));
}

}  // namespace lacquer
