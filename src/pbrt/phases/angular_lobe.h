// Directions and records of lobes about an axis: what phase functions need that are evaluated inline.
#pragma once

#include "pbrt/base/phase_function.h"
#include "pbrt/core/special_functions.h"

namespace lacquer {

inline PhaseValue SymmetricPhase(float p) { return {p, p, p}; }

/// The end of all Sample(): value and density come from one place. Asking anew costs a few ns and gives what
/// a later query will give.
template <class Phase>
PhaseSample PhaseRecord(const Phase& phase, Vec3 wo, Vec3 wi) {
    const PhaseValue value = phase.Evaluate(wo, wi);
    return {wi, 1, value.pdf, value.pdfReverse};
}

/// 1 - cos of the angle between unit vectors, with a small relative error also where it is tiny.
inline float OneMinusCos(Vec3 a, Vec3 b) { return 0.5f * LengthSquared(a - b); }

/// w with the rounding of a few operations taken from its length. Half of the relative error e of the length
/// squared goes, to first order: what is left is 3/8 e^2. Without the root and the division of Normalize(),
/// which a walk would wait for.
inline Vec3 KeepUnit(Vec3 w) { return w * (1.5f - 0.5f * LengthSquared(w)); }

/// Unit vector at a given angle to the axis, at a random azimuth.
inline Vec3 AroundAxis(Vec3 axis, float oneMinusCos, float u) {
    const float sine = SafeSqrt(oneMinusCos * (2 - oneMinusCos));
    const auto [sinPhi, cosPhi] = SinCosOfTurn(u);
    Vec3 x, y;
    CoordinateSystem(axis, &x, &y);
    // Long walks must not let the length drift.
    return KeepUnit(axis - oneMinusCos * axis + sine * (cosPhi * x + sinPhi * y));
}

}  // namespace lacquer
