// Long paths between a rough dielectric coat and a rough reflecting base, by a walk that knows Fresnel's
// factor.
//
// Their noise comes from internal reflection: a few per cent before the critical angle, all beyond it. A walk
// that takes this factor as a weight, or ends by roulette on it, is noisy; here it is drawn. One walk goes
// down and up from the more grazing side and is joined to one refraction from the other side at each visit to
// the base. There are no weights between strategies, and no density is ever asked for in reverse.
#pragma once

#include "layered/stack.h"

namespace lacquer::layered {

/// True for directions above a stack of two interfaces, coat and base rough, isotropic and level, the base
/// letting nothing through, with a slab between them that does not scatter.
bool LongPathWalkApplies(const Stack& stack, Vec3 wo, Vec3 wi);

/// One unbiased estimate of all light [1/sr, without the cosine] on paths of minVertices to maxVertices
/// vertices, where LongPathWalkApplies(). Vertices are meetings with interfaces, an odd number for these
/// paths. Costs about 3/4 of what all paths by ConnectionWalk do.
/// @param minVertices  3: all but the reflection off the coat; 5: also without coat, base, coat
SampledSpectrum EstimateLongPaths(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                                  int maxVertices, int minVertices);

}  // namespace lacquer::layered
