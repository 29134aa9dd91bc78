// The spellings of pbrt-v3 that pbrt-v4 no longer has, so that an old scene can be told what it is.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace lacquer {

// Each answer completes the sentence "in pbrt-v4 ...": `it is "dielectric"`. No value: not a v3 spelling.
// `directive` is Directive::Plugin(): "Material" also for MakeNamedMaterial. Directives of pbrt-v3 are rows
// of the table in directives.cpp.

std::optional<std::string> V3Plugin(std::string_view directive, std::string_view type);
std::optional<std::string> V3ParameterType(std::string_view type);
std::optional<std::string> V3Parameter(std::string_view directive, std::string_view plugin,
                                       std::string_view type, std::string_view name);
std::optional<std::string> V3TextureType(std::string_view type);

}  // namespace lacquer
