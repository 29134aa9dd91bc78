// The report of `lacquer capture`: what was fitted, and how well.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "capture/maps.h"
#include "capture/svbrdf/rectified_image.h"
#include "capture/svbrdf/scene_export.h"
#include "capture/views.h"

namespace lacquer::cmd {

/// A photograph as the calibration saw it; nothing of it where views were rectified already.
struct CardFinding {
    double reprojectionRms = 0;  ///< [pixels]
    int numTags = 0;
    std::array<double, 3> positionError{};  ///< standard errors [cm]
};

/// An iteration at which errors were looked at.
struct CaptureStep {
    int iteration = 0;
    double fitRmse = 0;
    std::optional<double> testRmse;
};

struct CaptureResults {
    std::string title, command;
    capture::ViewSet views;
    std::vector<std::string> names;                            ///< of the photographs, for people
    std::vector<capture::RectifiedImage> photographs, models;  ///< of the views, at one resolution
    std::vector<double> rmse;                                  ///< between the two, of each view
    capture::Maps maps;
    std::vector<CaptureStep> history;
    std::vector<CardFinding> card;     ///< of the views, or empty
    double cardSize = 0;               ///< [cm]; 0: there was none
    double focal = 0, focalError = 0;  ///< [pixels]; 0: not known
    std::array<double, 3> lightPower{};
    bool fittedLight = false, isComplete = true;
    double seconds = 0;
    /// Rows and sentences about the fit, each with its name.
    std::vector<std::pair<std::string, std::string>> fitSettings, fitFindings;
    capture::ExportReport material;
    std::string materialType;
    std::vector<std::string> warnings;  ///< each a sentence without its full stop
};

/// Root mean square over the views of one use; nothing if there are none.
std::optional<double> RmseOf(const CaptureResults& results, bool ofTests);
/// What a person wants to know first.
std::string VerdictOf(const CaptureResults& results);
/// All numbers and sentences of the page and of result.json.
nlohmann::ordered_json CaptureReportResults(const CaptureResults& results);
/// The page's text (UTF-8). @param page  CaptureReportResults()
std::string MakeCaptureReport(const CaptureResults& results, nlohmann::ordered_json page);

}  // namespace lacquer::cmd
