// One point of a material at wavelengths that the caller chooses.
#pragma once

#include <span>
#include <vector>

#include "pbrt/base/material.h"
#include "pbrt/core/error.h"
#include "pbrt/core/progress.h"

namespace lacquer::measure {

/// BxDFs of one point, each for as many wavelengths as a path carries; for a single one where the material
/// disperses. A mix is a list of draws, as in BsdfSubject.
class SpectralSubject {
  public:
    /// @param uv           where the textures are looked up, as for BsdfSubject
    /// @param wavelengths  [nm], at least one
    /// Errors: SceneError at `loc` for a material that scatters nothing.
    SpectralSubject(const Material& material, Point2 uv, std::span<const float> wavelengths,
                    const FileLoc& loc);

    size_t NumWavelengths() const { return numWavelengths_; }
    /// f(wo, wi) [1/sr], without the cosine, at each wavelength: mean of `numSamples` evaluations and its
    /// standard error, which is NaN for one.
    /// @param mean, error  as many as wavelengths
    /// @param observer     may stop it, between samples; what comes out then is worth nothing
    void Evaluate(Vec3 wo, Vec3 wi, TransportMode mode, int64_t numSamples, Rng& rng, std::span<double> mean,
                  std::span<double> error, Observer& observer) const;
    /// One evaluation at all wavelengths, with the same random numbers for each: the noise of a colour is
    /// then that of its lightness, mostly. @param sample  takes the draws of a mix in turn
    /// @param visit  visit(f, first, count): values at `count` wavelengths from number `first` on
    template <class Visit>
    void EvaluateOnce(int64_t sample, Vec3 wo, Vec3 wi, TransportMode mode, const Rng& rng,
                      const Visit& visit) const {
        for (const Group& group : VariantOf(sample)) {
            Rng own = rng;
            visit(group.bxdf->Evaluate(wo, wi, {.mode = mode, .rng = &own, .needsPdf = false}).f, group.first,
                  group.count);
        }
    }
    /// The same for a draw: visit(sample, first, count), where there is one.
    template <class Visit>
    void SampleOnce(int64_t sample, Vec3 wo, const BxDFRandom& u, TransportMode mode, const Rng& rng,
                    const Visit& visit) const {
        for (const Group& group : VariantOf(sample)) {
            Rng own = rng;
            if (const auto drawn = group.bxdf->Sample(wo, u, {.mode = mode, .rng = &own}))
                visit(*drawn, group.first, group.count);
        }
    }
    /// The BxDF of all wavelengths together; null unless one path carries them and the material does not
    /// disperse, or is asked for one. @param i  takes the draws of a mix in turn
    const BxDF* Together(int64_t i) const;

  private:
    struct Group {
        const BxDF* bxdf = nullptr;
        size_t first = 0, count = 1;  ///< of its wavelengths
    };
    using Variant = std::vector<Group>;
    const Variant& VariantOf(int64_t sample) const { return variants_[size_t(sample) % variants_.size()]; }
    Variant MakeVariant(const Material& material, const TextureContext& context,
                        std::span<const float> wavelengths, const FileLoc& loc);

    Arena arena_;
    size_t numWavelengths_;
    std::vector<Variant> variants_;
};

}  // namespace lacquer::measure
