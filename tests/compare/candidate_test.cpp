// What is compared: what each candidate changes of a scene, and what is said of those that render another
// image.
#include "compare/candidate.h"

#include <gtest/gtest.h>

#include "compare/experiment.h"
#include "pbrt/core/registry.h"
#include "pbrt/scene/parser.h"

namespace lacquer::compare::candidate_test {
namespace {

SceneDescription Room(const std::string& integrator, const std::string& world = "") {
    return ParseText(R"(
        LookAt 0 -4 1  0 0 0  0 0 1
        Camera "perspective" "float fov" 40
        Film "rgb" "integer xresolution" 16 "integer yresolution" 16
        Sampler "stratified" "integer xsamples" 3 "bool jitter" false
        Integrator )" + integrator +
                         R"(
        WorldBegin
        LightSource "infinite" "rgb L" [0.5 0.5 0.5]
        AttributeBegin
        AreaLightSource "diffuse" "rgb L" [5 4 3]
        Translate 1 -1 2
        Shape "sphere" "float radius" 0.5
        AttributeEnd
        Material "diffuse"
        Shape "sphere")" +
                         world,
                     "scene.pbrt", "", nullptr);
}

constexpr const char* kPath =
    R"("path" "integer maxdepth" 3 "string lightsampler" "power" "bool regularize" true)";

CandidateNotes NotesOn(const Candidate& candidate, const SceneDescription& scene) {
    return Examine(candidate, scene, BuildScene(scene, {}, nullptr));
}

Candidate Named(const std::string& name, Subject subject) { return {name, "", subject}; }

TEST(Candidate, IntegratorsKeepTheParametersThatTheyKnow) {
    SceneDescription scene = Room(kPath);
    EXPECT_TRUE(IsRegularized(scene));
    Apply(Named("bdpt", Subject::Integrators), &scene);
    EXPECT_EQ(scene.integrator.type, "bdpt");
    EXPECT_FALSE(IsRegularized(scene));
    // "lightsampler", which bdpt does not know, is no error.
    EXPECT_NO_THROW(BuildScene(scene, {}, nullptr));
    const Params params = MakeParams(scene.integrator, "integrator", scene.FilesOf(scene.integrator));
    EXPECT_EQ(params.GetInt("maxdepth", 5), 3);
    const CandidateNotes notes = NotesOn(Named("bdpt", Subject::Integrators), Room(kPath));
    EXPECT_EQ(notes.problem, "");
    EXPECT_EQ(notes.warnings, std::vector<std::string>{"has no parameter \"string lightsampler\""});
    EXPECT_TRUE(NotesOn(Named("volpath", Subject::Integrators), Room(kPath)).warnings.empty());
}

// The negative control: the scene's own integrator may not have parameters that it does not know.
TEST(Candidate, MistakesOfTheSceneStayErrors) {
    SceneDescription scene = Room(R"("path" "integer maxdepht" 3)");
    Apply(Named("path", Subject::Integrators), &scene);
    EXPECT_THROW(BuildScene(scene, {}, nullptr), SceneErrors);
}

TEST(Candidate, SamplersKeepNothingOfOthers) {
    SceneDescription scene = Room(kPath);
    Apply(Named("stratified", Subject::Samplers), &scene);
    EXPECT_EQ(scene.sampler.parameters.size(), 2u);
    Apply(Named("halton", Subject::Samplers), &scene);
    EXPECT_EQ(scene.sampler.type, "halton");
    EXPECT_TRUE(scene.sampler.parameters.empty());
}

TEST(Candidate, LightSamplersAreParametersOfTheIntegrator) {
    SceneDescription scene = Room(kPath);
    Apply(Named("uniform", Subject::LightSamplers), &scene);
    const Params params = MakeParams(scene.integrator, "integrator", scene.FilesOf(scene.integrator));
    EXPECT_EQ(params.GetString("lightsampler", ""), "uniform");
    EXPECT_EQ(NotesOn(Named("uniform", Subject::LightSamplers), scene).problem, "");
    EXPECT_NE(NotesOn(Named("uniform", Subject::LightSamplers), Room("\"bdpt\"")).problem, "");
}

