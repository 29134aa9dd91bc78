#include "cmd/bulk/bulk_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "bulk/cluster/coupling.h"
#include "bulk/cluster/far_field.h"
#include "bulk/table/ball_inversion.h"
#include "bulk/table/bulk_computation.h"
#include "bulk/table/bulk_problem.h"
#include "cmd/console.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::cmd {

using namespace bulk;

namespace {

using Clock = std::chrono::steady_clock;

/// Seconds of body(): the least of several runs where they are short, since one of them may have been
/// interrupted.
template <class Body>
double Measure(const Body& body) {
    constexpr double kEnough = 0.02;
    double least = std::numeric_limits<double>::infinity(), sum = 0;
    do {
        const Clock::time_point start = Clock::now();
        body();
        const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
        least = std::min(least, seconds);
        sum += seconds;
    } while (sum < kEnough);
    return least;
}

double PairsOf(double count) { return count * (count - 1) / 2; }

/// Spheres of size x that do not touch, on a cubic lattice about the origin.
std::vector<Sphere> Lattice(int perSide, double x) {
    std::vector<Sphere> spheres;
    const double step = 2.5 * x, middle = 0.5 * (perSide - 1);
    for (int i = 0; i < perSide * perSide * perSide; ++i)
        spheres.push_back(MakeSphere(step * Point(i % perSide - middle, i / perSide % perSide - middle,
                                                  i / (perSide * perSide) - middle),
                                     x, 1.2));
    return spheres;
}

}  // namespace

std::vector<BulkSettings> SettingsOf(const ParticlesInput& input) {
    if (input.sizes.empty()) return {input.settings};
    std::vector<BulkSettings> all;
    for (const int size : input.sizes) {
        all.push_back(input.settings);
        all.back().ensemble.count = size;
        // Independent ones, for their differences.
        all.back().seed = Hash(input.settings.seed, uint64_t(size));
    }
    return all;
}

BulkPlan PlanOf(const BulkSettings& settings, const std::optional<OrientedSettings>& oriented) {
    const Ensemble ensemble(settings.ensemble);
    const double wavelength = settings.wavelengths.front();
    const BulkDegrees degrees = DegreesAt(settings, ensemble, wavelength);
    BulkPlan plan;
    plan.count = settings.ensemble.count;
    plan.ballRadius = ReachOf(ensemble);
    plan.ballSize = plan.ballRadius * WavenumberOf(settings, wavelength);
    plan.degree = degrees.spheres;
    plan.farDegree = degrees.farField;
    plan.oriented = oriented;
    plan.numAngles = oriented ? 2 * oriented->numIncidences - 1 : NumAnglesOf(settings, ensemble);
    plan.unknowns = NumUnknowns(settings);
    plan.memory = MemoryOf(settings, ensemble, MaxThreads());
    if (oriented) plan.memory += MemoryOfOriented(settings, *oriented);
    BulkSettings independent = settings;
    independent.method = BulkMethod::Independent;
    const BulkTable table = BulkComputation(independent).Table();
    constexpr double kMicrometresInMillimetre = 1000;
    for (size_t w = 0; w < table.wavelengths.size(); ++w) {
        const double depth =
            2 * ensemble.BallRadius() * (table.sigmaS[w] + table.sigmaA[w]) / kMicrometresInMillimetre;
        if (depth <= plan.opticalDepth) continue;
        plan.opticalDepth = depth;
        plan.depthWavelength = table.wavelengths[w];
    }
    return plan;
}

namespace {

/// Seconds for the far fields of solutions for light along some directions, beside the spheres' own parts.
/// @param perSphere  of the translation to the origin, for one solution
struct FarFieldTime {
    double once = 0, perSphere = 0;
};
FarFieldTime MeasureFarField(const Cluster& cluster, const Cluster& lone, int farDegree, int numIncidences) {
    // A part of it does not go with the spheres.
    const std::vector<HelicityWaves> waves(size_t(numIncidences), IncidentWaves(cluster, {0, 0})),
        loneWaves(size_t(numIncidences), IncidentWaves(lone, {0, 0}));
    FarFieldTime time;
    const double one = Measure([&] { AboutOrigin(lone, loneWaves, farDegree); });
    const double all = Measure([&] { AboutOrigin(cluster, waves, farDegree); });
    time.perSphere = std::max(0., all - one) / (cluster.NumSpheres() - 1);
    time.once = one - time.perSphere;
    return time;
}

/// Of intensities in all directions of the table, for one incidence.
double MeasureIntensities(const OrientedSettings& oriented, int degree) {
    const OrientedDirections directions(oriented.numIncidences, oriented.numAzimuths, degree);
    const OneOriginWaves waves{degree, Eigen::MatrixX2cd::Ones(2 * NumHarmonics(degree), 2)};
    return Measure([&] { directions.IntensityOf(waves); });
}

}  // namespace

