#include "pbrt/media/voxel_grid.h"

#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer {

FloatGrid::FloatGrid(Int3 resolution, std::span<const float> values)
    : layout_(resolution), values_(layout_.StoredElements(), 0.f) {
    LACQUER_CHECK(values.size() == size_t(resolution.x) * size_t(resolution.y) * size_t(resolution.z));
    auto from = values.begin();
    for (int k = 0; k < resolution.z; ++k)
        for (int j = 0; j < resolution.y; ++j, from += resolution.x)
            std::copy(from, from + resolution.x, values_.begin() + std::ptrdiff_t(layout_.Index(0, j, k)));
}

float FloatGrid::Maximum() const { return *std::max_element(values_.begin(), values_.end()); }

float FloatGrid::Maximum(const Bounds3& box) const {
    // Between the planes through voxel centres the field is linear in each coordinate, so it has its maximum
    // where each coordinate is on such a plane or at the end of the box.
    std::vector<float> places[3];
    for (int axis = 0; axis < 3; ++axis) {
        const float n = float(layout_.Resolution()[axis]);
        const float low = std::max(0.f, box.min[axis]), high = std::min(1.f, box.max[axis]);
        places[axis].push_back(low);
        for (float i = std::max(0.f, std::ceil(low * n - 0.5f)); i < n && (i + 0.5f) / n < high; ++i)
            places[axis].push_back((i + 0.5f) / n);
        places[axis].push_back(high);
    }
    float maximum = 0;
    for (const float z : places[2])
        for (const float y : places[1])
            for (const float x : places[0]) maximum = std::max(maximum, Lookup({x, y, z}));
    return maximum;
}

MajorantGrid BoundUnitCube(Int3 resolution, const std::function<float(const Bounds3&)>& maximum) {
    MajorantGrid grid({Point3(0), Point3(1)}, resolution);
    const Vec3 slack = 1.f / 64.f / Vec3(resolution);
    ParallelFor(resolution.z, [&](int64_t z) {
        for (int y = 0; y < resolution.y; ++y)
            for (int x = 0; x < resolution.x; ++x) {
                const Int3 cell(x, y, int(z));
                const Bounds3 bounds = grid.CellBounds(cell);
                grid.Set(cell, maximum({bounds.min - slack, bounds.max + slack}));
            }
    });
    return grid;
}

Int3 MajorantResolution(Vec3 meanFreePaths, Int3 voxels) {
    constexpr float kMax = 64;
    constexpr int kPerVoxel = 8;
    Int3 resolution;
    for (int axis = 0; axis < 3; ++axis)
        resolution[axis] = std::min(int(std::ceil(std::clamp(meanFreePaths[axis], 1.f, kMax))),
                                    kPerVoxel * std::min(voxels[axis], 64));
    return resolution;
}

}  // namespace lacquer
