// The role of what could be made from a scene, but with a doubt that a user wants to hear of.
#pragma once

#include <span>

#include "pbrt/core/error.h"

namespace lacquer {

/// Role of a material, or of a medium's phase function. Who builds the scene asks for it once.
class HasWarnings {
  public:
    virtual std::span<const Diagnostic> Warnings() const = 0;

  protected:
    ~HasWarnings() = default;  // never destroyed through the role
};

}  // namespace lacquer
