// How a surface point scatters light: the central interface of the renderer.
#pragma once

#include <limits>
#include <optional>
#include <variant>

#include "pbrt/core/rng.h"
#include "pbrt/core/sampled_spectrum.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// What is carried along a path: radiance from lights to the camera, or importance from the camera to lights.
/// They differ by eta^2 at refraction [Veach 1997, ch. 5].
enum class TransportMode { Radiance, Importance };
constexpr TransportMode operator!(TransportMode m) {
    return m == TransportMode::Radiance ? TransportMode::Importance : TransportMode::Radiance;
}

/// Sets of lobes: a side (Reflection, Transmission) and a kind (Diffuse, Glossy, Specular).
enum class Lobes : unsigned {
    None = 0,
    Reflection = 1,
    Transmission = 2,
    Diffuse = 4,
    Glossy = 8,
    Specular = 16,
    BothSides = Reflection | Transmission,
    DiffuseReflection = Diffuse | Reflection,
    DiffuseTransmission = Diffuse | Transmission,
    GlossyReflection = Glossy | Reflection,
    GlossyTransmission = Glossy | Transmission,
    SpecularReflection = Specular | Reflection,
    SpecularTransmission = Specular | Transmission,
};
constexpr Lobes operator|(Lobes a, Lobes b) { return Lobes(unsigned(a) | unsigned(b)); }
constexpr Lobes operator&(Lobes a, Lobes b) { return Lobes(unsigned(a) & unsigned(b)); }
/// True if the sets have a member in common.
constexpr bool Any(Lobes a, Lobes b) { return (a & b) != Lobes::None; }
constexpr bool IsSpecular(Lobes l) { return Any(l, Lobes::Specular); }
constexpr bool IsNonSpecular(Lobes l) { return Any(l, Lobes::Diffuse | Lobes::Glossy); }

/// What stochastic models count as they are asked; each thread has its own.
struct BxDFCounters {
    int64_t productQueries = 0;    ///< of estimators that sample products of lobes
    int64_t productFallbacks = 0;  ///< of these, where no product applied: left to "bidirectional" as a whole
    int64_t numbers = 0;           ///< random numbers that queries took: how long they were

    BxDFCounters& operator+=(const BxDFCounters& c) {
        productQueries += c.productQueries;
        productFallbacks += c.productFallbacks;
        numbers += c.numbers;
        return *this;
    }
};

class BxDFDimensions;

/// What a query may depend on beside the two directions.
struct BxDFContext {
    TransportMode mode = TransportMode::Radiance;
    Lobes sides = Lobes::BothSides;  ///< only these sides are evaluated and sampled
    Rng* rng = nullptr;              ///< for stochastic models; never null in a render
    bool needsPdf = true;            ///< false: the caller has no use for Evaluate().pdf, which may be left 0
    /// False: the caller has no use for the densities in what Sample() draws from rough lobes, which may then
    /// be 0 and not pdfExact: much of the work of a draw is in them.
    bool needsSamplePdf = true;
    /// True: the direction that Sample() draws need not follow its numbers continuously, and more of them may
    /// come from rng. Faster, for numbers that are not stratified anyway.
    bool allowsRejection = false;
    /// Of BxDFs with CountsVertices(): longer paths within them count as 0 in Evaluate().
    int maxVertices = std::numeric_limits<int>::max();
    BxDFCounters* counters = nullptr;  ///< null: nobody asks
    /// Dimensions of the pixel's sampler, which come before numbers from rng (bxdf_numbers.h); null: none.
    BxDFDimensions* dimensions = nullptr;
};

/// Value and density of one pair of directions.
struct BxDFValue {
    SampledSpectrum f;     ///< [1/sr], without the cosine; 0 for specular lobes
    float pdf = 0;         ///< [1/sr], over solid angle of wi, of what Sample() draws for the same context
    float pdfReverse = 0;  ///< [1/sr], over solid angle of wo, of drawing wo for wi
};

