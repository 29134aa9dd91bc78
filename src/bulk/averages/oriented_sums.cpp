#include "bulk/averages/oriented_sums.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::bulk {

namespace {

/// Steps for each one of the grid, so that intensities of twice the degree are sampled.
int RefinementFor(int steps, int degree) { return (2 * degree + steps - 1) / steps; }

/// Shares of fine nodes in the linear functions of coarse ones, rows adding up to 1.
/// @param nodes  growing, of the fine grid, with the coarse ones at every `refinement`th
Eigen::MatrixXd SharesOf(const std::vector<double>& nodes, int refinement) {
    const auto count = Eigen::Index(nodes.size());
    const auto at = [&](Eigen::Index k) { return nodes[size_t(std::clamp(k, Eigen::Index(0), count - 1))]; };
    Eigen::MatrixXd shares = Eigen::MatrixXd::Zero((count - 1) / refinement + 1, count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const Eigen::Index row = std::min(k / refinement, shares.rows() - 2), low = row * refinement;
        const double width = 0.5 * (at(k + 1) - at(k - 1));
        const double x = (at(k) - at(low)) / (at(low + refinement) - at(low));
        shares(row, k) = (1 - x) * width;
        shares(row + 1, k) = x * width;
    }
    const Eigen::VectorXd sums = shares.rowwise().sum();
    return sums.cwiseInverse().asDiagonal() * shares;
}

std::vector<double> NegativeCosines(std::vector<double> angles) {
    for (double& angle : angles) angle = -std::cos(angle);
    return angles;
}

}  // namespace

OrientedDirections::OrientedDirections(int numIncidences, int numAzimuths, int degree)
    : numAzimuths_(numAzimuths),
      refinement_(RefinementFor(std::min(2 * (numIncidences - 1), numAzimuths - 1), degree)),
      incidences_(EvenAngles(2 * (numIncidences - 1))),
      harmonics_(degree, EvenAngles(2 * (numIncidences - 1) * refinement_)),
      azimuths_(degree, (numAzimuths - 1) * refinement_ + 1),
      angleShares_(SharesOf(NegativeCosines(EvenAngles(harmonics_.NumAngles() - 1)), refinement_)),
      azimuthShares_(SharesOf(EvenAngles(azimuths_.Count() - 1), refinement_)) {
    LACQUER_CHECK(numIncidences >= 2 && numAzimuths >= 2);
    incidences_.resize(size_t(numIncidences));
}

std::vector<double> OrientedDirections::IntensityOf(const OneOriginWaves& waves) const {
    Eigen::MatrixXd fine(numAzimuths_, harmonics_.NumAngles());
    for (int j = 0; j < harmonics_.NumAngles(); ++j)
        fine.col(j) = azimuthShares_ * IntensityAround(waves, harmonics_, j, azimuths_);
    const Eigen::MatrixXd table = fine * angleShares_.transpose();  // azimuths within angles
    return {table.data(), table.data() + table.size()};
}

