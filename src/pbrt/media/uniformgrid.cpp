// Medium "uniformgrid": densities on a regular grid of voxels.
//
//   "float density" []                                   required          one value for each voxel: x
//                                                                          fastest, then y, then z
//   "integer nx", "integer ny", "integer nz"             1, 1, 1           numbers of voxels
//   "point3 p0", "point3 p1"                             (0 0 0), (1 1 1)  the box in medium space
//   "spectrum sigma_a", "spectrum sigma_s"               1, 1              absorption and scattering
//                                                                          coefficient of density 1 [1 / unit
//                                                                          of length in the world]
//   "string bulk"                                        -                 a file of "lacquer bulk" instead,
//                                                                          in 1/mm, with its phase function
//   "float scale"                                        1                 multiplies both coefficients
//   "string phase"                                       hg                and its parameters: see phases/
//   "spectrum Le"                                        0                 emitted radiance, or
//   "float temperature" []                               -                 black-body emission, one value for
//                                                                          each voxel: T = (value - offset)
//                                                                          scale [K]
//   "float temperatureoffset", "float temperaturescale"  0, 1              see there; "float
//                                                                          temperaturecutoff" is an older
//                                                                          name
//   "float Lescale" []                                   1                 multiplies either; absent, it is a
//                                                                          grid of one voxel: full in the
//                                                                          middle of the box only
#include "pbrt/base/light.h"
#include "pbrt/media/grid_params.h"
#include "pbrt/media/medium_params.h"

namespace lacquer {
namespace {

/// What the grid emits: a spectrum or temperatures, times a grid.
class GridEmission {
  public:
    GridEmission(const Params& params, Int3 resolution) : byTemperature_(params) {
        const std::unique_ptr<Spectrum> given = params.GetSpectrum("Le", SpectrumKind::Illuminant);
        const std::vector<float> temperatures = params.GetFloats("temperature");
        if (given && !temperatures.empty())
            params.Fail("temperature", "a medium has \"Le\" or \"temperature\", not both");
        scale_ = ReadFloatGrid(params, "Lescale", resolution);
        if (!scale_) scale_ = FloatGrid(Int3(1), std::vector<float>{1.f});
        if (!temperatures.empty()) {
            CheckVoxelCount(params, "temperature", temperatures.size(), resolution);
            temperature_ = FloatGrid(resolution, temperatures);
        } else if (given && given->MaxValue() > 0) {
            spectrum_ = DenselySampledSpectrum(*given);
            spectrum_->Scale(EmissionScale(*given, params, "Le", 1));
        }
    }
    bool IsEmissive() const { return (spectrum_ || temperature_) && scale_->Maximum() > 0; }
    /// @param u  in the unit cube
    SampledSpectrum Le(Point3 u, const SampledWavelengths& lambda) const {
        const float scale = scale_->Lookup(u);
        if (scale == 0) return SampledSpectrum(0);
        if (temperature_) return scale * byTemperature_.Le(temperature_->Lookup(u), lambda);
        return scale * spectrum_->Sample(lambda);
    }
    size_t MemoryBytes() const {
        return scale_->MemoryBytes() + (temperature_ ? temperature_->MemoryBytes() : 0);
    }

  private:
    std::optional<DenselySampledSpectrum> spectrum_;
    TemperatureEmission byTemperature_;
    std::optional<FloatGrid> temperature_, scale_;
};

class UniformGrid final : public Medium {
  public:
    explicit UniformGrid(const MediumArgs& args)
        : Medium(ReadMediumPhase(args)),
          unitFromRender_(ReadUnitFromRender(args)),
          density_(ReadDensity(args.params)),
          coefficients_(ReadCoefficients(args.params, density_.Maximum(), "density", GetPhaseModel())),
          emission_(args.params, density_.Resolution()),
          isEmissive_(emission_.IsEmissive()),
          majorants_(Bounds()) {}

    MediumProperties At(Point3 p, const SampledWavelengths& lambda) const override {
        const Point3 u = unitFromRender_.Point(p);
        if (!InUnitCube(u)) return {};
        const float density = density_.Lookup(u);
        if (density == 0) return {};
        MediumProperties properties{density * coefficients_.sigma_a.Sample(lambda),
                                    density * coefficients_.sigma_s.Sample(lambda), SampledSpectrum(0)};
        if (isEmissive_) properties.Le = emission_.Le(u, lambda);
        return properties;
    }
    MajorantWalk Majorants(const Ray& ray, float tMax, const SampledWavelengths& lambda) const override {
        return {majorants_, unitFromRender_.Ray(ray), tMax,
                coefficients_.sigma_a.Sample(lambda) + coefficients_.sigma_s.Sample(lambda)};
    }
    bool IsEmissive() const override { return isEmissive_; }
    size_t MemoryBytes() const override { return density_.MemoryBytes() + emission_.MemoryBytes(); }

  private:
    static FloatGrid ReadDensity(const Params& params) {
        std::optional<FloatGrid> density = ReadFloatGrid(params, "density", ReadResolution(params));
        if (!density)
            params.Fail("density",
                        "a medium \"uniformgrid\" needs \"float density\", with one value for each voxel");
        return std::move(*density);
    }
    MajorantGrid Bounds() const {
        const float sigma = coefficients_.sigma_a.MaxValue() + coefficients_.sigma_s.MaxValue();
        const Vec3 meanFreePaths = sigma * density_.Maximum() * EdgeLengths(unitFromRender_);
        return BoundUnitCube(MajorantResolution(meanFreePaths, density_.Resolution()),
                             [&](const Bounds3& box) { return density_.Maximum(box); });
    }

    Transform unitFromRender_;
    FloatGrid density_;
    Coefficients coefficients_;
    GridEmission emission_;
    bool isEmissive_;
    MajorantGrid majorants_;
};

std::unique_ptr<Medium> Create(const MediumArgs& args) { return std::make_unique<UniformGrid>(args); }

}  // namespace

LACQUER_REGISTER(MediumKind, "uniformgrid", Create);

}  // namespace lacquer
