#include "cmd/estimate/posterior_summary.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimate/calibration/simulation_based.h"
#include "estimate/diagnostics/convergence.h"
#include "estimate/emulator/runs.h"
#include "estimate/infer/population.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

/// Of sorted values, linear between them.
double Quantile(const std::vector<double>& sorted, double p) {
    const double at = p * double(sorted.size() - 1);
    const auto i = size_t(at);
    return i + 1 < sorted.size() ? sorted[i] + (at - double(i)) * (sorted[i + 1] - sorted[i]) : sorted[i];
}

struct Moments {
    double mean = 0, sd = 0;
};
Moments MomentsOf(const std::vector<double>& values) {
    const double n = double(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.) / n;
    double squares = 0;
    for (const double v : values) squares += (v - mean) * (v - mean);
    return {mean, std::sqrt(squares / (n - 1))};
}

/// Standard deviation of a cut normal distribution, by its quantiles at evenly spaced probabilities.
double SdOf(const Prior& prior) {
    constexpr int kPoints = 2000;
    std::vector<double> values;
    for (int i = 0; i < kPoints; ++i) values.push_back(prior.Quantile((i + 0.5) / kPoints));
    return MomentsOf(values).sd;
}

std::vector<double> RowOf(const Matrix& draws, Eigen::Index i) {
    std::vector<double> values(static_cast<size_t>(draws.cols()));
    for (Eigen::Index k = 0; k < draws.cols(); ++k) values[size_t(k)] = draws(i, k);
    return values;
}

ParameterSummary SummaryOf(const Parameter& parameter, const Matrix& byChain, double mode) {
    ParameterSummary s{
        .name = parameter.name, .unit = parameter.unit, .prior = parameter.prior, .mode = mode};
    std::vector<double> values(byChain.data(), byChain.data() + byChain.size());
    const Moments moments = MomentsOf(values);
    s.mean = moments.mean;
    s.sd = moments.sd;
    s.priorSd = SdOf(parameter.prior);
    const double edge = 0.01 * (parameter.prior.high - parameter.prior.low);
    for (const double v : values) {
        s.atLow += v < parameter.prior.low + edge;
        s.atHigh += v > parameter.prior.high - edge;
    }
    s.atLow /= double(values.size());
    s.atHigh /= double(values.size());
    std::sort(values.begin(), values.end());
    s.q05 = Quantile(values, 0.05);
    s.q50 = Quantile(values, 0.5);
    s.q95 = Quantile(values, 0.95);
    const Convergence convergence = ConvergenceOf(byChain);
    s.rhat = convergence.rhat;
    s.bulkEss = convergence.bulkEss;
    s.tailEss = convergence.tailEss;
    return s;
}

/// Light times an albedo or a reflectance, where its logarithm is known at least twice as well as either
/// factor's.
void AddProducts(const ParameterSpace& space, const Matrix& draws, std::vector<ProductSummary>* products) {
    const std::optional<size_t> light = space.Find("light");
    if (!light) return;
    const auto logSd = [](std::vector<double> values) {
        for (double& v : values) v = std::log(std::max(v, 1e-30));
        return MomentsOf(values).sd;
    };
    const std::vector<double> ofLight = RowOf(draws, Eigen::Index(*light));
    for (const char* name : {"r", "g", "b"}) {
        const std::optional<size_t> factor = space.Find(name);
        if (!factor) continue;
        const std::vector<double> ofFactor = RowOf(draws, Eigen::Index(*factor));
        std::vector<double> values(ofLight.size());
        for (size_t i = 0; i < values.size(); ++i) values[i] = ofLight[i] * ofFactor[i];
        if (2 * logSd(values) > std::min(logSd(ofLight), logSd(ofFactor))) continue;
        const Moments moments = MomentsOf(values);
        std::sort(values.begin(), values.end());
        ProductSummary product{std::string("light x ") + name, {"light", name}, moments.mean, moments.sd};
        product.q05 = Quantile(values, 0.05);
        product.q50 = Quantile(values, 0.5);
        product.q95 = Quantile(values, 0.95);
        products->push_back(std::move(product));
    }
}

/// The part of a summary's name that tells its family, by the order in which families were asked for.
struct FamilyRange {
    std::string family;
    Eigen::Index first, count;
};
std::vector<FamilyRange> RangesOf(const PhotoSimulator& simulator) {
    std::vector<FamilyRange> ranges;
    Eigen::Index first = 0;
    for (const std::string& family : simulator.Families()) {
        const auto count = Eigen::Index(MakeSummary(family, simulator.Settings().Grid())->Size());
        ranges.push_back({family, first, count});
        first += count;
    }
    return ranges;
}

