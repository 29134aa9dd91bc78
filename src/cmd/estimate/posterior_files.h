// The files of a posterior, for people and for other programs.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "cmd/estimate/estimate_arguments.h"
#include "cmd/estimate/posterior_summary.h"

namespace lacquer::cmd {

/// Everything that the results depend on: settings, version, and a hash of the photograph's file.
nlohmann::ordered_json ConfigOf(const EstimateArguments& arguments, const estimate::PhotoSimulator& simulator,
                                const estimate::PhotographFile& photo, std::string_view photoBytes);
/// Of it: what chains depend on; priors by name; a hash of a file as text.
void AddChainSettings(const EstimateArguments& arguments, nlohmann::ordered_json* config);
nlohmann::ordered_json PriorsOf(const estimate::ParameterSpace& space);
std::string HashText(std::string_view bytes);
/// Errors: FileError that names what differs.
void CheckSameConfig(const std::string& path, const nlohmann::ordered_json& config);

/// chain-1.csv ... as Stan has them, and posterior.json as ArviZ does.
void WriteChains(const std::string& folder, const estimate::PhotoSimulator& simulator,
                 const EstimateArguments& arguments, const PosteriorChains& chains,
                 const estimate::Matrix& predicted, const estimate::Vector& observed);
/// The same of any model. @param names  of what was observed and predicted
void WriteChains(const std::string& folder, const estimate::ParameterSpace& space, const std::string& model,
                 const std::vector<std::string>& names, const EstimateArguments& arguments,
                 const PosteriorChains& chains, const estimate::Matrix& predicted,
                 const estimate::Vector& observed);
/// summary.csv and summary.txt.
void WriteSummary(const std::string& folder, const PosteriorSummary& summary);
/// The table of summary.txt, line by line.
std::vector<std::string> SummaryLines(const PosteriorSummary& summary);
/// Of --map-only.
std::vector<std::string> ModeLines(const estimate::ParameterSpace& space, const estimate::Vector& mode);
/// map.json: the most probable parameters.
void WriteMode(const std::string& folder, const estimate::PhotoSimulator& simulator,
               const estimate::Vector& mode);

/// A JSON file with an object. Errors: FileError, SceneError at the file.
nlohmann::ordered_json ReadJson(const std::string& path);

/// The truth of what was synthetic. Errors: FileError, SceneError at the file for text that is none.
/// @param subject  "photograph", "measurement"
void WriteTruth(const std::string& path, const EstimateArguments& arguments,
                const estimate::PhotoSimulator& simulator, const estimate::Vector& parameters);
std::map<std::string, double> ReadTruth(const std::string& path, const estimate::ParameterSpace& space,
                                        const char* subject);

}  // namespace lacquer::cmd
