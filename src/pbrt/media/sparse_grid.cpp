#include "pbrt/media/sparse_grid.h"

#include <map>

namespace lacquer {

SparseGrid::SparseGrid(Int3 firstBlock, Int3 numBlocks, std::span<const Source> sources, float outside)
    : firstBlock_(firstBlock),
      numBlocks_(numBlocks),
      origin_(kBlock * firstBlock),
      size_(kBlock * numBlocks),
      outside_(outside) {
    const auto source = [&](int x, int y, int z) {
        return sources[(size_t(x) * size_t(numBlocks.y + 1) + size_t(y)) * size_t(numBlocks.z + 1) +
                       size_t(z)];
    };
    bricks_.reserve(size_t(numBlocks.x) * size_t(numBlocks.y) * size_t(numBlocks.z));
    std::map<float, uint32_t> constants;  // bricks of one value
    std::vector<float> brick(kBrickValues);
    for (int x = 0; x < numBlocks.x; ++x)
        for (int y = 0; y < numBlocks.y; ++y)
            for (int z = 0; z < numBlocks.z; ++z) {
                Source around[2][2][2];
                bool isConstant = true;
                for (int i = 0; i < 8; ++i) {
                    const int dx = i >> 2, dy = i >> 1 & 1, dz = i & 1;
                    Source& s = around[dx][dy][dz];
                    s = source(x + dx, y + dy, z + dz);
                    isConstant = isConstant && !s.values && s.constant == around[0][0][0].constant;
                }
                const float constant = around[0][0][0].constant;
                if (isConstant && constants.contains(constant)) {
                    bricks_.push_back(constants[constant]);
                    continue;
                }
                for (int i = 0; i < kSide; ++i)
                    for (int j = 0; j < kSide; ++j)
                        for (int k = 0; k < kSide; ++k)
                            brick[size_t((i * kSide + j) * kSide + k)] =
                                around[i / kBlock][j / kBlock][k / kBlock].At(i % kBlock, j % kBlock,
                                                                              k % kBlock);
                bricks_.push_back(AddBrick(brick));
                if (isConstant) constants[constant] = bricks_.back();
            }
}

uint32_t SparseGrid::AddBrick(const std::vector<float>& values) {
    values_.insert(values_.end(), values.begin(), values.end());
    maxima_.push_back(*std::max_element(values.begin(), values.end()));
    return uint32_t(maxima_.size() - 1);
}

float SparseGrid::Maximum() const { return *std::max_element(maxima_.begin(), maxima_.end()); }

MajorantGrid BoundBlocks(const SparseGrid& grid, int most) {
    const Int3 blocks = grid.NumBlocks();
    int perCell = 1;
    while (std::max({blocks.x, blocks.y, blocks.z}) > most * perCell) perCell *= 2;
    const Int3 cells = (blocks + Int3(perCell - 1)) / perCell;
    const Point3 origin(SparseGrid::kBlock * grid.FirstBlock());
    MajorantGrid bounds({origin, origin + Vec3(SparseGrid::kBlock * perCell * cells)}, cells);
    // A point that rounding puts behind a wall of its cell exceeds the bound by rounding only: the field is
    // continuous.
    for (int x = 0; x < blocks.x; ++x)
        for (int y = 0; y < blocks.y; ++y)
            for (int z = 0; z < blocks.z; ++z) {
                const Int3 cell = Int3(x, y, z) / perCell;
                bounds.Set(cell, std::max(bounds.At(cell), grid.BlockMaximum({x, y, z})));
            }
    return bounds;
}

}  // namespace lacquer
