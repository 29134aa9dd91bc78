// "lacquer bulk" for ensembles that keep their axis.
#pragma once

#include <string>

#include "bulk/input/particles_input.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Solves an oriented ensemble and writes its table: `out`, and the image of its phase functions beside it.
/// Errors: usage for too few realisations; SceneError; FileError.
/// @param input  with `oriented`
ExitStatus RunOrientedBulk(const bulk::ParticlesInput& input, int realizations, const std::string& out,
                           Console* console);

}  // namespace lacquer::cmd
