// Completions for bash, zsh and fish.
#include <fmt/format.h>

#include <map>

#include "cmd/choices.h"
#include "cmd/help/command_help.h"

namespace lacquer::cmd {

namespace {

/// One word in single quotes; line ends become blanks. @param escapes  what takes the place of some
/// characters
std::string Quote(const std::string& text, const std::map<char, const char*>& escapes) {
    std::string quoted = "'";
    for (const char c : text) {
        const auto escape = escapes.find(c);
        quoted += escape == escapes.end() ? std::string(1, c == '\n' ? ' ' : c) : escape->second;
    }
    return quoted + "'";
}
std::string ZshQuote(const std::string& text) { return Quote(text, {{'\'', "'\\''"}}); }
std::string FishQuote(const std::string& text) { return Quote(text, {{'\'', "\\'"}, {'\\', "\\\\"}}); }

/// Names of the commands with `separator` between; empty for a program without.
std::string Names(const std::vector<CommandHelp>& commands, const char* separator) {
    std::vector<std::string> names;
    for (const CommandHelp& c : commands)
        if (!c.name.empty()) names.push_back(c.name);
    return fmt::format("{}", fmt::join(names, separator));
}

/// What a shell offers for a value.
enum class Offer { Nothing, Choices, Files, Folders };

Offer OfferOf(const OptionHelp& option) {
    if (!option.choices.empty()) return Offer::Choices;
    if (option.value == kFile) return Offer::Files;
    return option.value == kFolder ? Offer::Folders : Offer::Nothing;
}

std::string ChoicesOf(const OptionHelp& option) { return fmt::format("{}", fmt::join(option.choices, " ")); }

// ---- bash ----

/// The variables of a command: all its options, and what there is to offer for the word after `previous`, or
/// for an argument.
std::string BashCase(const CommandHelp& command, const std::string& pattern) {
    const auto offer = [](const OptionHelp& option) -> std::string {
        switch (OfferOf(option)) {
            case Offer::Choices:
                return fmt::format("offer=choices choices='{}'", ChoicesOf(option));
            case Offer::Files:
                return "offer=files";
            case Offer::Folders:
                return "offer=folders";
            case Offer::Nothing:
                return "offer=nothing";
        }
        return {};
    };
    std::string options, positional, values;
    for (const OptionHelp& option : command.options) {
        if (option.isPositional) {
            if (positional.empty()) positional = fmt::format("            {}\n", offer(option));
            continue;
        }
        options += fmt::format(" {}", fmt::join(option.names, " "));
        if (!option.value.empty())
            values += fmt::format("                {}) {} ;;\n", fmt::join(option.names, "|"), offer(option));
    }
    return fmt::format(
        "        {})\n            options='{} '\n{}            case $previous in\n{}            esac ;;\n",
        pattern, options, positional, values);
}

// ---- zsh ----

/// Text within a specification of _arguments, which gives a meaning to colons and brackets.
std::string ZshText(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        if (c == ':' || c == '[' || c == ']' || c == '\\') escaped += '\\';
        escaped += c;
    }
    return escaped;
}

std::string ZshArguments(const CommandHelp& command, const char* indent) {
    std::string text = std::string(indent) + "_arguments";
    for (const OptionHelp& option : command.options) {
        const Offer offer = OfferOf(option);
        const std::string action = offer == Offer::Choices   ? fmt::format("({})", ChoicesOf(option))
                                   : offer == Offer::Files   ? "_files"
                                   : offer == Offer::Folders ? "_files -/"
                                                             : " ";
        for (const std::string& name : option.names) {
            std::string spec = option.isList ? "*:" : ":";
            if (!option.isPositional)
                spec = (option.isList ? "*" : "") + name + "[" + ZshText(option.description) + "]" +
                       (option.value.empty() ? "" : ":");
            if (!option.value.empty())
                spec += ZshText(option.isPositional ? name : option.value) + ":" + action;
            text += fmt::format(" \\\n{}    {}", indent, ZshQuote(spec));
        }
    }
    return text + "\n";
}

// ---- fish ----

std::string FishOptions(const CommandHelp& command, const std::string& condition) {
    std::string text;
    for (const OptionHelp& option : command.options) {
        if (option.isPositional) continue;
        text += fmt::format("complete -c {}{}", command.program, condition);
        for (const std::string& name : option.names)
            text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
        const Offer offer = OfferOf(option);
        if (offer == Offer::Choices)
            text += fmt::format(" -x -a '{}'", ChoicesOf(option));
        else if (offer == Offer::Files)
            text += " -r -F";
        else if (offer == Offer::Folders)
            text += " -x -a '(__fish_complete_directories)'";
        else if (!option.value.empty())
            text += " -x";
        text += " -d " + FishQuote(option.description) + "\n";
    }
    return text;
}

}  // namespace

