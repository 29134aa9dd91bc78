#include "compare/variation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>

#include "pbrt/scene/parameter_list.h"

namespace lacquer::compare {

namespace {

[[noreturn]] void Fail(const std::string& message) { throw std::invalid_argument(message); }

/// What "PART.[TYPE ]PARAMETER" means in a scene.
struct Target {
    PluginEntity* entity = nullptr;
    std::string type, parameter;
};

/// Of lists whose members have no names: "light@2" is the second one.
template <class Entity>
struct NumberedList {
    const char* name;
    std::vector<Entity> SceneDescription::*list;
};
constexpr auto kNumberedLists =
    std::make_tuple(NumberedList<LightEntity>{"light", &SceneDescription::lights},
                    NumberedList<PluginEntity>{"arealight", &SceneDescription::areaLights},
                    NumberedList<ShapeEntity>{"shape", &SceneDescription::shapes});

/// Calls `visit(name, list)` for each of them.
template <class Scene, class Visit>
void ForEachList(Scene& scene, const Visit& visit) {
    std::apply([&](const auto&... numbered) { (visit(numbered.name, scene.*numbered.list), ...); },
               kNumberedLists);
}

/// Those of the option block. @param scene  may be const
template <class Scene>
auto SinglesOf(Scene& scene) {
    using Entity = std::conditional_t<std::is_const_v<Scene>, const PluginEntity, PluginEntity>;
    return std::array<std::pair<const char*, Entity*>, 6>{{{"camera", &scene.camera},
                                                           {"film", &scene.film},
                                                           {"filter", &scene.filter},
                                                           {"sampler", &scene.sampler},
                                                           {"integrator", &scene.integrator},
                                                           {"accelerator", &scene.accelerator}}};
}

std::string Numbered(const char* list, size_t index) { return fmt::format("{}@{}", list, index + 1); }

/// Materials come first: a name that they have is theirs.
PluginEntity* FindPart(const std::string& name, SceneDescription* scene) {
    for (MaterialEntity& material : scene->namedMaterials)
        if (material.name == name) return &material;
    for (size_t i = 1; i < scene->materials.size(); ++i)
        if (name == "@" + std::to_string(i)) return &scene->materials[i];
    for (const auto& [single, entity] : SinglesOf(*scene))
        if (name == single) return entity;
    PluginEntity* found = nullptr;
    const size_t at = name.find('@');
    if (at == std::string::npos) return nullptr;
    ForEachList(*scene, [&](const char* list, auto& entities) {
        for (size_t i = 0; i < entities.size() && name.compare(0, at, list) == 0; ++i)
            if (name == Numbered(list, i)) found = &entities[i];
    });
    return found;
}

std::vector<std::string> MaterialNames(const SceneDescription& scene) {
    std::vector<std::string> names;
    for (const MaterialEntity& material : scene.namedMaterials) names.push_back(material.name);
    for (size_t i = 1; i < scene.materials.size(); ++i) names.push_back("@" + std::to_string(i));
    return names;
}

/// Scenes may have a million shapes: their names are not listed one by one.
[[noreturn]] void FailUnknownPart(const std::string& name, SceneDescription* scene) {
    std::vector<std::string> names = MaterialNames(*scene);
    const std::string materials =
        names.empty() ? "no materials" : fmt::format("the materials {}", fmt::join(names, ", "));
    std::vector<std::string> parts;
    for (const auto& [single, entity] : SinglesOf(*scene)) parts.push_back(single);
    ForEachList(*scene, [&](const char* list, const auto& entities) {
        if (entities.empty()) return;
        const std::string last = Numbered(list, entities.size() - 1);
        parts.push_back(entities.size() == 1 ? last : fmt::format("{} to {}", Numbered(list, 0), last));
        names.push_back(Numbered(list, 0));
        names.push_back(last);
    });
    for (const auto& [single, entity] : SinglesOf(*scene)) names.push_back(single);
    Fail(fmt::format("the scene has no material or part \"{}\"{}; it has {}, and {}", Excerpt(name),
                     DidYouMean(name, names), materials, fmt::join(parts, ", ")));
}

Target ResolveTarget(const std::string& text, SceneDescription* scene) {
    Target target;
    for (size_t dot = text.rfind('.'); dot != std::string::npos && dot > 0; dot = text.rfind('.', dot - 1)) {
        target.entity = FindPart(text.substr(0, dot), scene);
        if (!target.entity) continue;
        target.parameter = text.substr(dot + 1);
        break;
    }
    if (!target.entity && FindPart(text, scene))
        Fail(fmt::format("\"{}\" names no parameter; expected {}.PARAMETER", Excerpt(text), Excerpt(text)));
    if (!target.entity) FailUnknownPart(text.substr(0, text.find('.')), scene);
    if (const size_t space = target.parameter.find(' '); space != std::string::npos) {
        target.type = target.parameter.substr(0, space);
        target.parameter.erase(0, space + 1);
    }
    return target;
}

/// The value as it would stand in a scene file, without quotes and brackets; elements of several numbers have
/// blanks between them.
void SetValue(Parameter* parameter, const std::string& value) {
    const ParameterType* type = FindParameterType(parameter->type);
    if (!type)
        Fail(fmt::format("there is no parameter type \"{}\"{}", Excerpt(parameter->type),
                         NearestParameterType(parameter->type)));
    parameter->Clear();
    parameter->kind = type->values;
    float number = 0;
    const std::vector<std::string_view> words = SplitAtBlanks(value);
    if (type->mayBeNamed && !words.empty() && ParseFloat(words[0], &number) != NumberProblem::None)
        parameter->kind = Parameter::Values::Strings;
    if (parameter->kind == Parameter::Values::Strings) {
        parameter->strings = {value};
        return;
    }
    for (const std::string_view word : words)
        if (AppendValue(word, parameter) != NumberProblem::None)
            Fail(fmt::format("\"{}\" is not {}", word, InWords(parameter->kind).one));
    if (words.empty() || words.size() % type->components != 0)
        Fail(fmt::format("\"{}\" has {} values; {} needs {}, with blanks between them", value, words.size(),
                         parameter->Quoted(), type->components));
}

}  // namespace

Variation ParseVariation(const std::string& text) {
    const size_t equals = text.find('=');
    Variation variation;
    if (equals != std::string::npos) {
        variation.target = text.substr(0, equals);
        for (size_t begin = equals + 1; begin <= text.size();) {
            const size_t end = std::min(text.find(',', begin), text.size());
            variation.values.push_back(text.substr(begin, end - begin));
            begin = end + 1;
        }
    }
    const std::string& target = variation.target;
    const size_t dot = target.find('.');
    const bool hasEmpty =
        std::find(variation.values.begin(), variation.values.end(), "") != variation.values.end();
    if (dot == std::string::npos || dot == 0 || target.back() == '.' || hasEmpty)
        Fail(fmt::format("\"{}\": expected MATERIAL.PARAMETER=VALUE,VALUE,...", text));
    return variation;
}

void Apply(const Variation& variation, const std::string& value, SceneDescription* scene) {
    const Target target = ResolveTarget(variation.target, scene);
    PluginEntity& entity = *target.entity;
    // A texture, a number and a spectrum of one name exclude each other: the last word replaces the others.
    const auto hasName = [&](const Parameter& p) { return p.name == target.parameter; };
    const auto old = std::find_if(entity.parameters.begin(), entity.parameters.end(), hasName);
    Parameter parameter;
    if (old != entity.parameters.end()) parameter = *old;
    parameter.name = target.parameter;
    if (!target.type.empty()) parameter.type = target.type;
    if (parameter.type.empty()) parameter.type = variation.defaultType;
    if (parameter.loc.file.IsEmpty()) parameter.loc = entity.loc;
    if (!parameter.colorSpace) parameter.colorSpace = entity.colorSpace;
    SetValue(&parameter, value);
    std::erase_if(entity.parameters, hasName);
    entity.parameters.push_back(parameter);
}

std::vector<std::pair<std::string, std::string>> PartsOf(const SceneDescription& scene) {
    std::vector<std::pair<std::string, std::string>> parts;
    for (const auto& [single, entity] : SinglesOf(scene)) parts.emplace_back(single, entity->type);
    ForEachList(scene, [&](const char* list, const auto& entities) {
        for (size_t i = 0; i < entities.size(); ++i) parts.emplace_back(Numbered(list, i), entities[i].type);
    });
    return parts;
}

}  // namespace lacquer::compare
