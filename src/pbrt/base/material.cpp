#include "pbrt/base/material.h"

#include <cmath>

#include "pbrt/image/image_cache.h"

namespace lacquer {

namespace {

struct Tangents {
    Vec3 dpdu, dpdv;
};

/// How far p moves along one parameter for the finite differences: half of the footprint.
float DisplacementStep(float dx, float dy) {
    const float step = 0.5f * (std::abs(dx) + std::abs(dy));
    return step > 0 && std::isfinite(step) ? step : 0.0005f;
}

/// Tangents of the surface p + d n, with derivatives of d by forward differences [Blinn 1978].
Tangents Displaced(const SurfaceInteraction& si, const FloatTexture& displacement) {
    const auto& s = si.shading;
    const TextureContext center(si);
    const float du = DisplacementStep(si.dudx, si.dudy), dv = DisplacementStep(si.dvdx, si.dvdy);
    TextureContext besideU = center, besideV = center;
    besideU.p += du * s.dpdu;
    besideU.uv.x += du;
    besideV.p += dv * s.dpdv;
    besideV.uv.y += dv;
    const float d = displacement.Evaluate(center);
    const float dddu = (displacement.Evaluate(besideU) - d) / du,
                dddv = (displacement.Evaluate(besideV) - d) / dv;
    return {s.dpdu + dddu * s.n + d * s.dndu, s.dpdv + dddv * s.n + d * s.dndv};
}

/// Tangents of the surface whose normal the map gives in the shading frame; lengths stay.
Tangents NormalMapped(const SurfaceInteraction& si, const Image& map) {
    const auto& s = si.shading;
    // Image rows go down where v goes up.
    const Point2 st(si.uv.x, 1 - si.uv.y);
    Vec3 local;
    for (int c = 0; c < 3; ++c) local[c] = 2 * map.Bilinear(st, c, WrapMode::Repeat) - 1;
    if (!(LengthSquared(local) > 0)) return {s.dpdu, s.dpdv};
    local = Normalize(local);
    const Vec3 x = Normalize(s.dpdu), y = Cross(s.n, x);
    const Vec3 n = local.x * x + local.y * y + local.z * s.n;
    const Vec3 dpdu = Normalize(s.dpdu - Dot(s.dpdu, n) * n) * Length(s.dpdu);
    return {dpdu, Normalize(Cross(n, dpdu)) * Length(s.dpdv)};
}

/// What a context without a surface is taken for: a plane with unit tangents.
SurfaceInteraction FlatSurface(const TextureContext& context) {
    SurfaceInteraction si;
    const Frame frame = LengthSquared(context.n) > 0 ? Frame::FromZ(context.n) : Frame{};
    si.SetGeometry(context.p, 0, context.uv, frame.x, frame.y, false);
    si.dpdx = context.dpdx;
    si.dpdy = context.dpdy;
    si.dudx = context.dudx;
    si.dudy = context.dudy;
    si.dvdx = context.dvdx;
    si.dvdy = context.dvdy;
    si.faceIndex = context.faceIndex;
    return si;
}

}  // namespace

void Material::ReadBump(const Params& params, TextureLibrary& textures) {
    displacement_ = OptionalFloatTextureParam(params, "displacement", textures);
    rotation_ = OptionalFloatTextureParam(params, "rotation", textures);
    if (!params.GetOptionalString("normalmap")) return;
    const std::string path = params.PathOf("normalmap");
    normalMap_ = ImageParam(params, "normalmap", ColorEncoding{}, textures);
    if (!normalMap_->HasRGB()) params.Fail("normalmap", path + ": a normal map needs channels R, G and B");
    if (normalMap_->HasNonFinite())
        params.Fail("normalmap", path + ": the image has pixels that are not finite numbers");
}

void Material::PerturbShading(SurfaceInteraction& si) const {
    const auto& s = si.shading;
    if (normalMap_ || displacement_) {
        // Where both are given the normal map is used, as in pbrt.
        const Tangents t = normalMap_ ? NormalMapped(si, *normalMap_) : Displaced(si, *displacement_);
        const Vec3 n = Normalize(Cross(t.dpdu, t.dpdv));
        // Parallel tangents say nothing: the frame stays.
        if (IsFinite(n) && IsFinite(t.dpdu) && IsFinite(t.dpdv))
            si.SetShading(n, t.dpdu, t.dpdv, s.dndu, s.dndv, false);
    }
    if (rotation_) {
        const float angle = rotation_->Evaluate(TextureContext(si)) * (Pi / 180);
        if (!std::isfinite(angle)) return;
        const float sine = std::sin(angle), cosine = std::cos(angle);
        const auto turned = [&](Vec3 v) {
            return cosine * v + sine * Cross(s.n, v) + (1 - cosine) * Dot(s.n, v) * s.n;
        };
        si.SetShading(s.n, turned(s.dpdu), turned(s.dpdv), s.dndu, s.dndv, false);
    }
}

Frame Material::BumpedFrame(const TextureContext& context) const {
    SurfaceInteraction si = context.surface ? *context.surface : FlatSurface(context);
    const Frame surface = Frame::FromZX(si.shading.n, si.shading.dpdu);
    PerturbShading(si);
    const Vec3 normal = surface.ToLocal(si.shading.n);
    if (!(normal.z > 0)) return {};
    return Frame::FromZX(Normalize(normal), surface.ToLocal(si.shading.dpdu));
}

}  // namespace lacquer
