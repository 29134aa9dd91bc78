#include "cmd/bulk/bulk_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "cmd/bulk/checkpoint.h"

namespace lacquer::cmd {

using namespace bulk;

namespace {

constexpr double kSecondsBetweenSaves = 30;
/// Errors are looked at after multiples of this many realisations only, so that where they end does not
/// depend on threads.
constexpr int kStep = 8;
/// An error of fewer realisations is not known well enough.
constexpr int kMinForErrors = 16;

}  // namespace

BulkErrors ErrorsOf(const EnsembleComputation& computation) {
    BulkErrors errors;
    for (size_t w = 0; w < computation.Settings().wavelengths.size(); ++w) {
        const ConvergencePoint means = computation.MeansAt(w);
        const auto relative = [](const ScatteringAverage::Value& v) {
            return v.mean != 0 ? v.error / std::abs(v.mean) : 0;
        };
        errors.extinction = std::max(errors.extinction, relative(means.extinction));
        errors.scattering = std::max(errors.scattering, relative(means.scattering));
        errors.g = std::max(errors.g, means.g.error);
    }
    return errors;
}

/// What the console shows, and when the work must stop.
class BulkRun::Progress final : public Observer {
  public:
    Progress(const BulkRun& run, double deadline) : run_(run), deadline_(deadline) {}
    void Advance(int64_t units) override { run_.console_->Advance(units); }
    bool ShouldStop() override { return Console::Signal() != 0 || IsLate(); }
    bool IsLate() const { return mayEnd_ && run_.Seconds() > deadline_; }
    /// Time is no reason to stop before there is an average.
    void SetMayEnd(bool mayEnd) { mayEnd_ = mayEnd; }