OrientedRealization SolveOriented(std::vector<Sphere> spheres, const RealizationSettings& settings,
                                  const OrientedDirections& directions, Observer* observer) {
    OrientedRealization result;
    const int degree = directions.Degree();
    result.incidences.resize(size_t(directions.NumIncidences()));
    if (spheres.empty()) {
        for (OrientedRealization::Incidence& found : result.incidences) {
            found.waves = {degree, Eigen::MatrixX2cd::Zero(2 * NumHarmonics(degree), 2)};
            found.intensity = directions.IntensityOf(found.waves);
        }
        return result;
    }
    const Cluster cluster(std::move(spheres), settings.extraDegree);
    const ClusterSolver solver(cluster, settings.memory);
    result.numParticles = cluster.NumSpheres();
    std::vector<HelicityWaves> all;
    for (int i = 0; i < directions.NumIncidences(); ++i) {
        result.wasStopped = observer && observer->ShouldStop();
        if (result.wasStopped) return result;
        OrientedRealization::Incidence& found = result.incidences[size_t(i)];
        ScatteredWaves scattered =
            solver.Solve(IncidentWaves(cluster, {directions.Incidence(i), 0}), settings.solver);
        found.extinction = ExtinctionOfSolved(cluster, scattered).mean();
        found.absorption = AbsorptionOf(cluster, scattered.coefficients).mean();
        result.numProducts += scattered.numProducts;
        result.hasConverged &= scattered.hasConverged;
        all.push_back(std::move(scattered.coefficients));
        if (observer) observer->Advance(1);
    }
    std::vector<OneOriginWaves> waves = AboutOrigin(cluster, all, degree);
    for (size_t i = 0; i < waves.size(); ++i) {
        OrientedRealization::Incidence& found = result.incidences[i];
        found.waves = std::move(waves[i]);
        found.scattering = found.waves.Scattering().mean();
        found.intensity = directions.IntensityOf(found.waves);
        result.energyError =
            std::max(result.energyError, EnergyError(found.extinction, found.absorption, found.scattering));
    }
    result.hasConverged &= result.energyError < kLargestEnergyError;
    return result;
}

OrientedSums::OrientedSums(const OrientedDirections& directions)
    : directions_(&directions), groups_(size_t(kNumGroups), Nothing()) {}

OrientedSums::Sums OrientedSums::Nothing() const {
    Incidence none;
    none.coefficients = Eigen::MatrixX2cd::Zero(2 * NumHarmonics(directions_->Degree()), 2);
    none.intensity.resize(size_t(directions_->NumAngles() * directions_->NumAzimuths()));
    return {0, 0, std::vector<Incidence>(size_t(directions_->NumIncidences()), none)};
}

void OrientedSums::Sums::Add(const Sums& other) {
    count += other.count;
    numParticles += other.numParticles;
    for (size_t i = 0; i < other.incidences.size(); ++i) {
        Incidence& sum = incidences[i];
        const Incidence& more = other.incidences[i];
        sum.extinction += more.extinction;
        sum.absorption += more.absorption;
        sum.scattering += more.scattering;
        sum.asymmetry += more.asymmetry;
        sum.coefficients += more.coefficients;
        for (size_t k = 0; k < more.intensity.size(); ++k) sum.intensity[k] += more.intensity[k];
    }
}

void OrientedSums::Add(const OrientedRealization& realization) {
    LACQUER_CHECK(int(realization.incidences.size()) == directions_->NumIncidences());
    Sums one{1, realization.numParticles, {}};
    for (int i = 0; i < directions_->NumIncidences(); ++i) {
        const OrientedRealization::Incidence& found = realization.incidences[size_t(i)];
        const Direction n{directions_->Incidence(i), 0};
        one.incidences.push_back({found.extinction, found.absorption, found.scattering,
                                  found.waves.Asymmetry(n).mean(), found.waves.coefficients,
                                  found.intensity});
    }
    groups_[size_t(numRealizations_++ % kNumGroups)].Add(one);
}

OrientedAverage OrientedSums::Evaluate(const Sums& sums, AverageMode mode, Part part) const {
    OrientedAverage average;
    // From pairs of different realisations: |sum F|^2 less the sum of |F|^2, over (count - 1), for each.
    const double perPair = mode == AverageMode::Aggregate ? 0 : 1 / (sums.count - 1);
    const double perParticle = sums.numParticles > 0 ? 1 / sums.numParticles : 0;
    for (int i = 0; i < directions_->NumIncidences(); ++i) {
        const Incidence& sum = sums.incidences[size_t(i)];
        const Direction n{directions_->Incidence(i), 0};
        const OneOriginWaves all{directions_->Degree(), sum.coefficients};
        OrientedAverage::Incidence& found = average.incidences.emplace_back();
        const auto ofMode = [&](double total, double ofSum) {
            const double coherent = (ofSum - total) * perPair;
            return perParticle * (mode == AverageMode::Chapter ? coherent : total - coherent);
        };
        found.extinction = sum.extinction * perParticle;
        found.absorption = sum.absorption * perParticle;
        found.scattering = ofMode(sum.scattering, all.Scattering().mean());
        found.asymmetry = ofMode(sum.asymmetry, perPair > 0 ? all.Asymmetry(n).mean() : sum.asymmetry);
        if (part == Part::CrossSections) continue;
        found.intensity = sum.intensity;
        const std::vector<double> ofSum = perPair > 0 ? directions_->IntensityOf(all) : sum.intensity;
        for (size_t k = 0; k < ofSum.size(); ++k) found.intensity[k] = ofMode(sum.intensity[k], ofSum[k]);
    }
    return average;
}

