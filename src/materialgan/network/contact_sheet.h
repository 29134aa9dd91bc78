// Maps side by side as an image to look at.
#pragma once

#include "materialgan/network/torch_render.h"
#include "pbrt/image/image.h"

namespace lacquer::materialgan {

/// Rows of materials; of each the albedo, normal, roughness, specular albedo and a photograph with flash, one
/// below the other. Linear values, for files that store them as sRGB.
/// @param rows  batches of maps, n x 9 x R x R
Image ContactSheet(const std::vector<Tensor>& rows);

/// The views of a camera above the middle with its flash.
TorchViews FlashView();

}  // namespace lacquer::materialgan