  private:
    const BulkRun& run_;
    double deadline_;
    std::atomic<bool> mayEnd_ = false;
};

BulkRun::BulkRun(std::vector<EnsembleComputation*> computations, const ParticlesInput& input,
                 const BulkLimits& limits, std::string partPath, const std::string& version, Console* console)
    : input_(input),
      limits_(limits),
      partPath_(std::move(partPath)),
      console_(console),
      computations_(std::move(computations)) {
    problem_ = fmt::format("{} {} {} {}", version, input.json, input.settings.seed,
                           fmt::join(input.settings.wavelengths, " "));
}

int BulkRun::NumRealizations() const {
    int count = 0;
    for (const EnsembleComputation* computation : computations_) count += computation->NumRealizations();
    return count;
}

bool BulkRun::Resume() {
    std::error_code ignored;
    if (!std::filesystem::exists(partPath_, ignored)) return false;
    const BulkStates states = ReadCheckpoint(partPath_, problem_);
    bool isFine = states.size() == computations_.size();
    for (size_t i = 0; isFine && i < states.size(); ++i) isFine = computations_[i]->SetState(states[i]);
    if (!isFine) throw FileError(partPath_, "this checkpoint is damaged");
    hasCheckpoint_ = true;
    return true;
}

void BulkRun::Save() {
    if (partPath_.empty()) return;
    BulkStates states;
    bool isEmpty = true;
    for (const EnsembleComputation* computation : computations_) {
        states.push_back(computation->State());
        isEmpty = isEmpty && computation->NumRealizations() == 0;
    }
    if (isEmpty) return;
    WriteCheckpoint(partPath_, problem_, states);
    hasCheckpoint_ = true;
}

// A full disk now may not be full at the end.
void BulkRun::SaveOrWarn() {
    try {
        Save();
    } catch (const FileError& error) {
        console_->Warn(fmt::format("{}; going on without a checkpoint", error.Message()));
    }
    lastSave_ = Seconds();
}

void BulkRun::RemoveCheckpoint() const {
    if (!hasCheckpoint_) return;
    std::error_code ignored;
    std::filesystem::remove(partPath_, ignored);
}

BulkRun::End BulkRun::Solve() {
    End end = End::Reached;
    for (size_t i = 0; i < computations_.size(); ++i) {
        // Each size has its part of the time, and what others left of theirs.
        const double part = double(i + 1) / double(computations_.size());
        const double deadline =
            limits_.seconds > 0 ? part * limits_.seconds : std::numeric_limits<double>::infinity();
        const End one = SolveOne(computations_[i], deadline);
        if (one == End::Signal) {
            Save();
            return one;
        }
        if (one == End::Time) end = one;
        RequireSolutions(*computations_[i]);
    }
    return end;
}

BulkRun::End BulkRun::SolveOne(EnsembleComputation* computation, double deadline) {
    const auto numWavelengths = int64_t(computation->Settings().wavelengths.size());
    const int begin = computation->NumRealizations();
    const double start = Seconds();
    Progress progress(*this, deadline);
    console_->Begin(fmt::format("{} particles", computation->Settings().ensemble.count),
                    (limits_.maxRealizations - begin) * computation->UnitsPerRealization(), "");
    End end = End::Reached;
    while (true) {
        const int done = computation->NumRealizations();
        bool hasAverage = true;
        for (size_t w = 0; w < size_t(numWavelengths); ++w)
            hasAverage = hasAverage && computation->NumAveraged(w) >= computation->NumNeeded();
        progress.SetMayEnd(hasAverage);
        double fraction = double(done - begin) / (limits_.maxRealizations - begin);
        if (hasAverage) {
            const BulkErrors errors = ErrorsOf(*computation);
            if (done % kStep == 0 && done >= kMinForErrors && errors.Largest() <= limits_.error) break;
            // Errors fall as the root of the number.
            const double needed =
                limits_.error > 0 ? done * std::pow(errors.Largest() / limits_.error, 2) : 0;
            if (needed > 0) fraction = std::max(fraction, (done - begin) / std::max(needed - begin, 1.));
            fraction = std::max(fraction, (Seconds() - start) / (deadline - start));
            console_->Describe(
                std::min(fraction, 1.),
                fmt::format("{} realisations, errors: C_ext {:.2g} %, C_sca {:.2g} %, g {:.2g}", done,
                            100 * errors.extinction, 100 * errors.scattering, errors.g));
        }
        if (done >= limits_.maxRealizations || (!hasAverage && done >= kMinForErrors)) break;
        if (Seconds() - lastSave_ > kSecondsBetweenSaves) SaveOrWarn();
        end = Console::Signal() != 0 ? End::Signal : progress.IsLate() ? End::Time : End::Reached;
        if (end != End::Reached) break;
        try {
            // A few, so that errors are seen and saved often; before there is an average, as few as it takes
            // where there is a time to keep.
            const int few = limits_.seconds > 0 && !hasAverage ? std::max(1, computation->NumNeeded() - done)
                                                               : computation->BatchSize();
            computation->AddRealizations(
                std::min({few, kStep - done % kStep, limits_.maxRealizations - done}), &progress);
        } catch (const SceneError& error) {
            throw SceneError(input_.placeOfArrangement, error.Message());
        }
    }
    console_->End();
    return end;
}

void BulkRun::RequireSolutions(const EnsembleComputation& computation) const {
    const int done = computation.NumRealizations();
    for (size_t w = 0; w < computation.Settings().wavelengths.size(); ++w)
        if (const int averaged = computation.NumAveraged(w); averaged < computation.NumNeeded())
            throw SceneError(input_.placeOfArrangement,
                             fmt::format("at {:g} nm {} of {} realisations have no solution: the waves of "
                                         "such particles are not computed accurately",
                                         computation.Settings().wavelengths[w], done - averaged, done));
    if (computation.NumRefused() > 0)
        console_->Warn(fmt::format("{} of {} solutions did not converge, and are in no average",
                                   computation.NumRefused(),
                                   size_t(done) * computation.Settings().wavelengths.size()));
}

}  // namespace lacquer::cmd
