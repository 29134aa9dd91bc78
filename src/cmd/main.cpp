// The lacquer command: finds the verb, runs it, and turns errors into messages and exit statuses.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "cmd/bsdf/bsdf_command.h"
#include "cmd/compare/compare_command.h"
#include "cmd/console.h"
#include "cmd/help/command_help.h"
#include "cmd/images/convert_command.h"
#include "cmd/images/diff_command.h"
#include "cmd/images/merge_command.h"
#include "cmd/render/render_command.h"
#include "cmd/report_error.h"
#include "cmd/scenes/info_command.h"
#include "cmd/scenes/plugins_command.h"
#include "cmd/version.h"
#include "pbrt/core/error.h"

namespace lacquer::cmd {
namespace {

constexpr const char* kRenderFooter = R"(
Exit status: 0 the image is complete; 1 wrong usage; 2 the scene is wrong; 3 a file cannot be read or
written; 4 rendered, but with too many invalid samples; 5 the time limit came before --spp was
reached (the image is valid); 130 or 143 stopped by a signal (the image so far is written).)";

constexpr const char* kCompareFooter = R"(
Exit status: 0 the report is written; 1 wrong usage; 2 the scene is wrong; 3 a file cannot be read or
written; 130 or 143 stopped by a signal (the report holds what was finished).)";

constexpr const char* kBsdfFooter = R"(
Exit status: 0 the files are written; 1 wrong usage; 2 the scene is wrong, or has no such material; 3 a
file cannot be read or written.)";

constexpr const char* kDiffFooter = R"(
Prints a line with the names of the columns and one for the whole and each box, with tabs between.
Exit status, as of idiff: 0 measured, and within the tolerance if there is one; 1 wrong usage; 2 above the
tolerance, or values that are NaN or infinite; 3 sizes, channels or colour spaces differ; 4 a file cannot
be read or written.)";

constexpr const char* kConvertFooter = R"(
Exit status: 0 all is done; 1 wrong usage; 2 the scene is wrong, or parts of it cannot be upgraded (the
result is written all the same); 3 a file cannot be read or written, or does not fit.)";

constexpr const char* kInfoFooter = R"(
Exit status: 0 all is told; 1 wrong usage; 2 the scene is wrong; 3 a file cannot be read.)";

constexpr const char* kImageFooter = R"(
Exit status: 0 all is done; 1 wrong usage; 3 a file cannot be read or written, or does not fit.)";

std::string Squeeze(const std::string& name) {
    std::string result;
    for (const char c : name)
        if (c != '-' && c != '_') result += char(std::tolower((unsigned char)c));
    return result;
}

/// pbrt accepts its options with one dash or two, in any case, and with '-' and '_' left out: spells them as
/// CLI11 knows them.
std::vector<std::string> NormalizeOptions(const CLI::App& app, std::vector<std::string> arguments) {
    for (std::string& argument : arguments) {
        if (argument.size() < 3 || argument[0] != '-') continue;
        if (std::isdigit((unsigned char)argument[1]) || argument[1] == '.') continue;  // a negative number
        const size_t equals = argument.find('=');
        const std::string name = Squeeze(argument.substr(0, equals));
        for (const CLI::Option* option : app.get_options())
            for (const std::string& known : option->get_lnames())
                if (Squeeze(known) == name)
                    argument = "--" + known + (equals == std::string::npos ? "" : argument.substr(equals));
    }
    return arguments;
}

std::string NearestOption(const CLI::App& app, const std::vector<std::string>& arguments) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& argument : arguments) {
        const std::string name = argument.substr(0, argument.find('='));
        if (name.size() > 2 && name[0] == '-' && std::find(names.begin(), names.end(), name) == names.end())
            return DidYouMean(name, names);
    }
    return {};
}

/// Reads `words` as options of `app` and calls `run`. @param command  its name in messages
template <class Function>
int ParseAndRun(CLI::App& app, const char* command, std::vector<std::string> words, const Function& run) {
    words = NormalizeOptions(app, std::move(words));
    try {
        std::vector<std::string> reversed(words.rbegin(), words.rend());
        app.parse(reversed);
    } catch (const CLI::Success& e) {
        app.exit(e, std::cout, std::cerr);
        return int(ExitStatus::Complete);
    } catch (const CLI::ParseError& e) {
        Console(ConsoleStyle::Detect(false))
            .Error(fmt::format("{}{} ({} --help lists the options)", e.what(), NearestOption(app, words),
                               command));
        return int(ExitStatus::Usage);
    }
    return int(run());
}

/// The command as a person would type it into a shell.
std::string CommandLine(std::string command, const std::vector<std::string>& words) {
    for (const std::string& word : words) {
        const bool isPlain = !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
            return std::isalnum((unsigned char)c) || std::strchr("-_./,:=@+%", c);
        });
        std::string quoted = "'";
        for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
        command += " " + (isPlain ? word : quoted + "'");
    }
    return command;
}

