#include "pbrt/film/passes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "pbrt/core/error.h"

namespace lacquer {

namespace {

constexpr const char* kPrefix = "lpe:";
constexpr const char* kLightGroups = "lightgroups";

struct NamedPass {
    const char *name, *expression;
};
/// By the number of events: emission, direct, indirect. By the first event: emission, diffuse, glossy,
/// transmission, volume. Either sum is all light.
constexpr std::array kNamed = {NamedPass{"diffuse", "C<RD>.*"},   NamedPass{"direct", "C.[LO]"},
                               NamedPass{"emission", "C[LO]"},    NamedPass{"glossy", "C<R[GS]>.*"},
                               NamedPass{"indirect", "C..+[LO]"}, NamedPass{"transmission", "C<T.>.*"},
                               NamedPass{"volume", "CV.*"}};
struct NamedPart {
    const char* name;
    LayeredPart part;
};
/// Together all light that comes from stacks which the camera sees first.
constexpr std::array kParts = {NamedPart{"layered.rest", LayeredPart::Rest},
                               NamedPart{"layered.single", LayeredPart::Single},
                               NamedPart{"layered.surface", LayeredPart::Surface}};
/// Layers that films and auxiliary outputs have.
constexpr std::array kTaken = {
    "R", "G",  "B", "A",      "Albedo",   "Half", "Variance", "RelativeVariance", "P",
    "N", "Ns", "Z", "object", "material", "u",    "v",        "samples",          "motion"};

bool IsExpression(const std::string& name) { return name.starts_with(kPrefix); }

/// Of "lpe:NAME=EXPRESSION". Errors: LightPathError.
Pass ReadPass(const std::string& text) {
    const std::string rest = text.substr(std::string_view(kPrefix).size());
    const size_t equals = rest.find('=');
    if (equals == std::string::npos)
        throw LightPathError(fmt::format(
            "\"{}\" has no \"=\"; expected lpe:NAME=EXPRESSION, as in lpe:shine=C<RG>L", Excerpt(text)));
    Pass pass{rest.substr(0, equals), rest.substr(equals + 1)};
    if (const std::string why = WhyNoLayerName(pass.layer); !why.empty())
        throw LightPathError(fmt::format("the name of the pass \"{}\" {}", Excerpt(text), why));
    if (std::find(kTaken.begin(), kTaken.end(), pass.layer) != kTaken.end())
        throw LightPathError(
            fmt::format("a pass cannot be called \"{}\": channels of the image have that name", pass.layer));
    CheckLightPathExpression(pass.expression);
    return pass;
}

}  // namespace

std::vector<std::string> PassNames() {
    std::vector<std::string> names{kLightGroups};
    for (const NamedPass& pass : kNamed) names.emplace_back(pass.name);
    for (const NamedPart& part : kParts) names.emplace_back(part.name);
    std::sort(names.begin(), names.end());
    return names;
}

bool IsPass(const std::string& name) {
    const std::vector<std::string> names = PassNames();
    return IsExpression(name) || std::find(names.begin(), names.end(), name) != names.end();
}

std::string WhyNoPass(const std::string& name) {
    try {
        if (IsExpression(name)) ReadPass(name);
        return {};
    } catch (const LightPathError& e) {
        return e.what();
    }
}

std::vector<Pass> PassesOf(const std::vector<std::string>& names, const std::vector<std::string>& groups) {
    std::vector<Pass> passes;
    std::set<std::string> seen, layers;
    const auto add = [&](Pass pass) {
        if (!layers.insert(pass.layer).second)
            throw LightPathError(fmt::format("two passes have the name \"{}\"", pass.layer));
        passes.push_back(std::move(pass));
    };
    for (const std::string& name : names) {
        if (!seen.insert(name).second) continue;
        if (IsExpression(name)) add(ReadPass(name));
        for (const NamedPass& pass : kNamed)
            if (name == pass.name) add({pass.name, pass.expression});
        for (const NamedPart& part : kParts)
            if (name == part.name) add({part.name, "", part.part});
        if (name != kLightGroups) continue;
        std::string others;
        for (size_t i = 1; i < groups.size(); ++i) {
            add({"lightgroup." + groups[i], fmt::format("C.*<[LO]'{}'>", groups[i])});
            others += fmt::format("<[LO]'{}'>", groups[i]);
        }
        add({"nolightgroup", others.empty() ? "C.*[LO]" : fmt::format("C[DGSV]*[^DGSV{}]", others)});
    }
    std::stable_partition(passes.begin(), passes.end(), [](const Pass& pass) { return !pass.part; });
    return passes;
}

namespace {

std::vector<std::string> ExpressionsOf(const std::vector<Pass>& passes) {
    std::vector<std::string> expressions;
    for (const Pass& pass : passes)
        if (!pass.part) expressions.push_back(pass.expression);
    return expressions;
}

}  // namespace

PassSet::PassSet(const std::vector<Pass>& passes, const std::vector<std::string>& groups)
    : automaton_(ExpressionsOf(passes), groups) {
    layerOfPart_.fill(-1);
    for (const Pass& pass : passes) {
        if (pass.part) layerOfPart_[size_t(*pass.part)] = int(layers_.size());
        layers_.push_back(pass.layer);
    }
}

std::string WhyNoLayerName(const std::string& name) {
    if (name.empty()) return "is empty";
    constexpr size_t kMaxLength = 64;
    if (name.size() > kMaxLength) return fmt::format("has more than {} characters", kMaxLength);
    const auto isFine = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-';
    };
    if (!std::all_of(name.begin(), name.end(), isFine))
        return "may have letters, digits, \"_\" and \"-\" only, as a layer of the image";
    return {};
}

}  // namespace lacquer
