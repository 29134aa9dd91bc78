#include "cmd/bulk/report.h"

#include <array>
#include <filesystem>

#include "cmd/bulk/thumbnails.h"
#include "cmd/command_support.h"
#include "pbrt/scattering/oriented_table.h"

namespace lacquer::cmd {

std::string MakeBulkReport(const nlohmann::ordered_json& results, const std::vector<ReportImage>& images) {
    static constexpr std::array kStyles = {"report.css", "bulk.css"};
    static constexpr std::array kScripts = {"format.js",        "blocks.js",     "axes.js",
                                            "images.js",        "curves.js",     "bulk_head.js",
                                            "bulk_looks.js",    "bulk_phase.js", "bulk_curves.js",
                                            "bulk_oriented.js", "bulk_table.js", "bulk.js"};
    return MakeReportPage({.page = "bulk.html",
                           .title = results.at("title").get<std::string>(),
                           .styles = kStyles,
                           .scripts = kScripts,
                           .results = &results,
                           .images = &images});
}

namespace {

/// @param table  for the sizes of what is rendered
void WriteReport(const std::string& folder, nlohmann::ordered_json results, const BulkTable& table,
                 const BulkReportContext& context, const std::string& tablePath) {
    const std::vector<BulkThumbnail> thumbnails =
        RenderBulkThumbnails(tablePath, table, context.thumbnailPixels);
    std::vector<ReportImage> images;
    for (const BulkThumbnail& thumbnail : thumbnails) {
        results["thumbnails"].push_back({{"file", thumbnail.name}, {"caption", thumbnail.caption}});
        images.push_back({thumbnail.name, &thumbnail.image});
    }
    WriteText((std::filesystem::path(folder) / "report.html").string(), MakeBulkReport(results, images));
}

}  // namespace

void WriteBulkReport(const std::string& folder, const bulk::BulkComputation& computation,
                     const BulkTable& table, const BulkReportContext& context, const std::string& tablePath) {
    WriteReport(folder, BulkReportResults(computation, table, context), table, context, tablePath);
}

void WriteOrientedReport(const std::string& folder, const bulk::OrientedComputation& computation,
                         const OrientedBulkTable& table, const BulkReportContext& context,
                         const std::string& tablePath) {
    const OrientedGrid grid(table);
    BulkTable mean;
    static_cast<BulkHead&>(mean) = table;
    for (size_t w = 0; w < table.wavelengths.size(); ++w) {
        mean.sigmaS.push_back(grid.MeanOverIncidences(table.sigmaS[w]));
        mean.sigmaA.push_back(grid.MeanOverIncidences(table.sigmaA[w]));
    }
    WriteReport(folder, OrientedReportResults(computation, table, context), mean, context, tablePath);
}

}  // namespace lacquer::cmd
