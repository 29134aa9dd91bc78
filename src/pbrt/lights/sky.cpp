// Light "infinite" with `"string model" "sky"`: sun and sky of a clear day or of twilight, spectral. z is up.
//
//   "float turbidity"         3     1 is air without aerosol, 2 very clear, 3 clear, 10 hazy
//   "spectrum groundalbedo"   0.2   of the ground that the sky sees
//   "float ozone"             300   of the column [Dobson units]
//   "float elevation"         30    of the sun over the horizon [degrees], -18 to 90
//   "float azimuth"           0     of the sun, clockwise from north, which is +y; east is -x, as cameras
//                                   see it in pbrt's left-handed space
//   "string time"             -     instead of these two: "2026-06-21 15:30 +02:00", with
//   "float latitude"          -     [degrees], north is positive
//   "float longitude"         -     [degrees], east is positive
//   "vector3 sundirection"    -     instead of them: toward the sun, in the light's space
//   "bool sun"                true  with the disk of the sun
//   "bool ground"             true  below the horizon there is the ground; else black
//   "float scale"             1     with 1, light of 1 W m^-2 sr^-1 nm^-1 has luminance 1
#include <fmt/format.h>

#include "pbrt/core/invertible.h"
#include "pbrt/core/sampling.h"
#include "pbrt/lights/emission.h"
#include "pbrt/lights/infinite.h"
#include "pbrt/scattering/clear_sky.h"
#include "pbrt/scattering/sun_position.h"

namespace lacquer {

namespace {

constexpr int kMapSize = 256;  // of the map by which directions are drawn

class SkyLight final : public Light {
  public:
    SkyLight(const Transform& renderFromLight, const ClearSkySettings& settings)
        : Light(Kind::Infinite),
          renderFromLight_(renderFromLight.Matrix()),
          lightFromRender_(renderFromLight.InverseMatrix()),
          fromLight_(renderFromLight),
          sky_(settings),
          disk_(Frame::FromZ(settings.sun)) {
        MakeMap();
        if (!sky_.HasDisk()) return;
        const float sun = sky_.ToXYZ(sky_.Sun(), ClearSky::Part::Sun).y * ClearSky::DiskSolidAngle();
        sunProbability_ = std::clamp(sun / (sun + mapIrradiance_), 0.1f, 0.9f);
        meanLuminance_ += sun * Inv4Pi;
    }

