// Latents whose maps are nearest to given ones.
#pragma once

#include "materialgan/fit/latent_descent.h"

namespace lacquer::materialgan {

/// Descends the mean squared difference from `maps`, 1 x 9 x R x R. Parameters as of DescendLatents().
LatentDescent EmbedMaps(const StyleGenerator& generator, const Tensor& maps, const LatentTensors& start,
                        const LatentSchedule& schedule, Observer* observer,
                        const std::function<Tensor(const Tensor&)>& toPlus = {});

/// The latents of a smooth metal, beginning with what the encoder makes of one, if there is an encoder, or
/// else with the mean material. @param generator  that of the file
LatentDescent EmbedSmoothMetal(const GeneratorFile& file, const StyleGenerator& generator,
                               capture::FitCheckpoint* checkpoint, Observer* observer);

/// Puts the latents into the file that the generator was read from, at the end of a training, so that fits
/// find them, unless that file has changed since, or cannot be written, which is no matter.
/// @return  whether they are there
bool StoreStartLow(const GeneratorFile& file, const LatentTensors& start);

}  // namespace lacquer::materialgan
