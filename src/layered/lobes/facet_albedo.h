// What rough boundaries reflect and transmit, by a quadrature of a few facets.
#pragma once

#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {

/// Parts of the light along one direction that single events on the facets of a boundary send to either side;
/// what facets shadow is in neither.
struct FacetAlbedo {
    float reflected = 0, transmitted = 0;
};

/// About, by 16 facets: within 0.025 from the thinner side for alpha <= 0.3 and cosTheta > 0.2, within 0.06
/// for all; from the denser side mostly within 0.05, at grazing angles within 0.2. Some 0.1 us.
/// @param cosTheta  in (0, 1]
/// @param eta          index beyond over index on this side; 0: facets that reflect everything
/// @param alphaShadow  of the facets that shadow each other: less than alpha where a part of that stands for
///                     the width of a beam
FacetAlbedo IntegrateFacets(MicrofacetModel model, float alpha, float eta, float cosTheta, float alphaShadow);
inline FacetAlbedo IntegrateFacets(MicrofacetModel model, float alpha, float eta, float cosTheta) {
    return IntegrateFacets(model, alpha, eta, cosTheta, alpha);
}

}  // namespace lacquer::layered
