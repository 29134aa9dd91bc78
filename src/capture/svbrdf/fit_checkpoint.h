// What the fits of a capture have done so far, in a file, so that one that was stopped goes on to the same
// bits.
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pbrt/image/safetensors.h"

namespace lacquer::capture {

/// One iteration of a fit.
struct FitStep {
    int iteration;     ///< from 0
    double inputRmse;  ///< encoded, over the photographs that are fitted, before the step
    /// Over those for tests; empty if there are none, or where FitSettings::testEvery passes them over.
    std::optional<double> testRmse;
};

/// Where a fit stands; what the entries are is its own matter.
struct FitState {
    int iteration = 0;  ///< the next one
    std::map<std::string, std::vector<double>> numbers;
    std::vector<NamedTensor> tensors;
    std::string path;  ///< of the file that it came from, for messages

    /// Takes the steps that are done.
    void SetSteps(std::span<const FitStep> steps);

    /// Errors of all: FileError if there are none of that name, or not as many.
    std::vector<FitStep> Steps() const;
    const std::vector<double>& Numbers(const std::string& name, size_t count) const;
    const std::vector<float>& Values(const std::string& name, size_t count) const;
};

/// The states of all fits of a run, by name. From one thread.
class FitCheckpoint {
  public:
    /// The parts of a problem, by name: another value of one is another problem.
    using Problem = std::map<std::string, std::string>;

    FitCheckpoint(std::string path, Problem problem, double secondsBetween = 60);

    /// Reads what an earlier run has left. Errors: FileError for a file that cannot be read, is damaged or no
    /// checkpoint, or is of another problem, which is told.
    void Load();
    /// Null: this fit has to begin. Errors: FileError for a state beyond so many iterations.
    const FitState* Find(const std::string& fit, int iterations) const;

    /// Whether the last writing is so long ago that a state is worth its making.
    bool IsDue() const;
    /// Keeps a state, and writes all. Errors: FileError.
    void Write(const std::string& fit, FitState state);
    /// After the run's end.
    void Remove();

  private:
    using Clock = std::chrono::steady_clock;

    std::string path_;
    Problem problem_;
    Clock::duration between_;
    Clock::time_point written_;
    std::map<std::string, FitState> states_;
};

}  // namespace lacquer::capture
