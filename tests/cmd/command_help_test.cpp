// Manual pages and completions, from a program that is made up. tests/install shows the real ones to man and
// to shells.
#include "cmd/help/command_help.h"

#include <gtest/gtest.h>

#include "cmd/choices.h"

namespace lacquer::cmd::command_help_test {
namespace {

/// A program "mill" with the commands "grind" (the default) and "sift".
class Mill : public testing::Test {
  protected:
    Mill() {
        grind_.footer("\n.5 is no request.\nExit status: 0 ground.");
        grind_.add_option("--fineness,-f", fineness_, "How fine [grit]: it's \\up to you")
            ->check(CLI::Range(1, 9))
            ->capture_default_str();
        grind_.add_option("grain", grain_, "What to grind")->required();
        grind_.add_option("--mesh", flour_, "Of the flour")->type_name(kFile);
        grind_.add_option("--store", store_, "Where it goes")->type_name(kFolder);
        sift_.add_option("--mesh", mesh_, "Of the sieve")->check(OneOf({"fine", "coarse"}));
        sift_.add_flag("--shake", shake_, "'quoted' flag");
    }
    std::vector<CommandHelp> Help() const { return {Describe(grind_, "grind"), Describe(sift_, "sift")}; }

    CLI::App grind_{"Grinds grain. Slowly.\nUsage: mill [grind] GRAIN\n       mill sift", "mill"};
    CLI::App sift_{"Sifts flour.", "mill sift"};
    int fineness_ = 4;
    std::vector<std::string> grain_;
    std::string flour_, store_, mesh_;
    bool shake_ = false;
};

void ExpectHas(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nis not in\n" << text;
}

TEST_F(Mill, OptionsAreThoseOfTheTable) {
    const CommandHelp help = Help()[0];
    EXPECT_EQ(help.program, "mill");
    EXPECT_EQ(help.summary, "Grinds grain");
    EXPECT_EQ(help.synopsis, (std::vector<std::string>{"mill [grind] GRAIN", "mill sift"}));
    EXPECT_EQ(help.description, "Grinds grain. Slowly.\n");
    ASSERT_EQ(help.options.size(), 5u);  // the first is --help
    EXPECT_EQ(help.options[1].names, (std::vector<std::string>{"-f", "--fineness"}));
    EXPECT_EQ(help.options[1].value, "INT");
    EXPECT_EQ(help.options[1].note, "from 1 to 9; default: 4");
    EXPECT_TRUE(help.options[2].isPositional);
    EXPECT_TRUE(help.options[2].isList);
    EXPECT_EQ(help.options[2].note, "required");
}

TEST_F(Mill, ChoicesAreKnownAndFlagsHaveNoValue) {
    const CommandHelp help = Help()[1];
    EXPECT_EQ(help.synopsis, std::vector<std::string>{"mill sift [OPTIONS]"});
    EXPECT_EQ(help.options[1].choices, (std::vector<std::string>{"fine", "coarse"}));
    EXPECT_EQ(help.options[2].value, "");
}

TEST_F(Mill, NothingInTheTextIsARequestOfRoff) {
    const std::string page = ManPage(Help());
    ExpectHas(page, "it's \\eup to you");
    ExpectHas(page, "\n\\&.5 is no request.\n");
    ExpectHas(page, "\\fB\\-\\-mesh\\fR \\fITEXT\\fR");
    ExpectHas(page, ".SS \"mill sift\"");
    for (size_t i = page.find("\n'"); i != std::string::npos; i = page.find("\n'", i + 1))
        ADD_FAILURE() << page;
}

TEST_F(Mill, TextsAreQuotedForEachShell) {
    ExpectHas(BashCompletion(Help()), "options=' -h --help --mesh --shake '");
    ExpectHas(ZshCompletion(Help()), "'--shake['\\''quoted'\\'' flag]'");
    ExpectHas(ZshCompletion(Help()), "'--fineness[How fine \\[grit\\]\\: it'\\''s \\\\up to you]:INT: '");
    ExpectHas(FishCompletion(Help()), "-l shake -d '\\'quoted\\' flag'");
    ExpectHas(FishCompletion(Help()), "-l fineness -x -d 'How fine [grit]: it\\'s \\\\up to you'");
}

// Option names that two commands share mean what they mean in each.
TEST_F(Mill, ShellsOfferChoicesFilesAndFoldersAndElseNothing) {
    const std::string bash = BashCompletion(Help()), zsh = ZshCompletion(Help()),
                      fish = FishCompletion(Help());
    ExpectHas(bash, "--mesh) offer=files ;;");
    ExpectHas(bash, "--store) offer=folders ;;");
    ExpectHas(bash, "-f|--fineness) offer=nothing ;;");
    ExpectHas(bash, "--mesh) offer=choices choices='fine coarse' ;;");
    ExpectHas(zsh, "FILE:_files'");
    ExpectHas(zsh, "FOLDER:_files -/'");
    ExpectHas(zsh, "TEXT:(fine coarse)'");
    ExpectHas(fish, "-l mesh -r -F");
    ExpectHas(fish, "-l store -x -a '(__fish_complete_directories)'");
    ExpectHas(fish, "-l mesh -x -a 'fine coarse'");
}

TEST_F(Mill, ANameThatIsNoChoiceIsAUsageError) {
    const auto error = [&](const std::string& arguments) -> std::string {
        try {
            sift_.parse(arguments);
        } catch (const CLI::ValidationError& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(error("--mesh coarse"), "");
    EXPECT_EQ(error("--mesh coars"),
              "--mesh: unknown \"coars\"; did you mean \"coarse\"? (known: fine, coarse)");
}

TEST_F(Mill, HelpAsPrintsAndEndsTheParsing) {
    AddHelpAs(sift_, [&] { return Help(); });
    testing::internal::CaptureStdout();
    EXPECT_THROW(sift_.parse("--help-as fish"), CLI::Success);
    ExpectHas(testing::internal::GetCapturedStdout(), "complete -c mill");
    EXPECT_THROW(sift_.parse("--help-as pdf"), CLI::ValidationError);
}

}  // namespace
}  // namespace lacquer::cmd::command_help_test
