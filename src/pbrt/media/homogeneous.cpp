// Medium "homogeneous": the same everywhere.
//
//   "spectrum sigma_a", "spectrum sigma_s"  1, 1  absorption and scattering coefficient [1 / unit of length
//                                                 in the world]
//   "string preset"                         -     a measured medium instead (data/scattering/presets.txt), in
//                                                 1/mm
//   "string bulk"                           -     a file of "lacquer bulk" instead, in 1/mm, with its phase
//                                                 function
//   "float scale"                           1     multiplies both coefficients
//   "spectrum Le"                           0     emitted radiance
//   "float Lescale"                         1     multiplies it
//   "string phase"                          hg    and its parameters: see phases/
#include "pbrt/core/sampling.h"
#include "pbrt/media/medium_params.h"

namespace lacquer {
namespace {

class Homogeneous final : public Medium {
  public:
    explicit Homogeneous(const MediumArgs& args) : Homogeneous(args, ReadPreset(args.params)) {}

    MediumProperties At(Point3, const SampledWavelengths& lambda) const override {
        MediumProperties properties{coefficients_.sigma_a.Sample(lambda),
                                    coefficients_.sigma_s.Sample(lambda), SampledSpectrum(0)};
        if (Le_) properties.Le = Le_->Sample(lambda);
        return properties;
    }
    MajorantWalk Majorants(const Ray& ray, float tMax, const SampledWavelengths& lambda) const override {
        return {0, tMax, At(ray.o, lambda).SigmaT()};
    }
    bool IsEmissive() const override { return Le_.has_value(); }
    bool IsHomogeneous() const override { return true; }

  private:
    Homogeneous(const MediumArgs& args, const std::optional<ScatteringPreset>& preset)
        : Medium(ReadMediumPhase(args)),
          coefficients_(ReadCoefficients(args.params, 1, args.params.Has("scale") ? "scale" : "sigma_s",
                                         GetPhaseModel(), preset ? &*preset : nullptr)),
          Le_(ReadMediumEmission(args.params)) {}

    Coefficients coefficients_;
    std::optional<DenselySampledSpectrum> Le_;  ///< empty: emits nothing
};

std::unique_ptr<Medium> Create(const MediumArgs& args) { return std::make_unique<Homogeneous>(args); }

}  // namespace

LACQUER_REGISTER(MediumKind, "homogeneous", Create);

}  // namespace lacquer
