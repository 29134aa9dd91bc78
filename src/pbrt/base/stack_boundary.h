// The roles that a material can have as a boundary between the media of a stack of layers. Who builds a stack
// asks for them once; renderers of surfaces know nothing of them.
#pragma once

#include <optional>
#include <string>

#include "pbrt/base/bxdf.h"
#include "pbrt/base/texture.h"
#include "pbrt/core/arena.h"

namespace lacquer {

/// Indices of refraction on the two sides of a boundary in a stack, relative to the vacuum.
struct BoundaryMedia {
    float etaAbove = 1;
    std::optional<float> etaBelow;  ///< empty: the material itself says it, or it is the same as above
};

/// Role of a material whose scattering depends on the media on its sides. A material without it is the same
/// boundary everywhere: what its MakeBxDF() makes, and the index below is that above.
class StackBoundary {
  public:
    /// The boundary at a point, in `arena`. Where `media` says what lies below, a dielectric that was given
    /// no index of its own takes the quotient; the index of a conductor is divided by that above.
    virtual BxDF* MakeBoundary(const TextureContext& context, SampledWavelengths& lambda, Arena& arena,
                               const BoundaryMedia& media) const = 0;
    /// Index below over index above of what MakeBoundary() makes, as its refraction has it. Default: 1.
    virtual float EtaAcross(SampledWavelengths& /*lambda*/, const BoundaryMedia& /*media*/) const {
        return 1;
    }

  protected:
    ~StackBoundary() = default;  // never destroyed through the role
};

/// Role of a material that is a surface, but never a boundary in a stack.
class NoStackBoundary {
  public:
    /// What it is instead and what was expected, as the end of a sentence that begins with its name.
    virtual std::string WhyNoStackBoundary() const = 0;

  protected:
    ~NoStackBoundary() = default;
};

}  // namespace lacquer
