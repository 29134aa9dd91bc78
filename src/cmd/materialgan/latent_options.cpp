#include "cmd/materialgan/latent_options.h"

namespace lacquer::cmd {

using materialgan::FitOptimizer;
using materialgan::FitStart;

materialgan::LatentFitOptions LatentFitOptionsOf(const PriorArguments& a) {
    materialgan::LatentFitOptions options;
    options.iterations = a.iterations;
    options.strategy = a.strategy;
    options.optimizer = a.optimizer == "sign" ? FitOptimizer::Sign : FitOptimizer::Adam;
    materialgan::SetFeatures(a.features, &options);
    if (a.start == "encoder") options.start = FitStart::Encoder;
    if (a.start == "two") options.start = FitStart::Two;
    if (a.start == "full") options.start = FitStart::Full;
    return options;
}

}  // namespace lacquer::cmd
