// The direction that flakes are arranged about.
#pragma once

#include "pbrt/phases/phase_params.h"

namespace lacquer {

/// The same everywhere, or (in slabs) from an image.
class Orientation {
  public:
    /// `"vector3 orientation"` or `"string orientationmap"`. Errors: SceneError for both of them, a vector
    /// without length, a map for a medium, an image that is no map of directions; FileError.
    static Orientation Read(const PhaseArgs& args);
    /// Names of the two.
    static constexpr std::string_view kParameter = "orientation", kMapParameter = "orientationmap";

    /// In the frame of the directions; any length but 0.
    Vec3 At(const PhaseContext& context) const {
        return context.frame.FromLocal(map_ ? FromMap(*context.textures) : constant_);
    }
    bool IsConstant() const { return !map_; }

  private:
    Vec3 FromMap(const TextureContext& context) const;

    Vec3 constant_{0, 0, 1};
    std::shared_ptr<const Image> map_;
};

}  // namespace lacquer
