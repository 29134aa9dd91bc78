#include "cmd/estimate/photo_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "cmd/estimate/purpose.h"
#include "cmd/page_parts.h"
#include "estimate/infer/population.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

constexpr int kNumShownDraws = 8;

/// The photograph as a page shows it: values after the tone curve.
Image Shown(const PlanarImage& image) {
    Image shown({image.size, image.size}, {"R", "G", "B"});
    for (int y = 0; y < image.size; ++y)
        for (int x = 0; x < image.size; ++x)
            for (int c = 0; c < 3; ++c)
                shown.Set({x, y}, c,
                          float(image.Channel(size_t(c))[size_t(y) * size_t(image.size) + size_t(x)]));
    return shown;
}

/// As people write it: "cm²".
std::string Written(std::string unit) {
    if (const size_t square = unit.find("^2"); square != std::string::npos) unit.replace(square, 2, "²");
    return unit;
}

/// Without chains: the mode beside the priors.
void AddMode(const PhotoResults& r, EstimateReport* report) {
    const ParameterSpace& space = r.Simulator().Parameters();
    for (size_t i = 0; i < space.Size(); ++i) {
        EstimateParameter p;
        p.name = space[i].name;
        p.unit = space[i].unit;
        p.prior = space[i].prior;
        p.map = r.posterior.mode[Eigen::Index(i)];
        report->parameters.push_back(std::move(p));
    }
}

void AddParameters(const PhotoResults& r, EstimateReport* report) {
    report->parameters = r.summary.parameters;
    if (r.arguments.mapOnly) AddMode(r, report);
    const auto truthOf = [&](const std::string& name) {
        const auto truth = r.truth.find(name);
        return truth == r.truth.end() ? std::optional<double>() : truth->second;
    };
    for (EstimateParameter& p : report->parameters) {
        if (p.factors.empty()) {
            const size_t place = size_t(r.Simulator().Model().Find(p.name));
            p.meaning = r.Simulator().Model().Parameters()[place].meaning.label;
        }
        p.unit = Written(p.unit);
        p.truth = truthOf(p.name);
        if (p.factors.size() == 2 && truthOf(p.factors[0]) && truthOf(p.factors[1]))
            p.truth = *truthOf(p.factors[0]) * *truthOf(p.factors[1]);
    }
}

void AddDraws(const PhotoResults& r, EstimateReport* report) {
    const Matrix draws =
        ThinnedColumns(r.posterior.chains.Natural(r.Simulator().Parameters()), kNumShownDraws);
    for (Eigen::Index k = 0; k < draws.cols(); ++k)
        report->draws.push_back(Shown(r.Simulator().Photograph(
            draws.col(k), Hash(r.arguments.seed, uint64_t(Purpose::Images), k + 1))));
}

void AddMaps(const PhotoResults& r, EstimateReport* report) {
    const std::filesystem::path folder = std::filesystem::path(r.arguments.out) / "maps";
    for (const auto& [name, unit, isColor] : {std::tuple("albedo", "", true),
                                              {"f0", "", true},
                                              {"normal", "", false},
                                              {"flake_normal", "", false},
                                              {"rough", "", false},
                                              {"roughx", "", false},
                                              {"roughy", "", false},
                                              {"height", "cm", false}}) {
        const std::string path = (folder / (std::string(name) + ".exr")).string();
        std::error_code ignored;
        if (std::filesystem::exists(path, ignored))
            report->maps.push_back({name, unit, isColor, ReadImage(path, {}, {})});
    }
}

void AddImages(const PhotoResults& r, EstimateReport* report) {
    report->photo = Shown(r.image);
    report->best =
        Shown(r.Simulator().Photograph(r.posterior.mode, Hash(r.arguments.seed, uint64_t(Purpose::Images))));
    if (!r.arguments.mapOnly) AddDraws(r, report);
    AddMaps(r, report);
}

}  // namespace

std::string KindsText(const PhotoResults& r) {
    const auto nameOf = [&](size_t k) { return NameOf(r.kinds[k]->Settings().kinds, r.Simulator().Model()); };
    if (r.posterior.kindProbabilities.size() < 2) return nameOf(r.posterior.kind);
    std::vector<size_t> order(r.kinds.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
        return r.posterior.kindProbabilities[a] > r.posterior.kindProbabilities[b];
    });
    std::string text;
    for (size_t i = 0; i < std::min<size_t>(3, order.size()); ++i)
        text += fmt::format("{}{} ({:.2g} %)", text.empty() ? "" : "; ", nameOf(order[i]),
                            100 * r.posterior.kindProbabilities[order[i]]);
    return text;
}

EstimateReport ReportOf(const PhotoResults& r) {
    const EstimateArguments& a = r.arguments;
    EstimateReport report;
    report.model = a.model;
    report.title = fmt::format("{} from {}", a.model, std::filesystem::path(a.photo).filename().string());
    report.command = a.command;
    const PhotoSettings& settings = r.Simulator().Settings();
    report.settings = {{"Method", r.posterior.method},
                       {"Photograph", fmt::format("{0} x {0} pixels, {1:.4g} cm wide, from {2:.4g} cm",
                                                  settings.resolution, settings.extent, settings.distance)},
                       {"Seed", std::to_string(a.seed)}};
    if (settings.averaging > 1)
        report.settings.emplace_back(
            "Pixels", fmt::format("means of {0} x {0}, in simulations too", settings.averaging));
    for (const std::string& note : r.Simulator().Notes()) report.settings.emplace_back("Priors", note);
    if (!a.mapOnly)
        report.settings.emplace_back("Draws", fmt::format("{} chains of {}", a.chains, a.samples));
    if (r.kinds.size() > 1) report.settings.emplace_back("Kinds", KindsText(r));
    report.isMapOnly = a.mapOnly;
    report.handError = HandError(a).value_or(0);
    report.isCalibrated = report.handError == 0;
    AddParameters(r, &report);
    report.numSummaries = r.Simulator().SummaryNames().size();
    report.misfit = r.posterior.misfit;
    report.tau = r.posterior.tau;
    report.hasMeanSettled = r.posterior.hasMeanSettled;
    for (const std::vector<Draw>& draws : r.posterior.chains.draws)
        for (const Draw& draw : draws) report.numDivergent += draw.isDivergent;
    for (const std::string& warning : r.photo.warnings) report.warnings.push_back(Sentence(warning));
    for (const std::string& warning : r.Simulator().Warnings()) report.warnings.push_back(Sentence(warning));
    report.checks = r.predictive.checks;
    report.residuals = r.predictive.residuals;
    report.numPredicted = int(r.predictive.summaries.rows());
    report.waves = r.posterior.waves;
    AddImages(r, &report);
    return report;
}

}  // namespace lacquer::cmd
