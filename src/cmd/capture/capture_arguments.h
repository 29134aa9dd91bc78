// What the command line of `lacquer capture` says.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "capture/svbrdf/scene_export.h"
#include "capture/views.h"

namespace lacquer::cmd {

/// Of fits with a generator.
struct PriorArguments {
    std::string file = kNoPrior, optimizer = "adam", features = "none", start;
    std::optional<double> weight;
    int iterations = 240, strategy = 2;
    bool trust = false;  ///< whatever the photographs say

    static constexpr const char* kNoPrior = "none";
    bool IsGiven() const { return file != kNoPrior; }
};

struct CaptureArguments {
    std::string command;              ///< the command line, as it was given
    std::vector<std::string> words;   ///< its words
    std::vector<std::string> photos;  ///< files, or folders of them
    std::string out, card, views, response, light, flash, as = "svbrdf";
    std::optional<double> size, depth;  ///< of the card [cm]
    double totalVariation = 0.003;
    std::optional<double> focal, timeLimit;
    int iterations = 500, refine = 300, holdOut = 0, numFrames = 0, threads = 0;
    std::optional<int> resolution, finalResolution;
    bool resume = false, quiet = false;
    PriorArguments prior;

    double CardSize() const { return size.value_or(17); }
    double CardDepth() const { return depth.value_or(0.1); }
};

void AddCaptureOptions(CLI::App& app, CaptureArguments& arguments);
/// --strategy, --optimizer, --features and --start.
std::vector<CLI::Option*> AddLatentMoves(CLI::App& app, PriorArguments& arguments);

/// Errors of all of these: usage.
void CheckCaptureArguments(const CaptureArguments& arguments);
/// Texels along an edge at which maps are fitted first, and those that they have in the end.
struct CaptureSizes {
    int first, last;
};
/// @param generatorSize  what a generator makes; 0: there is none. Errors: usage.
CaptureSizes SizesOf(const CaptureArguments& arguments, int generatorSize = 0);
capture::Response ResponseOf(const CaptureArguments& arguments);
capture::ExportAs ExportOf(const CaptureArguments& arguments);
/// Power of the light that is given, or nothing where it is to be found.
std::optional<std::array<double, 3>> LightPowerOf(const CaptureArguments& arguments);
/// Whether the light's power is to be found.
bool FitsLight(const CaptureArguments& arguments);
/// Where the light is, in the frame of the camera [cm].
std::array<double, 3> FlashOf(const CaptureArguments& arguments);

}  // namespace lacquer::cmd
