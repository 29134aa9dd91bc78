// render --checkpoint and --resume: the state of a render in a file, and what it belongs to.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cmd/console.h"
#include "pbrt/core/file_lock.h"
#include "pbrt/film/aov.h"
#include "pbrt/film/render_state.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"

namespace lacquer::cmd {

/// What a state belongs to, as JSON: only what has the same program, scene and settings can be added.
struct StateHeader {
    nlohmann::ordered_json program, scene, settings;
    std::string samplerValues = {};      ///< a hash of some
    int samplesPerPixel = 0;             ///< of the sampler
    int firstSample = 0, endSample = 0;  ///< that the render was to take
    int numSamples = 0;                  ///< of them that every pixel has
    int filterSamples = 0;               ///< for which textures are filtered
    int halfBlock = 1;
    double seconds = 0;  ///< of rendering, of all runs

    std::string Text() const;
    /// Errors: FileError for what is no such header.
    static StateHeader Read(const std::string& path, const std::string& text);
};

/// The part of a header that says what is rendered.
/// @param text      of scenes that are no files
/// @param settings  of the command line that change the image, beyond those of the setup
/// Cost: reads all files of the scene once more. Errors: FileError.
StateHeader HeaderOf(const RenderSetup& setup, const std::vector<std::string>& sceneFiles,
                     const std::string& text, const AovBuffer* aovs, const PassSet* passes,
                     nlohmann::ordered_json settings);

/// How `other` differs in what it belongs to: empty, or "the file skull.ply", "--seed: 3 instead of 0".
std::string Difference(const StateHeader& expected, const StateHeader& other);

/// The state file of one render, from its options to the last write.
class RenderCheckpoint {
  public:
    /// @param resume  file to go on from; empty: none
    /// @param path    file to write; empty: none
    /// Errors: FileError for a state that cannot be read, for a file at `path` that is not the one to
    /// go on from, and for one that another process writes.
    RenderCheckpoint(std::string resume, std::string path, double interval, Console* console);

    bool IsUsed() const { return resumed_ || !path_.empty(); }
    /// Textures are filtered as when the render began, which may have had another number of samples in mind.
    std::optional<int> FilterSamples() const;
    /// Takes over what was added up before. @param header  of this render
    /// Errors: FileError for a state of something else, or of more samples than are asked for.
    void Attach(StateHeader header, Film* film, AovBuffer* aovs);
    /// Halves as from the beginning, and writes on time.
    void AddTo(RenderOptions* options);
    /// Seconds of the runs before.
    double SecondsBefore() const { return resumed_ ? resumed_->seconds : 0; }
    /// What is added up in the end. @param seconds  of this run  Errors: FileError.
    void Finish(double seconds);

  private:
    void Write(double seconds);

    std::string resume_, path_;
    double interval_;
    Console* console_;
    std::optional<FileLock> lock_;
    std::optional<StateHeader> resumed_;
    std::vector<StoredArray> stored_;
    StateHeader header_;
    Film* film_ = nullptr;
    AovBuffer* aovs_ = nullptr;
};

}  // namespace lacquer::cmd
