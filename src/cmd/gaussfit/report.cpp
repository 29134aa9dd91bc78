#include "cmd/gaussfit/report.h"

#include <fmt/format.h>

#include <algorithm>

#include "cmd/gaussfit/figures.h"
#include "cmd/version.h"

namespace lacquer::cmd {

namespace {

// Colours follow the reader's preference; images carry their own.
constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --paper: #fbfaf7; --card: #ffffff; --ink: #22252b; --soft: #636a75; --line: #dddcd6;
  --accent: #2a7e8e; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #15171b; --card: #1d2026; --ink: #e4e3de; --soft: #989fab; --line: #343943; --accent: #7ac274; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 40px 24px 80px; }
h1 { font-size: 30px; line-height: 1.2; margin: 0 0 8px; }
h2 { font-size: 22px; margin: 48px 0 8px; }
h3 { font-size: 16px; margin: 24px 0 6px; }
p { max-width: 74ch; margin: 8px 0; }
a { color: var(--accent); }
.lead { color: var(--soft); }
.card { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 18px 20px; margin: 14px 0;
  overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 14px; width: 100%; }
th, td { text-align: right; padding: 6px 7px; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { font-weight: 600; color: var(--soft); }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
tr:last-child td { border-bottom: 0; }
svg { display: block; width: 100%; height: auto; overflow: visible; }
svg svg { overflow: hidden; }
svg text { fill: var(--ink); font: 12px system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; }
svg text.label { font-size: 13px; font-weight: 600; }
svg text.note { fill: var(--soft); font-size: 11px; }
svg text.middle { text-anchor: middle; }
svg text.end { text-anchor: end; }
svg text.inside { fill: #ffffff; font-size: 11px; paint-order: stroke; stroke: #0f122a; stroke-width: 3px; }
svg image.cells { image-rendering: pixelated; }
svg ellipse { fill: none; stroke-width: 1.4; }
svg ellipse.part0 { stroke: #ff8a5c; }
svg ellipse.part1 { stroke: #ffffff; }
svg ellipse.s2 { stroke-dasharray: 4 3; stroke-width: 1; }
.maps { display: grid; grid-template-columns: 82px repeat(4, minmax(0, 1fr)); gap: 6px 12px; min-width: 860px;
  align-items: center; }
.maps > div { font-size: 13px; font-weight: 600; }
.product { max-width: 860px; }
.card h3 { margin-top: 0; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 2px 16px; font-size: 14px; margin: 8px 0; }
dt { color: var(--soft); } dd { margin: 0; }
)";

std::string FitSeconds(const GaussfitEntry& e) {
    if (!e.sliceSeconds || !e.fitSeconds) return "–";
    return fmt::format("{:.1f} + {:.1f} s", *e.sliceSeconds, *e.fitSeconds);
}

std::string SummaryTable(const std::vector<GaussfitEntry>& entries) {
    std::string html =
        "<div class=\"card\"><table><tr><th>model</th><th>lobes</th><th>c</th><th>mean [σ]</th><th>log "
        "L11</th>"
        "<th>log L22</th><th>lost [nat]</th><th>uncovered</th><th>fit</th><th>lookup</th>"
        "<th>file</th></tr>\n";
    const auto pair = [](double rms, double max) {
        return fmt::format("<td>{:.4f} <span class=\"lead\">/ {:.3f}</span></td>", rms, max);
    };
    for (const GaussfitEntry& e : entries) {
        const gaussfit::LobeModel& model = *e.table.Get().model;
        const gaussfit::LobeError &rms = e.errors.rms, &max = e.errors.max;
        html += fmt::format("<tr><td><a href=\"#{0}\">{0}</a></td><td>{1}</td><td>{2}</td>", model.name,
                            model.numComponents, model.cosinePower);
        html += pair(rms.meanInSigmas, max.meanInSigmas) + pair(rms.logL11, max.logL11) +
                pair(rms.logL22, max.logL22) + pair(rms.lostLikelihood, max.lostLikelihood);
        html +=
            fmt::format("<td>{:.2f} <span class=\"lead\">/ {:.2f}</span></td>", rms.uncovered, max.uncovered);
        html += fmt::format("<td>{}</td><td>{:.0f} ns</td><td>{:.1f} kB</td></tr>\n", FitSeconds(e),
                            e.nanoseconds, double(e.bytes) / 1000);
    }
    return html + "</table></div>\n";
}

const GaussfitEntry* Find(const std::vector<GaussfitEntry>& entries, MicrofacetModel distribution,
                          gaussfit::LobeEvent event) {
    for (const GaussfitEntry& e : entries) {
        const gaussfit::LobeModel& model = *e.table.Get().model;
        if (model.distribution == distribution && model.event == event) return &e;
    }
    return nullptr;
}

std::string Products(const std::vector<GaussfitEntry>& entries) {
    std::string html;
    for (const GaussfitEntry& e : entries) {
        const gaussfit::LobeModel& model = *e.table.Get().model;
        if (model.event != gaussfit::LobeEvent::Entering) continue;
        const GaussfitEntry* reflection = Find(entries, model.distribution, gaussfit::LobeEvent::Reflection);
        if (!reflection) continue;
        html += fmt::format("<div class=\"card\"><h3>{} × {}</h3><div class=\"product\">{}</div></div>\n",
                            model.name, reflection->table.Get().model->name,
                            ProductFigure(e.table, reflection->table));
    }
    if (html.empty()) return {};
    return "<h2>Products</h2>\n<p>What the tables are for: light that is refracted into a layer (α 0.3, "
           "index 1.5, from "
           "65°) and then reflected by the one below (α 0.3) towards a direction 30° from the normal. The "
           "axes are the "
           "slopes of the direction between the two, from −1.4 to 1.8 and from −1.2 to 2. Colours are roots "
           "of "
           "densities. After figure 7 of Xia et al. 2020. Neither lobe alone is a good density to draw from; "
           "their product is.</p>\n" +
           html;
}

std::string ErrorMaps(const GaussfitEntry& e) {
    std::string html = "<div class=\"card\"><div class=\"maps\"><div></div>";
    for (const ErrorKind& kind : ErrorKinds())
        html += fmt::format("<div>{}{}{}</div>", kind.title, *kind.unit ? ", " : "", kind.unit);
    for (size_t eta = 0; eta < e.survey.etas.size(); ++eta) {
        html += e.table.Get().model->Transmits() ? fmt::format("<div>η = {:.3g}</div>", e.survey.etas[eta])
                                                 : std::string("<div></div>");
        for (const ErrorKind& kind : ErrorKinds()) html += ErrorMap(e.table, e.survey, kind, eta);
    }
    html += "<div></div>";
    for (const ErrorKind& kind : ErrorKinds()) html += ColorScale(kind);
    return html + "</div></div>\n";
}

std::string Options(const GaussfitEntry& e) {
    const gaussfit::LobeTable::Content& c = e.table.Get();
    std::string html = "<dl>";
    const auto row = [&](const std::string& name, const std::string& value) {
        html += fmt::format("<dt>{}</dt><dd>{}</dd>", name, value);
    };
    std::string alphas = fmt::format("{}", c.patches.front().alphaMin);
    for (const gaussfit::LobePatch& patch : c.patches) alphas += fmt::format(" – {}", patch.alphaMax);
    row("alpha", alphas);
    if (c.model->Transmits()) row("index", fmt::format("{} – {}", c.etaMin, c.etaMax));
    row("smallest cosine",
        fmt::format("{:.4f}, {}", c.grazingCosineMin,
                    c.model->event == gaussfit::LobeEvent::Leaving ? "of the refracted direction" : "of w"));
    row("polynomials", fmt::format("degree {} in the index, {} in alpha, {} in the angle; {} control values",
                                   c.EtaDegree(), gaussfit::kLobeAlphaDegree, gaussfit::kLobeThetaDegree,
                                   c.NumControlPoints() * c.FieldsPerPoint() * int(c.patches.size())));
    for (const auto& [name, value] : c.options) row(name, value);
    return html + "</dl>\n";
}

std::string Section(const GaussfitEntry& e) {
    const gaussfit::LobeModel& model = *e.table.Get().model;
    std::string html = fmt::format("<h2 id=\"{0}\">{0}</h2>\n", model.name);
    html += fmt::format(
        "<p class=\"lead\">f(w, ·) |cos|<sup>{}</sup> over slopes{}; {} Gaussian{} for each slice.</p>\n",
        model.cosinePower, model.Transmits() ? "" : ", without Fresnel’s factor", model.numComponents,
        model.numComponents == 1 ? "" : "s");
    html += Options(e);
    html += "<h3>Slices and lobes</h3>\n<div class=\"card\">" + SliceGallery(e.table, e.options) + "</div>\n";
    html += "<h3>Errors</h3>\n" + ErrorMaps(e);
    return html;
}

}  // namespace

std::string GaussfitReport(const std::vector<GaussfitEntry>& entries) {
    std::string html = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<title>Gaussian lobes of rough boundaries</title>\n<style>{}</style></head>\n<body><main>\n",
        kStyle);
    html += fmt::format(
        "<h1>Gaussian lobes of rough boundaries</h1>\n<p class=\"lead\">Tables for product sampling, fitted "
        "by gaussfit "
        "{}. Made with <code>gaussfit --report</code>; the method and the format of the files are in "
        "docs/gaussfit.md."
        "</p>\n",
        kVersion);
    html +=
        "<h2>Summary</h2>\n<p>Errors against the best mixture for each slice alone, at points between those "
        "of the fit: "
        "root of mean square / maximum. <b>Mean</b>: distance of the means in standard deviations of the "
        "slice. "
        "<b>log L</b>: of the quotients of standard deviations along the plane of incidence (11) and across "
        "it (22). "
        "<b>Lost</b>: mean log density that the table has less than the best mixture. <b>Uncovered</b>: part "
        "of a "
        "slice that it does not have in common with the table's lobes, most of which no Gaussians could "
        "cover. <b>Fit</b>: "
        "time for the slices and for the polynomials, on the wall. <b>Lookup</b>: one lobe's parameters for "
        "one w.</p>\n";
    html += SummaryTable(entries) + Products(entries);
    html +=
        "<h2>How to read the rest</h2>\n<p><b>Slices.</b> Each image is a function over the plane of "
        "slopes x (along "
        "the plane of incidence) and y, in a rectangle that just holds what is above 1/1000 of the maximum; "
        "the "
        "ranges stand below it, with what the lobes cover and the likelihood that the table loses there. "
        "Colours are roots of values. "
        "Ellipses: "
        "one and two (dashed) standard deviations of the fitted Gaussians, the second one in white. Index "
        "1.5.</p>\n"
        "<p><b>Errors.</b> Alpha to the right (logarithmic), the angle of w upward, lighter is worse; the "
        "scale below "
        "a column is the same for all models.</p>\n";
    for (const GaussfitEntry& e : entries) html += Section(e);
    return html + "</main></body></html>\n";
}

}  // namespace lacquer::cmd
