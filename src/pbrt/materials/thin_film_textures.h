// The parameters of a thin film, which materials share.
#pragma once

#include <string>

#include "pbrt/base/texture.h"
#include "pbrt/scattering/thin_film.h"

namespace lacquer {

/// `thinfilm_thickness`, `thinfilm_eta` and `thinfilm_k` of a boundary.
class ThinFilmTextures {
  public:
    /// No film.
    ThinFilmTextures() = default;
    /// Reads the parameters: `"float texture thinfilm_thickness"` [nm], without which there is no film;
    /// `thinfilm_eta` (default 1.4) and `thinfilm_k` (0), each `"float"`, `"spectrum"` or `"texture"`.
    /// Errors: SceneError for a negative thickness, one above kMaxFilmThickness, indices that are not
    /// positive, and for a film without a thickness.
    static ThinFilmTextures Read(const Params& params, TextureLibrary& textures);

    /// Of a parameter that says something of a film. Errors: SceneError if there is none, for want of a
    /// thickness.
    static void RequireThickness(const Params& params, const std::string& name);

    /// The film at a point; none where its thickness is 0. Values of textures are kept within their limits.
    /// @param etaAbove  of the medium above
    std::optional<ThinFilm> At(const TextureContext& context, const SampledWavelengths& lambda,
                               float etaAbove) const;
    bool IsConstant() const;

  private:
    const FloatTexture* thickness_ = nullptr;
    const SpectrumTexture* eta_ = nullptr;
    const SpectrumTexture* k_ = nullptr;
};

}  // namespace lacquer
