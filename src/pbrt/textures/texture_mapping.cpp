#include "pbrt/textures/texture_mapping.h"

#include "pbrt/textures/finite_params.h"

namespace lacquer {

namespace {

class UVMapping final : public TextureMapping2D {
  public:
    UVMapping(Vec2 scale, Vec2 delta) : scale_(scale), delta_(delta) {}
    TextureFootprint Map(const TextureContext& c) const override {
        return {scale_ * c.uv + delta_, scale_ * Vec2(c.dudx, c.dvdx), scale_ * Vec2(c.dudy, c.dvdy)};
    }

  private:
    Vec2 scale_, delta_;
};

/// The footprint of a map with gradients dsdp and dtdp at a point.
TextureFootprint WithGradients(Point2 st, Vec3 dsdp, Vec3 dtdp, const TexturePoint& c) {
    return {st, {Dot(dsdp, c.dpdx), Dot(dtdp, c.dpdx)}, {Dot(dsdp, c.dpdy), Dot(dtdp, c.dpdy)}};
}

/// s is the polar angle and t the azimuth (as in pbrt, not the other way round).
class SphericalMapping final : public TextureMapping2D {
  public:
    explicit SphericalMapping(const TextureArgs& args) : toTexture_(args) {}
    TextureFootprint Map(const TextureContext& context) const override {
        const TexturePoint c = toTexture_.Map(context);
        const float rho2 = Sqr(c.p.x) + Sqr(c.p.y), rho = std::sqrt(rho2), r2 = rho2 + Sqr(c.p.z);
        const Point2 st(ATan2(rho, c.p.z) * InvPi, SphericalPhi(c.p) * Inv2Pi);
        // On the axis the azimuth has no gradient: a point look-up.
        if (!(rho2 > 0)) return {st, Vec2(0), Vec2(0)};
        const Vec3 dsdp = Vec3(c.p.x * c.p.z, c.p.y * c.p.z, -rho2) * (InvPi / (r2 * rho));
        const Vec3 dtdp = Vec3(-c.p.y, c.p.x, 0) * (Inv2Pi / rho2);
        return WithGradients(st, dsdp, dtdp, c);
    }

  private:
    TextureMapping3D toTexture_;
};

class CylindricalMapping final : public TextureMapping2D {
  public:
    explicit CylindricalMapping(const TextureArgs& args) : toTexture_(args) {}
    TextureFootprint Map(const TextureContext& context) const override {
        const TexturePoint c = toTexture_.Map(context);
        const float rho2 = Sqr(c.p.x) + Sqr(c.p.y);
        const Point2 st((Pi + ATan2(c.p.y, c.p.x)) * Inv2Pi, c.p.z);
        const Vec3 dsdp = rho2 > 0 ? Vec3(-c.p.y, c.p.x, 0) * (Inv2Pi / rho2) : Vec3(0);
        return WithGradients(st, dsdp, Vec3(0, 0, 1), c);
    }

  private:
    TextureMapping3D toTexture_;
};

class PlanarMapping final : public TextureMapping2D {
  public:
    PlanarMapping(const TextureArgs& args, Vec3 v1, Vec3 v2, Vec2 delta)
        : toTexture_(args), v1_(v1), v2_(v2), delta_(delta) {}
    TextureFootprint Map(const TextureContext& context) const override {
        const TexturePoint c = toTexture_.Map(context);
        return WithGradients(delta_ + Vec2(Dot(c.p, v1_), Dot(c.p, v2_)), v1_, v2_, c);
    }

  private:
    TextureMapping3D toTexture_;
    Vec3 v1_, v2_;
    Vec2 delta_;
};

}  // namespace

std::unique_ptr<TextureMapping2D> MakeTextureMapping2D(const TextureArgs& args) {
    const Params& params = args.params;
    const std::string name = params.GetChoice("mapping", "uv", {"uv", "spherical", "cylindrical", "planar"});
    if (name == "spherical") return std::make_unique<SphericalMapping>(args);
    if (name == "cylindrical") return std::make_unique<CylindricalMapping>(args);
    const Vec2 delta(FiniteFloat(params, "udelta", 0), FiniteFloat(params, "vdelta", 0));
    if (name == "planar")
        return std::make_unique<PlanarMapping>(args, FiniteVector3(params, "v1", {1, 0, 0}),
                                               FiniteVector3(params, "v2", {0, 1, 0}), delta);
    return std::make_unique<UVMapping>(
        Vec2(FiniteFloat(params, "uscale", 1), FiniteFloat(params, "vscale", 1)), delta);
}

}  // namespace lacquer
