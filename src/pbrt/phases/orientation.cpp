#include "pbrt/phases/orientation.h"

#include "pbrt/image/image_cache.h"

namespace lacquer {

Orientation Orientation::Read(const PhaseArgs& args) {
    const Params& params = args.params;
    Orientation o;
    const std::optional<std::string> file = params.GetOptionalString("orientationmap");
    if (file && !args.owner.Textures())
        params.Fail("orientationmap", std::string("a ") + args.owner.Kind() +
                                          " has no surface for an image to lie on; expected \"vector3 "
                                          "orientation\", which is the same everywhere");
    if (file && params.Has("orientation"))
        params.Fail("orientationmap",
                    "an orientation is either \"orientation\" or \"orientationmap\"; expected only one of "
                    "the two");
    o.constant_ = params.GetVector3("orientation", {0, 0, 1});
    if (!(MaxComponent(Abs(o.constant_)) > 0))
        params.Fail("orientation", "\"vector3 orientation\" has no length; expected a direction");
    // Long and short ones alike: squares must neither overflow nor vanish later.
    o.constant_ /= MaxComponent(Abs(o.constant_));
    if (!file) return o;
    const std::string path = params.PathOf("orientationmap");
    o.map_ = ImageParam(params, "orientationmap", ColorEncoding{}, *args.owner.Textures());
    if (!o.map_->HasRGB())
        params.Fail("orientationmap", path + ": an orientation map needs channels R, G and B");
    if (o.map_->HasNonFinite())
        params.Fail("orientationmap", path + ": the image has pixels that are not finite numbers");
    return o;
}

Vec3 Orientation::FromMap(const TextureContext& context) const {
    // Image rows go down where v goes up.
    const Point2 st(context.uv.x, 1 - context.uv.y);
    Vec3 v;
    for (int c = 0; c < 3; ++c) v[c] = 2 * map_->Bilinear(st, c, WrapMode::Repeat) - 1;
    return LengthSquared(v) > 0 ? v : constant_;
}

}  // namespace lacquer
