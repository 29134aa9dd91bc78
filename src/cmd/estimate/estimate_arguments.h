// What the command line of `lacquer estimate` says, and what follows from it.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimate/photo/photograph_file.h"
#include "estimate/photo_simulator.h"

namespace lacquer::cmd {

struct EstimateArguments {
    std::string command;  ///< the command line, as it was given
    std::string photo, model, out, crop, tone = "srgb", priorSet = "test", simulate, truth;
    std::vector<std::string> fixed, free, priors, summaries;
    std::optional<double> size, distance, fieldOfView;
    std::string brdf = "smith", cells = "jittered", noise = "spectral", vgg;
    std::string method = "emulated", sampler, error = "calibrated";
    int seeds = 4;
    double checkpointEvery = 60;
    std::optional<double> timeLimit;
    int resolution = 256, simulatedResolution = 512, samples = 2000, chains = 4, warmup = 1000, mapSize = 0,
        threads = 0, calibration = 0;
    double mapExtent = 0;
    uint64_t seed = 1;
    // Of measurements of layers.
    std::string scene, material, candidates;
    bool robust = false;
    bool quiet = false, resume = false, listModels = false, json = false, mapOnly = false, explain = false;
};

void AddEstimateOptions(CLI::App& app, EstimateArguments& arguments);

/// "NAME=normal(MEAN,SD,LOW,HIGH)" of --prior. Errors: usage.
std::pair<std::string, estimate::Prior> NamedPriorOf(const std::string& option);

/// The model that is asked for. Errors: usage.
const estimate::MaterialModel& ModelOf(const EstimateArguments& arguments);
/// Fixed values, priors and optional parameters by name. Errors: usage, with the nearest name.
estimate::FreeParameters FreeParametersOf(const EstimateArguments& arguments,
                                          const estimate::MaterialModel& model);
/// The error that is set by hand, or nothing. Errors: usage.
std::optional<double> HandError(const EstimateArguments& arguments);
/// An option that would change nothing is a mistake that its user should hear of. Errors: usage, if it is
/// given.
/// @param why  how the sentence "--option has no effect" goes on
void RefuseIneffective(bool isGiven, const std::string& option, const std::string& why);
/// Usage errors of options that have no effect with --model.
void CheckModelArguments(const EstimateArguments& arguments);
/// Usage errors of options that do not go together.
void CheckMethod(const EstimateArguments& arguments);
/// Kinds of cells and noise that are possible: those that are named, or all that the model has where they are
/// "any".
std::vector<estimate::ModelKinds> KindsOf(const EstimateArguments& arguments,
                                          const estimate::MaterialModel& model);
/// "noise ridged", "cells stretched, noise spectral": what the model has of them.
std::string NameOf(const estimate::ModelKinds& kinds, const estimate::MaterialModel& model);
/// How the photograph was taken, with the first of the kinds and without weights for "vgg". @param file  what
/// was read, or null where one is made
estimate::PhotoSettings PhotoSettingsOf(const EstimateArguments& arguments,
                                        const estimate::PhotographFile* file);
/// Errors: usage, for a crop that is none.
estimate::PhotographReading ReadingOf(const EstimateArguments& arguments);
/// The simulator of all that. Errors: usage.
std::unique_ptr<estimate::PhotoSimulator> SimulatorOf(const EstimateArguments& arguments,
                                                      const estimate::PhotoSettings& settings,
                                                      const std::vector<std::string>& families);
/// Errors: usage, if nothing is left to be estimated.
void CheckSomethingIsFree(const estimate::PhotoSimulator& simulator);

}  // namespace lacquer::cmd
