#include "estimate/infer/mixed_chain.h"

#include <cmath>

#include "estimate/infer/mala.h"
#include "pbrt/core/parallel.h"

namespace lacquer::estimate {

namespace {

/// One for smooth coordinates, zero for the others.
Vector SmoothMask(const MixedTarget& target) {
    Vector mask{Eigen::Index(target.isSmooth.size())};
    for (size_t i = 0; i < target.isSmooth.size(); ++i) mask[Eigen::Index(i)] = target.isSmooth[i] ? 1 : 0;
    return mask;
}

/// Metropolis' rule for a symmetric proposal; moves the point if it is accepted.
double AcceptSymmetric(ChainPoint proposed, Random& random, ChainPoint* point, bool* isAccepted) {
    const double ratio = proposed.logDensity - point->logDensity;
    const double probability = std::isfinite(proposed.logDensity) ? std::exp(std::min(ratio, 0.)) : 0;
    *isAccepted = random.Uniform() < probability;
    if (*isAccepted) *point = std::move(proposed);
    return probability;
}

}  // namespace

ChainState MixedChain::Start(const MixedTarget& target, const Vector& y, uint64_t kind) const {
    ChainState state;
    state.kind = kind;
    state.point.y = y;
    state.point.logDensity = target.kinds[kind]->LogDensity(y, &state.point.gradient);
    state.metric = SmoothMask(target);
    state.adaptation.logStep = std::log(0.1);
    state.logSteps = Vector::Constant(y.size(), std::log(0.5));
    return state;
}

double MixedChain::MoveSmooth(const MixedTarget& target, Random& random, ChainState* state) const {
    const LangevinStep step =
        TakeLangevinStep(*target.kinds[state->kind], std::exp(state->adaptation.logStep), state->metric,
                         random, &state->point);
    if (state->step < warmup_) {
        const double gain = std::pow(++state->adaptation.count, -0.6);
        state->adaptation.logStep += gain * (step.acceptProbability - Mala::kTargetAcceptance);
    }
    return step.acceptProbability;
}

double MixedChain::MoveKind(const MixedTarget& target, Random& random, ChainState* state) const {
    const size_t other = random.Index(target.kinds.size() - 1), kind = other + (other >= state->kind ? 1 : 0);
    ChainPoint proposed = state->point;
    proposed.logDensity = target.kinds[kind]->LogDensity(proposed.y, &proposed.gradient);
    bool isAccepted = false;
    const double probability = AcceptSymmetric(std::move(proposed), random, &state->point, &isAccepted);
    if (isAccepted) state->kind = kind;
    return probability;
}

double MixedChain::MoveCoordinate(const MixedTarget& target, Eigen::Index coordinate, Random& random,
                                  ChainState* state) const {
    double& logStep = state->logSteps[coordinate];
    ChainPoint proposed = state->point;
    proposed.y[coordinate] += std::exp(logStep) * random.Normal();
    proposed.logDensity = target.kinds[state->kind]->LogDensity(proposed.y, &proposed.gradient);
    bool isAccepted = false;
    const double probability = AcceptSymmetric(std::move(proposed), random, &state->point, &isAccepted);
    // 0.44 is the best acceptance in one dimension [Roberts and Rosenthal 2009].
    if (state->step < warmup_) logStep += std::pow(double(state->step) / 10 + 1, -0.6) * (probability - 0.44);
    return probability;
}

void MixedChain::AdaptMetric(const MixedTarget& target, ChainState* state) const {
    if (state->step * 8 / warmup_ % 2 == 1) state->window.Add(state->point.y);
    for (const uint64_t quarter : {1u, 2u, 3u}) {
        if (!IsWindowEnd(state->step, warmup_, quarter, 4) || state->window.count < 2) continue;
        state->metric = state->window.Regularized().cwiseProduct(SmoothMask(target));
        state->window = {};
    }
}

Draw MixedChain::Advance(const MixedTarget& target, uint64_t chain, ChainState* state) const {
    Random random(seed_, chain, state->step);
    std::vector<Eigen::Index> rough;
    for (size_t i = 0; i < target.isSmooth.size(); ++i)
        if (!target.isSmooth[i]) rough.push_back(Eigen::Index(i));
    const bool hasSmooth = rough.size()<target.isSmooth.size(), hasKinds = target.kinds.size()> 1;
    const size_t numOthers = rough.size() + (hasKinds ? 1 : 0);
    const Vector before = state->point.y;
    const uint64_t kindBefore = state->kind;
    double probability = 0;
    if (numOthers == 0 || (hasSmooth && random.Uniform() < kSmoothPart)) {
        probability = MoveSmooth(target, random, state);
    } else {
        const size_t which = random.Index(numOthers);
        probability = which < rough.size() ? MoveCoordinate(target, rough[which], random, state)
                                           : MoveKind(target, random, state);
    }
    if (state->step < warmup_) AdaptMetric(target, state);
    ++state->step;
    return {.y = state->point.y,
            .logDensity = state->point.logDensity,
            .kind = state->kind,
            .acceptStat = probability,
            .stepSize = std::exp(state->adaptation.logStep),
            .numLeapfrog = 1,
            .isAccepted = state->kind != kindBefore || state->point.y != before,
            .energy = -state->point.logDensity};
}

std::vector<std::vector<Draw>> MixedChain::Run(const MixedTarget& target, uint64_t numSteps,
                                               std::vector<ChainState>* states, Observer* observer) const {
    std::vector<std::vector<Draw>> draws(states->size());
    ParallelFor(int64_t(states->size()), [&](int64_t chain) {
        ChainState& state = (*states)[size_t(chain)];
        while (state.step < numSteps && !(observer && observer->ShouldStop())) {
            draws[size_t(chain)].push_back(Advance(target, uint64_t(chain), &state));
            if (observer) observer->Advance(1);
        }
    });
    return draws;
}

}  // namespace lacquer::estimate
