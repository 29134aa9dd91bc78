// What the report of `lacquer estimate` says in words. No sentence says more than the intervals do.
#pragma once

#include <string>
#include <vector>

#include "cmd/estimate/report.h"

namespace lacquer::cmd {

/// Above this R-hat, or below this effective number of draws, chains have not converged; the second pair is
/// what is good [Vehtari et al. 2021].
inline constexpr double kWorstRhat = 1.05, kMinEss = 100, kGoodRhat = 1.01, kGoodEss = 400;

/// Where the knowledge of a parameter is from, by sd / prior sd: at most a half is the data's, above nine
/// tenths the prior's.
enum class ToldBy { Unknown, Prior, Little, Data };
ToldBy WhatTells(const EstimateParameter& parameter);
/// Part of the prior's standard deviation that the data took away, in [0,1]; NaN if one is not known.
double ShareTold(const EstimateParameter& parameter);

/// All parameters have an R-hat and effective numbers that pass, nothing was stopped, and means have settled.
bool HasConverged(const EstimateReport& report);

/// Its meaning, or its name if it has none; factors with signs between them are its name.
std::string LabelOf(const EstimateParameter& parameter);
/// "between 0.24 and 0.33 cm": ends rounded outwards to a tenth of the width or finer. Empty if not known.
std::string IntervalText(const EstimateParameter& parameter);
/// "energy at 8 cycles/cm: the photograph has less than the model, by 6.1 standard deviations"
std::string ResidualText(const EstimateResidual& residual);

/// Summaries outside of all predicted values, and how many would be by chance if the model were right.
struct OutsideCount {
    size_t count = 0, of = 0;
    double expected = 0;
};
OutsideCount CountOutside(const EstimateReport& report, bool isHeldOut);

/// One sentence for somebody who knows no statistics.
std::string VerdictOn(const EstimateReport& report);
/// A statement below the verdict: what it is about, and what there is to say.
struct EstimateFinding {
    std::string label, text;
};
std::vector<EstimateFinding> FindingsOf(const EstimateReport& report);
/// What makes intervals wrong or weak; most grave first.
std::vector<std::string> WarningsOf(const EstimateReport& report);

}  // namespace lacquer::cmd
