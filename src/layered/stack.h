// A stack of interfaces and slabs: what light meets inside a layered surface.
#pragma once

#include <cmath>
#include <optional>
#include <span>

#include "pbrt/base/bxdf.h"
#include "pbrt/base/phase_function.h"
#include "pbrt/core/special_functions.h"
#include "pbrt/phases/hg.h"

namespace lacquer::layered {

class CoatCurves;

/// Extent of all walks: paths of more vertices than this do not exist. Light that is neither absorbed nor let
/// out for so long is a mistake in a model and must not hang a render.
inline constexpr int kMaxPathVertices = 1 << 16;

/// A boundary in a stack: any BxDF, in a frame of its own.
///
/// A frame whose z is not the stack's has a perturbed shading normal [Veach 1997, sec. 5.3]: where the camera
/// side asks, the cosine of f |cos| is the one with the perturbed normal, and the adjoint follows. So no
/// event of a walk from the camera gains weight; from the light's side there is a quotient of cosines. Eq. 14
/// of [Guo et al. 2018] multiplies by a second quotient of cosines that has no bound; see docs/layered.md.
/// Where the two normals disagree about the side of a direction, f is 0.
struct StackInterface {
    const BxDF* bxdf = nullptr;  ///< never null in a stack
    Frame frame;                 ///< of the BxDF, in the stack's frame
    bool hasOwnFrame = false;    ///< the frame is not the stack's
    bool isSpecular = false;     ///< has no part that Evaluate() could find
    bool hasSpecular = false;    ///< has a part that it cannot find, beside others or alone
    bool transmits = true;       ///< light can pass
    SurfaceModel model;  ///< what the BxDF is: estimators ask at each evaluation, the BxDF says it once

    StackInterface() = default;
    explicit StackInterface(const BxDF* scattering);
    StackInterface(const BxDF* scattering, const Frame& ownFrame);
    /// Asks the BxDF again for what is stored of it; to be called where the BxDF was changed.
    void Refresh();

    /// True if its normal is the stack's; its tangent may be rotated.
    bool HasUnperturbedNormal() const { return !hasOwnFrame || (frame.z.x == 0 && frame.z.y == 0); }
    /// The facets of an isotropic rough boundary whose normal is not perturbed.
    std::optional<MicrofacetSurface> IsotropicFacets() const;

    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
        return hasOwnFrame ? EvaluateInOwnFrame(wo, wi, context) : bxdf->Evaluate(wo, wi, context);
    }
    /// The density that Evaluate() says, without a value: needs no random numbers where BxDF::Pdf() needs
    /// none.
    float Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const;
    /// The same with numbers from context.rng.
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFContext& context) const;

  private:
    BxDFValue EvaluateInOwnFrame(Vec3 wo, Vec3 wi, const BxDFContext& context) const;
    std::optional<BxDFSample> SampleInOwnFrame(Vec3 wo, const BxDFRandom& u,
                                               const BxDFContext& context) const;
};

/// A stretch of a slab, and the densities with which free flights along it end.
struct Crossing {
    SampledSpectrum transmittance{1};
    // Where extinctions differ these are means over the wavelengths: they depend on the stretch only, as the
    // weights of strategies need it.
    float pdfInside = 0;    ///< of ending inside the slab, at the stretch's end, per unit of x
    float pdfBoundary = 1;  ///< probability of getting that far, to a boundary

    float Pdf(bool endsInside) const { return endsInside ? pdfInside : pdfBoundary; }
};

/// Where a flight through a slab ended.
struct Flight {
    bool scatters = false;  ///< inside, at depth x; else at the boundary that it headed for
    float x = 0;            ///< depth in [0, 1], downward
    float pdf = 1;          ///< of ending there: per unit of x inside, a probability at a boundary
    Crossing crossing;      ///< from start to end
};

/// A direction drawn at a scattering vertex.
struct SlabSample {
    Vec3 wi;
    SampledSpectrum weight;  ///< Scatter().f over the density of the draw: per unit of x
    float pdf, pdfReverse;   ///< those of Scatter()
};

