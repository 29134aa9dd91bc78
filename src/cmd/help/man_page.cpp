// Manual pages, in the macros of man(7).
#include <fmt/format.h>

#include <sstream>

#include "cmd/help/command_help.h"
#include "cmd/version.h"

namespace lacquer::cmd {

namespace {

/// Plain text as roff: nothing in it is a command.
std::string Roff(const std::string& text) {
    std::string roff;
    for (const char c : text) {
        // At the beginning of a line, these would start a request.
        if ((c == '.' || c == '\'') && (roff.empty() || roff.back() == '\n')) roff += "\\&";
        if (c == '\\')
            roff += "\\e";
        else if (c == '-')
            roff += "\\-";
        else
            roff += c;
    }
    return roff;
}

std::string Bold(const std::string& text) { return "\\fB" + Roff(text) + "\\fR"; }
std::string Italic(const std::string& text) { return "\\fI" + Roff(text) + "\\fR"; }

/// Lines that end a sentence end a line; paragraphs stay.
std::string Paragraphs(const std::string& text) {
    std::string roff;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);)
        roff += line.find_first_not_of(' ') == std::string::npos ? ".PP\n" : Roff(line) + "\n";
    return roff;
}

std::string OptionText(const OptionHelp& option) {
    std::string text = ".TP\n";
    if (option.isPositional) {
        text += Italic(option.names[0]) + (option.isList ? " ..." : "");
    } else {
        for (size_t i = 0; i < option.names.size(); ++i) text += (i ? ", " : "") + Bold(option.names[i]);
        if (!option.value.empty()) text += " " + Italic(option.value);
    }
    text += "\n" + Roff(option.description);
    if (!option.note.empty()) text += Roff(fmt::format(" ({})", option.note));
    return text + "\n";
}

std::string OptionTexts(const CommandHelp& command) {
    std::string text;
    for (const bool positional : {true, false})
        for (const OptionHelp& option : command.options)
            if (option.isPositional == positional) text += OptionText(option);
    return text;
}

}  // namespace

std::string ManPage(const std::vector<CommandHelp>& commands) {
    const CommandHelp& main = commands.front();
    std::string title = main.program;
    for (char& c : title) c = char(std::toupper((unsigned char)c));
    // No date: the page of one version is always the same.
    std::string page =
        fmt::format(".TH {} 1 \"\" \"Lacquer {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
                    title, kVersion, main.program, Roff(main.summary));
    for (const CommandHelp& command : commands)
        for (const std::string& line : command.synopsis) page += ".br\n" + Roff(line) + "\n";
    page += ".SH DESCRIPTION\n" + Paragraphs(main.description) + ".SH OPTIONS\n" + OptionTexts(main);
    if (!main.footer.empty()) page += ".PP\n" + Paragraphs(main.footer);
    if (commands.size() > 1) page += ".SH COMMANDS\n";
    for (size_t i = 1; i < commands.size(); ++i) {
        const CommandHelp& c = commands[i];
        page +=
            fmt::format(".SS \"{} {}\"\n", c.program, c.name) + Paragraphs(c.description) + OptionTexts(c);
        if (!c.footer.empty()) page += ".PP\n" + Paragraphs(c.footer);
    }
    return page;
}

}  // namespace lacquer::cmd
