// Light "goniometric": a point light whose intensity in each direction is given by an image, as of a measured
// luminaire.
//
//   "spectrum I"       the colour space's illuminant  intensity where the image is 1
//   "string filename"  required                       square, equal-area octahedral: +y of the light's space
//                                                     at the centre, -y at the corners, +x on the right, +z
//                                                     at the lower edge; its channel Y, or the mean of R, G
//                                                     and B, counts
//   "float scale"      1                              multiplies the emission, >= 0
//   "float power"      not given                      if > 0, scales the light to this total power
#include <fmt/format.h>

#include <algorithm>

#include "pbrt/core/invertible.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/sampling.h"
#include "pbrt/lights/emission.h"
#include "pbrt/lights/light_image.h"
#include "pbrt/lights/point_like.h"

namespace lacquer {

namespace {

/// Relative intensity in each direction, a square of n x n texels. Not negative.
struct Diagram {
    int n = 0;
    std::vector<float> texels;

    /// @param w  unit, in the light's space, away from the light
    float Along(Vec3 w) const {
        // The pole of the image is z, that of the lamp y.
        return At(EqualAreaSphereToSquare({w.x, w.z, w.y}));
    }
    float At(Point2 st) const {
        return texels[size_t(NearestTexel(st.y, n)) * size_t(n) + size_t(NearestTexel(st.x, n))];
    }
    /// Mean over all directions: texels have equal solid angles.
    float Mean() const {
        double sum = 0;
        for (const float texel : texels) sum += double(texel);
        return float(sum / double(texels.size()));
    }
};

class GoniometricLight final : public PointLikeLight<GoniometricLight> {
  public:
    GoniometricLight(const Transform& renderFromLight, Diagram diagram, Emission intensity)
        : PointLikeLight(renderFromLight.Point(Point3(0))),
          renderFromLight_(renderFromLight),
          solidAngles_(renderFromLight),
          diagram_(std::move(diagram)),
          mean_(diagram_.Mean()),
          distribution_(diagram_.texels, diagram_.n, diagram_.n),
          intensity_(std::move(intensity)) {}

    SampledSpectrum IntensityOver(Vec3 w, float distanceSquared, const SampledWavelengths& lambda) const {
        // A transform that squeezes space squeezes the image too, but a change of size alone does nothing.
        const float weight = diagram_.Along(Normalize(renderFromLight_.InverseVector(w)));
        return intensity_.Sample(lambda) * (weight / distanceSquared);
    }
    std::optional<LightEmission> SampleLe(Point2, Point2 uDirection,
                                          const SampledWavelengths& lambda) const override {
        float pdf = 0;
        const Point2 st = distribution_.Sample(uDirection, &pdf);
        const Vec3 polar = EqualAreaSquareToSphere(st);
        const Vec3 local(polar.x, polar.z, polar.y);
        return EmittedToward(Normalize(renderFromLight_.Vector(local)),
                             intensity_.Sample(lambda) * diagram_.At(st),
                             pdf * Inv4Pi * solidAngles_.DensityFactor(local));
    }
    EmissionDensity PdfLe(Normal3, Vec3 w) const override {
        const Vec3 local = Normalize(renderFromLight_.InverseVector(w));
        const float pdf = distribution_.Pdf(EqualAreaSphereToSquare({local.x, local.z, local.y}));
        return {1, pdf * Inv4Pi * solidAngles_.DensityFactor(local)};
    }
    float Power() const override { return 4 * Pi * mean_ * intensity_.luminance; }

  private:
    Transform renderFromLight_;
    SolidAngleMap solidAngles_;
    Diagram diagram_;
    float mean_;
    PiecewiseConstant2D distribution_;  ///< of the diagram, on its square
    Emission intensity_;
};

/// Channel Y of the image, or the mean of R, G and B. What is negative, as a filter may have left it, is
/// black.
Diagram ReadDiagram(const LightArgs& args) {
    const std::shared_ptr<const Image> image = ReadLightImage(args);
    const std::string filename = args.params.GetString("filename", "");
    const Int2 size = image->Resolution();
    if (size.x != size.y)
        args.params.Fail("filename",
                         fmt::format("{}: the image of a goniometric light must be square (equal-area "
                                     "octahedral), this image has {} x {} pixels",
                                     filename, size.x, size.y));
    const int Y = image->FindChannel("Y");
    if (Y < 0 && !image->HasRGB())
        args.params.Fail("filename", fmt::format("{}: the image of a goniometric light needs the channel Y "
                                                 "or the channels R, G and B",
                                                 filename));
    Diagram diagram{size.x, {}};
    diagram.texels.reserve(size_t(size.x) * size_t(size.y));
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const auto get = [&](int channel) { return image->Get({x, y}, channel); };
            const float value = Y >= 0 ? get(Y) : (get(0) + get(1) + get(2)) / 3;
            diagram.texels.push_back(std::max(0.f, value));
        }
    return diagram;
}

std::unique_ptr<Light> CreateGoniometric(const LightArgs& args) {
    const Params& params = args.params;
    RequireInvertible(params, args.renderFromLight);
    Emission intensity = ReadEmission(params, "I", ReadScale(params));
    Diagram diagram = ReadDiagram(args);
    if (const float power = ReadQuantity(params, "power"); power > 0) {
        const float mean = diagram.Mean();
        if (!(mean > 0)) params.Fail("power", "the image is black: no scale gives this light a power");
        intensity.Scale(power / (4 * Pi * mean));
        RequireFinite(params, "power", intensity.luminance);
    }
    const float largest = *std::max_element(diagram.texels.begin(), diagram.texels.end());
    RequireFinite(params, "filename", largest * intensity.MaxValue());
    return std::make_unique<GoniometricLight>(args.renderFromLight, std::move(diagram), std::move(intensity));
}

}  // namespace

LACQUER_REGISTER(LightKind, "goniometric", CreateGoniometric);

}  // namespace lacquer
