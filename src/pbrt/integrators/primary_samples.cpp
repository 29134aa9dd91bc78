#include "pbrt/integrators/primary_samples.h"

#include "pbrt/core/special_functions.h"

namespace lacquer {

namespace {

/// @param u  uniform in [0,1)
float StandardNormal(float u) {
    return std::sqrt(2.f) * ErfInv(std::clamp(2 * u - 1, -1 + 2 * MachineEpsilon, 1 - 2 * MachineEpsilon));
}

/// The unit interval is a circle: steps out of it come back on the other side, so that all numbers have as
/// many neighbours.
float Wrap(float x) {
    x -= std::floor(x);
    return x < 1 ? x : 0.f;
}

}  // namespace

void PrimarySamples::StartChain(uint64_t seed) {
    rng_ = Rng(seed);
    for (std::vector<Number>& numbers : streams_)
        for (Number& number : numbers) number = {};
    step_ = largeStep_ = 0;
    isLarge_ = true;
    pathSeed_ = rng_.NextBits();
    StartStream(0);
}

void PrimarySamples::StartStep() {
    ++step_;
    isLarge_ = rng_.Uniform() < steps_.largeProbability;
    pathSeedBefore_ = pathSeed_;
    if (isLarge_) pathSeed_ = rng_.NextBits();
    StartStream(0);
}

void PrimarySamples::Accept() {
    if (isLarge_) largeStep_ = step_;
}

void PrimarySamples::Reject() {
    for (std::vector<Number>& numbers : streams_)
        for (Number& number : numbers) {
            if (number.step != step_) continue;
            number.value = number.before;
            number.step = number.stepBefore;
        }
    pathSeed_ = pathSeedBefore_;
    --step_;
}

void PrimarySamples::Follow(Number* number) {
    // A large step that the chain took while no path asked for the number.
    if (number->step < largeStep_) {
        number->value = rng_.Uniform();
        number->step = largeStep_;
    }
    if (number->step == step_) return;
    // Small ones, of which the last one is accepted. They stay when the current step is rejected: where the
    // chain is must not be drawn again after a rejection, which tells something about it.
    if (!isLarge_ && number->step < step_ - 1) {
        Move(number, step_ - 1 - number->step);
        number->step = step_ - 1;
    }
    number->before = number->value;
    number->stepBefore = number->step;
    if (isLarge_)
        number->value = rng_.Uniform();
    else
        Move(number, 1);
    number->step = step_;
}

void PrimarySamples::Move(Number* number, int64_t count) {
    // Independent steps add up to one of the sum of their variances.
    const float sigma = steps_.sigma * std::sqrt(float(count));
    number->value = Wrap(number->value + sigma * StandardNormal(rng_.Uniform()));
}

}  // namespace lacquer