/// What `lacquer NAME` does, from the words behind the name.
struct Verb {
    const char* name;
    const char* synopsis;  ///< the first lines of its help
    const char* footer;    ///< the last ones: exit statuses
    /// @param help  where not null, it gets the table of options, and nothing is run
    int (*run)(const Verb& verb, std::vector<std::string> words, CommandHelp* help);
};

/// The help of all verbs.
std::vector<CommandHelp> DescribeVerbs();

/// A verb whose options are an `Arguments`, declared by `add` and obeyed by `execute`.
template <class Arguments, auto add, auto execute>
int RunVerb(const Verb& verb, std::vector<std::string> words, CommandHelp* help) {
    // Rendering is what lacquer does without a verb.
    const bool isDefault = verb.name == std::string("render");
    const std::string command = isDefault ? "lacquer" : fmt::format("lacquer {}", verb.name);
    CLI::App app(verb.synopsis, command);
    app.footer(verb.footer);
    Arguments arguments;
    if constexpr (requires { arguments.command; }) arguments.command = CommandLine(command, words);
    add(app, arguments);
    app.set_version_flag("--version", fmt::format("lacquer {}", kVersion));
    if (isDefault) AddHelpAs(app, DescribeVerbs);
    if (help) {
        *help = Describe(app, verb.name);
        return int(ExitStatus::Complete);
    }
    return ParseAndRun(app, command.c_str(), std::move(words), [&] { return execute(arguments); });
}

constexpr Verb kVerbs[] = {
    {"render",
     "Lacquer renders pbrt-v4 scenes.\nUsage: lacquer [render] [OPTIONS] scene.pbrt ...\n"
     "       lacquer compare|bsdf|diff|convert|merge|info|plugins --help\n"
     "Without a scene file, or with -, the scene is read from standard input.",
     kRenderFooter, RunVerb<RenderArguments, AddRenderOptions, RunRender>},
    {"compare",
     "Compares estimators of layered materials at equal time, and makes a report to look at.\n"
     "Usage: lacquer compare [OPTIONS] scene.pbrt ... --out DIR",
     kCompareFooter, RunVerb<CompareArguments, AddCompareOptions, RunCompare>},
    {"bsdf",
     "Shows what a material does to light: lobes, albedo, agreement of the estimators.\n"
     "Usage: lacquer bsdf [OPTIONS] scene.pbrt ... --material NAME --wi THETA,PHI --out DIR",
     kBsdfFooter, RunVerb<BsdfArguments, AddBsdfOptions, RunBsdf>},
    {"diff", "Measures how far an image is from a reference.", kDiffFooter,
     RunVerb<DiffArguments, AddDiffOptions, RunDiff>},
    {"convert",
     "Writes an image in another format, size, exposure or colour space. Crops, resizes, exposes, changes "
     "the\n"
     "colour space and maps the tones, in this order.\n"
     "Writes a scene formatted (--format), with its meshes in PLY files (--toply), or upgraded from pbrt-v3.",
     kConvertFooter, RunVerb<ConvertArguments, AddConvertOptions, RunConvert>},
    {"merge", "Averages renders of one picture, each with the weight of its samples.", kImageFooter,
     RunVerb<MergeArguments, AddMergeOptions, RunMerge>},
    {"plugins", "Lists the names that scene files may use: a line each of kind, tab, name.",
     "\nExit status: 0 the list is complete; 1 wrong usage.",
     RunVerb<PluginsArguments, AddPluginsOptions, RunPlugins>},
    {"info",
     "Tells what images hold: size, channels with their ranges, metadata. Values are linear. Tells what a "
     "scene\n"
     "holds, without rendering it: image, counts, materials, textures, memory, files, and what looks wrong.",
     kInfoFooter, RunVerb<InfoArguments, AddInfoOptions, RunInfo>},
};

std::vector<CommandHelp> DescribeVerbs() {
    std::vector<CommandHelp> all;
    for (const Verb& verb : kVerbs) verb.run(verb, {}, &all.emplace_back());
    return all;
}

int Run(std::vector<std::string> words) {
    for (const Verb& verb : kVerbs)
        if (!words.empty() && words[0] == verb.name) {
            words.erase(words.begin());
            return verb.run(verb, std::move(words), nullptr);
        }
    return kVerbs[0].run(kVerbs[0], std::move(words), nullptr);
}

int RunGuarded(std::vector<std::string> words) {
    Console console(ConsoleStyle::Detect(false));
    try {
        return Run(std::move(words));
    } catch (const std::exception&) {
        return int(ReportError(console));
    }
}

}  // namespace
}  // namespace lacquer::cmd

int main(int argc, char** argv) {
    const int status = lacquer::cmd::RunGuarded(std::vector<std::string>(argv + 1, argv + argc));
    // Results on standard output that did not get there are no success.
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return status;
    lacquer::cmd::Console(lacquer::cmd::ConsoleStyle::Detect(false))
        .Error("standard output cannot be written");
    return status == 0 ? int(lacquer::cmd::ExitStatus::File) : status;
}
