// Files of what a render has added up.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pbrt/film/render_state.h"

namespace lacquer {

/// What a state file holds.
struct StateFile {
    std::string header;  ///< what it belongs to, as its writer put it
    std::vector<StoredArray> arrays;
};

/// Writes a state: compressed, with checksums, in the byte order of this machine, on all processors.
/// The file appears at once and whole, after it has reached the disk; what was at `path` is then at
/// PreviousState(path). Until then it is in "PATH.part", which a killed process may leave, and the next one
/// uses: one process at a time writes to `path`. Errors: FileError; what was there stays.
void WriteStateFile(const std::string& path, const std::string& header,
                    const std::vector<StateArray>& arrays);
/// The bytes of such a file, for messages.
std::vector<unsigned char> StateBytes(const std::string& header, const std::vector<StateArray>& arrays);
/// `path` with ".previous" behind it.
std::string PreviousState(const std::string& path);
/// Errors: FileError for what cannot be read, is no state, or is damaged.
StateFile ReadStateFile(const std::string& path);
/// The same of StateBytes(). @param name  for messages
StateFile ReadState(const std::string& name, std::span<const unsigned char> bytes);
/// By what the file begins with. False for files that cannot be read.
bool IsStateFile(const std::string& path);
/// The header alone; nothing behind it is read. Errors: as ReadStateFile(), of that part.
std::string ReadStateHeader(const std::string& path);

}  // namespace lacquer
