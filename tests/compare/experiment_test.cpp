#include "compare/experiment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>

#include "compare/fingerprint.h"
#include "pbrt/scene/parser.h"

namespace lacquer::compare::experiment_test {
namespace {

/// A ball with a coat under a distant light, 24 x 24 pixels.
SceneDescription CoatedBall(const std::string& sampler = "\"independent\"") {
    return ParseText(R"(
        LookAt 0 -4 0  0 0 0  0 0 1
        Camera "perspective" "float fov" 32
        Film "rgb" "integer xresolution" 24 "integer yresolution" 24
        Sampler )" + sampler +
                         R"(
        Integrator "path" "integer maxdepth" 2
        WorldBegin
        LightSource "distant" "point3 from" [-1 -2 2] "point3 to" [0 0 0]
        LightSource "infinite" "rgb L" [0.2 0.2 0.2]
        MakeNamedMaterial "top" "string type" "dielectric" "float roughness" 0.3 "bool remaproughness" false
        MakeNamedMaterial "clear" "string type" "slab" "float eta" 1.5
        MakeNamedMaterial "bottom" "string type" "conductor" "float roughness" 0.2 "bool remaproughness" false
        MakeNamedMaterial "coated" "string type" "layered" "string stack" ["top" "clear" "bottom"]
        NamedMaterial "coated"
        Shape "sphere")",
                     "scene.pbrt", "", nullptr);
}

ExperimentPlan Plan(int samples, int runs) {
    ExperimentPlan plan;
    plan.scene = CoatedBall();
    plan.candidates = {{"bidirectional"}, {"halfvector"}};
    plan.budget.samplesPerPixel = samples;
    plan.runs = runs;
    plan.reference.candidate = Candidate{"halfvector"};
    plan.reference.budget.samplesPerPixel = 512;
    return plan;
}

const Bounds2i kBall{{4, 4}, {20, 20}};

bool SameBits(const Image& a, const Image& b) {
    return std::memcmp(a.Pixels().data(), b.Pixels().data(), a.Pixels().size() * sizeof(float)) == 0;
}

TEST(Experiment, RunsAreIndependentAndCounted) {
    const ExperimentPlan plan = Plan(8, 3);
    Observer silent;
    Experiment experiment(plan, silent);
    const auto reference = experiment.RenderReference();
    ASSERT_TRUE(reference);
    EXPECT_TRUE(reference->NoiseIsKnown());
    EXPECT_EQ(reference->samplesPerPixel, 512);
    std::vector<CandidateResult> results = experiment.Run(*reference);
    std::set<int> seeds;
    for (const CandidateResult& r : results) {
        ASSERT_EQ(r.images.size(), 3u);
        for (const RunRecord& record : r.records) {
            EXPECT_TRUE(seeds.insert(record.seed).second);
            EXPECT_EQ(record.samplesPerPixel, 8);
            EXPECT_GT(record.seconds, 0);
            EXPECT_GT(record.loadSeconds, 0);
        }
        EXPECT_FALSE(SameBits(r.images[0], r.images[1]));
        // Passes of an untimed render end at 8 first.
        ASSERT_EQ(r.stages.size(), 1u);
        EXPECT_EQ(r.stages[0].samples, 8);
        EXPECT_EQ(r.stages[0].runs, 3);
    }
    MeasureBoxes(&results, *reference, {kBall}, 0, false);
    // What a stage says at the end is what the whole says.
    const BoxResult& box = results[1].boxes[0];
    EXPECT_NEAR(RmseOfSums(results[1].stages[0].squares, 24, kBall, 3, 0), box.rmse.value,
                1e-4 * box.rmse.value);
    for (const CandidateResult& r : results) EXPECT_LT(std::abs(r.boxes[0].bias->Z()), 4.5);
}

// Samplers that the scene fixes or does not randomise would repeat one image in all runs.
TEST(Experiment, RunsDifferWhateverTheSamplerSays) {
    for (const char* sampler :
         {"\"independent\" \"integer seed\" 7", "\"sobol\" \"string randomization\" \"none\"",
          "\"stratified\" \"bool jitter\" false", "\"zsobol\"", "\"halton\""}) {
        ExperimentPlan plan = Plan(4, 2);
        plan.scene = CoatedBall(sampler);
        Observer silent;
        Reference black;
        black.image = Image({24, 24}, {"R", "G", "B"});
        const auto results = Experiment(plan, silent).Run(black);
        EXPECT_FALSE(SameBits(results[0].images[0], results[0].images[1])) << sampler;
        EXPECT_FALSE(SameBits(results[0].images[0], results[1].images[0])) << sampler;
    }
}