    void Preprocess(const Bounds3& sceneBounds) override { sceneSphere_ = BoundingSphereOf(sceneBounds); }
    SampledSpectrum Le(const Ray& ray, const SampledWavelengths& lambda) const override {
        return sky_.Radiance(Normalize(lightFromRender_ * ray.d), lambda);
    }
    std::optional<LightSample> SampleLi(const LightReference& ref, Point2 u,
                                        const SampledWavelengths& lambda) const override {
        const Vec3 inLight = SampleDirection(u);
        const Vec3 wi = Normalize(renderFromLight_ * inLight);
        const float pdf = DensityOf(inLight) * fromLight_.DensityFactor(inLight);
        const SampledSpectrum L = sky_.Radiance(inLight, lambda);
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
    float Power() const override { return 4 * Pi * Pi * Sqr(sceneSphere_.radius) * meanLuminance_; }

  private:
    Vec3 SampleDirection(Point2 u) const {
        if (u.x < sunProbability_) {
            u.x /= sunProbability_;
            const Point2 d = SampleUniformDiskConcentric(u);
            // Uniform over the cap: 1 - cos(theta) = (1 - cos of the rim) r^2.
            const float height = ClearSky::DiskHeight() * (d.x * d.x + d.y * d.y);
            const float stretch = std::sqrt(ClearSky::DiskHeight() * (2 - height));
            return disk_.FromLocal(Vec3(stretch * d.x, stretch * d.y, 1 - height));
        }
        u.x = (u.x - sunProbability_) / (1 - sunProbability_);
        float pdf = 0;
        return EqualAreaSquareToSphere(map_.Sample(glm::min(u, Point2(OneMinusEpsilon)), &pdf));
    }
    float DensityOf(Vec3 w) const {
        const float fromMap = map_.Pdf(EqualAreaSphereToSquare(w)) * Inv4Pi;
        return (1 - sunProbability_) * fromMap +
               (sky_.IsInDisk(w) ? sunProbability_ / ClearSky::DiskSolidAngle() : 0.f);
    }

    void MakeMap() {
        std::vector<float> luminance(size_t(kMapSize) * kMapSize);
        double sum = 0, irradiance = 0;
        for (int y = 0; y < kMapSize; ++y)
            for (int x = 0; x < kMapSize; ++x) {
                const Vec3 w = EqualAreaSquareToSphere((Point2(float(x), float(y)) + 0.5f) / float(kMapSize));
                const float Y = sky_.ToXYZ(w, ClearSky::Part::Sky).y;
                luminance[size_t(y) * kMapSize + size_t(x)] = Y;
                sum += double(Y);
                irradiance += double(Y * std::max(w.z, 0.f));
            }
        const double perTexel = 4 * double(Pi) / (double(kMapSize) * kMapSize);
        mapIrradiance_ = float(irradiance * perTexel);
        meanLuminance_ = float(sum / (double(kMapSize) * kMapSize));
        map_ = CompensatedDistribution(std::move(luminance), kMapSize, meanLuminance_);
    }

    glm::mat3 renderFromLight_, lightFromRender_;
    SolidAngleMap fromLight_;
    ClearSky sky_;
    Frame disk_;  ///< z toward the sun
    PiecewiseConstant2D map_;
    float mapIrradiance_ = 0, meanLuminance_ = 0, sunProbability_ = 0;
    BoundingSphere sceneSphere_;
};

// ---- Parameters ----

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
    return DirectionOfSun(float(sun.elevation), float(sun.azimuth));
}

Vec3 ReadSun(const Params& params) {
    const bool byTime = params.Has("time"), byAngles = params.Has("elevation") || params.Has("azimuth");
    const bool byDirection = params.Has("sundirection");
    if (int(byTime) + int(byAngles) + int(byDirection) > 1)
        params.Fail(byTime ? "time" : "sundirection",
                    "the sun is placed either by \"elevation\" and \"azimuth\", or by \"time\", or by "
                    "\"sundirection\"");
    if (!byTime)
        for (const char* name : {"latitude", "longitude"})
            if (params.Has(name))
                params.Fail(name,
                            fmt::format("\"float {}\" goes with \"string time\", which is not given", name));
    if (byTime) return SunAtTime(params, params.GetString("time", ""));
    if (!byDirection)
        return DirectionOfSun(params.GetFloatInRange("elevation", 30, kLowestSun, 90),
                              params.GetFloatInRange("azimuth", 0, -360, 360));
    const Vec3 direction = params.GetVector3("sundirection", Vec3(0, 0, 1));
    const float length = Length(direction);
    if (!(length > 0)) params.Fail("sundirection", "a direction needs a length above 0");
    const Vec3 sun = direction / length;
    if (std::asin(std::clamp(sun.z, -1.f, 1.f)) < kLowestSun * Pi / 180)
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
    ClearSkySettings settings;
    settings.sun = ReadSun(params);
    settings.turbidity = params.GetFloatInRange("turbidity", 3, 1, 30);
    settings.ozone = params.GetFloatInRange("ozone", 300, 0, 1000);
    settings.groundAlbedo = ReadGroundAlbedo(params);
    settings.scale = ReadScale(params);
    settings.hasSun = params.GetBool("sun", true);
    settings.hasGround = params.GetBool("ground", true);
    // What is misspelt is told before the sky is computed. The group is read by who asked for the light.
    params.Ignore("string", "group");
    params.CheckAllUsed();
    return std::make_unique<SkyLight>(args.renderFromLight, settings);
}

}  // namespace lacquer
