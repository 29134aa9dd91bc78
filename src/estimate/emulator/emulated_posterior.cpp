#include "estimate/emulator/emulated_posterior.h"

#include <algorithm>
#include <cmath>

#include "estimate/diagnostics/convergence.h"
#include "estimate/infer/product_target.h"
#include "estimate/random.h"
#include "pbrt/core/parallel.h"

namespace lacquer::estimate {

namespace {

/// What random numbers are drawn for.
enum Purpose : uint64_t { PriorDraws, PriorSeeds, Starts, WaveDesign, WaveSeeds, Walks };

/// Logits beyond this are at a bound for all purposes.
constexpr double kMaxLogit = 9;

Matrix PriorLogits(const ParameterSpace& space, Eigen::Index count, uint64_t seed, uint64_t purpose) {
    Matrix logits(Eigen::Index(space.Size()), count);
    for (Eigen::Index i = 0; i < count; ++i) {
        Random random(seed, purpose, uint64_t(i));
        logits.col(i) = space.ToLogit(space.SamplePrior(random));
    }
    return logits;
}

/// Starts of walks on wave 0's emulator: draws of the prior, resampled by a power of their likelihood that
/// leaves them over-dispersed.
Matrix StartsFromPrior(const ParameterSpace& space, const EmulatedTarget& target,
                       const EmulationOptions& options) {
    constexpr Eigen::Index kCandidates = 4000;
    constexpr double kPower = 0.1;
    const Matrix candidates = PriorLogits(space, kCandidates, options.seed, Starts);
    Vector weights(kCandidates);
    ParallelFor(kCandidates, [&](int64_t i) {
        weights[i] = kPower * target.Emulator().LogLikelihood(candidates.col(i), target.Projected());
    });
    weights = (weights.array() - weights.maxCoeff()).exp().matrix();
    weights /= weights.sum();
    // Systematic resampling.
    Random random(options.seed, Starts, kCandidates);
    const double offset = random.Uniform();
    Matrix starts(candidates.rows(), options.numWalks);
    double sum = 0;
    for (Eigen::Index i = 0, walk = 0; i < kCandidates && walk < options.numWalks; ++i) {
        sum += weights[i];
        for (; walk < options.numWalks && (double(walk) + offset) / double(options.numWalks) < sum; ++walk)
            starts.col(walk) = candidates.col(i) + 1e-3 * random.Normals(candidates.rows());
    }
    return starts;
}

/// Where a wave simulates: draws of the posterior, widened about their mean, and a quarter of its covariance
/// as jitter.
Matrix Design(const PopulationDraws& draws, const EmulationOptions::Wave& wave, uint64_t seed,
              uint64_t number) {
    const Vector mean = draws.y.rowwise().mean();
    Matrix covariance = CovarianceOfColumns(draws.y);
    covariance.diagonal().array() += 1e-4;
    const Matrix jitter = 0.5 * CholeskyFactor(covariance);
    Matrix design(draws.y.rows(), wave.runs);
    for (Eigen::Index i = 0; i < wave.runs; ++i) {
        Random random(seed, WaveDesign, number, uint64_t(i));
        const Vector draw = draws.y.col(Eigen::Index(random.Index(size_t(draws.y.cols()))));
        design.col(i) =
            (mean + std::sqrt(wave.widening) * (draw - mean) + jitter * random.Normals(mean.size()))
                .cwiseMax(-kMaxLogit)
                .cwiseMin(kMaxLogit);
    }
    return design;
}

/// Of all runs those that lie where `design` does: no farther from its centre than nearly all of it.
Runs RunsInRegion(const Runs& all, const Matrix& design) {
    const Vector mean = design.rowwise().mean();
    const Matrix root = CholeskyFactor(CovarianceOfColumns(design));
    const auto distance = [&](const Vector& y) {
        return root.triangularView<Eigen::Lower>().solve(y - mean).squaredNorm();
    };
    std::vector<double> distances;
    for (Eigen::Index i = 0; i < design.cols(); ++i) distances.push_back(distance(design.col(i)));
    const auto nearlyAll = distances.begin() + std::ptrdiff_t(0.95 * double(distances.size()));
    std::nth_element(distances.begin(), nearlyAll, distances.end());
    std::vector<Eigen::Index> inside;
    // The design's own runs are the last ones; all of them are kept.
    for (Eigen::Index i = 0; i < all.Count(); ++i)
        if (i >= all.Count() - design.cols() || distance(all.parameters.col(i)) <= *nearlyAll)
            inside.push_back(i);
    return all.Select(inside);
}

PopulationDraws WalkOn(const ParameterSpace& space, const Target& ofLogits, const Matrix& starts,
                       const EmulationOptions& options, uint64_t number, double* acceptance) {
    const ProductTarget target(space, ofLogits);
    const PopulationWalk walk({.seed = Hash(options.seed, Walks, number)});
    PopulationState state = walk.Start(target, target.FromLogits(starts));
    walk.Warmup(target, &state);
    PopulationDraws draws = walk.Sample(target, options.walkSteps, &state);
    *acceptance = state.acceptance;
    draws.y = target.ToLogits(draws.y);
    return draws;
}

/// Positions of the walks, one draw for each, at evenly spaced steps.
Matrix StartsFrom(const PopulationDraws& draws, Eigen::Index count) {
    Matrix starts(draws.y.rows(), count);
    for (Eigen::Index i = 0; i < count; ++i)
        starts.col(i) = draws.y.col((2 * i + 1) * draws.y.cols() / (2 * count));
    return starts;
}

double LargestShift(const Matrix& before, const Matrix& after) {
    const Vector sds = CovarianceOfColumns(after).diagonal().cwiseSqrt();
    return (after.rowwise().mean() - before.rowwise().mean()).cwiseQuotient(sds).cwiseAbs().maxCoeff();
}

double MaxRhat(const PopulationDraws& draws) {
    double most = 0;
    for (Eigen::Index i = 0; i < draws.y.rows(); ++i) most = std::max(most, SplitRhat(draws.Coordinate(i)));
    return most;
}

WaveReport ReportOf(const EmulatedTarget& target, const PopulationDraws& draws, Eigen::Index numRuns,
                    double shift, double acceptance) {
    const Vector mean = draws.y.rowwise().mean();
    return {.runs = numRuns,
            .shift = shift,
            .misfit = target.Emulator().Misfit(mean, target.Projected()) / double(target.Projected().size()),
            .acceptance = acceptance,
            .maxRhat = MaxRhat(draws)};
}

/// Photographs are not samples of the model: a misfit that is too large widens the posterior.
void Inflate(const ParameterSpace& space, const Vector& observed, const EmulationOptions& options,
             EmulatedPosterior* posterior) {
    const auto count = double(posterior->target->Projected().size());
    const double misfit = posterior->waves.back().misfit, free = count - double(space.Size());
    if (!(misfit > options.maxMisfit) || free < 1) return;
    posterior->tau = std::sqrt(misfit * count / free);
    posterior->target = std::make_shared<EmulatedTarget>(space, posterior->target->SharedEmulator(), observed,
                                                         posterior->tau * posterior->tau);
    double acceptance = 0;
    posterior->draws = WalkOn(space, *posterior->target, StartsFrom(posterior->draws, options.numWalks),
                              options, posterior->waves.size(), &acceptance);
    posterior->waves.back().acceptance = acceptance;
    posterior->waves.back().maxRhat = MaxRhat(posterior->draws);
}

}  // namespace

double EmulatedTarget::LogDensity(const Vector& y, Vector* gradient) const {
    // A parameter at its bound is there: the prior falls off beyond, and polynomials must not be asked.
    if (!(y.cwiseAbs().maxCoeff() < 2 * kMaxLogit)) return -std::numeric_limits<double>::infinity();
    Vector ofPrior;
    double value = space_.LogPriorOfLogit(y, gradient ? &ofPrior : nullptr);
    value += emulator_->LogLikelihood(y, projected_, gradient, inflation_);
    if (gradient) *gradient += ofPrior;
    return value;
}

Runs RunPrior(const Simulator& simulator, const EmulationOptions& options, RunLog* log, Observer* observer) {
    const Matrix logits = PriorLogits(simulator.Parameters(), options.priorRuns, options.seed, PriorDraws);
    return RunSimulator(simulator, logits, Hash(options.seed, uint64_t(PriorSeeds)), log, observer);
}

EmulatedPosterior EmulatePosterior(const Simulator& simulator, const Vector& observed, const Runs& priorRuns,
                                   const EmulationOptions& options, RunLog* log, Observer* observer) {
    const ParameterSpace& space = simulator.Parameters();
    EmulatedPosterior posterior;
    posterior.numRuns = priorRuns.Count();
    const auto targetFrom = [&](const Runs& runs, int degree) {
        SummaryEmulator::Options emulator = options.emulator;
        emulator.degree = degree;
        return std::make_shared<EmulatedTarget>(
            space, std::make_shared<SummaryEmulator>(runs.parameters, runs.summaries, emulator), observed);
    };
    const auto degreeFor = [&](Eigen::Index runs, int most) {
        const auto size = Eigen::Index(space.Size());
        while (most > 1 && runs < 3 * SummaryEmulator::NumTerms(size, most)) --most;
        return most;
    };
    // Walks by which wave `number` is designed.
    const auto walkFor = [&](int number, const Matrix& starts, double* acceptance) {
        const double temperature =
            options.waves[std::min(size_t(number), options.waves.size()) - 1].temperature;
        const EmulatedTarget tempered(space, posterior.target->SharedEmulator(), observed, temperature);
        return WalkOn(space, tempered, starts, options, uint64_t(number - 1), acceptance);
    };
    double acceptance = 0;
    posterior.target = targetFrom(priorRuns, degreeFor(priorRuns.Count(), space.Size() <= 5 ? 3 : 2));
    posterior.draws = walkFor(1, StartsFromPrior(space, *posterior.target, options), &acceptance);
    posterior.waves.push_back(ReportOf(*posterior.target, posterior.draws, priorRuns.Count(), 0, acceptance));
    Runs all = priorRuns;
    for (int number = 1; number <= options.maxWaves && !posterior.hasConverged; ++number) {
        const auto& wave = options.waves[std::min(size_t(number), options.waves.size()) - 1];
        const Matrix design = Design(posterior.draws, wave, options.seed, uint64_t(number));
        all.Append(RunSimulator(simulator, design, Hash(options.seed, WaveSeeds, number), log, observer));
        posterior.numRuns += wave.runs;
        const Runs region = RunsInRegion(all, design);
        posterior.target = targetFrom(region, degreeFor(region.Count(), options.emulator.degree));
        const Matrix before = posterior.draws.y;
        posterior.draws = walkFor(number + 1, StartsFrom(posterior.draws, options.numWalks), &acceptance);
        const double shift = LargestShift(before, posterior.draws.y);
        posterior.waves.push_back(
            ReportOf(*posterior.target, posterior.draws, region.Count(), shift, acceptance));
        posterior.hasConverged = size_t(number) >= options.waves.size() && shift < options.tolerance;
    }
    Inflate(space, observed, options, &posterior);
    return posterior;
}

}  // namespace lacquer::estimate
