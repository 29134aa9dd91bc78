// render --checkpoint and --resume: the state of a render in a file, and what it belongs to.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cmd/console.h"
#include "cmd/render/state_header.h"
#include "pbrt/core/file_lock.h"
#include "pbrt/film/aov.h"
#include "pbrt/film/render_state.h"
#include "pbrt/integrators/render.h"

namespace lacquer::cmd {

/// The state file of one render, from its options to the last write.
class RenderCheckpoint {
  public:
    /// @param resume  file to go on from; empty: none
    /// @param path    file to write; empty: none
    /// @param interval  seconds between; by default 600, or as many as keep its cost below 1 % of the time
    /// Errors: FileError for a state that cannot be read, for a file at `path` that is not the one to
    /// go on from, and for one that another process writes.
    RenderCheckpoint(std::string resume, std::string path, std::optional<double> interval, Console* console);

    bool IsUsed() const { return resumed_ || !path_.empty(); }
    /// Textures are filtered as when the render began, which may have had another number of samples in mind.
    std::optional<int> FilterSamples() const;
    /// Takes over what was added up before. @param header  of this render, without parts
    /// @param range  of samples that it takes: the first one, and one behind the last
    /// @param shares  of the pixels, null: all are alike
    /// Errors: FileError for a state of something else, or of more samples than are asked for.
    void Attach(StateHeader header, std::pair<int, int> range, const SampleShares* shares, Film* film,
                AovBuffer* aovs);
    /// Halves as from the beginning, and writes on time.
    void AddTo(RenderOptions* options);
    /// Seconds of the runs before.
    double SecondsBefore() const { return resumed_ ? resumed_->seconds : 0; }
    /// Seconds that this run has spent before the first sample.
    void AddSeconds(double seconds) { pilotSeconds_ += seconds; }
    /// What is added up in the end. @param seconds  of this run
    /// @param samples  of a pixel, where fewer turned out to be enough  Errors: FileError.
    void Finish(double seconds, std::optional<int> samples);

  private:
    void Write(double seconds);
    /// Errors: FileError for a state of other samples or pixels.
    void CheckSamples() const;

    std::string resume_, path_;
    std::optional<double> interval_;
    Console* console_;
    std::optional<FileLock> lock_;
    std::optional<StateHeader> resumed_;
    std::vector<StoredArray> stored_;
    StateHeader header_;
    std::pair<int, int> range_;
    const SampleShares* shares_ = nullptr;
    double pilotSeconds_ = 0;
    Film* film_ = nullptr;
    AovBuffer* aovs_ = nullptr;
};

}  // namespace lacquer::cmd
