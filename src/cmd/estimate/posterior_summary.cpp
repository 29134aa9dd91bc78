#include "cmd/estimate/posterior_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cmd/estimate/report_sentences.h"
#include "estimate/diagnostics/convergence.h"
#include "estimate/diagnostics/sample_moments.h"
#include "estimate/emulator/runs.h"
#include "estimate/infer/population.h"
#include "estimate/output/predictive_check.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

/// Standard deviation of a cut normal distribution, by its quantiles at evenly spaced probabilities.
double SdOf(const Prior& prior) {
    constexpr int kPoints = 2000;
    std::vector<double> values;
    for (int i = 0; i < kPoints; ++i) values.push_back(prior.Quantile((i + 0.5) / kPoints));
    return MomentsOf(values).sd;
}

/// Fills what follows from the chains.
void SummarizeChains(EstimateParameter* p) {
    Matrix byChain{Eigen::Index(p->chains[0].size()), Eigen::Index(p->chains.size())};
    for (size_t c = 0; c < p->chains.size(); ++c)
        byChain.col(Eigen::Index(c)) = Eigen::Map<const Vector>(p->chains[c].data(), byChain.rows());
    std::vector<double> values(byChain.data(), byChain.data() + byChain.size());
    const SampleMoments moments = MomentsOf(values);
    p->mean = moments.mean;
    p->sd = moments.sd;
    std::sort(values.begin(), values.end());
    p->q5 = SortedQuantile(values, 0.05);
    p->q50 = SortedQuantile(values, 0.5);
    p->q95 = SortedQuantile(values, 0.95);
    const Convergence convergence = ConvergenceOf(byChain);
    p->rhat = convergence.rhat;
    p->essBulk = convergence.bulkEss;
    p->essTail = convergence.tailEss;
    if (!p->prior) return;
    const double edge = 0.01 * (p->prior->high - p->prior->low), size = double(values.size());
    const auto below = std::lower_bound(values.begin(), values.end(), p->prior->low + edge);
    const auto above = std::upper_bound(values.begin(), values.end(), p->prior->high - edge);
    p->shareAtLow = double(below - values.begin()) / size;
    p->shareAtHigh = double(values.end() - above) / size;
}

EstimateParameter SummaryOf(const estimate::Parameter& parameter, const Matrix& byChain, double mode) {
    EstimateParameter p;
    p.name = parameter.name;
    p.unit = parameter.unit;
    p.prior = parameter.prior;
    p.priorSd = SdOf(parameter.prior);
    p.map = mode;
    for (Eigen::Index c = 0; c < byChain.cols(); ++c)
        p.chains.emplace_back(byChain.col(c).begin(), byChain.col(c).end());
    SummarizeChains(&p);
    return p;
}

double LogSdOf(const EstimateParameter& p) {
    std::vector<double> logs;
    for (const std::vector<double>& chain : p.chains)
        for (const double v : chain) logs.push_back(std::log(std::max(v, 1e-30)));
    return MomentsOf(logs).sd;
}

EstimateParameter ProductOf(const ParameterSpace& space, const EstimateParameter& first,
                            const EstimateParameter& second, uint64_t seed) {
    constexpr int kPriorDraws = 2000;
    EstimateParameter p;
    p.name = first.name + " x " + second.name;
    p.unit = first.unit;
    p.factors = {first.name, second.name};
    p.chains = first.chains;
    for (size_t c = 0; c < p.chains.size(); ++c)
        for (size_t k = 0; k < p.chains[c].size(); ++k) p.chains[c][k] *= second.chains[c][k];
    SummarizeChains(&p);
    for (int k = 0; k < kPriorDraws; ++k) {
        Random random(seed, k);
        const Vector x = space.SamplePrior(random);
        p.priorDraws.push_back(x[Eigen::Index(*space.Find(first.name))] *
                               x[Eigen::Index(*space.Find(second.name))]);
    }
    p.priorSd = MomentsOf(p.priorDraws).sd;
    return p;
}

/// Light times an albedo or a reflectance, where its logarithm is known at least twice as well as either
/// factor's.
void AddProducts(const ParameterSpace& space, uint64_t seed, std::vector<EstimateParameter>* parameters) {
    const std::optional<size_t> light = space.Find("light");
    if (!light) return;
    for (const char* name : {"r", "g", "b"}) {
        const std::optional<size_t> factor = space.Find(name);
        if (!factor) continue;
        const EstimateParameter &first = (*parameters)[*light], &second = (*parameters)[*factor];
        EstimateParameter product = ProductOf(space, first, second, seed);
        if (2 * LogSdOf(product) <= std::min(LogSdOf(first), LogSdOf(second)))
            parameters->push_back(std::move(product));
    }
}

/// The checks by family, and the residuals of summaries that were used.
void AddChecks(const PhotoSimulator& simulator, const Matrix& simulated, const PlanarImage& image,
               bool isHeldOut, PredictiveSummary* result) {
    const std::vector<PredictiveCheck> checks =
        CheckPredictions(simulator.SummaryNames(), simulated, simulator.SummariesOf(image));
    for (const FamilyRange& range : simulator.FamilyRanges()) {
        EstimateCheck ofFamily{.family = range.name, .isHeldOut = isHeldOut, .names = {}, .shares = {}};
        for (Eigen::Index i = range.first; i < range.first + range.count; ++i) {
            const PredictiveCheck& check = checks[size_t(i)];
            ofFamily.names.push_back(check.summary);
            ofFamily.shares.push_back(check.shareAbove);
            if (!isHeldOut) result->residuals.push_back({check.summary, check.Residual()});
        }
        result->checks.push_back(std::move(ofFamily));
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

bool PosteriorSummary::HasConverged() const { return maxRhat <= kWorstRhat && minEss >= kMinEss; }

PosteriorSummary Summarize(const ParameterSpace& space, const PosteriorChains& chains, const Vector& mode,
                           uint64_t seed) {
    PosteriorSummary summary;
    summary.minEss = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < space.Size(); ++i) {
        summary.parameters.push_back(
            SummaryOf(space[i], chains.NaturalCoordinate(space, Eigen::Index(i)), mode[Eigen::Index(i)]));
        const EstimateParameter& p = summary.parameters.back();
        summary.maxRhat = std::max(summary.maxRhat,
                                   std::isfinite(p.rhat) ? p.rhat : std::numeric_limits<double>::infinity());
        for (const double ess : {p.essBulk, p.essTail})
            summary.minEss = std::min(summary.minEss, std::isfinite(ess) ? ess : 0);
    }
    AddProducts(space, seed, &summary.parameters);
    // Those that a scene has, such as extinction and thickness, are told alone.
    for (size_t i = 0; i < space.Size(); ++i)
        if (const auto scale = space.Find(space[i].productWith); scale && space[*scale].name != "light")
            summary.parameters.push_back(
                ProductOf(space, summary.parameters[i], summary.parameters[*scale], seed));
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
    AddChecks(simulator, result.summaries, observed, false, &result);
    if (heldOut)
        AddChecks(*heldOut, RunSimulator(*heldOut, logits, seed, nullptr, observer).summaries, observed, true,
                  &result);
    return result;
}

}  // namespace lacquer::cmd