/// Share of simulated values above the observed one, half of those that are equal.
double ShareAbove(const Vector& simulated, double observed) {
    double above = 0;
    for (const double v : simulated) above += v > observed ? 1 : v == observed ? 0.5 : 0;
    return above / double(simulated.size());
}

void AddChecks(const PhotoSimulator& simulator, const Matrix& simulated, const Vector& observed,
               bool isHeldOut, std::vector<EstimateCheck>* checks) {
    for (const FamilyRange& range : RangesOf(simulator)) {
        EstimateCheck check{.family = range.family, .isHeldOut = isHeldOut, .names = {}, .shares = {}};
        for (Eigen::Index i = range.first; i < range.first + range.count; ++i) {
            check.names.push_back(simulator.SummaryNames()[size_t(i)]);
            check.shares.push_back(ShareAbove(simulated.col(i), observed[i]));
        }
        checks->push_back(std::move(check));
    }
}

}  // namespace

Matrix PosteriorChains::NaturalCoordinate(const ParameterSpace& space, Eigen::Index i) const {
    Matrix values{Eigen::Index(draws[0].size()), Eigen::Index(draws.size())};
    for (size_t c = 0; c < draws.size(); ++c)
        for (size_t k = 0; k < draws[c].size(); ++k)
            values(Eigen::Index(k), Eigen::Index(c)) = space.ToNatural(draws[c][k].y)[i];
    return values;
}

Matrix PosteriorChains::Logits() const {
    Matrix values{draws[0][0].y.size(), Eigen::Index(draws.size() * draws[0].size())};
    Eigen::Index column = 0;
    for (const std::vector<Draw>& chain : draws)
        for (const Draw& draw : chain) values.col(column++) = draw.y;
    return values;
}

Matrix PosteriorChains::Natural(const ParameterSpace& space) const {
    Matrix values = Logits();
    for (Eigen::Index k = 0; k < values.cols(); ++k) values.col(k) = space.ToNatural(values.col(k));
    return values;
}

PosteriorSummary Summarize(const ParameterSpace& space, const PosteriorChains& chains, const Vector& mode) {
    PosteriorSummary summary;
    summary.minEss = 1e300;
    for (size_t i = 0; i < space.Size(); ++i) {
        summary.parameters.push_back(
            SummaryOf(space[i], chains.NaturalCoordinate(space, Eigen::Index(i)), mode[Eigen::Index(i)]));
        const ParameterSummary& s = summary.parameters.back();
        summary.maxRhat = std::max(summary.maxRhat, std::isfinite(s.rhat) ? s.rhat : 1e300);
        for (const double ess : {s.bulkEss, s.tailEss})
            summary.minEss = std::min(summary.minEss, std::isfinite(ess) ? ess : 0);
    }
    const Matrix draws = chains.Natural(space);
    AddProducts(space, draws, &summary.products);
    const Matrix covariance = CovarianceOfColumns(draws);
    const Vector sds = covariance.diagonal().cwiseSqrt().cwiseMax(1e-300);
    summary.correlations = sds.cwiseInverse().asDiagonal() * covariance * sds.cwiseInverse().asDiagonal();
    return summary;
}

PredictiveSummary PredictAndCheck(const PhotoSimulator& simulator, const PhotoSimulator* heldOut,
                                  const PlanarImage& observed, const Matrix& draws, int numDraws,
                                  uint64_t seed, Observer* observer) {
    const Matrix some = ThinnedColumns(draws, numDraws);
    Matrix logits(some.rows(), some.cols());
    for (Eigen::Index i = 0; i < some.cols(); ++i)
        logits.col(i) = simulator.Parameters().ToLogit(some.col(i));
    PredictiveSummary result;
    result.summaries = RunSimulator(simulator, logits, seed, nullptr, observer).summaries;
    const Vector ofObserved = simulator.SummariesOf(observed);
    AddChecks(simulator, result.summaries, ofObserved, false, &result.checks);
    if (heldOut)
        AddChecks(*heldOut, RunSimulator(*heldOut, logits, seed, nullptr, observer).summaries,
                  heldOut->SummariesOf(observed), true, &result.checks);
    const Vector mean = result.summaries.colwise().mean();
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
        const double sd = std::sqrt((result.summaries.col(i).array() - mean[i]).square().sum() /
                                    double(result.summaries.rows() - 1));
        result.residuals.push_back(
            {simulator.SummaryNames()[size_t(i)], (ofObserved[i] - mean[i]) / std::max(sd, 1e-12)});
    }
    return result;
}

}  // namespace lacquer::cmd
