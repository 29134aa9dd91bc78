#include "estimate/infer/chain.h"

#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::estimate {

void WindowVariances::Add(const Vector& y) {
    if (count == 0) {
        mean = Vector::Zero(y.size());
        squares = Vector::Zero(y.size());
    }
    ++count;
    const Vector before = y - mean;
    mean += before / count;
    squares += before.cwiseProduct(y - mean);
}

Vector WindowVariances::Regularized() const { return ((squares.array() + 5e-3) / (count + 5)).matrix(); }

ChainState Sampler::Start(const Target& target, const Vector& y) const {
    ChainState state;
    state.point.y = y;
    state.point.logDensity = target.LogDensity(y, &state.point.gradient);
    state.metric = Vector::Ones(y.size());
    return state;
}

std::vector<std::vector<Draw>> RunChains(const Sampler& sampler, const Target& target, uint64_t numSteps,
                                         std::vector<ChainState>* states, Observer* observer) {
    std::vector<std::vector<Draw>> draws(states->size());
    ParallelFor(int64_t(states->size()), [&](int64_t chain) {
        ChainState& state = (*states)[size_t(chain)];
        while (state.step < numSteps && !(observer && observer->ShouldStop())) {
            draws[size_t(chain)].push_back(sampler.Advance(target, uint64_t(chain), &state));
            if (observer) observer->Advance(1);
        }
    });
    return draws;
}

Matrix CoordinateOf(const std::vector<std::vector<Draw>>& chains, size_t firstDraw, Eigen::Index coordinate) {
    LACQUER_CHECK(!chains.empty() && chains[0].size() >= firstDraw);
    Matrix values{Eigen::Index(chains[0].size() - firstDraw), Eigen::Index(chains.size())};
    for (size_t c = 0; c < chains.size(); ++c) {
        LACQUER_CHECK(chains[c].size() == chains[0].size());
        for (size_t i = firstDraw; i < chains[c].size(); ++i)
            values(Eigen::Index(i - firstDraw), Eigen::Index(c)) = chains[c][i].y[coordinate];
    }
    return values;
}

}  // namespace lacquer::estimate
