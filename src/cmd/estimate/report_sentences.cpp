#include "cmd/estimate/report_sentences.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>

namespace lacquer::cmd {
namespace {

/// chi^2/p above which the model misses the photograph, and the widening above which it is another material.
constexpr double kMisfit = 1.5, kWrongModel = 3;
/// Part of the posterior near a bound that is worth a word.
constexpr double kAtBound = 0.05;
constexpr const char* kIf = "if the model is right";

std::string Signed(std::string text) {
    if (!text.empty() && text[0] == '-') text.replace(0, 1, "−");
    return text;
}
std::string Percent(double share) {
    if (share > 0 && share < 0.005) return "less than 1\u00a0%";
    if (share < 1 && share > 0.995) return "more than 99\u00a0%";
    return fmt::format("{:.0f}\u00a0%", 100 * share);
}
std::string Number(double value) {
    const bool isWhole = std::abs(value) >= 1000 && std::abs(value) < 1e6;
    return Signed(isWhole ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value));
}
std::string Rhat(double value) { return fmt::format("{:.{}f}", value, value < 1.095 ? 3 : 2); }

/// "a, b and c"; of more than `most` the first ones and how many more.
std::string Listed(const std::vector<std::string>& names, size_t most = 1000) {
    const size_t shown = names.size() > most + 1 ? most : names.size();
    std::string text;
    for (size_t i = 0; i < shown; ++i) {
        const bool isLast = i + 1 == names.size();
        text += (i == 0 ? "" : isLast ? " and " : ", ") + names[i];
    }
    return shown < names.size() ? text + fmt::format(" and {} more", names.size() - shown) : text;
}

std::vector<const EstimateParameter*> Parameters(
    const EstimateReport& report, const std::function<bool(const EstimateParameter&)>& isWanted) {
    std::vector<const EstimateParameter*> found;
    for (const EstimateParameter& p : report.parameters)
        if (isWanted(p)) found.push_back(&p);
    return found;
}
std::vector<const EstimateParameter*> ParametersToldBy(const EstimateReport& report, ToldBy by) {
    return Parameters(report,
                      [&](const EstimateParameter& p) { return p.factors.empty() && WhatTells(p) == by; });
}
std::vector<std::string> Labels(const std::vector<const EstimateParameter*>& parameters) {
    std::vector<std::string> labels;
    for (const EstimateParameter* p : parameters) labels.push_back(LabelOf(*p));
    return labels;
}

double SmallerEss(const EstimateParameter& p) {
    return std::isnan(p.essBulk) || std::isnan(p.essTail) ? kUnknown : std::min(p.essBulk, p.essTail);
}

/// Whose known value is the worst by what `isWorse` says; null if none is known.
const EstimateParameter* Worst(const EstimateReport& report,
                               const std::function<double(const EstimateParameter&)>& value,
                               const std::function<bool(double, double)>& isWorse) {
    const EstimateParameter* worst = nullptr;
    for (const EstimateParameter& p : report.parameters)
        if (!std::isnan(value(p)) && (!worst || isWorse(value(p), value(*worst)))) worst = &p;
    return worst;
}
double RhatOf(const EstimateParameter& p) { return p.rhat; }
const EstimateParameter* WorstRhat(const EstimateReport& report) {
    return Worst(report, RhatOf, std::greater<>());
}
const EstimateParameter* WorstEss(const EstimateReport& report) {
    return Worst(report, SmallerEss, std::less<>());
}

constexpr const char* kWaveMoves = "the last wave of simulations still moved the result";

/// Why the chains are not to be relied on, as the end of a sentence; empty if they are.
std::string ReasonAgainst(const EstimateReport& report) {
    if (report.parameters.empty()) return "there are no chains";
    const EstimateParameter *rhat = WorstRhat(report), *ess = WorstEss(report);
    if (rhat && rhat->rhat > kWorstRhat)
        return fmt::format("the chains still disagree, most about {} (R-hat {})", LabelOf(*rhat),
                           Rhat(rhat->rhat));
    if (ess && SmallerEss(*ess) < kMinEss)
        return fmt::format("there are only {:.0f} independent draws of {}", SmallerEss(*ess), LabelOf(*ess));
    for (const EstimateParameter& p : report.parameters) {
        if (std::isnan(p.rhat))
            return fmt::format("whether the chains agree about {} is not known", LabelOf(p));
        if (std::isnan(SmallerEss(p)))
            return fmt::format("how many independent draws there are of {} is not known", LabelOf(p));
    }
    if (report.wasStopped) return "the time ended before the computation did";
    if (!report.hasMeanSettled) return kWaveMoves;
    return "";
}

bool IsMisfit(const EstimateReport& report) { return report.misfit > kMisfit || report.tau > 1; }

/// How well the model does, as a clause that begins a sentence.
std::string FitClause(const EstimateReport& report) {
    if (!report.fit.empty()) return report.fit;
    if (std::isnan(report.misfit)) return "How well the model reproduces the photograph is not known";
    if (!IsMisfit(report))
        return "The model looks as much like the photograph as two samples of one material look like each "
               "other";
    const double times = report.tau > 1 ? report.tau : std::sqrt(report.misfit);
    if (times > kWrongModel)
        return fmt::format(
            "The model does not look like the photograph (it is off by {:.2g} times what chance "
            "explains), so its numbers mean little",
            times);
    return fmt::format(
        "The model resembles the photograph but misses it by {:.2g} times what chance explains", times);
}

/// What the photograph tells, as a clause.
std::string TellsClause(const EstimateReport& report) {
    const auto list = [&](const char* begin, ToldBy by) {
        constexpr size_t kMost = 4;
        const std::vector<std::string> labels = Labels(ParametersToldBy(report, by));
        return labels.empty() ? "" : begin + Listed(labels, kMost);
    };
    const std::string told = list("tells ", ToldBy::Data), little = list("little about ", ToldBy::Little),
                      nothing = list("hardly anything about ", ToldBy::Prior);
    const std::string rest = little + (little.empty() || nothing.empty() ? "" : ", and ") + nothing;
    if (told.empty() && rest.empty()) return "";
    return "the photograph " + told + (told.empty() || rest.empty() ? "" : ", but ") +
           (rest.empty() ? "" : "says " + rest);
}

struct AtBound {
    const EstimateParameter* parameter;
    bool isHigh;
    double share;
};
std::vector<AtBound> AtBounds(const EstimateReport& report) {
    std::vector<AtBound> found;
    for (const EstimateParameter& p : report.parameters) {
        if (!p.factors.empty()) continue;
        if (p.shareAtLow > kAtBound) found.push_back({&p, false, p.shareAtLow});
        if (p.shareAtHigh > kAtBound) found.push_back({&p, true, p.shareAtHigh});
    }
    return found;
}
std::string BoundsClause(const EstimateReport& report) {
    std::vector<std::string> texts;
    for (const AtBound& bound : AtBounds(report))
        texts.push_back(
            fmt::format("{} into its {} limit", LabelOf(*bound.parameter), bound.isHigh ? "upper" : "lower"));
    if (texts.empty()) return "";
    return fmt::format(
        "; {} {}",
        texts.size() == 1 ? "one parameter runs into a limit:" : "some run into limits:", Listed(texts, 3));
}

void AddChains(const EstimateReport& report, std::vector<EstimateFinding>* findings) {
    if (report.isMapOnly) return;
    const EstimateParameter *rhat = WorstRhat(report), *ess = WorstEss(report);
    if (report.parameters.empty()) return;
    const size_t numChains = report.parameters[0].chains.size();
    std::string text = HasConverged(report) ? "The chains agree" : "Not converged: " + ReasonAgainst(report);
    if (numChains > 0)
        text += fmt::format(". {} chain{} of {} draws", numChains, numChains == 1 ? "" : "s",
                            report.parameters[0].chains[0].size());
    if (rhat)
        text += fmt::format("; the largest R-hat is {} ({}; 1 is perfect, up to {} good)", Rhat(rhat->rhat),
                            LabelOf(*rhat), kGoodRhat);
    if (ess)
        text += fmt::format("; the draws are worth at least {:.0f} independent ones ({}; {} are enough)",
                            SmallerEss(*ess), LabelOf(*ess), kGoodEss);
    findings->push_back({"Chains", text + "."});
}

void AddFit(const EstimateReport& report, std::vector<EstimateFinding>* findings) {
    if (std::isnan(report.misfit)) return;
    std::string text = fmt::format("χ²/p is {:.3g} over {} summaries; chance alone makes it about 1.",
                                   report.misfit, report.numSummaries);
    if (report.tau > 1)
        text += fmt::format(
            " The model misses the photograph by {:.2g} standard deviations, and all intervals are "
            "widened by that factor.",
            report.tau);
    findings->push_back({"Fit", text});
}

/// "roughness between 0.24 and 0.33, cell size between 0.28 and 0.32 cm"
std::string Intervals(const std::vector<const EstimateParameter*>& parameters) {
    std::vector<std::string> texts;
    for (const EstimateParameter* p : parameters) {
        const std::string interval = IntervalText(*p);
        if (!interval.empty()) texts.push_back(LabelOf(*p) + " " + interval);
    }
    std::string joined;
    for (size_t i = 0; i < texts.size(); ++i) joined += (i ? "; " : "") + texts[i];
    return joined;
}

/// What an interval's probability rests on, before the intervals.
std::string Condition(const EstimateReport& report) {
    if (!HasConverged(report)) return "So far, and subject to change: ";
    if (!report.isCalibrated)
        return fmt::format("With 90\u00a0% probability, {} and so is the error that was set by hand: ", kIf);
    return fmt::format("With 90\u00a0% probability, {}: ", kIf);
}

void AddTold(const EstimateReport& report, std::vector<EstimateFinding>* findings) {
    if (report.isMapOnly) return;
    const auto add = [&](const char* label, ToldBy by) {
        const std::string text = Intervals(ParametersToldBy(report, by));
        if (!text.empty()) findings->push_back({label, Condition(report) + text + "."});
    };
    add("The photograph tells", ToldBy::Data);
    add("It says little about", ToldBy::Little);
    const std::vector<std::string> labels = Labels(ParametersToldBy(report, ToldBy::Prior));
    if (!labels.empty())
        findings->push_back({"Only the prior tells",
                             fmt::format("{}{}: what was assumed before the photograph, and hardly narrower.",
                                         HasConverged(report) ? "" : "So far, ", Listed(labels))});
}

/// The factors among the parameters.
std::vector<const EstimateParameter*> FactorsOf(const EstimateReport& report,
                                                const EstimateParameter& product) {
    return Parameters(report, [&](const EstimateParameter& p) {
        return std::find(product.factors.begin(), product.factors.end(), p.name) != product.factors.end();
    });
}

void AddProducts(const EstimateReport& report, std::vector<EstimateFinding>* findings) {
    constexpr double kClearlyMore = 0.8;  // of the factors' own sd / prior sd
    for (const EstimateParameter& product : report.parameters) {
        const std::vector<const EstimateParameter*> factors = FactorsOf(report, product);
        if (factors.size() < 2 || IntervalText(product).empty() || std::isnan(ShareTold(product))) continue;
        double best = 0;
        for (const EstimateParameter* factor : factors) best = std::max(best, ShareTold(*factor));
        if (!(1 - ShareTold(product) < kClearlyMore * (1 - best))) continue;
        findings->push_back(
            {"Known as a product",
             fmt::format("{}{} {}, {} narrower than assumed; {} alone at most {}.", Condition(report),
                         LabelOf(product), IntervalText(product), Percent(ShareTold(product)),
                         Listed(Labels(factors)), Percent(best))});
    }
}

void AddBounds(const EstimateReport& report, std::vector<EstimateFinding>* findings) {
    std::vector<std::string> texts;
    for (const AtBound& bound : AtBounds(report)) {
        const EstimateParameter& p = *bound.parameter;
        const std::string limit = p.prior ? " " + Number(bound.isHigh ? p.prior->high : p.prior->low) : "";
        texts.push_back(fmt::format("{} of {} is at the {} limit{}", Percent(bound.share), LabelOf(p),
                                    bound.isHigh ? "upper" : "lower", limit));
    }
    if (!texts.empty())
        findings->push_back(
            {"At a limit", Listed(texts, 6) + ". There the limit, not the photograph, ends the interval."});
}

void AddPredictions(const EstimateReport& report, std::vector<EstimateFinding>* findings) {
    for (const bool isHeldOut : {false, true}) {
        const OutsideCount outside = CountOutside(report, isHeldOut);
        if (outside.of == 0) continue;
        findings->push_back(
            {isHeldOut ? "Summaries not used" : "Summaries used",
             fmt::format(
                 "{} of {} summaries {} outside of all {} values that the posterior predicts; about {:.2g} "
                 "would by chance.",
                 outside.count, outside.of, outside.count == 1 ? "lies" : "lie", report.numPredicted,
                 outside.expected)});
    }
}

void AddTruth(const EstimateReport& report, std::vector<EstimateFinding>* findings) {
    size_t known = 0, inside = 0;
    std::vector<std::string> missed;
    for (const EstimateParameter& p : report.parameters) {
        if (!p.truth || !p.factors.empty() || std::isnan(p.q5) || std::isnan(p.q95)) continue;
        ++known;
        if (p.q5 <= *p.truth && *p.truth <= p.q95)
            ++inside;
        else
            missed.push_back(LabelOf(p));
    }
    if (known == 0) return;
    std::string text = fmt::format("{} of {} lie inside of their 90\u00a0% intervals; about {:.2g} should.",
                                   inside, known, 0.9 * double(known));
    if (!missed.empty()) text += " Outside: " + Listed(missed) + ".";
    findings->push_back({"True values", text});
}

void WarnOfSampling(const EstimateReport& report, std::vector<std::string>* warnings) {
    if (report.isMapOnly) {
        if (!report.hasMeanSettled) warnings->push_back(fmt::format("Not converged: {}.", kWaveMoves));
        return;
    }
    const std::string reason = ReasonAgainst(report);
    if (!reason.empty()) warnings->push_back(fmt::format("Not converged: {}.", reason));
    const EstimateParameter *rhat = WorstRhat(report), *ess = WorstEss(report);
    if (rhat && rhat->rhat > kGoodRhat && rhat->rhat <= kWorstRhat)
        warnings->push_back(
            fmt::format("R-hat reaches {} ({}): good is {} or less. A longer run tightens the "
                        "ends of the intervals.",
                        Rhat(rhat->rhat), LabelOf(*rhat), kGoodRhat));
    if (ess && SmallerEss(*ess) < kGoodEss && SmallerEss(*ess) >= kMinEss)
        warnings->push_back(
            fmt::format("The draws of {} are worth {:.0f} independent ones: {} make ends of intervals "
                        "reliable.",
                        LabelOf(*ess), SmallerEss(*ess), kGoodEss));
    if (report.numDivergent > 0)
        warnings->push_back(
            fmt::format("{} step{} of the sampler diverged: there may be a part of the distribution "
                        "that it cannot enter.",
                        report.numDivergent, report.numDivergent == 1 ? "" : "s"));
    if (report.lowestEbfmi < 0.3)
        warnings->push_back(fmt::format(
            "E-BFMI is {:.2g}, below 0.3: the sampler explores the tails too slowly.", report.lowestEbfmi));
    if (report.paretoK > 0.7)
        warnings->push_back(
            fmt::format("Pareto k is {:.2g}, above 0.7: the normal approximation at the most probable "
                        "point does not describe this distribution.",
                        report.paretoK));
}

void WarnOfIntervals(const EstimateReport& report, std::vector<std::string>* warnings) {
    if (!report.isCalibrated)
        warnings->push_back(fmt::format("Intervals are not calibrated: the error was set to {:g} by hand.",
                                        report.handError));
    if (IsMisfit(report) && report.tau <= 1)
        warnings->push_back(fmt::format(
            "χ²/p is {:.3g}, and the intervals are not widened by it: they are too narrow.", report.misfit));
    if (report.tau > 1)
        warnings->push_back(
            fmt::format("The model misses the photograph by {:.2g} standard deviations; intervals are "
                        "widened by it.",
                        report.tau));
}

void WarnOfPredictions(const EstimateReport& report, std::vector<std::string>* warnings) {
    const OutsideCount outside = CountOutside(report, true);
    if (double(outside.count) > 3 + 3 * outside.expected)
        warnings->push_back(
            fmt::format("{} of {} summaries that were not used lie outside of what is predicted: the "
                        "model lacks something that the photograph shows.",
                        outside.count, outside.of));
}

}  // namespace

