// The phase function of a slab as its scene-file parameters describe it.
#pragma once

#include "pbrt/base/material.h"
#include "pbrt/base/phase_function.h"

namespace lacquer::layered {

/// Makes a slab's phase function at each hit. Immutable and thread-safe.
class SlabPhase {
  public:
    virtual ~SlabPhase() = default;
    /// A phase function in `arena`. It may refer to this object.
    /// @param frame  of the slab, in the frame of the stack
    virtual const PhaseFunction* Make(const TextureContext& context, const Frame& frame,
                                      Arena& arena) const = 0;
    /// True if it has a direction of its own: the frame matters, and extinction may depend on the direction.
    virtual bool IsOriented() const { return false; }
    /// True if no texture has a say.
    virtual bool IsConstant() const { return true; }
    /// Phase functions that one Make() makes.
    virtual int NumParts() const { return 1; }
};

/// Henyey-Greenstein with the mean cosine `g` (not null), clamped to what the function can do.
std::unique_ptr<SlabPhase> MakeHenyeyGreensteinSlabPhase(const FloatTexture* g);

/// From `phase` and the parameters that belong to its value; slab.cpp lists them. Errors: SceneError for
/// values out of their range, parameters of another phase function, unknown slabs in a mixture.
std::unique_ptr<SlabPhase> ReadSlabPhase(const MaterialArgs& args);

}  // namespace lacquer::layered
