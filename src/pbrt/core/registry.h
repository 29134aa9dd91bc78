// Names in scene files and the functions that make the objects they name.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "pbrt/core/vector_calls.h"

namespace lacquer {

/// What is to be known of a plugin before it is made: `Kind::Traits`, or nothing.
struct NoTraits {};
template <class Kind>
struct TraitsOfKind {
    using Type = NoTraits;
};
template <class Kind>
requires requires { typename Kind::Traits; }
struct TraitsOfKind<Kind> {
    using Type = typename Kind::Traits;
};

/// One table for each kind of plugin; `Kind` is a struct with
///   static constexpr const char* kKind   the word in messages ("material")
///   using Factory = Product (*)(arguments)
///   struct Traits                        optional: what others ask of a plugin rather than know its name
/// Filled before main() by LACQUER_REGISTER, constant afterwards.
template <class Kind>
class Registry {
  public:
    using Factory = typename Kind::Factory;
    using Traits = typename TraitsOfKind<Kind>::Type;

    static bool Add(const std::string& name, Factory factory, Traits traits = {}) {
        return Table().emplace(name, Entry{factory, traits}).second;
    }
    /// Takes back an Add(); for tests, which leave the table as it was.
    static void Remove(const std::string& name) { Table().erase(name); }
    /// The factory of `name`, or null.
    static Factory Find(const std::string& name) {
        const auto it = Table().find(name);
        return it == Table().end() ? nullptr : it->second.factory;
    }
    /// What `name` was registered with; the default for unknown names.
    static Traits TraitsOf(const std::string& name) {
        const auto it = Table().find(name);
        return it == Table().end() ? Traits() : it->second.traits;
    }
    /// Registered names in alphabetical order.
    static std::vector<std::string> Names() {
        std::vector<std::string> names;
        for (const auto& [name, entry] : Table()) names.push_back(name);
        return names;
    }

  private:
    struct Entry {
        Factory factory;
        Traits traits;
    };
    static std::map<std::string, Entry>& Table() {
        static std::map<std::string, Entry> table;
        return table;
    }
};

}  // namespace lacquer

#define LACQUER_CONCAT_INNER(a, b) a##b
#define LACQUER_CONCAT(a, b) LACQUER_CONCAT_INNER(a, b)
/// Last line of a plugin's file: LACQUER_REGISTER(MaterialKind, "diffuse", CreateDiffuse); the traits of its
/// kind, if there are any, come last: LACQUER_REGISTER(MaterialKind, "layered", Create, {.isLayered = true});
#define LACQUER_REGISTER(Kind, name, ...)                                         \
    [[maybe_unused]] static const bool LACQUER_CONCAT(registered_, __COUNTER__) = \
        ::lacquer::Registry<Kind>::Add(name, __VA_ARGS__)
