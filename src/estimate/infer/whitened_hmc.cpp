#include "estimate/infer/whitened_hmc.h"

#include "estimate/infer/population.h"
#include "pbrt/core/check.h"

namespace lacquer::estimate {

WhitenedSampler::WhitenedSampler(const Target& target, const Matrix& sample,
                                 std::unique_ptr<const Sampler> sampler)
    : sample_(sample),
      transform_(CholeskyFactor(CovarianceOfColumns(sample))),
      center_(sample.rowwise().mean()),
      target_(target, center_, transform_),
      sampler_(std::move(sampler)) {
    LACQUER_CHECK(sample.cols() > sample.rows());
}

std::vector<ChainState> WhitenedSampler::Start(size_t numChains) const {
    std::vector<ChainState> states;
    for (size_t i = 0; i < numChains; ++i) {
        const auto column = Eigen::Index((2 * i + 1) * size_t(sample_.cols()) / (2 * numChains));
        const Vector q = transform_.triangularView<Eigen::Lower>().solve(sample_.col(column) - center_);
        states.push_back(sampler_->Start(target_, q));
    }
    return states;
}

std::vector<std::vector<Draw>> WhitenedSampler::Run(uint64_t numSteps, std::vector<ChainState>* states,
                                                    Observer* observer) const {
    std::vector<std::vector<Draw>> chains = RunChains(*sampler_, target_, numSteps, states, observer);
    for (auto& chain : chains)
        for (Draw& draw : chain) draw.y = target_.Original(draw.y);
    return chains;
}

}  // namespace lacquer::estimate
