// Paths from the camera and from the lights, vertex by vertex, to be connected.
#pragma once

#include <array>

#include "pbrt/base/film.h"
#include "pbrt/integrators/emitters.h"
#include "pbrt/integrators/shadow_ray.h"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {

/// Factor of f for importance where shading normals are not the geometric ones: what makes a path from a
/// light carry what the same path from the camera does [Veach 1997, sec. 5.3.2, eq. 5.19].
/// @param wLight  toward the light    @param wCamera  toward the camera; both in rendering space
inline float ShadingNormalFactor(const SurfaceInteraction& si, Vec3 wLight, Vec3 wCamera) {
    const float below = AbsDot(wLight, si.n) * AbsDot(wCamera, si.shading.n);
    return below > 0 ? AbsDot(wLight, si.shading.n) * AbsDot(wCamera, si.n) / below : 0.f;
}

/// Densities of scattering at a vertex [1/sr]: of going on, and of coming back the same way.
struct ScatterDensities {
    float forward = 0, reverse = 0;
};

/// A point of a path. Densities are over area [1/m^2]; those of points at infinity over solid angle [1/sr].
/// Densities of flights through media are not in them: weights of strategies need quotients only, and what
/// differs is the edge that connects, whose flight is not drawn. Its knownT is what they know of that.
struct PathVertex {
    enum class Kind { Camera, Light, Surface, Medium };

    Kind kind = Kind::Surface;
    /// Throughput up to here, this vertex's own scattering excluded: importance from the camera, or flux from
    /// a light, over the density with which all was drawn at the first wavelength. Of lights: 1 over the
    /// density of light and position.
    SampledSpectrum beta;
    /// Density over that at the first wavelength, for OverMeanPdf().
    SampledSpectrum pdfs{1.f};
    bool isAlone = false;   ///< it carries the first wavelength alone: something dispersed the others
    SurfaceInteraction si;  ///< where it is; n is zero where there is no surface
    Bsdf bsdf;              ///< of surfaces; its wo points back along the path
    const PhaseFunction* phase = nullptr;  ///< of the Medium kind
    const Medium* medium = nullptr;        ///< that the path has come through, or that it is in; null: vacuum
    const Light* light = nullptr;          ///< of the Light kind
    bool isInfinite = false;  ///< of the Light kind: infinitely far away, in the direction `toLight`
    Vec3 toLight{0, 0, 1};
    float pdfPlane = 0;    ///< where isInfinite: density of its rays over a plane across `toLight` [1/m^2]
    bool isDelta = false;  ///< scattered by a specular lobe: no other direction is possible
    float pdfForward = 0;  ///< of drawing it from its predecessor
    float pdfReverse = 0;  ///< of drawing it from its successor
    float knownT = 1;      ///< ShadowRay::knownT of the edge from its predecessor
    /// Light of media along the edge that leaves this vertex of a path from the camera, as it counts there.
    SampledSpectrum glow{0.f};

    /// The medium on the side of a direction.
    const Medium* MediumToward(Vec3 w) const { return si.MediumToward(w, medium); }
    /// Unit direction to another vertex.
    Vec3 DirectionTo(const PathVertex& v) const {
        return v.isInfinite ? v.toLight : Normalize(v.si.p - si.p);
    }
    /// Density over area at `to` from one over solid angle here, which points at infinity have no use for.
    float ToArea(float pdfDirection, const PathVertex& to) const {
        if (to.isInfinite) return pdfDirection;
        const bool isSurface = to.si.n != Normal3(0);
        if (isInfinite) return isSurface ? pdfPlane * AbsDot(to.si.n, toLight) : pdfPlane;
        const Vec3 d = to.si.p - si.p;
        const float distanceSquared = LengthSquared(d);
        if (!(distanceSquared > 0)) return 0;
        const float cosine = isSurface ? AbsDot(to.si.n, d) / std::sqrt(distanceSquared) : 1.f;
        return pdfDirection * cosine / distanceSquared;
    }
};

/// The vertices of one path, in an arena.
class Subpath {
  public:
    /// Longer paths than this are cut: roulette leaves none, and the work grows with the square.
    static constexpr size_t kMax = 1024;

    explicit Subpath(Arena& arena) : arena_(arena) {}
    size_t Size() const { return size_; }
    PathVertex& operator[](size_t i) { return *vertices_[i]; }
    const PathVertex& operator[](size_t i) const { return *vertices_[i]; }
    /// A fresh vertex after the last one, which is of the path once it is kept. References to vertices stay
    /// valid.
    PathVertex& Next() {
        if (size_ == made_)
            vertices_[made_++] = arena_.New<PathVertex>();
        else
            *vertices_[size_] = PathVertex();
        return *vertices_[size_];
    }
    void Keep() { ++size_; }
    void Add(const PathVertex& v) {
        Next() = v;
        Keep();
    }

  private:
    Arena& arena_;
    size_t size_ = 0, made_ = 0;
    std::array<PathVertex*, kMax> vertices_;  ///< the first made_ are set
};

/// True if a path may be connected at this vertex.
inline bool IsConnectible(const PathVertex& v) {
    return v.kind == PathVertex::Kind::Medium ||
           (v.kind == PathVertex::Kind::Surface && IsNonSpecular(v.bsdf.Flags()));
}

