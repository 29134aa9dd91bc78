// Scenes as models of measurements: names of parameters, values, and which stacks a measurement tells apart.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "estimate/layered/lobe_posterior.h"
#include "estimate/scene/scene_material_file.h"
#include "estimate/scene/scene_reflectance.h"
#include "measure/bsdf_survey.h"
#include "measure/scene_material.h"
#include "pbrt/core/parallel.h"
#include "pbrt/scene/parser.h"
#include "support/statistics.h"

namespace lacquer::test::layered_scene_test {
namespace {

using namespace estimate;

constexpr const char* kStack = R"(WorldBegin
Texture "worn" "float" "constant" "float value" [.2]
MakeNamedMaterial "coat" "string type" "dielectric" "float roughness" [0.2] "bool remaproughness" false
MakeNamedMaterial "slab" "string type" "slab" "float eta" [1.5] "rgb sigma_t" [.4 .2 .1] "rgb albedo" [.3 .3 .3]
MakeNamedMaterial "clear" "string type" "slab" "float eta" [1.5] "rgb sigma_t" [.1 .1 .1]
MakeNamedMaterial "metal" "string type" "conductor" "float roughness" [0.25] "bool remaproughness" false
MakeNamedMaterial "white" "string type" "diffuse" "rgb reflectance" [.8 .6 .4]
MakeNamedMaterial "rough" "string type" "conductor" "texture roughness" "worn" "spectrum k" "metal-Cu-k"
MakeNamedMaterial "varnish" "string type" "layered" "string stack" ["coat" "slab" "metal"]
MakeNamedMaterial "paint" "string type" "layered" "string stack" ["coat" "clear" "white"]
MakeNamedMaterial "old" "string type" "layered" "string stack" ["coat" "slab" "rough"]
)";

SceneParameters Make(const std::string& material, const std::vector<std::string>& names,
                     const std::map<std::string, Prior>& priors = {}) {
    return SceneParameters(ParseText(kStack, "stack.pbrt", "", nullptr), material, names, priors);
}
std::string Problem(const std::string& material, const std::vector<std::string>& names) {
    try {
        Make(material, names);
    } catch (const SceneError& e) {
        return e.what();
    }
    return "";
}
const estimate::Parameter& At(const SceneParameters& p, size_t i) { return p.Space()[i]; }
std::vector<float> FloatsOf(const SceneDescription& scene, const std::string& material,
                            const std::string& name) {
    SceneDescription copy = scene;
    for (const auto& entry : FindMaterialEntity(material, &copy)->parameters)
        if (entry.name == name) return entry.floats;
    return {};
}

TEST(SceneParameters, AreNumbersOfMaterialsOrChannelsOrMeansThatKeepTheirColour) {
    const SceneParameters p =
        Make("varnish", {"coat.roughness", "slab.sigma_t", "slab.albedo.g", "metal.uroughness"});
    EXPECT_FLOAT_EQ(float(p.All()[0].start), 0.2f);
    EXPECT_NEAR(p.All()[1].start, 0.7 / 3, 1e-6);
    const SceneDescription changed = p.With(Vector{{0.3, 0.7, 0.9, 0.4}});
    EXPECT_EQ(FloatsOf(changed, "coat", "roughness"), (std::vector<float>{0.3f}));
    const std::vector<float> sigma = FloatsOf(changed, "slab", "sigma_t");
    ASSERT_EQ(sigma.size(), 3u);
    EXPECT_NEAR(double(sigma[0]), 1.2, 1e-5);
    EXPECT_NEAR(double(sigma[2]), 0.3, 1e-5);
    EXPECT_EQ(FloatsOf(changed, "slab", "albedo"), (std::vector<float>{0.3f, 0.9f, 0.3f}));
    EXPECT_EQ(FloatsOf(changed, "metal", "uroughness"), (std::vector<float>{0.4f}));
    EXPECT_EQ(p.Needed(), (std::vector<std::string>{"coat", "slab", "metal", "varnish"}));
}

TEST(SceneParameters, ExtinctionAndThicknessOfASlabAreFactorsOfAProduct) {
    const SceneParameters p = Make("varnish", {"slab.thickness", "slab.sigma_t.r", "slab.sigma_t.b"});
    EXPECT_EQ(At(p, 0).productWith, "");
    EXPECT_EQ(At(p, 1).productWith, "slab.thickness");
    EXPECT_EQ(At(p, 2).productWith, "slab.thickness");
    EXPECT_EQ(At(Make("varnish", {"slab.sigma_t"}), 0).productWith, "");
}

TEST(SceneParameters, WhatIsNoNumberOfTheMaterialIsAnErrorThatNamesWhatIs) {
    const auto says = [](const std::string& problem, const std::vector<std::string>& parts) {
        for (const std::string& part : parts) EXPECT_NE(problem.find(part), std::string::npos) << problem;
    };
    says(Problem("varnish", {"cout.roughness"}), {"no material \"cout\"", "did you mean \"coat\"?"});
    says(Problem("varnish", {"coat.ruoghness"}),
         {"stack.pbrt:3:", "ruoghness", "did you mean \"roughness\"?"});
    says(Problem("varnish", {"roughness"}), {"expected MATERIAL.PARAMETER"});
    says(Problem("varnish", {"white.reflectance"}), {"no part of material \"varnish\"", "coat, slab, metal"});
    says(Problem("old", {"rough.roughness"}), {"stack.pbrt:8:", "is a texture"});
    says(Problem("old", {"rough.k"}), {"the spectrum \"metal-Cu-k\""});
    says(Problem("varnish", {"coat.remaproughness"}), {"is no number"});
    says(Problem("varnish", {"slab.sigma_t", "slab.sigma_t.r"}), {"are one number"});
    says(Problem("varnisch", {"coat.roughness"}), {"did you mean \"varnish\"?"});
}

TEST(SceneParameters, TheirMaterialsAreScenesAgain) {
    const SceneParameters p = Make("old", {"coat.roughness"});
    const std::string text = MaterialText(p.With(Vector{{0.123}}), p.Needed());
    const SceneDescription again = ParseText("WorldBegin\n" + text, "material.pbrt", "", nullptr);
    EXPECT_EQ(again.textures.size(), 1u);
    EXPECT_EQ(again.namedMaterials.size(), 4u);
    EXPECT_EQ(FloatsOf(again, "coat", "roughness"), (std::vector<float>{0.123f}));
    EXPECT_NO_THROW(BuildMaterial(again, "old", {}, nullptr));
}

std::vector<DirectionAngles> FewDirections() {
    return {{20, 0, 0, 0},    {20, 0, 20, 180}, {20, 0, 40, 180}, {50, 0, 10, 180}, {50, 0, 50, 180},
            {50, 0, 70, 180}, {50, 0, 30, 0},   {50, 0, 40, 90},  {5, 0, 15, 180}};
}

TEST(SceneReflectance, IsExactWhereTheMaterialHasAClosedForm) {
    const SceneParameters p = Make("paint", {"coat.roughness"});
    const SceneReflectance reflectance(p, FewDirections(), {}, {});
    ASSERT_TRUE(reflectance.IsExact());
    const Vector all = reflectance.Simulate(p.Start(), 1);
    EXPECT_EQ(all, reflectance.Simulate(p.Start(), 2));
    EXPECT_TRUE(all.tail(all.size() / 2).isZero());
    // As `lacquer bsdf` has it.
    const measure::SceneMaterial material =
        measure::LoadMaterial(ParseText(kStack, "stack.pbrt", "", nullptr), "paint");
    Rng rng(1);
    const measure::ColorMean expected = material.bsdf->Evaluate(
        measure::DirectionAt(40, 180), measure::DirectionAt(20, 0), TransportMode::Radiance, 1, rng);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(all[2 * 3 + c], expected.Mean()[c], 1e-6 * expected.Mean()[c]);
}

TEST(SceneReflectance, ErrorsAreThoseOfRepeatedEstimatesAndBitsDoNotDependOnThreads) {
    const SceneParameters p = Make("varnish", {"coat.roughness"});
    const SceneReflectance reflectance(p, FewDirections(), {}, {});
    ASSERT_FALSE(reflectance.IsExact());
    const Eigen::Index m = reflectance.NumValues();
    constexpr int kRepeats = 60;
    const Matrix logits = p.Space().ToLogit(p.Start()).replicate(1, kRepeats);
    Matrix first;
    for (const int threads : {1, 2, 7}) {
        const ThreadLimit limit(threads);
        const Matrix values = RunSimulator(reflectance, logits, 7).summaries;
        if (first.size() == 0) first = values;
        EXPECT_EQ(values, first) << threads;
    }
    const Matrix centered = first.leftCols(m).rowwise() - first.leftCols(m).colwise().mean();
    const double scatter = centered.squaredNorm() / (kRepeats - 1),
                 told = first.rightCols(m).squaredNorm() / kRepeats;
    // Squares of 27 values, by 60 repeats here and 180 degrees of freedom there; channels share their noise.
    EXPECT_NEAR(told / scatter, 1, 0.35);
    // With 16 times the samples errors are smaller: at least as those of independent samples are.
    const Vector more = reflectance.Measure(p.Start(), 9, 16);
    EXPECT_LT(more.tail(m).squaredNorm(), 0.15 * told);
    const Vector mean = first.leftCols(m).colwise().mean();
    for (Eigen::Index i = 0; i < m; ++i)
        EXPECT_NEAR(mean[i], more[i],
                    5 * (more[m + i] + std::sqrt(centered.col(i).squaredNorm()) / kRepeats) + 0.01 * mean[i]);
}

TEST(SceneReflectance, SingleWavelengthsMakeTheColours) {
    const SceneParameters p = Make("paint", {"coat.roughness"});
    const std::vector<DirectionAngles> one(2, {30, 0, 10, 180});
    const SceneReflectance spectral(p, one, {450, 650}, {}), colors(p, {one[0]}, {}, {});
    const Vector values = spectral.Simulate(p.Start(), 1), rgb = colors.Simulate(p.Start(), 1);
    // The base is reddish: .8, .6, .4.
    EXPECT_GT(values[1], 1.3 * values[0]);
    EXPECT_NEAR(values[0] / rgb[2], 1, 0.15);
    EXPECT_NEAR(values[1] / rgb[0], 1, 0.15);
}

/// 90 % interval of the coat's roughness from a measurement of a stack with some roughness and 3 % of noise.
struct Interval {
    double low, high;
};
Interval Estimated(double truth, uint64_t seed) {
    constexpr double kNoise = 0.03;
    const SceneParameters p = Make("varnish", {"coat.roughness", "slab.sigma_t"});
    const SceneReflectance reflectance(p, FewDirections(), {}, {});
    const ParameterSpace space = WithNoise(p.Space());
    const LobeCoordinates coordinates(p.Space(), 2);
    Vector x = p.Start();
    x[0] = truth;
    const Eigen::Index m = reflectance.NumValues();
    const Vector all = reflectance.Measure(x, Hash(seed, 1), 16);
    Random random(seed, 2);
    const Vector values = all.head(m).array() * (kNoise * random.Normals(m).array()).exp();
    const ObservedLobes observed = ObserveLobes(values, all.tail(m).cwiseQuotient(all.head(m)));
    const LobeOptions options{.seed = seed};
    const LobePosterior posterior = FindLobePosterior(reflectance, space, coordinates, observed,
                                                      RunLobePrior(reflectance, options), options);
    EXPECT_TRUE(posterior.hasConverged);
    std::vector<double> draws;
    for (const auto& y : posterior.draws.y.colwise()) draws.push_back(space.ToNatural(y)[0]);
    std::sort(draws.begin(), draws.end());
    return {draws[draws.size() / 20], draws[draws.size() - draws.size() / 20]};
}

TEST(LobePosterior, TellsStacksApartThatDifferByMoreThanTheNoiseAndNoOthers) {
    const Interval a = Estimated(0.2, SeedOf("stack a")), b = Estimated(0.23, SeedOf("stack b")),
                   c = Estimated(0.2005, SeedOf("stack c"));
    EXPECT_LT(a.high, b.low);  // 15 % of roughness are told apart
    EXPECT_GT(a.high, c.low);  // a quarter of a percent is not
    EXPECT_LT(a.low, c.high);
    EXPECT_LT(a.high - a.low, 0.02);
}

TEST(Measurement, IsReadInAnyOrderOfColumnsAndWrittenAgain) {
    const std::string path = testing::TempDir() + "measurement.csv";
    std::ofstream(path)
        << "# a comment\nr, "
           "g,b,theta_o,phi_o,theta_i,phi_i,sd\n1,2,3,10,180,20,0,.1\n\n.5,.25,.125,30,0,40,90,.2\n";
    const Measurement m = ReadMeasurement(path);
    ASSERT_EQ(m.NumRows(), 2);
    EXPECT_EQ(m.directions[1].thetaI, 40);
    EXPECT_EQ(m.directions[1].phiI, 90);
    EXPECT_EQ(m.values(1, 2), 0.125);
    EXPECT_EQ(m.Flat()[4], 0.25);
    EXPECT_EQ(m.RelativeDeviations()[5], 1.6);
    std::ofstream(path) << MeasurementCsv(m, true);
    const Measurement again = ReadMeasurement(path);
    EXPECT_EQ(again.values, m.values);
    EXPECT_EQ(again.deviations, m.deviations);
}

TEST(Measurement, TabsBesideCommasAreBlanks) {
    const std::string path = testing::TempDir() + "measurement.csv";
    std::ofstream(path)
        << "theta_i,\tphi_i,\ttheta_o,\tphi_o,\tr,\tg,\tb\n10,\t0,\t20,\t180,\t.1,\t.2,\t.3\n";
    EXPECT_EQ(ReadMeasurement(path).values(0, 2), 0.3);
}

TEST(MeasurementTable, PercentAreDoubted) {
    Measurement m;
    m.values = Eigen::MatrixXd::Constant(5, 3, 0.3);
    EXPECT_EQ(Doubt(m), "");
    m.values.topRows(2).setConstant(500);  // a highlight on a dark ground
    EXPECT_EQ(Doubt(m), "");
    m.values.setConstant(30);
    EXPECT_NE(Doubt(m).find("above 30, and a white sheet's is 0.32"), std::string::npos);
}

}  // namespace
}  // namespace lacquer::test::layered_scene_test
