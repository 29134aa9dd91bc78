// Names of objects and materials from what a scene file says about them; the rules stand in
// base/scene_names.h.
#pragma once

#include <string>
#include <unordered_map>
#include <unordered_set>

#include "pbrt/scene/description.h"

namespace lacquer {

/// The name of what a Shape directive outside of object definitions makes, perhaps not yet unique.
std::string NameOf(const ShapeEntity& shape);
/// The same of a material.
std::string NameOf(const MaterialEntity& material);

/// Tells equal names apart.
class UniqueNames {
  public:
    /// Keeps a name for the first object that Make() gets it for: no other one is numbered so.
    void Reserve(const std::string& name) { reserved_.insert(name); }
    /// `name`, or name#2, name#3, ... where it was given out before.
    std::string Make(const std::string& name);

  private:
    std::unordered_set<std::string> used_, reserved_;
    std::unordered_map<std::string, int> last_;  ///< number that was last given to a repeated name
};

}  // namespace lacquer
