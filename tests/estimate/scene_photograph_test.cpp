// Photographs of scenes as data: what is simulated is what a camera of the scene sees, and posteriors hold
// the truth.
#include "estimate/scene/scene_photograph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "estimate/layered/lobe_posterior.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"
#include "support/statistics.h"

namespace lacquer::test::scene_photograph_test {
namespace {

using namespace estimate;

constexpr const char* kMaterials = R"(
MakeNamedMaterial "coat" "string type" "dielectric" "float roughness" [0.3] "bool remaproughness" false
MakeNamedMaterial "clear" "string type" "slab" "float eta" [1.5] "rgb sigma_t" [.1 .2 .3]
MakeNamedMaterial "white" "string type" "diffuse" "rgb reflectance" [.8 .6 .4]
MakeNamedMaterial "paint" "string type" "layered" "string stack" ["coat" "clear" "white"]
NamedMaterial "paint"
)";
constexpr const char* kCamera = R"(LookAt 0 -4 1  0 0 0  0 0 1
Camera "perspective" "float fov" 34
PixelFilter "box"
Film "rgb" "integer xresolution" 36 "integer yresolution" 36
WorldBegin
LightSource "distant" "point3 from" [-2 -3 3] "point3 to" [0 0 0] "rgb L" [2 2 2]
LightSource "infinite" "rgb L" [.3 .35 .4]
)";
constexpr const char* kSphere = R"(Shape "sphere"
)";
constexpr const char* kPlane = R"(Shape "bilinearmesh" "point3 P" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]
)";

SceneParameters Make(const char* shape, const std::vector<std::string>& names) {
    return SceneParameters(ParseText(std::string(kCamera) + kMaterials + shape, "ball.pbrt", "", nullptr),
                           "paint", names, {});
}

/// What a camera of the scene sees, by many samples.
Image Photographed(const SceneParameters& p, const Vector& x, Int2 resolution = Int2(36)) {
    BuildOptions build;
    build.samplesPerPixel = 64;
    build.film.resolution = resolution;
    const RenderSetup setup = BuildScene(p.With(x), build, nullptr);
    RenderOptions options;
    options.endSample = setup.sampler->SamplesPerPixel();
    options.seed = 12345;
    Observer nobody;
    Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, nobody);
    return *setup.film->Develop();
}

ScenePhotograph Simulator(const SceneParameters& p, const Image& photograph) {
    return ScenePhotograph(p, photograph, "photo.exr", {.blocks = 6, .samples = 16});
}

/// Mean square of differences between the photograph and simulations, in standard errors of the means of
/// these.
double Chi2(const SceneParameters& p, const Image& photograph, const Vector& x) {
    const ScenePhotograph simulator = Simulator(p, photograph);
    const Eigen::Index m = simulator.Observed().size();
    constexpr int kRepeats = 12;
    Matrix values(kRepeats, m);
    for (int k = 0; k < kRepeats; ++k) values.row(k) = simulator.Simulate(x, Hash(uint64_t(99), k)).head(m);
    const Vector mean = values.colwise().mean();
    const Vector variances =
        (values.rowwise() - mean.transpose()).colwise().squaredNorm() / (kRepeats * (kRepeats - 1));
    // Of the photograph itself, which has as many samples as four repeats, and of what is constant.
    const Eigen::ArrayXd all = variances.array() * (1 + kRepeats / 4.) + (1e-4 * mean.array()).square();
    return ((mean - simulator.Observed()).array().square() / all).mean();
}

TEST(ScenePhotograph, SimulatesWhatTheCameraSeesOfASphereAndOfAPlane) {
    for (const char* shape : {kSphere, kPlane}) {
        const SceneParameters p = Make(shape, {"coat.roughness"});
        // The photograph may have more pixels than a simulation.
        const Image photograph = Photographed(p, p.Start(), Int2(72));
        EXPECT_LT(Chi2(p, photograph, p.Start()), 1.5) << shape;
        EXPECT_GT(Chi2(p, photograph, Vector{{0.5}}), 3) << shape;
    }
}

TEST(ScenePhotograph, BlocksAreMeansInRowsOfTheImage) {
    Image image({8, 4}, {"R", "G", "B"});
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 8; ++x)
            for (int c = 0; c < 3; ++c) image.Set({x, y}, c, float(100 * c + 10 * (y / 2) + x / 2));
    const ImageBlocks blocks = BlocksOf({8, 4}, 4);
    ASSERT_EQ(blocks.count, Int2(4, 2));
    const Vector means = blocks.MeansOf(image);
    ASSERT_EQ(means.size(), 24);
    EXPECT_DOUBLE_EQ(means[3 * 2 + 1], 102);        // third of the first row, green
    EXPECT_DOUBLE_EQ(means[3 * (4 + 3) + 2], 213);  // last of the second row, blue
}

