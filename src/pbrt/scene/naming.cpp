#include "pbrt/scene/naming.h"

#include <fmt/format.h>

#include <filesystem>

namespace lacquer {

namespace {

namespace fs = std::filesystem;

/// "sphere@room.pbrt:12"
std::string NameByPlace(const PluginEntity& entity) {
    if (entity.loc.file.IsEmpty()) return entity.type;
    return fmt::format("{}@{}:{}", entity.type, fs::path(entity.loc.file.Text()).filename().string(),
                       entity.loc.line);
}

}  // namespace

std::string NameOf(const ShapeEntity& shape) {
    for (const Parameter& p : shape.parameters) {
        if (p.name != "filename" || p.strings.size() != 1) continue;
        fs::path file = fs::path(p.strings[0]).filename();
        if (file.extension() == ".gz") file = file.stem();
        if (std::string stem = file.stem().string(); !stem.empty()) return stem;
    }
    return NameByPlace(shape);
}

std::string NameOf(const MaterialEntity& material) {
    if (!material.name.empty()) return material.name;
    return material.loc.file.IsEmpty() ? "default" : NameByPlace(material);
}

std::string UniqueNames::Make(const std::string& name) {
    if (used_.insert(name).second) return name;
    std::string made;
    do {
        made = fmt::format("{}#{}", name, ++last_.try_emplace(name, 1).first->second);
    } while (reserved_.contains(made) || !used_.insert(made).second);
    return made;
}

}  // namespace lacquer