ToldBy WhatTells(const EstimateParameter& parameter) {
    constexpr double kHalf = 0.5, kHardly = 0.9;
    const double ratio = parameter.sd / parameter.priorSd;
    if (!std::isfinite(ratio)) return ToldBy::Unknown;
    return ratio <= kHalf ? ToldBy::Data : ratio <= kHardly ? ToldBy::Little : ToldBy::Prior;
}

double ShareTold(const EstimateParameter& parameter) {
    const double ratio = parameter.sd / parameter.priorSd;
    return std::isfinite(ratio) ? std::clamp(1 - ratio, 0., 1.) : kUnknown;
}

bool HasConverged(const EstimateReport& report) { return !report.isMapOnly && ReasonAgainst(report).empty(); }

std::string LabelOf(const EstimateParameter& parameter) {
    return parameter.meaning.empty() ? parameter.name : parameter.meaning;
}

std::string IntervalText(const EstimateParameter& parameter) {
    const double width = parameter.q95 - parameter.q5;
    if (!std::isfinite(width)) return "";
    const std::string unit = parameter.unit.empty() ? "" : "\u00a0" + parameter.unit;
    if (!(width > 0)) return fmt::format("at {}{}", Number(parameter.q5), unit);
    const int exponent = int(std::floor(std::log10(width / 10)));
    const double step = std::pow(10., exponent);
    // Rounding of the quotient must not push an end that is round already.
    constexpr double kSlack = 1e-9;
    const double from = std::floor(parameter.q5 / step + kSlack) * step,
                 to = std::ceil(parameter.q95 / step - kSlack) * step;
    const int digits = std::max(0, -exponent);
    if (digits > 6)
        return fmt::format("between {} and {}{}", Signed(fmt::format("{:.2e}", from)),
                           Signed(fmt::format("{:.2e}", to)), unit);
    // Adding 0 turns −0 into 0.
    return fmt::format("between {} and {}{}", Signed(fmt::format("{:.{}f}", from + 0., digits)),
                       Signed(fmt::format("{:.{}f}", to + 0., digits)), unit);
}