/// Matter between two interfaces. Depth x runs from 0 at the top to 1 at the bottom. Extinction and albedo by
/// direction must be the same at all of the wavelengths (SlabMaterial ends the others).
struct Slab {
    SampledSpectrum opticalThickness{0};   ///< sigma_t times thickness, for a vertical path [1]
    SampledSpectrum albedo{0};             ///< single-scattering albedo, in [0,1]
    const PhaseFunction* phase = nullptr;  ///< null only if nothing scatters

    Slab() = default;  ///< empty
    Slab(SampledSpectrum thickness, SampledSpectrum scatteringAlbedo, const PhaseFunction* phaseFunction);

    bool IsClear() const { return isClear_; }
    /// False where flights pass for certain: nothing there, or absorption only.
    bool Scatters() const { return scatters_; }
    /// True if the extinction is the same at all wavelengths.
    bool IsGray() const { return isGray_; }
    /// The phase function if it is that of Henyey and Greenstein, else null.
    const HenyeyGreensteinPhase* GetHenyeyGreenstein() const { return henyeyGreenstein_; }
    /// Albedo times optical thickness.
    SampledSpectrum Scattering() const { return scattering_; }
    /// A stretch of depth `dx` along w (unit).
    Crossing Cross(Vec3 w, float dx) const {
        return isClear_ ? Crossing() : CrossAt(ExtinctionPerDepth(w), dx);
    }
    /// The same, with ExtinctionPerDepth(w) at hand.
    Crossing CrossAt(float extinctionPerDepth, float dx) const {
        if (isClear_) return {};
        const float path = dx * extinctionPerDepth;
        if (isGray_) {
            const float t = Exp(-opticalThickness[0] * path);
            if (!scatters_) return {SampledSpectrum(t)};
            return {SampledSpectrum(t), opticalThickness[0] * extinctionPerDepth * t, t};
        }
        const SampledSpectrum t = Exp(-(opticalThickness * path));
        if (!scatters_) return {t};
        return {t, (opticalThickness * t).Average() * extinctionPerDepth, t.Average()};
    }
    /// Extinction along w per unit of depth, in units of sigma_t.
    float ExtinctionPerDepth(Vec3 w) const { return RelativeExtinction(w) / AbsCos(w); }
    /// A free flight from depth x along w. In a scattering slab the distance is drawn by the extinction of
    /// one wavelength, chosen in proportion to `throughput`: that keeps the sum of the throughputs from
    /// growing however different the extinctions are.
    /// @param forcedShare  in [0, 1): so often the flight is made to scatter, at a depth that is uniform over
    ///                     what lies ahead, for walks that count only if they do. It enters `pdf`, not
    ///                     `crossing`.
    Flight SampleFlight(float x, Vec3 w, SampledSpectrum throughput, Rng& rng, float forcedShare = 0) const {
        return SampleFlightAt(isClear_ ? 0.f : ExtinctionPerDepth(w), x, w, throughput, rng, forcedShare);
    }
    /// The same, with ExtinctionPerDepth(w) at hand. Inline for slabs of one extinction: a result in memory
    /// is what a walk would wait for.
    Flight SampleFlightAt(float extinctionPerDepth, float x, Vec3 w, SampledSpectrum throughput, Rng& rng,
                          float forcedShare = 0) const {
        const bool isDown = w.z < 0;
        const float room = isDown ? 1 - x : x, end = isDown ? 1.f : 0.f;
        if (!scatters_) return {false, end, 1, CrossAt(extinctionPerDepth, room)};
        if (!isGray_ || forcedShare > 0)
            return SampleOtherFlight(extinctionPerDepth, x, w, throughput, rng, forcedShare);
        const float extinction = opticalThickness[0] * extinctionPerDepth;
        // What is drawn is the transmittance up to where the flight would end.
        const float drawn = 1 - rng.Uniform(), optical = -Log(drawn);
        const bool scatters = optical < extinction * room;
        const float dx = optical / extinction, t = scatters ? drawn : Exp(-extinction * room);
        Flight flight;
        flight.scatters = scatters;
        flight.x = scatters ? (isDown ? x + dx : x - dx) : end;
        flight.crossing.transmittance = SampledSpectrum(t);
        flight.crossing.pdfInside = extinction * t;
        flight.crossing.pdfBoundary = t;
        flight.pdf = scatters ? extinction * t : t;
        return flight;
    }
    /// What a scattering vertex multiplies a path with: albedo * extinction * p (the first two along wo), per
    /// unit of x and sr; with the densities of the direction. wo and wi point away from the vertex.
    /// Where they depend on the wavelength the densities are means, as those of Crossing.
    BxDFValue Scatter(Vec3 wo, Vec3 wi) const {
        if (!henyeyGreenstein_) return ScatterOther(wo, wi);
        const PhaseValue value = henyeyGreenstein_->Evaluate(wo, wi);
        return {scattering_ * value.p, value.pdf, value.pdfReverse};
    }
    /// A phase function that depends on the wavelength is drawn for one that is chosen in proportion to
    /// `throughput`, as SampleFlight() does.
    SlabSample SampleScatter(Vec3 wo, SampledSpectrum throughput, Rng& rng) const {
        if (!henyeyGreenstein_) return SampleOtherScatter(wo, throughput, rng);
        const PhaseSample s = henyeyGreenstein_->Sample(wo, rng);
        return {s.wi, scattering_ * s.weight, s.pdf, s.pdfReverse};
    }