// The end of it all: the ratio of an estimator to itself with four times the samples is 2. With 3 runs of 256
// pixels its standard error is below 0.1.
TEST(Experiment, FourTimesTheSamplesHalveTheError) {
    const ExperimentPlan few = Plan(16, 3), many = Plan(64, 3);
    Observer silent;
    const auto reference = Experiment(few, silent).RenderReference();
    std::vector<CandidateResult> a = Experiment(few, silent).Run(*reference);
    std::vector<CandidateResult> b = Experiment(many, silent).Run(*reference);
    const Runs fewRuns{&a[1].images[0], &a[1].images[1], &a[1].images[2]};
    const Runs manyRuns{&b[1].images[0], &b[1].images[1], &b[1].images[2]};
    const BoxResult r = MeasureBox(kBall, *reference, {fewRuns, manyRuns}, 0, 1)[1];
    EXPECT_NEAR(r.rmseReduction.value, 2, 0.35);
}

// A material with less light inside than the reference's is a biased estimator of it.
TEST(Experiment, LeftOutPathsAreFoundAsBias) {
    ExperimentPlan plan = Plan(64, 3);
    Observer silent;
    const auto reference = Experiment(plan, silent).RenderReference();
    Apply(ParseVariation("coated.integer maxdepth=1"), "1", &plan.scene);
    std::vector<CandidateResult> results = Experiment(plan, silent).Run(*reference);
    MeasureBoxes(&results, *reference, {kBall}, 0, false);
    for (const CandidateResult& r : results) EXPECT_LT(r.boxes[0].bias->Z(), -3.5);
}

TEST(Experiment, TimeBudgetsAreKept) {
    ExperimentPlan plan = Plan(0, 1);
    plan.budget.seconds = 0.3;
    plan.candidates.resize(1);
    Observer silent;
    Reference black;
    black.image = Image({24, 24}, {"R", "G", "B"});
    const auto results = Experiment(plan, silent).Run(black);
    EXPECT_NEAR(results[0].records[0].seconds, 0.3, 0.2);
    EXPECT_GT(results[0].records[0].samplesPerPixel, 2);
    // 1, 2, 4, ...
    for (size_t i = 0; i < results[0].stages.size(); ++i) EXPECT_EQ(results[0].stages[i].samples, 1 << i);
}

/// Stops after some work.
class Impatient final : public Observer {
  public:
    void Begin(const std::string&, int64_t, const std::string&) override { ++renders; }
    bool ShouldStop() override { return renders > 4; }
    int renders = 0;
};

TEST(Experiment, AStopKeepsWhatIsFinished) {
    ExperimentPlan plan = Plan(4, 10);
    Impatient observer;
    Reference black;
    black.image = Image({24, 24}, {"R", "G", "B"});
    std::vector<CandidateResult> results = Experiment(plan, observer).Run(black);
    EXPECT_LE(results[0].images.size(), 3u);
    EXPECT_GE(results[0].images.size(), 1u);
    KeepWholeRounds(&results);
    EXPECT_EQ(results[0].images.size(), results[1].images.size());
}

TEST(Variation, ReadsAndSets) {
    const Variation v = ParseVariation("top.roughness=0.1,0.25");
    EXPECT_EQ(v.target, "top.roughness");
    EXPECT_EQ(v.values, (std::vector<std::string>{"0.1", "0.25"}));
    SceneDescription scene = CoatedBall();
    Apply(v, "0.25", &scene);
    int found = 0;
    for (const MaterialEntity& m : scene.namedMaterials)
        if (m.name == "top")
            for (const Parameter& p : m.parameters)
                if (p.name == "roughness") {
                    ++found;
                    EXPECT_EQ(p.floats, std::vector<float>{0.25f});
                }
    EXPECT_EQ(found, 1);
}

