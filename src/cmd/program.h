// What every program does around its work.
#pragma once

namespace lacquer::cmd {

/// Runs `work`, which reports its own errors, with streams that cannot hurt it: a stream that the process was
/// started without is no file that is opened later; a reader that went away and a file that grows too large
/// fail the write, and do not end the process. What ends there is as it is for other programs (SIGPIPE).
/// @return  the exit status: that of `work`, or of results that did not get to standard output
int RunProgram(int (*work)(int argc, char** argv), int argc, char** argv);

}  // namespace lacquer::cmd
