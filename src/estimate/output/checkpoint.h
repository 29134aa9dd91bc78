// States of chains as text, so that an interrupted computation goes on with the same bits.
#pragma once

#include <string>
#include <vector>

#include "estimate/infer/chain.h"

namespace lacquer::estimate {

/// Chains in the middle of their work: states, and what has been drawn so far.
struct Checkpoint {
    std::string settings;  ///< a text that must be the same when the chains go on
    std::vector<ChainState> states;
    std::vector<std::vector<Draw>> draws;
};
/// JSON text from which every number comes back with its bits.
std::string CheckpointText(const Checkpoint& checkpoint);
/// Error: FileError with `path` if the text is no checkpoint or damaged, or has other settings.
Checkpoint ParseCheckpoint(const std::string& text, const std::string& path, const std::string& settings);

}  // namespace lacquer::estimate
