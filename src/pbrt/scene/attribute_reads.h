// Which parameters of Attribute directives something has read: one that nothing reads is probably misspelt.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "pbrt/core/params.h"

namespace lacquer {

/// pbrt lets an attribute go unread where it does not fit, so only what no directive at all has read is told.
class AttributeReads {
  public:
    /// After a directive has looked up what it wants.
    void Note(const Params& params);
    /// Warnings for what was offered to directives and read by none, in the order of files and places.
    std::vector<Diagnostic> Unread() const;

  private:
    using Place = std::tuple<FileName, int, int>;
    std::map<Place, std::optional<Diagnostic>> reads_;  // nothing for what was read
};

}  // namespace lacquer
