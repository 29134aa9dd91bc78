// One point of a material: BxDFs at fixed wavelengths, and the colours of what they scatter.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "measure/color_mean.h"
#include "pbrt/base/material.h"

namespace lacquer::measure {

/// One point of a material, as BxDFs at several sets of wavelengths that together cover the visible range.
/// A mean over the sets, each value turned into RGB by ToRGB() of its set, is linear sRGB under the white of
/// sRGB (D65): 1, 1, 1 where every wavelength has the value 1. A mix is a list of variants: draws of it.
class BsdfSubject {
  public:
    /// Sets of wavelengths: enough for smooth spectra to some 1e-3 of the value.
    static constexpr int kNumSets = 8;

    /// @param uv  where the textures are looked up (point-sampled; at the origin of space). Normal maps and
    /// displacements of the material as a whole are no part of its BxDF and have no effect.
    /// Errors: SceneError at `loc` for a material that scatters nothing.
    /// @param isStochastic  if it is known; finding it out takes 512 evaluations
    BsdfSubject(const Material& material, Point2 uv, const FileLoc& loc,
                std::optional<bool> isStochastic = std::nullopt);

    /// Draws of a mix, else 1.
    int NumVariants() const { return int(bxdfs_.size()) / kNumSets; }
    /// The BxDF of set `i % kNumSets` and variant `i / kNumSets % NumVariants()`: consecutive indices take
    /// all sets in turn.
    const BxDF& At(int64_t i) const { return *bxdfs_[size_t(i % int64_t(bxdfs_.size()))]; }
    RGB ToRGB(SampledSpectrum value, int64_t i) const;
    /// `scale` f(wo, wi) [1/sr], without the cosine, in linear sRGB: the mean of `numBatches` evaluations at
    /// each set of wavelengths, and of the variants of a mix as far as there are batches. The errors are
    /// those of stochastic models and of mixes.
    ColorMean Evaluate(Vec3 wo, Vec3 wi, TransportMode mode, int64_t numBatches, Rng& rng,
                       double scale = 1) const;
    /// The lobes of all BxDFs together.
    Lobes Flags() const { return flags_; }
    /// False if repeated evaluations of one pair of directions give one value.
    bool IsStochastic() const { return isStochastic_; }

  private:
    bool FindNoise() const;

    /// Linear sRGB of values at the wavelengths of one set: one row for each channel.
    struct ColorWeights {
        SampledSpectrum r, g, b;
    };
    Arena arena_;
    std::vector<const BxDF*> bxdfs_;     ///< [variant][set]
    std::vector<ColorWeights> weights_;  ///< likewise
    Lobes flags_ = Lobes::None;
    bool isStochastic_ = false;
};

}  // namespace lacquer::measure
