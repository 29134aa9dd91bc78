// The report on fitted tables: one HTML page that needs no other file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gaussfit/fit/lobe_fit.h"

namespace lacquer::cmd {

/// What is known about one table.
struct GaussfitEntry {
    gaussfit::LobeTable table;
    gaussfit::LobeFitOptions options;
    gaussfit::LobeSurvey survey;                     ///< between the slices of the fit
    gaussfit::LobeErrorSummary errors;               ///< of the survey
    size_t bytes = 0;                                ///< of the file
    double nanoseconds = 0;                          ///< of one LobeTable::Find()
    std::optional<double> sliceSeconds, fitSeconds;  ///< not set for tables that were read
};

/// The page's text.
std::string GaussfitReport(const std::vector<GaussfitEntry>& entries);

}  // namespace lacquer::cmd