TEST(Candidate, IntegratorsOfOtherImagesAreFound) {
    const auto problem = [](const char* name, const std::string& world) {
        return NotesOn(Named(name, Subject::Integrators), Room("\"volpath\"", world)).problem;
    };
    const std::string point = "\nLightSource \"point\"",
                      fog =
                          "\nMakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\n"
                          "MediumInterface \"fog\" \"\"\nMaterial \"interface\"\nShape \"sphere\"",
                      interface = "\nMaterial \"interface\"\nShape \"sphere\"",
                      skin = "\nMaterial \"subsurface\"\nShape \"sphere\"";
    for (const char* name : {"path", "volpath", "bdpt", "simplepath", "randomwalk", "lightpath", "mlt"})
        EXPECT_EQ(problem(name, ""), "") << name;
    EXPECT_NE(problem("ambientocclusion", ""), "");
    EXPECT_NE(problem("function", ""), "");
    EXPECT_NE(problem("simplevolpath", ""), "");
    EXPECT_NE(problem("randomwalk", point), "");
    EXPECT_EQ(problem("path", point), "");
    for (const char* name : {"path", "simplepath", "bdpt", "lightpath", "mlt", "randomwalk"})
        EXPECT_NE(problem(name, skin), "") << name;
    for (const char* name : {"path", "simplepath", "randomwalk"}) EXPECT_NE(problem(name, fog), "") << name;
    for (const char* name : {"volpath", "bdpt", "lightpath", "mlt"})
        EXPECT_EQ(problem(name, fog + point), "") << name;
    EXPECT_EQ(problem("volpath", skin), "");
    EXPECT_NE(problem("path", interface), "");
    EXPECT_EQ(problem("bdpt", interface), "");
}

ExperimentPlan Plan(Subject subject, const std::vector<std::string>& names, const std::string& reference) {
    ExperimentPlan plan;
    plan.scene = Room("\"path\" \"integer maxdepth\" 2");
    for (const std::string& name : names) plan.candidates.push_back(Named(name, subject));
    plan.budget.samplesPerPixel = 16;
    plan.runs = 4;
    plan.reference.candidate = Named(reference, subject);
    plan.reference.budget.samplesPerPixel = 1024;
    return plan;
}

std::vector<CandidateResult> Compare(const ExperimentPlan& plan) {
    Observer silent;
    Experiment experiment(plan, silent);
    const auto reference = experiment.RenderReference();
    std::vector<CandidateResult> results = experiment.Run(*reference);
    MeasureBoxes(&results, *reference, {{{0, 0}, {16, 16}}}, 0, false);
    return results;
}

// All converge to one image, and what is known of their noise shows: uniformly random directions have several
// times the error of next-event estimation, and independent samples more than stratified ones.
TEST(Candidate, IntegratorsOfOneImageAgreeAndDifferInNoise) {
    const auto results =
        Compare(Plan(Subject::Integrators, {"path", "bdpt", "simplepath", "randomwalk"}, "volpath"));
    for (const CandidateResult& r : results)
        EXPECT_LT(std::abs(r.boxes[0].bias->Z()), 4.5) << r.candidate.name;
    EXPECT_LT(results[3].boxes[0].rmseReduction.high, 0.7);
}

TEST(Candidate, SamplersOfOneSceneAgreeAndDifferInNoise) {
    const auto results = Compare(Plan(Subject::Samplers, {"independent", "zsobol", "halton"}, "stratified"));
    for (const CandidateResult& r : results)
        EXPECT_LT(std::abs(r.boxes[0].bias->Z()), 4.5) << r.candidate.name;
    EXPECT_GT(results[1].boxes[0].rmseReduction.low, 1.1);
}

