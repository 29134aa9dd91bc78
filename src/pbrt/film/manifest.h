// Names and their numbers as text, for image metadata.
#pragma once

#include <functional>
#include <span>
#include <string>

namespace lacquer {

/// A JSON object on one line: {"name":value,...}, in the order of `names`. Bytes that are not UTF-8 become
/// U+FFFD. @param value  JSON text of the i-th value
std::string JsonManifest(std::span<const std::string> names, const std::function<std::string(size_t)>& value);

}  // namespace lacquer
