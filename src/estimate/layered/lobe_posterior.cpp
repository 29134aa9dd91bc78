#include "estimate/layered/lobe_posterior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimate/infer/product_target.h"
#include "pbrt/core/parallel.h"

namespace lacquer::estimate {

namespace {

/// Seeds of what a posterior needs.
enum Purpose : uint64_t { PriorDraws = 11, PriorSeeds, WaveSeeds, Designs, Starts, Walks };

Matrix EvenlySpaced(const Matrix& columns, Eigen::Index count) {
    Matrix some(columns.rows(), count);
    for (Eigen::Index i = 0; i < count; ++i)
        some.col(i) = columns.col((2 * i + 1) * columns.cols() / (2 * count));
    return some;
}

/// The work of FindLobePosterior(), wave by wave.
class LobeWaves {
  public:
    LobeWaves(const Simulator& simulator, const ParameterSpace& space, const LobeCoordinates& coordinates,
              const ObservedLobes& observed, const Runs& priorRuns, const LobeOptions& options, RunLog* log,
              Observer* observer)
        : simulator_(simulator),
          space_(space),
          coordinates_(coordinates),
          observed_(observed),
          options_(options),
          log_(log),
          observer_(observer),
          all_(priorRuns) {}

    LobePosterior Run() {
        Emulate(all_, all_.parameters);
        Walk(0, PriorStarts());
        Report(all_.Count(), 0, 0);
        for (int number = 1; number <= options_.maxWaves && !posterior_.hasConverged; ++number)
            RunWave(number);
        Refine();
        posterior_.numRuns = all_.Count();
        return std::move(posterior_);
    }

  private:
    Matrix PointsOf(const Matrix& logits) const {
        Matrix points(coordinates_.Size(), logits.cols());
        for (Eigen::Index i = 0; i < logits.cols(); ++i)
            points.col(i) = coordinates_.FromNatural(simulator_.Parameters().ToNatural(logits.col(i)));
        return points;
    }

    /// @param judged  logits without noise: where the emulator's error is looked at
    void Emulate(const Runs& runs, const Matrix& judged) {
        const Matrix points = PointsOf(runs.parameters);
        const LobeRuns logs = LogsOf(runs, observed_.floor);
        emulator_ = std::make_shared<LobeEmulator>(
            points, logs.values, logs.errors, LobeEmulator::Options{.errsTogether = options_.errsTogether});
        region_ = SimulatedRegion(points);
        Judge(judged);
    }

    /// The emulator's error is what it is on average over these points.
    void Judge(const Matrix& judged) {
        constexpr Eigen::Index kJudged = 40;
        const Matrix places = PointsOf(EvenlySpaced(judged, std::min(kJudged, judged.cols())));
        variances_ = Vector::Zero(emulator_->NumComponents());
        for (Eigen::Index i = 0; i < places.cols(); ++i)
            variances_ += emulator_->Variances(places.col(i)) / double(places.cols());
        posterior_.target =
            std::make_shared<LobeTarget>(space_, coordinates_, emulator_, variances_, observed_, region_,
                                         options_.isRobust, options_.errorScale);
    }

    /// The last posterior is narrower than the one before, by which the error was judged: simulations are
    /// denser in its middle.
    void Refine() {
        Judge(WithoutNoise(posterior_.draws.y));
        Walk(options_.maxWaves + 1, EvenlySpaced(posterior_.draws.y, options_.numWalks));
    }

    /// Of many draws of the prior the best quarter.
    Matrix PriorStarts() const {
        const Eigen::Index count = 4 * options_.numWalks;
        Matrix draws(Eigen::Index(space_.Size()), count);
        std::vector<std::pair<double, Eigen::Index>> order;
        for (Eigen::Index i = 0; i < count; ++i) {
            Random random(options_.seed, uint64_t(Starts), i);
            draws.col(i) = space_.ToLogit(space_.SamplePrior(random));
            order.emplace_back(-posterior_.target->LogDensity(draws.col(i), nullptr), i);
        }
        std::sort(order.begin(), order.end());
        Matrix starts(draws.rows(), options_.numWalks);
        for (Eigen::Index i = 0; i < starts.cols(); ++i) starts.col(i) = draws.col(order[size_t(i)].second);
        return starts;
    }

