#include "pbrt/media/grid_params.h"

#include <fmt/format.h>

#include "pbrt/core/invertible.h"

namespace lacquer {

Transform ReadUnitFromRender(const MediumArgs& args) {
    RequireInvertible(args.params, args.renderFromMedium);
    const Point3 p0 = args.params.GetPoint3("p0", Point3(0)), p1 = args.params.GetPoint3("p1", Point3(1));
    const Bounds3 box(p0, p1);
    const Transform unitFromRender = Transform::Scale(1.f / box.Diagonal()) * Transform::Translate(-box.min) *
                                     args.renderFromMedium.Inverse();
    for (int axis = 0; axis < 3; ++axis)
        if (!(box.Diagonal()[axis] > 0) || unitFromRender.IsSingular())
            args.params.Fail(
                args.params.Has("p1") ? "p1" : "p0",
                fmt::format("the box from \"p0\" ({} {} {}) to \"p1\" ({} {} {}) must have a volume", p0.x,
                            p0.y, p0.z, p1.x, p1.y, p1.z));
    return unitFromRender;
}

Int3 ReadResolution(const Params& params) {
    Int3 n;
    constexpr int kMax = std::numeric_limits<int>::max();
    n.x = params.GetIntInRange("nx", 1, 1, kMax);
    n.y = params.GetIntInRange("ny", 1, 1, kMax);
    n.z = params.GetIntInRange("nz", 1, 1, kMax);
    if (double(n.x) * double(n.y) * double(n.z) > 0x1p31)
        params.Fail("nx", fmt::format("{} x {} x {} voxels are more than the limit of 2^31", n.x, n.y, n.z));
    return n;
}

void CheckVoxelCount(const Params& params, const char* name, size_t count, Int3 n) {
    const size_t expected = size_t(n.x) * size_t(n.y) * size_t(n.z);
    if (count != expected)
        params.Fail(name,
                    fmt::format("\"{}\" needs {} values, \"nx\" x \"ny\" x \"nz\" = {} x {} x {}, but has {}",
                                name, expected, n.x, n.y, n.z, count));
}

std::optional<FloatGrid> ReadFloatGrid(const Params& params, const char* name, Int3 resolution) {
    const std::vector<float> values = params.GetFloats(name);
    if (values.empty()) return std::nullopt;
    CheckVoxelCount(params, name, values.size(), resolution);
    for (const float value : values)
        if (!(value >= 0))
            params.Fail(name, fmt::format("\"{}\" must not be negative, found {}", name, value));
    return FloatGrid(resolution, values);
}

Vec3 EdgeLengths(const Transform& unitFromRender) {
    return {Length(unitFromRender.InverseVector({1, 0, 0})), Length(unitFromRender.InverseVector({0, 1, 0})),
            Length(unitFromRender.InverseVector({0, 0, 1}))};
}

}  // namespace lacquer