void MeasureTime(const BulkSettings& settings, BulkPlan* plan) {
    // A product of the linear system, and the far field, of eight spheres, whatever their places: the first
    // goes with the pairs, the second with the spheres. Both go with the third power of the degree.
    constexpr int kPerSide = 2, kSpheres = kPerSide * kPerSide * kPerSide, kMaxDegree = 24;
    const Ensemble ensemble(settings.ensemble);
    plan->secondsPerRealization = 0;
    const int numIncidences = plan->oriented ? plan->oriented->numIncidences : 1;
    const std::vector<double>& wavelengths = settings.wavelengths;
    // Of long lists some, for those between them.
    const size_t step = (wavelengths.size() + 2) / 3;
    for (size_t w = 0; w < wavelengths.size(); w += step) {
        const double weight = double(std::min(step, wavelengths.size() - w));
        const BulkDegrees degrees = DegreesAt(settings, ensemble, wavelengths[w]);
        const int degree = std::min(degrees.spheres, kMaxDegree);
        const Cluster cluster = Cluster::WithDegree(Lattice(kPerSide, degree), degree);
        const Coupling coupling(cluster.Centers(), degree, settings.realization.memory);
        const HelicityWaves waves = IncidentWaves(cluster, {0, 0});
        HelicityWaves out(kSpheres, degree);
        coupling.Apply(waves, &out);
        const double product = Measure([&] { coupling.Apply(waves, &out); });
        const FarFieldTime far = MeasureFarField(cluster, Cluster::WithDegree(Lattice(1, degree), degree),
                                                 std::max(degree, degrees.farField), numIncidences);
        plan->secondsPerRealization +=
            weight * std::pow(degrees.spheres / double(degree), 3) *
            (numIncidences * kPlannedProducts * product * PairsOf(plan->count) / PairsOf(kSpheres) +
             (far.once + far.perSphere * plan->count) / MaxThreads());
        if (plan->oriented)
            plan->secondsPerRealization +=
                weight * numIncidences * MeasureIntensities(*plan->oriented, degrees.farField) / MaxThreads();
    }
}

std::string ToText(const BulkPlan& plan, int numRealizations) {
    std::string text = fmt::format(
        "{} particles in a ball of {:.3g} um, kR = {:.3g}{}\n"
        "  degree {} of each, {} of all: {:.3g} unknowns, {}\n"
        "  memory {:.2g} GB\n",
        plan.count, plan.ballRadius, plan.ballSize,
        plan.opticalDepth > 0
            ? fmt::format(", optical depth {:.2g} at {:g} nm", plan.opticalDepth, plan.depthWavelength)
            : "",
        plan.degree, plan.farDegree, plan.unknowns,
        plan.oriented ? fmt::format("{} incidences, {} angles, {} azimuths", plan.oriented->numIncidences,
                                    plan.numAngles, plan.oriented->numAzimuths)
                      : fmt::format("{} angles", plan.numAngles),
        plan.memory / 1e9);
    if (plan.secondsPerRealization > 0)
        text += fmt::format("  about {} products a solution: {} a realisation, {} for {}\n", kPlannedProducts,
                            FormatSeconds(plan.secondsPerRealization),
                            FormatSeconds(numRealizations * plan.secondsPerRealization), numRealizations);
    return text;
}

std::string WarningOfChapter(const std::vector<EnergyBalance>& ofWavelengths) {
    double largest = 0;
    for (const EnergyBalance& c : ofWavelengths)
        largest = std::max(largest, std::abs((c.extinction - c.absorption - c.scattering) / c.extinction));
    return fmt::format(
        "the average \"chapter\" does not conserve energy: C_ext - C_abs and C_sca differ by up "
        "to {:.3g} % of C_ext",
        100 * largest);
}

std::vector<std::string> WarningsOf(const BulkSettings& settings, const BulkPlan& plan) {
    std::vector<std::string> warnings;
    constexpr double kThin = 0.3;
    if (settings.removesMultipleScattering) {
        if (LostShare(plan.opticalDepth) > kLargestLostShare)
            warnings.push_back(
                fmt::format("a ball of {} particles has an optical depth of {:.2g} at {:g} nm, too much to "
                            "tell what is in "
                            "it; expected fewer particles",
                            plan.count, plan.opticalDepth, plan.depthWavelength));
    } else if (settings.mode == AverageMode::Medium && plan.opticalDepth > kThin)
        warnings.push_back(fmt::format(
            "a ball of {} particles has an optical depth of {:.2g} at {:g} nm, and shadows itself: sigma_s "
            "will be too low; expected at most {}. Fewer particles, \"sizes\" to extrapolate, or \"multiple "
            "scattering\": \"removed\"",
            plan.count, plan.opticalDepth, plan.depthWavelength, kThin));
    const double step = std::numbers::pi / (plan.numAngles - 1);
    if (settings.mode != AverageMode::Medium && step * plan.ballSize > 1)
        warnings.push_back(
            fmt::format("kR of {} particles is {:.3g}: the forward peak of the ball is about {:.2g} degrees "
                        "wide, and the angles of the table stand {:.2g} degrees apart",
                        plan.count, plan.ballSize, 180 / std::numbers::pi / plan.ballSize,
                        180 / std::numbers::pi * step));
    constexpr int kAccurateDegree = 80;  // to 1e-7 of a field, between spheres that touch
    if (plan.degree > kAccurateDegree)
        warnings.push_back(fmt::format(
            "waves of degree {} are translated, and those above {} lose digits: realisations whose energy "
            "does not balance will be left out",
            plan.degree, kAccurateDegree));
    return warnings;
}

}  // namespace lacquer::cmd
