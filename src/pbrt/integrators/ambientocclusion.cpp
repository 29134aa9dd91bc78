// Integrator "ambientocclusion": how open the surroundings of a surface are; white where nothing is near.
//
//   "bool cossample"     true      directions by the cosine; false: uniform over the hemisphere
//   "float maxdistance"  infinity  what is farther away does not count
#include <fmt/format.h>

#include "pbrt/core/sampling.h"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {
namespace {

class AmbientOcclusionIntegrator final : public Integrator {
  public:
    explicit AmbientOcclusionIntegrator(const IntegratorArgs& args)
        : samplesCosine_(args.params.GetBool("cossample", true)),
          maxDistance_(args.params.GetFloat("maxdistance", Infinity)),
          white_(args.params.ColorSpace().Illuminant()),
          surroundings_(args) {
        if (!(maxDistance_ > 0))
            args.params.Fail("maxdistance",
                             fmt::format("maxdistance is {}; it must be positive", maxDistance_));
    }

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        SurfaceInteraction si;
        if (!TracedPath::FromCamera(surroundings_, cameraRay, 1, state)
                 .FollowToSurface(cameraRay.ray, lambda, &si))
            return SampledSpectrum(0);
        // Geometry alone decides: neither bumps nor interpolated normals.
        const Point2 u = sampler.Get2D();
        const Vec3 w = samplesCosine_ ? SampleCosineHemisphere(u) : SampleUniformHemisphere(u);
        const float pdf = samplesCosine_ ? PdfCosineHemisphere(w.z) : PdfUniformHemisphere();
        if (!(pdf > 0)) return SampledSpectrum(0);
        const Normal3 n = FaceForward(si.n, si.wo);
        const Ray ray = SpawnRay(si, Frame::FromZ(n).FromLocal(w));
        if (surroundings_.scene.Occluded(ray, maxDistance_, state.rays)) return SampledSpectrum(0);
        return white_.Sample(lambda) * (w.z / (Pi * pdf * kCieYIntegral));
    }

  private:
    bool samplesCosine_;
    float maxDistance_;
    const DenselySampledSpectrum& white_;
    PathSurroundings surroundings_;
};

std::unique_ptr<Integrator> CreateAmbientOcclusion(const IntegratorArgs& args) {
    return std::make_unique<AmbientOcclusionIntegrator>(args);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "ambientocclusion", CreateAmbientOcclusion,
                 {.otherImage = "renders how open the surroundings of a surface are, not its light"});

}  // namespace lacquer
