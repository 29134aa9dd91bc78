// Media from parameters as they stand in scene files.
#pragma once

#include <gtest/gtest.h>

#include "pbrt/base/medium.h"
#include "pbrt/core/rng.h"
#include "support/scene_parts.h"
#include "support/statistics.h"

namespace lacquer::test {

/// The medium `type` with the parameters of `text`. Throws what its factory throws; all parameters must be
/// used.
inline std::unique_ptr<Medium> MakeMedium(const std::string& type, const std::string& text,
                                          const Transform& renderFromMedium = {}) {
    const auto factory = Registry<MediumKind>::Find(type);
    EXPECT_NE(factory, nullptr) << type;
    const SceneDescription d =
        ParseText("WorldBegin MakeNamedMedium \"m\" \"string type\" \"" + type + "\" " + text, "scene.pbrt",
                  "", nullptr);
    const Params params = MakeParams(d.media.front(), "medium", d.FilesOf(d.media.front()));
    std::unique_ptr<Medium> medium = factory({params, renderFromMedium});
    params.CheckAllUsed();
    return medium;
}
/// The message of the SceneError that the factory throws, or an empty string.
inline std::string MediumErrorOf(const std::string& type, const std::string& text) {
    try {
        MakeMedium(type, text);
    } catch (const SceneError& e) {
        return e.what();
    }
    return "";
}

inline SampledWavelengths SomeWavelengths() { return SampledWavelengths::SampleVisible(0.3f); }

inline Point3 RandomPoint(Rng& rng) { return {rng.Uniform(), rng.Uniform(), rng.Uniform()}; }
inline Vec3 RandomDirection(Rng& rng) {
    const float z = 2 * rng.Uniform() - 1;
    return SphericalDirection(std::sqrt(1 - z * z), z, 2 * Pi * rng.Uniform());
}

/// "[ ... ]" of random numbers in [0, high), every third one 0.
inline std::string RandomList(int count, Rng& rng, float high = 1) {
    std::string list = "[";
    for (int i = 0; i < count; ++i) list += " " + std::to_string(i % 3 == 2 ? 0.f : high * rng.Uniform());
    return list + " ]";
}

/// Checks along random rays through a box that sigma_t is never above its bound, but for a relative `slack`,
/// and zero outside of the segments.
/// @param factor  on the bounds: below 1 for negative controls
inline testing::AssertionResult BoundsHold(const Medium& medium, const Bounds3& box, Rng& rng,
                                           int numRays = 300, int numPoints = 40, double slack = 1e-5,
                                           double factor = 1) {
    const SampledWavelengths lambda = SomeWavelengths();
    for (int i = 0; i < numRays; ++i) {
        const Point3 through = box.min + RandomPoint(rng) * box.Diagonal();
        const Vec3 d = RandomDirection(rng);
        const float reach = 2 * Length(box.Diagonal());
        const Ray ray{through - 0.5f * reach * d, d};
        std::vector<MajorantSegment> segments;
        MajorantWalk walk = medium.Majorants(ray, reach, lambda);
        for (MajorantSegment s; walk.Next(&s);) segments.push_back(s);
        for (int j = 0; j < numPoints; ++j) {
            const float t = reach * rng.Uniform();
            SampledSpectrum bound(0);
            for (const MajorantSegment& s : segments)
                if (t >= s.tMin && t <= s.tMax) bound = Max(bound, s.sigmaMaj);
            const SampledSpectrum sigma = medium.At(ray(t), lambda).SigmaT();
            for (int l = 0; l < kNumWavelengths; ++l)
                if (!(double(sigma[l]) <= factor * double(bound[l]) * (1 + slack) + 1e-6))
                    return testing::AssertionFailure()
                           << "sigma_t " << sigma[l] << " above " << factor << " x " << bound[l]
                           << " at t = " << t << " of ray " << i;
        }
    }
    return testing::AssertionSuccess();
}

}  // namespace lacquer::test
