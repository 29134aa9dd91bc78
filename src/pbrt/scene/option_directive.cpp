#include "pbrt/scene/option_directive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <variant>

#include "pbrt/scene/parameter_list.h"

namespace lacquer {

namespace {

using Field = std::variant<std::optional<bool> SceneOptions::*, std::optional<int> SceneOptions::*,
                           std::optional<float> SceneOptions::*, std::optional<std::string> SceneOptions::*>;
struct Option {
    const char* name;
    Field field;
};
constexpr Option kOptions[] = {
    {"disablepixeljitter", &SceneOptions::disablePixelJitter},
    {"disabletexturefiltering", &SceneOptions::disableTextureFiltering},
    {"disablewavelengthjitter", &SceneOptions::disableWavelengthJitter},
    {"displacementedgescale", &SceneOptions::displacementEdgeScale},
    {"forcediffuse", &SceneOptions::forceDiffuse},
    {"msereferenceimage", &SceneOptions::mseReferenceImage},
    {"msereferenceout", &SceneOptions::mseReferenceOut},
    {"pixelstats", &SceneOptions::pixelStats},
    {"rendercoordsys", &SceneOptions::renderCoordSys},
    {"seed", &SceneOptions::seed},
    {"wavefront", &SceneOptions::wavefront},
};

std::string Normalize(const std::string& name) {
    std::string plain;
    for (const char c : name)
        if (c != '-' && c != '_') plain += char(std::tolower(static_cast<unsigned char>(c)));
    return plain;
}

void Read(const std::string& name, const Token& value, std::optional<bool>* option) {
    const bool isTrue = value.text == "true", isFalse = value.text == "false";
    if (value.kind != Token::Kind::Word || !(isTrue || isFalse))
        throw SceneError(value.Loc(),
                         fmt::format("Option \"{}\": expected true or false without quotes, found {}", name,
                                     value.Excerpt()));
    *option = isTrue;
}

template <class Number>
void ReadNumber(const std::string& name, const Token& value, Number (*expect)(const Token&),
                std::optional<Number>* option) {
    try {
        *option = expect(value);
    } catch (const SceneError& e) {
        throw SceneError(e.Loc(), fmt::format("Option \"{}\": {}", name, e.Message()));
    }
}

void Read(const std::string& name, const Token& value, std::optional<int>* option) {
    ReadNumber(name, value, ExpectInteger, option);
}
void Read(const std::string& name, const Token& value, std::optional<float>* option) {
    ReadNumber(name, value, ExpectFloat, option);
}

void Read(const std::string& name, const Token& value, std::optional<std::string>* option) {
    if (value.kind != Token::Kind::String)
        throw SceneError(value.Loc(), fmt::format("Option \"{}\": expected a string in quotes, found {}",
                                                  name, value.Excerpt()));
    std::string text(value.text);
    const std::vector<std::string>& spaces = RenderSpaces();
    if (name == "rendercoordsys" && std::find(spaces.begin(), spaces.end(), text) == spaces.end())
        throw SceneError(value.Loc(),
                         fmt::format("Option \"{}\": expected \"{}\", found {}{}", name,
                                     fmt::join(spaces, "\", \""), value.Excerpt(), DidYouMean(text, spaces)));
    *option = std::move(text);
}

}  // namespace

void SetOption(const std::string& name, const Token& value, const FileLoc& loc, SceneOptions* options) {
    const std::string plain = Normalize(name);
    const auto* found = std::find_if(std::begin(kOptions), std::end(kOptions),
                                     [&](const Option& option) { return plain == option.name; });
    if (found == std::end(kOptions)) {
        std::vector<std::string> names;
        for (const Option& option : kOptions) names.emplace_back(option.name);
        throw SceneError(loc,
                         fmt::format("unknown option \"{}\"{}", Excerpt(name), DidYouMean(plain, names)));
    }
    std::visit([&](auto field) { Read(plain, value, &(options->*field)); }, found->field);
}

}  // namespace lacquer
