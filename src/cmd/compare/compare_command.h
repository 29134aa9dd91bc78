// lacquer compare: ways to render a scene against each other at equal time or equal samples.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Everything that the command line of `compare` can say.
struct CompareArguments {
    std::vector<std::string> scenes;
    std::vector<std::string> estimators{"bidirectional", "pairproduct", "halfvector", "auto"};
    std::vector<std::string> integrators, samplers, lightSamplers, denoisers;  ///< at most one of them
    std::string baseline;  ///< empty: the first of what is compared
    double time = 20;
    std::optional<int> equalSamples;
    int runs = 4;
    std::string reference;
    std::optional<int> referenceSpp;
    std::optional<double> referenceTime;
    std::string referenceBy;  ///< empty: as candidates.h says
    std::vector<std::string> boxes;
    std::string vary;
    std::string out;
    std::string resolution;
    int seed = 0;
    int threads = 0;
    bool quiet = false;
    std::string command;  ///< as typed, for the report
};

/// Declares the options on `app`.
void AddCompareOptions(CLI::App& app, CompareArguments& arguments);
/// Errors of the library pass through, for main to report.
ExitStatus RunCompare(const CompareArguments& arguments);

}  // namespace lacquer::cmd
