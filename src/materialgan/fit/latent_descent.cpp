#include "materialgan/fit/latent_descent.h"

#include <cmath>

namespace lacquer::materialgan {
namespace {

/// Iterations of w+ and of noise that take turns in strategy 3.
constexpr int kTurn = 10;

/// Which latents an iteration moves.
struct Moves {
    bool w, noise;
};
Moves MovesAt(const LatentSchedule& schedule, int iteration) {
    Moves moves{schedule.movesW, schedule.movesNoise};
    if (!(moves.w && moves.noise) || schedule.strategy == 2) return moves;
    moves.w = schedule.strategy == 1 ? 2 * iteration < schedule.iterations : iteration / kTurn % 2 == 0;
    moves.noise = !moves.w;
    return moves;
}

}  // namespace

LatentDescent DescendLatents(const StyleGenerator& generator, const LatentTensors& start,
                             const LatentSchedule& schedule, const LatentObjective& objective,
                             const FitObserver& observer,
                             const std::function<Tensor(const Tensor&)>& toPlus) {
    const auto plusOf = [&](const Tensor& w) { return toPlus ? toPlus(w) : w; };
    LatentTensors moving = start.Clone();
    const AdamOptions options{.isSignDescent = schedule.optimizer == FitOptimizer::Sign};
    Adam ofW({moving.wPlus}, options), ofNoise(moving.noise, options);
    LatentDescent descent{start.Clone(), {}};
    descent.latents.wPlus = plusOf(descent.latents.wPlus).detach();
    for (int i = 0; i < schedule.iterations; ++i) {
        const Moves moves = MovesAt(schedule, i);
        const LatentTensors latents{plusOf(moving.wPlus), moving.noise};
        const Tensor maps =
            SoftClampMaps(generator.Synthesize(latents.wPlus, latents.noise), generator.Config());
        const auto value = objective(maps, latents, moves.w ? FitPhase::W : FitPhase::Noise);
        const double loss = value.loss.item<double>();
        if (!std::isfinite(loss)) {
            descent.isFinite = false;
            return descent;
        }
        // The last state that is known to be good.
        descent.latents = latents.Clone();
        descent.losses.push_back(loss);
        descent.pixelLoss = value.pixelLoss;
        const FitProgress progress{schedule.stage, i, schedule.iterations, loss, std::sqrt(value.pixelLoss)};
        if (observer && !observer(progress)) {
            descent.isStopped = true;
            return descent;
        }
        value.loss.backward();
        moves.w ? ofW.Step(schedule.rateW) : ofW.ClearGradients();
        moves.noise ? ofNoise.Step(schedule.rateNoise) : ofNoise.ClearGradients();
    }
    bool isGood = moving.wPlus.isfinite().all().item<bool>();
    for (const Tensor& map : moving.noise) isGood = isGood && map.isfinite().all().item<bool>();
    if (isGood) descent.latents = LatentTensors{plusOf(moving.wPlus), moving.noise}.Clone();
    return descent;
}

}  // namespace lacquer::materialgan
