// What an estimate from a photograph has found, and the report of it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cmd/estimate/photo_inference.h"
#include "estimate/photo/photograph_file.h"

namespace lacquer::cmd {

/// A photograph, and all that a run has found of it.
struct PhotoResults {
    const EstimateArguments& arguments;
    estimate::PhotographFile photo = {};
    estimate::PlanarImage image = {};          ///< the photograph after the tone curve
    std::map<std::string, double> truth = {};  ///< of a synthetic one
    /// One, or those that the photograph tells apart.
    std::vector<std::unique_ptr<estimate::PhotoSimulator>> kinds = {};
    PhotoPosterior posterior = {};
    PosteriorSummary summary = {};      ///< empty with --map-only
    PredictiveSummary predictive = {};  ///< empty with --map-only

    const estimate::PhotoSimulator& Simulator() const { return *kinds[posterior.kind]; }
};

/// "noise ridged (98 %); noise spectral (2 %)": the three most probable kinds.
std::string KindsText(const PhotoResults& results);
/// Reads the maps in the folder of results, which are written before.
EstimateReport ReportOf(const PhotoResults& results);

}  // namespace lacquer::cmd
