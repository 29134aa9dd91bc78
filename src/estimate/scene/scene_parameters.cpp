#include "estimate/scene/scene_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "pbrt/base/material.h"
#include "pbrt/core/registry.h"

namespace lacquer::estimate {

namespace {

/// What is known of a parameter of materials beforehand.
struct ParameterKind {
    const char* name;
    double low, high;    ///< of the default prior, which is uniform between them
    double least, most;  ///< that materials can have: of any prior
    double fallback;     ///< where the scene does not give it
    bool isColor;
    const char* meaning;
    const char* only = nullptr;  ///< materials of this type only
};
constexpr ParameterKind kKinds[] = {
    {"roughness", 0.0005, 0.8, 0, 1, 0, false, "roughness"},
    {"uroughness", 0.0005, 0.8, 0, 1, 0, false, "roughness along the tangent"},
    {"vroughness", 0.0005, 0.8, 0, 1, 0, false, "roughness across the tangent"},
    {"eta", 0.05, 8, 0.001, 100, 1, true, "index of refraction", "conductor"},
    {"conductor.eta", 0.05, 8, 0.001, 100, 1, true, "index of refraction"},
    {"eta", 1.05, 2.5, 0.1, 10, 1.5, false, "index of refraction"},
    {"k", 0.5, 10, 0, 100, 3, true, "absorption index"},
    {"thickness", 0.01, 5, 0, 1e6, 1, false, "thickness"},
    {"sigma_t", 0.01, 5, 0, 1e6, 0, true, "extinction"},
    {"albedo", 0, 0.999, 0, 1, 0, true, "single-scattering albedo"},
    {"reflectance", 0.01, 0.99, 0, 1, 0.5, true, "reflectance"},
    {"transmittance", 0.01, 0.99, 0, 1, 0.25, true, "transmittance"},
    {"g", -0.9, 0.95, -0.999, 0.999, 0, false, "mean cosine of scattering"},
    {"kappa", 0.1, 50, 0, 1e6, 1, false, "concentration of scattering"},
    {"stddev", 0.02, 0.8, 1e-3, 10, 0.1, false, "deviation of fibres"},
    {"rotation", -90, 90, -360, 360, 0, false, "rotation"},
};
/// Of roughness, where it is the alpha itself: the same alphas.
constexpr double kLowestAlpha = 0.02, kHighestAlpha = 0.9;
constexpr double kMaxDepth = 5, kMinDepth = 0.01;  ///< optical

bool IsRoughness(const std::string& name) { return name.ends_with("roughness") && name != "remaproughness"; }

/// "interface.roughness" is a roughness, too.
const ParameterKind* KindOf(const std::string& type, const std::string& parameter) {
    for (const ParameterKind& kind : kKinds) {
        if (kind.only && type != kind.only) continue;
        if (parameter == kind.name) return &kind;
        if (const std::string suffix = std::string(".") + kind.name; parameter.ends_with(suffix))
            return &kind;
    }
    return nullptr;
}

std::vector<std::string> MaterialNames(const SceneDescription& scene) {
    std::vector<std::string> names;
    for (const MaterialEntity& material : scene.namedMaterials) names.push_back(material.name);
    for (size_t i = 1; i < scene.materials.size(); ++i) names.push_back(fmt::format("@{}", i));
    return names;
}

/// A parameter as scenes have it; estimate::Parameter is what is estimated.
using Entry = lacquer::Parameter;

const Entry* FindIn(const std::vector<Entry>& entries, const std::string& name) {
    for (const Entry& entry : entries)
        if (entry.name == name) return &entry;
    return nullptr;
}
/// The entity's own, or one that an Attribute directive has given it.
const Entry* FindEntry(const MaterialEntity& material, const std::string& name) {
    const Entry* own = FindIn(material.parameters, name);
    return own || !material.attributes ? own : FindIn(*material.attributes, name);
}

/// Places of the numbers among an entry's floats that a parameter sets: all of them, one channel, or the
/// values among the wavelengths.
std::vector<size_t> Places(const Entry& entry, int channel) {
    std::vector<size_t> places;
    const bool isSpectrum = entry.type == "spectrum";
    for (size_t i = isSpectrum ? 1 : 0; i < entry.floats.size(); i += isSpectrum ? 2 : 1)
        if (channel < 0 || i == size_t(channel)) places.push_back(i);
    return places;
}
double MeanOf(const Entry& entry, int channel) {
    double sum = 0;
    const std::vector<size_t> places = Places(entry, channel);
    for (const size_t i : places) sum += double(entry.floats[i]);
    return sum / double(places.size());
}

/// "coat.sigma_t.r" as a parameter of a scene.
class Resolver {
  public:
    Resolver(const SceneDescription& scene, const std::vector<std::string>& needed,
             const std::string& material)
        : scene_(scene), needed_(needed), material_(material) {}

