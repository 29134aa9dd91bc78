// The lacquer command: finds the verb, runs it, and turns errors into messages and exit statuses.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <new>

#include "cmd/bsdf_command.h"
#include "cmd/console.h"
#include "cmd/render_command.h"
#include "cmd/version.h"
#include "pbrt/base/film.h"
#include "pbrt/core/check.h"
#include "pbrt/core/error.h"

namespace lacquer {
namespace {

constexpr const char* kFooter = R"(
Exit status: 0 the image is complete; 1 wrong usage; 2 the scene is wrong; 3 a file cannot be read or
written; 4 rendered, but with too many invalid samples; 5 the time limit came before --spp was
reached (the image is valid); 130 or 143 stopped by a signal (the image so far is written).)";

constexpr const char* kBsdfFooter = R"(
Exit status: 0 the files are written; 1 wrong usage; 2 the scene is wrong, or has no such material; 3 a
file cannot be read or written.)";

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

bool IsPlannedVerb(const std::string& word) {
    const std::vector<std::string> verbs{"compare", "merge", "diff", "convert", "info"};
    return std::find(verbs.begin(), verbs.end(), word) != verbs.end() && !std::filesystem::exists(word);
}

/// Reads `words` as options of `app` and calls `run`. @param command  its name in messages
template <class Function>
ExitStatus ParseAndRun(CLI::App& app, const char* command, std::vector<std::string> words,
                       const Function& run) {
    app.set_version_flag("--version", fmt::format("lacquer {}", kVersion));
    words = NormalizeOptions(app, std::move(words));
    try {
        std::vector<std::string> reversed(words.rbegin(), words.rend());
        app.parse(reversed);
    } catch (const CLI::Success& e) {
        app.exit(e, std::cout, std::cerr);
        return ExitStatus::Complete;
    } catch (const CLI::ParseError& e) {
        Console(ConsoleStyle::Detect(false))
            .Error(fmt::format("{}{} ({} --help lists the options)", e.what(), NearestOption(app, words),
                               command));
        return ExitStatus::Usage;
    }
    return run();
}

ExitStatus RunRenderVerb(std::vector<std::string> words) {
    CLI::App app(
        "Lacquer renders pbrt-v4 scenes.\nUsage: lacquer [render] [OPTIONS] scene.pbrt ...\n"
        "       lacquer bsdf --help\n"
        "Without a scene file, the scene is read from standard input.",
        "lacquer");
    app.footer(kFooter);
    RenderArguments arguments;
    AddRenderOptions(app, arguments);
    return ParseAndRun(app, "lacquer", std::move(words), [&] { return RunRender(arguments); });
}

ExitStatus RunBsdfVerb(std::vector<std::string> words) {
    CLI::App app(
        "Shows what a material does to light: lobes, albedo, agreement of the estimators.\nUsage: lacquer "
        "bsdf "
        "[OPTIONS] scene.pbrt ... --material NAME --wi THETA,PHI --out DIR",
        "lacquer bsdf");
    app.footer(kBsdfFooter);
    BsdfArguments arguments;
    AddBsdfOptions(app, arguments);
    return ParseAndRun(app, "lacquer bsdf", std::move(words), [&] { return RunBsdf(arguments); });
}

ExitStatus Run(std::vector<std::string> words) {
    if (!words.empty() && IsPlannedVerb(words[0])) {
        Console(ConsoleStyle::Detect(false))
            .Error(fmt::format("the verb \"{}\" is not in this version of Lacquer yet", words[0]));
        return ExitStatus::Usage;
    }
    const std::string verb = words.empty() ? "" : words[0];
    if (verb == "render" || verb == "bsdf") words.erase(words.begin());
    return verb == "bsdf" ? RunBsdfVerb(std::move(words)) : RunRenderVerb(std::move(words));
}

ExitStatus RunGuarded(std::vector<std::string> words) {
    Console console(ConsoleStyle::Detect(false));
    try {
        return Run(std::move(words));
    } catch (const SceneErrors& e) {
        for (const Diagnostic& d : e.Diagnostics()) console.Error(d);
        const bool filesOnly =
            std::all_of(e.Diagnostics().begin(), e.Diagnostics().end(),
                        [](const Diagnostic& d) { return d.cause == Diagnostic::Cause::File; });
        return filesOnly ? ExitStatus::File : ExitStatus::Scene;
    } catch (const SceneError& e) {
        console.Error(
            Diagnostic{Diagnostic::Severity::Error, e.Loc(), e.Message(), Diagnostic::Cause::Scene});
        return ExitStatus::Scene;
    } catch (const FileError& e) {
        console.Error(Diagnostic{Diagnostic::Severity::Error, e.Loc(), e.Message(), Diagnostic::Cause::File});
        return ExitStatus::File;
    } catch (const std::bad_alloc&) {
        console.Error("not enough memory for this scene");
        return ExitStatus::Scene;
    } catch (const CLI::ValidationError& e) {
        console.Error(e.what());
        return ExitStatus::Usage;
    } catch (const OverrideError& e) {
        console.Error(e.what());
        return ExitStatus::Usage;
    } catch (const std::exception& e) {
        console.Error(fmt::format("this is a bug in Lacquer: {}", e.what()));
        return ExitStatus::Internal;
    }
}

}  // namespace
}  // namespace lacquer

int main(int argc, char** argv) {
    return int(lacquer::RunGuarded(std::vector<std::string>(argv + 1, argv + argc)));
}
