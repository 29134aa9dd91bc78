// What the state of a render belongs to, and what it holds: the first part of a state file.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cmd/render/state_parts.h"
#include "pbrt/film/aov.h"
#include "pbrt/film/passes.h"
#include "pbrt/scene/builder.h"

namespace lacquer::cmd {

/// What a state belongs to: only what has the same program, scene and settings can be added.
struct StateHeader {
    nlohmann::ordered_json program, scene, settings;
    nlohmann::ordered_json film = {};   ///< FilmRecord()
    std::string name = {};              ///< of the scene
    std::string samplerValues = {};     ///< a hash of some
    int samplesPerPixel = 0;            ///< of the sampler
    Bounds2i pixels = {};               ///< of the arrays
    std::vector<StatePart> parts = {};  ///< what they hold, no sample twice
    int filterSamples = 0;              ///< for which textures are filtered
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
/// x0, x1, y0, y1, as --pixelbounds has them.
nlohmann::ordered_json BoundsJson(const Bounds2i& pixels);
/// The same in brackets: "[x0, x1, y0, y1]".
std::string PixelsInWords(const Bounds2i& pixels);

}  // namespace lacquer::cmd
