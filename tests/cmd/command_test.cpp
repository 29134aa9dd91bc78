// Commands are plugins: what lists them goes over the registry.
#include "cmd/command.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "cmd/command_support.h"
#include "pbrt/core/error.h"
#include "support/scoped_registration.h"

namespace lacquer::cmd::command_test {
namespace {

struct GreetArguments {
    int times = 1;
    std::string command;
};
void AddGreetOptions(CLI::App& app, GreetArguments& a) { app.add_option("--times", a.times, "How often"); }
int greeted = 0;
std::string typed;
int RunGreet(const GreetArguments& a) {
    greeted += a.times;
    typed = a.command;
    return 7;
}

std::string HelpOf(const std::string& name) {
    const auto command = Registry<CommandKind>::Find(name)();
    return MakeApp(name, *command)->help();
}

TEST(RegisteredCommands, AreExactlyThese) {
    EXPECT_EQ(
        Registry<CommandKind>::Names(),
        (std::vector<std::string>{
            "assemble", "average", "bloom",   "bsdf",         "bulk",           "capture",  "cat",
            "compare",  "convert", "denoise", "diff",         "error",          "estimate", "falsecolor",
            "farm",     "help",    "info",    "makeemitters", "makeequiarea",   "makesky",  "materialgan",
            "merge",    "plugins", "preview", "render",       "scalenormalmap", "splitn",   "whitebalance"}));
}

TEST(RegisteredCommands, SayWhatTheyDoAndHowTheyEnd) {
    for (const std::string& name : Registry<CommandKind>::Names()) {
        const CommandKind::Traits traits = Registry<CommandKind>::TraitsOf(name);
        EXPECT_GT(std::string_view(traits.synopsis).size(), 20u) << name;
        const std::string help = HelpOf(name);
        std::istringstream synopsis(traits.synopsis);  // its usage comes last
        for (std::string line; std::getline(synopsis, line);)
            EXPECT_NE(help.find(line), std::string::npos) << name << ": " << line;
        EXPECT_NE(help.find("Exit status"), std::string::npos) << name;
        EXPECT_NE(help.find("--version"), std::string::npos) << name;
    }
}

TEST(RegisteredCommands, ANewOneIsFoundAndListedByItsOwnLine) {
    EXPECT_EQ(HelpOf(kDefaultCommand).find("greet"), std::string::npos);
    const test::ScopedRegistration<CommandKind> greet(
        "greet", CommandOf<GreetArguments, AddGreetOptions, RunGreet>::Make,
        {.synopsis = "Greets.", .footer = "\nExit status: 7."});
    EXPECT_NE(HelpOf(kDefaultCommand).find(" greet help "), std::string::npos) << HelpOf(kDefaultCommand);
    EXPECT_NE(HelpOf("greet").find("--times"), std::string::npos);
    const auto command = Registry<CommandKind>::Find("greet")();
    const auto app = MakeApp("greet", *command);
    app->parse(std::vector<std::string>{"3", "--times"});  // reversed, as CLI11 wants them
    EXPECT_EQ(command->Run(MakeGivenCommand("lacquer greet", {"--times", "3"})), 7);
    EXPECT_EQ(greeted, 3);
    EXPECT_EQ(typed, "lacquer greet --times 3");
}

TEST(CommandSupport, WhatCannotBeWrittenIsAnError) {
    EXPECT_THROW(WriteText("/nowhere/at/all/chain-1.csv", "text"), FileError);
}

}  // namespace
}  // namespace lacquer::cmd::command_test
