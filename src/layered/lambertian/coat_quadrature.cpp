#include "layered/lambertian/coat_quadrature.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "pbrt/core/quadrature.h"

namespace lacquer::layered {
namespace {

constexpr double kPi = std::numbers::pi;
/// Beckmann slopes beyond this many alphas weigh less than 1e-11.
constexpr double kLargestSlope = 5.2;

/// Calls f(x, weight) for the nodes of a rule on [a, b].
template <class Function>
void ForNodes(const std::vector<QuadratureNode>& rule, double a, double b, const Function& f) {
    if (!(b > a)) return;
    const double half = 0.5 * (b - a), middle = 0.5 * (a + b);
    for (const QuadratureNode& node : rule) f(middle + half * node.x, half * node.weight);
}

/// The same with most nodes near b, where the function has a logarithm.
template <class Function>
void ForNodesNearEnd(const std::vector<QuadratureNode>& rule, double a, double b, const Function& f) {
    ForNodes(rule, 0, 1,
             [&](double x, double weight) { f(b - (b - a) * x * x * x, weight * 3 * x * x * (b - a)); });
}

double Square(double x) { return x * x; }

/// As FresnelDielectric(), for d > 0. @param eta  index on the far side over index on the near side
double Fresnel(double d, double eta) {
    const double cos2 = 1 - (1 - d) * (1 + d) / (eta * eta);
    if (!(cos2 > 0)) return 1;
    const double t = std::sqrt(cos2);
    return 0.5 * (Square((eta * d - t) / (eta * d + t)) + Square((d - eta * t) / (d + eta * t)));
}

/// As ProjectedArea() of the distributions: c (1 + Lambda).
double ProjectedArea(const CoatSurface& surface, double c) {
    const double s = surface.alpha * std::sqrt(std::max(0., (1 - c) * (1 + c)));
    if (surface.model == MicrofacetModel::TrowbridgeReitz) return 0.5 * (c + std::sqrt(c * c + s * s));
    if (c >= 6 * s) return c;
    const double a = c / s;
    return 0.5 * (c * (1 + std::erf(a)) + s * std::exp(-a * a) / std::sqrt(kPi));
}

/// Calls f(x, y, weight) for facet slopes in units of alpha, w being along -x: the weights are the density of
/// visible normals and add up to 1. y stands for -y, too.
template <class Function>
void ForVisibleSlopes(const CoatSurface& surface, double c, const Function& f) {
    static const std::vector<QuadratureNode> along = GaussLegendre(24), across = GaussLegendre(18),
                                             brief = GaussLegendre(10);
    const double s = surface.alpha * std::sqrt(std::max(0., (1 - c) * (1 + c)));
    const double area = ProjectedArea(surface, c);
    if (surface.model == MicrofacetModel::Beckmann) {
        const double first = c < kLargestSlope * s ? -c / s : -kLargestSlope;
        ForNodes(along, first, kLargestSlope, [&](double x, double weightX) {
            const double seen = std::exp(-x * x) * (c + s * x) / area * weightX / kPi;
            ForNodes(across, 0, kLargestSlope,
                     [&](double y, double weightY) { f(x, y, 2 * weightY * std::exp(-y * y) * seen); });
        });
        return;
    }
    // x = tan xi, y = sqrt(1 + x^2) tan chi make the density smooth and bounded. The facets tilt over slopes
    // of 1/alpha; parts on either side of 1/sqrt(alpha) resolve both scales.
    const double far = 1 / std::sqrt(surface.alpha);
    const auto addColumn = [&](double xi, double weightXi) {
        const double x = std::tan(xi), middle = std::atan(far * std::cos(xi));
        const double seen = (c * std::cos(xi) + s * std::sin(xi)) / area * weightXi / kPi;
        const auto add = [&](double chi, double weightChi) {
            f(x, std::tan(chi) / std::cos(xi), 2 * weightChi * Square(std::cos(chi)) * seen);
        };
        ForNodes(brief, 0, middle, add);
        ForNodesNearEnd(brief, middle, kPi / 2, add);
    };
    const double first = s > 0 ? -std::atan(c / s) : -kPi / 2, middle = std::atan(far);
    const double left = std::max(first, -middle);
    ForNodes(brief, first, left, addColumn);
    ForNodes(along, left, middle, addColumn);
    ForNodesNearEnd(brief, middle, kPi / 2, addColumn);
}

}  // namespace

CoatEntry IntegrateEntry(const CoatSurface& surface, double cosTheta, std::span<const double> taus,
                         std::span<double> transmittances) {
    const double c = cosTheta, s = std::sqrt(std::max(0., (1 - c) * (1 + c))), eta = surface.eta;
    const double area = ProjectedArea(surface, c);
    CoatEntry entry{0, 0, 0};
    std::fill(transmittances.begin(), transmittances.end(), 0.);
    double sum = 0;
    const auto add = [&](double x, double y, double weight) {
        const double mz = 1 / std::sqrt(1 + Square(surface.alpha) * (x * x + y * y));
        const double d = (c + s * surface.alpha * x) * mz;
        // Refract; u is the cosine below.
        const double dt = std::sqrt(1 - (1 - d) * (1 + d) / (eta * eta));
        const double u = c / eta + (dt - d / eta) * mz;
        if (!(u > 0)) return;
        const double passed = weight * (1 - Fresnel(d, eta));
        const double areaU = ProjectedArea(surface, u);
        const double value = passed * area * u / (area * u + (areaU - u) * c);
        entry.probabilityIn += passed;
        entry.densityOut += passed * u / areaU * area;
        entry.meanPath += value / u;
        sum += value;
        for (size_t i = 0; i < taus.size(); ++i) transmittances[i] += value * std::exp(-taus[i] / u);
    };
    if (surface.alpha > 0)
        ForVisibleSlopes(surface, c, add);
    else
        add(0, 0, 1);
    entry.meanPath /= sum;
    return entry;
}

namespace {

/// Sums up what facets of one tilt reflect. Directions are drawn around the facet's normal: d is their cosine
/// with it and psi the azimuth, from the facet's line of steepest ascent.
class FacetReturn {
  public:
    FacetReturn(const CoatSurface& surface, std::span<const double> taus, std::span<double> reflectances)
        : surface_(surface), taus_(taus), reflectances_(reflectances) {}

