// A scene's survey for readers and for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cmd/scenes/scene_survey.h"

namespace lacquer::cmd {

/// A table of several lines. Control characters in names become blanks.
std::string SceneInfoText(const SceneSurvey& survey);
/// The object that docs/scenes.md describes.
nlohmann::json SceneInfoJson(const SceneSurvey& survey);

}  // namespace lacquer::cmd
