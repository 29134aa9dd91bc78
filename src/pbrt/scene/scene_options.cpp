#include "pbrt/scene/scene_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "pbrt/scene/parameter_list.h"

namespace lacquer {

namespace {

using O = SceneOptions;

constexpr SceneOption kOptions[] = {
    {"disablepixeljitter", "--disable-pixel-jitter", &O::disablePixelJitter, "Sample pixels at their centres",
     true},
    {"disabletexturefiltering", "--disable-texture-filtering", &O::disableTextureFiltering,
     "Look textures up at points", true},
    {"disablewavelengthjitter", "--disable-wavelength-jitter", &O::disableWavelengthJitter,
     "The same wavelengths for all samples", true},
    {"displacementedgescale", "--displacement-edge-scale", &O::displacementEdgeScale,
     "Multiplies the edge length to which displaced meshes are refined", true, true},
    {"forcediffuse", "--force-diffuse", &O::forceDiffuse,
     "Make every surface matte, with the albedo of its material", true},
    {"msereferenceimage", "--mse-reference-image", &O::mseReferenceImage,
     "Image to compare with after every pass", false, false, nullptr, true},
    {"msereferenceout", "--mse-reference-out", &O::mseReferenceOut,
     "File for lines of samples, mean squared error", false, false, nullptr, true},
    {"pixelstats", "--pixelstats", &O::pixelStats,
     "Write what each pixel costs to another image, NAME-pixelstats.exr"},
    {"rendercoordsys", "--render-coord-sys", &O::renderCoordSys, "Space of computation", true, false,
     &RenderSpaces},
    {"seed", "--seed", &O::seed, "Seed of all random numbers"},
    {"wavefront", nullptr, &O::wavefront, "No effect in this version"},
};

std::string Normalize(const std::string& name) {
    std::string plain;
    for (const char c : name)
        if (c != '-' && c != '_') plain += char(std::tolower(static_cast<unsigned char>(c)));
    return plain;
}

[[noreturn]] void Unexpected(const SceneOption& option, const Token& value, const std::string& wanted,
                             const std::string& hint = {}) {
    throw SceneError(value.Loc(), fmt::format("Option \"{}\": expected {}, found {}{}", option.name, wanted,
                                              value.Excerpt(), hint));
}

void Read(const SceneOption& option, const Token& value, bool* result) {
    const bool isTrue = value.text == "true", isFalse = value.text == "false";
    if (value.kind != Token::Kind::Word || !(isTrue || isFalse))
        Unexpected(option, value, "true or false without quotes");
    *result = isTrue;
}

template <class Number>
void ReadNumber(const SceneOption& option, const Token& value, Number (*expect)(const Token&),
                Number* result) {
    try {
        *result = expect(value);
    } catch (const SceneError& e) {
        throw SceneError(e.Loc(), fmt::format("Option \"{}\": {}", option.name, e.Message()));
    }
    if (option.isPositive && !(*result > 0)) Unexpected(option, value, "a positive number");
}
void Read(const SceneOption& option, const Token& value, int* result) {
    ReadNumber(option, value, ExpectInteger, result);
}
void Read(const SceneOption& option, const Token& value, float* result) {
    ReadNumber(option, value, ExpectFloat, result);
}

void Read(const SceneOption& option, const Token& value, std::string* result) {
    if (value.kind != Token::Kind::String) Unexpected(option, value, "a string in quotes");
    *result = value.text;
    if (!option.choices) return;
    const std::vector<std::string>& choices = option.choices();
    if (std::find(choices.begin(), choices.end(), *result) == choices.end())
        Unexpected(option, value, fmt::format("\"{}\"", fmt::join(choices, "\", \"")),
                   DidYouMean(*result, choices));
}

}  // namespace

const std::vector<std::string>& RenderSpaces() {
    static const std::vector<std::string> spaces = {"camera", "cameraworld", "world"};
    return spaces;
}

std::span<const SceneOption> OptionTable() { return kOptions; }

size_t GivenOptions::IndexOf(const SceneOption::Field& field) {
    const auto* found = std::find_if(std::begin(kOptions), std::end(kOptions),
                                     [&](const SceneOption& option) { return option.field == field; });
    return size_t(found - std::begin(kOptions));
}

SceneOptions Resolve(const GivenOptions& ofScene, const GivenOptions& ofCommandLine) {
    SceneOptions resolved;
    for (const SceneOption& option : kOptions)
        for (const GivenOptions* source : {&ofScene, &ofCommandLine}) {
            if (!source->IsGiven(option.field)) continue;
            std::visit([&](auto field) { resolved.*field = source->Values().*field; }, option.field);
            break;
        }
    return resolved;
}

void SetOption(const std::string& name, const Token& value, const FileLoc& loc, GivenOptions* options) {
    const std::string plain = Normalize(name);
    const auto* found = std::find_if(std::begin(kOptions), std::end(kOptions),
                                     [&](const SceneOption& option) { return plain == option.name; });
    if (found == std::end(kOptions)) {
        std::vector<std::string> names;
        for (const SceneOption& option : kOptions) names.emplace_back(option.name);
        throw SceneError(loc,
                         fmt::format("unknown option \"{}\"{}", Excerpt(name), DidYouMean(plain, names)));
    }
    std::visit(
        [&](auto field) {
            auto result = SceneOptions().*field;
            Read(*found, value, &result);
            options->Set(field, std::move(result));
        },
        found->field);
}

}  // namespace lacquer
