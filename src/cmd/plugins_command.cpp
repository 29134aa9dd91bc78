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

namespace lacquer {

namespace {

template <class... Kinds>
void PrintNames() {
    const auto print = [](const char* kind, const std::vector<std::string>& names) {
        for (const std::string& name : names) fmt::print("{}\t{}\n", kind, name);
    };
    (print(Kinds::kKind, Registry<Kinds>::Names()), ...);
}

}  // namespace

void AddPluginsOptions(CLI::App&, PluginsArguments&) {}

ExitStatus RunPlugins(const PluginsArguments&) {
    PrintNames<CameraKind, FilmKind, FilterKind, SamplerKind, IntegratorKind, LightSamplerKind, LightKind,
               AreaLightKind, MaterialKind, FloatTextureKind, SpectrumTextureKind, ShapeKind, MediumKind,
               LayeredEstimatorKind, LayeredPdfKind>();
    return ExitStatus::Complete;
}

}  // namespace lacquer
