#include "materialgan/fit/latent_descent.h"

#include <fmt/format.h>

#include <cmath>

namespace lacquer::materialgan {
namespace {

using capture::FitState;
using capture::FitStep;
using End = capture::FitResult::End;

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

class Descent {
  public:
    Descent(const StyleGenerator& generator, const LatentTensors& start, const LatentSchedule& schedule,
            const LatentObjective& objective, Observer* observer,
            const std::function<Tensor(const Tensor&)>& toPlus)
        : generator_(generator),
          schedule_(schedule),
          objective_(objective),
          observer_(observer ? observer : &nobody_),
          toPlus_(toPlus),
          moving_(start.Clone()),
          ofW_({moving_.wPlus}, {.isSignDescent = schedule.optimizer == FitOptimizer::Sign}),
          ofNoise_(moving_.noise, {.isSignDescent = schedule.optimizer == FitOptimizer::Sign}) {}

    LatentDescent Run() {
        observer_->Begin(schedule_.name, schedule_.iterations, "iterations");
        GoOn();
        observer_->Advance(int64_t(result_.steps.size()));
        KeepLatents();
        while (int(result_.steps.size()) < schedule_.iterations && result_.end == End::Finished) {
            if (!Step()) {
                result_.end = End::NotFinite;
                break;
            }
            observer_->Advance(1);
            if (int(result_.steps.size()) < schedule_.iterations && observer_->ShouldStop())
                result_.end = End::Stopped;
            WriteCheckpoint();
        }
        observer_->End();
        if (result_.end != End::NotFinite && IsFinite()) KeepLatents();
        return std::move(result_);
    }

  private:
    LatentTensors Latents() const {
        return {toPlus_ ? toPlus_(moving_.wPlus) : moving_.wPlus, moving_.noise};
    }
    /// The last state that is known to be good.
    void KeepLatents() {
        const torch::NoGradGuard noGradients;
        result_.latents = Latents().Clone();
    }
    bool IsFinite() const {
        bool isFinite = moving_.wPlus.isfinite().all().item<bool>();
        for (const Tensor& map : moving_.noise) isFinite = isFinite && map.isfinite().all().item<bool>();
        return isFinite;
    }

    /// False: the loss is not finite, and nothing has changed.
    bool Step() {
        const int iteration = int(result_.steps.size());
        const Moves moves = MovesAt(schedule_, iteration);
        const LatentTensors latents = Latents();
        const Tensor maps =
            SoftClampMaps(generator_.Synthesize(latents.wPlus, latents.noise), generator_.Config());
        const auto value = objective_(maps, latents, moves.w ? FitPhase::W : FitPhase::Noise);
        const double loss = value.loss.item<double>();
        if (!std::isfinite(loss)) return false;
        KeepLatents();
        result_.losses.push_back(loss);
        FitStep step{iteration, std::sqrt(value.pixelLoss), {}};
        if (schedule_.testRmse && schedule_.testEvery > 0 && iteration % schedule_.testEvery == 0)
            step.testRmse = schedule_.testRmse(maps.detach());
        Tell(step);
        value.loss.backward();
        moves.w ? ofW_.Step(schedule_.rateW) : ofW_.ClearGradients();
        moves.noise ? ofNoise_.Step(schedule_.rateNoise) : ofNoise_.ClearGradients();
        return true;
    }
    void Tell(const FitStep& step) {
        result_.steps.push_back(step);
        if (schedule_.afterStep) schedule_.afterStep(step);
    }

    void WriteCheckpoint() {
        if (!schedule_.checkpoint) return;
        const bool isOver = int(result_.steps.size()) == schedule_.iterations || result_.end == End::Stopped;
        if (isOver || schedule_.checkpoint->IsDue()) schedule_.checkpoint->Write(schedule_.name, State());
    }
    FitState State() {
        FitState state;
        state.SetSteps(result_.steps);
        state.numbers["loss"] = result_.losses;
        state.numbers["adam steps"] = {double(ofW_.NumSteps()), double(ofNoise_.NumSteps())};
        for (const auto& [name, tensor] : StateTensors())
            state.tensors.push_back(ToNamedTensor(name, tensor));
        return state;
    }
    void GoOn() {
        const FitState* state =
            schedule_.checkpoint ? schedule_.checkpoint->Find(schedule_.name, schedule_.iterations) : nullptr;
        if (!state) return;
        result_.losses = state->Numbers("loss", size_t(state->iteration));
        for (const FitStep& step : state->Steps()) Tell(step);
        ofW_.SetNumSteps(int64_t(state->Numbers("adam steps", 2)[0]));
        ofNoise_.SetNumSteps(int64_t(state->Numbers("adam steps", 2)[1]));
        const torch::NoGradGuard noGradients;
        for (auto& [name, tensor] : StateTensors()) {
            const std::vector<float>& values = state->Values(name, size_t(tensor.numel()));
            std::ranges::copy(values, tensor.data_ptr<float>());
        }
    }
    /// All that moves; the tensors share their numbers with those of the descent.
    TensorMap StateTensors() {
        TensorMap tensors{
            {"w", moving_.wPlus}, {"w mean", ofW_.FirstMoments()[0]}, {"w square", ofW_.SecondMoments()[0]}};
        for (size_t i = 0; i < moving_.noise.size(); ++i) {
            tensors.emplace(fmt::format("noise {}", i), moving_.noise[i]);
            tensors.emplace(fmt::format("noise {} mean", i), ofNoise_.FirstMoments()[i]);
            tensors.emplace(fmt::format("noise {} square", i), ofNoise_.SecondMoments()[i]);
        }
        return tensors;
    }

    const StyleGenerator& generator_;
    const LatentSchedule& schedule_;
    const LatentObjective& objective_;
    Observer nobody_;
    Observer* observer_;
    const std::function<Tensor(const Tensor&)>& toPlus_;
    LatentTensors moving_;
    Adam ofW_, ofNoise_;
    LatentDescent result_;
};

}  // namespace

LatentDescent DescendLatents(const StyleGenerator& generator, const LatentTensors& start,
                             const LatentSchedule& schedule, const LatentObjective& objective,
                             Observer* observer, const std::function<Tensor(const Tensor&)>& toPlus) {
    return Descent(generator, start, schedule, objective, observer, toPlus).Run();
}

}  // namespace lacquer::materialgan
