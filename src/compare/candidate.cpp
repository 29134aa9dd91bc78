#include "compare/candidate.h"

#include <fmt/format.h>

#include <algorithm>

#include "denoise/method.h"
#include "pbrt/base/light.h"

namespace lacquer::compare {

namespace {

constexpr const char *kLightSampler = "lightsampler", *kRegularize = "regularize",
                     *kClamp = "maxcomponentvalue";

void SetLightSampler(const std::string& name, PluginEntity* integrator) {
    std::erase_if(integrator->parameters, [](const Parameter& p) { return p.name == kLightSampler; });
    Parameter parameter;
    parameter.type = "string";
    parameter.name = kLightSampler;
    parameter.kind = Parameter::Values::Strings;
    parameter.strings = {name};
    parameter.loc = integrator->loc;
    integrator->parameters.push_back(std::move(parameter));
}

void SetIntegrator(const std::string& name, PluginEntity* integrator) {
    std::erase_if(integrator->parameters, [](const Parameter& p) { return p.name == kRegularize; });
    if (integrator->type == name) return;
    integrator->type = name;
    // As those of Attribute directives: who does not know them leaves them.
    for (Parameter& p : integrator->parameters) p.fromAttribute = true;
}

void SetSampler(const std::string& name, PluginEntity* sampler) {
    if (sampler->type == name) return;
    sampler->type = name;
    sampler->parameters.clear();
}

/// Why an integrator renders another image of this scene than others; empty: it does not.
std::string OtherImageOf(const std::string& name, const Integrator& integrator, const Scene& scene) {
    const auto traits = Registry<IntegratorKind>::TraitsOf(name);
    const auto& lights = scene.Lights();
    if (scene.HasMedia() && !integrator.RendersMedia()) return "renders the media of the scene as vacuum";
    if (scene.HasSubsurface() && !traits.rendersSubsurface)
        return "does not render the light below surfaces that the scene has";
    if (scene.HasInterfaces() && traits.shadowsOfInterfaces)
        return "lets the surfaces of material \"interface\" cast shadows";
    if (!traits.findsDeltaLights &&
        std::any_of(lights.begin(), lights.end(), [](const Light* light) { return light->IsDelta(); }))
        return "never finds the light of a point, spot, goniometric, projection or distant light, which the "
               "scene has";
    return {};
}

CandidateNotes ExamineIntegrator(const std::string& name, const SceneDescription& description,
                                 const RenderSetup& setup) {
    CandidateNotes notes;
    const auto traits = Registry<IntegratorKind>::TraitsOf(name);
    if (traits.otherImage) return {traits.otherImage, {}};
    PluginEntity entity = description.integrator;
    SetIntegrator(name, &entity);
    try {
        const Params params = MakeParams(entity, IntegratorKind::kKind, description.FilesOf(entity));
        const auto integrator = Registry<IntegratorKind>::Find(name)(
            {.params = params, .scene = *setup.scene, .mayBeReplaced = false});
        // Some films take no light that is traced from the lights, and say so here.
        if (integrator->MakesSplats()) setup.film->PrepareForSplats(1);
        notes.problem = OtherImageOf(name, *integrator, *setup.scene);
        for (const Parameter& p : params.All())
            if (!p.lookedUp) notes.warnings.push_back(fmt::format("has no parameter {}", p.Quoted()));
    } catch (const SceneError& e) {
        notes.problem = fmt::format("cannot render this scene: {}", e.Message());
    }
    if (traits.neverFinds)
        notes.warnings.push_back(
            fmt::format("never finds {}: where the scene has such, it has an error that no time takes away",
                        traits.neverFinds));
    return notes;
}

}  // namespace

const char* NounOf(Subject subject) {
    switch (subject) {
        case Subject::Estimators:
            return "estimator";
        case Subject::Integrators:
            return "integrator";
        case Subject::Samplers:
            return "sampler";
        case Subject::LightSamplers:
            return "light sampler";
        case Subject::Denoisers:
            return "denoiser";
    }
    return "";
}

bool IsDenoised(const Candidate& candidate) {
    return candidate.subject == Subject::Denoisers && candidate.name != kNoDenoiser;
}

bool IsClamped(const SceneDescription& scene) {
    const auto& parameters = scene.film.parameters;
    return std::any_of(parameters.begin(), parameters.end(),
                       [](const Parameter& p) { return p.name == kClamp; });
}

bool IsRegularized(const SceneDescription& scene) {
    const auto& parameters = scene.integrator.parameters;
    return std::any_of(parameters.begin(), parameters.end(), [](const Parameter& p) {
        return p.name == kRegularize && p.bools == std::vector<unsigned char>{1};
    });
}

void Apply(const Candidate& candidate, SceneDescription* scene) {
    if (candidate.subject == Subject::Integrators || candidate.subject == Subject::LightSamplers)
        std::erase_if(scene->film.parameters, [](const Parameter& p) { return p.name == kClamp; });
    if (candidate.subject == Subject::Integrators) SetIntegrator(candidate.name, &scene->integrator);
    if (candidate.subject == Subject::Samplers) SetSampler(candidate.name, &scene->sampler);
    if (candidate.subject == Subject::LightSamplers) SetLightSampler(candidate.name, &scene->integrator);
}

MaterialOverrides OverridesOf(const Candidate& candidate) {
    if (candidate.subject != Subject::Estimators) return {};
    return {{"estimator", candidate.name}, {"pdf", candidate.pdf}};
}

CandidateNotes Examine(const Candidate& candidate, const SceneDescription& scene, const RenderSetup& setup) {
    if (candidate.subject == Subject::Integrators) return ExamineIntegrator(candidate.name, scene, setup);
    if (IsDenoised(candidate)) {
        const std::string why =
            denoise::WhyNot(denoise::MethodOf(candidate.name), setup.sampler->SamplesPerPixel(),
                            setup.integrator->MakesSplats());
        return {why.empty() ? why : fmt::format("cannot denoise what is rendered: it {}", why), {}};
    }
    const std::string& integrator = scene.integrator.type;
    if (candidate.subject == Subject::LightSamplers &&
        !Registry<IntegratorKind>::TraitsOf(integrator).takesLightSampler)
        return {fmt::format("cannot be set: integrator \"{}\" of the scene has no light sampler", integrator),
                {}};
    return {};
}

}  // namespace lacquer::compare
