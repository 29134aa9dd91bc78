// Auxiliary outputs ("arbitrary output variables"): what the camera sees beside radiance.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pbrt/base/camera.h"
#include "pbrt/base/integrator.h"
#include "pbrt/image/image.h"

namespace lacquer {

/// One sample's first hit, in rendering space.
struct FirstHit {
    bool hit = false;
    Point3 p{0};
    Normal3 n{0}, ns{0};  ///< facing the viewer
    Point2 uv{0};
    SampledSpectrum albedo;  ///< hemispherical-directional reflectance (and transmittance)
};

/// Keeps the last first hit that an integrator reported; one for each thread.
class FirstHitRecorder final : public FirstHitObserver {
  public:
    /// @param wantAlbedo  the albedo costs 16 BxDF samples a hit
    explicit FirstHitRecorder(bool wantAlbedo) : wantAlbedo_(wantAlbedo) {}
    void Record(const SurfaceInteraction& si, const BxDF& bxdf, Vec3 woLocal) override;
    void Clear() { last_ = {}; }
    const FirstHit& Last() const { return last_; }

  private:
    bool wantAlbedo_;
    FirstHit last_;
};

/// Sums of the outputs that were asked for; extra channels of the written image.
///
/// name           channels              meaning
/// albedo         Albedo.R,G,B          reflectance seen under the colour space's white, averaged over all
/// samples normal         N.X,Y,Z               geometric normal toward the viewer, world space, mean over
/// hits, normalised shadingnormal  Ns.X,Y,Z              the same of the shading normal position P.X,Y,Z
/// world-space point, mean over hits depth          Z                     camera-space z, mean over hits uv
/// u,v                   surface parameters, mean over hits variance       Variance.Y            sample
/// variance of the luminance of camera samples samples        samples               camera samples that the
/// pixel got
class AovBuffer {
  public:
    static const std::vector<std::string>& Names();
    /// @param names  as above (checked by the caller)
    AovBuffer(const std::vector<std::string>& names, const Bounds2i& pixelBounds, const ColorSpace& space,
              const Transform& worldFromRender, const Transform& cameraFromRender);

    bool Wants(const std::string& name) const;
    /// True if anything beside variance and samples is wanted.
    bool WantsFirstHit() const;
    /// Adds one camera sample; pixels belong to one thread at a time.
    void Add(Int2 pixel, const FirstHit& hit, SampledSpectrum L, const SampledWavelengths& lambda);
    /// Appends the channels to an image of the same pixels.
    std::unique_ptr<Image> AppendTo(const Image& rgb) const;

  private:
    struct Pixel {
        double samples = 0, hits = 0;
        double albedo[3] = {}, n[3] = {}, ns[3] = {}, p[3] = {}, z = 0, uv[2] = {};
        double luminanceMean = 0, luminanceM2 = 0;
    };
    std::vector<float> Channels(const Pixel& pixel) const;

    std::vector<std::string> names_;
    Bounds2i bounds_;
    const ColorSpace* space_;
    Transform worldFromRender_, cameraFromRender_;
    std::vector<Pixel> pixels_;
};

}  // namespace lacquer
