#include "estimate/layered/lobe_data.h"

#include <cmath>

namespace lacquer::estimate {

Vector FlooredLogs(const Vector& values, double floor) {
    return 0.5 * (values.array().square() + floor * floor).log();
}

Vector FlooredErrors(const Vector& values, const Vector& errors, double floor) {
    return errors.array() * values.array() / (values.array().square() + floor * floor);
}

ObservedLobes ObserveLobes(const Vector& values, const Vector& relativeDeviations, double floor) {
    if (!(floor > 0)) floor = kFloorOfPeak * values.maxCoeff();
    return {FlooredLogs(values, floor), FlooredErrors(values, values.cwiseProduct(relativeDeviations), floor),
            floor};
}

LobeRuns LogsOf(const Runs& runs, double floor) {
    constexpr double kMaxCorrection = 0.1;
    const Eigen::Index m = runs.summaries.cols() / 2;
    LobeRuns logs{Matrix(runs.Count(), m), Matrix(runs.Count(), m)};
    for (Eigen::Index i = 0; i < runs.Count(); ++i) {
        const Vector values = runs.summaries.row(i).head(m), errors = runs.summaries.row(i).tail(m);
        const Vector relative = FlooredErrors(values, errors, floor);
        logs.errors.row(i) = relative;
        logs.values.row(i) =
            FlooredLogs(values, floor) + (0.5 * relative.array().square()).min(kMaxCorrection).matrix();
    }
    return logs;
}

}  // namespace lacquer::estimate