std::string BashCompletion(const std::vector<CommandHelp>& commands) {
    const std::string program = commands.front().program, names = Names(commands, " ");
    std::string cases;
    for (size_t i = 1; i < commands.size(); ++i) cases += BashCase(commands[i], commands[i].name);
    cases += BashCase(commands.front(), "*");
    return fmt::format(R"(# Completions of {0} for bash. Made by: {0} --help-as bash
_{0}() {{
    local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}}
    local options command= offer=files choices= list= names=()
    COMPREPLY=()
    (( COMP_CWORD > 1 )) && command=${{COMP_WORDS[1]}}
    case $command in
{1}    esac
    [[ $current == -* ]] && offer=choices choices=$options
    # Of names with commas between, the last one.
    [[ $offer == choices && $current == *,* ]] && list=${{current%,*}},
    case $offer in
        choices) mapfile -t COMPREPLY < <(compgen -P "$list" -W "$choices" -- "${{current##*,}}") ;;
        files) mapfile -t COMPREPLY < <(compgen -f -- "$current") ;;
        folders) mapfile -t COMPREPLY < <(compgen -d -- "$current") ;;
    esac
    [[ $offer == f* ]] && compopt -o filenames 2>/dev/null
    if (( COMP_CWORD == 1 )) && [[ $current != -* ]]; then
        mapfile -t names < <(compgen -W '{2}' -- "$current")
        COMPREPLY+=("${{names[@]}}")
    fi
    return 0
}}
complete -F _{0} {0}
)",
                       program, cases, names);
}

std::string ZshCompletion(const std::vector<CommandHelp>& commands) {
    const std::string program = commands.front().program;
    std::string text = fmt::format(
        "#compdef {0}\n# Completions of {0} for zsh. Made by: {0} --help-as zsh\n_{0}() {{\n", program);
    if (commands.size() > 1) {
        text += "    local -a commands=(\n";
        for (const CommandHelp& c : commands)
            text += "        " + ZshQuote(c.name + ":" + ZshText(c.summary)) + "\n";
        text += "    )\n    (( CURRENT == 2 )) && _describe command commands\n    case $words[2] in\n";
        for (const CommandHelp& c : commands)
            text += fmt::format(
                "        {})\n            shift words\n            (( CURRENT-- ))\n{}"
                "            return ;;\n",
                c.name, ZshArguments(c, "            "));
        text += "    esac\n";
    }
    return text + ZshArguments(commands.front(), "    ") + fmt::format("}}\n_{} \"$@\"\n", program);
}

std::string FishCompletion(const std::vector<CommandHelp>& commands) {
    const CommandHelp& main = commands.front();
    std::string text =
        fmt::format("# Completions of {0} for fish. Made by: {0} --help-as fish\n", main.program);
    if (commands.size() == 1) return text + FishOptions(main, "");
    std::string others;
    for (const CommandHelp& c : commands) {
        text += fmt::format("complete -c {} -n __fish_is_first_arg -a {} -d {}\n", c.program, c.name,
                            FishQuote(c.summary));
        if (&c != &main) others += " " + c.name;
    }
    text += FishOptions(main, fmt::format(" -n 'not __fish_seen_subcommand_from{}'", others));
    for (size_t i = 1; i < commands.size(); ++i)
        text +=
            FishOptions(commands[i], fmt::format(" -n '__fish_seen_subcommand_from {}'", commands[i].name));
    return text;
}

}  // namespace lacquer::cmd
