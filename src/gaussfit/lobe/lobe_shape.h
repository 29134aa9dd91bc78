// The lobe of a boundary of small roughness in closed form, and the coordinates in which tables correct it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "gaussfit/lobe/lobe.h"

namespace lacquer::gaussfit {

/// Where a slice is taken: angle by its cosine, azimuth 0. T: float to evaluate, double to fit.
template <class T>
struct LobeQuery {
    T alpha = 0;
    T eta = 1;       ///< index on the far side over index on the side of w; not looked at for reflections
    T cosTheta = 1;  ///< of w, > 0
};

/// One Gaussian along the plane of incidence: mean (x, 0), P = diag(l11^2, l22^2) [Xia et al. 2020] eq. 17.
template <class T>
struct LobeShape {
    T mean = 0, l11 = 1, l22 = 1;
};

/// What a lobe would be for facets of slopes so small that everything is linear in them, and how far from
/// that it is. A table holds factors to `shape`: 1 + polynomial, all 1 in the limit of small alpha.
template <class T>
struct LobeBasis {
    LobeShape<T> shape;
    T grazingCosine =
        1;         ///< cosine on the side where light grazes: of w, for Leaving of the refracted direction
    T spread = 0;  ///< facets' slopes in units of the angle that is left to the horizon
};

namespace lobe_detail {

/// tan of the angle with this cosine.
template <class T>
T TanOf(T cosTheta) {
    return std::sqrt(std::max(T(0), (1 - cosTheta) * (1 + cosTheta))) / cosTheta;
}

/// Reflections: v has the slope -tan + 2 m sec^2 for a facet of slope m along x, and 2 m across. With m
/// normal of variance alpha^2/2 this gives L. Where the spread is large, the lobe is cut off by the horizon
/// and by shadowing; its mean and width then go like 1/alpha and not like tan theta, which the roots take
/// care of.
template <class T>
LobeBasis<T> ReflectionBasis(const LobeQuery<T>& q) {
    const T tan = TanOf(q.cosTheta), x = q.alpha * tan, across = T(0.70710678118654752) / q.alpha;
    LobeBasis<T> basis;
    basis.shape.mean = -tan / std::sqrt(1 + T(1.8) * x * x);
    basis.shape.l11 = across * q.cosTheta * q.cosTheta * (1 + 2 * x * x);
    basis.shape.l22 = across;
    basis.grazingCosine = q.cosTheta;
    basis.spread = x;
    return basis;
}

/// Refractions: a facet of slope m turns the refracted direction of slope tan theta_t by m (eta c_t - c)/(eta
/// c_t^3) along x and by m (eta c_t - c)/(eta c_t) across [Snell's law, linearised]. Needs eta c_t > 0.
template <class T>
LobeBasis<T> RefractionBasis(const LobeQuery<T>& q, bool isLeaving) {
    const T sine2 = (1 - q.cosTheta) * (1 + q.cosTheta) / (q.eta * q.eta);
    const T ct = std::sqrt(std::max(T(0), 1 - sine2));
    const T turn = std::abs(q.eta * ct - q.cosTheta);
    LobeBasis<T> basis;
    basis.shape.mean = std::sqrt(sine2) / ct;
    basis.shape.l22 = T(1.4142135623730950) * q.eta * ct / (q.alpha * turn);
    basis.shape.l11 = basis.shape.l22 * ct * ct;
    if (!isLeaving) {
        // The shadowing of w tells how far the lobe is from linear.
        basis.grazingCosine = q.cosTheta;
        basis.spread = q.alpha * TanOf(q.cosTheta);
        return basis;
    }
    // The horizon of the refracted side does.
    const T x = q.alpha * turn / (q.eta * ct * ct);
    basis.grazingCosine = ct;
    basis.spread = x;
    basis.shape.mean /= std::sqrt(1 + T(0.3) * x);
    basis.shape.l11 *= 1 + T(0.5) * x * std::sqrt(x);
    return basis;
}

}  // namespace lobe_detail

/// The closed form for one event. Domain: alpha > 0, cosTheta > 0; under total reflection grazingCosine is 0
/// and the rest is not finite.
template <class T>
LobeBasis<T> LobeBasisOf(LobeEvent event, const LobeQuery<T>& query) {
    return event == LobeEvent::Reflection ? lobe_detail::ReflectionBasis(query)
                                          : lobe_detail::RefractionBasis(query, event == LobeEvent::Leaving);
}

/// Variables in [0, 1] of the polynomials: of eta, of alpha, and of the angle.
template <class T>
struct LobeCoordinates {
    T eta = 0, alpha = 0, theta = 0;
};

/// The ranges of the variables of one polynomial. Roots resolve what happens near eta = 1 and at small alpha.
struct LobeDomain {
    double alphaMin = 0, alphaMax = 1;
    double etaMin = 1, etaMax = 2;  ///< larger index over the smaller one; equal if the event has no index
    double grazingCosineMin = 0;    ///< where the angles end
    /// Angles are measured by the spread x, as x/(1+x), which follows what happens close to the horizon at
    /// small alpha; else by 1 - sqrt(grazingCosine), scaled to end at 1.
    bool anglesBySpread = false;
};

/// The map from queries to coordinates, with the constants of a domain ready.
template <class T>
class LobeMap {
  public:
    LobeMap() = default;
    explicit LobeMap(const LobeDomain& d)
        : alphaOffset_(T(std::sqrt(d.alphaMin))),
          alphaScale_(T(1 / (std::sqrt(d.alphaMax) - std::sqrt(d.alphaMin)))),
          etaOffset_(T(std::sqrt(d.etaMin - 1))),
          etaScale_(d.etaMax > d.etaMin ? T(1 / (std::sqrt(d.etaMax - 1) - std::sqrt(d.etaMin - 1))) : T(0)),
          thetaScale_(T(1 / (1 - std::sqrt(d.grazingCosineMin)))),
          anglesBySpread_(d.anglesBySpread) {}

    LobeCoordinates<T> operator()(const LobeQuery<T>& q, const LobeBasis<T>& basis) const {
        LobeCoordinates<T> c;
        // Reflections have no index: etaScale_ is 0 then.
        const T index = std::max(q.eta, 1 / q.eta);
        c.eta = (std::sqrt(std::max(T(0), index - 1)) - etaOffset_) * etaScale_;
        c.alpha = (std::sqrt(q.alpha) - alphaOffset_) * alphaScale_;
        c.theta = anglesBySpread_ ? basis.spread / (1 + basis.spread)
                                  : (1 - std::sqrt(basis.grazingCosine)) * thetaScale_;
        return c;
    }

  private:
    T alphaOffset_ = 0, alphaScale_ = 1, etaOffset_ = 0, etaScale_ = 1, thetaScale_ = 1;
    bool anglesBySpread_ = false;
};

/// All Bernstein polynomials of one degree at t in [0, 1]: binomial(n, k) t^k (1-t)^(n-k).
template <int kDegree, class T>
std::array<T, kDegree + 1> BernsteinBasis(T t) {
    std::array<T, kDegree + 1> values, complements;
    values[0] = complements[0] = 1;
    T binomial = 1;
    for (int k = 1; k <= kDegree; ++k) {
        values[size_t(k)] = values[size_t(k - 1)] * t;
        complements[size_t(k)] = complements[size_t(k - 1)] * (1 - t);
    }
    for (int k = 0; k <= kDegree; ++k) {
        values[size_t(k)] *= binomial * complements[size_t(kDegree - k)];
        binomial *= T(kDegree - k) / T(k + 1);
    }
    return values;
}

}  // namespace lacquer::gaussfit
