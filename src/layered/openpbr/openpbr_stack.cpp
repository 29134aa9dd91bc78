#include "layered/openpbr/openpbr_stack.h"

#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/bxdfs/diffuse.h"
#include "pbrt/bxdfs/diffuse_transmission.h"
#include "pbrt/bxdfs/multiscatter_conductor.h"
#include "pbrt/bxdfs/multiscatter_dielectric.h"
#include "pbrt/bxdfs/rough_diffuse.h"
#include "pbrt/phases/sggx.h"
#include "pbrt/scattering/thin_film.h"

namespace lacquer::layered {
namespace {

using GGX = TrowbridgeReitz;

/// Optical thickness of subsurface light above the diffuse base that stands for all that is deeper.
constexpr float kSubsurfaceDepth = 16;
/// The fuzz: fibres that stand on the surface, one mean free path deep across them.
constexpr float kFuzzDepth = 1;
constexpr float kMinTransmittance = 1e-6f;
constexpr float kNanometersPerMicrometer = 1000;
/// Fraunhofer lines of Abbe's number [nm].
constexpr float kLineC = 656.2725f, kLineD = 587.5618f, kLineF = 486.1327f;

/// Widths of facets along and across the tangent, whose mean of squares does not change with the anisotropy.
Alphas AlphasOf(float roughness, float anisotropy) {
    const float alpha = Sqr(roughness), ratio = 1 - anisotropy;
    const float along = alpha * std::sqrt(2 / (1 + Sqr(ratio)));
    return {along, along * ratio};
}

/// Cauchy's law through the index at line D with an Abbe number.
float DispersedIndex(float eta, float abbe, float lambda) {
    const float spread = (eta - 1) / abbe / (1 / Sqr(kLineF) - 1 / Sqr(kLineC));
    return eta + spread * (1 / Sqr(lambda) - 1 / Sqr(kLineD));
}

/// Single-scattering albedo of a half space that reflects `color` [Kulla and Conty 2017].
SampledSpectrum AlbedoOf(SampledSpectrum color, float g) {
    return Map(color, [g](float c) {
        const float s = 4.09712f + 4.20863f * c - std::sqrt(9.59217f + c * (41.6808f + 17.7126f * c));
        return std::clamp((1 - s * s) / (1 - g * s * s), 0.f, 1.f);
    });
}

class StackMaker {
  public:
    StackMaker(const OpenPBRVariant& variant, const OpenPBRPoint& point, const OpenPBRFrames& frames,
               const LayeredOptions& options, bool rescatters, SampledWavelengths& lambda, Arena& arena)
        : v_(variant),
          p_(point),
          frames_(frames),
          options_(options),
          rescatters_(rescatters),
          lambda_(lambda),
          arena_(arena) {}

    BxDF* Make() {
        if (!v_.isThere) return Nothing();
        if (v_.hasFuzz) AddFuzz();
        if (v_.hasCoat) AddCoat();
        firstOfBase_ = count_;
        if (v_.isMetal)
            AddInterface(Metal());
        else if (v_.transmits)
            AddTranslucentBase();
        else
            AddOpaqueBase();
        return count_ == 1 && !frames_.differ ? bxdfs_[0] : Layered();
    }

  private:
    /// Fuzz, coat, and a sheet with two sides.
    static constexpr size_t kMaxLayers = 4;

    BxDF* Nothing() { return arena_.New<DielectricBxDF<GGX>>(Alphas(0, 0), 1.f); }

    /// Facets that lose less than a hundredth of the light below them scatter once. (At an alpha of 0.09 a
    /// boundary of index 1.5 over a white base loses 4 %.)
    bool Rescatters(Alphas alphas) const {
        constexpr float kMinAlpha = 0.02f;
        return rescatters_ && std::max(alphas.x, alphas.y) >= kMinAlpha;
    }
    BxDF* Dielectric(Alphas alphas, float eta) {
        if (Rescatters(alphas) && eta != 1) return arena_.New<MultiscatterDielectricBxDF<GGX>>(alphas, eta);
        return arena_.New<DielectricBxDF<GGX>>(alphas, eta);
    }

