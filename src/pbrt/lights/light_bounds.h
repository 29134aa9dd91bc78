// Clusters of lights: their union, what they may bring to a point, and what a cluster costs.
#pragma once

#include "pbrt/base/light.h"
#include "pbrt/core/lane_functions.h"

namespace lacquer {

/// Bounds of two clusters together. Cones of directions are joined as in [Conty Estevez and Kulla 2018,
/// algorithm 1].
LightBounds Union(const LightBounds& a, const LightBounds& b);

/// Measure of a cluster in the surface area orientation heuristic [Conty Estevez and Kulla 2018, eq. 1 and
/// 2]: power * orientation * area. A line of lights has no area, so the squared diagonal is added to it.
float ClusterCost(const LightBounds& b);

/// A cluster in the form that Importance() wants: one cache line with the links of a tree.
struct LightCluster {
    Point3 center{0};
    float radiusSquared = 0;  ///< of the bounding sphere of the box
    Vec3 axis{0, 0, 1};
    float power = 0;  ///< as a share of the power of all lights
    float cosTheta_o = 1, sinTheta_o = 0, cosTheta_e = 0;
    bool twoSided = false;

    LightCluster() = default;
    LightCluster(const LightBounds& b, float totalPower);
};

/// Estimate of what a cluster brings to a reference point, from bounds on the angles at the lights and, where
/// ref has a normal, at the surface [Conty Estevez and Kulla 2018, eq. 3]. Unit: power / area. Zero only
/// where no light of the cluster shines; otherwise positive and finite.
float Importance(const LightCluster& cluster, const LightReference& ref);

/// A few clusters side by side, each in a lane of its own.
struct LightClusterLanes {
    static constexpr int kLanes = kNumWavelengths;

    LaneFloats centerX{}, centerY{}, centerZ{}, radiusSquared{};
    LaneFloats axisX{}, axisY{}, axisZ{};
    LaneFloats power{};  ///< 0: no cluster
    LaneFloats cosTheta_o{}, sinTheta_o{}, cosTheta_e{};
    LaneInts isTwoSided{}, facesAllSides{};  ///< masks

    void Set(int lane, const LightCluster& cluster);
};

/// Importance() of all of them, but for rounding, in the time of one; 0 where there is no cluster.
LaneFloats Importance(const LightClusterLanes& clusters, const LightReference& ref);

}  // namespace lacquer
