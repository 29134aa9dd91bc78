// The parameters that say what a metal is, which materials share.
#pragma once

#include <string>

#include "pbrt/base/texture.h"

namespace lacquer {

/// `eta` and `k`, or `reflectance`.
class MetalTextures {
  public:
    /// A complex index of refraction.
    struct Index {
        SampledSpectrum eta{1}, k{0};  ///< each in [0, 1e6]
    };

    /// Reads the parameters: `"spectrum texture eta"` and `k`, by default those of the built-in metal that
    /// `metal` names ("Cu", "Al"), or `"spectrum texture reflectance"`, that at normal incidence.
    /// @param prefix  before the names of the index, as in "conductor.eta"
    /// Errors: SceneError where both are given.
    static MetalTextures Read(const Params& params, TextureLibrary& textures, const std::string& prefix,
                              const std::string& metal);

    /// The index at a point, over that of the medium above. A reflectance is one beside the vacuum: the index
    /// above divides also what follows from it, and under a coat the metal reflects less.
    Index At(const TextureContext& context, const SampledWavelengths& lambda, float etaAbove) const;
    bool IsConstant() const;

  private:
    const SpectrumTexture* eta_ = nullptr;
    const SpectrumTexture* k_ = nullptr;
    const SpectrumTexture* reflectance_ = nullptr;  ///< null where the index is given
};

}  // namespace lacquer