TEST(ScenePhotograph, TheExposureMultipliesWhatIsSeenAndNothingElse) {
    const SceneParameters p = Make(kPlane, {"coat.roughness", kExposureName});
    ASSERT_EQ(p.Exposure(), 1u);
    EXPECT_EQ(p.Start()[1], 1);
    const ScenePhotograph simulator = Simulator(p, Photographed(p, p.Start()));
    const Vector one = simulator.Simulate(Vector{{0.3, 1}}, 5), two = simulator.Simulate(Vector{{0.3, 2}}, 5);
    EXPECT_LT((two - 2 * one).cwiseAbs().maxCoeff(), 1e-12);
    const SceneParameters without = Make(kPlane, {"coat.roughness"});
    EXPECT_FALSE(without.Exposure());
    EXPECT_EQ(Simulator(without, Photographed(p, p.Start())).Simulate(Vector{{0.3}}, 5), one);
}

TEST(ScenePhotograph, WhatCannotBeThePhotographIsAnErrorThatSaysWhy) {
    const SceneParameters p = Make(kPlane, {"coat.roughness"});
    const auto problem = [&](const Image& image) -> std::string {
        try {
            Simulator(p, image);
        } catch (const SceneError& e) {
            return e.what();
        }
        return "";
    };
    const auto filled = [](Int2 resolution, float value) {
        Image image(resolution, {"R", "G", "B"});
        for (int y = 0; y < resolution.y; ++y)
            for (int x = 0; x < resolution.x; ++x)
                for (int c = 0; c < 3; ++c) image.Set({x, y}, c, value);
        return image;
    };
    EXPECT_EQ(problem(filled({24, 24}, 1)), "");
    EXPECT_NE(problem(filled({24, 12}, 1)).find("photo.exr"), std::string::npos);
    EXPECT_NE(problem(filled({24, 12}, 1)).find("24 x 12 pixels; expected the ratio of the scene's film"),
              std::string::npos);
    EXPECT_NE(problem(filled({3, 3}, 1)).find("expected at least 6 x 6"), std::string::npos);
    EXPECT_NE(problem(filled({24, 24}, std::nanf(""))).find("not finite"), std::string::npos);
}

/// Deviations between the truth and the middle of the posterior of each parameter, in its own deviations.
std::vector<double> Scores(double gain, const std::vector<std::string>& names, uint64_t seed, Vector* sds) {
    const SceneParameters p = Make(kSphere, names);
    Image photograph = Photographed(p, p.Start());
    for (int y = 0; y < 36; ++y)
        for (int x = 0; x < 36; ++x)
            for (int c = 0; c < 3; ++c) photograph.Set({x, y}, c, float(gain) * photograph.Get({x, y}, c));
    const ScenePhotograph simulator = Simulator(p, photograph);
    const ParameterSpace space = WithNoise(p.Space(), {0, 0.1, 0.01, 1});
    const LobeCoordinates coordinates(p.Space(), Eigen::Index(names.size()));
    const Vector& values = simulator.Observed();
    const LobeOptions options{.seed = seed, .errsTogether = true, .leastWidth = 6};
    const LobePosterior posterior =
        FindLobePosterior(simulator, space, coordinates, ObserveLobes(values, Vector::Zero(values.size())),
                          RunLobePrior(simulator, options), options);
    Matrix draws = posterior.draws.y;
    for (auto y : draws.colwise()) y = space.ToNatural(y).eval();
    const Vector mean = draws.rowwise().mean();
    *sds = ((draws.colwise() - mean).rowwise().squaredNorm() / double(draws.cols())).cwiseSqrt();
    std::vector<double> scores;
    for (size_t i = 0; i < names.size(); ++i) {
        const double truth = names[i] == kExposureName ? gain : p.Start()[Eigen::Index(i)];
        scores.push_back((mean[Eigen::Index(i)] - truth) / (*sds)[Eigen::Index(i)]);
    }
    return scores;
}

TEST(ScenePhotographLong, PosteriorsHoldTheTruthAndTheExposureOnlyIfItIsFree) {
    Vector sds;
    const std::vector<double> free = Scores(1.3, {"coat.roughness", kExposureName}, SeedOf("exposure"), &sds);
    for (const double score : free) EXPECT_LT(std::abs(score), 4);
    EXPECT_LT(sds[0], 0.03);
    EXPECT_LT(sds[1], 0.1);
    const std::vector<double> fixed = Scores(1.3, {"coat.roughness"}, SeedOf("exposure"), &sds);
    EXPECT_GT(std::abs(fixed[0]), 4);
}

}  // namespace
}  // namespace lacquer::test::scene_photograph_test
