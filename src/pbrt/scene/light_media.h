// Which media lights are in.
#pragma once

#include <vector>

#include "pbrt/base/interaction.h"

namespace lacquer {

class Scene;

/// The media of a light's two sides.
struct LightMedia {
    const MediumInterface* interface = nullptr;  ///< where the light is a surface between media; else null
    const Medium* around = nullptr;              ///< where there is no interface; null: vacuum
};

/// What is around everything, as paths from the camera have it; null: vacuum.
const Medium* OutermostMedium(const Scene& scene);

/// For each of scene.Lights(). Casts some rays for each. Which medium a light is in follows from the surfaces
/// around it, as it does for paths from the camera, and not from what the scene file says at the light.
std::vector<LightMedia> FindLightMedia(const Scene& scene);

}  // namespace lacquer
