// What all parts of particles.json are read with.
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "bulk/table/ensemble_computation.h"
#include "pbrt/core/json_reader.h"

namespace lacquer::bulk {

/// Names and what they stand for.
template <class T>
using Choices = std::vector<std::pair<std::string, T>>;

/// A JSON text with lengths, names and whole numbers. Errors as JsonReader's.
class ParticlesJson : public JsonReader {
  public:
    ParticlesJson(std::string_view text, const std::string& path)
        : JsonReader(text, path, "the particles of a medium") {}
    /// @param micrometres  in a length of the file
    void SetUnit(double micrometres) { unit_ = micrometres; }
    double Unit() const { return unit_; }

    /// A value by its name.
    template <class T>
    T Choice(const std::string& pointer, const Choices<T>& choices) const {
        const Json& value = At(pointer);
        std::vector<std::string> names;
        for (const auto& [name, meaning] : choices) {
            if (value == name) return meaning;
            names.push_back(name);
        }
        Fail(pointer, fmt::format("found {}; expected one of {}{}", KindOf(value), fmt::join(names, ", "),
                                  value.is_string() ? DidYouMean(value.get<std::string>(), names) : ""));
    }
    /// Above 0. @param what  ends the message: "a radius above 0"
    double Positive(const std::string& pointer, double high, const char* what) const;
    double Whole(const std::string& pointer, double low, double high) const;
    /// Of a list that is not empty. @param what  ends the message
    size_t NumItems(const std::string& pointer, const char* what) const;
    /// [um], between atoms and what is no small particle.
    double LengthAt(const std::string& pointer, const char* what) const;
    double Radius(const std::string& pointer) const { return LengthAt(pointer, "a radius above 0"); }
    /// What the solver can do with a particle of that radius [um].
    void CheckSize(const std::string& pointer, const BulkSettings& settings, double radius) const;

  private:
    double unit_ = 1;
};

}  // namespace lacquer::bulk
