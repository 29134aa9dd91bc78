#include "cmd/compare/report.h"

#include <array>

namespace lacquer::cmd {

std::string MakeCompareReport(const nlohmann::ordered_json& results, const std::vector<ReportImage>& images) {
    static constexpr std::array kStyles = {"report.css"};
    static constexpr std::array kScripts = {
        "format.js",       "comparison.js",   "axes.js",  "images.js", "error_scale.js",
        "head.js",         "table.js",        "crops.js", "plots.js",  "viewer.js",
        "viewer_input.js", "viewer_panel.js", "main.js"};
    const auto scene = results.find("scene");
    return MakeReportPage(
        {.page = "report.html",
         .title = scene != results.end() && scene->is_string() ? scene->get<std::string>() : "comparison",
         .styles = kStyles,
         .scripts = kScripts,
         .results = &results,
         .images = &images});
}

}  // namespace lacquer::cmd
