#include "cmd/estimate/layered_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "cmd/page_parts.h"
#include "estimate/diagnostics/sample_moments.h"
#include "estimate/output/predictive_check.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

/// Of the seeds of noise that predictions are given for the checks.
constexpr uint64_t kNoiseSeed = 303;

std::vector<std::string> ChannelsOf(const Measurement& m) {
    return m.IsColor() ? std::vector<std::string>{"r", "g", "b"} : std::vector<std::string>{"value"};
}

/// Rows that make one curve: one direction of the light and one plane, or one pair of directions.
std::string CurveOf(const Measurement& m, size_t row) {
    const DirectionAngles& d = m.directions[row];
    if (!m.IsColor()) return "light and view at " + d.ToString() + "°";
    double azimuth = std::fmod(d.phiO - d.phiI + 720, 180);
    if (azimuth > 179.9) azimuth = 0;
    return azimuth < 0.1 ? fmt::format("light from {:.4g}°", d.thetaI)
                         : fmt::format("light from {:.4g}°, view turned by {:.4g}°", d.thetaI, azimuth);
}
/// Where a row lies on its curve: the wavelength, or the angle of view, positive on the far side of the
/// light.
double PlaceOf(const Measurement& m, size_t row) {
    if (!m.IsColor()) return m.wavelengths[row];
    const DirectionAngles& d = m.directions[row];
    const double azimuth = std::fmod(d.phiO - d.phiI + 720, 360);
    return azimuth > 89 && azimuth < 269.9 ? d.thetaO : -d.thetaO;
}

double FlooredBack(double logarithm, double floor) {
    return std::sqrt(std::max(0., std::exp(2 * logarithm) - floor * floor));
}

/// A channel at one place: what was measured, and the middle 90 % of what is predicted.
void AddPoint(const LayeredResults& r, size_t row, Eigen::Index channel, EstimateLobe::Channel* curve) {
    const Eigen::Index i = Eigen::Index(row) * r.problem.measurement.values.cols() + channel;
    std::vector<double> values(r.predicted.col(i).begin(), r.predicted.col(i).end());
    std::sort(values.begin(), values.end());
    curve->measured.push_back(r.problem.measurement.values(Eigen::Index(row), channel));
    curve->low.push_back(FlooredBack(SortedQuantile(values, 0.05), r.observed.floor));
    curve->median.push_back(FlooredBack(SortedQuantile(values, 0.5), r.observed.floor));
    curve->high.push_back(FlooredBack(SortedQuantile(values, 0.95), r.observed.floor));
}

void AddLobes(const LayeredResults& r, EstimateReport* report) {
    const Measurement& m = r.problem.measurement;
    std::vector<std::string> titles;
    std::map<std::string, std::vector<size_t>> rows;
    for (size_t row = 0; row < m.directions.size(); ++row) {
        const std::string title = CurveOf(m, row);
        if (!rows.contains(title)) titles.push_back(title);
        rows[title].push_back(row);
    }
    for (const std::string& title : titles) {
        std::vector<size_t>& ofCurve = rows[title];
        std::stable_sort(ofCurve.begin(), ofCurve.end(),
                         [&](size_t a, size_t b) { return PlaceOf(m, a) < PlaceOf(m, b); });
        EstimateLobe lobe{title, m.IsColor() ? "angle of view [degrees]" : "wavelength [nm]", {}, {}};
        for (const size_t row : ofCurve) lobe.places.push_back(PlaceOf(m, row));
        for (Eigen::Index c = 0; c < m.values.cols(); ++c) {
            EstimateLobe::Channel channel{ChannelsOf(m)[size_t(c)], {}, {}, {}, {}};
            for (const size_t row : ofCurve) AddPoint(r, row, c, &channel);
            lobe.channels.push_back(std::move(channel));
        }
        report->lobes.push_back(std::move(lobe));
    }
}

/// Predictions with noise of their own beside what was measured.
void AddChecks(const LayeredResults& r, EstimateReport* report) {
    Matrix noisy = r.predicted;
    for (Eigen::Index k = 0; k < noisy.rows(); ++k) {
        Random random(r.arguments.seed, kNoiseSeed, k);
        for (Eigen::Index i = 0; i < noisy.cols(); ++i)
            noisy(k, i) += std::hypot(r.noise[k], r.observed.deviations[i]) * random.Normal();
    }
    const std::vector<PredictiveCheck> checks =
        CheckPredictions(r.problem.ValueNames(), noisy, r.observed.logs);
    const std::vector<std::string> channels = ChannelsOf(r.problem.measurement);
    for (const std::string& channel : channels) {
        EstimateCheck ofChannel{.family = channel, .isHeldOut = false, .names = {}, .shares = {}};
        for (size_t i = 0; i < checks.size(); ++i) {
            if (channels.size() > 1 && !checks[i].summary.starts_with(channel)) continue;
            ofChannel.names.push_back(checks[i].summary);
            ofChannel.shares.push_back(checks[i].shareAbove);
            report->residuals.push_back({checks[i].summary, checks[i].Residual()});
        }
        report->checks.push_back(std::move(ofChannel));
    }
    report->numPredicted = int(noisy.rows());
}

