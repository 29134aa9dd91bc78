// The command line of `render`: what it can say, and what that means for a scene.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cmd/render/denoise_render.h"
#include "cmd/sandbox.h"
#include "compare/variation.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/scene_options.h"

namespace lacquer::cmd {

/// Everything that the command line of `render` can say.
struct RenderArguments {
    std::vector<std::string> scenes;  ///< none, or "-": standard input
    std::string outfile;
    std::optional<int> spp;
    GivenOptions options;  ///< those that Option directives can set as well
    int threads = 0;
    bool quiet = false, quick = false, stats = false, writePartialImages = false;
    bool disableImageTextures = false;
    std::string cropWindow, pixelBounds, pixel, resolution, sampleRange;
    std::string displayServer;
    int textureMegabytes = 512;
    std::string textureCache;
    std::string logLevel = "error", logFile;
    std::string estimator, layeredPdf;
    std::optional<double> timeLimit;
    bool adaptive = false;
    std::string noiseTarget;
    std::string statsJson;
    std::vector<std::string> aovs;
    int cryptomatteRanks = 6;
    bool mpi = false;
    bool denoise = false;
    std::string denoiser = "nfor";
    SandboxOptions sandbox;
    std::string frames, summary;               ///< of a sequence
    std::vector<std::string> vary;             ///< a value for each frame
    bool restart = false;                      ///< the sequence
    std::vector<compare::Variation> settings;  ///< of this frame: one value each
    std::string checkpoint, resume;
    std::optional<double> checkpointEvery;
    /// What is kept beside colours: what was asked for, and what the denoiser needs.
    std::vector<std::string> Aovs() const {
        return denoise ? denoise::WithAovsOf(denoise::MethodOf(denoiser), aovs) : aovs;
    }
};

/// Declares the options on `app`.
void AddRenderOptions(CLI::App& app, RenderArguments& arguments);

/// Values that can be judged before the scene is read. Errors: usage.
void CheckArguments(const RenderArguments& arguments);

/// What the arguments say about a scene. Errors: usage.
BuildOptions BuildOptionsOf(const RenderArguments& arguments);

/// --noise-target as a fraction; 0: none. Errors: usage.
double NoiseTargetOf(const RenderArguments& arguments);

/// "a:b" of --sample-range, or all. @param samples  per pixel  Errors: usage.
std::pair<int, int> SampleRangeOf(const RenderArguments& arguments, int samples);

/// From now on, this process touches nothing but what the arguments of all frames allow, and the folder of
/// `summary`. Errors: as EnterSandbox().
void EnterSandboxOf(std::span<const RenderArguments> frames, const std::string& summary);

}  // namespace lacquer::cmd
