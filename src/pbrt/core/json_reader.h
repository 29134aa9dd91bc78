// Reading JSON texts that people write: everything that is wrong is an error with its place.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/json_places.h"

namespace lacquer {

/// A JSON text with checks. Values are named by JSON pointers [RFC 6901]; errors of all members are
/// SceneErrors with line and column, and say what was found and what was expected.
class JsonReader {
  public:
    using Json = nlohmann::ordered_json;  ///< keys keep their order

    /// @param text  must outlive the object; its brackets may be nested 64 deep, and no object has a key
    /// twice
    /// @param path  for messages
    /// @param what  ends the message about a text that is no object: "expected an object, {}"
    JsonReader(std::string_view text, const std::string& path, const char* what);

    static constexpr double kInf = std::numeric_limits<double>::infinity();
    /// How many numbers a list must have, and why.
    struct Length {
        size_t count;
        const char* why;
    };

    const Json& Root() const { return root_; }
    [[noreturn]] void Fail(const std::string& pointer, const std::string& message) const;
    /// Where a value stands, or the last one on the way there that exists.
    FileLoc PlaceOf(const std::string& pointer) const { return places_.Find(pointer); }
    bool Has(const std::string& pointer) const { return root_.contains(Json::json_pointer(pointer)); }
    /// The value, which must be there.
    const Json& At(const std::string& pointer) const;
    /// The value is an object, and has no other keys.
    void CheckKeys(const std::string& pointer, const std::vector<std::string>& known) const;
    /// The value is this one.
    void Require(const std::string& pointer, const Json& expected, const char* advice = "") const;
    /// A finite number in [low, high].
    double Number(const std::string& pointer, const Json& value, double low, double high) const;
    double Number(const std::string& pointer, double low, double high) const {
        return Number(pointer, At(pointer), low, high);
    }
    std::vector<double> Numbers(const std::string& pointer, std::optional<Length> length, double low,
                                double high) const;
    /// @param step  least difference between neighbours
    void RequireGrowing(const std::string& pointer, const std::vector<double>& numbers, double step) const;
    /// What a value is, for messages: "a list of 3".
    static std::string KindOf(const Json& value);

  private:
    std::string_view text_;
    JsonPlaces places_;
    Json root_;
};

}  // namespace lacquer