TEST(Variation, NamesMayHoldDots) {
    SceneDescription scene = CoatedBall();
    scene.namedMaterials[0].name = "top.of";
    Apply(ParseVariation("top.of.interface.roughness=0.5"), "0.5", &scene);
    Apply(ParseVariation("top.of.integer maxdepth=3"), "3", &scene);
    const std::vector<Parameter>& parameters = scene.namedMaterials[0].parameters;
    ASSERT_GE(parameters.size(), 2u);
    const Parameter &first = parameters[parameters.size() - 2], &second = parameters.back();
    EXPECT_EQ(first.type + " " + first.name, "float interface.roughness");
    EXPECT_EQ(second.type + " " + second.name, "integer maxdepth");
    EXPECT_EQ(second.integers, std::vector<int>{3});
}

TEST(Variation, SetsValuesOfEveryType) {
    const std::map<std::string, std::string> values = {{"float", "0.5"},
                                                       {"integer", "3"},
                                                       {"bool", "true"},
                                                       {"string", "two words"},
                                                       {"texture", "bricks"},
                                                       {"point2", "1 2"},
                                                       {"vector2", "1 2"},
                                                       {"point3", "1 2 3"},
                                                       {"vector3", "1 2 3"},
                                                       {"normal", "1 2 3"},
                                                       {"rgb", ".1 .2 .3"},
                                                       {"blackbody", "5000"},
                                                       {"spectrum", "400 1 700 .5"}};
    for (const ParameterType& type : ParameterTypes()) {
        SceneDescription scene = CoatedBall();
        const std::string& value = values.at(type.name);
        Apply(ParseVariation("top." + std::string(type.name) + " x=" + value), value, &scene);
        for (const MaterialEntity& m : scene.namedMaterials)
            if (m.name == "top") {
                const Parameter& p = m.parameters.back();
                EXPECT_EQ(p.kind, type.values) << type.name;
                EXPECT_EQ(p.NumValues(), type.components * (p.type == "spectrum" ? 2 : 1)) << type.name;
            }
    }
    SceneDescription scene = CoatedBall();
    Apply(ParseVariation("top.spectrum x=metal-Au-eta"), "metal-Au-eta", &scene);
    const auto top = std::find_if(scene.namedMaterials.begin(), scene.namedMaterials.end(),
                                  [](const MaterialEntity& m) { return m.name == "top"; });
    EXPECT_EQ(top->parameters.back().strings, std::vector<std::string>{"metal-Au-eta"});
}

TEST(Variation, SaysWhatIsWrong) {
    for (const char* text : {"", "top", "top=1", ".roughness=1", "top.=1", "top.roughness",
                             "top.roughness=", "top.roughness=1,,2", "top.roughness=1,"})
        EXPECT_THROW(ParseVariation(text), std::invalid_argument) << text;
    SceneDescription scene = CoatedBall();
    for (const auto& [text, expected] :
         {std::pair("topp.roughness=1", "did you mean \"top\""),
          std::pair("top.roughness=rough", "\"rough\" is not a number"),
          std::pair("coated.integer maxdepth=1.5", "\"1.5\" is not an integer"),
          std::pair("coated.bool twosided=perhaps", "\"perhaps\" is not true or false"),
          std::pair("top.rgb tint=1", "has 1 values; \"rgb tint\" needs 3"),
          std::pair("top.flaot roughness=1", "did you mean \"float\"")}) {
        const Variation v = ParseVariation(text);
        try {
            Apply(v, v.values[0], &scene);
            ADD_FAILURE() << text;
        } catch (const std::invalid_argument& e) {
            EXPECT_NE(std::string(e.what()).find(expected), std::string::npos) << e.what();
        }
    }
}

TEST(Fingerprint, TellsScenesApartButNotTheirPlaces) {
    const uint64_t one = FingerprintOf(CoatedBall());
    EXPECT_EQ(one, FingerprintOf(CoatedBall()));
    EXPECT_NE(one, FingerprintOf(CoatedBall("\"halton\"")));
    SceneDescription varied = CoatedBall();
    Apply(ParseVariation("top.roughness=0.31"), "0.31", &varied);
    EXPECT_NE(one, FingerprintOf(varied));
    SceneDescription moved = CoatedBall();
    moved.shapes[0].worldFromObject.start = Transform::Translate({0, 0, 1});
    EXPECT_NE(one, FingerprintOf(moved));
    SceneDescription elsewhere = CoatedBall();
    for (MaterialEntity& m : elsewhere.namedMaterials) m.loc.file = "include.pbrt";
    EXPECT_EQ(one, FingerprintOf(elsewhere));
}

}  // namespace
}  // namespace lacquer::compare::experiment_test
