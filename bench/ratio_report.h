// The figures of comparisons: a table for people, files for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "comparison.h"

namespace lacquer::bench {

/// Of all intervals.
inline constexpr double kConfidence = 0.95;
/// What others have for a baseline: part of every published ratio is the cost of this sampler.
inline constexpr const char* kSlowBaseline = "bidirectional@newton";

/// A ratio of errors with its interval and, for groups, its extremes.
struct Ratio {
    double value = 1;
    Interval interval;
    double least = 1, most = 1;
};
/// The geometric mean over rows, not none; each has its own replicas.
Ratio MeanRatio(std::span<const CandidateResult> rows, double LogRatios::*which);
inline Ratio RatioOf(const CandidateResult& result, double LogRatios::*which) {
    return MeanRatio({&result, 1}, which);
}

/// What the report says about its figures.
struct ReportOptions {
    std::string baseline;
    std::string json, csv;  ///< files, none if empty
    CompareOptions compare;
};

/// Prints the table as it grows and writes the files at the end.
class Report {
  public:
    /// The options must outlive the report.
    explicit Report(const ReportOptions& options);

    void PrintLegend() const;
    void StartGroup(const ConfigurationGroup& group);
    void AddRow(const Configuration& configuration, std::span<const CandidateResult> results);
    /// One line for each candidate over all rows of the group, and one against the slow baseline.
    void EndGroup();
    /// Errors: std::runtime_error if a file cannot be written.
    void WriteFiles() const;

  private:
    void PrintResult(const std::string& configuration, const CandidateResult& result, bool isBaseline) const;
    void AddSummary(std::span<const CandidateResult> rows, const std::string& baseline);

    const ReportOptions& options_;
    nlohmann::ordered_json json_;
    std::string csv_, group_;
    std::vector<std::vector<CandidateResult>> byCandidate_;  ///< of this group, without the baseline
};

}  // namespace lacquer::bench
