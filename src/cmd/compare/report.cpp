#include "cmd/compare/report.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <string_view>

#include "cmd/page_parts.h"
#include "pbrt/core/embedded.h"

namespace lacquer {
extern const EmbeddedFile kReportFiles[];
}

namespace lacquer::cmd {

namespace {

/// The page's own scripts, in the order in which they need each other.
constexpr std::array kScripts = {"format.js", "images.js", "head.js",         "table.js",        "crops.js",
                                 "plots.js",  "viewer.js", "viewer_input.js", "viewer_panel.js", "main.js"};

std::string_view ReportFile(std::string_view name) { return EmbeddedData(kReportFiles, name); }

std::string Scripts() {
    std::string out;
    for (const char* name : kScripts) out += ReportFile(std::string("report/") + name);
    return out;
}

/// The colours of errors as JSON: [[r,g,b],...], 8-bit sRGB.
std::string ErrorColors() { return JsonForPage(EmbeddedTable("colormaps/magma.txt")); }

/// Elements that hold the images' pixels as text; the page decodes them when it shows them.
std::string Images(const std::vector<ReportImage>& images) {
    std::string out;
    for (const ReportImage& entry : images) {
        if (!entry.image) throw std::logic_error("the report's image " + entry.file + " is missing");
        const Int2 resolution = entry.image->Resolution();
        const Int2 origin = entry.image->Window().min;
        out += fmt::format(
            "<script type=\"text/plain\" class=\"image\" data-file=\"{}\" data-width=\"{}\" "
            "data-height=\"{}\" data-channels=\"{}\" data-x=\"{}\" data-y=\"{}\">{}</script>\n",
            EscapeHtml(entry.file), resolution.x, resolution.y, NumPageChannels(*entry.image), origin.x,
            origin.y, ToBase64(Deflated(PixelsForPage(*entry.image))));
    }
    return out;
}

std::string Title(const nlohmann::ordered_json& results) {
    const auto scene = results.find("scene");
    return EscapeHtml(scene != results.end() && scene->is_string() ? scene->get<std::string>()
                                                                   : "comparison");
}

std::string ReportPart(std::string_view name, const nlohmann::ordered_json& results,
                       const std::vector<ReportImage>& images) {
    if (name == "title") return Title(results);
    if (name == "style") return std::string(ReportFile("report/report.css"));
    if (name == "results") return JsonForPage(results);
    if (name == "magma") return ErrorColors();
    if (name == "images") return Images(images);
    if (name == "notices") return std::string(ReportFile("report/notices.txt"));
    if (name == "chart") return std::string(ReportFile("report/chart.js"));
    if (name == "script") return Scripts();
    throw std::logic_error("report.html asks for an unknown part " + std::string(name));
}

}  // namespace

std::string MakeCompareReport(const nlohmann::ordered_json& results, const std::vector<ReportImage>& images) {
    // One pass over the template: what is put in is never looked at again, whatever it holds.
    constexpr std::string_view kOpen = "{{", kClose = "}}";
    std::string_view rest = ReportFile("report/report.html");
    std::string page;
    for (size_t open = rest.find(kOpen); open != std::string_view::npos; open = rest.find(kOpen)) {
        const size_t close = rest.find(kClose, open);
        page += rest.substr(0, open);
        page += ReportPart(rest.substr(open + kOpen.size(), close - open - kOpen.size()), results, images);
        rest.remove_prefix(close + kClose.size());
    }
    return page += rest;
}

}  // namespace lacquer::cmd
