// lacquer render --mpi: one render by all processes of an MPI job.
#pragma once

#include "cmd/exit_status.h"
#include "cmd/render/render_arguments.h"

namespace lacquer::cmd {

/// The part of this process. Only rank 0 prints and writes, and only its status tells how the render ended:
/// that of the others is 0. Without mpirun it is rank 0 of one. Errors: FileError where there is no MPI.
ExitStatus RunMpiRender(const RenderArguments& arguments);

}  // namespace lacquer::cmd