void AddParameters(const LayeredResults& r, EstimateReport* report) {
    report->parameters = r.summary.parameters;
    const auto truthOf = [&](const std::string& name) {
        const auto truth = r.truth.find(name);
        return truth == r.truth.end() ? std::optional<double>() : truth->second;
    };
    for (EstimateParameter& p : report->parameters) {
        for (const SceneParameter& s : r.problem.parameters->All())
            if (s.name == p.name) p.meaning = s.meaning;
        if (p.name == kNoiseName) p.meaning = "noise of the measurement";
        p.truth = truthOf(p.name);
        if (p.factors.size() != 2) continue;
        p.meaning = fmt::format("optical thickness ({})", p.name);
        if (truthOf(p.factors[0]) && truthOf(p.factors[1]))
            p.truth = *truthOf(p.factors[0]) * *truthOf(p.factors[1]);
    }
}

/// What is left between material and measurement, as the beginning of the verdict.
std::string FitOf(const LayeredResults& r) {
    constexpr double kLarge = 0.15;
    double noise = 0;
    for (const EstimateParameter& p : r.summary.parameters)
        if (p.name == kNoiseName) noise = p.q50;
    return noise <= kLarge
               ? fmt::format("The material explains the measurement up to noise of about {:.2g}\u00a0%",
                             100 * noise)
               : fmt::format(
                     "The material resembles the measurement only within {:.2g}\u00a0%, so other layers may "
                     "be there",
                     100 * noise);
}

}  // namespace

std::string NextText(const std::vector<NextDirection>& next) {
    if (next.empty()) return "";
    const NextDirection& best = next.front();
    if (best.ratio < 0.05)
        return "Hardly any further measurement would tell more: predictions vary less than its noise "
               "everywhere.";
    return fmt::format(
        "Light from {:.4g}° and view at {:.4g}°, turned by {:.4g}°, would tell most: predictions there "
        "differ by "
        "{:.2g}\u00a0%, and their variance is {:.2g} times that of the noise.",
        best.direction.thetaI, best.direction.thetaO, best.direction.phiO - best.direction.phiI,
        100 * best.deviation, best.ratio);
}

EstimateReport ReportOf(const LayeredResults& r) {
    const EstimateArguments& a = r.arguments;
    EstimateReport report;
    report.subject = "measurement";
    report.model = r.problem.parameters->Material();
    report.title =
        fmt::format("{} from {}", report.model, std::filesystem::path(a.photo).filename().string());
    report.command = a.command;
    report.fit = FitOf(r);
    report.settings = {
        {"Method", r.problem.IsExact() ? std::string("closed form")
                                       : fmt::format("emulated, {} simulations", r.posterior.numRuns)},
        {"Measurement", r.problem.photograph
                            ? fmt::format("a photograph, {} values", r.observed.logs.size())
                            : fmt::format("{} directions{}", r.problem.measurement.NumRows(),
                                          r.problem.measurement.IsColor() ? ", three channels" : "")},
        {"Scene", a.scene},
        {"Seed", std::to_string(a.seed)},
        {"Draws", fmt::format("{} chains of {}", a.chains, a.samples)}};
    if (a.robust) report.settings.emplace_back("Errors", "Student's t, 4 degrees of freedom");
    AddParameters(r, &report);
    report.numSummaries = size_t(r.observed.logs.size());
    report.hasMeanSettled = r.problem.IsExact() || r.posterior.hasConverged;
    for (const std::vector<Draw>& draws : r.chains.draws)
        for (const Draw& draw : draws) report.numDivergent += draw.isDivergent;
    for (const LobeWave& wave : r.posterior.waves)
        report.waves.push_back({double(wave.runs), report.waves.empty() ? kUnknown : wave.shift, wave.misfit,
                                wave.acceptance, wave.maxRhat});
    if (r.problem.photograph) {
        report.warnings.emplace_back(kPhotographWarning);
    } else {
        if (const std::string doubt = Doubt(r.problem.measurement); !doubt.empty())
            report.warnings.push_back(Sentence(doubt));
        AddLobes(r, &report);
    }
    AddChecks(r, &report);
    constexpr size_t kShown = 8;
    for (const NextDirection& next : r.next)
        if (report.next.size() < kShown)
            report.next.push_back({next.direction.thetaI, next.direction.phiI, next.direction.thetaO,
                                   next.direction.phiO, next.deviation, next.ratio});
    report.nextText = NextText(r.next);
    return report;
}

}  // namespace lacquer::cmd
