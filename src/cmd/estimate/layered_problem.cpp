#include "cmd/estimate/layered_problem.h"

#include <fmt/format.h>

#include <map>

#include "cmd/command_support.h"
#include "pbrt/image/image_file.h"
#include "pbrt/scene/parser.h"

namespace lacquer::cmd {

using namespace estimate;

std::vector<std::string> LayeredProblem::ValueNames() const {
    const std::vector<std::string>& all = Simulator().SummaryNames();
    return {all.begin(), all.begin() + std::ptrdiff_t(all.size() / 2)};
}

void CheckLayeredArguments(const EstimateArguments& a) {
    const auto refuse = [](bool isGiven, const char* option, const char* why) {
        RefuseIneffective(isGiven, option, std::string("with --scene: ") + why);
    };
    const char* const camera = "the scene has the camera and its film";
    refuse(a.size.has_value(), "--size", camera);
    refuse(a.distance.has_value(), "--distance", camera);
    refuse(a.fieldOfView.has_value(), "--fov", camera);
    refuse(!a.crop.empty(), "--crop", camera);
    refuse(a.tone != EstimateArguments().tone, "--tone", "photographs of scenes are linear");
    refuse(!a.model.empty(), "--model", "the scene is the model");
    refuse(!a.fixed.empty(), "--fix", "what --free does not name is as the scene has it");
    refuse(!a.summaries.empty() || !a.vgg.empty(), "--summaries", "reflectances are compared themselves");
    refuse(a.mapOnly, "--map-only", "the distribution takes seconds");
    refuse(a.explain, "--explain", "the report says which measurement would tell most");
    refuse(a.method != "emulated", "--method", "the material decides");
    refuse(a.error != "calibrated", "--error", "the noise is estimated");
    refuse(a.sampler == "mala-published", "--sampler mala-published", "expected hmc or mala");
    if (a.free.empty())
        throw CLI::ValidationError(
            "--free is required with --scene: MATERIAL.PARAMETER,... such as coat.roughness,varnish.sigma_t");
}

LobeOptions LobeOptionsOf(const EstimateArguments& a) {
    LobeOptions options;
    options.seed = a.seed;
    options.isRobust = a.robust;
    if (IsPhotograph(a)) {
        // Channels of a block are seen by the same paths, so that three of these widths are about one error.
        options.errsTogether = true;
        options.leastWidth = 6;
    }
    return options;
}

/// A type that no material has is a mistake of the scene: it is told at its place, before options are looked
/// up among what is there. Errors: SceneError, SceneErrors.
void CheckMaterialTypes(const SceneDescription& scene) {
    const auto check = [&](const MaterialEntity& entity, const std::string& name) {
        if (!Registry<MaterialKind>::Find(entity.type)) BuildMaterial(scene, name, {}, nullptr);
    };
    for (const MaterialEntity& entity : scene.namedMaterials) check(entity, entity.name);
    for (size_t i = 0; i < scene.materials.size(); ++i) check(scene.materials[i], fmt::format("@{}", i));
}

LayeredProblem ReadLayeredScene(const EstimateArguments& a, Observer* observer) {
    SceneDescription scene = ParseFile(a.scene, observer);
    CheckMaterialTypes(scene);
    if (!IsPhotograph(a)) {
        // Of the rest nothing is needed, and the description is copied for each simulation.
        scene.shapes.clear();
        scene.objects.clear();
        scene.instances.clear();
        scene.lights.clear();
    }
    std::map<std::string, Prior> priors;
    for (const std::string& option : a.priors) priors.insert(NamedPriorOf(option));
    Prior ofNoise = kNoisePrior;
    // No photograph fits a scene better: lens, lights and shape are never those of the scene.
    if (IsPhotograph(a)) ofNoise.low = 0.01;
    if (const auto noise = priors.find(kNoiseName); noise != priors.end()) {
        if (!(noise->second.low > 0))
            throw CLI::ValidationError("--prior noise: expected LOW > 0: nothing is measured without noise");
        ofNoise = noise->second;
        priors.erase(noise);
    }
    if (const auto gain = priors.find(estimate::kExposureName);
        gain != priors.end() && !(gain->second.low > 0))
        throw CLI::ValidationError(
            "--prior exposure: expected LOW > 0: a photograph is brighter than nothing");
    LayeredProblem problem;
    try {
        const std::string material = a.material.empty() ? OnlyLayeredMaterial(scene) : a.material;
        problem.parameters = std::make_unique<SceneParameters>(std::move(scene), material, a.free, priors);
    } catch (const SceneError& e) {
        throw OptionError(e);
    } catch (const std::invalid_argument& e) {
        throw CLI::ValidationError(e.what());
    }
    problem.space = std::make_unique<ParameterSpace>(WithNoise(problem.parameters->Space(), ofNoise));
    problem.coordinates = std::make_unique<LobeCoordinates>(problem.parameters->Space(),
                                                            Eigen::Index(problem.parameters->Space().Size()));
    return problem;
}

void SetMeasurement(const EstimateArguments& a, Measurement measurement, LayeredProblem* problem) {
    if (problem->parameters->Exposure())
        throw CLI::ValidationError(
            "--free exposure: photographs have one; reflectances are measured as they are");
    const size_t needed = 3 * problem->parameters->Space().Size();
    const auto rows = size_t(measurement.NumRows());
    if (rows < needed)
        throw SceneError(
            {a.photo},
            fmt::format("has {} rows; expected at least {}, three for each free parameter", rows, needed));
    problem->reflectance = std::make_unique<SceneReflectance>(*problem->parameters, measurement.directions,
                                                              measurement.wavelengths,
                                                              SceneReflectance::Options{.seed = a.seed});
    problem->measurement = std::move(measurement);
}

bool IsPhotograph(const EstimateArguments& a) {
    const std::string extension = ExtensionOf(a.photo);
    return extension == "exr" || extension == "pfm" || extension == "hdr";
}

void ReadData(const EstimateArguments& a, LayeredProblem* problem) {
    if (!IsPhotograph(a)) {
        SetMeasurement(a, ReadMeasured(a.photo, a.seed), problem);
        return;
    }
    const Image image = ReadImage(a.photo, {}, {});
    if (!image.HasRGB()) throw SceneError({a.photo}, "has no channels R, G, B");
    problem->photograph =
        std::make_unique<ScenePhotograph>(*problem->parameters, image, a.photo, ScenePhotograph::Options());
    const size_t needed = 3 * problem->parameters->Space().Size();
    if (size_t(problem->photograph->Observed().size()) < needed)
        throw SceneError(
            {a.photo},
            fmt::format("has {} values that are bright enough; expected at least {}, three for each "
                        "free parameter",
                        problem->photograph->Observed().size(), needed));
}

ObservedLobes LayeredProblem::Observed() const {
    if (photograph) {
        const Vector& values = photograph->Observed();
        return ObserveLobes(values, Vector::Zero(values.size()));
    }
    return ObserveLobes(measurement.Flat(), measurement.RelativeDeviations());
}

Measurement ReadMeasured(const std::string& path, uint64_t seed) {
    if (!path.ends_with(".bsdf")) return ReadMeasurement(path);
    // As a scene whose only material is the file.
    SceneDescription scene;
    MaterialEntity measured;
    measured.name = "measured";
    measured.type = "measured";
    measured.colorSpace = &ColorSpace::SRGB();
    lacquer::Parameter filename;
    filename.type = "string";
    filename.name = "filename";
    filename.kind = lacquer::Parameter::Values::Strings;
    filename.strings = {path};
    measured.parameters = {filename};
    scene.namedMaterials = {measured};
    scene.resolvers = {FileResolver()};
    const Measurement all = MeasureMaterial(scene, measured.name, LobeDirections(), seed);
    Measurement kept = all;
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < all.NumRows(); ++i)
        if (all.values.row(i).minCoeff() > 0) rows.push_back(i);
    kept.values = all.values(rows, Eigen::all);
    kept.deviations = Matrix::Zero(kept.values.rows(), kept.values.cols());
    kept.directions.clear();
    for (const Eigen::Index i : rows) kept.directions.push_back(all.directions[size_t(i)]);
    return kept;
}

}  // namespace lacquer::cmd
