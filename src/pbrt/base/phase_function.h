// How a medium scatters light at a point inside it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "pbrt/core/arena.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/rng.h"
#include "pbrt/core/sampled_spectrum.h"
#include "pbrt/core/vec.h"

namespace lacquer {

class FloatTexture;
class Params;
class TextureLibrary;
struct TextureContext;

/// Value and densities for one pair of directions.
struct PhaseValue {
    float p = 0;           ///< [1/sr]; integrates to 1 over wi
    float pdf = 0;         ///< [1/sr], over wi, of what Sample() draws for wo
    float pdfReverse = 0;  ///< [1/sr], over wo, of drawing wo for wi
};

/// The same at each wavelength of a path, the densities being those of SampleAt().
struct SpectralPhaseValue {
    SampledSpectrum p, pdf, pdfReverse;
};

/// A direction drawn by Sample().
struct PhaseSample {
    Vec3 wi{0, 0, 1};
    float weight = 1;  ///< p / pdf
    float pdf = 0, pdfReverse = 0;
};

/// What a medium does to light along one direction, over what its coefficients say, at each wavelength.
struct DirectionalFactors {
    SampledSpectrum extinction{1.f};  ///< of sigma_t
    SampledSpectrum albedo{1.f};      ///< of sigma_s / sigma_t
};

/// Scattering in a medium, for wo and wi that both point away from the point (straight on is wi = -wo).
/// Objects hold numbers only, live in an Arena and are trivially destructible; all functions are const and
/// thread-safe.
///
/// Reciprocity: Extinction(wo) Albedo(wo) p(wo, wi) = Extinction(wi) Albedo(wi) p(wi, wo). Media whose
/// extinction and albedo do not depend on the direction have a symmetric p.
///
/// Most are the same at all wavelengths. One that is not (IsChromatic()) is made with the wavelengths of a
/// path, and its Evaluate() and Sample() are those of the first. Whoever carries more than that one asks
/// EvaluateSpectral(), draws by SampleAt() for one of the wavelengths, and weights the draw by the balance
/// heuristic over all for which it might have been made, as for free flights.
class PhaseFunction {
  public:
    virtual PhaseValue Evaluate(Vec3 wo, Vec3 wi) const = 0;
    /// Draws wi; never fails. Takes as many numbers as it needs.
    virtual PhaseSample Sample(Vec3 wo, Rng& rng) const = 0;
    /// True if p may differ between the wavelengths.
    virtual bool IsChromatic() const { return false; }
    /// Default: Evaluate() at all wavelengths.
    virtual SpectralPhaseValue EvaluateSpectral(Vec3 wo, Vec3 wi) const {
        const PhaseValue value = Evaluate(wo, wi);
        return {SampledSpectrum(value.p), SampledSpectrum(value.pdf), SampledSpectrum(value.pdfReverse)};
    }
    /// Draws wi for the wavelength with this index. Default: Sample().
    virtual Vec3 SampleAt(int /*wavelength*/, Vec3 wo, Rng& rng) const { return Sample(wo, rng).wi; }
    /// Extinction along w in units of the medium's sigma_t: the projected area of its flakes. Even in w. At
    /// the first wavelength, if it depends on the wavelength (PhaseModel::HasChromaticExtinction()).
    virtual float Extinction(Vec3 /*w*/) const { return 1; }
    /// Albedo along w in units of the medium's, at most 1; else as Extinction().
    virtual float Albedo(Vec3 /*w*/) const { return 1; }
    /// True if Extinction() or Albedo() is not 1 everywhere.
    virtual bool HasDirectionalExtinction() const { return false; }
    /// True if Albedo() is not 1 everywhere.
    virtual bool HasDirectionalAlbedo() const { return false; }
    /// Both at any wavelengths, also others than this object was made with. Default: the same at all.
    virtual DirectionalFactors FactorsAlong(Vec3 w, const SampledWavelengths& /*lambda*/) const {
        return {SampledSpectrum(Extinction(w)), SampledSpectrum(Albedo(w))};
    }

  protected:
    ~PhaseFunction() = default;  // never destroyed through the base: the arena forgets objects
};

/// Where a phase function is made.
struct PhaseContext {
    const Frame& frame;  ///< of orientations, in that of the directions; its axes may have any length
    const SampledWavelengths& lambda;
    const TextureContext* textures = nullptr;  ///< never null for models made with textures
};

/// A phase function as a scene describes it: to a PhaseFunction what a Material is to a BxDF. Immutable and
/// thread-safe.
class PhaseModel {
  public:
    virtual ~PhaseModel() = default;
    /// A phase function in `arena`. It may refer to this object.
    virtual const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const = 0;
    /// True if it has a direction of its own: the frame matters, and extinction may depend on the direction.
    virtual bool IsOriented() const { return false; }
    /// True if it depends on the wavelength.
    virtual bool IsChromatic() const { return false; }
    /// True if extinction or albedo by direction depends on the wavelength. Slabs then end all wavelengths
    /// but the first.
    virtual bool HasChromaticExtinction() const { return false; }
    /// True if no texture has a say.
    virtual bool IsConstant() const { return true; }
    /// Phase functions that one Make() makes.
    virtual int NumParts() const { return 1; }
};

/// What has a phase function, for those that read its parameters: a slab or a medium.
class PhaseOwner {
  public:
    /// The word in messages, for one and for many.
    virtual const char* Kind() const = 0;
    virtual const char* KindOfMany() const = 0;
    /// Null for media: they have no surface, and so no textures.
    virtual TextureLibrary* Textures() const = 0;
    /// The phase function of an earlier one of the same kind; null for one that could not be made.
    /// Errors: SceneError at "phases" for a name that there is not.
    virtual const PhaseModel* Find(const Params& params, const std::string& name) const = 0;

  protected:
    ~PhaseOwner() = default;
};

/// What a phase function's factory gets.
struct PhaseArgs {
    const Params& params;
    const PhaseOwner& owner;
};
/// A factory, and the names of the parameters that belong to it: given beside another phase function they are
/// an error that says so.
struct PhasePlugin {
    std::unique_ptr<PhaseModel> (*create)(const PhaseArgs&);
    std::span<const std::string_view> parameters;
};
struct PhaseKind {
    static constexpr const char* kKind = "phase";
    using Factory = const PhasePlugin*;
};

}  // namespace lacquer
