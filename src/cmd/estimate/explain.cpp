#include "cmd/estimate/explain.h"

#include <fmt/format.h>

#include <algorithm>

#include "estimate/diagnostics/family_information.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

/// Those in use, and of the others those that any photograph has.
std::vector<std::string> FamiliesToCompare(const PhotoSimulator& simulator) {
    std::vector<std::string> families = simulator.Families();
    for (const std::string_view family : SummaryFamilies())
        if (std::find(families.begin(), families.end(), family) == families.end())
            families.emplace_back(family);
    return families;
}

}  // namespace

std::string FamilyTable(const EstimateArguments& a, const PhotoSimulator& simulator, const Vector& natural) {
    constexpr Eigen::Index kRuns = 300;
    const std::vector<std::string> names = FamiliesToCompare(simulator);
    const std::unique_ptr<PhotoSimulator> all = SimulatorOf(a, simulator.Settings(), names);
    const ParameterSpace& space = simulator.Parameters();
    const Matrix deviations = PredictedDeviations(*all, all->FamilyRanges(), space.ToLogit(natural), kRuns,
                                                  Hash(a.seed, uint64_t(301)));
    std::string text = "Deviation over the prior's, if only these summaries were known:\n";
    text += fmt::format("{:<16}", "");
    for (const estimate::Parameter& parameter : space.All()) text += fmt::format("{:>13}", parameter.name);
    for (Eigen::Index f = 0; f < deviations.rows(); ++f) {
        text += fmt::format("\n{:<16}", size_t(f) < names.size() ? names[size_t(f)] : "all");
        for (Eigen::Index i = 0; i < deviations.cols(); ++i)
            text += fmt::format("{:>13.2f}", deviations(f, i));
    }
    return text + "\n";
}

}  // namespace lacquer::cmd
