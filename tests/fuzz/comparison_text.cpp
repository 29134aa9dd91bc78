// What `lacquer compare` reads of its command line and of a scene's comments: boxes and variations.
#include <sstream>
#include <stdexcept>

#include "compare/box.h"
#include "compare/variation.h"
#include "fuzz/fuzz_target.h"
#include "pbrt/core/error.h"
#include "pbrt/scene/parser.h"

namespace lacquer::fuzz {
namespace {

constexpr const char* kScene = R"(WorldBegin LightSource "infinite"
MakeNamedMaterial "coat" "string type" "coateddiffuse" "float roughness" 0.1
NamedMaterial "coat" Shape "sphere")";

// Errors of both are std::invalid_argument.
void ComparisonText(std::string_view bytes) {
    const std::string text(bytes);
    std::istringstream comments(text);
    for (const compare::Box& box : compare::BoxesOfScene(comments, {40, 30}))
        Require(!box.pixels.IsEmpty(), "boxes of scenes have pixels");
    int refused = 0;
    try {
        Require(!compare::ParseBox(text, {40, 30}).pixels.IsEmpty(), "boxes have pixels");
    } catch (const std::invalid_argument&) {
        ++refused;
    }
    try {
        const compare::Variation variation = compare::ParseVariation(text);
        SceneDescription scene = ParseText(kScene, "scene.pbrt", "", nullptr);
        for (const std::string& value : variation.values) compare::Apply(variation, value, &scene);
    } catch (const std::invalid_argument&) {
        ++refused;
    }
    if (refused == 2) throw FileError("text", "neither a box nor a variation");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "comparison_text", ComparisonText);

}  // namespace lacquer::fuzz
