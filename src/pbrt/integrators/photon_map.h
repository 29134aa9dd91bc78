// Photons where surfaces scattered them, to be found by the points of a camera path that are close to them.
#pragma once

#include <span>
#include <vector>

#include "pbrt/core/sampled_spectrum.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// Flux that arrives at a surface.
struct Photon {
    /// Of one of all the paths from the lights, times cosines of the shading over the geometric normal: what
    /// f is multiplied by [W/nm].
    SampledSpectrum flux;
    Point3 p{0};
    Vec3 wi{0};  ///< where it came from, unit, away from the surface
    /// No path from the camera that misses a vertex before this one finds the light that it came from: a
    /// light without extent, and specular vertices alone.
    bool isHidden = false;
};

/// The photons of one iteration in a hashed grid [Teschner et al. 2003]. Immutable.
///
/// Photons stand in it in an order that depends on their own order alone, so that sums over them have the
/// same bits however many threads made it.
class PhotonMap {
  public:
    PhotonMap() = default;
    /// @param blocks  photons in their order; taken apart to save memory
    /// @param radius  of later look-ups [m]
    PhotonMap(std::vector<std::vector<Photon>> blocks, float radius);

    float Radius() const { return radius_; }
    std::span<const Photon> Photons() const { return photons_; }

    /// visit(photon) for those closer to p than the radius.
    template <class Visit>
    void ForEachNear(Point3 p, const Visit& visit) const {
        if (photons_.empty()) return;
        // Cells are as wide as the sphere: it reaches into two of them along each axis.
        const Cell first = CellOf(p - Vec3(radius_)), last = CellOf(p + Vec3(radius_));
        for (int z = first.z; z <= last.z; ++z)
            for (int y = first.y; y <= last.y; ++y)
                for (int x = first.x; x <= last.x; ++x) VisitCell({x, y, z}, p, visit);
    }

  private:
    using Cell = Int3;
    Cell CellOf(Point3 p) const {
        // Far cells are one: no photon is lost, and look-ups there are slow.
        constexpr float kLimit = 1 << 29;
        return Cell(glm::clamp(glm::floor(p * inverseWidth_), Vec3(-kLimit), Vec3(kLimit)));
    }
    size_t BucketOf(Cell cell) const {
        const auto x = uint32_t(cell.x), y = uint32_t(cell.y), z = uint32_t(cell.z);
        uint32_t hash = x * 73856093u ^ y * 19349663u ^ z * 83492791u;
        hash ^= hash >> 15;
        return hash & (starts_.size() - 2);
    }
    template <class Visit>
    void VisitCell(Cell cell, Point3 p, const Visit& visit) const {
        const size_t bucket = BucketOf(cell);
        for (size_t i = starts_[bucket]; i < starts_[bucket + 1]; ++i) {
            const Photon& photon = photons_[i];
            // Cells may share a bucket: each photon is visited in its own cell only.
            if (LengthSquared(photon.p - p) < Sqr(radius_) && CellOf(photon.p) == cell) visit(photon);
        }
    }

    float radius_ = 0, inverseWidth_ = 0;
    std::vector<Photon> photons_;   ///< by bucket
    std::vector<uint32_t> starts_;  ///< of the buckets, whose number is a power of two; and the end
};

}  // namespace lacquer
