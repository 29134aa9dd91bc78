// Latents as tensors, and those that a generator is known to have.
#pragma once

#include "materialgan/material_prior.h"
#include "materialgan/network/generator_file.h"

namespace lacquer::materialgan {

LatentTensors ToTensors(const Latents& latents, const GeneratorConfig& config);
Latents FromTensors(const LatentTensors& latents);

/// The mean w everywhere, and no noise.
LatentTensors MeanLatents(const GeneratorFile& file);
/// What the encoder makes of maps, 1 x 9 x R x R: the mean. Without gradients.
LatentTensors EncodedLatents(const GeneratorFile& file, const Tensor& maps);

}  // namespace lacquer::materialgan
