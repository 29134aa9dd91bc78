#include "pbrt/core/json_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lacquer {
namespace {

/// What nlohmann says of a text that is no JSON, without the place, and without what was read last: a place
/// of ours stands before it.
std::string ProblemOf(const JsonReader::Json::parse_error& error) {
    const std::string_view what = error.what();
    const size_t dash = what.find(" - ");
    if (dash == std::string_view::npos) return "this is no JSON";
    const std::string_view problem = what.substr(dash + 3), read = "; last read: ", expected = "; expected ";
    const size_t end = problem.rfind(expected);
    return fmt::format("this is no JSON: {}{}", problem.substr(0, std::min(problem.find(read), end)),
                       end == std::string_view::npos ? "" : problem.substr(end));
}

}  // namespace

JsonReader::JsonReader(std::string_view text, const std::string& path, const char* what)
    : text_(text), places_(text, path) {
    // Beyond this nobody wants to follow: what writes JSON recurses.
    constexpr int kMaxDepth = 64;
    if (const FileLoc deep = places_.FindDeeperThan(kMaxDepth); deep.line > 0)
        throw SceneError(deep, fmt::format("brackets are nested more than {} deep", kMaxDepth));
    try {
        root_ = Json::parse(text_);
    } catch (const Json::parse_error& error) {
        throw SceneError(places_.LocOf(error.byte > 0 ? error.byte - 1 : 0), ProblemOf(error));
    } catch (const Json::out_of_range& error) {
        // "... number overflow parsing '1e999'"
        std::string number = error.what();
        number = number.substr(number.find('\'') + 1);
        number = number.substr(0, number.find('\''));
        throw SceneError(places_.LocOf(std::min(text_.find(number), text_.size())),
                         fmt::format("{} is beyond the range of numbers", Excerpt(number)));
    }
    if (const FileLoc twice = places_.FindRepeatedKey(); twice.line > 0)
        throw SceneError(twice, "this key stands in the file twice");
    if (!root_.is_object()) Fail("", fmt::format("found {}; expected an object, {}", KindOf(root_), what));
}

std::string JsonReader::KindOf(const Json& value) {
    switch (value.type()) {
        case Json::value_t::null:
            return "null";
        case Json::value_t::object:
            return "an object";
        case Json::value_t::array:
            return fmt::format("a list of {}", value.size());
        case Json::value_t::string:
            return fmt::format("\"{}\"", Excerpt(value.get_ref<const std::string&>()));
        default:
            return Excerpt(value.dump());
    }
}

void JsonReader::Fail(const std::string& pointer, const std::string& message) const {
    throw SceneError(places_.Find(pointer), message);
}

const JsonReader::Json& JsonReader::At(const std::string& pointer) const {
    const Json::json_pointer at(pointer);
    if (!root_.contains(at)) Fail(pointer, fmt::format("there is no \"{}\"", at.back()));
    return root_.at(at);
}

void JsonReader::CheckKeys(const std::string& pointer, const std::vector<std::string>& known) const {
    const Json& object = At(pointer);
    if (!object.is_object()) Fail(pointer, fmt::format("found {}; expected an object", KindOf(object)));
    for (const auto& [key, value] : object.items())
        if (std::find(known.begin(), known.end(), key) == known.end())
            throw SceneError(places_.FindKey(pointer, key),
                             fmt::format("unknown key \"{}\"{}", Excerpt(key), DidYouMean(key, known)));
}

void JsonReader::Require(const std::string& pointer, const Json& expected, const char* advice) const {
    const Json& value = At(pointer);
    if (value != expected)
        Fail(pointer, fmt::format("found {}; expected {}{}", KindOf(value), expected.dump(), advice));
}

double JsonReader::Number(const std::string& pointer, const Json& value, double low, double high) const {
    const double number = value.is_number() ? value.get<double>() : kInf;
    if (number >= low && number <= high && std::isfinite(number)) return number;
    if (std::isinf(low)) Fail(pointer, fmt::format("found {}; expected a finite number", KindOf(value)));
    Fail(pointer, std::isinf(high)
                      ? fmt::format("found {}; expected a number of at least {}", KindOf(value), low)
                      : fmt::format("found {}; expected a number in [{}, {}]", KindOf(value), low, high));
}

std::vector<double> JsonReader::Numbers(const std::string& pointer, std::optional<Length> length, double low,
                                        double high) const {
    const Json& list = At(pointer);
    if (!list.is_array()) Fail(pointer, fmt::format("found {}; expected a list of numbers", KindOf(list)));
    if (length && list.size() != length->count)
        Fail(pointer, fmt::format("this list has {} numbers; expected {}, {}", list.size(), length->count,
                                  length->why));
    std::vector<double> numbers;
    for (size_t i = 0; i < list.size(); ++i) {
        const Json& value = list[i];
        const double number = value.is_number() ? value.get<double>() : kInf;
        // Names are made for errors only.
        const bool isFine = number >= low && number <= high && std::isfinite(number);
        numbers.push_back(isFine ? number : Number(fmt::format("{}/{}", pointer, i), value, low, high));
    }
    return numbers;
}

void JsonReader::RequireGrowing(const std::string& pointer, const std::vector<double>& numbers,
                                double step) const {
    for (size_t i = 1; i < numbers.size(); ++i)
        if (!(numbers[i] - numbers[i - 1] >= step))
            Fail(fmt::format("{}/{}", pointer, i),
                 fmt::format("{} stands after {}; expected numbers that grow by {} or more", numbers[i],
                             numbers[i - 1], step));
}

}  // namespace lacquer
