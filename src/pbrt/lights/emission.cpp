#include "pbrt/lights/emission.h"

#include <fmt/format.h>

#include "pbrt/core/sampling.h"

namespace lacquer {

Emission ReadEmission(const Params& params, std::string_view parameter, float scale) {
    const std::unique_ptr<Spectrum> given = params.GetSpectrum(parameter, SpectrumKind::Illuminant);
    const Spectrum* const spectrum = given ? given.get() : &params.ColorSpace().Illuminant();
    Emission emission{DenselySampledSpectrum(*spectrum)};
    emission.spectrum.Scale(EmissionScale(*spectrum, params, parameter, scale));
    emission.luminance = RequireFinite(params, parameter, InnerProduct(emission.spectrum, CieY()));
    RequireFinite(params, parameter, emission.spectrum.MaxValue());
    return emission;
}

float ReadScale(const Params& params) {
    const float scale = params.GetFloat("scale", 1);
    if (!(scale >= 0) || !std::isfinite(scale))
        params.Fail("scale", fmt::format("expected a finite scale that is not negative, found {}", scale));
    return scale;
}

float ReadQuantity(const Params& params, std::string_view name) {
    return std::max(0.f, RequireFinite(params, name, params.GetFloat(name, 0)));
}

float RequireFinite(const Params& params, std::string_view parameter, float value) {
    if (!std::isfinite(value))
        params.Fail(parameter,
                    fmt::format("the emission of this light must be finite, but \"{}\" makes it {}",
                                parameter, value));
    return value;
}

Vec3 ReadDirection(const Params& params, Point3 from, Point3 to) {
    // In double: neither may the difference of two huge points overflow nor its square underflow.
    const glm::dvec3 d = glm::dvec3(to) - glm::dvec3(from);
    const double length = glm::length(d);
    if (!(length > 0) || !std::isfinite(length))
        params.Fail(
            "to", "\"from\" and \"to\" must be finite and differ, for they give the direction of the light");
    return Vec3(d / length);
}

LightEmission EmissionThroughSphere(const BoundingSphere& sphere, Vec3 w, SampledSpectrum L, Point2 u,
                                    float pdfDirection) {
    const Point2 d = SampleUniformDiskConcentric(u);
    const Vec3 onDisk = Frame::FromZ(w).FromLocal({d.x, d.y, -1});
    LightEmission emitted;
    emitted.L = L;
    emitted.w = w;
    emitted.p = sphere.center + sphere.radius * onDisk;
    emitted.pdfPosition = PdfThroughSphere(sphere);
    emitted.pdfDirection = pdfDirection;
    return emitted;
}

BoundingSphere BoundingSphereOf(const Bounds3& sceneBounds) {
    if (sceneBounds.IsEmpty()) return {};
    const float radius = 0.5f * Length(sceneBounds.Diagonal());
    // Beyond 1e18 the square of the radius, which every power of a distant light has, would overflow.
    if (!(radius < 1e18f)) return {Point3(0), 1e18f};
    return {sceneBounds.Center(), std::max(radius, 1e-18f)};
}

}  // namespace lacquer
