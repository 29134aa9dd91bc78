// lacquer merge, of states: their exact sum, as an image or as a state.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "pbrt/core/vec.h"

namespace lacquer::cmd {

struct StateMerge {
    std::vector<std::string> states;      ///< one or more
    std::string outfile;                  ///< image, or "NAME.state"
    bool isPartial = false;               ///< samples may be missing
    std::optional<Bounds2i> pixelBounds;  ///< all that is wanted; unset: what the scene asks for
};

/// Adds states of one render, in any order. The image has the bits of one render of all.
/// Errors: FileError for states of different renders, for samples that are double or, unless some may be,
/// missing, and for files that cannot be read or written: nothing has been written then.
ExitStatus MergeStates(const StateMerge& merge, Console* console);

}  // namespace lacquer::cmd
