#include "cmd/choices.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "pbrt/core/error.h"

namespace lacquer::cmd {

std::string WhyUnknown(const std::string& name, const std::vector<std::string>& known) {
    if (std::find(known.begin(), known.end(), name) != known.end()) return {};
    if (known.empty()) return fmt::format("unknown \"{}\" (there are none)", Excerpt(name));
    return fmt::format("unknown \"{}\"{} (known: {})", Excerpt(name), DidYouMean(name, known),
                       fmt::join(known, ", "));
}

CLI::Validator OneOf(std::vector<std::string> names) {
    const std::vector<std::string> listed = names;
    return OneOf(listed,
                 [names = std::move(names)](const std::string& value) { return WhyUnknown(value, names); });
}

CLI::Validator OneOf(const std::vector<std::string>& names,
                     std::function<std::string(const std::string&)> why) {
    return {[why = std::move(why)](std::string& value) {
                return value.empty() ? std::string("the value is empty") : why(value);
            },
            fmt::format("{{{}}}", fmt::join(names, ","))};
}

CLI::Validator Positive() {
    return {[](std::string& text) {
                double value = 0;
                const bool isPositive = CLI::detail::lexical_cast(text, value) && value > 0;
                return isPositive ? std::string() : Excerpt(text) + "; expected a number above 0";
            },
            "POSITIVE"};
}

CLI::Validator Unsigned() {
    return {[](std::string& text) {
                uint64_t value = 0;
                const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
                const bool isRead = error == std::errc() && end == text.data() + text.size();
                return isRead ? std::string() : Excerpt(text) + "; expected a whole number, 0 or more";
            },
            "NONNEGATIVE"};
}

void ExpectFiniteNumbers(CLI::App& app) {
    const auto isNumber = [](CLI::Option* option) { return option->get_type_name().starts_with("FLOAT"); };
    for (CLI::Option* option : app.get_options(isNumber))
        option->transform(CLI::Validator(
            [](std::string& text) {
                double value = 0;
                const bool isRead = CLI::detail::lexical_cast(text, value);
                return isRead && !std::isfinite(value)
                           ? fmt::format("\"{}\" is not a finite number", Excerpt(text))
                           : std::string();
            },
            ""));
}

void AddCheckpointInterval(CLI::App& app, std::optional<double>& seconds) {
    app.add_option(
           "--checkpoint-every", seconds,
           "Seconds of rendering between states; default: 600, or as many as keep their cost at 1 % of "
           "the time")
        ->check(CLI::Range(0.1, 1e9));
}

void CheckName(const char* option, const std::string& name, const std::vector<std::string>& known) {
    if (const std::string why = WhyUnknown(name, known); !why.empty())
        throw CLI::ValidationError(fmt::format("{}: {}", option, why));
}

std::vector<double> NumbersBetweenCommas(const std::string& text) {
    std::vector<double> numbers;
    std::istringstream in(text);
    char comma = ',';
    double number = 0;
    while (comma == ',' && in >> number) {
        if (!std::isfinite(number)) return {};
        numbers.push_back(number);
        comma = 0;
        in >> comma;
    }
    return in.eof() && comma == 0 ? numbers : std::vector<double>();
}

}  // namespace lacquer::cmd
