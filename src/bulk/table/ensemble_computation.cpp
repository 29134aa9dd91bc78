#include "bulk/table/ensemble_computation.h"

#include <algorithm>
#include <atomic>
#include <bit>

#include "bulk/table/bulk_problem.h"
#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::bulk {

OpticalIndex::OpticalIndex(std::vector<Node> nodes) : nodes_(std::move(nodes)) {
    LACQUER_CHECK(!nodes_.empty());
}

Complex OpticalIndex::At(double wavelength) const {
    if (wavelength <= nodes_.front().wavelength) return nodes_.front().index;
    if (wavelength >= nodes_.back().wavelength) return nodes_.back().index;
    const auto upper = std::upper_bound(nodes_.begin(), nodes_.end(), wavelength,
                                        [](double w, const Node& node) { return w < node.wavelength; });
    const Node &a = *(upper - 1), &b = *upper;
    const double t = (wavelength - a.wavelength) / (b.wavelength - a.wavelength);
    return (1 - t) * a.index + t * b.index;
}

std::vector<Sphere> SpheresOf(const BulkSettings& settings, const std::vector<Particle>& particles,
                              double wavelength) {
    const double k = WavenumberOf(settings, wavelength);
    std::vector<Sphere> spheres;
    for (const Particle& particle : particles) {
        const Complex index = settings.indices[size_t(particle.species)].At(wavelength);
        spheres.push_back(MakeSphere(k * particle.center, k * particle.radius, index / settings.hostIndex));
    }
    return spheres;
}

const char* ModeName(AverageMode mode) {
    if (mode == AverageMode::Aggregate) return "aggregate";
    return mode == AverageMode::Medium ? "medium" : "chapter";
}

EnsembleComputation::EnsembleComputation(BulkSettings settings, int tasksPerThread)
    : settings_(std::move(settings)),
      ensemble_(settings_.ensemble),
      batchSize_(BatchSizeFor(settings_.wavelengths.size(), tasksPerThread)),
      history_(settings_.wavelengths.size()) {
    LACQUER_CHECK(!settings_.wavelengths.empty() &&
                  settings_.indices.size() == settings_.ensemble.species.size());
}

// Enough for all threads, and few, so that the work can stop soon and be saved often.
int EnsembleComputation::BatchSizeFor(size_t numWavelengths, int tasksPerThread) {
    constexpr int kMaxBatch = 8;
    return std::clamp(tasksPerThread * MaxThreads() / int(numWavelengths), 1, kMaxBatch);
}

double EnsembleComputation::Wavenumber(size_t wavelength) const {
    return WavenumberOf(settings_, settings_.wavelengths[wavelength]);
}

void EnsembleComputation::AddRealizations(int count, Observer* observer) {
    LACQUER_CHECK(settings_.method == BulkMethod::Clusters);
    for (int done = 0; done < count; done += batchSize_) {
        const int size = std::min(batchSize_, count - done);
        if (AddBatch(size, observer) < size) return;
    }
}

int EnsembleComputation::AddBatch(int size, Observer* observer) {
    const size_t numWavelengths = settings_.wavelengths.size(), numTasks = size_t(size) * numWavelengths;
    const auto shouldStop = [&] { return observer && observer->ShouldStop(); };
    if (shouldStop()) return 0;
    RealizationSettings each = settings_.realization;
    each.memory /= std::max(size_t(1), std::min(size_t(MaxThreads()), numTasks));
    std::vector<std::vector<Particle>> particles;
    particles.resize(size_t(size));
    ParallelFor(size, [&](int64_t r) {
        particles[size_t(r)] = ensemble_.Realize(settings_.seed, uint64_t(numRealizations_ + r));
    });
    // In their order, so that few of those that were begun are left out.
    std::vector<std::unique_ptr<Solution>> solved(numTasks);
    std::atomic<size_t> numBegun = 0;
    ParallelFor(int64_t(numTasks), [&](int64_t) {
        if (shouldStop()) return;
        const size_t task = numBegun++, r = task / numWavelengths, w = task % numWavelengths;
        solved[task] = Solve(SpheresOf(settings_, particles[r], settings_.wavelengths[w]), each, w, observer);
    });
    const auto missing = std::find(solved.begin(), solved.end(), nullptr);
    const size_t numWhole = size_t(missing - solved.begin()) / numWavelengths;
    for (size_t r = 0; r < numWhole; ++r)
        AddRealization(std::span(solved).subspan(r * numWavelengths, numWavelengths));
    return int(numWhole);
}

void EnsembleComputation::AddRealization(std::span<const std::unique_ptr<Solution>> ofAllWavelengths) {
    ++numRealizations_;
    constexpr unsigned kPointsPerOctave = 32;
    const auto n = unsigned(numRealizations_);
    const bool isRecorded = n % std::max(1u, std::bit_floor(n) / kPointsPerOctave) == 0;
    for (size_t w = 0; w < ofAllWavelengths.size(); ++w) {
        const Solution& solved = *ofAllWavelengths[w];
        if (solved.hasConverged) {
            worstEnergyError_ = std::max(worstEnergyError_, solved.energyError);
            Add(solved, w);
        } else {
            ++numRefused_;
        }
        if (isRecorded && NumAveraged(w) >= NumNeeded()) history_[w].push_back(MeansAt(w));
    }
}

// Three numbers, and for each wavelength the sums and the length of its history with the history.
std::vector<double> EnsembleComputation::State() const {
    std::vector<double> state{double(numRealizations_), double(numRefused_), worstEnergyError_};
    for (size_t w = 0; w < history_.size(); ++w) {
        const std::vector<double> sums = SumsState(w);
        state.insert(state.end(), sums.begin(), sums.end());
        state.push_back(double(history_[w].size()));
        for (const ConvergencePoint& p : history_[w])
            state.insert(state.end(), {double(p.numRealizations), p.extinction.mean, p.extinction.error,
                                       p.scattering.mean, p.scattering.error, p.g.mean, p.g.error});
    }
    return state;
}

bool EnsembleComputation::SetState(std::span<const double> state) {
    constexpr size_t kHead = 3, kPoint = 7;
    // Sizes first.
    size_t size = kHead;
    for (size_t w = 0; w < history_.size(); ++w) {
        size += SumsSize(w) + 1;
        if (size > state.size()) return false;
        const double points = state[size - 1];
        if (!(points >= 0 && points <= double(state.size()))) return false;
        size += kPoint * size_t(points);
    }
    if (size != state.size()) return false;
    numRealizations_ = int(state[0]);
    numRefused_ = int(state[1]);
    worstEnergyError_ = state[2];
    std::span<const double> rest = state.subspan(kHead);
    for (size_t w = 0; w < history_.size(); ++w) {
        SetSums(w, rest.first(SumsSize(w)));
        rest = rest.subspan(SumsSize(w));
        history_[w].resize(size_t(rest[0]));
        rest = rest.subspan(1);
        for (ConvergencePoint& p : history_[w]) {
            p = {int(rest[0]), {rest[1], rest[2]}, {rest[3], rest[4]}, {rest[5], rest[6]}};
            rest = rest.subspan(kPoint);
        }
    }
    return true;
}

}  // namespace lacquer::bulk
