#include "cmd/compare/candidates.h"

#include <fmt/format.h>

#include <algorithm>

#include "cmd/choices.h"
#include "cmd/command_support.h"
#include "denoise/method.h"
#include "layered/estimator.h"
#include "pbrt/base/light.h"
#include "pbrt/core/registry.h"

namespace lacquer::cmd {

namespace {

using compare::Candidate;
using compare::Subject;

/// What is known of a subject: its option and the names that there are.
struct SubjectNames {
    const char* option;
    std::vector<std::string> names;
};

SubjectNames NamesOf(Subject subject) {
    switch (subject) {
        case Subject::Estimators:
            return {"estimators", Registry<layered::LayeredEstimatorKind>::Names()};
        case Subject::Integrators: {
            std::vector<std::string> names = Registry<IntegratorKind>::Names();
            std::erase_if(names, [](const std::string& name) {
                return Registry<IntegratorKind>::TraitsOf(name).otherImage != nullptr;
            });
            return {"integrators", names};
        }
        case Subject::Samplers:
            return {"samplers", Registry<SamplerKind>::Names()};
        case Subject::LightSamplers:
            return {"light-samplers", Registry<LightSamplerKind>::Names()};
        case Subject::Denoisers: {
            std::vector<std::string> names = denoise::MethodNames();
            names.insert(names.begin(), compare::kNoDenoiser);
            return {"denoisers", names};
        }
    }
    return {};
}

/// "bidirectional" or "bidirectional/gaussian"; names of other subjects have no second half.
Candidate ParseCandidate(const std::string& text, Subject subject) {
    const size_t slash = subject == Subject::Estimators ? text.find('/') : std::string::npos;
    return {text.substr(0, slash), slash == std::string::npos ? "" : text.substr(slash + 1), subject};
}

/// What is wrong with the text of a candidate; empty: nothing.
std::string WhyNoCandidate(const std::string& text, Subject subject) {
    const Candidate candidate = ParseCandidate(text, subject);
    if (subject == Subject::Integrators)
        if (const char* other = Registry<IntegratorKind>::TraitsOf(text).otherImage)
            return fmt::format("\"{}\" {}: there is nothing to compare", text, other);
    if (std::string why = WhyUnknown(candidate.name, NamesOf(subject).names); !why.empty()) return why;
    if (compare::IsDenoised(candidate)) {
        const std::string why = denoise::WhyUnavailable(denoise::MethodOf(text));
        return why.empty() ? why : fmt::format("\"{}\" cannot be had: {}", text, why);
    }
    if (candidate.Label() == text && candidate.pdf.empty()) return {};
    return WhyUnknown(candidate.pdf, Registry<layered::LayeredPdfKind>::Names());
}

bool IsLayered(const MaterialEntity& m) { return Registry<MaterialKind>::TraitsOf(m.type).isLayered; }

/// Why all candidates render the same; empty: they may differ.
std::string WhyAllAreAlike(Subject subject, const SceneDescription& scene, const RenderSetup& setup) {
    if (subject == Subject::Estimators &&
        std::none_of(scene.namedMaterials.begin(), scene.namedMaterials.end(), IsLayered) &&
        std::none_of(scene.materials.begin(), scene.materials.end(), IsLayered))
        return "the scene has no layered material: all estimators render the same";
    if (subject == Subject::LightSamplers && setup.scene->SampledLights().size() < 2)
        return fmt::format("the scene has {}: all light samplers render the same",
                           setup.scene->SampledLights().empty() ? "no light" : "one light");
    return {};
}

}  // namespace

CLI::Validator IsCandidate(Subject subject) {
    return OneOf(NamesOf(subject).names,
                 [subject](const std::string& text) { return WhyNoCandidate(text, subject); });
}

std::vector<Candidate> CandidatesOf(const CompareArguments& a) {
    Subject subject = Subject::Estimators;
    const std::vector<std::string>* texts = &a.estimators;
    const auto take = [&](Subject other, const std::vector<std::string>& names) {
        if (names.empty()) return;
        subject = other;
        texts = &names;
    };
    take(Subject::Integrators, a.integrators);
    take(Subject::Samplers, a.samplers);
    take(Subject::LightSamplers, a.lightSamplers);
    take(Subject::Denoisers, a.denoisers);
    std::vector<Candidate> candidates;
    for (const std::string& text : *texts) {
        const Candidate candidate = ParseCandidate(text, subject);
        for (const Candidate& other : candidates)
            if (other.Label() == candidate.Label())
                BadOption(NamesOf(subject).option, candidate.Label(),
                          fmt::format("each {} once", compare::NounOf(subject)));
        candidates.push_back(candidate);
    }
    return candidates;
}

Candidate ReferenceCandidateOf(const CompareArguments& a, Subject subject) {
    if (!a.referenceBy.empty()) {
        if (const std::string why = WhyNoCandidate(a.referenceBy, subject); !why.empty())
            throw CLI::ValidationError(fmt::format("--reference-by: {}", why));
        if (compare::IsDenoised(ParseCandidate(a.referenceBy, subject)))
            BadOption("reference-by", a.referenceBy,
                      "\"none\": what others are measured against is never denoised");
        return ParseCandidate(a.referenceBy, subject);
    }
    if (subject == Subject::Estimators) return {"halfvector", "", subject};
    if (subject == Subject::Integrators) return {"volpath", "", subject};
    if (subject == Subject::Denoisers) return {compare::kNoDenoiser, "", subject};
    return {"", "", subject};
}

Candidate CandidateOfScene(const SceneDescription& scene, Subject subject) {
    Candidate candidate{scene.sampler.type, "", subject};
    if (subject != Subject::LightSamplers) return candidate;
    candidate.name = "bvh";
    for (const Parameter& p : scene.integrator.parameters)
        if (p.name == "lightsampler" && p.strings.size() == 1) candidate.name = p.strings[0];
    return candidate;
}

bool IsApproximate(const Candidate& candidate) {
    if (compare::IsDenoised(candidate)) return true;
    return candidate.subject == Subject::Estimators &&
           Registry<layered::LayeredEstimatorKind>::TraitsOf(candidate.name).isApproximate;
}

std::string KeyOf(Subject subject) {
    return subject == Subject::LightSamplers ? "lightSampler" : compare::NounOf(subject);
}

void ExamineCandidates(const compare::ExperimentPlan& plan, const RenderSetup& setup, Observer* observer) {
    const auto warn = [&](const std::string& text) {
        if (observer) observer->Warn(fmt::format("warning: {}", text));
    };
    const Subject subject = plan.candidates.front().subject;
    const auto examine = [&](const Candidate& candidate, const char* option) {
        const compare::CandidateNotes notes = compare::Examine(candidate, plan.scene, setup);
        if (!notes.problem.empty())
            throw CLI::ValidationError(fmt::format("--{} \"{}\": this {} {}", option, candidate.name,
                                                   compare::NounOf(subject), notes.problem));
        for (const std::string& warning : notes.warnings)
            warn(fmt::format("{} \"{}\" {}", compare::NounOf(subject), candidate.name, warning));
    };
    for (const Candidate& candidate : plan.candidates) examine(candidate, NamesOf(subject).option);
    const bool isNew = std::none_of(plan.candidates.begin(), plan.candidates.end(), [&](const Candidate& c) {
        return c.Label() == plan.reference.candidate.Label();
    });
    if (plan.reference.file.empty() && isNew) examine(plan.reference.candidate, "reference-by");
    if (subject == Subject::Integrators && compare::IsRegularized(plan.scene))
        warn("\"bool regularize\" changes the image, of each integrator in its own way: it is left out");
    if (subject != Subject::Samplers && subject != Subject::Denoisers && compare::IsClamped(plan.scene))
        warn(subject == Subject::Estimators ? "\"float maxcomponentvalue\" of the film clamps samples, and "
                                              "takes more from estimators that are "
                                              "noisier: they have an error that no time takes away"
                                            : "\"float maxcomponentvalue\" of the film clamps samples, and "
                                              "takes more where there is more noise: "
                                              "it is left out");
    const auto isStratified = [](const Candidate& c) { return c.name == "stratified"; };
    if (subject == Subject::Samplers && plan.budget.seconds &&
        std::any_of(plan.candidates.begin(), plan.candidates.end(), isStratified))
        warn(
            "within a time, sampler \"stratified\" does not know its count of samples, and is hardly better "
            "than "
            "\"independent\"; --equal-samples compares it at its best");
    if (const std::string why = WhyAllAreAlike(subject, plan.scene, setup); !why.empty()) warn(why);
}

}  // namespace lacquer::cmd
