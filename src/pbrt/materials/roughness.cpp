#include "pbrt/materials/roughness.h"

namespace lacquer {

RoughnessTextures RoughnessTextures::Read(const Params& params, TextureLibrary& textures,
                                          const std::string& prefix, float fallback) {
    RoughnessTextures r;
    r.u_ = OptionalFloatTextureParam(params, prefix + "uroughness", textures);
    r.v_ = OptionalFloatTextureParam(params, prefix + "vroughness", textures);
    if (!r.u_ || !r.v_) {
        const FloatTexture* both = FloatTextureParam(params, prefix + "roughness", fallback, textures);
        if (!r.u_) r.u_ = both;
        if (!r.v_) r.v_ = both;
    }
    r.remap_ = params.GetBool("remaproughness", true);
    const std::string model =
        params.GetChoice("distribution", "trowbridgereitz", {"trowbridgereitz", "beckmann"});
    r.model_ = model == "beckmann" ? MicrofacetModel::Beckmann : MicrofacetModel::TrowbridgeReitz;
    return r;
}

}  // namespace lacquer
