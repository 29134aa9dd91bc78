// What `lacquer NAME` does. A command is a plugin: its file registers it with the first and last lines of its
// help, and dispatch, help, and whatever else lists commands and their options go over the registry.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "pbrt/core/registry.h"

namespace lacquer::cmd {

/// A command with room for its arguments; runs once.
class Command {
  public:
    virtual ~Command() = default;
    /// Declares the options on `app`, which fills them in when it parses.
    virtual void AddOptions(CLI::App& app) = 0;
    /// @param line  the command as a person would type it, for reports
    /// @return      exit status
    /// Errors of the library pass through, for main to report.
    virtual int Run(const std::string& line) = 0;
};

struct CommandKind {
    static constexpr const char* kKind = "command";
    using Factory = std::unique_ptr<Command> (*)();
    struct Traits {
        const char* synopsis = "";  ///< the first lines of its help
        const char* footer = "";    ///< the last ones: exit statuses
    };
};

/// A command whose arguments are a plain struct.
template <class Arguments, void (*add)(CLI::App&, Arguments&), auto run>
class CommandOf final : public Command {
  public:
    static std::unique_ptr<Command> Make() { return std::make_unique<CommandOf>(); }
    void AddOptions(CLI::App& app) override { add(app, arguments_); }
    int Run([[maybe_unused]] const std::string& line) override {
        if constexpr (requires { arguments_.command; }) arguments_.command = line;
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
