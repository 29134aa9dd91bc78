// Parameters, and whole scenes, from scene text: tests read like scene files.
#pragma once

#include <string>

#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"

namespace lacquer::test {

/// The parameters of `text` ("\"float fov\" 30 ..."), as a directive of some kind carries them.
/// @param space  name of the colour space in force
inline Params ParamsFromText(const std::string& kind, const std::string& text,
                             const std::string& space = "srgb") {
    const SceneDescription d = ParseText(
        "ColorSpace \"" + space + "\" Film \"test\" " + text + "\nWorldBegin", "scene.pbrt", "", nullptr);
    return MakeParams(d.film, kind, d.FilesOf(d.film));
}

/// Everything that is wrong with a scene, line by line; empty if nothing is.
inline std::string BuildErrorsOf(const std::string& text, Observer* observer = nullptr) {
    try {
        BuildScene(ParseText(text, "scene.pbrt", "", observer), {}, observer);
    } catch (const SceneErrors& e) {
        return e.what();
    }
    return "";
}

inline RenderSetup BuildText(const std::string& text, Observer* observer = nullptr) {
    return BuildScene(ParseText(text, "scene.pbrt", "", observer), {}, observer);
}

/// The nearest hit of a ray; nobody counts it.
inline bool NearestHit(const RenderSetup& setup, const Ray& ray, SurfaceInteraction* si) {
    RayCounts uncounted;
    return setup.scene->Intersect(ray, Infinity, si, uncounted);
}

/// Keeps the warnings.
class WarningList final : public Observer {
  public:
    void Warn(const std::string& message) override { text += message + "\n"; }
    std::string text;
};

}  // namespace lacquer::test