    SceneParameter Resolve(const std::string& name) {
        SceneParameter p;
        p.name = name;
        const MaterialEntity& material = SplitAtMaterial(name, &p);
        if (std::find(needed_.begin(), needed_.end(), p.material) == needed_.end())
            throw SceneError(material.loc,
                             fmt::format("\"{}\" is no part of material \"{}\", whose light was measured; "
                                         "its parts are {}",
                                         Excerpt(p.material), Excerpt(material_), fmt::join(needed_, ", ")));
        const Entry* entry = FindEntry(material, p.parameter);
        if (!entry) entry = WithoutChannel(material, &p);
        const ParameterKind* kind = KindOf(material.type, p.parameter);
        if (!entry && !kind) Unknown(material, p);
        p.meaning = fmt::format("{} of {}{}", kind ? kind->meaning : p.parameter, p.material,
                                p.channel < 0 ? "" : fmt::format(" ({})", "rgb"[p.channel]));
        if (entry)
            CheckNumber(*entry, &p);
        else
            p.start = kind->fallback;
        return p;
    }

  private:
    const MaterialEntity& SplitAtMaterial(const std::string& name, SceneParameter* p) const {
        auto* scene = const_cast<SceneDescription*>(&scene_);
        for (size_t dot = name.rfind('.'); dot != std::string::npos && dot > 0;
             dot = name.rfind('.', dot - 1))
            if (const MaterialEntity* material = FindMaterialEntity(name.substr(0, dot), scene)) {
                p->material = name.substr(0, dot);
                p->parameter = name.substr(dot + 1);
                return *material;
            }
        const size_t dot = name.find('.');
        if (dot == std::string::npos)
            throw SceneError({},
                             fmt::format("\"{}\": expected MATERIAL.PARAMETER, such as \"{}.roughness\", or "
                                         "\"{}\" of a photograph{}",
                                         Excerpt(name), needed_.front(), kExposureName,
                                         DidYouMean(name, std::vector<std::string>{kExposureName})));
        const std::string material = name.substr(0, dot);
        const std::vector<std::string> names = MaterialNames(scene_);
        throw SceneError({}, fmt::format("the scene has no material \"{}\"{}; it has {}", Excerpt(material),
                                         DidYouMean(material, names), fmt::join(names, ", ")));
    }
    /// "sigma_t.r" as a channel of "sigma_t".
    static const Entry* WithoutChannel(const MaterialEntity& material, SceneParameter* p) {
        const std::string& name = p->parameter;
        if (name.size() < 3 || name[name.size() - 2] != '.') return nullptr;
        const size_t channel = std::string_view("rgb").find(name.back());
        if (channel == std::string_view::npos) return nullptr;
        p->parameter = name.substr(0, name.size() - 2);
        p->channel = int(channel);
        const Entry* entry = FindEntry(material, p->parameter);
        if (entry && entry->type != "rgb")
            throw SceneError(entry->loc,
                             fmt::format("{} has no channels; expected an rgb, to estimate \"{}\"",
                                         entry->Quoted(), p->name));
        return entry;
    }
    static void CheckNumber(const Entry& entry, SceneParameter* p) {
        if (entry.type == "texture")
            throw SceneError(entry.loc, fmt::format("{} is a texture; expected a number, to estimate \"{}\"",
                                                    entry.Quoted(), p->name));
        if (entry.kind == Entry::Values::Strings && entry.type == "spectrum")
            throw SceneError(
                entry.loc,
                fmt::format("{} is the spectrum \"{}\"; expected a number or an rgb, to estimate \"{}\"",
                            entry.Quoted(), entry.strings.empty() ? "" : Excerpt(entry.strings[0]), p->name));
        const bool isNumber = entry.type == "float" || entry.type == "rgb" || entry.type == "spectrum";
        const size_t count = entry.floats.size();
        if (!isNumber || entry.kind != Entry::Values::Floats || count == 0 ||
            count != (entry.type == "rgb"     ? 3
                      : entry.type == "float" ? 1
                                              : count / 2 * 2))
            throw SceneError(entry.loc, fmt::format("{} is no number; expected one, to estimate \"{}\"",
                                                    entry.Quoted(), p->name));
        p->start = MeanOf(entry, p->channel);
        if (entry.type != "float" && p->channel < 0 && !(p->start > 0))
            throw SceneError(entry.loc,
                             fmt::format("{} is 0: there is no colour to keep; estimate one of its channels, "
                                         "\"{}.r\"",
                                         entry.Quoted(), p->name));
    }
    [[noreturn]] static void Unknown(const MaterialEntity& material, const SceneParameter& p) {
        std::vector<std::string> known;
        for (const Entry& entry : material.parameters) known.push_back(entry.name);
        for (const ParameterKind& kind : kKinds)
            if (!kind.only || material.type == kind.only) known.emplace_back(kind.name);
        throw SceneError(material.loc, fmt::format("\"{}\" has no parameter \"{}\"{}", Excerpt(p.material),
                                                   Excerpt(p.parameter), DidYouMean(p.parameter, known)));
    }

