// Light from all around, given by an image.
#include "pbrt/core/sampling.h"
#include "pbrt/lights/emission.h"
#include "pbrt/lights/infinite.h"

namespace lacquer {

PiecewiseConstant2D CompensatedDistribution(std::vector<float> luminance, int n, float mean) {
    constexpr float kFloor = 0.05f;
    for (float& Y : luminance) Y = std::max(Y - mean, kFloor * Y);
    return PiecewiseConstant2D(luminance, n, n);
}

namespace {

std::vector<float> Luminances(const EnvironmentMap& map) {
    const int n = map.Size();
    std::vector<float> luminance;
    luminance.reserve(size_t(n) * size_t(n));
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) luminance.push_back(map.Luminance(map.Texel({x, y})));
    return luminance;
}

float MeanLuminance(const EnvironmentMap& map) {
    const int n = map.Size();
    double sum = 0;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) sum += double(map.Luminance(map.Texel({x, y})));
    return float(sum / (double(n) * n));
}

class ImageInfiniteLight final : public Light {
  public:
    ImageInfiniteLight(const Transform& renderFromLight, const EnvironmentMap& map)
        : Light(Kind::Infinite),
          renderFromLight_(renderFromLight.Matrix()),
          lightFromRender_(renderFromLight.InverseMatrix()),
          determinant_(float(std::abs(glm::determinant(glm::dmat3(renderFromLight_))))),
          radiance_(map.Space(), map.Size(), map.scale, [&](Int2 p) { return map.Texel(p); }),
          meanLuminance_(MeanLuminance(map)),
          distribution_(CompensatedDistribution(Luminances(map), map.Size(), meanLuminance_)) {}

    void Preprocess(const Bounds3& sceneBounds) override { sceneSphere_ = BoundingSphereOf(sceneBounds); }
    SampledSpectrum Le(const Ray& ray, const SampledWavelengths& lambda) const override {
        return radiance_.Sample(EqualAreaSphereToSquare(Normalize(lightFromRender_ * ray.d)), lambda);
    }
    std::optional<LightSample> SampleLi(const LightReference& ref, Point2 u,
                                        const SampledWavelengths& lambda) const override {
        float pdfMap = 0;
        const Point2 st = distribution_.Sample(u, &pdfMap);
        const Vec3 w = renderFromLight_ * EqualAreaSquareToSphere(st);
        const float length = Length(w);
        // A matrix M takes the solid angle around a unit vector w to |det M| / |M w|^3 of it.
        const float pdf = pdfMap * Inv4Pi * (length * length * length) / determinant_;
        const SampledSpectrum L = radiance_.Sample(st, lambda);
        if (!(pdf > 0) || !L) return std::nullopt;
        const Vec3 wi = w / length;
        return LightSample{L, wi, pdf, ref.p + 2 * sceneSphere_.radius * wi, 0, Normal3(0)};
    }
    float PdfLi(const LightReference&, Vec3 wi, const SurfaceInteraction*) const override {
        const Vec3 w = lightFromRender_ * wi;
        const float length = Length(w);
        return distribution_.Pdf(EqualAreaSphereToSquare(w / length)) * Inv4Pi /
               (determinant_ * (length * length * length));
    }
    std::optional<LightEmission> SampleLe(Point2 uPosition, Point2 uDirection,
                                          const SampledWavelengths& lambda) const override {
        const std::optional<LightSample> from = SampleLi(LightReference(), uDirection, lambda);
        if (!from) return std::nullopt;
        return EmissionThroughSphere(sceneSphere_, -from->wi, from->L, uPosition, from->pdf);
    }
    EmissionDensity PdfLe(Normal3, Vec3 w) const override {
        return {PdfThroughSphere(sceneSphere_), PdfLi(LightReference(), -w, nullptr)};
    }
    float Power() const override { return 4 * Pi * Pi * Sqr(sceneSphere_.radius) * meanLuminance_; }

  private:
    glm::mat3 renderFromLight_, lightFromRender_;
    float determinant_;
    SpectralMap radiance_;
    float meanLuminance_;
    PiecewiseConstant2D distribution_;
    BoundingSphere sceneSphere_;
};

}  // namespace

std::unique_ptr<Light> MakeImageInfiniteLight(const Transform& renderFromLight, const EnvironmentMap& map) {
    return std::make_unique<ImageInfiniteLight>(renderFromLight, map);
}

}  // namespace lacquer
