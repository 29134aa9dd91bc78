// Names in scene files and the functions that make the things they name.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace lacquer {

/// One table for each kind of plugin; `Kind` is a struct with
///   static constexpr const char* kKind   the word in messages ("material")
///   using Factory = Product (*)(arguments)
/// Filled before main() by LACQUER_REGISTER, constant afterwards.
template <class Kind>
class Registry {
  public:
    using Factory = typename Kind::Factory;

    static bool Add(const std::string& name, Factory factory) {
        return Table().emplace(name, factory).second;
    }
    /// The factory of `name`, or null.
    static Factory Find(const std::string& name) {
        const auto it = Table().find(name);
        return it == Table().end() ? nullptr : it->second;
    }
    /// Registered names in alphabetical order.
    static std::vector<std::string> Names() {
        std::vector<std::string> names;
        for (const auto& [name, factory] : Table()) names.push_back(name);
        return names;
    }

  private:
    static std::map<std::string, Factory>& Table() {
        static std::map<std::string, Factory> table;
        return table;
    }
};

}  // namespace lacquer

#define LACQUER_CONCAT_INNER(a, b) a##b
#define LACQUER_CONCAT(a, b) LACQUER_CONCAT_INNER(a, b)
/// Last line of a plugin's file: LACQUER_REGISTER(MaterialKind, "diffuse", CreateDiffuse);
#define LACQUER_REGISTER(Kind, name, factory)                                  \
    [[maybe_unused]] static const bool LACQUER_CONCAT(registered_, __LINE__) = \
        ::lacquer::Registry<Kind>::Add(name, factory)
