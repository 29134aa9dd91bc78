// From what the library throws to a message and an exit status.
#pragma once

#include "cmd/console.h"
#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Tells of the exception that is being handled. Only within a catch block; anything that is no
/// std::exception passes through.
ExitStatus ReportError(Console& console);
/// What it ends with, without a word.
ExitStatus StatusOfError();

}  // namespace lacquer::cmd
