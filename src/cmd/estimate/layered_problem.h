// What `lacquer estimate --scene` works on: a material with free parameters, and what was measured of it.
#pragma once

#include <memory>
#include <string>

#include "cmd/estimate/estimate_arguments.h"
#include "estimate/layered/lobe_posterior.h"
#include "estimate/layered/measurement.h"
#include "estimate/scene/scene_parameters.h"
#include "estimate/scene/scene_photograph.h"
#include "estimate/scene/scene_reflectance.h"
#include "pbrt/core/progress.h"

namespace lacquer::cmd {

/// The objects refer to each other: it stays where it is.
struct LayeredProblem {
    std::unique_ptr<estimate::SceneParameters> parameters;
    /// One of the two: a goniometer's directions, or a photograph of the scene.
    std::unique_ptr<estimate::SceneReflectance> reflectance;
    std::unique_ptr<estimate::ScenePhotograph> photograph;
    std::unique_ptr<estimate::ParameterSpace> space;  ///< with the noise
    std::unique_ptr<estimate::LobeCoordinates> coordinates;
    estimate::Measurement measurement;  ///< of a goniometer

    const estimate::Simulator& Simulator() const {
        return reflectance ? static_cast<const estimate::Simulator&>(*reflectance) : *photograph;
    }
    bool IsExact() const { return reflectance && reflectance->IsExact(); }
    /// What was measured.
    estimate::ObservedLobes Observed() const;
    /// Names of the values alone.
    std::vector<std::string> ValueNames() const;
};

/// The scene and its free parameters. Errors: usage, also for names that the scene does not have; SceneError,
/// FileError.
LayeredProblem ReadLayeredScene(const EstimateArguments& arguments, Observer* observer);
/// Adds the directions of a measurement. Errors: SceneError for too few rows; usage for a free exposure.
void SetMeasurement(const EstimateArguments& arguments, estimate::Measurement measurement,
                    LayeredProblem* problem);
/// The data that the arguments name: a photograph by the extensions of images, else a goniometer's file.
/// Errors: SceneError, FileError.
void ReadData(const EstimateArguments& arguments, LayeredProblem* problem);
bool IsPhotograph(const EstimateArguments& arguments);
/// A goniometer's file, by its name: CSV, or RGL's .bsdf. Errors: SceneError, FileError.
estimate::Measurement ReadMeasured(const std::string& path, uint64_t seed);
/// Usage errors of options that have no effect on layers.
void CheckLayeredArguments(const EstimateArguments& arguments);
estimate::LobeOptions LobeOptionsOf(const EstimateArguments& arguments);

}  // namespace lacquer::cmd
