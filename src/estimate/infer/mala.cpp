#include "estimate/infer/mala.h"

#include <cmath>

namespace lacquer::estimate {

namespace {

/// Logarithm of the density of a normal step, up to a constant; coordinates that stay do not count.
double LogStepDensity(const Vector& to, const Vector& mean, const Vector& variances) {
    double sum = 0;
    for (Eigen::Index i = 0; i < to.size(); ++i)
        if (variances[i] > 0)
            sum -= 0.5 * ((to[i] - mean[i]) * (to[i] - mean[i]) / variances[i] + std::log(variances[i]));
    return sum;
}

/// Probability of acceptance for the logarithm of the ratio; what is not a number is rejected.
double AcceptProbability(double logRatio) {
    return std::isnan(logRatio) ? 0 : std::exp(std::min(logRatio, 0.));
}

Draw Recorded(const ChainState& state, const LangevinStep& step, double size) {
    return {.y = state.point.y,
            .logDensity = state.point.logDensity,
            .acceptStat = step.acceptProbability,
            .stepSize = size,
            .numLeapfrog = 1,
            .isAccepted = step.isAccepted,
            .energy = -state.point.logDensity};
}

}  // namespace

LangevinStep TakeLangevinStep(const Target& target, double step, const Vector& metric, Random& random,
                              ChainPoint* point) {
    const Vector variances = step * step * metric;
    const Vector mean = point->y + 0.5 * variances.cwiseProduct(point->gradient);
    ChainPoint proposed;
    proposed.y = mean;
    for (Eigen::Index i = 0; i < mean.size(); ++i)
        if (variances[i] > 0) proposed.y[i] += std::sqrt(variances[i]) * random.Normal();
    proposed.logDensity = target.LogDensity(proposed.y, &proposed.gradient);
    LangevinStep result;
    if (std::isfinite(proposed.logDensity)) {
        const Vector back = proposed.y + 0.5 * variances.cwiseProduct(proposed.gradient);
        result.acceptProbability = AcceptProbability(proposed.logDensity - point->logDensity +
                                                     LogStepDensity(point->y, back, variances) -
                                                     LogStepDensity(proposed.y, mean, variances));
    }
    result.isAccepted = random.Uniform() < result.acceptProbability;
    if (result.isAccepted) *point = std::move(proposed);
    return result;
}

ChainState Mala::Start(const Target& target, const Vector& y) const {
    ChainState state = Sampler::Start(target, y);
    state.adaptation.logStep = std::log(firstStep_);
    return state;
}

Draw Mala::Advance(const Target& target, uint64_t chain, ChainState* state) const {
    Random random = NumbersOf(chain, *state);
    const double size = std::exp(state->adaptation.logStep);
    const LangevinStep step = TakeLangevinStep(target, size, state->metric, random, &state->point);
    if (IsWarmup(*state)) {
        const double gain = std::pow(double(state->step) + 1, -0.6);
        state->adaptation.logStep += gain * (step.acceptProbability - kTargetAcceptance);
        // Windows begin in the middle of the quarter that they end: what was before is not yet at its place.
        if (state->step * 8 / Warmup() % 2 == 1) state->window.Add(state->point.y);
        for (const uint64_t quarter : {1u, 2u, 3u}) {
            if (!IsWindowEnd(state->step, Warmup(), quarter, 4) || state->window.count < 2) continue;
            state->metric = state->window.Regularized();
            state->window = {};
        }
    }
    ++state->step;
    return Recorded(*state, step, size);
}

ChainState PublishedMala::Start(const Target& target, const Vector& y) const {
    ChainState state = Sampler::Start(target, y);
    state.gradientMean = Vector::Zero(y.size());
    state.gradientSquares = Vector::Zero(y.size());
    return state;
}

namespace {

// Constants of the published rule: means of .9 and .999, powers of 1/4, and 1e-6 against division by zero.
constexpr double kAlpha = 0.9, kBeta = 0.999, kPower = 0.25, kEpsilon = 1e-6;

double DampingOf(const ChainState& state) { return std::pow(std::max(kEpsilon, state.accepted), -kPower); }

}  // namespace

Vector PublishedMala::MetricOf(const ChainState& state, const Vector& gradientSquares) {
    return (kEpsilon + DampingOf(state) * gradientSquares.array().sqrt()).inverse().matrix();
}

Draw PublishedMala::Advance(const Target& target, uint64_t chain, ChainState* state) const {
    struct Proposal {
        Vector mean, variances, gradientMean, gradientSquares;
    };
    const double damping = DampingOf(*state);
    const auto proposalFrom = [&](const ChainPoint& from) {
        Proposal p;
        const Vector slope = -from.gradient;
        p.gradientMean = kAlpha * state->gradientMean + (1 - kAlpha) * slope;
        p.gradientSquares = kBeta * state->gradientSquares + (1 - kBeta) * slope.cwiseAbs2();
        p.variances = delta_ * MetricOf(*state, p.gradientSquares);
        p.mean = from.y - 0.5 * p.variances.cwiseProduct(damping * p.gradientMean + slope);
        return p;
    };
    Random random = NumbersOf(chain, *state);
    const Proposal forward = proposalFrom(state->point);
    ChainPoint proposed;
    proposed.y =
        forward.mean + forward.variances.cwiseSqrt().cwiseProduct(random.Normals(forward.mean.size()));
    proposed.logDensity = target.LogDensity(proposed.y, &proposed.gradient);
    LangevinStep step;
    if (std::isfinite(proposed.logDensity)) {
        const Proposal back = proposalFrom(proposed);
        step.acceptProbability =
            AcceptProbability(proposed.logDensity - state->point.logDensity +
                              LogStepDensity(state->point.y, back.mean, back.variances) -
                              LogStepDensity(proposed.y, forward.mean, forward.variances));
    }
    step.isAccepted = random.Uniform() < step.acceptProbability;
    if (step.isAccepted) {
        state->point = std::move(proposed);
        ++state->accepted;
    }
    state->gradientMean = forward.gradientMean;
    state->gradientSquares = forward.gradientSquares;
    ++state->step;
    return Recorded(*state, step, std::sqrt(delta_));
}

Draw MalaAfterPublished::Advance(const Target& target, uint64_t chain, ChainState* state) const {
    if (IsWarmup(*state)) return published_.Advance(target, chain, state);
    if (state->step == Warmup()) {
        state->metric = PublishedMala::MetricOf(*state, state->gradientSquares);
        state->adaptation.logStep = 0.5 * std::log(delta_);
    }
    return mala_.Advance(target, chain, state);
}

}  // namespace lacquer::estimate
