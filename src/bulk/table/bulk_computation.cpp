#include "bulk/table/bulk_computation.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <numbers>

#include "bulk/ensembles/structure.h"
#include "bulk/table/bulk_problem.h"
#include "pbrt/core/check.h"
#include "pbrt/core/error.h"
#include "pbrt/core/parallel.h"

namespace lacquer::bulk {
namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

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

double BulkComputation::Wavenumber(size_t wavelength) const {
    return WavenumberOf(settings_, settings_.wavelengths[wavelength]);
}

BulkComputation::BulkComputation(BulkSettings settings)
    : settings_(std::move(settings)), ensemble_(settings_.ensemble) {
    LACQUER_CHECK(!settings_.wavelengths.empty() &&
                  settings_.indices.size() == settings_.ensemble.species.size());
    numAngles_ = NumAnglesOf(settings_, ensemble_);
    history_.resize(settings_.wavelengths.size());
    const std::vector<double> thetas = EvenAngles(numAngles_ - 1);
    for (const double wavelength : settings_.wavelengths) {
        sums_.emplace_back(numAngles_);
        if (settings_.method == BulkMethod::Clusters)
            harmonics_.emplace_back(DegreesAt(settings_, ensemble_, wavelength).farField, thetas);
    }
}

// Enough for all threads, and few, so that the work can stop soon and be saved often.
int BulkComputation::BatchSize() const {
    constexpr int kTasksPerThread = 4, kMaxBatch = 8;
    const int numWavelengths = int(settings_.wavelengths.size());
    return std::clamp(kTasksPerThread * MaxThreads() / numWavelengths, 1, kMaxBatch);
}

void BulkComputation::AddRealizations(int count, Observer* observer) {
    LACQUER_CHECK(settings_.method == BulkMethod::Clusters);
    const int batch = BatchSize();
    for (int done = 0; done < count; done += batch) {
        const int size = std::min(batch, count - done);
        if (AddBatch(size, observer) < size) return;
    }
}

int BulkComputation::AddBatch(int size, Observer* observer) {
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
    // In their order, so that none before the last one that was begun is left out.
    std::vector<SolvedRealization> solved(numTasks);
    std::atomic<size_t> numBegun = 0;
    ParallelFor(int64_t(numTasks), [&](int64_t) {
        if (shouldStop()) return;
        const size_t task = numBegun++, r = task / numWavelengths, w = task % numWavelengths;
        solved[task] = SolveRealization(SpheresOf(settings_, particles[r], settings_.wavelengths[w]), each,
                                        harmonics_[w]);
        if (observer) observer->Advance(1);
    });
    const size_t numWhole = numBegun / numWavelengths;
    for (size_t r = 0; r < numWhole; ++r) Add(std::span(solved).subspan(r * numWavelengths, numWavelengths));
    return int(numWhole);
}

void BulkComputation::Add(std::span<const SolvedRealization> ofAllWavelengths) {
    ++numRealizations_;
    constexpr unsigned kPointsPerOctave = 32;
    const auto n = unsigned(numRealizations_);
    const bool isRecorded = n % std::max(1u, std::bit_floor(n) / kPointsPerOctave) == 0;
    for (size_t w = 0; w < ofAllWavelengths.size(); ++w) {
        const SolvedRealization& solved = ofAllWavelengths[w];
        if (solved.hasConverged) {
            worstEnergyError_ = std::max(worstEnergyError_, solved.energyError);
            sums_[w].Add(solved.scattering);
        } else {
            ++numRefused_;
        }
        if (!isRecorded || NumAveraged(w) < NumNeeded()) continue;
        const ScatteringAverage average = AverageAt(w);
        history_[w].push_back({numRealizations_, average.extinction, average.scattering, average.g});
    }
}

// Three numbers, and for each wavelength the sums and the length of its history with the history.
std::vector<double> BulkComputation::State() const {
    std::vector<double> state{double(numRealizations_), double(numRefused_), worstEnergyError_};
    for (size_t w = 0; w < sums_.size(); ++w) {
        const std::vector<double> sums = sums_[w].State();
        state.insert(state.end(), sums.begin(), sums.end());
        state.push_back(double(history_[w].size()));
        for (const ConvergencePoint& p : history_[w])
            state.insert(state.end(), {double(p.numRealizations), p.extinction.mean, p.extinction.error,
                                       p.scattering.mean, p.scattering.error, p.g.mean, p.g.error});
    }
    return state;
}

bool BulkComputation::SetState(std::span<const double> state) {
    constexpr size_t kHead = 3, kPoint = 7;
    // Sizes first.
    size_t size = kHead;
    for (const ScatteringSums& sums : sums_) {
        size += sums.StateSize() + 1;
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
    for (size_t w = 0; w < sums_.size(); ++w) {
        sums_[w].SetState(rest.first(sums_[w].StateSize()));
        rest = rest.subspan(sums_[w].StateSize());
        history_[w].resize(size_t(rest[0]));
        rest = rest.subspan(1);
        for (ConvergencePoint& p : history_[w]) {
            p = {int(rest[0]), {rest[1], rest[2]}, {rest[3], rest[4]}, {rest[5], rest[6]}};
            rest = rest.subspan(kPoint);
        }
    }
    return true;
}

// For each particle: integrals over the distributions of radii of all species by their shares in the number.
ScatteringAverage BulkComputation::WithoutClusters(size_t wavelength, BulkMethod method) const {
    LACQUER_CHECK(method != BulkMethod::Clusters);
    const double k = Wavenumber(wavelength);
    double cubes = 0;
    ScatteringAverage average;
    average.intensity.assign(size_t(numAngles_), 0.);
    average.intensityError = average.intensity;
    for (size_t s = 0; s < settings_.indices.size(); ++s) {
        const Species& species = settings_.ensemble.species[s];
        const Complex m = settings_.indices[s].At(settings_.wavelengths[wavelength]) / settings_.hostIndex;
        cubes += ensemble_.NumberShare(int(s)) * species.radius.Moment(3);
        for (const RadiusDistribution::Node& node : species.radius.Nodes()) {
            const double x = k * node.radius, share = ensemble_.NumberShare(int(s)) * node.weight;
            const MieCoefficients mie = MieOfSphere(x, m, MieDegree(x));
            const MieEfficiencies q = EfficienciesOf(mie, x);
            const double area = kPi * x * x * share;
            average.extinction.mean += area * q.extinction;
            average.absorption.mean += m.imag() == 0 ? 0 : area * q.Absorption();
            for (int i = 0; i < numAngles_; ++i)
                average.intensity[size_t(i)] +=
                    share * AmplitudesAt(mie, std::cos(i * kPi / (numAngles_ - 1))).Intensity();
        }
    }
    const double fraction = VolumeFractionOf(settings_.ensemble);
    // Of mixtures and distributions: as if all had the radius of the mean volume.
    const double diameter = 2 * k * std::cbrt(cubes);
    const std::vector<double> weights = ClenshawCurtisWeights(numAngles_ - 1);
    double cosines = 0;
    for (int i = 0; i < numAngles_; ++i) {
        const double theta = i * kPi / (numAngles_ - 1);
        double& intensity = average.intensity[size_t(i)];
        if (method == BulkMethod::Structure)
            intensity *= PercusYevickStructureFactor(fraction, 2 * std::sin(theta / 2) * diameter);
        const double part = 2 * kPi * weights[size_t(i)] * intensity;
        average.scattering.mean += part;
        cosines += part * std::cos(theta);
    }
    average.g.mean = cosines / average.scattering.mean;
    return average;
}

// Differences of estimates are negative at times, or nothing but rounding where all realisations are alike.
void BulkComputation::RequireScattering(const ScatteringAverage& average, size_t wavelength) const {
    constexpr double kRounding = 1e-12;
    double total = 0;
    if (settings_.method == BulkMethod::Clusters)
        total = AverageAt(wavelength, AverageMode::Aggregate).scattering.mean;
    if (average.scattering.mean > kRounding * total) return;
    throw SceneError(
        {}, fmt::format("the average \"{}\" of {} realisations leaves no scattering at {:g} nm; "
                        "expected more realisations, and some that differ",
                        ModeName(settings_.mode), numRealizations_, settings_.wavelengths[wavelength]));
}

BulkTable BulkComputation::Table() const {
    BulkTable table;
    switch (settings_.method) {
        case BulkMethod::Independent:
            table.mode = "independent";
            break;
        case BulkMethod::Structure:
            table.mode = "structure";
            break;
        case BulkMethod::Clusters:
            table.mode = ModeName(settings_.mode);
    }
    table.hostIndex = settings_.hostIndex;
    table.wavelengths = settings_.wavelengths;
    for (int i = 0; i < numAngles_; ++i) table.angles.push_back(i * 180. / (numAngles_ - 1));
    for (size_t w = 0; w < table.wavelengths.size(); ++w) {
        const bool hasClusters = settings_.method == BulkMethod::Clusters;
        const ScatteringAverage average = hasClusters ? AverageAt(w) : WithoutClusters(w, settings_.method);
        RequireScattering(average, w);
        const double perMillimetre = CoefficientOfUnit(settings_, ensemble_, table.wavelengths[w]);
        table.sigmaS.push_back(average.scattering.mean * perMillimetre);
        table.sigmaA.push_back(average.absorption.mean * perMillimetre);
        table.g.push_back(std::clamp(average.g.mean, -1., 1.));
        std::vector<double> p = average.intensity;
        // Differences of estimates may be negative where there is hardly any light.
        for (double& value : p) value = std::max(0., value);
        const double norm = NormOfPhase(table.angles, p);
        for (double& value : p) value /= norm;
        table.phase.push_back(std::move(p));
        if (!hasClusters) continue;
        table.errorSigmaS.push_back(average.scattering.error * perMillimetre);
        table.errorSigmaA.push_back(average.absorption.error * perMillimetre);
        table.errorPhase.push_back(NormOfPhase(table.angles, average.intensityError) / norm);
        if (settings_.mode == AverageMode::Chapter) continue;
        std::vector<double> mueller;
        for (const auto& elements : average.mueller)
            mueller.insert(mueller.end(), elements.begin(), elements.end());
        table.mueller.push_back(std::move(mueller));
    }
    return table;
}

}  // namespace lacquer::bulk
