// Materials from scene text, as `lacquer bsdf` looks at them.
#pragma once

#include "cmd/bsdf/subject.h"
#include "support/scene_parts.h"

namespace lacquer::cmd::test {

/// A material and what it is made of.
struct SubjectFromText {
    MaterialSetup setup;
    std::unique_ptr<BsdfSubject> subject;

    /// @param materials  directives that make named materials, among them `name`
    SubjectFromText(const std::string& materials, const std::string& name)
        : setup(BuildMaterial(ParseText("WorldBegin\n" + materials, "scene.pbrt", "", nullptr), name, {},
                              nullptr)),
          subject(std::make_unique<BsdfSubject>(*setup.material, Point2(0.5f), setup.entity.loc)) {}
    const BsdfSubject& operator*() const { return *subject; }
};

/// Unit vector at angles in degrees.
inline Vec3 DirectionAt(float thetaDeg, float phiDeg) {
    return SphericalDirection(std::sin(Radians(thetaDeg)), std::cos(Radians(thetaDeg)), Radians(phiDeg));
}

}  // namespace lacquer::cmd::test
