#include "cmd/help/command_help.h"

#include <fmt/format.h>

#include <cstdio>
#include <sstream>

#include "cmd/choices.h"

namespace lacquer::cmd {

namespace {

std::vector<std::string> Lines(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

/// CLI11 writes types and limits as "INT:INT in [1 - 64]", "TEXT:{a,b}", "FLOAT:POSITIVE".
void ReadType(const std::string& type, OptionHelp& option, std::vector<std::string>& notes) {
    const size_t colon = type.find(':');
    option.value = type.substr(0, colon);
    if (colon == std::string::npos) return;
    const std::string limit = type.substr(colon + 1);
    const size_t range = limit.find(" in ["), dash = limit.find(" - ");
    if (range != std::string::npos && dash != std::string::npos && limit.back() == ']') {
        const size_t low = range + 5, high = dash + 3;
        notes.push_back(fmt::format("from {} to {}", limit.substr(low, dash - low),
                                    limit.substr(high, limit.size() - 1 - high)));
    } else if (limit.size() > 2 && limit.front() == '{' && limit.back() == '}') {
        std::istringstream in(limit.substr(1, limit.size() - 2));
        for (std::string choice; std::getline(in, choice, ',');) option.choices.push_back(choice);
        notes.push_back(fmt::format("one of {}", fmt::join(option.choices, ", ")));
    } else {
        std::string lower = limit;
        for (char& c : lower) c = char(std::tolower((unsigned char)c));
        notes.push_back(lower);
    }
}

OptionHelp DescribeOption(const CLI::Option& o) {
    OptionHelp option;
    std::vector<std::string> notes;
    for (const std::string& name : o.get_snames()) option.names.push_back("-" + name);
    for (const std::string& name : o.get_lnames()) option.names.push_back("--" + name);
    option.isPositional = option.names.empty();
    if (option.isPositional) option.names.push_back(o.get_name(true));
    if (o.get_required()) notes.emplace_back("required");
    if (o.get_items_expected_max() > 0) ReadType(o.get_type_name(), option, notes);
    if (!o.get_default_str().empty()) notes.push_back("default: " + o.get_default_str());
    option.isList =
        o.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll || o.get_items_expected_max() > 1;
    option.description = o.get_description();
    option.note = fmt::format("{}", fmt::join(notes, "; "));
    return option;
}

/// Text in lines of at most `width` characters, broken behind `separator` where that is possible.
/// @param indent  what further lines begin with
std::string Wrapped(const std::string& text, char separator, size_t width, const std::string& indent) {
    std::string wrapped;
    size_t column = 0;
    for (size_t begin = 0; begin < text.size();) {
        const size_t end =
            std::min(text.find_first_of(std::string{separator, '\n'}, begin), text.size() - 1) + 1;
        const std::string piece = text.substr(begin, end - begin);
        if (column > 0 && column + piece.size() > width) {
            if (wrapped.back() == ' ') wrapped.pop_back();
            wrapped += "\n" + indent;
            column = indent.size();
        }
        wrapped += piece;
        column = piece.back() == '\n' ? 0 : column + piece.size();
        begin = end;
    }
    return wrapped;
}

/// CLI11's help in lines of 120 characters, with the lines of usage of the description, if it has any, in
/// place of CLI11's own.
class UsageOnce : public CLI::Formatter {
  public:
    std::string make_option_opts(const CLI::Option* option) const override {
        return Wrapped(CLI::Formatter::make_option_opts(option), ',', 90, std::string(8, ' '));
    }
    std::string make_option_desc(const CLI::Option* option) const override {
        return Wrapped(CLI::Formatter::make_option_desc(option), ' ', 120 - get_column_width(), "");
    }
    std::string make_description(const CLI::App* app) const override { return Describe(*app).description; }
    std::string make_usage(const CLI::App* app, std::string) const override {
        return fmt::format("Usage: {}\n", fmt::join(Describe(*app).synopsis, "\n       "));
    }
};

}  // namespace

CommandHelp Describe(const CLI::App& app, const std::string& name) {
    CommandHelp help;
    help.program = app.get_name().substr(0, app.get_name().find(' '));
    help.name = name;
    // Lines of usage in the description are marked, and those that follow are set in to their column.
    const std::string mark = "Usage: ", indent(mark.size(), ' ');
    for (const std::string& line : Lines(app.get_description())) {
        if (line.starts_with(mark) || (line.starts_with(indent) && !help.synopsis.empty()))
            help.synopsis.push_back(line.substr(mark.size()));
        else
            help.description += line + "\n";
    }
    const std::string first = help.description.substr(0, help.description.find_first_of("\n:"));
    help.summary = first.substr(0, std::min(first.find(". "), first.find_last_not_of('.') + 1));
    std::string usage = app.get_name() + " [OPTIONS]";
    for (const CLI::Option* option : app.get_options()) {
        help.options.push_back(DescribeOption(*option));
        const OptionHelp& o = help.options.back();
        if (o.isPositional) usage += " " + o.names[0] + (o.isList ? " ..." : "");
    }
    if (help.synopsis.empty()) help.synopsis.push_back(usage);
    const size_t begin = app.get_footer().find_first_not_of('\n');
    if (begin != std::string::npos) help.footer = app.get_footer().substr(begin) + "\n";
    return help;
}

void TellUsageOnce(CLI::App& app) { app.formatter(std::make_shared<UsageOnce>()); }

void AddHelpAs(CLI::App& app, std::function<std::vector<CommandHelp>()> commands) {
    using Format = std::string (*)(const std::vector<CommandHelp>&);
    static const std::vector<std::pair<std::string, Format>> kFormats = {
        {"man", ManPage}, {"bash", BashCompletion}, {"zsh", ZshCompletion}, {"fish", FishCompletion}};
    std::vector<std::string> names;
    names.reserve(kFormats.size());
    for (const auto& [name, format] : kFormats) names.push_back(name);
    app.add_option_function<std::string>(
           "--help-as",
           [commands = std::move(commands)](const std::string& wanted) {
               for (const auto& [name, format] : kFormats)
                   if (name == wanted) fmt::print("{}", format(commands()));
               throw CLI::Success();
           },
           "Print the help of all commands as a manual page, or as completions for a shell")
        ->check(OneOf(names));
}

}  // namespace lacquer::cmd
