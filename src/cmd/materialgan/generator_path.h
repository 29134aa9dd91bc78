// Which file a command means by a generator.
#pragma once

#include <string>

namespace lacquer::cmd {

/// What names the generator that comes with Lacquer.
inline constexpr const char* kShippedGenerator = "shipped";

/// The file of a generator: of the shipped one that which was installed with the program, or else that of the
/// sources it was built from. Errors: FileError where neither is there.
std::string GeneratorPath(const std::string& name);

}  // namespace lacquer::cmd
