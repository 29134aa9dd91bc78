// Chains as files that other programs read.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estimate/infer/chain.h"
#include "estimate/parameters.h"

namespace lacquer::estimate {

/// What a file of chains says besides the draws.
struct ChainHeader {
    std::string model;                                          ///< "leather"
    std::vector<std::pair<std::string, std::string>> settings;  ///< name, value
    uint64_t numWarmup = 0;
    bool savesWarmup = false;  ///< draws of warm-up come first
};

/// A chain as Stan's CSV: settings as comments, then `lp__,accept_stat__,stepsize__,n_leapfrog__,divergent__,
/// energy__` and the parameters in natural units, with as many digits as tell any two numbers apart.
/// CmdStanPy and ArviZ read it.
/// @param draws  those of warm-up only if the header says so
std::string StanCsv(const ParameterSpace& space, const ChainHeader& header, const ChainState& last,
                    const std::vector<Draw>& draws);

/// Chains and what goes with them, in the groups that ArviZ has.
struct InferenceData {
    std::vector<std::vector<Draw>> chains;  ///< after warm-up, in logits, all of one length
    Matrix priorDraws;                      ///< logits, a column for each
    std::vector<std::string> summaryNames;
    Vector observed;
    Matrix predictive;                                            ///< summaries, a row for each draw
    std::vector<std::pair<std::string, std::string>> attributes;  ///< of the whole: version, model, seed
};
/// JSON text: `posterior`, `sample_stats`, `prior`, `observed_data`, `posterior_predictive` with arrays of
/// chain x draw (x summary), and `attrs`.
std::string ArviZJson(const ParameterSpace& space, const InferenceData& data);

}  // namespace lacquer::estimate
