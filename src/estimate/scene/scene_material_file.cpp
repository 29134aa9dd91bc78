#include "estimate/scene/scene_material_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "estimate/scene/scene_parameters.h"
#include "pbrt/scene/statements.h"

namespace lacquer::estimate {

namespace {

using Entry = lacquer::Parameter;

/// Where a file is, if the string names one.
std::string Located(const std::string& text, const FileResolver& files) {
    std::error_code ignored;
    const std::filesystem::path path = files.Resolve(text);
    if (text.find('.') == std::string::npos || !std::filesystem::is_regular_file(path, ignored)) return text;
    return std::filesystem::absolute(path, ignored).lexically_normal().string();
}

std::string ValuesOf(const Entry& entry, const FileResolver& files) {
    std::string text;
    for (const float value : entry.floats) text += fmt::format(" {:.9g}", value);
    for (const int value : entry.integers) text += fmt::format(" {}", value);
    for (const auto value : entry.bools) text += value ? " true" : " false";
    for (const std::string& value : entry.strings) text += " " + QuotedText(Located(value, files));
    return text + " ";
}

std::string ParametersOf(const PluginEntity& entity, const FileResolver& files) {
    std::string text;
    std::set<std::string> own;
    const auto add = [&](const Entry& entry) {
        text +=
            fmt::format("\n    {} [{}]", QuotedText(entry.type + " " + entry.name), ValuesOf(entry, files));
    };
    for (const Entry& entry : entity.parameters) {
        own.insert(entry.name);
        add(entry);
    }
    if (entity.attributes)
        for (const Entry& entry : *entity.attributes)
            if (!own.contains(entry.name)) add(entry);
    return text + "\n";
}

void AddStrings(const PluginEntity& entity, std::set<std::string>* strings) {
    for (const Entry& entry : entity.parameters) strings->insert(entry.strings.begin(), entry.strings.end());
}

}  // namespace

std::string MaterialText(const SceneDescription& scene, const std::vector<std::string>& names) {
    auto* mutableScene = const_cast<SceneDescription*>(&scene);
    std::set<std::string> strings;
    for (const std::string& name : names) AddStrings(*FindMaterialEntity(name, mutableScene), &strings);
    std::string textures;
    for (auto texture = scene.textures.rbegin(); texture != scene.textures.rend(); ++texture) {
        if (!strings.contains(texture->name)) continue;
        AddStrings(*texture, &strings);
        textures.insert(0, fmt::format("Texture {} \"{}\" {}{}", QuotedText(texture->name),
                                       texture->isSpectrum ? "spectrum" : "float", QuotedText(texture->type),
                                       ParametersOf(*texture, scene.FilesOf(*texture))));
    }
    std::string text = textures;
    for (const std::string& name : names) {
        const MaterialEntity& entity = *FindMaterialEntity(name, mutableScene);
        text += fmt::format("MakeNamedMaterial {} \"string type\" {}{}",
                            QuotedText(entity.name.empty() ? "estimated" : entity.name),
                            QuotedText(entity.type), ParametersOf(entity, scene.FilesOf(entity)));
    }
    return text;
}

}  // namespace lacquer::estimate
