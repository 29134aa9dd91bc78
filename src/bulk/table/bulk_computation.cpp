#include "bulk/table/bulk_computation.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "bulk/ensembles/structure.h"
#include "bulk/table/bulk_problem.h"
#include "pbrt/core/check.h"
#include "pbrt/core/error.h"

namespace lacquer::bulk {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kTasksPerThread = 4;

}  // namespace

BulkComputation::BulkComputation(BulkSettings settings)
    : EnsembleComputation(std::move(settings), kTasksPerThread) {
    numAngles_ = NumAnglesOf(Settings(), GetEnsemble());
    const std::vector<double> thetas = EvenAngles(numAngles_ - 1);
    for (const double wavelength : Settings().wavelengths) {
        sums_.emplace_back(numAngles_);
        if (Settings().method == BulkMethod::Clusters)
            harmonics_.emplace_back(DegreesAt(Settings(), GetEnsemble(), wavelength).farField, thetas);
    }
}

std::unique_ptr<Solution> BulkComputation::Solve(std::vector<Sphere> spheres,
                                                 const RealizationSettings& settings, size_t wavelength,
                                                 Observer* observer) const {
    auto solved = std::make_unique<SolvedRealization>(
        SolveRealization(std::move(spheres), settings, harmonics_[wavelength]));
    if (observer) observer->Advance(1);
    return solved;
}

void BulkComputation::Add(const Solution& solution, size_t wavelength) {
    sums_[wavelength].Add(static_cast<const SolvedRealization&>(solution).scattering);
}

ConvergencePoint BulkComputation::MeansAt(size_t wavelength) const {
    const ScatteringAverage average = AverageAt(wavelength);
    return {NumRealizations(), average.extinction, average.scattering, average.g};
}

// For each particle: integrals over the distributions of radii of all species by their shares in the number.
ScatteringAverage BulkComputation::WithoutClusters(size_t wavelength, BulkMethod method) const {
    LACQUER_CHECK(method != BulkMethod::Clusters);
    const double k = Wavenumber(wavelength);
    double cubes = 0;
    ScatteringAverage average;
    average.intensity.assign(size_t(numAngles_), 0.);
    average.intensityError = average.intensity;
    for (size_t s = 0; s < Settings().indices.size(); ++s) {
        const Species& species = Settings().ensemble.species[s];
        const Complex m = Settings().indices[s].At(Settings().wavelengths[wavelength]) / Settings().hostIndex;
        cubes += GetEnsemble().NumberShare(int(s)) * species.radius.Moment(3);
        for (const RadiusDistribution::Node& node : species.radius.Nodes()) {
            const double x = k * node.radius, share = GetEnsemble().NumberShare(int(s)) * node.weight;
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
    const double fraction = VolumeFractionOf(Settings().ensemble);
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
    if (Settings().method == BulkMethod::Clusters)
        total = AverageAt(wavelength, AverageMode::Aggregate).scattering.mean;
    if (average.scattering.mean > kRounding * total) return;
    throw SceneError(
        {}, fmt::format("the average \"{}\" of {} realisations leaves no scattering at {:g} nm; "
                        "expected more realisations, and some that differ",
                        ModeName(Settings().mode), NumRealizations(), Settings().wavelengths[wavelength]));
}

BulkTable BulkComputation::Table() const {
    BulkTable table;
    switch (Settings().method) {
        case BulkMethod::Independent:
            table.mode = "independent";
            break;
        case BulkMethod::Structure:
            table.mode = "structure";
            break;
        case BulkMethod::Clusters:
            table.mode = ModeName(Settings().mode);
    }
    table.hostIndex = Settings().hostIndex;
    table.wavelengths = Settings().wavelengths;
    for (int i = 0; i < numAngles_; ++i) table.angles.push_back(i * 180. / (numAngles_ - 1));
    for (size_t w = 0; w < table.wavelengths.size(); ++w) {
        const bool hasClusters = Settings().method == BulkMethod::Clusters;
        const ScatteringAverage average = hasClusters ? AverageAt(w) : WithoutClusters(w, Settings().method);
        RequireScattering(average, w);
        const double perMillimetre = CoefficientOfUnit(Settings(), GetEnsemble(), table.wavelengths[w]);
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
        if (Settings().mode == AverageMode::Chapter) continue;
        std::vector<double> mueller;
        for (const auto& elements : average.mueller)
            mueller.insert(mueller.end(), elements.begin(), elements.end());
        table.mueller.push_back(std::move(mueller));
    }
    return table;
}

}  // namespace lacquer::bulk
