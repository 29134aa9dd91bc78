#include "pbrt/base/medium.h"

namespace lacquer {

Bounds3 MajorantGrid::CellBounds(Int3 cell) const {
    const Vec3 size = bounds_.Diagonal() / Vec3(resolution_);
    return {bounds_.min + Vec3(cell) * size, bounds_.min + Vec3(cell + Int3(1)) * size};
}

MajorantWalk::MajorantWalk(const MajorantGrid& grid, const Ray& ray, float tMax, SampledSpectrum sigma)
    : sigma_(sigma), grid_(&grid) {
    const Bounds3& box = grid.Bounds();
    t_ = 0;
    tMax_ = tMax;
    for (int axis = 0; axis < 3; ++axis) {
        if (ray.d[axis] == 0) {
            if (ray.o[axis] < box.min[axis] || ray.o[axis] > box.max[axis]) tMax_ = -1;
            continue;
        }
        const float a = (box.min[axis] - ray.o[axis]) / ray.d[axis];
        const float b = (box.max[axis] - ray.o[axis]) / ray.d[axis];
        t_ = std::max(t_, std::min(a, b));
        tMax_ = std::min(tMax_, std::max(a, b));
    }
    if (!(t_ < tMax_)) {
        tMax_ = -1;
        return;
    }
    const Int3 resolution = grid.Resolution();
    const Vec3 cellSize = box.Diagonal() / Vec3(resolution);
    const Point3 start = ray.o + t_ * ray.d;
    for (int axis = 0; axis < 3; ++axis) {
        const float position = (start[axis] - box.min[axis]) / cellSize[axis];
        cell_[axis] = std::clamp(int(std::floor(position)), 0, resolution[axis] - 1);
        step_[axis] = ray.d[axis] < 0 ? -1 : 1;
        if (ray.d[axis] == 0) {
            nextCrossing_[axis] = deltaT_[axis] = Infinity;
            continue;
        }
        const float plane = box.min[axis] + float(cell_[axis] + (step_[axis] > 0)) * cellSize[axis];
        nextCrossing_[axis] = (plane - ray.o[axis]) / ray.d[axis];
        deltaT_[axis] = cellSize[axis] / std::abs(ray.d[axis]);
    }
}

bool MajorantWalk::Next(MajorantSegment* segment) {
    if (single_) {
        *segment = {t_, tMax_, sigma_};
        single_ = false;
        tMax_ = -1;
        return true;
    }
    while (t_ < tMax_) {
        const int axis = nextCrossing_.x < nextCrossing_.y ? (nextCrossing_.x < nextCrossing_.z ? 0 : 2)
                                                           : (nextCrossing_.y < nextCrossing_.z ? 1 : 2);
        const float bound = grid_->At(cell_);
        const float from = t_;
        // The last cell of a row reaches to the end of the box, whatever the crossings round to.
        t_ = std::clamp(nextCrossing_[axis], from, tMax_);
        cell_[axis] += step_[axis];
        nextCrossing_[axis] += deltaT_[axis];
        const bool left = cell_[axis] < 0 || cell_[axis] >= grid_->Resolution()[axis];
        const float to = left ? tMax_ : t_;
        if (left) t_ = tMax_;
        if (bound > 0 && to > from) {
            *segment = {from, to, sigma_ * bound};
            return true;
        }
    }
    return false;
}

}  // namespace lacquer
