// Every rank of `render --mpi` but the first: renders the units that it is given.
#pragma once

#include <optional>
#include <string>

#include "cmd/mpi/job_messages.h"

namespace lacquer::cmd {

/// A rank's talk with the manager. Functions that wait return nothing once the manager wants no more.
class JobWorker {
  public:
    explicit JobWorker(mpi::Messenger* messenger) : messenger_(messenger) {}

    std::optional<LoadOrder> AwaitLoad();
    /// Tells what was loaded. @param header  StateHeader::Text()
    std::optional<StartOrder> AwaitStart(const std::string& header, int threads);
    /// Renders units until the manager wants no more. Errors: what `render` throws.
    void Serve(UnitRenderer::Renderer render);

    /// Tells why this rank cannot go on, and waits until the manager knows.
    void Fail(ExitStatus status, const std::string& text);
    /// The last thing.
    void End();

  private:
    /// The next message of this kind. What is of another kind is a bug.
    std::optional<mpi::Bytes> Await(JobMessage kind);
    mpi::Messenger* messenger_;
    bool isStopped_ = false;
};

}  // namespace lacquer::cmd
