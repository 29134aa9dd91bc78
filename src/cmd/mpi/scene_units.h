// Rendering units of a scene: films of their pixels, and what these have added up as bytes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cmd/mpi/unit_renderer.h"
#include "pbrt/integrators/rendered_image.h"

namespace lacquer::cmd {

/// A render of which units are made.
struct SceneUnits {
    const RenderSetup* setup = nullptr;
    nlohmann::ordered_json film;  ///< FilmRecord()
    std::vector<std::string> aovs;
    int cryptomatteRanks = 6;
    const PassSet* passes = nullptr;  ///< null: none
    int halfBlock = 1;                ///< of the whole

    /// Renders a unit into a film of its own. Samples have the numbers that they have in the whole, and go to
    /// its halves; so adding the states of all units has the bits of one render.
    RenderedUnit Render(const RenderUnit& unit, Observer& observer) const;
};

}  // namespace lacquer::cmd
