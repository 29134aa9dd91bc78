// A posterior in numbers: of each parameter, of pairs of them, and of what the model makes of the photograph.
#pragma once

#include <string>
#include <vector>

#include "cmd/estimate/report.h"
#include "estimate/infer/chain.h"
#include "estimate/photo_simulator.h"

namespace lacquer::cmd {

/// Draws of several chains, without their warm-up.
struct PosteriorChains {
    std::vector<std::vector<estimate::Draw>> draws;  ///< in logits, as many of each chain
    std::vector<estimate::ChainState> states;        ///< where the chains ended
    /// One parameter in natural units: rows are draws, columns are chains.
    estimate::Matrix NaturalCoordinate(const estimate::ParameterSpace& space, Eigen::Index i) const;
    /// All draws, chain after chain: a column for each.
    estimate::Matrix Logits() const;
    estimate::Matrix Natural(const estimate::ParameterSpace& space) const;
};

struct PosteriorSummary {
    /// In the order of the space; behind them products of which the data tell more than of their factors.
    /// Without meanings and truths.
    std::vector<EstimateParameter> parameters;
    double maxRhat = 0, minEss = 0;  ///< of the parameters themselves
    /// R-hat and effective sizes as they should be for results that others rely on.
    bool HasConverged() const;
};

/// @param seed  of draws of the prior, which products are compared with
PosteriorSummary Summarize(const estimate::ParameterSpace& space, const PosteriorChains& chains,
                           const estimate::Vector& mode, uint64_t seed);

struct PredictiveSummary {
    std::vector<EstimateCheck> checks;
    std::vector<EstimateResidual> residuals;
    estimate::Matrix summaries;  ///< of the draws' photographs: a row for each, as the simulator has them
};
/// Photographs of `numDraws` draws with fresh seeds, beside the one that was observed: their summaries and
/// those of families that were held out.
/// @param draws  natural units, a column for each
PredictiveSummary PredictAndCheck(const estimate::PhotoSimulator& simulator,
                                  const estimate::PhotoSimulator* heldOut,
                                  const estimate::PlanarImage& observed, const estimate::Matrix& draws,
                                  int numDraws, uint64_t seed, Observer* observer);

}  // namespace lacquer::cmd
