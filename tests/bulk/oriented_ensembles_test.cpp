// Oriented ensembles: cross sections and scattering for light along given directions, and their tables.
#include <gtest/gtest.h>

#include <atomic>
#include <numbers>

#include "bulk/reference_case.h"
#include "bulk/table/bulk_computation.h"
#include "bulk/table/oriented_computation.h"
#include "pbrt/core/parallel.h"
#include "phases/phase_scenes.h"
#include "support/oriented_tables.h"
#include "support/statistics.h"
#include "support/stopping_observer.h"

namespace lacquer::test::oriented_ensembles_test {
namespace {

using namespace bulk;

using std::numbers::pi;
/// At which a micrometre is a unit of the solver.
constexpr double kUnitWavelength = 2000 * pi;

OrientedDirections DirectionsFor(const std::vector<Sphere>& spheres, int numIncidences, int numAzimuths) {
    return {numIncidences, numAzimuths, FarFieldDegree(Cluster(spheres, 4))};
}
RealizationSettings Precise() { return {.extraDegree = 4, .solver = {.residual = 1e-11}}; }

double LargestRadius(const std::vector<Sphere>& spheres) {
    double largest = 0;
    for (const Sphere& sphere : spheres) largest = std::max(largest, sphere.Radius());
    return largest;
}

// ---- One realisation ----

// By the same degrees. The smaller of mixed spheres have their own here, which changes parts in 10^5.
TEST(OrientedRealization, HasTheKnownCrossSectionsOfFixedOrientations) {
    const std::tuple<const char*, std::vector<int>, double> rows[] = {
        {"bisphere_2r", {0, 45, 90}, 1e-8}, {"cluster5", {0, 60}, 1e-8}, {"cluster6_mixed", {0, 60}, 1e-4}};
    for (const auto& row : rows) {
        const ReferenceCase known = ReferenceCase::Read(std::get<0>(row));
        const OrientedDirections directions = DirectionsFor(known.spheres, 7, 5);
        RealizationSettings settings = Precise();
        const int degree = known.numbers.at("prototype").at("fixed_beta0").at("sphere_degree");
        settings.extraDegree = degree - MieDegree(LargestRadius(known.spheres));
        const double tolerance = std::get<2>(row);
        const OrientedRealization found = SolveOriented(known.spheres, settings, directions);
        EXPECT_TRUE(found.hasConverged);
        EXPECT_LT(found.energyError, 1e-10);
        for (const int beta : std::get<1>(row)) {
            const auto& at = known.numbers.at("prototype").at("fixed_beta" + std::to_string(beta));
            const auto mean = [&](const std::string& what) {
                return 0.5 *
                       (double(at.at("k2C_" + what + "_theta")) + double(at.at("k2C_" + what + "_phi")));
            };
            const OrientedRealization::Incidence& incidence = found.incidences[size_t(beta / 15)];
            EXPECT_NEAR(incidence.extinction / mean("ext"), 1, tolerance) << beta;
            EXPECT_NEAR(incidence.absorption / mean("abs"), 1, tolerance) << beta;
            EXPECT_NEAR(incidence.scattering / mean("sca"), 1, tolerance) << beta;
            // A control: other directions have other numbers.
            const OrientedRealization::Incidence& next =
                found.incidences[size_t(beta / 15 + (beta < 90 ? 1 : -1))];
            EXPECT_GT(std::abs(next.extinction / mean("ext") - 1), 1e-3) << beta;
        }
    }
}

TEST(OrientedRealization, IntensitiesAreThoseOfTheFieldsAndIntegrateToTheirCrossSections) {
    const ReferenceCase known = ReferenceCase::Read("cluster5");
    const OrientedDirections directions = DirectionsFor(known.spheres, 31, 121);
    const OrientedRealization found = SolveOriented(known.spheres, Precise(), directions);
    const std::vector<double> weights = ClenshawCurtisWeights(60);
    for (const int i : {0, 11, 30}) {
        const OrientedRealization::Incidence& incidence = found.incidences[size_t(i)];
        double sum = 0;
        for (int j = 0; j <= 60; ++j)
            for (int k = 0; k <= 120; ++k) {
                const double s11 = incidence.intensity[size_t(j * 121 + k)];
                sum += weights[size_t(j)] * s11 * (k == 0 || k == 120 ? 0.5 : 1.) * 2 * pi / 120;
                if (k % 37 != 5 || j % 13 != 4) continue;
                const double theta = j * pi / 60, phi = k * pi / 120;
                const double there = incidence.waves.Amplitude({theta, phi}).squaredNorm(),
                             mirrored = incidence.waves.Amplitude({theta, -phi}).squaredNorm();
                EXPECT_NEAR(s11 / (0.25 * (there + mirrored)), 1, 1e-10) << i << ' ' << j << ' ' << k;
            }
        EXPECT_NEAR(sum / incidence.scattering, 1, 1e-6) << i;
    }
}

// Against a quadrature that is exact for fields of this degree, for three directions; one off the plane y =
// 0.
TEST(OneOriginWaves, AsymmetryIsTheIntegralOfTheCosine) {
    const ReferenceCase known = ReferenceCase::Read("cluster5");
    const Cluster cluster(known.spheres, 4);
    const ClusterSolver solver(cluster, size_t(1) << 30);
    for (const Direction n : {Direction{0, 0}, Direction{0.7, 0}, Direction{2.1, -1.3}}) {
        const ScatteredWaves scattered = solver.Solve(IncidentWaves(cluster, n), {.residual = 1e-11});
        const OneOriginWaves waves = AboutOrigin(cluster, scattered.coefficients, FarFieldDegree(cluster));
        const int steps = 2 * (waves.degree + 1);
        const std::vector<double> weights = ClenshawCurtisWeights(steps);
        CrossSection asymmetry = {0, 0}, scattering = {0, 0};
        for (int j = 0; j <= steps; ++j)
            for (int k = 0; k < steps; ++k) {
                const Direction s{j * pi / steps, k * 2 * pi / steps};
                const CrossSection part = waves.Amplitude(s).colwise().squaredNorm().transpose().array() *
                                          (weights[size_t(j)] * 2 * pi / steps);
                scattering += part;
                asymmetry += part * n.Vector().dot(s.Vector());
            }
        for (int p = 0; p < 2; ++p) {
            EXPECT_NEAR(scattering[p] / waves.Scattering()[p], 1, 1e-11);
            EXPECT_NEAR(asymmetry[p] / waves.Asymmetry(n)[p], 1, 1e-11);
            // A control: another direction has another mean cosine.
            EXPECT_GT(std::abs(waves.Asymmetry({n.theta + 0.3, n.phi})[p] / asymmetry[p] - 1), 1e-3);
        }
    }
}

// Far too few directions for a cluster of this size: means have its light, values at the directions have not.
TEST(OrientedRealization, LobesNarrowerThanTheGridKeepTheirLight) {
    const ReferenceCase known = ReferenceCase::Read("cluster12_titania");
    const OrientedRealization found = SolveOriented(known.spheres, {}, DirectionsFor(known.spheres, 10, 19));
    const OrientedGrid grid(EqualAngles(19), 19);
    double worst = 0;
    for (const OrientedRealization::Incidence& incidence : found.incidences) {
        EXPECT_NEAR(grid.OverSphere<double>(incidence.intensity, 0) / incidence.scattering, 1, 0.01);
        std::vector<double> values;
        for (int j = 0; j < 19; ++j)
            for (int k = 0; k < 19; ++k)
                values.push_back(0.5 * incidence.waves.Amplitude({j * pi / 18, k * pi / 18}).squaredNorm());
        worst = std::max(worst, std::abs(grid.OverSphere<double>(values, 0) / incidence.scattering - 1));
    }
    EXPECT_GT(worst, 0.03) << "a control";
}

// ---- Tables ----

/// Two spheres of x = 5 that touch, along z, absorbing: what they are does not depend on rotations about z.
BulkSettings Bisphere() {
    BulkSettings settings;
    settings.ensemble.species = {{"sphere", RadiusDistribution::Constant(5), 0.05}};
    settings.ensemble.arrangement = Arrangement::List;
    settings.ensemble.particles = {{Point(0, 0, -5), 5, 0}, {Point(0, 0, 5), 5, 0}};
    settings.ensemble.count = 2;
    settings.indices = {OpticalIndex({1.5, 0.005})};
    settings.wavelengths = {kUnitWavelength};
    settings.mode = AverageMode::Aggregate;
    settings.realization = Precise();
    return settings;
}

// The mean over all directions is that of random orientations, which two programs know.
TEST(OrientedComputation, OfABisphereHasTheMeansOfRandomOrientations) {
    OrientedComputation computation(Bisphere(), {.numIncidences = 31, .numAzimuths = 91});
    computation.AddRealizations(1, nullptr);
    EXPECT_LT(computation.WorstEnergyError(), 1e-10);
    const OrientedBulkTable table = computation.Table();
    const OrientedGrid grid(table);
    const double perParticle = computation.GetEnsemble().NumberDensity() * 1000 / 2;
    const ReferenceCase known = ReferenceCase::Read("bisphere_2r");
    const auto& random = known.numbers.at("mstm").at("random");
    EXPECT_NEAR(grid.MeanOverIncidences(table.sigmaS[0]) / perParticle / double(random.at("k2C_sca")), 1,
                2e-3);
    EXPECT_NEAR(grid.MeanOverIncidences(table.sigmaA[0]) / perParticle / double(random.at("k2C_abs")), 1,
                2e-3);
    EXPECT_NEAR(table.g[0], double(random.at("g")), 6e-3);
    // One realisation is reciprocal but for the interpolation between nodes; and directions do matter.
    EXPECT_LT(table.errorReciprocity[0], 0.03);
    EXPECT_GT(table.sigmaS[0].back() / table.sigmaS[0].front(), 1.5);
}

// N = 1, off the origin: the waves of a ball, whatever the incidence.
TEST(OrientedComputation, OfOneSphereIsMie) {
    BulkSettings settings = Bisphere();
    settings.ensemble.particles = {{Point(2, 1, -1), 5, 0}};
    OrientedComputation computation(settings, {.numIncidences = 46, .numAzimuths = 91});
    computation.AddRealizations(1, nullptr);
    const OrientedAverage average = computation.AverageAt(0);
    const MieCoefficients mie = MieOfSphere(5, {1.5, 0.005}, MieDegree(5));
    const MieEfficiencies q = EfficienciesOf(mie, 5);
    for (int i = 0; i < 46; i += 5) {
        const OrientedAverage::Incidence& found = average.incidences[size_t(i)];
        EXPECT_NEAR(found.extinction / (q.extinction * 25 * pi), 1, 1e-8);
        EXPECT_NEAR(found.absorption / (q.Absorption() * 25 * pi), 1, 1e-8);
        const Vec3 n = DirectionAt(2. * i, 0);
        for (int j = 0; j <= 90; j += 9)
            for (int k = 0; k <= 90; k += 21) {
                const double cosine = double(Dot(n, DirectionAt(2. * j, k * pi / 90)));
                EXPECT_NEAR(found.intensity[size_t(j * 91 + k)] / AmplitudesAt(mie, cosine).Intensity(), 1,
                            2e-4)
                    << i << ' ' << j << ' ' << k;
            }
    }
}

/// Spheres of x = 1, m = 1.33, at 5 % by volume, as a probe of a medium without an axis.
BulkSettings Probe() {
    BulkSettings settings;
    settings.ensemble.species = {{"water", RadiusDistribution::Constant(1), 0.05}};
    settings.ensemble.arrangement = Arrangement::Cut;
    settings.ensemble.count = 12;
    settings.indices = {OpticalIndex({1.33, 0.003})};
    settings.wavelengths = {kUnitWavelength};
    settings.mode = AverageMode::Medium;
    settings.seed = 7;
    return settings;
}

// Each incidence by itself has the numbers of the isotropic computation, with other realisations. Power:
// standard errors of 3 %; the control is the mean of all intensity, with that of the probe's shape.
TEST(OrientedComputationLong, OfAnEnsembleWithoutAnAxisIsTheIsotropicOne) {
    BulkSettings settings = Probe();
    BulkComputation isotropic(settings);
    isotropic.AddRealizations(Scaled(160), nullptr);
    const BulkTable expected = isotropic.Table();
    settings.seed = 8;
    OrientedComputation computation(settings, {.numIncidences = 4, .numAzimuths = 13});
    computation.AddRealizations(Scaled(160), nullptr);
    EXPECT_EQ(computation.NumRefused(), 0);
    EXPECT_LT(computation.WorstEnergyError(), 1e-10);
    const OrientedBulkTable table = computation.Table();
    const OrientedGrid grid(table);
    const double error = std::hypot(table.errorSigmaS[0], expected.errorSigmaS[0]);
    EXPECT_LT(error, 0.06 * expected.sigmaS[0] * std::sqrt(160. / Scaled(160)));
    EXPECT_NEAR(grid.MeanOverIncidences(table.sigmaS[0]), expected.sigmaS[0], 5 * error);
    for (size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(table.sigmaS[0][i], expected.sigmaS[0], 5 * 1.5 * error) << i;
        EXPECT_NEAR(
            table.sigmaA[0][i], expected.sigmaA[0],
            5 * std::hypot(table.errorSigmaA[0], expected.errorSigmaA[0]) + 0.01 * expected.sigmaA[0]);
    }
    EXPECT_NEAR(table.g[0], expected.g[0], 0.08 * std::sqrt(160. / Scaled(160)));
    settings.mode = AverageMode::Aggregate;
    OrientedComputation control(settings, {.numIncidences = 4, .numAzimuths = 13});
    control.AddRealizations(20, nullptr);
    EXPECT_GT(grid.MeanOverIncidences(control.Table().sigmaS[0]), 1.5 * expected.sigmaS[0]);
}

/// A flat disc of ten spheres, at two wavelengths.
BulkSettings Disc() {
    BulkSettings settings = Probe();
    settings.ensemble.arrangement = Arrangement::Gaussian;
    settings.ensemble.deviations = {3, 3, 0.8};
    settings.ensemble.count = 10;
    settings.mode = AverageMode::Aggregate;
    settings.wavelengths = {kUnitWavelength, 1.3 * kUnitWavelength};
    return settings;
}

TEST(OrientedComputation, TablesDependOnNeitherThreadsNorSteps) {
    const auto table = [](int threads, std::initializer_list<int> steps) {
        const ThreadLimit limit(threads);
        OrientedComputation computation(Disc(), {.numIncidences = 4, .numAzimuths = 7});
        for (const int step : steps) computation.AddRealizations(step, nullptr);
        EXPECT_EQ(computation.NumRealizations(), 5);
        return computation.Table();
    };
    const OrientedBulkTable first = table(1, {5});
    for (const OrientedBulkTable& other : {table(2, {5}), table(3, {2, 1, 2})}) {
        EXPECT_EQ(other.phase, first.phase);
        EXPECT_EQ(WriteBulkTable(other), WriteBulkTable(first));
    }
    // A control: one realisation less.
    OrientedComputation four(Disc(), {.numIncidences = 4, .numAzimuths = 7});
    four.AddRealizations(4, nullptr);
    EXPECT_NE(four.Table().phase[0], first.phase[0]);
}

TEST(OrientedComputation, GoesOnFromItsStateToTheSameBits) {
    for (const AverageMode mode : {AverageMode::Aggregate, AverageMode::Medium}) {
        BulkSettings settings = Disc();
        settings.mode = mode;
        const auto fresh = [&] {
            return OrientedComputation(settings, {.numIncidences = 3, .numAzimuths = 5});
        };
        OrientedComputation whole = fresh(), first = fresh(), second = fresh();
        whole.AddRealizations(6, nullptr);
        first.AddRealizations(2, nullptr);
        const std::vector<double> state = first.State();
        ASSERT_TRUE(second.SetState(state));
        second.AddRealizations(4, nullptr);
        EXPECT_EQ(second.State(), whole.State());
        EXPECT_EQ(second.Table().phase, whole.Table().phase);
        EXPECT_EQ(WriteBulkTable(second.Table()), WriteBulkTable(whole.Table()));
        // Controls: without the second half, and numbers that are no such state.
        EXPECT_NE(first.Table().phase, whole.Table().phase);
        OrientedComputation other = fresh();
        for (const size_t size : {size_t(0), state.size() - 1, state.size() + 1}) {
            std::vector<double> wrong = state;
            wrong.resize(size);
            EXPECT_FALSE(other.SetState(wrong)) << size;
        }
        EXPECT_EQ(other.NumRealizations(), 0);
    }
}

TEST(OrientedComputation, KeepsWholeRealisationsWhenItIsStopped) {
    const OrientedSettings directions{.numIncidences = 4, .numAzimuths = 5};
    OrientedComputation computation(Disc(), directions), whole(Disc(), directions);
    ASSERT_EQ(computation.UnitsPerRealization(), 8);
    const ThreadLimit limit(2);
    StoppingObserver observer(3 * 8 + 3);
    computation.AddRealizations(10, &observer);
    EXPECT_GE(computation.NumRealizations(), 2);
    EXPECT_LE(computation.NumRealizations(), 3);
    computation.AddRealizations(9 - computation.NumRealizations(), nullptr);
    whole.AddRealizations(9, nullptr);
    EXPECT_EQ(computation.Table().phase, whole.Table().phase);
    EXPECT_EQ(computation.State(), whole.State());
}

// Without the steps that make tables reciprocal, which keep the coefficients.
TEST(OrientedComputationLong, MeansAreThoseOfTheTable) {
    for (const AverageMode mode : {AverageMode::Aggregate, AverageMode::Medium}) {
        BulkSettings settings = Disc();
        settings.mode = mode;
        settings.ensemble.count = 5;
        OrientedComputation computation(settings, {.numIncidences = 9, .numAzimuths = 17});
        computation.AddRealizations(14, nullptr);
        const OrientedBulkTable table = computation.Table();
        const OrientedGrid grid(table);
        for (size_t w = 0; w < 2; ++w) {
            const double perParticle =
                computation.GetEnsemble().NumberDensity() * 1000 / std::pow(computation.Wavenumber(w), 2);
            const std::vector<OrientedMeans> means = computation.MeansOfIncidences(w);
            for (size_t i = 0; i < 9; ++i) {
                EXPECT_NEAR(means[i].scattering.mean * perParticle / table.sigmaS[w][i], 1, 1e-12);
                EXPECT_NEAR(means[i].absorption.mean * perParticle / table.sigmaA[w][i], 1, 1e-12);
                EXPECT_NEAR(means[i].albedo.mean,
                            table.sigmaS[w][i] / (table.sigmaS[w][i] + table.sigmaA[w][i]), 1e-12);
            }
            const OrientedMeans all = computation.MeansOverIncidences(w);
            EXPECT_NEAR(all.scattering.mean * perParticle / grid.MeanOverIncidences(table.sigmaS[w]), 1,
                        1e-12);
            EXPECT_NEAR(all.scattering.error * perParticle / table.errorSigmaS[w], 1, 1e-9);
            EXPECT_NEAR(all.absorption.error * perParticle / table.errorSigmaA[w], 1, 1e-9);
            // By other means: from waves, and from intensities on the table's grid.
            EXPECT_NEAR(all.g.mean, table.g[w], 0.02);
            if (mode == AverageMode::Aggregate) {
                EXPECT_GT(all.g.mean, 0.2) << "a control";
            }
            EXPECT_GT(all.g.error, 0);
            const ConvergencePoint& last = computation.History(w).back();
            EXPECT_EQ(last.numRealizations, 14);
            EXPECT_EQ(last.extinction.mean, all.extinction.mean);
            EXPECT_EQ(last.scattering.error, all.scattering.error);
            EXPECT_EQ(last.g.mean, all.g.mean);
        }
    }
}

// Light across the axis meets a disc edge on: fields of all its particles add up in a wider cone.
TEST(OrientedComputation, TablesAreWhatScenesRead) {
    OrientedComputation computation(Disc(), {.numIncidences = 10, .numAzimuths = 13});
    computation.AddRealizations(12, nullptr);
    const OrientedBulkTable table = computation.Table();
    const std::string path = WriteFile("disc.json", table);
    auto read = std::get<OrientedBulkTable>(ReadBulkFile(path));
    ReadOrientedPhase(path, {}, &read);
    EXPECT_EQ(read.mode, "aggregate");
    EXPECT_EQ(read.phase, table.phase);
    for (size_t w = 0; w < 2; ++w) {
        EXPECT_GT(read.errorSigmaS[w], 0);
        EXPECT_GT(read.errorPhase[w], 0.01);
        EXPECT_LT(read.errorPhase[w], 0.5);
        EXPECT_GT(read.errorReciprocity[w], 0.01);
        EXPECT_GT(read.sigmaS[w].back(), 1.1 * read.sigmaS[w].front());
    }
}

// As tables of isotropic ensembles.
TEST(OrientedComputation, AbsorptionThatIsRoundingIsNotNegative) {
    BulkSettings settings = Disc();
    settings.ensemble.count = 3;
    for (OpticalIndex& index : settings.indices) index = OpticalIndex(Complex(1.5, 1e-18));
    OrientedComputation computation(settings, {.numIncidences = 4, .numAzimuths = 7});
    computation.AddRealizations(2, nullptr);
    double least = 1;
    for (size_t w = 0; w < settings.wavelengths.size(); ++w)
        for (const OrientedAverage::Incidence& incidence : computation.AverageAt(w).incidences)
            least = std::min(least, incidence.absorption);
    EXPECT_LT(least, 0) << "a control";
    const std::string path = WriteFile("rounding.json", computation.Table());
    const auto read = std::get<OrientedBulkTable>(ReadBulkFile(path));
    for (const std::vector<double>& sigmaA : read.sigmaA)
        for (const double value : sigmaA) EXPECT_GE(value, 0);
}

// The ball is white where nothing is lost; the control loses what its particles absorb. Tables of any number
// of realisations are to be so.
TEST(OrientedComputation, TablesHaveFurnacesOfOne) {
    for (const double k : {0., 0.003}) {
        BulkSettings settings = Disc();
        settings.indices = {OpticalIndex({1.33, k})};
        settings.wavelengths = {400, 700};
        settings.ensemble.species[0].radius = RadiusDistribution::Constant(0.1);
        settings.ensemble.deviations = {0.3, 0.3, 0.08};
        OrientedComputation computation(settings, {.numIncidences = 7, .numAzimuths = 13});
        computation.AddRealizations(2, nullptr);
        const std::string scene =
            View("volpath", 4000, {3, 1, -2}) + kWhite +
            "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"vector3 orientation\" [1 2 0] \"float "
            "scale\" 0.01 \"string bulk\" \"" +
            WriteFile("disc.json", computation.Table()) + "\" " + kBall;
        const RunningMean mean = CenterRadiance(BuildText(scene), Scaled(20000), SeedOf(FullTestName()));
        if (k == 0)
            EXPECT_NEAR(mean.Mean(), 1, 2e-4);
        else
            EXPECT_LT(mean.Mean(), 0.99);
    }
}

TEST(Ensemble, OrientedOnesKeepTheirAxis) {
    EnsembleSettings settings = Disc().ensemble;
    double flat[2] = {0, 0}, wide[2] = {0, 0};
    for (const int isOriented : {0, 1}) {
        settings.isOriented = isOriented;
        const Ensemble ensemble(settings);
        for (uint64_t r = 0; r < 200; ++r)
            for (const Particle& particle : ensemble.Realize(3, r)) {
                flat[isOriented] += particle.center.z() * particle.center.z() / 2000;
                wide[isOriented] += particle.center.x() * particle.center.x() / 2000;
            }
    }
    EXPECT_LT(flat[1], 0.35 * wide[1]);
    EXPECT_NEAR(flat[0] / wide[0], 1, 0.3);
}

}  // namespace
}  // namespace lacquer::test::oriented_ensembles_test
