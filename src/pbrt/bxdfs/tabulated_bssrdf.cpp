#include "pbrt/bxdfs/tabulated_bssrdf.h"

#include "pbrt/bxdfs/normalized_fresnel.h"

namespace lacquer {
namespace {

/// Chances of the axes x, y, z: exit points are mostly found along the normal, but not those of edges.
constexpr float kAxisProbability[3] = {0.25f, 0.25f, 0.5f};
/// Radii with more than this share of the light within them are not drawn: as in pbrt-v4, so that images
/// agree.
constexpr float kSampledFraction = 0.999f;

}  // namespace

TabulatedBSSRDF::TabulatedBSSRDF(Point3 p, Normal3 n, float eta, SampledSpectrum sigma_a,
                                 SampledSpectrum sigma_s, const BssrdfTable& table)
    : p_(p), frame_(Frame::FromZ(n)), eta_(eta), sigma_t_(sigma_a + sigma_s) {
    const SampledSpectrum albedo = SafeDivide(sigma_s, sigma_t_);
    for (int i = 0; i < kNumWavelengths; ++i) slices_[i] = BssrdfSlice(table, albedo[i]);
}

std::optional<ProbeSegment> TabulatedBSSRDF::SampleProbe(float uAxis, Point2 u) const {
    if (!(sigma_t_[0] > 0) || !(slices_[0].EffectiveAlbedo() > 0)) return std::nullopt;
    const float rMax = slices_[0].SampleRadius(kSampledFraction) / sigma_t_[0];
    const float r = slices_[0].SampleRadius(u.x) / sigma_t_[0];
    if (!(r < rMax)) return std::nullopt;

    // A disc, a point of it, and the chord of the sphere of radius rMax through that point.
    const int axis = uAxis < kAxisProbability[0]                         ? 0
                     : uAxis < kAxisProbability[0] + kAxisProbability[1] ? 1
                                                                         : 2;
    const Vec3 axes[3] = {frame_.x, frame_.y, frame_.z};
    const Vec3 across = axes[(axis + 1) % 3], along = axes[(axis + 2) % 3];
    const float phi = 2 * Pi * u.y, length = 2 * std::sqrt(rMax * rMax - r * r);
    const Point3 foot = p_ + r * (std::cos(phi) * across + std::sin(phi) * along);
    return ProbeSegment{foot - (0.5f * length) * axes[axis], axes[axis], length, rMax};
}

BSSRDFValue TabulatedBSSRDF::Evaluate(Point3 p, Normal3 n) const {
    const Vec3 d = frame_.ToLocal(p - p_), nLocal = frame_.ToLocal(n);
    const float distance = Length(d);
    // Distance from the entry in each disc, and what a piece of the surface is foreshortened by there.
    float projected[3], weight[3];
    for (int axis = 0; axis < 3; ++axis) {
        const float a = d[(axis + 1) % 3], b = d[(axis + 2) % 3];
        projected[axis] = std::sqrt(a * a + b * b);
        weight[axis] = kAxisProbability[axis] * std::abs(nLocal[axis]);
    }
    BSSRDFValue value;
    for (int i = 0; i < kNumWavelengths; ++i) {
        const float sigma_t = sigma_t_[i];
        if (!(sigma_t > 0) || !(slices_[i].EffectiveAlbedo() > 0)) continue;
        value.Sp.Set(i, slices_[i].Profile(distance * sigma_t) * Sqr(sigma_t));
        float pdf = 0;
        for (int axis = 0; axis < 3; ++axis)
            pdf += weight[axis] * slices_[i].Profile(projected[axis] * sigma_t);
        value.pdf.Set(i, pdf * Sqr(sigma_t) / slices_[i].EffectiveAlbedo());
    }
    return value;
}

SampledSpectrum TabulatedBSSRDF::EffectiveAlbedo() const {
    SampledSpectrum albedo(0);
    for (int i = 0; i < kNumWavelengths; ++i)
        if (sigma_t_[i] > 0) albedo.Set(i, slices_[i].EffectiveAlbedo());
    return albedo;
}

BxDF* TabulatedBSSRDF::ExitBxDF(Arena& arena) const { return arena.New<NormalizedFresnelBxDF>(eta_); }

}  // namespace lacquer
