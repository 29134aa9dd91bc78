#include "cmd/plugins_command.h"

#include <fmt/format.h>

#include "layered/estimator.h"
#include "pbrt/base/camera.h"
#include "pbrt/base/film.h"
#include "pbrt/base/integrator.h"
#include "pbrt/base/light.h"
#include "pbrt/base/material.h"
#include "pbrt/base/medium.h"
#include "pbrt/base/sampler.h"
#include "pbrt/base/shape.h"
#include "pbrt/film/sensor.h"
#include "pbrt/scene/builder.h"

namespace lacquer {

namespace {

void Print(const char* kind, const std::vector<std::string>& names) {
    for (const std::string& name : names) fmt::print("{}\t{}\n", kind, name);
}

template <class... Kinds>
void PrintRegistered() {
    (Print(Kinds::kKind, Registry<Kinds>::Names()), ...);
}

}  // namespace

void AddPluginsOptions(CLI::App&, PluginsArguments&) {}

ExitStatus RunPlugins(const PluginsArguments&) {
    PrintRegistered<CameraKind, FilmKind, FilterKind, SamplerKind, IntegratorKind, LightSamplerKind,
                    LightKind, AreaLightKind, MaterialKind, FloatTextureKind, SpectrumTextureKind, ShapeKind,
                    MediumKind, LayeredEstimatorKind, LayeredPdfKind>();
    Print("accelerator", AcceleratorNames());
    Print("sensor", SensorNames());
    Print("colour space", ColorSpace::Names());
    return ExitStatus::Complete;
}

}  // namespace lacquer
