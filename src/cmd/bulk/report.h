// The report of `lacquer bulk`.
#pragma once

#include <string>
#include <vector>

#include "bulk/table/oriented_computation.h"
#include "bulk/table/size_extrapolation.h"
#include "cmd/report_page.h"

namespace lacquer::cmd {

/// What the report shows beside what computation and table know.
struct BulkReportContext {
    std::string input;    ///< the text of particles.json
    std::string command;  ///< empty: not known
    /// Of balls of several sizes, the extrapolated one last; fewer than two: nothing to compare.
    std::vector<bulk::SizeResult> sizes;
    int thumbnailPixels = 128;  ///< a side
};

/// All numbers and sentences of the page; docs/bulk.md says what they mean. Cost: draws some realisations
/// again for g(r) and S(q), at most a few seconds.
/// @param computation  of the largest ball, with enough realisations for its Table()
/// @param table        as it was written: that, or one with extrapolated coefficients
nlohmann::ordered_json BulkReportResults(const bulk::BulkComputation& computation, const BulkTable& table,
                                         const BulkReportContext& context);

/// The same for an oriented ensemble. @param table  its Table()
nlohmann::ordered_json OrientedReportResults(const bulk::OrientedComputation& computation,
                                             const OrientedBulkTable& table,
                                             const BulkReportContext& context);

/// The page's text (UTF-8). `results` is embedded whole, and every name and text of it escaped.
/// @param images  those that results["thumbnails"] names. Cost and errors: as MakeReportPage()
std::string MakeBulkReport(const nlohmann::ordered_json& results, const std::vector<ReportImage>& images);

/// Writes report.html into a folder that exists: both of the above, with renders of the medium as scenes
/// see it (thumbnails.h).
/// @param tablePath  the file of `table`, written before
void WriteBulkReport(const std::string& folder, const bulk::BulkComputation& computation,
                     const BulkTable& table, const BulkReportContext& context, const std::string& tablePath);
void WriteOrientedReport(const std::string& folder, const bulk::OrientedComputation& computation,
                         const OrientedBulkTable& table, const BulkReportContext& context,
                         const std::string& tablePath);

}  // namespace lacquer::cmd
