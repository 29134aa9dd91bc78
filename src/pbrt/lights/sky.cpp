// Light "infinite" with `"string model" "sky"`: sun and sky of a clear day or of twilight, spectral. z is up.
//
//   "float turbidity"        3           1 is air without aerosol, 2 very clear, 3 clear, 10 hazy
//   "spectrum groundalbedo"  0.2         of the ground that the sky sees
//   "float ozone"            300         of the column [Dobson units]
//   "float elevation"        30          of the sun over the horizon [degrees], -18 to 90
//   "float azimuth"          0           of the sun, clockwise from north, which is +y; east is -x, as
//   cameras see
//                                        it in pbrt's left-handed space
//   "string time"            -           instead of these two: "2026-06-21 15:30 +02:00", with
//   "float latitude", "float longitude"  - [degrees], north and east are positive
//   "vector3 sundirection"   -           instead of them: toward the sun, in the light's space
//   "bool sun"               true        with the disk of the sun
//   "bool ground"            true        below the horizon there is the ground; else black
//   "float scale"            1           with 1, light of 1 W m^-2 sr^-1 nm^-1 at all wavelengths has
//   luminance 1
#include <fmt/format.h>

#include "pbrt/core/embedded.h"
#include "pbrt/core/invertible.h"
#include "pbrt/core/sampling.h"
#include "pbrt/lights/emission.h"
#include "pbrt/lights/infinite.h"
#include "pbrt/scattering/sky_radiance.h"
#include "pbrt/scattering/sun_position.h"

namespace lacquer {

namespace {

constexpr float kSunRadius = 0.2666f * Pi / 180;  // mean angle from its centre to its rim
constexpr int kMapSize = 256;                     // of the map by which directions are drawn

/// Sunlight above the air [W m^-2 nm^-1], in the unit of lights: see `scale`.
DenselySampledSpectrum Sunlight(float scale) {
    std::vector<float> nm, irradiance;
    for (const std::vector<double>& row : EmbeddedTable("spectra/sky/sun.txt")) {
        nm.push_back(float(row.at(0)));
        irradiance.push_back(scale / kCieYIntegral * float(row.at(1)));
    }
    return DenselySampledSpectrum(PiecewiseLinearSpectrum::Extended(std::move(nm), std::move(irradiance)));
}

float Luminance(const SkySpectrum& transfer, const DenselySampledSpectrum& sunlight) {
    float sum = 0;
    for (int i = 0; i < kNumSkyWavelengths; ++i) {
        const float lambda = SkyWavelength(i);
        sum += transfer[size_t(i)] * sunlight.Evaluate(lambda) * CieY().Evaluate(lambda);
    }
    return sum * (SkyWavelength(1) - SkyWavelength(0));
}

struct SkySetup {
    SkyOptions options;
    Vec3 sun{0, 0, 1};  ///< toward it, in the light's space
    float scale = 1;
    bool hasSun = true, hasGround = true;
};

class SkyLight final : public Light {
  public:
    SkyLight(const Transform& renderFromLight, const SkySetup& setup)
        : Light(Kind::Infinite),
          renderFromLight_(renderFromLight.Matrix()),
          lightFromRender_(renderFromLight.InverseMatrix()),
          fromLight_(renderFromLight),
          setup_(setup),
          sky_(setup.options),
          sunlight_(Sunlight(setup.scale)),
          disk_(Frame::FromZ(setup.sun)) {
        const float horizontal = std::hypot(setup.sun.x, setup.sun.y);
        if (horizontal > 0) side_ = Vec2(setup.sun.x, setup.sun.y) / horizontal;
        MakeMap();
        hasDisk_ = setup.hasSun && setup.sun.z > 0;
        if (!hasDisk_) return;
        const float sun = Luminance(sky_.SunTransmittance(), sunlight_);
        sunProbability_ = std::clamp(sun / (sun + mapIrradiance_), 0.1f, 0.9f);
        power_ += sun / (4 * Pi);
    }

