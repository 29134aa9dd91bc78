#include "estimate/emulator/emulated_posterior.h"

#include <algorithm>
#include <cmath>

#include "estimate/emulator/model_check.h"
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
    ParallelFor(kCandidates,
                [&](int64_t i) { weights[i] = kPower * target.LogLikelihood(candidates.col(i)); });
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
/// as jitter, in coordinates in which ridges of products are straight.
Matrix Design(const ParameterSpace& space, const PopulationDraws& found, const EmulationOptions::Wave& wave,
              uint64_t seed, uint64_t number) {
    const ProductCoordinates coordinates(space);
    const Matrix draws = coordinates.FromLogits(found.y);
    const Vector mean = draws.rowwise().mean();
    Matrix covariance = CovarianceOfColumns(draws);
    covariance.diagonal().array() += 1e-4;
    const Matrix jitter = 0.5 * CholeskyFactor(covariance);
    Matrix design(draws.rows(), wave.runs);
    for (Eigen::Index i = 0; i < wave.runs; ++i) {
        Random random(seed, WaveDesign, number, uint64_t(i));
        const Vector draw = draws.col(Eigen::Index(random.Index(size_t(draws.cols()))));
        design.col(i) =
            mean + std::sqrt(wave.widening) * (draw - mean) + jitter * random.Normals(mean.size());
    }
    return coordinates.ToLogits(design).cwiseMax(-kMaxLogit).cwiseMin(kMaxLogit);
}

/// Of all runs those that lie where `design` does: no farther from its centre than nearly all of it.
Runs RunsInRegion(const RegressionCoordinates& coordinates, const Runs& all, const Matrix& design) {
    const Matrix places = coordinates.FromLogits(all.parameters), own = places.rightCols(design.cols());
    const Vector mean = own.rowwise().mean();
    const Matrix root = CholeskyFactor(CovarianceOfColumns(own));
    const auto distance = [&](const Vector& place) {
        return root.triangularView<Eigen::Lower>().solve(place - mean).squaredNorm();
    };
    std::vector<double> distances;
    for (Eigen::Index i = 0; i < own.cols(); ++i) distances.push_back(distance(own.col(i)));
    const auto nearlyAll = distances.begin() + std::ptrdiff_t(0.95 * double(distances.size()));
    std::nth_element(distances.begin(), nearlyAll, distances.end());
    std::vector<Eigen::Index> inside;
    // The design's own runs are the last ones; all of them are kept.
    for (Eigen::Index i = 0; i < all.Count(); ++i)
        if (i >= all.Count() - design.cols() || distance(places.col(i)) <= *nearlyAll) inside.push_back(i);
    return all.Select(inside);
}

PopulationDraws WalkOn(const ParameterSpace& space, const Target& ofLogits, const Matrix& starts,
                       const EmulationOptions& options, uint64_t number, double* acceptance) {
    const ProductTarget target(space, ofLogits);
    const uint64_t numSteps = options.walkSteps + space.Size() * options.walkStepsPerParameter;
    constexpr int kWindows = 5;
    const PopulationWalk walk({.seed = Hash(options.seed, Walks, number),
                               .windowSteps = (numSteps + kWindows - 1) / kWindows,
                               .numWindows = kWindows});
    PopulationState state = walk.Start(target, target.FromLogits(starts));
    walk.Warmup(target, &state);
    PopulationDraws draws = walk.Sample(target, numSteps, &state);
    *acceptance = state.acceptance;
    draws.y = target.ToLogits(draws.y);
    return draws;
}

/// Of the means, in deviations.
double LargestShift(const Matrix& before, const Matrix& after) {
    const Vector sds = CovarianceOfColumns(after).diagonal().cwiseSqrt();
    return (after.rowwise().mean() - before.rowwise().mean()).cwiseQuotient(sds).cwiseAbs().maxCoeff();
}

/// By how much few simulations let the means of a posterior move, in its deviations.
double EmulatorError(const EmulatedTarget& target, const PopulationDraws& draws) {
    const Matrix some = ThinnedColumns(draws.y, 100);
    double sum = 0;
    for (Eigen::Index i = 0; i < some.cols(); ++i) sum += target.Leverage(some.col(i));
    return std::sqrt(sum / double(some.cols()));
}

/// The work of EmulatePosterior(), wave by wave.
class Waves {
  public:
    Waves(const Simulator& simulator, const Vector& observed, const Runs& priorRuns,
          const EmulationOptions& options, RunLog* log, Observer* observer)
        : simulator_(simulator),
          space_(simulator.Parameters()),
          coordinates_(space_),
          observed_(observed),
          options_(options),
          log_(log),
          observer_(observer),
          all_(priorRuns) {}

    EmulatedPosterior Run() {
        Emulate(all_, space_.Size() <= 5 ? 3 : 2);
        Walk(1, StartsFromPrior(space_, *posterior_.target, options_));
        Report(all_.Count(), 0, 0);
        for (int number = 1; number <= options_.maxWaves && !posterior_.hasConverged; ++number)
            RunWave(number);
        posterior_.numRuns = all_.Count();
        Inflate();
        return std::move(posterior_);
    }

  private:
    const EmulationOptions::Wave& WaveOf(int number) const {
        return options_.waves[std::min(size_t(number), options_.waves.size()) - 1];
    }

