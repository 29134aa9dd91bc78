// A variational autoencoder whose decoder is the generator, and whose latents are z and the noise maps.
#pragma once

#include "materialgan/network/encoder.h"
#include "materialgan/network/stylegan.h"

namespace lacquer::materialgan {

/// Mean over a batch, in nats for an image.
struct LadderLoss {
    Tensor total;  ///< divided by the number of values of an image
    double reconstruction = 0, klZ = 0, klNoise = 0;
    double rmse = 0;  ///< of stored values, as parts of their range
};

/// The negative evidence lower bound [Kingma and Welling 2014] with latents at all resolutions
/// [Sonderby et al. 2016]: squared differences over variances that are fixed for each channel, and what the
/// posterior of z and of each noise map is away from N(0,1).
/// @param klWeight  of the latter; below 1 at the start
LadderLoss EvaluateLadder(const StyleGenerator& generator, const MapEncoder& encoder, const Tensor& maps,
                          double klWeight, torch::Generator random);

/// A sample of the distributions.
struct LatentSample {
    Tensor z;
    std::vector<Tensor> noise;
};
LatentSample SampleLatents(const Encoding& encoding, torch::Generator random);

}  // namespace lacquer::materialgan
