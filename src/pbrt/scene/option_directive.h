// Option "name" value.
#pragma once

#include "pbrt/scene/description.h"
#include "pbrt/scene/lexer.h"

namespace lacquer {

/// Sets the option `name`; case, '-' and '_' in it do not count.
/// Errors: SceneError for unknown names (at `loc`) and for values of the wrong kind (at the value).
void SetOption(const std::string& name, const Token& value, const FileLoc& loc, SceneOptions* options);

}  // namespace lacquer