    // ---- Layers, from the outside in ----

    void AddInterface(BxDF* bxdf, float across = 1) {
        bxdfs_[count_++] = bxdf;
        eta_ *= across;
    }
    /// Below the interface that was added last.
    void AddSlab(SampledSpectrum opticalThickness, SampledSpectrum albedo, const PhaseFunction* phase) {
        slabs_[count_ - 1] = Slab(opticalThickness, albedo, phase);
    }

    void AddFuzz() {
        AddInterface(Nothing());
        AddSlab(SampledSpectrum(kFuzzDepth), p_.fuzz.color,
                arena_.New<SggxPhase>(Vec3(0, 0, 1), p_.fuzz.roughness, false));
    }

    void AddCoat() {
        AddInterface(Dielectric(AlphasOf(p_.coat.roughness, p_.coat.anisotropy), p_.coat.ior), p_.coat.ior);
        // The colour is that of light that passes twice.
        const SampledSpectrum depth = Map(Max(p_.coat.color, SampledSpectrum(kMinTransmittance)),
                                          [](float c) { return -0.5f * std::log(c); });
        if (depth) AddSlab(depth, SampledSpectrum(0), nullptr);
    }

    // ---- Bases ----

    /// Index above the base.
    float EtaAbove() const { return v_.hasCoat ? p_.coat.ior : 1; }
    Alphas BaseAlphas() const { return AlphasOf(p_.specular.roughness, p_.specular.anisotropy); }
    std::optional<ThinFilm> Film() const {
        const float thickness = p_.thinFilm.thickness * kNanometersPerMicrometer;
        if (!v_.hasFilm || !(thickness > 0)) return {};
        return ThinFilm(std::min(thickness, kMaxFilmThickness), SampledSpectrum(p_.thinFilm.ior),
                        SampledSpectrum(0), lambda_.Lambda(), EtaAbove());
    }
    SampledSpectrum BaseColor() const { return p_.base.color * p_.base.weight; }

    BxDF* Metal() {
        const Alphas alphas = BaseAlphas();
        const float weight = std::min(p_.specular.weight, 1.f);
        if (const std::optional<ThinFilm> film = Film()) {
            // Interference asks for an index: that of a metal with n = 1 and this reflectance.
            const SampledSpectrum r = Clamp(BaseColor() * weight, 0, 0.9999f);
            const FilmedMetal metal(SampledSpectrum(1), 2 * Sqrt(r / (1 - r)), *film);
            if (Rescatters(alphas)) return arena_.New<FilmedMultiscatterConductorBxDF<GGX>>(alphas, metal);
            return arena_.New<FilmedConductorBxDF<GGX>>(alphas, metal);
        }
        const TintedMetal metal(BaseColor(), p_.specular.color, weight);
        if (Rescatters(alphas)) return arena_.New<TintedMultiscatterConductorBxDF<GGX>>(alphas, metal);
        return arena_.New<TintedConductorBxDF<GGX>>(alphas, metal);
    }

    /// Index below the base's boundary over index above it.
    float BaseIndex() {
        float ior = p_.specular.ior;
        if (v_.transmits && p_.transmission.dispersionScale > 0) {
            lambda_.TerminateSecondary();
            ior =
                DispersedIndex(ior, p_.transmission.abbeNumber / p_.transmission.dispersionScale, lambda_[0]);
        }
        return WeightedIndex(ior / EtaAbove(), p_.specular.weight);
    }
    /// @param eta  index below over index above
    BxDF* BaseBoundary(float eta, SampledSpectrum transmission) {
        const std::optional<ThinFilm> film = Film();
        const bool isTinted =
            !(p_.specular.color == SampledSpectrum(1)) || !(transmission == SampledSpectrum(1));
        if (!isTinted && !film) return Dielectric(BaseAlphas(), eta);
        if (!isTinted)
            return arena_.New<FilmedDielectricBxDF<GGX>>(BaseAlphas(), FilmedDielectric(eta, *film));
        return arena_.New<TintedDielectricBxDF<GGX>>(
            BaseAlphas(), TintedDielectric(eta, film, p_.specular.color, transmission));
    }

