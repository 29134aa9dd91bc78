// Chains with a checkpoint.
#include <algorithm>
#include <chrono>
#include <filesystem>

#include "cmd/command_support.h"
#include "cmd/estimate/photo_inference.h"
#include "estimate/emulator/runs.h"
#include "estimate/output/checkpoint.h"
#include "pbrt/core/file_bytes.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

uint64_t FewestSteps(const std::vector<ChainState>& states) {
    return std::min_element(states.begin(), states.end(),
                            [](const ChainState& a, const ChainState& b) { return a.step < b.step; })
        ->step;
}

Checkpoint ReadIfThere(const InferenceTask& task) {
    std::error_code ignored;
    if (!task.arguments.resume || !std::filesystem::exists(CheckpointName(task.arguments), ignored))
        return {};
    const FileBytes bytes = ReadFileBytes(CheckpointName(task.arguments), {}, {.maxBytes = size_t(4) << 30});
    return ParseCheckpoint(std::string(bytes.View()), CheckpointName(task.arguments), task.settings);
}

}  // namespace

PosteriorChains RunCheckpointed(
    const InferenceTask& task, const std::function<std::vector<ChainState>()>& start,
    const std::function<std::vector<std::vector<Draw>>(uint64_t, std::vector<ChainState>*)>& advance) {
    constexpr uint64_t kSteps = 10;  // after which all chains are together again
    using Clock = std::chrono::steady_clock;
    const EstimateArguments& a = task.arguments;
    const uint64_t total = uint64_t(a.warmup) + uint64_t(a.samples);
    Checkpoint done = ReadIfThere(task);
    if (done.states.empty()) {
        done.states = start();
        done.draws.resize(done.states.size());
    }
    done.settings = task.settings;
    task.observer->Begin("chains", int64_t(total * done.states.size()), "steps");
    for (const ChainState& state : done.states) task.observer->Advance(int64_t(state.step));
    Clock::time_point written = Clock::now();
    const auto write = [&] {
        WriteText(CheckpointName(task.arguments), CheckpointText(done));
        written = Clock::now();
    };
    for (uint64_t steps = FewestSteps(done.states); steps < total; steps = FewestSteps(done.states)) {
        const auto draws = advance(std::min(total, steps + kSteps), &done.states);
        for (size_t c = 0; c < draws.size(); ++c)
            done.draws[c].insert(done.draws[c].end(), draws[c].begin(), draws[c].end());
        const bool mustStop = task.observer->ShouldStop();
        if (mustStop || Clock::now() - written >= std::chrono::duration<double>(a.checkpointEvery)) write();
        if (mustStop) throw Interrupted{};
    }
    write();  // what is made of the chains may be interrupted too
    task.observer->End();
    for (std::vector<Draw>& chain : done.draws) chain.erase(chain.begin(), chain.begin() + a.warmup);
    return {std::move(done.draws), std::move(done.states)};
}

}  // namespace lacquer::cmd
