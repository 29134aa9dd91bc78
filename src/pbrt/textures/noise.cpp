#include "pbrt/textures/noise.h"

#include <algorithm>
#include <cmath>

namespace lacquer {

namespace {

/// Number of octaves that a footprint leaves visible, as pbrt counts them.
float VisibleOctaves(Vec3 dpdx, Vec3 dpdy, int octaves) {
    const float width2 = std::max(LengthSquared(dpdx), LengthSquared(dpdy));
    return std::clamp(-1 - 0.5f * std::log2(width2), 0.f, float(octaves));
}

}  // namespace

OctaveParams OctaveParams::Read(const Params& params) {
    OctaveParams result;
    result.octaves =
        std::min(params.GetIntInRange("octaves", 8, 0, std::numeric_limits<int>::max()), kMaxOctaves);
    result.omega = params.GetFloatInRange("roughness", 0.5f, -10, 10);
    return result;
}

float FractionalBrownianMotion(Point3 p, Vec3 dpdx, Vec3 dpdy, const OctaveParams& params) {
    const float n = VisibleOctaves(dpdx, dpdy, params.octaves);
    const int whole = int(n);
    float sum = 0, lambda = 1, weight = 1;
    for (int i = 0; i < whole; ++i) {
        sum += weight * Noise(lambda * p);
        lambda *= 1.99f;
        weight *= params.omega;
    }
    const float fade = SmoothStep(n - float(whole), 0.3f, 0.7f);
    return fade > 0 ? sum + weight * fade * Noise(lambda * p) : sum;
}

float Turbulence(Point3 p, Vec3 dpdx, Vec3 dpdy, const OctaveParams& params) {
    constexpr float kMean = 0.2f;
    const float n = VisibleOctaves(dpdx, dpdy, params.octaves);
    const int whole = int(n);
    float sum = 0, lambda = 1, weight = 1;
    for (int i = 0; i < whole; ++i) {
        sum += weight * std::abs(Noise(lambda * p));
        lambda *= 1.99f;
        weight *= params.omega;
    }
    // As in pbrt, the octave that fades counts once here and once more among those that are too fine.
    sum += weight * Lerp(SmoothStep(n - float(whole), 0.3f, 0.7f), kMean, std::abs(Noise(lambda * p)));
    for (int i = whole; i < params.octaves; ++i) {
        sum += weight * kMean;
        weight *= params.omega;
    }
    return sum;
}

}  // namespace lacquer
