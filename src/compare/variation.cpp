#include "compare/variation.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "pbrt/scene/parameter_list.h"

namespace lacquer::compare {

namespace {

[[noreturn]] void Fail(const std::string& message) { throw std::invalid_argument(message); }

/// What "MATERIAL.[TYPE ]PARAMETER" means in a scene.
struct Target {
    MaterialEntity* material = nullptr;
    std::string type, parameter;
};

MaterialEntity* FindMaterial(const std::string& name, SceneDescription* scene) {
    for (MaterialEntity& material : scene->namedMaterials)
        if (material.name == name) return &material;
    for (size_t i = 1; i < scene->materials.size(); ++i)
        if (name == "@" + std::to_string(i)) return &scene->materials[i];
    return nullptr;
}

std::vector<std::string> MaterialNames(const SceneDescription& scene) {
    std::vector<std::string> names;
    for (const MaterialEntity& material : scene.namedMaterials) names.push_back(material.name);
    for (size_t i = 1; i < scene.materials.size(); ++i) names.push_back("@" + std::to_string(i));
    return names;
}

Target ResolveTarget(const std::string& text, SceneDescription* scene) {
    Target target;
    for (size_t dot = text.rfind('.'); dot != std::string::npos && dot > 0; dot = text.rfind('.', dot - 1)) {
        target.material = FindMaterial(text.substr(0, dot), scene);
        if (!target.material) continue;
        target.parameter = text.substr(dot + 1);
        break;
    }
    if (!target.material) {
        const std::string name = text.substr(0, text.find('.'));
        const std::vector<std::string> names = MaterialNames(*scene);
        Fail(fmt::format("the scene has no material \"{}\"{}; it has {}", name, DidYouMean(name, names),
                         names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
    }
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
    MaterialEntity& material = *target.material;
    // A texture, a number and a spectrum of one name exclude each other: the last word replaces the others.
    const auto hasName = [&](const Parameter& p) { return p.name == target.parameter; };
    const auto old = std::find_if(material.parameters.begin(), material.parameters.end(), hasName);
    Parameter parameter;
    if (old != material.parameters.end()) parameter = *old;
    parameter.name = target.parameter;
    if (!target.type.empty()) parameter.type = target.type;
    if (parameter.type.empty()) parameter.type = "float";
    if (parameter.loc.file.empty()) parameter.loc = material.loc;
    if (!parameter.colorSpace) parameter.colorSpace = material.colorSpace;
    SetValue(&parameter, value);
    std::erase_if(material.parameters, hasName);
    material.parameters.push_back(parameter);
}

}  // namespace lacquer::compare
