#include "pbrt/textures/noise.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lacquer {

namespace {

// The permutation of [Perlin 2002], so that patterns are those of every other renderer.
constexpr std::array<uint8_t, 256> kPermutation = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,
    69,  142, 8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,
    94,  252, 219, 203, 117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136,
    171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166, 77,  146, 158, 231, 83,  111, 229, 122,
    60,  211, 133, 230, 220, 105, 92,  41,  55,  46,  245, 40,  244, 102, 143, 54,  65,  25,  63,  161,
    1,   216, 80,  73,  209, 76,  132, 187, 208, 89,  18,  169, 200, 196, 135, 130, 116, 188, 159, 86,
    164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250, 124, 123, 5,   202, 38,  147, 118, 126,
    255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,  182, 189, 28,  42,  223, 183, 170, 213,
    119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,   129, 22,  39,  253,
    19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,  242, 193,
    238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,
    181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,
    222, 114, 67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

int Hash(int x, int y, int z) {
    const auto at = [](int i) { return int(kPermutation[size_t(i & 255)]); };
    return at(at(at(x) + y) + z);
}

/// Dot product of (x, y, z) with the gradient that the hash chooses: an edge direction of the cube.
float Gradient(int hash, Vec3 d) {
    const int h = hash & 15;
    const float u = h < 8 || h == 12 || h == 13 ? d.x : d.y;
    const float v = h < 4 || h == 12 || h == 13 ? d.y : d.z;
    return (h & 1 ? -u : u) + (h & 2 ? -v : v);
}

/// Quintic step with vanishing first and second derivative at 0 and 1.
float Fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

/// Number of octaves that a footprint leaves visible, as pbrt counts them.
float VisibleOctaves(Vec3 dpdx, Vec3 dpdy, int octaves) {
    const float width2 = std::max(LengthSquared(dpdx), LengthSquared(dpdy));
    return std::clamp(-1 - 0.5f * std::log2(width2), 0.f, float(octaves));
}

}  // namespace

float Noise(Point3 p) {
    constexpr float kFar = 0x1p24f;
    if (!(MaxComponent(Abs(p)) < kFar) || !IsFinite(p)) return 0;
    const Vec3 cell = glm::floor(p), d = p - cell;
    const int x = int(cell.x), y = int(cell.y), z = int(cell.z);
    const Vec3 w(Fade(d.x), Fade(d.y), Fade(d.z));
    const auto corner = [&](int i, int j, int k) {
        return Gradient(Hash(x + i, y + j, z + k), d - Vec3(float(i), float(j), float(k)));
    };
    const auto edge = [&](int j, int k) { return Lerp(w.x, corner(0, j, k), corner(1, j, k)); };
    return Lerp(w.z, Lerp(w.y, edge(0, 0), edge(1, 0)), Lerp(w.y, edge(0, 1), edge(1, 1)));
}

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
