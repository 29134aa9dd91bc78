// Photographs of a flat sample as tensor operations: the model of [Guo et al. 2020b].
#pragma once

#include "capture/views.h"
#include "materialgan/network/tensors.h"

namespace lacquer::materialgan {

/// Positions and light of some photographs of one sample.
struct TorchViews {
    Tensor camera, light;  ///< V x 3 [cm]
    Tensor power;          ///< 3, or V x 3 [cm^2]
    double size = 0;       ///< edge of the sample [cm]
};
/// Of the views that are held out of the fit, or of the others.
TorchViews ViewsOf(const capture::ViewSet& set, bool ofTests);

/// Maps as a generator gives them within [-1,1], and the roughness in the range of its file.
Tensor ClampMaps(const Tensor& maps, const GeneratorConfig& config);
/// The same plus a hundredth of what is beyond: a latent fit would have no gradient there.
Tensor SoftClampMaps(const Tensor& maps, const GeneratorConfig& config);

/// Linear values for each view, B x V x 3 x R x R, without limits.
/// @param maps  B x 9 x R x R as stored; beyond [-1,1] as at its ends
Tensor RenderLinear(const Tensor& maps, const TorchViews& views);
/// The same as a photograph has it: limited to [1e-6,1], to the power 1/2.2.
Tensor RenderEncoded(const Tensor& maps, const TorchViews& views);
Tensor EncodeLinear(const Tensor& linear);

/// What the channels stand for; each B x c x R x R.
struct DecodedMaps {
    Tensor albedo, normal, roughness, specular;
};
DecodedMaps DecodeMaps(const Tensor& maps);

}  // namespace lacquer::materialgan