std::string ResidualText(const EstimateResidual& residual) {
    return fmt::format("{}: the photograph has {} than the model, by {:.2g} standard deviations",
                       residual.name, residual.deviation < 0 ? "less" : "more", std::abs(residual.deviation));
}

OutsideCount CountOutside(const EstimateReport& report, bool isHeldOut) {
    OutsideCount outside;
    for (const EstimateCheck& check : report.checks) {
        if (check.isHeldOut != isHeldOut) continue;
        for (const double share : check.shares) {
            if (!std::isfinite(share)) continue;
            ++outside.of;
            outside.count += share <= 0 || share >= 1;
        }
    }
    // The photograph has any rank among itself and n predicted values alike.
    outside.expected = 2. * double(outside.of) / (report.numPredicted + 1.);
    return outside;
}

std::string VerdictOn(const EstimateReport& report) {
    std::string fit = FitClause(report);
    if (report.isMapOnly)
        return fit +
               "; these are the most probable values alone, and how uncertain they are was not computed.";
    const std::string reason = ReasonAgainst(report);
    if (!reason.empty()) {
        fit[0] = char(std::tolower(static_cast<unsigned char>(fit[0])));
        return fmt::format("Do not rely on these numbers yet, because {}; {}.", reason, fit);
    }
    const std::string tells = TellsClause(report);
    if (!tells.empty()) fit += (IsMisfit(report) ? "; " : ", and ") + tells;
    fit += BoundsClause(report);
    if (!report.isCalibrated) fit += "; how wide the intervals are was decided by hand";
    return fit + ".";
}

std::vector<EstimateFinding> FindingsOf(const EstimateReport& report) {
    std::vector<EstimateFinding> findings;
    AddTold(report, &findings);
    AddProducts(report, &findings);
    if (!report.nextText.empty()) findings.push_back({"Measure next", report.nextText});
    AddBounds(report, &findings);
    AddFit(report, &findings);
    AddPredictions(report, &findings);
    AddChains(report, &findings);
    AddTruth(report, &findings);
    return findings;
}

std::vector<std::string> WarningsOf(const EstimateReport& report) {
    std::vector<std::string> warnings;
    WarnOfSampling(report, &warnings);
    if (!report.isMapOnly) WarnOfIntervals(report, &warnings);
    WarnOfPredictions(report, &warnings);
    warnings.insert(warnings.end(), report.warnings.begin(), report.warnings.end());
    return warnings;
}

}  // namespace lacquer::cmd