    const SceneDescription& scene_;
    const std::vector<std::string>& needed_;
    const std::string& material_;
};

/// Materials before one that its strings name, and those that they name.
std::vector<std::string> NeededBy(const std::string& name, const SceneDescription& scene) {
    auto* mutableScene = const_cast<SceneDescription*>(&scene);
    const MaterialEntity* target = FindMaterialEntity(name, mutableScene);
    if (!target)
        throw SceneError(
            {}, fmt::format("there is no material \"{}\" in the scene{}; it has {}", Excerpt(name),
                            DidYouMean(name, MaterialNames(scene)), fmt::join(MaterialNames(scene), ", ")));
    std::set<std::string> wanted;
    const auto note = [&](const MaterialEntity& entity) {
        for (const Entry& entry : entity.parameters)
            wanted.insert(entry.strings.begin(), entry.strings.end());
    };
    note(*target);
    std::vector<std::string> needed = {name};
    for (auto entity = scene.namedMaterials.rbegin(); entity != scene.namedMaterials.rend(); ++entity) {
        if (!wanted.contains(entity->name) || entity->name == name) continue;
        needed.push_back(entity->name);
        note(*entity);
    }
    std::reverse(needed.begin(), needed.end());
    return needed;
}

/// A prior that is uniform but for some 1e-5.
Prior Uniform(double low, double high) { return {(low + high) / 2, 100 * (high - low), low, high}; }

/// What `"name"` of the same slab is in the file, or its default.
double PartnerValue(const MaterialEntity& slab, const char* name) {
    const Entry* entry = FindEntry(slab, name);
    const bool isThere = entry && entry->kind == Entry::Values::Floats && !entry->floats.empty();
    return isThere ? MeanOf(*entry, -1) : KindOf("slab", name)->fallback;
}

/// The range of a slab's extinction or thickness: optical thicknesses from 0.01 to 5.
Prior DepthPrior(const MaterialEntity& slab, const SceneParameter& p) {
    const double other = PartnerValue(slab, p.parameter == "sigma_t" ? "thickness" : "sigma_t");
    return other > 0 ? Uniform(kMinDepth / other, kMaxDepth / other) : Uniform(kMinDepth, kMaxDepth);
}

Prior DefaultPrior(const MaterialEntity& material, const SceneParameter& p) {
    const ParameterKind* kind = KindOf(material.type, p.parameter);
    const Entry* entry = FindEntry(material, p.parameter);
    if (!kind)
        throw SceneError(entry->loc, fmt::format("\"{}\" has no default range; expected --prior "
                                                 "\"{}=normal(MEAN,SD,LOW,HIGH)\"",
                                                 p.name, p.name));
    if (material.type == "slab" && (p.parameter == "sigma_t" || p.parameter == "thickness"))
        return DepthPrior(material, p);
    double low = kind->low, high = kind->high;
    if (IsRoughness(p.parameter)) {
        const Entry* remap = FindEntry(material, "remaproughness");
        if (remap && !remap->bools.empty() && !remap->bools[0]) low = kLowestAlpha, high = kHighestAlpha;
    }
    // The brightest channel stays a reflectance.
    if (entry && entry->type != "float" && p.channel < 0 && high < 1) {
        double most = 0;
        for (const size_t i : Places(*entry, -1)) most = std::max(most, double(entry->floats[i]));
        high *= std::min(1., p.start / most);
    }
    return Uniform(low, high);
}

/// A prior that was asked for reaches no further than materials do. Errors: SceneError without a place.
void CheckPrior(const MaterialEntity& material, const SceneParameter& p, const Prior& prior) {
    const ParameterKind* kind = KindOf(material.type, p.parameter);
    if (kind && (prior.low < kind->least || prior.high > kind->most))
        throw SceneError({}, fmt::format("the prior of {} reaches from {:g} to {:g}; expected LOW and HIGH "
                                         "from {:g} to {:g}",
                                         p.name, prior.low, prior.high, kind->least, kind->most));
}

/// A gain from a fifth to five times the scene's, most probably nearly its own.
SceneParameter ExposureParameter() {
    return {.name = kExposureName,
            .material = "",
            .parameter = kExposureName,
            .start = 1,
            .meaning = "gain over the scene"};
}
constexpr Prior kExposurePrior = {1, 0.5, 0.2, 5};

void Set(MaterialEntity* material, const SceneParameter& p, double value) {
    Entry entry;
    if (const Entry* old = FindEntry(*material, p.parameter)) {
        entry = *old;
    } else {
        const ParameterKind* kind = KindOf(material->type, p.parameter);
        entry.name = p.parameter;
        entry.type = kind && kind->isColor ? "rgb" : "float";
        entry.loc = material->loc;
        entry.floats.assign(kind && kind->isColor ? 3 : 1, float(p.start));
    }
    if (!entry.colorSpace) entry.colorSpace = material->colorSpace;
    const std::vector<size_t> places = Places(entry, p.channel);
    const bool isScaled = places.size() > 1 && p.start > 0;
    for (const size_t i : places)
        entry.floats[i] = float(isScaled ? double(entry.floats[i]) * value / p.start : value);
    std::erase_if(material->parameters, [&](const Entry& e) { return e.name == p.parameter; });
    material->parameters.push_back(std::move(entry));
}

}  // namespace

MaterialEntity* FindMaterialEntity(const std::string& name, SceneDescription* scene) {
    for (MaterialEntity& material : scene->namedMaterials)
        if (material.name == name) return &material;
    for (size_t i = 0; i < scene->materials.size(); ++i)
        if (name == fmt::format("@{}", i)) return &scene->materials[i];
    return nullptr;
}

SceneParameters::SceneParameters(SceneDescription scene, std::string material,
                                 const std::vector<std::string>& names,
                                 const std::map<std::string, Prior>& priors)
    : scene_(std::move(scene)), material_(std::move(material)), needed_(NeededBy(material_, scene_)) {
    Resolver resolver(scene_, needed_, material_);
    std::vector<Parameter> space;
    for (const std::string& name : names) {
        const auto prior = priors.find(name);
        const bool isGiven = prior != priors.end();
        if (name == kExposureName) {
            parameters_.push_back(ExposureParameter());
            space.push_back({.name = name, .unit = "", .prior = isGiven ? prior->second : kExposurePrior});
            continue;
        }
        parameters_.push_back(resolver.Resolve(name));
        const SceneParameter& p = parameters_.back();
        const MaterialEntity& entity = *FindMaterialEntity(p.material, &scene_);
        for (size_t i = 0; i + 1 < parameters_.size(); ++i) {
            const SceneParameter& other = parameters_[i];
            if (other.material == p.material && other.parameter == p.parameter &&
                (other.channel == p.channel || other.channel < 0 || p.channel < 0))
                throw SceneError(
                    entity.loc,
                    fmt::format("\"{}\" and \"{}\" are one number; expected each once", other.name, p.name));
        }
        if (isGiven) CheckPrior(entity, p, prior->second);
        space.push_back(
            {.name = name, .unit = "", .prior = isGiven ? prior->second : DefaultPrior(entity, p)});
        if (entity.type != "slab" || p.parameter != "sigma_t") continue;
        for (const std::string& other : names)
            if (other == p.material + ".thickness" && space.back().prior.low > 0)
                space.back().productWith = other;
    }
    for (const auto& [name, prior] : priors)
        if (std::find(names.begin(), names.end(), name) == names.end())
            throw SceneError({}, fmt::format("--prior {}: is not among the free parameters{}", Excerpt(name),
                                             DidYouMean(name, names)));
    space_ = ParameterSpace(std::move(space));
}

Vector SceneParameters::Start() const {
    Vector x{Eigen::Index(parameters_.size())};
    for (size_t i = 0; i < parameters_.size(); ++i) x[Eigen::Index(i)] = parameters_[i].start;
    return space_.ToNatural(space_.ToLogit(x));
}

SceneDescription SceneParameters::With(const Vector& x) const {
    SceneDescription scene = scene_;
    for (size_t i = 0; i < parameters_.size(); ++i)
        if (!parameters_[i].material.empty())
            Set(FindMaterialEntity(parameters_[i].material, &scene), parameters_[i], x[Eigen::Index(i)]);
    return scene;
}

std::string OnlyLayeredMaterial(const SceneDescription& scene) {
    std::vector<std::string> found;
    const auto isLayered = [](const MaterialEntity& m) {
        return Registry<MaterialKind>::TraitsOf(m.type).isLayered;
    };
    for (const MaterialEntity& material : scene.namedMaterials)
        if (isLayered(material)) found.push_back(material.name);
    for (size_t i = 0; i < scene.materials.size(); ++i)
        if (isLayered(scene.materials[i])) found.push_back(fmt::format("@{}", i));
    if (found.size() == 1) return found[0];
    throw SceneError(
        {}, found.empty()
                ? "the scene has no layered material: --material says whose light was measured"
                : fmt::format("the scene has several layered materials: expected --material, one of {}",
                              fmt::join(found, ", ")));
}

}  // namespace lacquer::estimate
