// Light from all around, given by an image, that enters through a rectangle only [Bitterli et al. 2015].
#include "pbrt/lights/emission.h"
#include "pbrt/lights/infinite.h"
#include "pbrt/lights/windowed_distribution.h"

namespace lacquer {

namespace {

/// Unit square to the hemisphere of the portal's frame, rectified: lines parallel to the portal's edges
/// become parallel to the square's, and so the portal is an axis-aligned rectangle from wherever it is seen.
/// @param solidAngle  d omega / d(uv) there
Vec3 SquareToHemisphere(Point2 uv, float* solidAngle) {
    const float tanA = std::tan((uv.x - 0.5f) * Pi), tanB = std::tan((uv.y - 0.5f) * Pi);
    const Vec3 w = Normalize(Vec3(tanA, tanB, 1));
    // d omega = z^3 d(tan a) d(tan b), and d(tan a) = (1 + tan^2 a) pi du with 1 + tan^2 a = (1 - y^2) / z^2.
    *solidAngle = Sqr(Pi) * (1 - Sqr(w.x)) * (1 - Sqr(w.y)) / w.z;
    return w;
}

/// The inverse; empty for directions that are not in front of the portal's plane.
std::optional<Point2> HemisphereToSquare(Vec3 w, float* solidAngle = nullptr) {
    if (!(w.z > 0)) return std::nullopt;
    if (solidAngle) *solidAngle = Sqr(Pi) * (1 - Sqr(w.x)) * (1 - Sqr(w.y)) / w.z;
    return Point2(0.5f + ATan2(w.x, w.z) * InvPi, 0.5f + ATan2(w.y, w.z) * InvPi);
}

Point2 TexelCenter(int x, int y, int n) { return (Point2(float(x), float(y)) + 0.5f) / float(n); }

/// What texels are drawn by: luminance times solid angle.
std::vector<float> Weights(const EnvironmentMap& map, const std::vector<RGB>& texels) {
    const int n = map.Size();
    std::vector<float> weights;
    weights.reserve(texels.size());
    for (size_t i = 0; i < texels.size(); ++i) {
        float solidAngle;
        SquareToHemisphere(TexelCenter(int(i) % n, int(i) / n, n), &solidAngle);
        weights.push_back(map.Luminance(texels[i]) * solidAngle);
    }
    return weights;
}

/// Luminous flux through a unit area of the portal's plane.
float Flux(const EnvironmentMap& map, const std::vector<RGB>& texels) {
    const int n = map.Size();
    double flux = 0;
    for (size_t i = 0; i < texels.size(); ++i) {
        float solidAngle;
        const Vec3 w = SquareToHemisphere(TexelCenter(int(i) % n, int(i) / n, n), &solidAngle);
        flux += double(map.Luminance(texels[i]) * w.z * solidAngle);
    }
    return float(flux / double(texels.size()));
}

class PortalInfiniteLight final : public Light {
  public:
    /// @param texels  the map in the rectified parametrisation, not negative
    PortalInfiniteLight(const EnvironmentMap& map, const Portal& portal, const std::vector<RGB>& texels)
        : Light(Kind::Infinite),
          portal_(portal),
          radiance_(map.Space(), map.Size(), map.scale,
                    [&](Int2 p) { return texels[size_t(p.y) * size_t(map.Size()) + size_t(p.x)]; }),
          distribution_(Weights(map, texels), map.Size(), map.Size()),
          power_(Flux(map, texels) * portal.area) {}

