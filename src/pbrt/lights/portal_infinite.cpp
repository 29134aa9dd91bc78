// Light from all around, given by a picture, that enters through a rectangle only [Bitterli et al. 2015].
#include "pbrt/lights/emission.h"
#include "pbrt/lights/infinite.h"
#include "pbrt/lights/windowed_distribution.h"

namespace lacquer {

namespace {

/// Unit square to the hemisphere of the portal's frame, rectified: lines parallel to the portal's edges become
/// parallel to the square's, and so the portal is an axis-aligned rectangle from wherever it is seen.
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
    return Point2(0.5f + std::atan2(w.x, w.z) * InvPi, 0.5f + std::atan2(w.y, w.z) * InvPi);
}

Point2 TexelCenter(int x, int y, int n) { return (Point2(float(x), float(y)) + 0.5f) / float(n); }

class PortalInfiniteLight final : public Light {
  public:
    PortalInfiniteLight(const Transform& renderFromLight, const EnvironmentMap& map, const Portal& portal)
        : Light(Kind::Infinite), portal_(portal), space_(&map.Space()), scale_(map.scale), n_(map.Size()),
          texels_(Rectify(renderFromLight, map)), distribution_(Weights(map), n_, n_) {
        double flux = 0;
        for (int y = 0; y < n_; ++y)
            for (int x = 0; x < n_; ++x) {
                float solidAngle;
                const Vec3 w = SquareToHemisphere(TexelCenter(x, y, n_), &solidAngle);
                flux += double(map.Luminance(Texel(x, y)) * w.z * solidAngle);
            }
        power_ = float(flux / (double(n_) * n_)) * portal.area;
    }

    void Preprocess(const Bounds3& sceneBounds) override { radius_ = BallAround(sceneBounds).radius; }
    SampledSpectrum Le(const Ray& ray, const SampledWavelengths& lambda) const override {
        const std::optional<Point2> uv = HemisphereToSquare(portal_.frame.ToLocal(Normalize(ray.d)));
        const std::optional<Window> window = WindowFrom(ray.o);
        if (!uv || !window || !window->Contains(*uv)) return SampledSpectrum(0);
        return Lookup(*uv, lambda);
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
        const SampledSpectrum L = Lookup(*uv, lambda);
        if (!(pdf > 0) || !std::isfinite(pdf) || !L) return std::nullopt;
        return LightSample{L, wi, pdf, ref.p + 2 * radius_ * wi, 0, Normal3(0)};
    }
    float PdfLi(const LightReference& ref, Vec3 wi, const SurfaceInteraction*) const override {
        float solidAngle = 0;
        const std::optional<Point2> uv = HemisphereToSquare(portal_.frame.ToLocal(wi), &solidAngle);
        const std::optional<Window> window = WindowFrom(ref.p);
        if (!uv || !window || !(solidAngle > 0)) return 0;
        return distribution_.Pdf(*uv, *window) / solidAngle;
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
    RGB Texel(int x, int y) const { return texels_[size_t(y) * size_t(n_) + size_t(x)]; }
    SampledSpectrum Lookup(Point2 uv, const SampledWavelengths& lambda) const {
        const int x = std::clamp(int(uv.x * float(n_)), 0, n_ - 1), y = std::clamp(int(uv.y * float(n_)), 0, n_ - 1);
        return SampleRGB(*space_, Texel(x, y), SpectrumKind::Illuminant, lambda) * scale_;
    }
    std::vector<RGB> Rectify(const Transform& renderFromLight, const EnvironmentMap& map) const;
    std::vector<float> Weights(const EnvironmentMap& map) const;

    Portal portal_;
    const ColorSpace* space_;
    float scale_;
    int n_;
    std::vector<RGB> texels_;  // the map in the rectified parametrisation, not negative
    WindowedDistribution distribution_;
    float power_ = 0, radius_ = 1;
};

std::vector<RGB> PortalInfiniteLight::Rectify(const Transform& renderFromLight, const EnvironmentMap& map) const {
    std::vector<RGB> texels;
    texels.reserve(size_t(n_) * size_t(n_));
    for (int y = 0; y < n_; ++y)
        for (int x = 0; x < n_; ++x) {
            float solidAngle;
            const Vec3 w = portal_.frame.FromLocal(SquareToHemisphere(TexelCenter(x, y, n_), &solidAngle));
            const Point2 st = EqualAreaSphereToSquare(Normalize(renderFromLight.InverseVector(w)));
            RGB rgb;
            for (int c = 0; c < 3; ++c) rgb[c] = map.image->Bilinear(st, c, WrapMode::OctahedralSphere);
            texels.push_back(glm::max(rgb, 0.f));
        }
    return texels;
}

std::vector<float> PortalInfiniteLight::Weights(const EnvironmentMap& map) const {
    std::vector<float> weights;
    weights.reserve(texels_.size());
    for (int y = 0; y < n_; ++y)
        for (int x = 0; x < n_; ++x) {
            float solidAngle;
            SquareToHemisphere(TexelCenter(x, y, n_), &solidAngle);
            weights.push_back(map.Luminance(Texel(x, y)) * solidAngle);
        }
    return weights;
}

}  // namespace

std::unique_ptr<Light> MakePortalInfiniteLight(const Transform& renderFromLight, const EnvironmentMap& map,
                                               const Portal& portal) {
    return std::make_unique<PortalInfiniteLight>(renderFromLight, map, portal);
}

}  // namespace lacquer
