#include "cmd/report_page.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string_view>

#include "cmd/page_parts.h"
#include "pbrt/core/embedded.h"

namespace lacquer {
extern const EmbeddedFile kReportFiles[];
}

namespace lacquer::cmd {

namespace {

std::string ReportFile(std::string_view name) {
    return std::string(EmbeddedData(kReportFiles, "report/" + std::string(name)));
}

std::string Joined(std::span<const char* const> files) {
    std::string text;
    for (const char* file : files) text += ReportFile(file);
    return text;
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

std::string Part(std::string_view name, const ReportPage& parts) {
    if (name == "title") return EscapeHtml(parts.title);
    if (name == "style") return Joined(parts.styles);
    if (name == "results") return JsonForPage(*parts.results);
    if (name == "magma") return ErrorColors();
    if (name == "images") return Images(*parts.images);
    if (name == "notices") return ReportFile("notices.txt");
    if (name == "chart") return ReportFile("chart.js");
    if (name == "script") return Joined(parts.scripts);
    throw std::logic_error("a report's page asks for an unknown part " + std::string(name));
}

}  // namespace

std::string MakeReportPage(const ReportPage& parts) {
    // One pass over the template: what is put in is never looked at again, whatever it holds.
    constexpr std::string_view kOpen = "{{", kClose = "}}";
    const std::string whole = ReportFile(parts.page);
    std::string_view rest = whole;
    std::string page;
    for (size_t open = rest.find(kOpen); open != std::string_view::npos; open = rest.find(kOpen)) {
        const size_t close = rest.find(kClose, open);
        page += rest.substr(0, open);
        page += Part(rest.substr(open + kOpen.size(), close - open - kOpen.size()), parts);
        rest.remove_prefix(close + kClose.size());
    }
    return page += rest;
}

}  // namespace lacquer::cmd
