// The `eta` of dielectric materials.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "pbrt/core/params.h"
#include "pbrt/core/sampled_spectrum.h"

namespace lacquer {

/// An index of refraction: `"float eta"`, or a spectrum (a glass by name, samples, a file), else 1.5, as a
/// default-made one has it.
class IndexOfRefraction {
  public:
    /// Errors: SceneError for a number that is negative or not finite.
    static IndexOfRefraction Read(const Params& params, const std::string& name = "eta");

    /// The index for a path: at its first wavelength, the others being ended, if it varies with wavelength. A
    /// value that is 0 or no number counts as 1 (a table asked outside of its range); the result lies in
    /// [1e-3, 1e3].
    float At(SampledWavelengths& lambda) const;
    /// The same limits for an index from elsewhere.
    static float Limited(float eta) {
        return eta == 0 || std::isnan(eta) ? 1.f : std::clamp(eta, 1e-3f, 1e3f);
    }

  private:
    std::shared_ptr<const Spectrum> spectrum_ = std::make_shared<ConstantSpectrum>(1.5f);
};

}  // namespace lacquer
