// The report of an estimate from a measurement of layers.
#pragma once

#include "cmd/estimate/layered_problem.h"
#include "cmd/estimate/posterior_summary.h"
#include "cmd/estimate/report.h"
#include "estimate/layered/next_measurement.h"

namespace lacquer::cmd {

/// All that a run has found.
struct LayeredResults {
    const EstimateArguments& arguments;
    const LayeredProblem& problem;
    const estimate::ObservedLobes& observed;
    const estimate::LobePosterior& posterior;
    const PosteriorChains& chains;
    const PosteriorSummary& summary;
    estimate::Matrix predicted;  ///< logarithms at draws of the posterior: a row for each
    estimate::Vector noise;      ///< of these draws
    std::vector<estimate::NextDirection> next;
    std::map<std::string, double> truth;
};
/// Of scenes that were photographed.
inline constexpr const char* kPhotographWarning =
    "Intervals hold if camera, light and shape of the photograph are those of the scene: where they are not, "
    "parts of an "
    "image err together, and here they count as independent.";
EstimateReport ReportOf(const LayeredResults& results);
/// The sentence about the next best measurement; empty without candidates.
std::string NextText(const std::vector<estimate::NextDirection>& next);

}  // namespace lacquer::cmd
