// Options of fits of latents, from the command line.
#pragma once

#include "cmd/capture/capture_arguments.h"
#include "materialgan/latent_fit.h"

namespace lacquer::cmd {

/// Without the weight of the prior, whose default depends on the photographs.
materialgan::LatentFitOptions LatentFitOptionsOf(const PriorArguments& arguments);

}  // namespace lacquer::cmd
