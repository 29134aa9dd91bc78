// What the verbs share.
#pragma once

#include <string>
#include <vector>

namespace lacquer {

/// Usage error (CLI::ValidationError), with the nearest valid name, unless `name` is one of `known`.
/// @param option  as on the command line: "--estimator"
void CheckName(const char* option, const std::string& name, const std::vector<std::string>& known);

/// Writes a file under a temporary name and renames it; a device or a pipe takes the text itself. Nothing is
/// left of a file that cannot be finished. Errors: FileError.
void WriteText(const std::string& path, const std::string& text);

}  // namespace lacquer
