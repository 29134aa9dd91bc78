#include "estimate/layered/noisy_measurement.h"

namespace lacquer::estimate {

Vector NoisyMeasurement::Simulate(const Vector& x, uint64_t seed) const {
    const Eigen::Index d = x.size() - 1;
    const Vector all = truth_(x.head(d), Hash(seed, uint64_t(1)));
    const Eigen::Index m = all.size() / 2;
    const Vector values = all.head(m), errors = all.tail(m);
    Random random(seed, uint64_t(2));
    Vector summaries(2 * m);
    summaries << FlooredLogs(values, floor_) + x[d] * random.Normals(m),
        FlooredErrors(values, errors, floor_);
    return summaries;
}

ObservedLobes NoisyMeasurement::Observed(const Vector& summaries) const {
    const Eigen::Index m = summaries.size() / 2;
    return {summaries.head(m), summaries.tail(m), floor_};
}

}  // namespace lacquer::estimate
