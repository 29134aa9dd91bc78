#include "compare/variation.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>

namespace lacquer {

namespace {

[[noreturn]] void Fail(const std::string& message) { throw std::invalid_argument(message); }

template <class Number>
Number ParseNumber(const std::string& text, const char* what) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size())
        Fail(fmt::format("\"{}\" is no {}", text, what));
    return number;
}

bool ParseBool(const std::string& text) {
    if (text != "true" && text != "false") Fail(fmt::format("\"{}\" is neither true nor false", text));
    return text == "true";
}

/// The material called `name`, or "@1", "@2", ... for the unnamed ones in the order of the file.
MaterialEntity& FindMaterial(const std::string& name, SceneDescription* scene) {
    std::vector<std::string> names;
    for (MaterialEntity& material : scene->namedMaterials) {
        if (material.name == name) return material;
        names.push_back(material.name);
    }
    for (size_t i = 1; i < scene->materials.size(); ++i) {
        const std::string unnamed = "@" + std::to_string(i);
        if (unnamed == name) return scene->materials[i];
        names.push_back(unnamed);
    }
    Fail(fmt::format("the scene has no material \"{}\"{}; it has {}", name, DidYouMean(name, names),
                     names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
}

void SetValue(Parameter* parameter, const std::string& value) {
    parameter->floats.clear();
    parameter->integers.clear();
    parameter->bools.clear();
    parameter->strings.clear();
    if (parameter->type == "integer") {
        parameter->kind = Parameter::Values::Integers;
        parameter->integers = {ParseNumber<int>(value, "integer")};
    } else if (parameter->type == "float") {
        parameter->kind = Parameter::Values::Floats;
        parameter->floats = {ParseNumber<float>(value, "number")};
    } else if (parameter->type == "bool") {
        parameter->kind = Parameter::Values::Bools;
        parameter->bools = {ParseBool(value)};
    } else if (parameter->type == "string" || parameter->type == "texture" || parameter->type == "spectrum") {
        parameter->kind = Parameter::Values::Strings;
        parameter->strings = {value};
    } else {
        Fail(
            fmt::format("a parameter of type \"{}\" cannot be varied; expected float, integer, bool, string, "
                        "texture or spectrum (by name)",
                        parameter->type));
    }
}

}  // namespace

Variation ParseVariation(const std::string& text) {
    const size_t equals = text.find('=');
    const size_t dot = equals == std::string::npos ? equals : text.rfind('.', equals);
    if (dot == std::string::npos || dot == 0)
        Fail(fmt::format("\"{}\": expected MATERIAL.PARAMETER=VALUE,VALUE,...", text));
    Variation variation;
    variation.material = text.substr(0, dot);
    variation.parameter = text.substr(dot + 1, equals - dot - 1);
    if (const size_t space = variation.parameter.find(' '); space != std::string::npos) {
        variation.type = variation.parameter.substr(0, space);
        variation.parameter.erase(0, space + 1);
    }
    for (size_t begin = equals + 1; begin <= text.size();) {
        const size_t end = std::min(text.find(',', begin), text.size());
        variation.values.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    const bool hasEmpty =
        std::find(variation.values.begin(), variation.values.end(), "") != variation.values.end();
    if (variation.parameter.empty() || hasEmpty)
        Fail(fmt::format("\"{}\": expected MATERIAL.PARAMETER=VALUE,VALUE,...", text));
    return variation;
}

void Apply(const Variation& variation, const std::string& value, SceneDescription* scene) {
    MaterialEntity& material = FindMaterial(variation.material, scene);
    // A texture, a number and a spectrum of one name exclude each other: the last word replaces the others.
    const auto hasName = [&](const Parameter& p) { return p.name == variation.parameter; };
    const auto old = std::find_if(material.parameters.begin(), material.parameters.end(), hasName);
    Parameter parameter;
    if (old != material.parameters.end()) parameter = *old;
    parameter.name = variation.parameter;
    if (!variation.type.empty()) parameter.type = variation.type;
    if (parameter.type.empty()) parameter.type = "float";
    if (parameter.loc.file.empty()) parameter.loc = material.loc;
    if (!parameter.colorSpace) parameter.colorSpace = material.colorSpace;
    SetValue(&parameter, value);
    std::erase_if(material.parameters, hasName);
    material.parameters.push_back(parameter);
}

}  // namespace lacquer
