// From surface points to texture coordinates.
#pragma once

#include <memory>

#include "pbrt/base/texture.h"
#include "pbrt/core/invertible.h"
#include "pbrt/image/mipmap.h"

namespace lacquer {

/// Coordinates (s, t) and their change from one pixel to its neighbours.
class TextureMapping2D {
  public:
    virtual ~TextureMapping2D() = default;
    virtual TextureFootprint Map(const TextureContext& context) const = 0;
};

/// The mapping of `"string mapping"`: "uv" (default; uscale, vscale, udelta, vdelta), "spherical",
/// "cylindrical" or "planar" (v1, v2, udelta, vdelta). All but uv map the point in texture space. Errors:
/// SceneError for unknown names, numbers that are not finite, and a texture space without an inverse.
std::unique_ptr<TextureMapping2D> MakeTextureMapping2D(const TextureArgs& args);

/// A point and its footprint in texture space.
struct TexturePoint {
    Point3 p{0};
    Vec3 dpdx{0}, dpdy{0};
};

/// The point in texture space: that of the CTM at the Texture directive. Errors: SceneError if that has no
/// inverse.
class TextureMapping3D {
  public:
    explicit TextureMapping3D(const TextureArgs& args) : renderFromTexture_(args.renderFromTexture) {
        RequireInvertible(args.params, renderFromTexture_);
    }
    TexturePoint Map(const TextureContext& context) const {
        return {renderFromTexture_.InversePoint(context.p), renderFromTexture_.InverseVector(context.dpdx),
                renderFromTexture_.InverseVector(context.dpdy)};
    }

  private:
    Transform renderFromTexture_;
};

}  // namespace lacquer
