// Colours as laboratories write them: CIE L*a*b*, and differences that the eye sees.
#pragma once

#include <cmath>

#include "pbrt/core/vec.h"

namespace lacquer {

/// CIE 1976 L*a*b*.
struct Lab {
    double L = 0, a = 0, b = 0;
    /// Distance from grey.
    double Chroma() const { return std::hypot(a, b); }
    /// [degrees], in [0, 360); 0 for grey.
    double HueDegrees() const;
};

/// @param xyz, white  in one unit, the white's values > 0  [CIE 2004, sec. 8.2.1]
Lab LabOf(glm::dvec3 xyz, glm::dvec3 white);

/// Color difference CIEDE2000, with the parametric factors 1 [Sharma et al. 2005]. About 1 is
/// the least that is seen side by side.
double DeltaE2000(const Lab& a, const Lab& b);

}  // namespace lacquer
