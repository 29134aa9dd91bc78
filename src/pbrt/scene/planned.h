// Names of the pbrt-v4 format that this version does not have yet.
#pragma once

#include <string>
#include <string_view>

namespace lacquer {

/// True if the format knows a `kind` ("material", "shape", ...) called `name` and Lacquer does not yet.
/// A name leaves the list when its file registers it; a test checks that no name is in both places.
bool IsPlanned(std::string_view kind, std::string_view name);

}  // namespace lacquer
