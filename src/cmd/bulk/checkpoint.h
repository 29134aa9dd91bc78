// What `lacquer bulk` has done so far, in a file, for a run that goes on.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lacquer::cmd {

/// Numbers of BulkComputation::State(), of each computation of a run.
using BulkStates = std::vector<std::vector<double>>;

/// Writes a file in the byte order of this machine, at once or not at all.
/// @param problem  what the numbers depend on, as text: the input and the program
/// Errors: FileError.
void WriteCheckpoint(const std::string& path, std::string_view problem, const BulkStates& states);
/// Errors: FileError for a file that cannot be read, is damaged or no checkpoint, or is of another problem.
BulkStates ReadCheckpoint(const std::string& path, std::string_view problem);

}  // namespace lacquer::cmd
