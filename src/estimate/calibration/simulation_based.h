// Simulation-based calibration: does a method of inference give intervals that hold what they say?
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "estimate/simulator.h"
#include "pbrt/core/progress.h"

namespace lacquer::estimate {

/// A method of inference: draws of the posterior of what was observed, in logits, a column for each, nearly
/// independent. Any number of at least CalibrationOptions::numDraws; they are thinned evenly.
using InferenceMethod = std::function<Matrix(const Vector& observed, uint64_t seed)>;

struct CalibrationOptions {
    int replicates = 200;
    uint64_t seed = 1;
    /// Draws that a truth is ranked among. One more must be a multiple of 20.
    int numDraws = 99;
};

/// Ranks of the truth of one parameter among the posterior's draws, over all replicates: uniform, if the
/// method is right.
struct CalibratedParameter {
    std::string name;
    std::vector<int> ranks;
    double chiSquare = 0, degrees = 0, pValue = 1;  ///< of Pearson's test
    bool isInsideEnvelope = true;                   ///< the ECDF stays in the 99 % envelope
    double coverage50 = 0, coverage90 = 0;          ///< how often central intervals contained the truth
    double shrinkage = 1;  ///< median of the posterior's deviation over the prior's, in logits
    /// Both rank tests at 1 %.
    bool Passes() const { return pValue > 0.01 && isInsideEnvelope; }
};

struct CalibrationReport {
    int replicates = 0;
    int numRanks = 0;
    std::vector<CalibratedParameter> parameters;
    bool Passes() const;
    /// A line for each parameter.
    std::string ToString() const;
};

/// Draws truths from the prior, simulates what would be observed, infers and ranks [Talts et al. 2018]; in
/// parallel over replicates. The same for any number of threads if the method is. If the observer asks to
/// stop, the report is of the replicates that were finished (which ones they are depends on threads then).
CalibrationReport Calibrate(const Simulator& simulator, const InferenceMethod& infer,
                            const CalibrationOptions& options, Observer* observer = nullptr);

}  // namespace lacquer::estimate
