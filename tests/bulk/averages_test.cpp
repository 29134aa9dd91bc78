#include <gtest/gtest.h>

#include <numbers>

#include "bulk/averages/realization.h"
#include "bulk/ensembles/ensemble.h"
#include "bulk/ensembles/structure.h"
#include "bulk/reference_case.h"
#include "pbrt/core/error.h"
#include "support/statistics.h"

namespace lacquer::test::averages_test {
namespace {

using namespace bulk;
using std::numbers::pi;

/// Spheres of size parameter x; lengths of the ensemble are times k.
EnsembleSettings OneSpecies(double x, double fraction, int count, Arrangement arrangement) {
    EnsembleSettings settings;
    settings.species = {{"spheres", RadiusDistribution::Constant(x), fraction}};
    settings.arrangement = arrangement;
    settings.count = count;
    return settings;
}

struct EnsembleRun {
    ScatteringSums sums{181};
    double worstEnergy = 0;
    bool haveConverged = true;
};

EnsembleRun AverageOver(const EnsembleSettings& settings, Complex m, int numRealizations, uint64_t seed) {
    const Ensemble ensemble(settings);
    const double reach = ensemble.BallRadius() + settings.species[0].radius.Largest();
    const std::vector<double> thetas = EvenAngles(180);
    const AzimuthalHarmonics harmonics(FarFieldDegree(reach, MieDegree(reach) + 4), thetas);
    EnsembleRun run;
    for (int r = 0; r < numRealizations; ++r) {
        std::vector<Sphere> spheres;
        for (const Particle& p : ensemble.Realize(seed, uint64_t(r)))
            spheres.push_back(MakeSphere(p.center, p.radius, m));
        const SolvedRealization solved = SolveRealization(std::move(spheres), {}, harmonics);
        run.sums.Add(solved.scattering);
        run.worstEnergy = std::max(run.worstEnergy, solved.energyError);
        run.haveConverged &= solved.hasConverged;
    }
    return run;
}

double MieScattering(double x, Complex m) {
    return EfficienciesOf(MieOfSphere(x, m, MieDegree(x)), x).scattering * pi * x * x;
}

/// Mie theory times the structure factor of Percus and Yevick: k^2 C_sca of one sphere among others.
double MieTimesStructure(double x, Complex m, double fraction) {
    const MieCoefficients mie = MieOfSphere(x, m, MieDegree(x));
    const std::vector<double> weights = ClenshawCurtisWeights(180);
    double sum = 0;
    for (size_t i = 0; i <= 180; ++i) {
        const double theta = double(i) * pi / 180;
        sum += 2 * pi * weights[i] * AmplitudesAt(mie, std::cos(theta)).Intensity() *
               PercusYevickStructureFactor(fraction, 4 * x * std::sin(theta / 2));
    }
    return sum;
}

// Numbers by the prototype with other random clusters: x = 1, m = 1.33, 5 % by volume.
TEST(ScatteringAveragesLong, ThreeMeansAreThoseOfThePrototype) {
    const EnsembleRun fixed =
        AverageOver(OneSpecies(1, 0.05, 12, Arrangement::Uniform), 1.33, Scaled(160), SeedOf(FullTestName()));
    EXPECT_TRUE(fixed.haveConverged);
    EXPECT_LT(fixed.worstEnergy, 1e-10);
    const ScatteringAverage total = fixed.sums.Average(AverageMode::Aggregate);
    const ScatteringAverage medium = fixed.sums.Average(AverageMode::Medium);
    const ScatteringAverage coherent = fixed.sums.Average(AverageMode::Chapter);
    EXPECT_NEAR(total.extinction.mean, 0.4948, 4 * (total.extinction.error + 0.0116));
    EXPECT_NEAR(total.scattering.mean / total.extinction.mean, 1, 1e-9);
    EXPECT_NEAR(medium.scattering.mean, 0.2107, 4 * (medium.scattering.error + 0.005));
    EXPECT_NEAR(coherent.scattering.mean, 0.2842, 4 * (coherent.scattering.error + 0.01));
    EXPECT_NEAR(medium.scattering.mean + coherent.scattering.mean, total.scattering.mean, 1e-6);
    EXPECT_NEAR(total.g.mean, 0.542, 0.04);
    EXPECT_NEAR(coherent.g.mean, 0.922, 0.03);
    // One for the other would be seen.
    EXPECT_GT(std::abs(coherent.scattering.mean - total.scattering.mean), 10 * total.scattering.error);

    // A number that fluctuates has no false hole straight on.
    const EnsembleRun cut =
        AverageOver(OneSpecies(1, 0.05, 12, Arrangement::Cut), 1.33, Scaled(160), SeedOf(FullTestName()));
    const ScatteringAverage probe = cut.sums.Average(AverageMode::Medium);
    EXPECT_NEAR(probe.scattering.mean, 0.2382, 4 * (probe.scattering.error + 0.006));
    EXPECT_NEAR(cut.sums.MeanParticles(), 12, 4.5 * std::sqrt(12. / Scaled(160)));
    EXPECT_GT(probe.intensity[0], 10 * std::abs(medium.intensity[0]));
}

TEST(ScatteringAveragesLong, ThinMediaScatterAsMieSays) {
    const EnsembleRun run =
        AverageOver(OneSpecies(1, 0.001, 10, Arrangement::Cut), 1.33, Scaled(120), SeedOf(FullTestName()));
    const ScatteringAverage average = run.sums.Average(AverageMode::Medium);
    const double expected = MieTimesStructure(1, 1.33, 0.001);
    EXPECT_NEAR(expected / MieScattering(1, 1.33), 1, 0.01);
    EXPECT_LT(average.scattering.error, 0.05 * expected * std::sqrt(120. / Scaled(120)));
    EXPECT_NEAR(average.scattering.mean, expected, 4 * average.scattering.error);
}

TEST(ScatteringAveragesLong, WeakSpheresScatterAsTheirStructureSays) {
    const double fraction = 0.1;
    const Complex m = 1.02;
    const EnsembleRun run =
        AverageOver(OneSpecies(1, fraction, 60, Arrangement::Cut), m, Scaled(160), SeedOf(FullTestName()));
    const ScatteringAverage average = run.sums.Average(AverageMode::Medium);
    const double expected = MieTimesStructure(1, m, fraction);
    EXPECT_LT(average.scattering.error, 0.03 * expected * std::sqrt(160. / Scaled(160)));
    // The ball's surface, where spheres have fewer neighbours, adds up to 4 % at this size.
    EXPECT_NEAR(average.scattering.mean, expected, 4 * average.scattering.error + 0.04 * expected);
    // Control: without the structure it is another number.
    EXPECT_GT(std::abs(average.scattering.mean - MieScattering(1, m)), 4 * average.scattering.error);
}

// The square of a mean of three is too large by a third of the variance; pairs of different realisations are
// not.
TEST(ScatteringAverages, FewRealizationsHaveNoBias) {
    constexpr int kEach = 3;
    const int numSums = Scaled(200);
    std::vector<ScatteringSums> sums(size_t(numSums), ScatteringSums(3));
    Random random(SeedOf(FullTestName()));
    double coherent = 0, squares = 0;
    for (ScatteringSums& sum : sums) {
        for (int r = 0; r < kEach; ++r) {
            RealizationScattering one;
            one.numParticles = one.extinction = 1;
            one.angles.resize(3);
            for (AzimuthalMeans& means : one.angles) {
                // A mean of 1 in F_11 and F_22, with deviations of 1 in all parts.
                for (int k = 0; k < 4; ++k)
                    means.amplitude(k / 2, k % 2) =
                        Complex(k % 3 == 0, 0) + Complex(random.Normal(), random.Normal());
                means.s11 = 0.5 * means.amplitude.squaredNorm();
            }
            sum.Add(one);
        }
        const double value = sum.Average(AverageMode::Chapter).intensity[1];
        coherent += value / numSums;
        squares += value * value / numSums;
    }
    const double error = std::sqrt((squares - coherent * coherent) / numSums);
    EXPECT_NEAR(coherent, 1, 4.5 * error);
    // The biased square would be 1 + 8/2/3.
    EXPECT_LT(4.5 * error, 4. / 3);
}

TEST(ScatteringAveragesLong, NumbersInACutFluctuateAsInAnEndlessMedium) {
    const Ensemble thin(OneSpecies(1, 1e-4, 30, Arrangement::Cut));
    const int numRuns = Scaled(3000);
    double sum = 0, squares = 0;
    for (int r = 0; r < numRuns; ++r) {
        const double n = double(thin.Realize(SeedOf(FullTestName()), uint64_t(r)).size());
        sum += n / numRuns;
        squares += n * n / numRuns;
    }
    const double ratio = (squares - sum * sum) / sum;
    // Poisson's numbers: 1 with a deviation of sqrt(2/n). A fixed number in the box gives 0.73.
    EXPECT_NEAR(ratio, 1, 4.5 * std::sqrt(2. / numRuns));
}

TEST(ScatteringAverages, OneSphereIsMie) {
    const Complex m(1.5, 0.1);
    const double x = 2;
    ScatteringSums sums(181);
    const AzimuthalHarmonics harmonics(FieldDegree(x, 12), EvenAngles(180));
    for (int i = 0; i < 3; ++i)
        sums.Add(SolveRealization({MakeSphere({0, 0, 0}, x, m)}, {}, harmonics).scattering);
    const ScatteringAverage average = sums.Average(AverageMode::Aggregate);
    const MieCoefficients mie = MieOfSphere(x, m, MieDegree(x) + 2);
    const MieEfficiencies q = EfficienciesOf(mie, x);
    EXPECT_NEAR(average.extinction.mean / (q.extinction * pi * x * x), 1, 1e-10);
    EXPECT_NEAR(average.absorption.mean / (q.Absorption() * pi * x * x), 1, 1e-10);
    EXPECT_NEAR(average.g.mean, q.g, 1e-10);
    for (size_t i = 0; i <= 180; ++i)
        EXPECT_NEAR(average.intensity[i] / AmplitudesAt(mie, std::cos(double(i) * pi / 180)).Intensity(), 1,
                    1e-9);
    EXPECT_NEAR(average.extinction.error, 0, 1e-9);
}

TEST(Ensemble, RealizationsAreWhatTheirNumbersSay) {
    for (const Arrangement arrangement : {Arrangement::Uniform, Arrangement::Cut, Arrangement::PoissonDisc,
                                          Arrangement::Clumped, Arrangement::Gaussian}) {
        EnsembleSettings settings = OneSpecies(1, 0.04, 40, arrangement);
        settings.species.push_back({"others", RadiusDistribution::Normal(0.5, 0.1), 0.01});
        settings.deviations = {4, 8, 2};
        const Ensemble ensemble(settings);
        double count = 0, large = 0;
        constexpr int kRuns = 30;
        for (uint64_t r = 0; r < kRuns; ++r) {
            const std::vector<Particle> particles = ensemble.Realize(5, r);
            const double apart = arrangement == Arrangement::PoissonDisc ? settings.minDistance : 1;
            for (size_t i = 0; i < particles.size(); ++i) {
                large += particles[i].species == 0;
                const double beyond = arrangement == Arrangement::Cut ? 0 : particles[i].radius;
                const double ball = ensemble.BallRadius() > 0 ? ensemble.BallRadius() : 3 * 10;
                EXPECT_LE(particles[i].center.norm() + beyond, ball + 1e-9);
                for (size_t j = 0; j < i; ++j)
                    EXPECT_GE((particles[i].center - particles[j].center).norm(),
                              apart * (particles[i].radius + particles[j].radius) - 1e-9);
            }
            count += double(particles.size());
            // The same again, whatever was drawn in between.
            const std::vector<Particle> again = ensemble.Realize(5, r);
            ASSERT_EQ(again.size(), particles.size());
            for (size_t i = 0; i < again.size(); ++i) EXPECT_EQ(again[i].center, particles[i].center);
        }
        EXPECT_NEAR(count / kRuns / 40, 1, arrangement == Arrangement::Cut ? 0.12 : 1e-12);
        EXPECT_NEAR(large / count, ensemble.NumberShare(0), 0.05);
    }
}

TEST(Ensemble, TooDenseOnesSaySo) {
    const Ensemble ensemble(OneSpecies(1, 0.72, 50, Arrangement::Clumped));
    EXPECT_THROW(ensemble.Realize(1, 0), SceneError);
}

}  // namespace
}  // namespace lacquer::test::averages_test
