#include "pbrt/core/noise.h"

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
/// That direction.
Vec3 GradientDirection(int hash) {
    return {Gradient(hash, {1, 0, 0}), Gradient(hash, {0, 1, 0}), Gradient(hash, {0, 0, 1})};
}

/// Quintic step with vanishing first and second derivative at 0 and 1.
float Fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }
float FadeSlope(float t) { return 30 * Sqr(t * (t - 1)); }

/// Beyond, floats have no fractions.
constexpr float kFar = 0x1p24f;

}  // namespace

float Noise(Point3 p) {
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

Vec3 NoiseGradient(Point3 p) {
    if (!(MaxComponent(Abs(p)) < kFar) || !IsFinite(p)) return Vec3(0);
    const Vec3 cell = glm::floor(p), d = p - cell;
    const int x = int(cell.x), y = int(cell.y), z = int(cell.z);
    // Noise() is a sum over corners of products: a weight for each axis, and a linear function.
    const Vec3 weights[2] = {Vec3(1 - Fade(d.x), 1 - Fade(d.y), 1 - Fade(d.z)),
                             Vec3(Fade(d.x), Fade(d.y), Fade(d.z))};
    const Vec3 slope(FadeSlope(d.x), FadeSlope(d.y), FadeSlope(d.z));
    Vec3 sum(0);
    for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j)
            for (int i = 0; i < 2; ++i) {
                const Vec3 direction = GradientDirection(Hash(x + i, y + j, z + k));
                const float value = Dot(direction, d - Vec3(float(i), float(j), float(k)));
                const Vec3 w(weights[i].x, weights[j].y, weights[k].z);
                const Vec3 s(i ? slope.x : -slope.x, j ? slope.y : -slope.y, k ? slope.z : -slope.z);
                sum += w.x * w.y * w.z * direction;
                sum += value * Vec3(s.x * w.y * w.z, w.x * s.y * w.z, w.x * w.y * s.z);
            }
    return sum;
}

}  // namespace lacquer
