// A camera's lens as a row of spherical surfaces: reading it, focusing it, and tracing rays through it.
// Lengths are millimetres. The film lies in the plane z = 0, the axis is +z towards the scene.
#pragma once

#include <string>
#include <vector>

#include "pbrt/core/error.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// One surface as a lens file has it.
struct LensSurface {
    float radius = 0;     ///< of curvature [mm], positive if the centre lies on the film's side; 0: a stop
    float thickness = 0;  ///< distance along the axis to the next surface, or to the film [mm]
    float eta = 1;        ///< index of refraction behind the surface, on the film's side
    float diameter = 0;   ///< of what lets light through [mm]
    int line = 0;         ///< in the file
};

/// Reads a lens file: surfaces from the scene to the film, four numbers each (radius, thickness, index with 0
/// meaning air, diameter); '#' starts a comment.
/// @param loc  of the parameter that names the file
/// Errors: FileError at `loc` if the file cannot be read, SceneError in the file for what is not a lens.
std::vector<LensSurface> ReadLensFile(const std::string& path, const FileLoc& loc);

/// Four rays that are traced together.
struct LensRays {
    using Lanes = float __attribute__((vector_size(16)));
    using Mask = int __attribute__((vector_size(16)));  ///< -1: yes, 0: no
    static constexpr int kCount = 4;

    Lanes ox, oy, oz;        ///< origins [mm]
    Lanes dx, dy, dz;        ///< unit directions
    Lanes stopRadius2{};     ///< after tracing: largest squared distance from the axis at a stop, in radii
    Lanes stopX{}, stopY{};  ///< after tracing: where the ray met the last stop, in its radii
};

/// What the paraxial rays of a lens obey.
struct CardinalPoints {
    float focalLength = 0;     ///< [mm]; not positive or not finite: the lens does not make an image
    float frontPrincipal = 0;  ///< z of the principal plane for objects in the scene [mm]
    float rearPrincipal = 0;   ///< z of the principal plane for images on the film [mm]
};

/// A rotationally symmetric lens of spherical surfaces without dispersion. Immutable after Focus().
class LensSystem {
  public:
    /// @param surfaces        from the scene to the film, at least one
    /// @param stopDiameter    of the stops, at most what they say themselves [mm]
    LensSystem(const std::vector<LensSurface>& surfaces, float stopDiameter);

    /// Moves the lens such that objects `distance` [mm] before the film are sharp, for paraxial rays. False,
    /// and nothing is moved, if there is no such place (`distance` is less than NearestFocus()).
    bool Focus(float distance);
    /// Distance from the film of the nearest object of which there is a sharp image [mm].
    float NearestFocus() const;

    CardinalPoints Cardinals() const;
    /// z of the vertex of the surface next to the film, and of the one next to the scene [mm].
    float RearZ() const { return surfaces_.front().z; }
    float FrontZ() const { return surfaces_.back().z; }
    float RearRadius() const { return std::sqrt(surfaces_.front().radius2); }
    /// Depth of the rim of the surface next to the film over its vertex, towards the scene [mm].
    float RearSag() const;

    enum class Stops { Block, Ignore };
    /// Takes rays from the film to the scene: positions and directions become those where they leave the last
    /// surface. @return the lanes that get through. A surface stops what meets it outside of its diameter,
    /// for the first `blocked` lanes; lanes behind them are only lost where they miss a sphere or are totally
    /// reflected. Stops measure in LensRays::stopRadius2 and, unless ignored, block. Tracing ends as soon
    /// as none of the first `blocked` lanes is left. Formulas: [Spencer and Murty 1962] sec. B and C for
    /// spheres.
    LensRays::Mask Trace(LensRays* rays, int blocked, Stops stops) const;

  private:
    struct Surface {
        float curvature;  ///< 1/radius [1/mm], positive if the centre lies towards the scene; 0: a stop
        float z;          ///< of the vertex [mm]
        float radius2;    ///< square of half the diameter [mm^2]
        float invRadius;  ///< of that half [1/mm]
        float etaRatio;   ///< index before over index behind, for a ray towards the scene
    };
    std::vector<Surface> surfaces_;  ///< from the film to the scene
};

/// The region of the plane z = RearZ() through which light reaches points at one distance from the axis.
/// Boxes for rings of the film, each holding all points that let light through to any point of its ring that
/// lies on the +x axis.
class ExitPupils {
  public:
    struct Box {
        Point2 min{0}, max{0};
        float Area() const { return (max.x - min.x) * (max.y - min.y); }
    };
    ExitPupils() = default;
    /// @param filmRadius  half of the film's diagonal [mm]
    /// @param stopScale   radius of what lets light through at a stop, in units of the stop's own
    /// Cost: about a million rays, in parallel.
    ExitPupils(const LensSystem& lens, float filmRadius, float stopScale);
    /// The box for points at `radius` [mm] from the axis.
    const Box& At(float radius) const {
        return boxes_[size_t(std::min(int(radius * perRadius_), kRings - 1))];
    }

    static constexpr int kRings = 64;

  private:
    std::vector<Box> boxes_;
    float perRadius_ = 0;
};

}  // namespace lacquer