    /// |cos| of a segment; kept from 0, where 0 times infinity would follow.
    static float AbsCos(Vec3 w) { return std::max(std::abs(w.z), 1e-12f); }

  private:
    /// Of the medium, in units of sigma_t.
    float RelativeExtinction(Vec3 w) const { return isDirectional_ ? phase->Extinction(w) : 1.f; }
    /// What of it is scattered, in units of the albedo.
    float RelativeScattering(Vec3 w) const {
        return hasDirectionalAlbedo_ ? phase->Extinction(w) * phase->Albedo(w) : RelativeExtinction(w);
    }
    Flight SampleOtherFlight(float extinctionPerDepth, float x, Vec3 w, SampledSpectrum throughput, Rng& rng,
                             float forcedShare) const;
    BxDFValue ScatterOther(Vec3 wo, Vec3 wi) const;
    SlabSample SampleOtherScatter(Vec3 wo, SampledSpectrum throughput, Rng& rng) const;
    BxDFValue ScatterSpectral(Vec3 wo, Vec3 wi) const;
    SlabSample SampleSpectral(Vec3 wo, SampledSpectrum throughput, Rng& rng) const;

    SampledSpectrum scattering_{0};                            ///< albedo times optical thickness
    const HenyeyGreensteinPhase* henyeyGreenstein_ = nullptr;  ///< the phase function, if it is one
    bool isClear_ = true, scatters_ = false, isGray_ = true, isDirectional_ = false;
    bool hasChromaticPhase_ = false, hasDirectionalAlbedo_ = false;
};

/// Interfaces 0 ... N-1 from the outside in and N-1 slabs between them; slab i lies between interfaces i and
/// i+1. Numbers of one surface point: lives in an Arena together with what it refers to.
struct Stack {
    std::span<const StackInterface> interfaces;
    std::span<const Slab> slabs;
    float eta = 1;  ///< index below the last interface over index above the first
    /// Tables of a boundary that is mostly the first interface's, which AreOf() tells; null: none.
    const CoatCurves* topCurves = nullptr;

    int Last() const { return int(interfaces.size()) - 1; }
    /// True if some slab sends light into other directions.
    bool Scatters() const;
    /// The interface that light from the side of w (above or below the stack) meets first.
    int OuterTowards(Vec3 w) const { return w.z > 0 ? 0 : Last(); }
};

}  // namespace lacquer::layered
