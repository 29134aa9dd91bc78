// Integrator "example": white where something is.
// Stands in src/pbrt/integrators. Scene: Integrator "example"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {
namespace {

class Example final : public Integrator {
  public:
    explicit Example(const IntegratorArgs& args) : surroundings_(args) {}
    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths&, Sampler&,
                       ThreadState& state) const override {
        SurfaceInteraction si;
        TracedPath path = TracedPath::FromCamera(surroundings_, cameraRay, 1, state);
        return SampledSpectrum(path.Intersect(cameraRay.ray, &si) ? 1.f : 0.f);
    }

  private:
    PathSurroundings surroundings_;
};

std::unique_ptr<Integrator> Create(const IntegratorArgs& args) { return std::make_unique<Example>(args); }

}  // namespace

LACQUER_REGISTER(IntegratorKind, "example", Create);

}  // namespace lacquer
