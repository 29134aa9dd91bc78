// A few boxes, against which a ray is tested side by side.
#pragma once

#include <array>

#include "pbrt/core/check.h"
#include "pbrt/core/lane_functions.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// A ray exactly in the plane of a side may miss a box that is not flat: callers pad their boxes.
class FewBoxes {
  public:
    static constexpr int kMax = kNumWavelengths;  ///< as many as there are lanes

    int Size() const { return size_; }
    /// @param box  number Size(), of kMax at most
    void Add(const Bounds3& box) {
        LACQUER_CHECK(size_ < kMax);
        for (int axis = 0; axis < 3; ++axis) {
            min_[size_t(axis)][size_] = box.min[axis];
            max_[size_t(axis)][size_] = box.max[axis];
        }
        ++size_;
    }
    /// found(i) for each box i that the ray may meet between tMin and tMax, in their order, until one is
    /// true. Whether one was.
    template <class Found>
    bool AnyMet(const Ray& ray, float tMin, float tMax, const Found& found) const {
        if (size_ == 0) return false;
        const LaneInts met = Met(ray, tMin, tMax);
        if (!ReduceLanes(met, [](auto a, auto b) { return a | b; })) return false;
        for (int i = 0; i < size_; ++i)
            if (met[i] && found(i)) return true;
        return false;
    }

  private:
    /// -1 where a box is met, else 0.
    LaneInts Met(const Ray& ray, float tMin, float tMax) const {
        LaneFloats enter = LaneFloats{} + tMin, leave = LaneFloats{} + tMax;
        for (int axis = 0; axis < 3; ++axis) {
            const float inverse = 1 / ray.d[axis];
            const LaneFloats a = (min_[size_t(axis)] - ray.o[axis]) * inverse,
                             b = (max_[size_t(axis)] - ray.o[axis]) * inverse;
            // Where a and b are NaN (a ray within a flat box's plane), these give their second argument.
            enter = MaxLanes(MinLanes(b, a), enter);
            leave = MinLanes(MaxLanes(b, a), leave);
        }
        return enter <= leave;
    }

    std::array<LaneFloats, 3> min_{}, max_{};  ///< by axis
    int size_ = 0;
};

}  // namespace lacquer