OrientedSums::Sums OrientedSums::SumWithout(int group) const {
    Sums sums = Nothing();
    for (int g = 0; g < kNumGroups; ++g)
        if (g != group) sums.Add(groups_[size_t(g)]);
    return sums;
}

OrientedAverage OrientedSums::Average(AverageMode mode) const {
    LACQUER_CHECK(numRealizations_ >= (mode == AverageMode::Aggregate ? 1 : 2));
    return Evaluate(SumWithout(-1), mode, Part::All);
}

OrientedAverage OrientedSums::CrossSections(AverageMode mode) const {
    LACQUER_CHECK(numRealizations_ >= (mode == AverageMode::Aggregate ? 1 : 2));
    return Evaluate(SumWithout(-1), mode, Part::CrossSections);
}

std::vector<OrientedAverage> OrientedSums::EvaluateWithoutGroups(AverageMode mode, Part part) const {
    std::vector<OrientedAverage> averages;
    if (numRealizations_ >= kNumGroups + 2)
        for (int g = 0; g < kNumGroups; ++g) averages.push_back(Evaluate(SumWithout(g), mode, part));
    return averages;
}

std::vector<OrientedAverage> OrientedSums::AveragesWithoutGroups(AverageMode mode) const {
    return EvaluateWithoutGroups(mode, Part::All);
}

std::vector<OrientedAverage> OrientedSums::CrossSectionsWithoutGroups(AverageMode mode) const {
    return EvaluateWithoutGroups(mode, Part::CrossSections);
}

// Of each group its two sums, and for each incidence the four sums, the coefficients and the intensities.
size_t OrientedSums::StateSize() const {
    const size_t coefficients = 2 * 2 * 2 * size_t(NumHarmonics(directions_->Degree()));
    const size_t intensities = size_t(directions_->NumAngles() * directions_->NumAzimuths());
    return groups_.size() * (2 + size_t(directions_->NumIncidences()) * (4 + coefficients + intensities));
}

std::vector<double> OrientedSums::State() const {
    std::vector<double> state;
    state.reserve(StateSize());
    for (const Sums& group : groups_) {
        state.insert(state.end(), {group.count, group.numParticles});
        for (const Incidence& sum : group.incidences) {
            state.insert(state.end(), {sum.extinction, sum.absorption, sum.scattering, sum.asymmetry});
            for (const Complex& c : sum.coefficients.reshaped())
                state.insert(state.end(), {c.real(), c.imag()});
            state.insert(state.end(), sum.intensity.begin(), sum.intensity.end());
        }
    }
    return state;
}

void OrientedSums::SetState(std::span<const double> state) {
    LACQUER_CHECK(state.size() == StateSize());
    const double* at = state.data();
    numRealizations_ = 0;
    for (Sums& group : groups_) {
        group.count = *at++;
        group.numParticles = *at++;
        for (Incidence& sum : group.incidences) {
            for (double* each : {&sum.extinction, &sum.absorption, &sum.scattering, &sum.asymmetry})
                *each = *at++;
            for (Complex& c : sum.coefficients.reshaped()) {
                c = {at[0], at[1]};
                at += 2;
            }
            for (double& value : sum.intensity) value = *at++;
        }
        numRealizations_ += int(group.count);
    }
}

}  // namespace lacquer::bulk
