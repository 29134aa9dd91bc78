// What `lacquer NAME` does. A command is a plugin: its file registers it with the first and last lines of its
// help, and dispatch, help, and whatever else lists commands and their options go over the registry.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "pbrt/core/registry.h"

namespace lacquer::cmd {

/// A command line behind the command's name.
struct GivenCommand {
    std::string line;  ///< with the command, as a person would type it into a shell, for reports
    std::vector<std::string> words;  ///< the same, with options spelled as CLI11 knows them
};
/// @param command  "lacquer bsdf"
GivenCommand MakeGivenCommand(const std::string& command, std::vector<std::string> words);

/// A command with room for its arguments; runs once.
class Command {
  public:
    virtual ~Command() = default;
    /// Declares the options on `app`, which fills them in when it parses.
    virtual void AddOptions(CLI::App& app) = 0;
    /// @return  exit status
    /// Errors of the library pass through, for main to report.
    virtual int Run(const GivenCommand& given) = 0;
};

struct CommandKind {
    static constexpr const char* kKind = "command";
    using Factory = std::unique_ptr<Command> (*)();
    struct Traits {
        const char* synopsis = "";  ///< the first lines of its help
        const char* footer = "";    ///< the last ones: exit statuses
    };
};

/// A command whose arguments are a plain struct; `command` and `words`, where it has them, are what was
/// given.
template <class Arguments, void (*add)(CLI::App&, Arguments&), auto run>
class CommandOf final : public Command {
  public:
    static std::unique_ptr<Command> Make() { return std::make_unique<CommandOf>(); }
    void AddOptions(CLI::App& app) override { add(app, arguments_); }
    int Run([[maybe_unused]] const GivenCommand& given) override {
        if constexpr (requires { arguments_.command; }) arguments_.command = given.line;
        if constexpr (requires { arguments_.words; }) arguments_.words = given.words;
        return int(run(arguments_));
    }

  private:
    Arguments arguments_;
};

/// The one that a command line without a name means.
inline constexpr const char* kDefaultCommand = "render";

/// The app that reads the options of `name`: with its help, and named as on the command line.
/// @param command  must outlive it
std::unique_ptr<CLI::App> MakeApp(const std::string& name, Command& command);

}  // namespace lacquer::cmd
