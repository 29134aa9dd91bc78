// Values on a sparse grid of voxels with integer coordinates.
#pragma once

#include <span>
#include <vector>

#include "pbrt/base/medium.h"

namespace lacquer {

/// One float per voxel of a box, in blocks of 8 x 8 x 8; voxel (i, j, k) lies at the point (i, j, k), between
/// them the field is linear. Blocks that are constant, their neighbours' first voxels included, share their
/// memory with all others of the value. Each block keeps the first voxels of its upper neighbours: a look-up
/// stays within one block.
class SparseGrid {
  public:
    static constexpr int kBlock = 8;

    /// Values of 8 x 8 x 8 voxels, z fastest: an array, or the same for all of them.
    struct Source {
        const float* values = nullptr;
        float constant = 0;
        float At(int x, int y, int z) const {
            return values ? values[(x * kBlock + y) * kBlock + z] : constant;
        }
    };

    /// @param firstBlock  its first voxel is at 8 firstBlock
    /// @param numBlocks   along each axis, at least 1
    /// @param sources     of the blocks from firstBlock up to firstBlock + numBlocks, one more than
    ///                    there are on each axis; z fastest
    /// @param outside     the field outside of all blocks
    SparseGrid(Int3 firstBlock, Int3 numBlocks, std::span<const Source> sources, float outside);

    /// The field at p. The inner loop of rendering volumes.
    float Lookup(Point3 p) const {
        const Vec3 q = p - origin_;
        if (!(q.x >= 0 && q.y >= 0 && q.z >= 0 && q.x < size_.x && q.y < size_.y && q.z < size_.z))
            return outside_;
        const int i = int(q.x), j = int(q.y), k = int(q.z);
        const float* v = &values_[BrickOf({i >> 3, j >> 3, k >> 3}) * kBrickValues +
                                  size_t(((i & 7) * kSide + (j & 7)) * kSide + (k & 7))];
        const float x = q.x - float(i), y = q.y - float(j), z = q.z - float(k);
        const auto along = [z](const float* u) { return u[0] + z * (u[1] - u[0]); };
        const float a = along(v), b = along(v + kSide), c = along(v + kSide * kSide),
                    d = along(v + kSide * kSide + kSide);
        const float near = a + y * (b - a), far = c + y * (d - c);
        return near + x * (far - near);
    }
    /// Largest value of the field in the closed cube of a block, counted from 0.
    float BlockMaximum(Int3 block) const { return maxima_[BrickOf(block)]; }
    float Maximum() const;
    Int3 FirstBlock() const { return firstBlock_; }
    Int3 NumBlocks() const { return numBlocks_; }
    size_t MemoryBytes() const {
        return (values_.size() + maxima_.size()) * sizeof(float) + bricks_.size() * sizeof(uint32_t);
    }

  private:
    static constexpr int kSide = kBlock + 1;
    static constexpr size_t kBrickValues = size_t(kSide) * kSide * kSide;

    size_t BrickOf(Int3 block) const {
        return bricks_[(size_t(block.x) * size_t(numBlocks_.y) + size_t(block.y)) * size_t(numBlocks_.z) +
                       size_t(block.z)];
    }
    uint32_t AddBrick(const std::vector<float>& values);

    Int3 firstBlock_, numBlocks_;
    Vec3 origin_, size_;
    float outside_;
    std::vector<uint32_t> bricks_;  ///< of each block
    std::vector<float> values_;     ///< of each brick: 9 x 9 x 9
    std::vector<float> maxima_;     ///< of each brick
};

/// Bounds of the field in cubes of 8, 16, 32 ... voxels, as few as `most` along each axis.
MajorantGrid BoundBlocks(const SparseGrid& grid, int most);

}  // namespace lacquer
