#include "pbrt/base/medium.h"

namespace lacquer {

MediumPhase::MediumPhase(std::unique_ptr<const PhaseModel> model, const Transform& renderFromMedium)
    : model_(std::move(model)),
      frame_{renderFromMedium.Vector({1, 0, 0}), renderFromMedium.Vector({0, 1, 0}),
             renderFromMedium.Vector({0, 0, 1})},
      arena_(std::make_unique<Arena>()),
      fixed_(model_->Make({frame_, SampledWavelengths()}, *arena_)),
      isChromatic_(model_->IsChromatic()),
      isDirectional_(fixed_->HasDirectionalExtinction()) {}

namespace {

/// Largest t that a walk can count with: crossings further away might not be finite.
constexpr float kFarthest = 1e30f;

/// Cell of the coordinate `x` among `count` cells of the given size from `low` on; the nearest one if it is
/// outside.
int CellOf(float x, float low, float size, int count) {
    const float position = (x - low) / size;
    return position > 0 ? int(std::min(position, float(count - 1))) : 0;
}

}  // namespace

Bounds3 MajorantGrid::CellBounds(Int3 cell) const {
    const Vec3 size = bounds_.Diagonal() / Vec3(resolution_);
    return {bounds_.min + Vec3(cell) * size, bounds_.min + Vec3(cell + Int3(1)) * size};
}

MajorantWalk::MajorantWalk(const MajorantGrid& grid, const Ray& ray, float tMax, SampledSpectrum sigma)
    : sigma_(sigma), grid_(&grid) {
    const Bounds3& box = grid.Bounds();
    const Vec3 cellSize = box.Diagonal() / Vec3(grid.Resolution());
    float entry = 0, exit = std::min(tMax, kFarthest);
    for (int axis = 0; axis < 3; ++axis) {
        if (!(cellSize[axis] > 0)) return;
        if (ray.d[axis] == 0) {
            if (!(ray.o[axis] >= box.min[axis] && ray.o[axis] <= box.max[axis])) return;
            continue;
        }
        const float low = (box.min[axis] - ray.o[axis]) / ray.d[axis];
        const float high = (box.max[axis] - ray.o[axis]) / ray.d[axis];
        entry = std::max(entry, std::min(low, high));
        exit = std::min(exit, std::max(low, high));
    }
    if (!(entry < exit)) return;
    t_ = entry;
    tMax_ = exit;
    const Point3 start = ray(t_);
    for (int axis = 0; axis < 3; ++axis) {
        cell_[axis] = CellOf(start[axis], box.min[axis], cellSize[axis], grid.Resolution()[axis]);
        step_[axis] = ray.d[axis] < 0 ? -1 : 1;
        planeDistance_[axis] = cellSize[axis] / ray.d[axis];
        firstPlane_[axis] = (box.min[axis] - ray.o[axis]) / ray.d[axis];
        nextCrossing_[axis] = Crossing(axis);
    }
}

/// t at the wall through which the ray leaves its cell along `axis`, from the cell's index rather than by
/// adding up: errors do not grow with the number of cells.
float MajorantWalk::Crossing(int axis) const {
    if (!(std::abs(planeDistance_[axis]) < kFarthest)) return Infinity;  // (almost) parallel to the walls
    return std::fma(float(cell_[axis] + (step_[axis] > 0)), planeDistance_[axis], firstPlane_[axis]);
}

bool MajorantWalk::Next(MajorantSegment* segment) {
    if (single_) {
        *segment = {t_, tMax_, sigma_};
        single_ = false;
        t_ = tMax_;
        return true;
    }
    while (t_ < tMax_) {
        const int axis = nextCrossing_.x < nextCrossing_.y ? (nextCrossing_.x < nextCrossing_.z ? 0 : 2)
                                                           : (nextCrossing_.y < nextCrossing_.z ? 1 : 2);
        const float bound = grid_->At(cell_), from = t_;
        cell_[axis] += step_[axis];
        const bool leaves = cell_[axis] < 0 || cell_[axis] >= grid_->Resolution()[axis];
        // The last cell of a row reaches to the end of the box, whatever its wall rounds to.
        t_ = leaves ? tMax_ : std::clamp(nextCrossing_[axis], from, tMax_);
        nextCrossing_[axis] = Crossing(axis);
        if (bound > 0 && t_ > from) {
            *segment = {from, t_, sigma_ * bound};
            return true;
        }
    }
    return false;
}

}  // namespace lacquer