    void AddTranslucentBase() {
        const float eta = BaseIndex();
        // What is deep is a medium inside of the shape; without one the two passages share the colour.
        const SampledSpectrum tint =
            p_.transmission.depth > 0 ? SampledSpectrum(1) : Sqrt(p_.transmission.color);
        AddInterface(BaseBoundary(eta, tint), eta);
        // A sheet has air below it as well.
        if (v_.isThinWalled) AddInterface(BaseBoundary(1 / eta_, tint), 1 / eta_);
    }

    void AddOpaqueBase() {
        const float eta = BaseIndex();
        AddInterface(BaseBoundary(eta, SampledSpectrum(1)), eta);
        if (!v_.hasSubsurface) {
            AddInterface(Diffuse());
        } else if (v_.isThinWalled) {
            const SampledSpectrum half = 0.5f * Below(p_.subsurface.color);
            AddInterface(arena_.New<DiffuseTransmissionBxDF>(half, half));
        } else {
            const SampledSpectrum color = Below(p_.subsurface.color);
            AddSlab(SampledSpectrum(kSubsurfaceDepth), AlbedoOf(color, p_.subsurface.anisotropy),
                    arena_.New<HenyeyGreensteinPhase>(p_.subsurface.anisotropy));
            AddInterface(arena_.New<DiffuseBxDF>(color));
        }
    }
    /// The reflectance of what lies below the base's interface, where `color` is that of the light which has
    /// passed it in air, without a coat: some of that is sent back, and takes colour again.
    SampledSpectrum Below(SampledSpectrum color) const {
        const float inside = p_.specular.insideReflectance;
        return color / (1 - inside + inside * color);
    }
    BxDF* Diffuse() {
        const SampledSpectrum color = Below(BaseColor());
        if (p_.base.diffuseRoughness > 0)
            return arena_.New<RoughDiffuseBxDF>(color, p_.base.diffuseRoughness);
        return arena_.New<DiffuseBxDF>(color);
    }

    /// The boundary of the fuzz is not there, and has no frame.
    Frame FrameOf(size_t i) const {
        if (i >= firstOfBase_) return frames_.base;
        return v_.hasFuzz && i == 0 ? Frame() : frames_.coat;
    }
    BxDF* Layered() {
        const std::span<BxDF*> bxdfs = arena_.NewArray<BxDF*>(count_);
        const std::span<StackInterface> interfaces = arena_.NewArray<StackInterface>(count_);
        const std::span<Slab> slabs = arena_.NewArray<Slab>(count_ - 1);
        for (size_t i = 0; i < count_; ++i) {
            bxdfs[i] = bxdfs_[i];
            interfaces[i] =
                !frames_.differ ? StackInterface(bxdfs_[i]) : StackInterface(bxdfs_[i], FrameOf(i));
            if (i + 1 < count_) slabs[i] = slabs_[i];
        }
        Stack stack;
        stack.slabs = slabs;
        stack.eta = eta_;
        LayeredOptions options = options_;
        options.isTwoSided = !interfaces.back().transmits;
        return arena_.New<LayeredBxDF>(stack, interfaces, bxdfs, options);
    }

    const OpenPBRVariant& v_;
    const OpenPBRPoint& p_;
    const OpenPBRFrames& frames_;
    const LayeredOptions& options_;
    bool rescatters_;
    SampledWavelengths& lambda_;
    Arena& arena_;
    std::array<BxDF*, kMaxLayers> bxdfs_{};
    std::array<Slab, kMaxLayers> slabs_{};
    size_t count_ = 0, firstOfBase_ = 0;
    float eta_ = 1;
};

}  // namespace

BxDF* MakeOpenPBR(const OpenPBRVariant& variant, const OpenPBRPoint& point, const OpenPBRFrames& frames,
                  const LayeredOptions& options, bool rescatters, SampledWavelengths& lambda, Arena& arena) {
    return StackMaker(variant, point, frames, options, rescatters, lambda, arena).Make();
}

}  // namespace lacquer::layered
