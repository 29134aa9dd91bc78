// Materials from scene text.
#pragma once

#include "measure/scene_material.h"
#include "support/scene_parts.h"

namespace lacquer::measure::test {

/// @param materials  directives that make named materials, among them `name`
inline SceneMaterial FromText(const std::string& materials, const std::string& name) {
    return LoadMaterial(ParseText("WorldBegin\n" + materials, "scene.pbrt", "", nullptr), name);
}

/// Unit vector at angles in degrees.
inline Vec3 DirectionAt(float thetaDeg, float phiDeg) {
    return SphericalDirection(std::sin(Radians(thetaDeg)), std::cos(Radians(thetaDeg)), Radians(phiDeg));
}

}  // namespace lacquer::measure::test
