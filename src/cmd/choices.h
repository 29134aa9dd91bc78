// Options whose values are names.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace lacquer::cmd {

/// What an option or a positional argument expects, in help texts and for completions, where it is a path.
inline constexpr const char *kFile = "FILE", *kFolder = "FOLDER";

/// `unknown "x"; did you mean "y"? (known: y, z)`, or empty where `name` is one of `known`.
std::string WhyUnknown(const std::string& name, const std::vector<std::string>& known);

/// For CLI::Option::check(): a value is one of `names`, which help texts list and completions offer.
CLI::Validator OneOf(std::vector<std::string> names);
/// The same, but what a value may be says `why`, which returns an empty text or what is wrong with it.
CLI::Validator OneOf(const std::vector<std::string>& names,
                     std::function<std::string(const std::string&)> why);
/// A number above 0. (CLI11 has such a check, whose message spells out the largest of all numbers.)
CLI::Validator Positive();
/// A whole number of 64 bits, 0 or more; the same of its message.
CLI::Validator Unsigned();

/// Finite numbers with commas between and nothing else; empty if it is not that.
std::vector<double> NumbersBetweenCommas(const std::string& text);

/// Usage error (CLI::ValidationError) by WhyUnknown(), for names that are not known before something is read.
/// @param option  as on the command line: "--channels"
void CheckName(const char* option, const std::string& name, const std::vector<std::string>& known);

/// Options of numbers take finite ones only: ranges of CLI11 let NaN pass, and no option means it.
void ExpectFiniteNumbers(CLI::App& app);

/// How often a render writes its state. @param seconds  none: as RenderCheckpoint has it
void AddCheckpointInterval(CLI::App& app, std::optional<double>& seconds);

}  // namespace lacquer::cmd
