// What command lines understand, taken from their tables of options: manual pages and completions for shells.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace lacquer::cmd {

/// An option or a positional argument.
struct OptionHelp {
    std::vector<std::string> names;    ///< with their dashes; of a positional its name
    std::string value;                 ///< "INT", "A,B,..."; empty: there is none
    std::vector<std::string> choices;  ///< all values that there are; empty: others
    std::string description;
    std::string note;  ///< "required; from 1 to 64; default: 4", or part of it
    bool isPositional = false;
    bool isList = false;  ///< may be given several times
};

/// One app of a program.
struct CommandHelp {
    std::string program;                ///< "lacquer"
    std::string name;                   ///< "bsdf"; empty where a program has no commands
    std::vector<std::string> synopsis;  ///< "lacquer bsdf [OPTIONS] scene.pbrt ...", a line each
    std::string summary;                ///< the first sentence of the description, without its end
    std::string description, footer;    ///< paragraphs of plain text
    std::vector<OptionHelp> options;
};

/// @param name  of the command, if the program has several
CommandHelp Describe(const CLI::App& app, const std::string& name = "");

/// The manual page of a program in section 1, for man. @param commands  the default one comes first
std::string ManPage(const std::vector<CommandHelp>& commands);
/// Completions: commands, options, and values: those of options that have few, or names of files or folders
/// where such are meant (cmd/choices.h), else nothing.
std::string BashCompletion(const std::vector<CommandHelp>& commands);
std::string ZshCompletion(const std::vector<CommandHelp>& commands);
std::string FishCompletion(const std::vector<CommandHelp>& commands);

/// Makes --help tell the lines "Usage: ..." of the description, or else the usage that CLI11 finds.
void TellUsageOnce(CLI::App& app);

/// Adds --help-as FORMAT, which prints the help of the whole program in another format, and ends the parsing
/// (CLI::Success). @param commands  is called where the option is given
void AddHelpAs(CLI::App& app, std::function<std::vector<CommandHelp>()> commands);

}  // namespace lacquer::cmd
