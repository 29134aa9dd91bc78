#include "materialgan/training/gan_losses.h"

#include <cmath>
#include <numbers>

namespace lacquer::materialgan {
namespace {

constexpr double kMixing = 0.9;

}  // namespace

Tensor DiscriminatorLoss(const Tensor& ofReal, const Tensor& ofFake) {
    return torch::softplus(-ofReal).mean() + torch::softplus(ofFake).mean();
}

Tensor GeneratorLoss(const Tensor& ofFake) { return torch::softplus(-ofFake).mean(); }

Tensor GradientPenalty(const Discriminator& discriminator, const Tensor& real) {
    const Tensor images = real.detach().requires_grad_();
    const Tensor sum = discriminator.Judge(images).sum();
    const Tensor gradient = torch::autograd::grad({sum}, {images}, {}, /*retain_graph=*/true,
                                                  /*create_graph=*/true)[0];
    return 0.5 * gradient.square().sum({1, 2, 3}).mean();
}

Tensor PathLengths(const StyleGenerator& generator, const Tensor& w, torch::Generator random) {
    const std::vector<Tensor> noise = generator.RandomNoise(w.size(0), random);
    const Tensor images = generator.Synthesize(generator.Repeat(w), noise);
    const Tensor sum = (images * NormalNumbers(images.sizes(), random)).sum();
    const Tensor gradient =
        torch::autograd::grad({sum}, {w}, {}, /*retain_graph=*/true, /*create_graph=*/true)[0];
    return gradient.square().sum(1).sqrt();
}

double PathLengthWeight(int resolution) {
    const double r = resolution;
    return std::numbers::ln2 / (r * r * (std::log(r) - std::numbers::ln2));
}

Tensor MixedStyles(const StyleGenerator& generator, int64_t batch, torch::Generator random) {
    const GeneratorConfig& config = generator.Config();
    const Tensor z = NormalNumbers({2 * batch, config.latentSize}, random);
    const std::vector<Tensor> w = generator.Map(z).split(batch);
    // Columns from the crossover on are of the second material; beyond the last one: of none.
    const int64_t columns = config.NumColumns();
    const Tensor crossover = torch::randint(1, columns, {batch, 1}, random),
                 mixes = torch::empty({batch, 1}).uniform_(0, 1, random) < kMixing;
    const Tensor isSecond = torch::arange(columns).unsqueeze(0) >=
                            torch::where(mixes, crossover, torch::full_like(crossover, columns));
    return torch::where(isSecond.unsqueeze(-1), generator.Repeat(w[1]), generator.Repeat(w[0]));
}

}  // namespace lacquer::materialgan