    void Walk(int number, const Matrix& starts) {
        const ProductTarget target(space_, *posterior_.target);
        const uint64_t numSteps = options_.walkSteps + space_.Size() * options_.walkStepsPerParameter;
        constexpr int kWindows = 6;
        const PopulationWalk walk({.seed = Hash(options_.seed, uint64_t(Walks), number),
                                   .windowSteps = (numSteps + kWindows - 1) / kWindows,
                                   .numWindows = kWindows});
        PopulationState state = walk.Start(target, target.FromLogits(starts));
        walk.Warmup(target, &state);
        posterior_.draws = walk.Sample(target, numSteps, &state);
        posterior_.draws.y = target.ToLogits(posterior_.draws.y);
        acceptance_ = state.acceptance;
    }

    /// Covariance of logits with which one simulation would tell them if it were the observation and its
    /// errors were `leastWidth` times as large, beside the prior: what nothing tells is no wider than that.
    Matrix LeastCovariance(const Vector& mean) const {
        constexpr double kStep = 1e-3, kPriorDeviation = 1.8;  // of the logit of a uniform number
        const Eigen::Index d = mean.size();
        Matrix slopes(emulator_->NumComponents(), d);
        for (Eigen::Index i = 0; i < d; ++i) {
            Matrix both = mean.replicate(1, 2);
            both(i, 0) -= kStep;
            both(i, 1) += kStep;
            const Matrix points = PointsOf(both);
            slopes.col(i) = (emulator_->Coefficients(points.col(1), nullptr) -
                             emulator_->Coefficients(points.col(0), nullptr)) /
                            (2 * kStep);
        }
        const Vector weights = emulator_->NoiseVariances().cwiseMax(1e-12).cwiseInverse();
        const Matrix information =
            slopes.transpose() * weights.asDiagonal() * slopes / (options_.leastWidth * options_.leastWidth) +
            Matrix::Identity(d, d) / (kPriorDeviation * kPriorDeviation);
        return information.ldlt().solve(Matrix::Identity(d, d));
    }

    /// Draws of the posterior, farther from its mean, with some noise of their own.
    Matrix Design(int number) const {
        constexpr double kWidening = 1.4, kJitter = 0.5, kMaxLogit = 12;
        const Matrix y = WithoutNoise(posterior_.draws.y);
        const Eigen::Index count =
            options_.waveRuns + options_.waveRunsPerParameter * Eigen::Index(simulator_.Parameters().Size());
        const Vector mean = y.rowwise().mean();
        Matrix jitter = kJitter * kJitter * CovarianceOfColumns(y);
        if (options_.leastWidth > 0) jitter += LeastCovariance(mean);
        const Matrix factor = CholeskyFactor(jitter);
        Matrix design = EvenlySpaced(y, count);
        for (Eigen::Index i = 0; i < count; ++i) {
            Random random(options_.seed, uint64_t(Designs), number, i);
            design.col(i) = mean + kWidening * (design.col(i) - mean) + factor * random.Normals(y.rows());
        }
        return design.cwiseMax(-kMaxLogit).cwiseMin(kMaxLogit);
    }

    /// Earlier runs where those of the design are, the nearest ones if there are many.
    Runs RunsNear(const Matrix& design) const {
        constexpr double kFarther = 1.3;
        const SimulatedRegion region(PointsOf(design));
        const Matrix points = PointsOf(all_.parameters);
        std::vector<std::pair<double, Eigen::Index>> order;
        const Eigen::Index firstOwn = all_.Count() - design.cols();
        for (Eigen::Index i = 0; i < all_.Count(); ++i) {
            const double distance = i < firstOwn ? region.SquaredDistance(points.col(i)) : 0;
            if (distance <= kFarther * region.SquaredRadius()) order.emplace_back(distance, i);
        }
        std::sort(order.begin(), order.end());
        order.resize(std::min(order.size(), size_t(std::max(options_.maxEmulatorRuns, design.cols()))));
        std::vector<Eigen::Index> indices;
        for (const auto& [distance, index] : order) indices.push_back(index);
        std::sort(indices.begin(), indices.end());
        return all_.Select(indices);
    }

