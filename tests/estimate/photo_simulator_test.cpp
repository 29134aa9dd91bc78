// From parameters to summaries and back: the whole forward side.
#include "estimate/photo_simulator.h"

#include <gtest/gtest.h>

#include "estimate/gradient_check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::estimate::photo_simulator_test {
namespace {

PhotoSettings SmallSettings() {
    PhotoSettings settings;
    settings.resolution = 64;
    settings.extent = 16;
    return settings;
}

Vector MeansOf(const Simulator& simulator) {
    Vector x(Eigen::Index(simulator.Parameters().Size()));
    for (size_t i = 0; i < simulator.Parameters().Size(); ++i)
        x[Eigen::Index(i)] = simulator.Parameters()[i].prior.mean;
    return x;
}

// A random sum of all default summaries, by each parameter. Smooth parameters: steps of 1e-4, which meet no
// kink but that of clipping, of which few pixels are near; the others: as small a step as rounding allows.
TEST(PhotoSimulator, GradientOfTheWholeIsThatOfDifferences) {
    for (const MaterialModel* model : AllModels()) {
        FreeParameters free;
        free.alsoFree = {"axis_x", "axis_y"};
        const PhotoSimulator simulator(*model, SmallSettings(), free);
        Random random(4);
        const Vector x = simulator.Parameters().SamplePrior(random);
        const auto run = simulator.SimulateForGradient(x, 5);
        EXPECT_EQ(run->Summaries(), simulator.Simulate(x, 5));
        const Vector weights = Random(8).Normals(run->Summaries().size());
        const Vector gradient = run->Gradient(weights);
        const ParameterSpace& space = simulator.Parameters();
        double worst = 0, scale = 0;
        for (Eigen::Index k = 0; k < x.size(); ++k)
            scale = std::max(scale, std::abs(gradient[k] * space[size_t(k)].prior.sd));
        for (Eigen::Index k = 0; k < x.size(); ++k) {
            const double sd = space[size_t(k)].prior.sd;
            const double difference = sd * DifferenceAlong(
                                               [&](double t) {
                                                   Vector moved = x;
                                                   moved[k] += t;
                                                   return simulator.Simulate(moved, 5).dot(weights);
                                               },
                                               (space[size_t(k)].smooth ? 1e-6 : 1e-7) * sd);
            const double gap =
                std::abs(sd * gradient[k] - difference) / (std::abs(difference) + 1e-3 * scale);
            worst = std::max(worst, gap);
            EXPECT_LT(gap, 1e-5) << model->Name() << " " << space[size_t(k)].name;
        }
        EXPECT_GT(worst, 0) << model->Name();
    }
}

// Pixels that are means of simulated ones: what a reader makes of the finer photograph, and its derivatives.
TEST(PhotoSimulator, AveragesAsAReaderOfFinerPhotographsDoes) {
    PhotoSettings fine = SmallSettings(), coarse = SmallSettings();
    fine.resolution = 128;
    fine.tone = coarse.tone = ToneCurve::Linear;
    coarse.averaging = 2;
    const PhotoSimulator larger(LeatherModel(), fine, {}), smaller(LeatherModel(), coarse, {});
    const Vector x = MeansOf(smaller);
    const PlanarImage before = larger.Photograph(x, 5), after = smaller.Photograph(x, 5);
    ASSERT_EQ(after.size, 64);
    for (const size_t place : {size_t(0), size_t(64 * 40 + 31), size_t(64 * 63 + 63)}) {
        const size_t corner = 2 * (place / 64) * 128 + 2 * (place % 64);
        const auto values = before.Channel(1);
        EXPECT_NEAR(after.Channel(1)[place],
                    (values[corner] + values[corner + 1] + values[corner + 128] + values[corner + 129]) / 4,
                    1e-12);
    }
    const Vector weights = Random(8).Normals(Eigen::Index(smaller.SummaryNames().size()));
    const Vector gradient = smaller.SimulateForGradient(x, 5)->Gradient(weights);
    for (const char* name : {"light", "r", "rough", "height", "vig"}) {
        const auto k = Eigen::Index(*smaller.Parameters().Find(name));
        const double sd = smaller.Parameters()[size_t(k)].prior.sd;
        const double difference = DifferenceAlong(
            [&](double t) {
                Vector moved = x;
                moved[k] += t;
                return smaller.Simulate(moved, 5).dot(weights);
            },
            1e-6 * sd);
        EXPECT_NEAR(gradient[k], difference, 1e-5 * std::abs(difference)) << name;
    }
}

TEST(PhotoSimulator, PriorsOfLightAndVignetteFollowTheDistance) {
    PhotoSettings settings = SmallSettings();
    settings.distance = 50;
    FreeParameters free;
    const PhotoSimulator far(BumpModel(), settings, free);
    const auto priorOf = [](const PhotoSimulator& simulator, const char* name) {
        return simulator.Parameters()[*simulator.Parameters().Find(name)].prior;
    };
    EXPECT_DOUBLE_EQ(priorOf(far, "light").mean, 4 * 999);
    EXPECT_DOUBLE_EQ(priorOf(far, "light").sd, 4 * 400);
    EXPECT_DOUBLE_EQ(priorOf(far, "light").high, 4 * 2500);
    EXPECT_DOUBLE_EQ(priorOf(far, "vig").mean, 20);
    EXPECT_DOUBLE_EQ(priorOf(far, "vig").low, 10);
    EXPECT_DOUBLE_EQ(priorOf(far, "rough").mean, .2);
    EXPECT_EQ(far.Notes(), std::vector<std::string>{"of light and vig: those for 25 cm, scaled to 50 cm"});
    // A prior that is given stays, and so does the other one's scale.
    free.replacedPriors["light"] = {500, 100, 1, 900};
    const PhotoSimulator own(BumpModel(), settings, free);
    EXPECT_DOUBLE_EQ(priorOf(own, "light").mean, 500);
    EXPECT_DOUBLE_EQ(priorOf(own, "vig").mean, 20);
    EXPECT_EQ(own.Notes(), std::vector<std::string>{"of vig: those for 25 cm, scaled to 50 cm"});
    EXPECT_TRUE(PhotoSimulator(BumpModel(), SmallSettings(), {}).Notes().empty());
}

// Threads take turns at the same arguments; each run has the bits that it has alone.
TEST(PhotoSimulator, ThreadsDoNotChangeBits) {
    const PhotoSimulator simulator(LeatherModel(), SmallSettings(), {});
    const Vector x = MeansOf(simulator);
    std::vector<Vector> alone(12), together(12);
    for (size_t i = 0; i < alone.size(); ++i) alone[i] = simulator.Simulate(x, i / 2);
    const ThreadLimit threads(7);
    ParallelFor(int64_t(alone.size()),
                [&](int64_t i) { together[size_t(i)] = simulator.Simulate(x, uint64_t(i) / 2); });
    for (size_t i = 0; i < alone.size(); ++i) EXPECT_EQ(alone[i], together[i]) << i;
    EXPECT_EQ(alone[0], alone[1]);
    EXPECT_NE(alone[0], alone[2]);
}

TEST(PhotoSimulator, SummariesOfItsPhotographAreItsSummaries) {
    for (const MaterialModel* model : AllModels()) {
        const PhotoSimulator simulator(*model, SmallSettings(), {});
        const Vector x = MeansOf(simulator);
        EXPECT_EQ(simulator.SummariesOf(simulator.Photograph(x, 3)), simulator.Simulate(x, 3))
            << model->Name();
        EXPECT_EQ(size_t(simulator.Simulate(x, 3).size()), simulator.SummaryNames().size());
    }
}

// All corners of the prior's box give finite numbers.
TEST(PhotoSimulator, ExtremeParametersGiveFiniteSummaries) {
    for (const MaterialModel* model : AllModels())
        for (const PriorSet set : {PriorSet::Test, PriorSet::Demo}) {
            FreeParameters free;
            free.priors = set;
            const PhotoSimulator simulator(*model, SmallSettings(), free);
            Random random(11);
            for (uint64_t i = 0; i < 12; ++i) {
                Vector x = MeansOf(simulator);
                for (Eigen::Index k = 0; k < x.size(); ++k) {
                    const Prior& prior = simulator.Parameters()[size_t(k)].prior;
                    x[k] = random.Uniform() < 0.5 ? prior.low : prior.high;
                }
                const auto run = simulator.SimulateForGradient(x, i);
                EXPECT_TRUE(run->Summaries().allFinite()) << model->Name();
                EXPECT_TRUE(run->Gradient(Vector::Ones(run->Summaries().size())).allFinite())
                    << model->Name();
            }
        }
}

TEST(PhotoSimulator, ParametersAreFreeOrFixedAsAsked) {
    FreeParameters free;
    free.fixed["rough"] = 0.3;
    free.replacedPriors["noise_scale"] = {0.01, 0.002, 0.001, 0.02};
    const PhotoSimulator simulator(LeatherModel(), SmallSettings(), free);
    EXPECT_FALSE(simulator.Parameters().Find("rough"));
    EXPECT_TRUE(simulator.Parameters().Find("noise_scale"));
    EXPECT_FALSE(simulator.Parameters().Find("axis_x"));
    const auto all = simulator.AllParameters(MeansOf(simulator));
    EXPECT_EQ(all[size_t(LeatherModel().Find("rough"))], 0.3);
    EXPECT_EQ(all[size_t(LeatherModel().Find("noise_scale"))], 0.01);
}

TEST(PhotoSimulator, MistakesAreNamed) {
    const auto messageOf = [](const FreeParameters& free, const PhotoSettings& settings) -> std::string {
        try {
            PhotoSimulator(BumpModel(), settings, free);
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
        return "";
    };
    FreeParameters free;
    free.fixed["roughh"] = 0.3;
    EXPECT_EQ(messageOf(free, SmallSettings()),
              "model bump has no parameter \"roughh\"; did you mean \"rough\"?");
    free.fixed = {{"rough", 3}};
    EXPECT_EQ(messageOf(free, SmallSettings()), "rough is fixed at 3, outside of [0.01, 0.5]");
    PhotoSettings settings = SmallSettings();
    settings.resolution = 100;
    EXPECT_EQ(messageOf({}, settings), "the resolution is 100, which is not a multiple of 16 from 64 on");
    settings = SmallSettings();
    settings.extent = 0;
    EXPECT_EQ(messageOf({}, settings),
              "the sample has a side of 0 cm at a distance of 25 cm; both have to be positive and finite");
}

TEST(PhotoSimulator, PriorsBeyondTheNyquistFrequencyAreCut) {
    PhotoSettings settings = SmallSettings();
    settings.extent = 25;  // 1.28 cycles/cm
    const PhotoSimulator simulator(BumpModel(), settings, {});
    EXPECT_DOUBLE_EQ(simulator.Parameters()[*simulator.Parameters().Find("fsigma")].prior.high, 1.28);
    ASSERT_EQ(simulator.Warnings().size(), 1u);
    EXPECT_EQ(simulator.Warnings()[0],
              "the prior of fsigma reaches to 2 cycles/cm, and is cut at 1.28, beyond which the photograph "
              "shows nothing");
}

}  // namespace
}  // namespace lacquer::estimate::photo_simulator_test