// Of fourteen lights two give nearly all of the light: who draws them alike has more noise.
TEST(Candidate, LightSamplersOfOneSceneAgreeAndDifferInNoise) {
    ExperimentPlan plan = Plan(Subject::LightSamplers, {"uniform", "power"}, "bvh");
    std::string faint;
    for (int i = 0; i < 12; ++i)
        faint += "\nLightSource \"point\" \"point3 from\" [0 -3 3] \"float scale\" 0.0001";
    plan.scene = Room("\"path\" \"integer maxdepth\" 2", faint);
    const auto results = Compare(plan);
    for (const CandidateResult& r : results)
        EXPECT_LT(std::abs(r.boxes[0].bias->Z()), 4.5) << r.candidate.name;
    EXPECT_GT(results[1].boxes[0].rmseReduction.low, 1.15);
}

TEST(Candidate, DenoisersOfWhatHasNoHalvesAreFound) {
    const auto problem = [](const char* name, const char* integrator) {
        return NotesOn(Named(name, Subject::Denoisers), Room(integrator)).problem;
    };
    EXPECT_EQ(problem("nfor", "\"path\""), "");
    EXPECT_NE(problem("nfor", "\"bdpt\""), "");
    EXPECT_EQ(problem("none", "\"bdpt\""), "");
    EXPECT_EQ(problem("oidn", "\"bdpt\""), "");
}

// A denoised image has less error, but not an unbiased one: the part of it that all runs share is told, and
// no check of the mean, which says nothing about pixels. Noise alone shares nothing but for chance: the mean
// of 256 pixels' products of errors has a deviation of some 1 / sqrt(256 * 6) of the squared error, 0.03, and
// more where few pixels hold most of it.
TEST(Candidate, DenoisedRunsShareAnError) {
    ExperimentPlan plan = Plan(Subject::Denoisers, {"none", "nfor"}, "none");
    plan.budget.samplesPerPixel = 8;  // noise that somebody would see
    plan.scene = Room("\"path\" \"integer maxdepth\" 2");
    plan.scene.sampler.type = "independent";
    plan.scene.sampler.parameters.clear();
    const auto results = Compare(plan);
    const BoxResult &plain = results[0].boxes[0], &denoised = results[1].boxes[0];
    ASSERT_TRUE(plain.bias.has_value());
    EXPECT_LT(std::abs(plain.bias->Z()), 4.5);
    EXPECT_LT(plain.systematicShare, 0.15);
    EXPECT_FALSE(denoised.bias.has_value());
    EXPECT_GT(denoised.systematicShare, plain.systematicShare + 0.1);
    EXPECT_GT(denoised.rmseReduction.low, 1);
    EXPECT_LT(results[1].flips.at(0), results[0].flips.at(0));
    EXPECT_EQ(results[1].stages.size(), 0u);
    for (const RunRecord& run : results[1].records) {
        EXPECT_GT(run.denoiseSeconds, 0);
        EXPECT_GT(run.seconds, run.denoiseSeconds);
    }
    EXPECT_EQ(results[0].records[0].denoiseSeconds, 0);
}

// Within a time, denoising is part of it.
TEST(Candidate, TimeOfDenoisersCounts) {
    ExperimentPlan plan = Plan(Subject::Denoisers, {"none", "nfor"}, "none");
    plan.budget = {.seconds = 1.0, .samplesPerPixel = 0};
    plan.runs = 1;
    Observer silent;
    plan.denoiseSeconds = Experiment(plan, silent).TimeDenoisers();
    ASSERT_EQ(plan.denoiseSeconds.size(), 2u);
    EXPECT_EQ(plan.denoiseSeconds[0], 0);
    EXPECT_GT(plan.denoiseSeconds[1], 0);
    Experiment experiment(plan, silent);
    const auto reference = experiment.RenderReference();
    const auto results = experiment.Run(*reference);
    const RunRecord& denoised = results[1].records[0];
    EXPECT_GT(denoised.denoiseSeconds, 0);
    EXPECT_GT(denoised.seconds, denoised.denoiseSeconds);
    // A time that denoising alone takes is an error, before hours of references.
    plan.budget.seconds = 1e-6;
    EXPECT_THROW(Experiment(plan, silent).TimeDenoisers(), OverrideError);
}

}  // namespace
}  // namespace lacquer::compare::candidate_test
