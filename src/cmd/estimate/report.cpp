#include "cmd/estimate/report.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "cmd/command_support.h"

namespace lacquer::cmd {

std::string MakeEstimateReport(const EstimateReport& report) {
    static constexpr std::array kStyles = {"report.css", "bulk.css", "estimate.css"};
    static constexpr std::array kScripts = {"format.js",         "blocks.js",         "axes.js",
                                            "images.js",         "image_figures.js",  "curves.js",
                                            "start.js",          "estimate_head.js",  "estimate_images.js",
                                            "estimate_table.js", "estimate_plots.js", "estimate_checks.js",
                                            "estimate_lobes.js", "estimate.js"};
    const nlohmann::ordered_json results = EstimateReportResults(report);
    std::vector<ReportImage> images;
    const auto add = [&](const std::string& name, const Image& image) {
        if (image.Resolution().x > 0) images.push_back({name, &image});
    };
    add("photo", report.photo);
    add("best", report.best);
    for (size_t i = 0; i < report.draws.size(); ++i) add(fmt::format("draw {}", i + 1), report.draws[i]);
    for (const EstimateMap& map : report.maps) add("map " + map.name, map.image);
    return MakeReportPage({.page = "estimate.html",
                           .title = report.title,
                           .styles = kStyles,
                           .scripts = kScripts,
                           .results = &results,
                           .images = &images});
}

void WriteEstimateReport(const std::string& folder, const EstimateReport& report) {
    WriteText((std::filesystem::path(folder) / "report.html").string(), MakeEstimateReport(report));
}

}  // namespace lacquer::cmd