    void Emulate(const Runs& runs, int maxDegree) {
        SummaryEmulator::Options emulator = options_.emulator;
        emulator.degree = maxDegree;
        while (emulator.degree > 1 &&
               runs.Count() < 3 * SummaryEmulator::NumTerms(Eigen::Index(space_.Size()), emulator.degree))
            --emulator.degree;
        const Matrix points = coordinates_.FromLogits(runs.parameters);
        posterior_.target = std::make_shared<EmulatedTarget>(
            space_, std::make_shared<SummaryEmulator>(points, runs.summaries, emulator), observed_);
        check_ = ModelCheck(points, runs.summaries, emulator.degree);
    }

    /// Draws by which wave `number` is designed.
    void Walk(int number, const Matrix& starts) {
        const EmulatedTarget tempered(space_, posterior_.target->SharedEmulator(), observed_,
                                      WaveOf(number).temperature);
        posterior_.draws = WalkOn(space_, tempered, starts, options_, uint64_t(number - 1), &acceptance_);
    }

    void RunWave(int number) {
        EmulationOptions::Wave wave = WaveOf(number);
        constexpr Eigen::Index kFewParameters = 12;
        wave.runs = wave.runs * std::max(kFewParameters, Eigen::Index(space_.Size())) / kFewParameters;
        const Matrix design = Design(space_, posterior_.draws, wave, options_.seed, uint64_t(number));
        all_.Append(
            RunSimulator(simulator_, design, Hash(options_.seed, WaveSeeds, number), log_, observer_));
        const Runs region = RunsInRegion(coordinates_, all_, design);
        const Matrix before = coordinates_.FromLogits(posterior_.draws.y);
        const double errorBefore = EmulatorError(*posterior_.target, posterior_.draws);
        Emulate(region, options_.emulator.degree);
        Walk(number + 1, ThinnedColumns(posterior_.draws.y, options_.numWalks));
        const double error = std::hypot(errorBefore, EmulatorError(*posterior_.target, posterior_.draws));
        const double shift = LargestShift(before, coordinates_.FromLogits(posterior_.draws.y));
        // Beyond a deviation they have not settled, however little the emulators know.
        Report(region.Count(), shift, std::min(1., std::hypot(options_.tolerance, error)));
        posterior_.hasConverged =
            size_t(number) >= options_.waves.size() && shift < posterior_.waves.back().allowedShift;
    }

    void Report(Eigen::Index numRuns, double shift, double allowedShift) {
        const Matrix some = coordinates_.FromLogits(ThinnedColumns(posterior_.draws.y, 200));
        posterior_.waves.push_back({.runs = numRuns,
                                    .shift = shift,
                                    .allowedShift = allowedShift,
                                    .misfit = check_.Misfit(some, observed_),
                                    .acceptance = acceptance_,
                                    .maxRhat = MaxRhat(posterior_.draws)});
    }

    /// Photographs are not samples of the model: a misfit that is too large widens the posterior.
    void Inflate() {
        const auto count = double(check_.NumSummaries());
        const double misfit = posterior_.waves.back().misfit, free = count - double(space_.Size());
        if (!(misfit > options_.maxMisfit) || free < 1) return;
        posterior_.tau = std::sqrt(misfit * count / free);
        posterior_.target = std::make_shared<EmulatedTarget>(space_, posterior_.target->SharedEmulator(),
                                                             observed_, posterior_.tau * posterior_.tau);
        posterior_.draws =
            WalkOn(space_, *posterior_.target, ThinnedColumns(posterior_.draws.y, options_.numWalks),
                   options_, posterior_.waves.size(), &acceptance_);
        posterior_.waves.back().acceptance = acceptance_;
        posterior_.waves.back().maxRhat = MaxRhat(posterior_.draws);
    }

    const Simulator& simulator_;
    const ParameterSpace& space_;
    const RegressionCoordinates coordinates_;
    const Vector& observed_;
    const EmulationOptions& options_;
    RunLog* log_;
    Observer* observer_;
    Runs all_;
    EmulatedPosterior posterior_;
    ModelCheck check_;
    double acceptance_ = 0;
};

}  // namespace

double EmulatedTarget::LogDensity(const Vector& y, Vector* gradient) const {
    // A parameter at its bound is there: the prior falls off beyond, and polynomials must not be asked.
    if (!(y.cwiseAbs().maxCoeff() < 2 * kMaxLogit)) return -std::numeric_limits<double>::infinity();
    Vector ofPrior;
    double value = space_.LogPriorOfLogit(y, gradient ? &ofPrior : nullptr);
    value += LogLikelihood(y, gradient);
    if (gradient) *gradient += ofPrior;
    return value;
}

double EmulatedTarget::LogLikelihood(const Vector& y, Vector* gradient) const {
    const double value =
        emulator_->LogLikelihood(coordinates_.FromLogits(y), projected_, gradient, inflation_);
    if (gradient) *gradient = coordinates_.GradientByLogits(y, *gradient);
    return value;
}

Runs RunPrior(const Simulator& simulator, const EmulationOptions& options, RunLog* log, Observer* observer) {
    const Matrix logits = PriorLogits(simulator.Parameters(), options.priorRuns, options.seed, PriorDraws);
    return RunSimulator(simulator, logits, Hash(options.seed, uint64_t(PriorSeeds)), log, observer);
}

EmulatedPosterior EmulatePosterior(const Simulator& simulator, const Vector& observed, const Runs& priorRuns,
                                   const EmulationOptions& options, RunLog* log, Observer* observer) {
    return Waves(simulator, observed, priorRuns, options, log, observer).Run();
}

}  // namespace lacquer::estimate
