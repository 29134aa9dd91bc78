#include "estimate/calibration/simulation_based.h"

#include <algorithm>
#include <cmath>

#include "estimate/calibration/uniformity.h"
#include "estimate/infer/population.h"
#include "estimate/random.h"
#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::estimate {

namespace {

/// What one replicate found, for each parameter.
struct Replicate {
    bool isDone = false;
    std::vector<int> ranks;
    Vector sds;
};

Replicate RunReplicate(const Simulator& simulator, const InferenceMethod& infer,
                       const CalibrationOptions& options, uint64_t number) {
    Random random(options.seed, number);
    const Vector x = simulator.Parameters().SamplePrior(random), truth = simulator.Parameters().ToLogit(x);
    const Vector observed = simulator.Simulate(x, random.Bits());
    const Matrix draws = ThinnedColumns(infer(observed, random.Bits()), options.numDraws);
    Replicate result{.isDone = true, .ranks = {}, .sds = Vector(truth.size())};
    for (Eigen::Index i = 0; i < truth.size(); ++i) {
        result.ranks.push_back(int((draws.row(i).array() < truth[i]).count()));
        result.sds[i] =
            std::sqrt((draws.row(i).array() - draws.row(i).mean()).square().sum() / double(draws.cols() - 1));
    }
    return result;
}

/// Deviations of the prior in logits, from exact quantiles.
Vector PriorDeviations(const ParameterSpace& space) {
    constexpr int kPoints = 999;
    Matrix logits(Eigen::Index(space.Size()), kPoints);
    for (int k = 0; k < kPoints; ++k) {
        Vector x{Eigen::Index(space.Size())};
        for (size_t i = 0; i < space.Size(); ++i)
            x[Eigen::Index(i)] = space[i].prior.Quantile((k + 0.5) / kPoints);
        logits.col(k) = space.ToLogit(x);
    }
    const Matrix centered = logits.colwise() - logits.rowwise().mean();
    return (centered.rowwise().squaredNorm() / kPoints).cwiseSqrt();
}

/// Bins with ten replicates or more each, as many as divide the ranks.
int BinsFor(int replicates) {
    for (const int bins : {20, 10, 5, 4})
        if (replicates >= 10 * bins) return bins;
    return 2;
}

/// Part of the ranks in the middle `part` of all.
double Coverage(const std::vector<int>& ranks, int numRanks, double part) {
    const double margin = (1 - part) / 2 * numRanks;
    const auto inside = std::count_if(ranks.begin(), ranks.end(), [&](int rank) {
        return rank >= margin - 1e-9 && rank + 1 <= numRanks - margin + 1e-9;
    });
    return double(inside) / double(ranks.size());
}

double Median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

}  // namespace

CalibrationReport Calibrate(const Simulator& simulator, const InferenceMethod& infer,
                            const CalibrationOptions& options, Observer* observer) {
    LACQUER_CHECK(options.replicates > 0 && (options.numDraws + 1) % 20 == 0);
    std::vector<Replicate> replicates(size_t(options.replicates), Replicate{});
    ParallelFor(options.replicates, [&](int64_t i) {
        if (observer && observer->ShouldStop()) return;
        replicates[size_t(i)] = RunReplicate(simulator, infer, options, uint64_t(i));
        if (observer) observer->Advance(1);
    });
    std::erase_if(replicates, [](const Replicate& r) { return !r.isDone; });

    const ParameterSpace& space = simulator.Parameters();
    CalibrationReport report{int(replicates.size()), options.numDraws + 1, {}};
    if (replicates.empty()) return report;
    const EcdfEnvelope envelope(report.replicates, 20, 0.99);
    const Vector priorSds = PriorDeviations(space);
    for (size_t i = 0; i < space.Size(); ++i) {
        CalibratedParameter p;
        p.name = space[i].name;
        std::vector<double> shrinkages;
        for (const Replicate& r : replicates) {
            p.ranks.push_back(r.ranks[i]);
            shrinkages.push_back(r.sds[Eigen::Index(i)] / priorSds[Eigen::Index(i)]);
        }
        const ChiSquareOfRanks test = TestRanks(p.ranks, report.numRanks, BinsFor(report.replicates));
        p.chiSquare = test.value;
        p.degrees = test.degrees;
        p.pValue = test.pValue;
        p.isInsideEnvelope = envelope.Contains(p.ranks, report.numRanks);
        p.coverage50 = Coverage(p.ranks, report.numRanks, 0.5);
        p.coverage90 = Coverage(p.ranks, report.numRanks, 0.9);
        p.shrinkage = Median(shrinkages);
        report.parameters.push_back(std::move(p));
    }
    return report;
}

bool CalibrationReport::Passes() const {
    return std::all_of(parameters.begin(), parameters.end(), [](const auto& p) { return p.Passes(); });
}

std::string CalibrationReport::ToString() const {
    std::string text = fmt::format("{} replicates, ranks among {} draws\n", replicates, numRanks - 1);
    for (const CalibratedParameter& p : parameters)
        text += fmt::format(
            "{:<12} coverage 50 %: {:.3f}, 90 %: {:.3f}; chi-square({:.0f}) {:.1f}, p {:.3f}; ECDF {}; "
            "posterior/prior sd {:.2f}\n",
            p.name, p.coverage50, p.coverage90, p.degrees, p.chiSquare, p.pValue,
            p.isInsideEnvelope ? "inside" : "OUTSIDE", p.shrinkage);
    return text;
}

}  // namespace lacquer::estimate
