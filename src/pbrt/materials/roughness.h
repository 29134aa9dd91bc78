// The roughness parameters that materials share.
#pragma once

#include <string>
#include <utility>

#include "pbrt/base/bxdf.h"
#include "pbrt/base/texture.h"
#include "pbrt/core/arena.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer {

/// `roughness`, `uroughness`, `vroughness`, `remaproughness` and `distribution` of a rough boundary.
class RoughnessTextures {
  public:
    /// Reads the parameters. `roughness` is looked up only where an axis needs it: given beside
    /// both others it has no effect and is left over as unused, as in pbrt.
    /// @param prefix    before the three names, as in "interface.roughness"
    /// @param fallback  what `roughness` is by default
    /// Errors: SceneError for an unknown `distribution`.
    static RoughnessTextures Read(const Params& params, TextureLibrary& textures,
                                  const std::string& prefix = "", float fallback = 0);

    /// What the microfacet distribution uses: alpha = sqrt(roughness) where remapped, else the roughness
    /// itself.
    Alphas At(const TextureContext& context) const {
        const float u = u_->Evaluate(context), v = v_ == u_ ? u : v_->Evaluate(context);
        return remap_ ? Alphas(RoughnessToAlpha(u), RoughnessToAlpha(v)) : Alphas(u, v);
    }
    MicrofacetModel Model() const { return model_; }
    bool IsConstant() const { return u_->Constant() && v_->Constant(); }

  private:
    const FloatTexture* u_ = nullptr;
    const FloatTexture* v_ = nullptr;
    bool remap_ = true;
    MicrofacetModel model_ = MicrofacetModel::TrowbridgeReitz;
};

/// A new BxDF<Distribution>(arguments...) in the arena, for the distribution that `model` names.
template <template <class> class BxDFOf, class... Args>
BxDF* NewMicrofacetBxDF(MicrofacetModel model, Arena& arena, Args&&... args) {
    if (model == MicrofacetModel::Beckmann) return arena.New<BxDFOf<Beckmann>>(std::forward<Args>(args)...);
    return arena.New<BxDFOf<TrowbridgeReitz>>(std::forward<Args>(args)...);
}

}  // namespace lacquer
