#include "estimate/infer/hmc.h"

#include <cmath>

#include "estimate/infer/mala.h"

namespace lacquer::estimate {

namespace {

// [Hoffman and Gelman 2014], sec. 3.2.1
constexpr double kGamma = 0.05, kOffset = 10, kKappa = 0.75;

void Restart(double step, StepAdaptation* a) {
    *a = {.logStep = std::log(step), .logStepAverage = std::log(step), .center = std::log(10 * step)};
}

void Learn(double error, StepAdaptation* a) {
    ++a->count;
    const double gain = 1 / (a->count + kOffset);
    a->error += gain * (error - a->error);
    a->logStep = a->center - std::sqrt(a->count) / kGamma * a->error;
    const double weight = std::pow(a->count, -kKappa);
    a->logStepAverage += weight * (a->logStep - a->logStepAverage);
}

/// Leapfrog with velocity M p; false where the density has become zero.
bool Integrate(const Target& target, double step, const Vector& metric, int count, Vector* momentum,
               ChainPoint* point) {
    for (int i = 0; i < count; ++i) {
        *momentum += 0.5 * step * point->gradient;
        point->y += step * metric.cwiseProduct(*momentum);
        point->logDensity = target.LogDensity(point->y, &point->gradient);
        if (!std::isfinite(point->logDensity)) return false;
        *momentum += 0.5 * step * point->gradient;
    }
    return true;
}

}  // namespace

ChainState Hmc::Start(const Target& target, const Vector& y) const {
    ChainState state = Sampler::Start(target, y);
    Restart(options_.firstStep, &state.adaptation);
    return state;
}

void Hmc::Adapt(double acceptProbability, ChainState* state) const {
    Learn(options_.targetAcceptance - acceptProbability, &state->adaptation);
    if (state->step * 6 / Warmup() % 2 == 1) state->window.Add(state->point.y);
    for (const uint64_t third : {1u, 2u}) {
        if (!IsWindowEnd(state->step, Warmup(), third, 3) || state->window.count < 2) continue;
        const Vector metric = state->window.Regularized();
        // A step of this size in the new metric covers what it did in the old one, in the mean.
        const double ratio = std::exp(0.5 * (state->metric.array() / metric.array()).log().mean());
        state->metric = metric;
        state->window = {};
        Restart(std::exp(state->adaptation.logStepAverage) * ratio, &state->adaptation);
    }
    if (state->step + 1 == Warmup()) state->adaptation.logStep = state->adaptation.logStepAverage;
}

Draw Hmc::Advance(const Target& target, uint64_t chain, ChainState* state) const {
    Random random = NumbersOf(chain, *state);
    const double size = std::exp(state->adaptation.logStep);
    const int count = 1 + int(random.Index(size_t(options_.maxLeapfrog)));
    const Vector& metric = state->metric;
    Vector momentum = random.Normals(metric.size()).cwiseQuotient(metric.cwiseSqrt());
    const auto energyOf = [&](const ChainPoint& p) {
        return -p.logDensity + 0.5 * momentum.cwiseAbs2().dot(metric);
    };
    const double before = energyOf(state->point);
    ChainPoint proposed = state->point;
    const bool isInside = Integrate(target, size, metric, count, &momentum, &proposed);
    const double after = isInside ? energyOf(proposed) : std::numeric_limits<double>::infinity();
    const double logRatio = before - after;
    const double acceptProbability = std::isnan(logRatio) ? 0 : std::exp(std::min(logRatio, 0.));
    const bool isAccepted = random.Uniform() < acceptProbability;
    if (isAccepted) state->point = std::move(proposed);
    if (IsWarmup(*state)) Adapt(acceptProbability, state);
    ++state->step;
    return {.y = state->point.y,
            .logDensity = state->point.logDensity,
            .acceptStat = acceptProbability,
            .stepSize = size,
            .numLeapfrog = count,
            .isDivergent = !(logRatio >= -kDivergence),
            .isAccepted = isAccepted,
            .energy = isAccepted ? after : before};
}

}  // namespace lacquer::estimate
