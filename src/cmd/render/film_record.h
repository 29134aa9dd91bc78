// What makes a film and its outputs again without the scene, as JSON: for states, whose merging ends in an
// image.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "pbrt/base/scene_names.h"
#include "pbrt/film/aov.h"
#include "pbrt/film/passes.h"
#include "pbrt/film/render_state.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/description.h"

namespace lacquer::cmd {

/// The directives of the film and its filter, and names of others.
nlohmann::ordered_json FilmDirectives(const SceneDescription& description);
/// What follows from them, the command line and the scene, with these directives.
/// @param aovs, passes  may be null
nlohmann::ordered_json FilmRecord(nlohmann::ordered_json directives, const RenderSetup& setup,
                                  const AovBuffer* aovs, int cryptomatteRanks, const PassSet* passes);

/// That a record has what is said of it and asked for here but for RestoreFilm(), of the right types. Errors:
/// nlohmann::json::exception.
void CheckFilmRecord(const nlohmann::ordered_json& record);

/// An empty film as that of the render, and its outputs.
struct RestoredFilm {
    std::unique_ptr<Film> film;
    std::unique_ptr<SceneNames> names;
    std::unique_ptr<AovBuffer> aovs;  ///< null: none
    bool hasPasses = false;
    Metadata metadata;  ///< SceneMetadata()
    std::vector<StateArray> State() const;
};
/// @param overrides  name of the image and pixel bounds; without bounds, the pixels that the scene asks for.
/// The rest is as recorded. Errors: OverrideError, SceneError, as of films; nlohmann::json::exception.
RestoredFilm RestoreFilm(const nlohmann::ordered_json& record, FilmOverrides overrides);
/// An empty film of a part of the scene's pixels, to render into: as the scene's own with its passes, without
/// outputs.
std::unique_ptr<Film> MakePartOfFilm(const nlohmann::ordered_json& record, const RenderSetup& setup,
                                     const Bounds2i& pixels);
/// True if the record is of a render that traces light from the lights.
bool MakesSplats(const nlohmann::ordered_json& record);

}  // namespace lacquer::cmd