    void Preprocess(const Bounds3& sceneBounds) override { sceneSphere_ = BoundingSphereOf(sceneBounds); }
    SampledSpectrum Le(const Ray& ray, const SampledWavelengths& lambda) const override {
        return RadianceFrom(Normalize(lightFromRender_ * ray.d), lambda);
    }
    std::optional<LightSample> SampleLi(const LightReference& ref, Point2 u,
                                        const SampledWavelengths& lambda) const override {
        const Vec3 inLight = SampleDirection(u);
        const Vec3 wi = Normalize(renderFromLight_ * inLight);
        const float pdf = DensityOf(inLight) * fromLight_.DensityFactor(inLight);
        const SampledSpectrum L = RadianceFrom(inLight, lambda);
        if (!(pdf > 0) || !L) return std::nullopt;
        return LightSample{L, wi, pdf, ref.p + 2 * sceneSphere_.radius * wi, 0, Normal3(0)};
    }
    float PdfLi(const LightReference&, Vec3 wi, const SurfaceInteraction*) const override {
        const Vec3 inLight = Normalize(lightFromRender_ * wi);
        return DensityOf(inLight) * fromLight_.DensityFactor(inLight);
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
    float Power() const override { return 4 * Pi * Pi * Sqr(sceneSphere_.radius) * power_; }

  private:
    /// In the frame of SkyRadiance, where the sun is over +x.
    Vec3 ToSky(Vec3 w) const { return {side_.x * w.x + side_.y * w.y, side_.x * w.y - side_.y * w.x, w.z}; }
    /// Less for directions near the horizon from below: those within rounding are the sky's.
    bool IsSky(Vec3 w) const { return w.z >= 0; }
    SampledSpectrum RadianceFrom(Vec3 w, const SampledWavelengths& lambda) const {
        SampledSpectrum L(0);
        if (IsSky(w))
            L = sky_.Radiance(ToSky(w), lambda);
        else if (setup_.hasGround)
            L = SkyRadiance::Interpolate(sky_.Ground(), lambda);
        if (hasDisk_ && IsInDisk(w) && IsSky(w))
            L += SkyRadiance::Interpolate(sky_.SunTransmittance(), lambda) / DiskSolidAngle();
        return L * sunlight_.Sample(lambda);
    }

    static float OneMinusCosine() { return 2 * Sqr(std::sin(kSunRadius / 2)); }
    static float DiskSolidAngle() { return 2 * Pi * OneMinusCosine(); }
    /// By the chord: 1 - cos of a small angle has few digits.
    bool IsInDisk(Vec3 w) const { return LengthSquared(w - setup_.sun) <= 2 * OneMinusCosine(); }

    Vec3 SampleDirection(Point2 u) const {
        if (hasDisk_ && u.x < sunProbability_) {
            u.x /= sunProbability_;
            const Point2 d = SampleUniformDiskConcentric(u);
            // Uniform over the cap: 1 - cos(theta) = (1 - cos of the rim) r^2.
            const float height = OneMinusCosine() * (d.x * d.x + d.y * d.y);
            const float stretch = std::sqrt(OneMinusCosine() * (2 - height));
            return disk_.FromLocal(Vec3(stretch * d.x, stretch * d.y, 1 - height));
        }
        if (hasDisk_) u.x = (u.x - sunProbability_) / (1 - sunProbability_);
        float pdf = 0;
        return EqualAreaSquareToSphere(map_.Sample(glm::min(u, Point2(OneMinusEpsilon)), &pdf));
    }
    float DensityOf(Vec3 w) const {
        const float fromMap = map_.Pdf(EqualAreaSphereToSquare(w)) * Inv4Pi;
        if (!hasDisk_) return fromMap;
        return (1 - sunProbability_) * fromMap + (IsInDisk(w) ? sunProbability_ / DiskSolidAngle() : 0.f);
    }

    /// Directions are drawn where the sky exceeds its mean, as in image_infinite.cpp.
    void MakeMap() {
        std::vector<float> luminance(size_t(kMapSize) * kMapSize);
        const float ground = setup_.hasGround ? Luminance(sky_.Ground(), sunlight_) : 0;
        double sum = 0, irradiance = 0;
        for (int y = 0; y < kMapSize; ++y)
            for (int x = 0; x < kMapSize; ++x) {
                const Vec3 w = EqualAreaSquareToSphere((Point2(float(x), float(y)) + 0.5f) / float(kMapSize));
                const float Y = IsSky(w) ? Luminance(sky_.Radiance(ToSky(w)), sunlight_) : ground;
                luminance[size_t(y) * kMapSize + size_t(x)] = Y;
                sum += double(Y);
                irradiance += double(Y * std::max(w.z, 0.f));
            }
        const double perTexel = 4 * double(Pi) / (double(kMapSize) * kMapSize);
        mapIrradiance_ = float(irradiance * perTexel);
        power_ = float(sum / (double(kMapSize) * kMapSize));
        for (float& Y : luminance) Y = std::max(Y - power_, 0.05f * Y);
        map_ = PiecewiseConstant2D(luminance, kMapSize, kMapSize);
    }

    glm::mat3 renderFromLight_, lightFromRender_;
    SolidAngleMap fromLight_;
    SkySetup setup_;
    SkyRadiance sky_;
    DenselySampledSpectrum sunlight_;
    Frame disk_;  ///< z toward the sun
    Vec2 side_{1, 0};
    PiecewiseConstant2D map_;
    float mapIrradiance_ = 0, power_ = 0, sunProbability_ = 0;
    bool hasDisk_ = false;
    BoundingSphere sceneSphere_;
};

// ---- Parameters ----

constexpr float kDegree = Pi / 180;

/// Where the sun is, from elevation and azimuth.
Vec3 SunDirection(float elevation, float azimuth) {
    const float c = std::cos(elevation * kDegree);
    return {-c * std::sin(azimuth * kDegree), c * std::cos(azimuth * kDegree), std::sin(elevation * kDegree)};
}

constexpr float kLowestSun = -18;  // the end of astronomical twilight [degrees]

Vec3 SunAtTime(const Params& params, const std::string& time) {
    const std::optional<Instant> instant = ParseInstant(time);
    if (!instant)
        params.Fail("time",
                    fmt::format("\"{}\" is no time; expected one like \"2026-06-21 15:30 +02:00\"", time));
    for (const char* name : {"latitude", "longitude"})
        if (!params.Has(name))
            params.Fail(name, fmt::format("\"string time\" needs \"float {}\" as well", name));
    const auto latitude = double(params.GetFloatInRange("latitude", 0, -90, 90));
    const auto longitude = double(params.GetFloatInRange("longitude", 0, -180, 180));
    const SunPosition sun = SunPositionAt(*instant, latitude, longitude);
    if (sun.elevation < double(kLowestSun))
        params.Fail("time",
                    fmt::format("at this time the sun is {:.1f} degrees below the horizon; it is night "
                                "below {}",
                                -sun.elevation, -kLowestSun));
    return SunDirection(float(sun.elevation), float(sun.azimuth));
}

Vec3 ReadSun(const Params& params) {
    const bool byTime = params.Has("time"), byAngles = params.Has("elevation") || params.Has("azimuth");
    const bool byDirection = params.Has("sundirection");
    if (int(byTime) + int(byAngles) + int(byDirection) > 1)
        params.Fail(byTime ? "time" : "sundirection",
                    "the sun is placed either by \"elevation\" and \"azimuth\", or by \"time\", or by "
                    "\"sundirection\"");
    if (byTime) return SunAtTime(params, params.GetString("time", ""));
    if (!byDirection)
        return SunDirection(params.GetFloatInRange("elevation", 30, kLowestSun, 90),
                            params.GetFloatInRange("azimuth", 0, -360, 360));
    const Vec3 direction = params.GetVector3("sundirection", Vec3(0, 0, 1));
    const float length = Length(direction);
    if (!(length > 0)) params.Fail("sundirection", "a direction needs a length above 0");
    const Vec3 sun = direction / length;
    if (std::asin(std::clamp(sun.z, -1.f, 1.f)) < kLowestSun * kDegree)
        params.Fail("sundirection",
                    fmt::format("the sun is more than {} degrees below the horizon (z is up)", -kLowestSun));
    return sun;
}

SkySpectrum ReadGroundAlbedo(const Params& params) {
    SkySpectrum albedo;
    albedo.fill(0.2f);
    if (const auto spectrum = params.GetSpectrum("groundalbedo", SpectrumKind::Albedo))
        for (int i = 0; i < kNumSkyWavelengths; ++i)
            albedo[size_t(i)] = std::clamp(spectrum->Evaluate(SkyWavelength(i)), 0.f, 1.f);
    return albedo;
}

}  // namespace

std::unique_ptr<Light> MakeSkyLight(const LightArgs& args) {
    const Params& params = args.params;
    RequireInvertible(params, args.renderFromLight);
    SkySetup setup;
    setup.sun = ReadSun(params);
    setup.options.sunElevation = std::asin(std::clamp(setup.sun.z, -1.f, 1.f));
    setup.options.turbidity = params.GetFloatInRange("turbidity", 3, 1, 30);
    setup.options.ozone = params.GetFloatInRange("ozone", 300, 0, 1000);
    setup.options.groundAlbedo = ReadGroundAlbedo(params);
    setup.scale = ReadScale(params);
    setup.hasSun = params.GetBool("sun", true);
    setup.hasGround = params.GetBool("ground", true);
    return std::make_unique<SkyLight>(args.renderFromLight, setup);
}

}  // namespace lacquer