/// A direction drawn by Sample().
struct BxDFSample {
    Vec3 wi{0, 0, 1};
    SampledSpectrum weight;  ///< f |cos theta_i| / pdf: what the throughput is multiplied by
    float pdf = 0;           ///< [1/sr]; for specular lobes the probability of the lobe
    /// Density of drawing wo for wi [1/sr]; for specular lobes the probability of that lobe times the solid
    /// angle of wi per solid angle of wo, so that quotients pdf / pdfReverse mean the same for all lobes.
    float pdfReverse = 0;
    Lobes lobe = Lobes::None;  ///< the one side and kind that was drawn
    float eta = 1;             ///< index on the side of wi over index on the side of wo; 1 unless transmitted
    /// False: pdf is not the density of what was drawn. Those who need one for multiple importance weights
    /// ask Pdf(), which is what Evaluate() says; pdf may be 0.
    bool pdfExact = true;
    /// Of BxDFs with CountsVertices(): vertices of the path within that was followed; 0: the record stands
    /// for paths of all lengths.
    int numVertices = 0;

    bool IsSpecular() const { return lacquer::IsSpecular(lobe); }
    bool IsTransmission() const { return Any(lobe, Lobes::Transmission); }
    bool IsReflection() const { return Any(lobe, Lobes::Reflection); }
};

/// Uniform numbers in [0,1) for one Sample().
struct BxDFRandom {
    float lobe = 0;       ///< chooses among lobes
    Point2 direction{0};  ///< the direction within it
};

enum class MicrofacetModel;  // see scattering/microfacet.h

/// A rough boundary that scatters once, at facets.
struct MicrofacetSurface {
    MicrofacetModel model;
    float alphaX, alphaY;
    float eta = 0;  ///< index below over index above; 0: lets nothing through
};
/// A polished boundary of transparent media: reflection and refraction are specular.
struct SmoothSurface {
    float eta;  ///< index below over index above
};
/// f = R/pi on the side of wo, nothing on the other one.
struct LambertianSurface {
    SampledSpectrum reflectance;
};
/// What a BxDF is, for those who sample several together or know closed forms; empty: nothing special.
using SurfaceModel = std::variant<std::monostate, MicrofacetSurface, LambertianSurface, SmoothSurface>;

/// Scattering at a point, in the local frame with z along the shading normal. wo points to the camera side
/// and wi to the light side, both unit and away from the surface. Objects hold numbers only, live in an Arena
/// and are trivially destructible. All functions are const, thread-safe, and take their randomness as an
/// argument.
///
/// Transmitted f in radiance mode carries the factor 1/eta^2 of refraction; f(wo, wi, mode) = f(wi, wo,
/// !mode).
class BxDF {
  public:
    /// The lobes that can occur.
    virtual Lobes Flags() const = 0;
    /// f and its density together; both zero outside of the lobes asked for, and for directions in the
    /// surface (z = 0).
    virtual BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const = 0;
    /// The density of Evaluate() alone, where that is cheaper. For stochastic models a draw of its own.
    virtual float Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
        return Evaluate(wo, wi, context).pdf;
    }
    /// Draws wi. Empty if the draw fails (the path ends) or no lobe asked for exists. For non-specular lobes
    /// with pdfExact, the record agrees with Evaluate(): weight = f |cos| / pdf.
    virtual std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u,
                                             const BxDFContext& context) const = 0;
    /// True of a stack, within which paths have vertices: Evaluate() goes by BxDFContext::maxVertices.
    virtual bool CountsVertices() const { return false; }
    /// The closed form that this BxDF has, now. Default: none.
    virtual SurfaceModel Model() const { return {}; }
    /// Widens narrow lobes, for path regularisation. Default: nothing to widen.
    virtual void Regularize() {}

  protected:
    ~BxDF() = default;  // never destroyed through the base: the arena forgets objects
};

}  // namespace lacquer