    void Preprocess(const Bounds3& sceneBounds) override { sceneSphere_ = BoundingSphereOf(sceneBounds); }
    SampledSpectrum Le(const Ray& ray, const SampledWavelengths& lambda) const override {
        const std::optional<Point2> uv = HemisphereToSquare(portal_.frame.ToLocal(Normalize(ray.d)));
        const std::optional<Window> window = WindowFrom(ray.o);
        if (!uv || !window || !window->Contains(*uv)) return SampledSpectrum(0);
        return radiance_.Sample(*uv, lambda);
    }
    std::optional<LightSample> SampleLi(const LightReference& ref, Point2 u,
                                        const SampledWavelengths& lambda) const override {
        const std::optional<Window> window = WindowFrom(ref.p);
        if (!window) return std::nullopt;
        float pdfSquare = 0, solidAngle = 0;
        const std::optional<Point2> uv = distribution_.Sample(u, *window, &pdfSquare);
        if (!uv) return std::nullopt;
        const Vec3 wi = portal_.frame.FromLocal(SquareToHemisphere(*uv, &solidAngle));
        const float pdf = pdfSquare / solidAngle;
        const SampledSpectrum L = radiance_.Sample(*uv, lambda);
        if (!(pdf > 0) || !std::isfinite(pdf) || !L) return std::nullopt;
        return LightSample{L, wi, pdf, ref.p + 2 * sceneSphere_.radius * wi, 0, Normal3(0)};
    }
    float PdfLi(const LightReference& ref, Vec3 wi, const SurfaceInteraction*) const override {
        float solidAngle = 0;
        const std::optional<Point2> uv = HemisphereToSquare(portal_.frame.ToLocal(wi), &solidAngle);
        const std::optional<Window> window = WindowFrom(ref.p);
        if (!uv || !window || !(solidAngle > 0)) return 0;
        return distribution_.Pdf(*uv, *window) / solidAngle;
    }
    std::optional<LightEmission> SampleLe(Point2 uPosition, Point2 uDirection,
                                          const SampledWavelengths& lambda) const override {
        float pdfSquare = 0, solidAngle = 0;
        const std::optional<Point2> uv = distribution_.Sample(uDirection, Window{}, &pdfSquare);
        if (!uv) return std::nullopt;
        LightEmission emitted;
        emitted.L = radiance_.Sample(*uv, lambda);
        emitted.w = -portal_.frame.FromLocal(SquareToHemisphere(*uv, &solidAngle));
        const auto& c = portal_.corners;
        const Point3 inPortal = c[0] + uPosition.x * (c[3] - c[0]) + uPosition.y * (c[1] - c[0]);
        // From where nothing of the scene is behind it; before the portal, Le() says, it lights nothing.
        emitted.p = inPortal - (2 * sceneSphere_.radius + Length(inPortal - sceneSphere_.center)) * emitted.w;
        const EmissionDensity pdf = PdfLe(Normal3(0), emitted.w);
        emitted.pdfPosition = pdf.position;
        emitted.pdfDirection = pdfSquare / solidAngle;
        if (!emitted.L || !(pdf.position > 0) || !std::isfinite(pdf.position) ||
            !(emitted.pdfDirection > 0) || !std::isfinite(emitted.pdfDirection))
            return std::nullopt;
        return emitted;
    }
    EmissionDensity PdfLe(Normal3, Vec3 w) const override {
        float solidAngle = 0;
        const Vec3 local = portal_.frame.ToLocal(-w);
        const std::optional<Point2> uv = HemisphereToSquare(local, &solidAngle);
        if (!uv || !(solidAngle > 0)) return {};
        return {1 / (portal_.area * local.z), distribution_.Pdf(*uv, Window{}) / solidAngle};
    }
    float Power() const override { return power_; }

  private:
    /// The portal in the rectified square as seen from p; empty from behind its plane.
    std::optional<Window> WindowFrom(Point3 p) const {
        const std::optional<Point2> a = HemisphereToSquare(portal_.frame.ToLocal(portal_.corners[0] - p));
        const std::optional<Point2> b = HemisphereToSquare(portal_.frame.ToLocal(portal_.corners[2] - p));
        if (!a || !b) return std::nullopt;
        return Window{glm::min(*a, *b), glm::max(*a, *b)};
    }
    Portal portal_;
    SpectralMap radiance_;
    WindowedDistribution distribution_;
    float power_;
    BoundingSphere sceneSphere_;
};

/// The map resampled to the rectified parametrisation of a portal.
std::vector<RGB> Rectify(const Transform& renderFromLight, const EnvironmentMap& map, const Frame& frame) {
    const int n = map.Size();
    std::vector<RGB> texels;
    texels.reserve(size_t(n) * size_t(n));
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            float solidAngle;
            const Vec3 w = frame.FromLocal(SquareToHemisphere(TexelCenter(x, y, n), &solidAngle));
            const Point2 st = EqualAreaSphereToSquare(Normalize(renderFromLight.InverseVector(w)));
            RGB rgb;
            for (int c = 0; c < 3; ++c) rgb[c] = map.image->Bilinear(st, c, WrapMode::OctahedralSphere);
            texels.push_back(glm::max(rgb, 0.f));
        }
    return texels;
}

}  // namespace

std::unique_ptr<Light> MakePortalInfiniteLight(const Transform& renderFromLight, const EnvironmentMap& map,
                                               const Portal& portal) {
    return std::make_unique<PortalInfiniteLight>(map, portal, Rectify(renderFromLight, map, portal.frame));
}

}  // namespace lacquer
