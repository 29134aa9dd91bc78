#include "materialgan/training/ladder_vae.h"

#include <cmath>

namespace lacquer::materialgan {
namespace {

/// How far a stored value may be off: albedo, x and y of normals, roughness, specular albedo.
constexpr float kDeviations[] = {0.12f, 0.12f, 0.12f, 0.08f, 0.08f, 0.1f, 0.1f, 0.1f, 0.1f};

Tensor SamplePosterior(const Tensor& mean, const Tensor& logVariance, const torch::Generator& random) {
    return torch::addcmul(mean, (0.5 * logVariance).exp(), NormalNumbers(mean.sizes(), random));
}

/// From N(0,1), summed over all of an image, averaged over images.
Tensor Divergence(const Tensor& mean, const Tensor& logVariance) {
    return 0.5 * (mean.square() + logVariance.exp() - 1 - logVariance).sum() / double(mean.size(0));
}

}  // namespace

LatentSample SampleLatents(const Encoding& e, torch::Generator random) {
    LatentSample sample{SamplePosterior(e.zMean, e.zLogVariance, random), {}};
    for (size_t i = 0; i < e.noiseMean.size(); ++i)
        sample.noise.push_back(SamplePosterior(e.noiseMean[i], e.noiseLogVariance[i], random));
    return sample;
}

LadderLoss EvaluateLadder(const StyleGenerator& generator, const MapEncoder& encoder, const Tensor& maps,
                          double klWeight, torch::Generator random) {
    const Encoding e = encoder.Encode(maps);
    const LatentSample sample = SampleLatents(e, std::move(random));
    const Tensor y = generator.Synthesize(generator.Repeat(generator.Map(sample.z)), sample.noise);
    const Tensor deviations =
        torch::from_blob(const_cast<float*>(kDeviations), {1, int64_t(capture::kNumChannels), 1, 1});
    const Tensor difference = y - maps;
    const Tensor reconstruction = 0.5 * (difference / deviations).square().sum() / double(maps.size(0));
    const Tensor klZ = Divergence(e.zMean, e.zLogVariance);
    Tensor klNoise = torch::zeros({});
    for (size_t i = 0; i < e.noiseMean.size(); ++i)
        klNoise = klNoise + Divergence(e.noiseMean[i], e.noiseLogVariance[i]);
    const double numValues = double(maps.numel() / maps.size(0));
    LadderLoss loss;
    loss.total = (reconstruction + klWeight * (klZ + klNoise)) / numValues;
    loss.reconstruction = reconstruction.item<double>();
    loss.klZ = klZ.item<double>();
    loss.klNoise = klNoise.item<double>();
    loss.rmse = 0.5 * std::sqrt(difference.detach().square().mean().item<double>());
    return loss;
}

}  // namespace lacquer::materialgan
