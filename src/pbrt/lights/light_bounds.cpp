#include "pbrt/lights/light_bounds.h"

#include <limits>
#include <tuple>

namespace lacquer {

namespace {

/// The least share of a cosine that a sample gets: a light at grazing angle stays possible, however its bound
/// rounds.
constexpr float kCosineMargin = 1e-4f;
/// The same for the limit beyond which a cluster emits nothing: unions of narrow cones lose 3e-4 radians
/// each.
constexpr float kLimitMargin = 5e-3f;

/// Of importances that are not 0.
constexpr float kSmallest = std::numeric_limits<float>::min(), kLargest = 1e37f;

/// cos(max(0, a - b)) for angles in [0, pi] given by their sines and cosines. Of floats or of lanes.
template <class Value>
Value CosDifference(Value sinA, Value cosA, Value sinB, Value cosB) {
    return cosA > cosB ? Value{} + 1.f : cosA * cosB + sinA * sinB;
}
/// sin(max(0, a - b)).
template <class Value>
Value SinDifference(Value sinA, Value cosA, Value sinB, Value cosB) {
    return cosA > cosB ? Value{} : sinA * cosB - cosA * sinB;
}
LaneFloats SafeSqrtLanes(LaneFloats x) { return SqrtLanes(MaxLanes(x, LaneFloats{})); }

/// v turned by `angle` toward `target`, both unit and neither parallel nor opposite.
Vec3 TurnToward(Vec3 v, Vec3 target, float angle) {
    const Vec3 side = Normalize(target - v * Dot(v, target));
    return Normalize(v * std::cos(angle) + side * std::sin(angle));
}

/// Smallest cone of directions around two others.
std::pair<Vec3, float> UnionOfCones(Vec3 axisA, float cosA, Vec3 axisB, float cosB) {
    if (cosA > cosB) {
        std::swap(axisA, axisB);
        std::swap(cosA, cosB);
    }
    if (cosA <= -1) return {axisA, cosA};
    const float thetaA = SafeACos(cosA), thetaB = SafeACos(cosB), between = AngleBetween(axisA, axisB);
    if (std::min(between + thetaB, Pi) <= thetaA) return {axisA, cosA};
    const float theta = (thetaA + between + thetaB) / 2;
    if (!(theta < Pi) || LengthSquared(Cross(axisA, axisB)) < 1e-12f) {
        // Nearly the same axis: the wider cone, opened by what the axes differ. Nearly opposite ones:
        // everything.
        const float opened = Dot(axisA, axisB) > 0 ? thetaA + between : Pi;
        return {axisA, std::cos(std::min(opened, Pi))};
    }
    return {TurnToward(axisA, axisB, theta - thetaA), std::cos(theta)};
}

}  // namespace

LightBounds Union(const LightBounds& a, const LightBounds& b) {
    LightBounds r;
    r.bounds = a.bounds.Union(b.bounds);
    r.power = a.power + b.power;
    std::tie(r.axis, r.cosTheta_o) = UnionOfCones(a.axis, a.cosTheta_o, b.axis, b.cosTheta_o);
    r.cosTheta_e = std::min(a.cosTheta_e, b.cosTheta_e);
    r.twoSided = a.twoSided || b.twoSided;
    return r;
}

float ClusterCost(const LightBounds& b) {
    const float theta_o = SafeACos(b.cosTheta_o), theta_e = SafeACos(b.cosTheta_e);
    const float theta_w = std::min(theta_o + theta_e, Pi), sinTheta_o = std::sin(theta_o);
    const float orientation =
        2 * Pi * (1 - b.cosTheta_o) + PiOver2 * (2 * theta_w * sinTheta_o - std::cos(theta_o - 2 * theta_w) -
                                                 2 * theta_o * sinTheta_o + b.cosTheta_o);
    return b.power * orientation * (b.bounds.SurfaceArea() + LengthSquared(b.bounds.Diagonal()));
}

LightCluster::LightCluster(const LightBounds& b, float totalPower)
    : center(b.bounds.Center()),
      radiusSquared(LengthSquared(b.bounds.Diagonal()) / 4),
      axis(b.axis),
      power(b.power / totalPower),
      cosTheta_o(b.cosTheta_o),
      sinTheta_o(SafeSqrt(1 - Sqr(b.cosTheta_o))),
      cosTheta_e(b.cosTheta_e - kLimitMargin),
      twoSided(b.twoSided) {}

float Importance(const LightCluster& cluster, const LightReference& ref) {
    const Vec3 d = cluster.center - ref.p;
    const float distanceSquared = LengthSquared(d);

    // Inside of the bounding sphere nothing is known about directions; its radius stands for the distance.
    if (!(distanceSquared > cluster.radiusSquared))
        return std::clamp(cluster.power / std::max(cluster.radiusSquared, kSmallest), kSmallest, kLargest);
    const Vec3 wi = d / std::sqrt(distanceSquared);
    const float sin2Sphere = cluster.radiusSquared / distanceSquared;
    const float sinSphere = std::sqrt(sin2Sphere), cosSphere = SafeSqrt(1 - sin2Sphere);

    // At the light: the angle to the axis, less the spread of the normals, less the extent of the cluster.
    float importance = cluster.power / distanceSquared;
    const bool facesAllSides = cluster.cosTheta_o <= -1;
    if (!facesAllSides) {
        float cosAxis = -Dot(cluster.axis, wi);
        if (cluster.twoSided) cosAxis = std::abs(cosAxis);
        const float sinAxis = SafeSqrt(1 - Sqr(cosAxis));
        const float cosX = CosDifference(sinAxis, cosAxis, cluster.sinTheta_o, cluster.cosTheta_o);
        const float sinX = SinDifference(sinAxis, cosAxis, cluster.sinTheta_o, cluster.cosTheta_o);
        const float cosAtLight = CosDifference(sinX, cosX, sinSphere, cosSphere);
        if (cosAtLight < cluster.cosTheta_e) return 0;
        importance *= std::max(cosAtLight, kCosineMargin);
    }

    // At the surface, which may reflect or transmit: the angle to the normal, less the extent.
    if (ref.ns != Normal3(0)) {
        const float cosNormal = AbsDot(wi, ref.ns), sinNormal = SafeSqrt(1 - Sqr(cosNormal));
        importance *= std::max(CosDifference(sinNormal, cosNormal, sinSphere, cosSphere), kCosineMargin);
    }
    return std::clamp(importance, kSmallest, kLargest);
}

void LightClusterLanes::Set(int lane, const LightCluster& cluster) {
    centerX[lane] = cluster.center.x;
    centerY[lane] = cluster.center.y;
    centerZ[lane] = cluster.center.z;
    radiusSquared[lane] = cluster.radiusSquared;
    axisX[lane] = cluster.axis.x;
    axisY[lane] = cluster.axis.y;
    axisZ[lane] = cluster.axis.z;
    power[lane] = std::max(cluster.power, kSmallest);  // 0 would be no cluster
    cosTheta_o[lane] = cluster.cosTheta_o;
    sinTheta_o[lane] = cluster.sinTheta_o;
    cosTheta_e[lane] = cluster.cosTheta_e;
    isTwoSided[lane] = cluster.twoSided ? -1 : 0;
    facesAllSides[lane] = cluster.cosTheta_o <= -1 ? -1 : 0;
}

LaneFloats Importance(const LightClusterLanes& clusters, const LightReference& ref) {
    // Step by step as for one cluster; steps that one leaves out have their results left out here.
    const LaneFloats none{}, smallest = none + kSmallest, margin = none + kCosineMargin;
    const LaneFloats dx = clusters.centerX - ref.p.x, dy = clusters.centerY - ref.p.y,
                     dz = clusters.centerZ - ref.p.z;
    const LaneFloats distanceSquared = dx * dx + dy * dy + dz * dz;
    const auto isOutside = distanceSquared > clusters.radiusSquared;
    const LaneFloats inverse = 1.f / SqrtLanes(distanceSquared);
    const LaneFloats sin2Sphere = clusters.radiusSquared / distanceSquared;
    const LaneFloats sinSphere = SqrtLanes(sin2Sphere), cosSphere = SafeSqrtLanes(1.f - sin2Sphere);

    const LaneFloats cosToAxis = -(clusters.axisX * dx + clusters.axisY * dy + clusters.axisZ * dz) * inverse;
    const LaneFloats cosAxis = (clusters.isTwoSided & (cosToAxis < 0.f)) ? -cosToAxis : cosToAxis;
    const LaneFloats sinAxis = SafeSqrtLanes(1.f - cosAxis * cosAxis);
    const LaneFloats cosX = CosDifference(sinAxis, cosAxis, clusters.sinTheta_o, clusters.cosTheta_o),
                     sinX = SinDifference(sinAxis, cosAxis, clusters.sinTheta_o, clusters.cosTheta_o);
    const LaneFloats cosAtLight = CosDifference(sinX, cosX, sinSphere, cosSphere);
    const LaneFloats atLight = clusters.facesAllSides ? none + 1.f : MaxLanes(cosAtLight, margin);
    const auto isDark = ~clusters.facesAllSides & (cosAtLight < clusters.cosTheta_e);

    LaneFloats importance = clusters.power / distanceSquared * atLight;
    if (ref.ns != Normal3(0)) {
        const LaneFloats cosNormal = (dx * ref.ns.x + dy * ref.ns.y + dz * ref.ns.z) * inverse,
                         absCos = MaxLanes(cosNormal, -cosNormal);
        const LaneFloats sinNormal = SafeSqrtLanes(1.f - absCos * absCos);
        importance *= MaxLanes(CosDifference(sinNormal, absCos, sinSphere, cosSphere), margin);
    }
    importance = isDark ? none : MaxLanes(importance, smallest);
    importance = isOutside ? importance
                           : MaxLanes(clusters.power / MaxLanes(clusters.radiusSquared, smallest), smallest);
    return clusters.power > 0.f ? MinLanes(importance, none + kLargest) : none;
}

}  // namespace lacquer
