// From a name in the scene file to the factory that makes the object.
#pragma once

#include <fmt/format.h>

#include "pbrt/core/registry.h"
#include "pbrt/scene/description.h"

namespace lacquer {

/// SceneError for a name that is not registered, with the nearest one.
[[noreturn]] inline void UnknownPlugin(const char* kind, const std::string& type, const FileLoc& loc,
                                       const std::vector<std::string>& known) {
    if (type == "ptex" && std::string_view(kind).ends_with("texture"))
        throw SceneError(
            loc, fmt::format("{} \"ptex\": Ptex files are not supported; give the mesh uv coordinates, "
                             "bake the file to an image, and name that in an \"imagemap\"",
                             kind));
    throw SceneError(loc, fmt::format("unknown {} \"{}\"{}", kind, Excerpt(type), DidYouMean(type, known)));
}

/// The factory of an entity's type. Errors: SceneError at the entity.
template <class Kind>
typename Kind::Factory FactoryOf(const PluginEntity& entity) {
    const auto factory = Registry<Kind>::Find(entity.type);
    if (!factory) UnknownPlugin(Kind::kKind, entity.type, entity.loc, Registry<Kind>::Names());
    return factory;
}

}  // namespace lacquer