    void RunWave(int number) {
        const Matrix design = Design(number);
        all_.Append(RunSimulator(simulator_, design, Hash(options_.seed, uint64_t(WaveSeeds), number), log_,
                                 observer_));
        const Runs region = RunsNear(design);
        const Matrix before = posterior_.draws.y;
        const double shareBefore = posterior_.waves.back().errorShare;
        Emulate(region, WithoutNoise(before));
        Walk(number, EvenlySpaced(before, options_.numWalks));
        const Vector sds = CovarianceOfColumns(posterior_.draws.y).diagonal().cwiseSqrt();
        const double shift = (posterior_.draws.y.rowwise().mean() - before.rowwise().mean())
                                 .cwiseQuotient(sds)
                                 .cwiseAbs()
                                 .maxCoeff();
        Report(region.Count(), shift, shareBefore);
        posterior_.hasConverged = number >= options_.minWaves && shift < posterior_.waves.back().allowedShift;
    }

    /// By the component whose coefficient the emulator knows least, compared with what the noise hides.
    double ErrorShare(double noise) const {
        const Matrix& components = posterior_.target->Emulator().Components();
        double most = 0;
        for (Eigen::Index k = 0; k < components.cols(); ++k) {
            const double ofNoise = noise * noise / components.col(k).squaredNorm();
            most = std::max(most, variances_[k] / (variances_[k] + ofNoise));
        }
        return most;
    }

    void Report(Eigen::Index numRuns, double shift, double shareBefore) {
        const Vector mean = space_.ToNatural(posterior_.draws.y.rowwise().mean());
        const double share = ErrorShare(mean[mean.size() - 1]);
        posterior_.waves.push_back({.runs = numRuns,
                                    .shift = shift,
                                    .allowedShift = options_.tolerance + std::sqrt(share + shareBefore),
                                    .errorShare = share,
                                    .misfit = posterior_.target->Misfit(mean),
                                    .acceptance = acceptance_,
                                    .maxRhat = MaxRhat(posterior_.draws)});
    }

    const Simulator& simulator_;
    const ParameterSpace& space_;
    const LobeCoordinates& coordinates_;
    const ObservedLobes& observed_;
    const LobeOptions& options_;
    RunLog* log_;
    Observer* observer_;
    Runs all_;
    LobePosterior posterior_;
    std::shared_ptr<const LobeEmulator> emulator_;
    SimulatedRegion region_;
    Vector variances_;
    double acceptance_ = 0;
};

}  // namespace

Runs RunLobePrior(const Simulator& simulator, const LobeOptions& options, RunLog* log, Observer* observer) {
    const ParameterSpace& space = simulator.Parameters();
    Matrix logits(Eigen::Index(space.Size()),
                  options.priorRuns + options.priorRunsPerParameter * Eigen::Index(space.Size()));
    for (Eigen::Index i = 0; i < logits.cols(); ++i) {
        Random random(options.seed, uint64_t(PriorDraws), i);
        logits.col(i) = space.ToLogit(space.SamplePrior(random));
    }
    return RunSimulator(simulator, logits, Hash(options.seed, uint64_t(PriorSeeds)), log, observer);
}

LobePosterior FindLobePosterior(const Simulator& simulator, const ParameterSpace& space,
                                const LobeCoordinates& coordinates, const ObservedLobes& observed,
                                const Runs& priorRuns, const LobeOptions& options, RunLog* log,
                                Observer* observer) {
    return LobeWaves(simulator, space, coordinates, observed, priorRuns, options, log, observer).Run();
}

}  // namespace lacquer::estimate
