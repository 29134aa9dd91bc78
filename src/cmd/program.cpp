#include "cmd/program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>

#include "cmd/console.h"
#include "cmd/exit_status.h"

namespace lacquer::cmd {
namespace {

/// Takes the numbers of missing streams, or the next file that is opened would get the messages. What is
/// opened here is of no use: reading and writing fail as before.
void ReserveStreams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(stream, F_GETFD) < 0) open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

bool IsReaderGone() {
    pollfd out = {STDOUT_FILENO, 0, 0};
    return poll(&out, 1, 0) == 1 && (out.revents & POLLERR);
}

/// A reader of the results who has seen enough is no error.
void EndAsOfClosedPipe() {
    signal(SIGPIPE, SIG_DFL);
    raise(SIGPIPE);
}

}  // namespace

int RunProgram(int (*work)(int argc, char** argv), int argc, char** argv) {
    ReserveStreams();
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    const int status = work(argc, argv);
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return status;
    if (IsReaderGone()) EndAsOfClosedPipe();
    Console(ConsoleStyle::Detect(false)).Error("standard output cannot be written");
    return status == 0 ? int(ExitStatus::File) : status;
}

}  // namespace lacquer::cmd
