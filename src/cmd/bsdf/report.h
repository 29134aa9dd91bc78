// The numbers of `lacquer bsdf` as JSON and as text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "measure/bsdf_result.h"

namespace lacquer::cmd {

/// Everything, with units in the keys where there are any.
nlohmann::ordered_json ToJson(const measure::BsdfResult& result);
/// The same for a reader: tables of at most 110 columns.
std::string ToText(const measure::BsdfResult& result);

}  // namespace lacquer::cmd
