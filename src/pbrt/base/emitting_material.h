// The role of materials whose surfaces emit.
#pragma once

#include "pbrt/core/params.h"

namespace lacquer {

/// Role of a material that makes an area light "diffuse" of a shape. Who builds the scene asks for it once.
class EmittingMaterial {
  public:
    /// Parameters of that light; null if the material emits nothing.
    virtual const Params* EmissionParams() const = 0;

  protected:
    ~EmittingMaterial() = default;  // never destroyed through the role
};

}  // namespace lacquer