    /// @param slope  of the facets, in units of alpha
    void Add(double slope, double weight) {
        static const std::vector<QuadratureNode> rule = GaussLegendre(14);
        const double mz = 1 / std::sqrt(1 + Square(surface_.alpha * slope));
        const double tilt = surface_.alpha * slope * mz;
        // Fresnel's factor has a root at the critical angle, the range of azimuths one at `tilt`.
        const double critical = std::sqrt(1 - 1 / Square(surface_.eta));
        const double low = std::min(critical, tilt), high = std::max(critical, tilt);
        for (const auto& [from, to] : {std::pair(0., low), std::pair(low, high), std::pair(high, 1.)})
            AddCones(from, to, rule, mz, tilt, weight / mz);
    }

    CoatReturn Result() const { return {probabilityBack_, pathSum_ / sum_}; }

  private:
    /// Directions at angles of cosines d between two bounds; roots at the bounds do not matter.
    void AddCones(double from, double to, const std::vector<QuadratureNode>& rule, double mz, double tilt,
                  double weight) {
        const double half = 0.5 * (to - from);
        if (!(half > 0)) return;
        ForNodes(rule, 0, kPi, [&](double phi, double weightPhi) {
            AddCone(from + half * (1 - std::cos(phi)), mz, tilt, weight * half * std::sin(phi) * weightPhi);
        });
    }
    /// Directions at one angle from the facet's normal.
    void AddCone(double d, double mz, double tilt, double weight) {
        static const std::vector<QuadratureNode> rule = GaussLegendre(12);
        const double a = d * mz, b = std::sqrt((1 - d) * (1 + d)) * tilt;
        const double firstPsi = b > a ? std::acos(a / b) : 0;
        const double reflected = Fresnel(d, 1 / surface_.eta) * d / kPi * weight;
        // Four quadrants are alike: both directions may be exchanged, and psi mirrored.
        ForNodes(rule, firstPsi, kPi / 2, [&](double psi, double weightPsi) {
            const double u = a + b * std::cos(psi), v = a - b * std::cos(psi);
            if (u > 0 && v > 0) AddPair(u, v, 4 * reflected * weightPsi);
        });
    }

    void AddPair(double u, double v, double weight) {
        const double areaU = ProjectedArea(surface_, u), areaV = ProjectedArea(surface_, v);
        const double value = weight * u * v / (areaU * v + (areaV - v) * u);
        const double path = 1 / u + 1 / v;
        sum_ += value;
        pathSum_ += value * path;
        probabilityBack_ += weight * 0.5 * (u / areaU + v / areaV);
        for (size_t i = 0; i < taus_.size(); ++i) reflectances_[i] += value * std::exp(-taus_[i] * path);
    }

    const CoatSurface& surface_;
    std::span<const double> taus_;
    std::span<double> reflectances_;
    double sum_ = 0, pathSum_ = 0, probabilityBack_ = 0;
};

}  // namespace

CoatReturn IntegrateReturn(const CoatSurface& surface, std::span<const double> taus,
                           std::span<double> reflectances) {
    static const std::vector<QuadratureNode> rule = GaussLegendre(20);
    std::fill(reflectances.begin(), reflectances.end(), 0.);
    FacetReturn facets(surface, taus, reflectances);
    if (surface.alpha == 0) {
        facets.Add(0, 1);
        return facets.Result();
    }
    // Where the facets' tilt is the critical angle, two roots meet.
    const double split = std::sqrt(Square(surface.eta) - 1) / surface.alpha;
    if (surface.model == MicrofacetModel::Beckmann) {
        const auto add = [&](double p, double weight) { facets.Add(p, 2 * p * std::exp(-p * p) * weight); };
        const double middle = std::min(split, kLargestSlope);
        ForNodes(rule, 0, middle, add);
        ForNodes(rule, middle, kLargestSlope, add);
    } else {  // p = tan zeta
        const auto add = [&](double zeta, double weight) {
            facets.Add(std::tan(zeta), std::sin(2 * zeta) * weight);
        };
        ForNodes(rule, 0, std::atan(split), add);
        ForNodes(rule, std::atan(split), kPi / 2, add);
    }
    return facets.Result();
}

}  // namespace lacquer::layered
