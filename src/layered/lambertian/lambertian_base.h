// The closed form of a dielectric coat over a Lambertian base, with a slab between that absorbs at most.
#pragma once

#include "layered/lambertian/coat_tables.h"
#include "layered/stack.h"

namespace lacquer::layered {

/// A stack that has the closed form. All light that meets the base forgets where it came from, so the paths
/// of 3, 5, 7 ... vertices are a geometric series [1/sr]:
///   f = f0 + t(wi) t(wo) rho / (pi eta^2) (1 + rho R + (rho R)^2 + ...),
/// t and R being those of Coat. The factor 1/eta^2 is that of two refractions, one in each direction: the
/// value is the same for both transport modes.
struct LambertianBase {
    const StackInterface* top = nullptr;
    MicrofacetModel model{};             ///< of the coat's facets
    float alpha = 0;                     ///< of the coat; 0: smooth
    float eta = 1;                       ///< index below the coat over index above
    const CoatCurves* curves = nullptr;  ///< of the coat, if there are any
    SampledSpectrum reflectance{};       ///< rho, of the base
    SampledSpectrum tau{};               ///< optical thickness of the slab
};

/// Sets what belongs to the coat. False if Coat does not know the boundary.
bool FindCoat(const StackInterface& top, LambertianBase* base);

/// True if the stack and the two directions have the closed form: two level interfaces, an isotropic coat
/// that Coat knows, an absorbing or empty slab whose extinction does not depend on the direction, a
/// Lambertian base, and both directions above.
bool FindLambertianBase(const Stack& stack, Vec3 wo, Vec3 wi, LambertianBase* base);

/// f - f0 [1/sr], without the cosine, of paths of at most `maxVertices` vertices. No random numbers. Right up
/// to the tables' errors, see Coat: 1e-5 (rms) under varnishes, at most 1e-3 for tau < 1 and no grazing
/// light. Some 0.1 us.
SampledSpectrum EvaluateLambertianBase(const LambertianBase& base, Vec3 wo, Vec3 wi, int maxVertices);

/// The same with t(wo) and t(wi) estimated from one refraction each, drawn by visible normals: no error of
/// t's table, but noise. Takes its randomness from context.rng.
SampledSpectrum EstimateLambertianBase(const LambertianBase& base, Vec3 wo, Vec3 wi,
                                       const BxDFContext& context, int maxVertices);

/// The density of SampleLambertianBaseDirection() [1/sr], f0's part included and walks of more than
/// `maxVertices` vertices left out. No random numbers. The mirror lobe of a smooth coat is left out. Less
/// than 0.2 us.
float LambertianBasePdf(const LambertianBase& base, Vec3 wo, Vec3 wi, int maxVertices);

/// Draws wi: from the coat's lobe or as light that the base has met, so often as the energies of the two are
/// (a mean over the wavelengths). The weight is (f0 + f) |cos| / pdf by the closed form, without the noise of
/// a walk; the mirror lobe of a smooth coat is a record of the coat. pdfReverse is left 0 for other lobes.
/// Empty if the light does not come out. Some 0.5 us.
/// @param u  for the first meeting with the coat; the others take their numbers from context.rng
std::optional<BxDFSample> SampleLambertianBaseDirection(const LambertianBase& base, Vec3 wo,
                                                        const BxDFRandom& u, const BxDFContext& context,
                                                        int maxVertices);

}  // namespace lacquer::layered