/// What a vertex scatters from the end of its path toward w: f has the cosine of surfaces, and for importance
/// their ShadingNormalFactor(). Densities are those that cost nothing more; of phase functions, means over
/// the wavelengths.
BxDFValue ScatteringAt(const PathVertex& v, Vec3 w, TransportMode mode, ThreadState& state);

/// The densities of scattering at a vertex toward `w`, in the direction in which `mode` goes on. Where a
/// model says only `forward`, or neither, it is asked for both, with numbers of their own: whichever way a
/// path is found, its weights then come from the same, possibly random, estimates, and sum to one in
/// expectation.
/// @param known  what ScatteringAt() or Sample() said; 0: nothing
ScatterDensities DensitiesAt(const PathVertex& v, Vec3 w, TransportMode mode, ScatterDensities known,
                             ThreadState& state);
inline ScatterDensities DensitiesAt(const PathVertex& v, Vec3 w, TransportMode mode, const BxDFValue& value,
                                    ThreadState& state) {
    return DensitiesAt(v, w, mode, ScatterDensities{value.pdf, value.pdfReverse}, state);
}

/// Where a subpath goes on from its last vertex.
struct SubpathEdge {
    Ray ray;
    SampledSpectrum beta{1.f};       ///< at the next vertex
    float pdfDirection = 0;          ///< of the ray [1/sr]
    const Medium* medium = nullptr;  ///< around the ray; null: vacuum
    SpectralPdfs pdfs{};
    float knownT = 1;               ///< so far
    bool isAlone = false;           ///< as PathVertex has it
    SampledWavelengths followed{};  ///< what surfaces are asked for: those of the sample, until it is alone

    /// For Russian roulette.
    float Carried() const {
        return isAlone ? beta[0] / pdfs.scattering[0] : beta.MaxComponent() / pdfs.scattering.Average();
    }
};

/// The first edge of a path from the camera, but for its density.
SubpathEdge CameraEdge(const Scene& scene, const CameraRay& cameraRay, const SampledWavelengths& lambda);

/// What becomes of an edge.
enum class Arrival {
    AtVertex,  ///< something scatters
    Passes,    ///< it goes on behind a surface of the interface material
    Escapes,   ///< it leaves the scene
    Ends       ///< it is absorbed, or the path may not get another vertex
};
/// Follows an edge to what it meets next.
/// @param from    the vertex that it leaves: gets the light of media on the way; null: nobody asks
/// @param v       where it arrives AtVertex; densities are left as they are
/// @param lambda  those of the sample: they stay, whatever disperses. Weights of strategies are functions of
///                the path and of them.
Arrival FollowEdge(SubpathEdge* edge, TracedPath* traced, PathVertex* from, PathVertex* v,
                   const SampledWavelengths& lambda, Sampler& sampler, ThreadState& state);

/// What the camera ray meets is for the auxiliary outputs, where no path follows it.
void RecordFirstHit(const PathSurroundings& surroundings, const CameraRay& cameraRay,
                    const SampledWavelengths& lambda, Sampler& sampler, ThreadState& state);

/// Draws where a path from a light goes on from v, and sets v->isDelta. False: it ends. Densities, which
/// nobody asks for who does not connect, are not set.
bool ScatterLight(PathVertex* v, SubpathEdge* edge, Sampler& sampler, ThreadState& state);

/// What all subpaths of one kind have in common.
struct SubpathTracer {
    TransportMode mode;
    size_t maxVertices;  ///< of a whole path
    bool regularize = false;
    bool roulette = true;  ///< it ends at random where it carries little

    /// Lets `path`, whose only vertex is a camera or a light, go on along `edge`. Camera paths that leave the
    /// scene end with a Light vertex at infinity, whose `light` is null.
    /// @param traced  the same path, from its beginning
    void Extend(Subpath& path, TracedPath traced, SubpathEdge edge, const SampledWavelengths& lambda,
                Sampler& sampler, ThreadState& state) const;
};

/// The first vertex of a path from a light, and how it goes on.
struct LightStart {
    PathVertex vertex;
    SubpathEdge edge;
};
/// Draws a light and a ray from it. Empty if the draw fails.
std::optional<LightStart> StartAtLight(const EmitterTable& emitters, float time,
                                       const SampledWavelengths& lambda, Sampler& sampler);

/// False where the light at infinity that a path began at does not reach its next vertex (it missed a
/// portal).
bool IsLit(const PathVertex& start, const SurfaceInteraction& si, const SampledWavelengths& lambda);

/// Why paths cannot begin at all of a scene's lights, as a sentence without its full stop; empty: they can.
/// Where a medium has no walls, how much of the light arrives that comes from infinitely far is a matter of
/// definition, and only light samples define it.
std::string WhyNoLightPaths(const Scene& scene);

/// Errors: SceneError at the integrator unless the camera knows its importance.
void RequireImportance(const IntegratorArgs& args);

/// Light of a vertex of a light path that reaches the camera, but for the path's weight. Empty if it does
/// not.
struct CameraArrival {
    CameraConnection camera;
    SampledSpectrum L;
    BxDFValue scattering;  ///< as ScatteringAt() has it; none of lights
    float knownT = 1;      ///< ShadowRay::knownT of the way to the camera
};
/// @param state  its film bounds what is worth a shadow ray
std::optional<CameraArrival> ConnectToCamera(const Scene& scene, const PathVertex& v, Point2 uLens,
                                             const SampledWavelengths& lambda, ThreadState& state);

}  // namespace lacquer
