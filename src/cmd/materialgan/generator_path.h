// Which file a command means by a generator, and how many threads it works with.
#pragma once

#include <string>

#include "materialgan/material_prior.h"

namespace lacquer::cmd {

/// What names the generator that comes with Lacquer.
inline constexpr const char* kShippedGenerator = "shipped";

/// The file of a generator: of the shipped one that which was installed with the program, or else that of the
/// sources it was built from. Errors: FileError where neither is there.
std::string GeneratorPath(const std::string& name);

/// Sets the threads of libtorch, and returns their number. Same seeds, threads and machine give the same
/// bits.
/// @param asked  0: all processors, but one for a generator of small images: its threads would wait for each
/// other longer than they compute
int UseThreads(const materialgan::MaterialPrior& prior, int asked);

}  // namespace lacquer::cmd
