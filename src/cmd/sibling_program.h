// Programs of the project beside the one that runs.
#pragma once

#include <string>
#include <vector>

namespace lacquer::cmd {

/// Goes on as lacquer-materialgan, which stands in the same folder and has what needs libtorch.
/// Errors: CLI::ValidationError (usage) where it was not built, with how to build it; FileError.
[[noreturn]] void GoOnAsMaterialgan(const std::vector<std::string>& words);

}  // namespace lacquer::cmd
