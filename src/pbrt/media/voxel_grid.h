// Values on a regular grid of voxels in the unit cube, and bounds of what lies between them.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "pbrt/base/medium.h"

namespace lacquer {

/// Where voxels lie: voxel (i, j, k) of nx x ny x nz has its centre at ((i + 1/2)/nx, ...) of the unit cube,
/// in files x runs fastest. In memory, a shell of zeros surrounds the grid, so that no look-up asks where the
/// grid ends.
class VoxelLayout {
  public:
    /// @param resolution  at least 1 along each axis
    explicit VoxelLayout(Int3 resolution)
        : resolution_(resolution),
          size_(resolution),
          rowStride_(size_t(resolution.x) + 2),
          sliceStride_(rowStride_ * (size_t(resolution.y) + 2)) {}

    Int3 Resolution() const { return resolution_; }
    /// Elements in memory, the shell included.
    size_t StoredElements() const { return sliceStride_ * (size_t(resolution_.z) + 2); }
    /// Place in memory of voxel (i, j, k), from -1 (the shell) to the resolution (the shell again).
    size_t Index(int i, int j, int k) const {
        return size_t(k + 1) * sliceStride_ + size_t(j + 1) * rowStride_ + size_t(i + 1);
    }

    /// The eight voxels around a point.
    struct Corners {
        size_t first;  ///< place in memory of the one with the smallest coordinates
        Vec3 w;        ///< weights of those with the larger coordinate, for each axis
    };
    /// @param u  in the unit cube
    Corners CornersOf(Point3 u) const {
        // From -1/2 to n - 1/2 voxels; the shell adds 1. Truncation rounds down: all is positive.
        const Vec3 q = u * size_ + 0.5f;
        const int i = int(q.x), j = int(q.y), k = int(q.z);
        return {size_t(k) * sliceStride_ + size_t(j) * rowStride_ + size_t(i),
                q - Vec3(float(i), float(j), float(k))};
    }
    size_t RowStride() const { return rowStride_; }
    size_t SliceStride() const { return sliceStride_; }

  private:
    Int3 resolution_;
    Vec3 size_;
    size_t rowStride_, sliceStride_;
};

inline bool InUnitCube(Point3 u) {
    return u.x >= 0 && u.x <= 1 && u.y >= 0 && u.y <= 1 && u.z >= 0 && u.z <= 1;
}

/// One float per voxel: linear between the centres, zero beyond the shell's, so half at the faces of the
/// cube.
class FloatGrid {
  public:
    /// @param values  one per voxel, x fastest
    FloatGrid(Int3 resolution, std::span<const float> values);

    /// @param u  in the unit cube. Inline: the inner loop of rendering volumes.
    float Lookup(Point3 u) const {
        const VoxelLayout::Corners c = layout_.CornersOf(u);
        const float* v = values_.data() + c.first;
        const size_t row = layout_.RowStride(), slice = layout_.SliceStride();
        const auto along = [&](const float* p) { return p[0] + c.w.x * (p[1] - p[0]); };
        const float a = along(v), b = along(v + row), d = along(v + slice), e = along(v + slice + row);
        const float near = a + c.w.y * (b - a), far = d + c.w.y * (e - d);
        return near + c.w.z * (far - near);
    }
    /// The largest value of the field inside a box, exactly but for rounding. Cost: some look-ups per voxel.
    float Maximum(const Bounds3& box) const;
    /// The largest value of a voxel.
    float Maximum() const;
    Int3 Resolution() const { return layout_.Resolution(); }
    size_t MemoryBytes() const { return values_.size() * sizeof(float); }

  private:
    VoxelLayout layout_;
    std::vector<float> values_;
};

/// Bounds of a field over the unit cube. @param maximum  the largest value of the field in a box; called by
/// several threads. The boxes are larger than the cells by 1/64 on each side, for the rounding of points far
/// from the origin.
MajorantGrid BoundUnitCube(Int3 resolution, const std::function<float(const Bounds3&)>& maximum);

/// Cells that a medium's bounds want. Short cells follow the density, and each costs a step: cells of a mean
/// free path where the medium is densest are about the best.
/// @param meanFreePaths  optical thickness of the medium's box along each axis, at its densest
/// @param voxels  of the grid: cells much finer than those are of no use
Int3 MajorantResolution(Vec3 meanFreePaths, Int3 voxels);

}  // namespace lacquer
