// The colours of a material as paint laboratories read them, as text and as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "measure/color_survey.h"
#include "pbrt/scene/builder.h"

namespace lacquer::cmd {

/// The colours of a material, and of the one that they are compared with, if there is one.
struct ColorTable {
    std::string material, reference;
    double azimuthDeg = 0;
    std::optional<measure::ColorSurvey> colors, referenceColors;
};

struct ColorQuery {
    std::string material, reference;  ///< as of measure::LoadMaterial(); empty: no reference
    Point2 uv{0.5f};
    measure::ColorSurveyOptions survey;
    BuildOptions build;
};
/// Errors: as of measure::LoadMaterial(). @param observer  may be null
ColorTable MakeColorTable(const SceneDescription& scene, const ColorQuery& query, Observer* observer);

nlohmann::ordered_json ToJson(const ColorTable& table);
std::string ToText(const ColorTable& table);

}  // namespace lacquer::cmd
