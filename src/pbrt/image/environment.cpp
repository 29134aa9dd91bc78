#include "pbrt/image/environment.h"

#include <fmt/format.h>

#include <stdexcept>

#include "pbrt/core/math.h"
#include "pbrt/core/parallel.h"

namespace lacquer {
namespace {

constexpr int kMaxMapSide = 8192;

/// From the middle of the square by `radius` in [0,1] along (right, up), which need not be unit.
Point2 OnDisk(float radius, float right, float up) {
    const float length = std::hypot(right, up);
    if (!(length > 0)) return {0.5f, 0.5f * (1 - radius)};
    const float scale = 0.5f * radius / length;
    return {0.5f + scale * right, 0.5f - scale * up};
}

/// Facing a mirroring ball from -x, +y is on the right: pbrt's space is left-handed.
Point2 OnMirrorBall(Vec3 w) {
    // The normal of the ball is half way between w and the camera; its distance from the axis is where it is
    // seen: sin(theta / 2) for the angle theta between w and the camera.
    return OnDisk(SafeSqrt(0.5f * (1 + w.x)), w.y, w.z);
}
/// Inside of the world, looking towards -x, +y is on the left.
Point2 OnAngularMap(Vec3 w) { return OnDisk(std::acos(std::clamp(-w.x, -1.f, 1.f)) * InvPi, -w.y, w.z); }
Point2 OnLatLong(Vec3 w) {
    const float phi = std::atan2(w.y, w.x), theta = std::atan2(std::hypot(w.x, w.y), w.z);
    return {(phi < 0 ? phi + 2 * Pi : phi) / (2 * Pi), theta * InvPi};
}

/// Pixels of one row or column between which a coordinate lies.
struct Neighbors {
    int first, second;
    float weight;  ///< of the second
};
Neighbors NeighborsOf(float coordinate, int size, bool isPeriodic) {
    const float x = coordinate * float(size) - 0.5f;
    const float floor = std::floor(x);
    int first = int(floor), second = first + 1;
    if (isPeriodic) {
        first = (first + size) % size;
        second %= size;
    } else {
        first = std::clamp(first, 0, size - 1);
        second = std::clamp(second, 0, size - 1);
    }
    return {first, second, x - floor};
}

/// Adds a bilinear look-up to the channels of `sum`.
void AddLookUp(const Image& image, Point2 st, bool isPeriodic, std::vector<double>* sum) {
    const Int2 size = image.Resolution();
    const Neighbors x = NeighborsOf(st.x, size.x, isPeriodic), y = NeighborsOf(st.y, size.y, false);
    for (int c = 0; c < image.NumChannels(); ++c) {
        const float top = Lerp(x.weight, image.Get({x.first, y.first}, c), image.Get({x.second, y.first}, c));
        const float bottom =
            Lerp(x.weight, image.Get({x.first, y.second}, c), image.Get({x.second, y.second}, c));
        (*sum)[size_t(c)] += double(Lerp(y.weight, top, bottom));
    }
}

/// Look-ups for each pixel of the result, in each direction: every pixel of the image has at least two, so
/// that maps of few pixels miss no sun.
int LookUpsAlongPixel(Int2 resolution, int side) {
    const double pixels = std::sqrt(double(resolution.x) * resolution.y) / side;
    return std::max(std::clamp(int(std::ceil(4 * pixels)), 4, 16), int(std::ceil(2 * pixels)));
}

}  // namespace

std::vector<std::string> EnvironmentMappingNames() {
    return {"equalarea", "latlong", "mirrorball", "angular"};
}

EnvironmentMapping EnvironmentMappingOf(const std::string& name) {
    const std::vector<std::string> names = EnvironmentMappingNames();
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) throw std::out_of_range("mapping of an environment: " + name);
    return EnvironmentMapping(found - names.begin());
}

std::string WhyNotOfMapping(Int2 resolution, EnvironmentMapping mapping) {
    if (resolution.x < 1 || resolution.y < 1) return "it has no pixels";
    if (mapping == EnvironmentMapping::LatLong || resolution.x == resolution.y) return {};
    return fmt::format(
        "an environment map of the mapping \"{}\" must be square, this image has {} x {} pixels",
        EnvironmentMappingNames()[size_t(mapping)], resolution.x, resolution.y);
}

Point2 DirectionToImage(EnvironmentMapping mapping, Vec3 w) {
    switch (mapping) {
        case EnvironmentMapping::LatLong:
            return OnLatLong(w);
        case EnvironmentMapping::MirrorBall:
            return OnMirrorBall(w);
        case EnvironmentMapping::Angular:
            return OnAngularMap(w);
        case EnvironmentMapping::EqualArea:
            break;
    }
    return EqualAreaSphereToSquare(w);
}

int EqualAreaSide(Int2 resolution, EnvironmentMapping mapping) {
    const bool isDisk = mapping == EnvironmentMapping::MirrorBall || mapping == EnvironmentMapping::Angular;
    const double pixels = double(resolution.x) * resolution.y * (isDisk ? double(PiOver4) : 1.);
    return std::clamp(int(std::ceil(std::sqrt(pixels))), 1, kMaxMapSide);
}

Image ToEqualArea(const Image& image, EnvironmentMapping mapping, int side) {
    Image result(Int2(side), image.Channels());
    result.SetColorSpace(image.ColorSpace());
    const bool isPeriodic = mapping == EnvironmentMapping::LatLong;
    const int n = LookUpsAlongPixel(image.Resolution(), side);
    ParallelFor(side, [&](int64_t row) {
        std::vector<double> sum(size_t(image.NumChannels()));
        for (int x = 0; x < side; ++x) {
            std::fill(sum.begin(), sum.end(), 0.);
            for (int64_t i = 0; i < int64_t(n) * n; ++i) {
                const Point2 inPixel(float(i % n) + 0.5f, float(i / n) + 0.5f);
                const Point2 square = (Point2(float(x), float(row)) + inPixel / float(n)) / float(side);
                AddLookUp(image, DirectionToImage(mapping, EqualAreaSquareToSphere(square)), isPeriodic,
                          &sum);
            }
            for (size_t c = 0; c < sum.size(); ++c)
                result.Set({x, int(row)}, int(c), float(sum[c] / (double(n) * n)));
        }
    });
    return result;
}

}  // namespace lacquer
