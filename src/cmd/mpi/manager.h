// Rank 0 of `render --mpi`: gives out units of work, renders some itself, and adds up what comes back.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cmd/console.h"
#include "cmd/mpi/job_messages.h"
#include "cmd/render/state_header.h"
#include "mpi/messenger.h"
#include "pbrt/film/aov.h"
#include "pbrt/integrators/render.h"

namespace lacquer::cmd {

/// Another rank cannot go on, or is not of this job. The message names it.
class RankError : public std::runtime_error {
  public:
    RankError(ExitStatus status, const std::string& message) : std::runtime_error(message), status_(status) {}
    ExitStatus Status() const { return status_; }

  private:
    ExitStatus status_;
};

/// A render as its manager sees it.
struct ManagedRender {
    UnitRenderer::Renderer render;  ///< of units, on this rank
    Film* film = nullptr;           ///< of the whole; has what a state to go on from had
    AovBuffer* aovs = nullptr;      ///< null: none
    std::pair<int, int> range;      ///< of the samples: the first one, and one behind the last
    int halfBlock = 1;
    bool wholeImages = false;  ///< units have all pixels: light from the lights lands anywhere, or is shared
    int threads = 1;           ///< of this rank
    /// Of RenderOptions: `checkpoint` and its times.
    const RenderOptions* options = nullptr;
    /// Called now and then with the number of samples that every pixel has and the seconds so far; null:
    /// nobody looks.
    std::function<void(int samples, double seconds)> showImage = {};
};

/// What a manager has taken in, its own results included.
struct JobTraffic {
    int64_t results = 0, bytes = 0;
    double seconds = 0;  ///< of adding them
};

/// Errors of all functions: RankError, and std::runtime_error of MPI.
class JobManager {
  public:
    explicit JobManager(mpi::Messenger* messenger) : messenger_(messenger) {}

    /// Lets the other ranks load the scene. To be called once. @param filterSamples  of a render to go on
    /// from
    void LetLoad(std::optional<int> filterSamples);
    /// Waits until all have, and compares what they have loaded with what this rank has.
    void AwaitLoaded(const StateHeader& header);
    /// Renders until all samples are there or a signal asks to stop. Needs the two above first.
    RenderStats Render(const ManagedRender& render, Observer* observer);
    /// Of the render before.
    const JobTraffic& Traffic() const { return traffic_; }
    /// Ends the other ranks; by force if they do not do so soon, and with `status`.
    void End(ExitStatus status);

  private:
    void Compare(int rank, const RankReport& report, const StateHeader& header);

    mpi::Messenger* messenger_;
    int otherThreads_ = 0;
    JobTraffic traffic_;
};

}  // namespace lacquer::cmd
