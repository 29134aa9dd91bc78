// How open the surroundings of a surface are, as white where nothing is near. Parameters: cossample
// (directions by the cosine, or uniform), maxdistance (what is farther away does not count).
#include <fmt/format.h>

#include "pbrt/core/sampling.h"
#include "pbrt/integrators/surface_point.h"

namespace lacquer {
namespace {

class AmbientOcclusionIntegrator final : public Integrator {
  public:
    explicit AmbientOcclusionIntegrator(const IntegratorArgs& args)
        : scene_(args.scene),
          samplesCosine_(args.params.GetBool("cossample", true)),
          maxDistance_(args.params.GetFloat("maxdistance", Infinity)),
          white_(args.params.ColorSpace().Illuminant()),
          footprint_(args.scene.Camera(), args.scene.Resolution(), args.footprintScale) {
        if (!(maxDistance_ > 0))
            args.params.Fail("maxdistance",
                             fmt::format("maxdistance is {}; it must be positive", maxDistance_));
    }

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        SurfaceInteraction si;
        if (!FirstBsdf(scene_, cameraRay, footprint_, lambda, state, &si)) return SampledSpectrum(0);
        ++state.pathLengthSum;
        // Geometry alone decides: neither bumps nor interpolated normals.
        const Point2 u = sampler.Get2D();
        const Vec3 w = samplesCosine_ ? SampleCosineHemisphere(u) : SampleUniformHemisphere(u);
        const float pdf = samplesCosine_ ? PdfCosineHemisphere(w.z) : PdfUniformHemisphere();
        if (!(pdf > 0)) return SampledSpectrum(0);
        const Normal3 n = FaceForward(si.n, si.wo);
        ++state.shadowRays;
        if (scene_.Occluded(SpawnRay(si, Frame::FromZ(n).FromLocal(w)), maxDistance_))
            return SampledSpectrum(0);
        return white_.Sample(lambda) * (w.z / (Pi * pdf * kCieYIntegral));
    }

  private:
    const Scene& scene_;
    bool samplesCosine_;
    float maxDistance_;
    const DenselySampledSpectrum& white_;
    FootprintEstimator footprint_;
};

std::unique_ptr<Integrator> CreateAmbientOcclusion(const IntegratorArgs& args) {
    return std::make_unique<AmbientOcclusionIntegrator>(args);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "ambientocclusion", CreateAmbientOcclusion);

}  // namespace lacquer
