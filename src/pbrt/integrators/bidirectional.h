// Bidirectional path tracing, strategy by strategy [Veach 1997, ch. 10]. Strategy (s, t) makes a path of s
// vertices from a light and t from the camera: the emitter and the camera count as vertices. Its light comes
// with its weight among all strategies that make the same path, by the power heuristic. Lights are chosen by
// their power.
//
// Where a BxDF knows the density of what it samples only as a random estimate, weights take that estimate in
// all strategies alike, with numbers of its own (DensitiesAt()). Throughputs never contain it: they come from
// the weights of the samples. So each strategy is unbiased with any weight, and the weights of all strategies
// for one path have the expectation of a sum that is 1.
//
// The wavelengths of a sample stay: a subpath that was dispersed knows that it carries the first one alone,
// and what it finds then counts for that one (OverMeanPdf()).
#pragma once

#include "pbrt/integrators/subpath.h"

namespace lacquer {

/// Light that reaches the camera at a point of the film: what Film::AddSplat() takes.
struct FilmLight {
    Point2 p{0};
    SampledSpectrum L{0.f};
};

/// The strategies. Vertices that they connect are the last ones of what they are given as s and t, and must
/// be connectible.
class BidirectionalStrategies {
  public:
    /// @param regularize  widens narrow lobes after the first diffuse or glossy event of a path
    /// @param roulette    subpaths end at random where they carry little
    BidirectionalStrategies(const IntegratorArgs& args, bool regularize, bool roulette)
        : scene_(args.scene),
          regularize_(regularize),
          roulette_(roulette),
          surroundings_(args),
          emitters_(args.scene) {}

    /// @param maxVertices  camera and emitter included
    void TraceCameraPath(Subpath& path, size_t maxVertices, const CameraRay& cameraRay,
                         const SampledWavelengths& lambda, Sampler& sampler, ThreadState& state) const;
    void TraceLightPath(Subpath& path, size_t maxVertices, float time, const SampledWavelengths& lambda,
                        Sampler& sampler, ThreadState& state) const;

    /// Strategy (0, t), t > 1: the path from the camera meets a light by itself.
    SampledSpectrum Emission(const Subpath& lightPath, const Subpath& cameraPath, size_t t,
                             const SampledWavelengths& lambda) const;
    /// The same where a medium glows along the edge that leaves vertex t - 2, which need not lead to a
    /// vertex. No other strategy finds that light.
    static SampledSpectrum Glow(const Subpath& cameraPath, size_t t) { return cameraPath[t - 2].glow; }
    /// Strategy (1, t), t > 1: a point of a light, drawn for the last vertex from the camera.
    SampledSpectrum DirectLight(const Subpath& lightPath, const Subpath& cameraPath, size_t t,
                                const SampledWavelengths& lambda, Sampler& sampler, ThreadState& state) const;
    /// Strategy (s, 1), s > 1: the camera is drawn for the last vertex from the light. Empty where it does
    /// not see it.
    /// @param state  its film bounds what is worth a shadow ray
    std::optional<FilmLight> CameraLight(const Subpath& lightPath, const Subpath& cameraPath, size_t s,
                                         const SampledWavelengths& lambda, Sampler& sampler,
                                         ThreadState& state) const;
    /// Strategy (s, t), s > 1, t > 1: the last vertices see each other.
    SampledSpectrum Connect(const Subpath& lightPath, const Subpath& cameraPath, size_t s, size_t t,
                            const SampledWavelengths& lambda, ThreadState& state) const;

  private:
    float EmissionWeight(const Subpath& lightPath, const Subpath& cameraPath, size_t t, const Light& light,
                         const LightSample& at) const;
    /// How a path of two or more vertices from a light begins.
    float DirectRatioOf(const Subpath& lightPath) const;

    const Scene& scene_;
    bool regularize_, roulette_;
    PathSurroundings surroundings_;
    EmitterTable emitters_;
};

}  // namespace lacquer
