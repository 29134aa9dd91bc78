#include "pbrt/scene/file_parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "pbrt/scene/v3.h"

namespace lacquer {

/// Sorted by name.
const FileParser::Directive FileParser::kDirectives[] = {
    {"Accelerator", Where::Options, &FileParser::PluginDirective<&DescriptionBuilder::Accelerator>},
    {"ActiveTransform", Where::Anywhere, &FileParser::ActiveTransform},
    {"AreaLightSource", Where::World, &FileParser::PluginDirective<&DescriptionBuilder::AreaLightSource>},
    {"Attribute", Where::Anywhere, &FileParser::Attribute},
    {"AttributeBegin", Where::World, &FileParser::PlainDirective<&DescriptionBuilder::AttributeBegin>},
    {"AttributeEnd", Where::World, &FileParser::PlainDirective<&DescriptionBuilder::AttributeEnd>},
    {"Camera", Where::Options, &FileParser::PluginDirective<&DescriptionBuilder::Camera>},
    {"ColorSpace", Where::Anywhere, &FileParser::NameDirective<&DescriptionBuilder::SetColorSpace>},
    {"ConcatTransform", Where::Anywhere, &FileParser::ConcatTransform},
    {"CoordSysTransform", Where::Anywhere,
     &FileParser::NameDirective<&DescriptionBuilder::CoordSysTransform>},
    {"CoordinateSystem", Where::Anywhere, &FileParser::CoordinateSystem},
    {"Film", Where::Options, &FileParser::PluginDirective<&DescriptionBuilder::Film>},
    {"Identity", Where::Anywhere, &FileParser::Identity},
    {"Import", Where::World, &FileParser::Import},
    {"Include", Where::Anywhere, &FileParser::Include},
    {"Integrator", Where::Options, &FileParser::PluginDirective<&DescriptionBuilder::Integrator>},
    {"LightSource", Where::World, &FileParser::PluginDirective<&DescriptionBuilder::LightSource>},
    {"LookAt", Where::Anywhere, &FileParser::LookAt},
    {"MakeNamedMaterial", Where::World, &FileParser::MakeNamedMaterial},
    {"MakeNamedMedium", Where::Anywhere, &FileParser::MakeNamedMedium},
    {"Material", Where::World, &FileParser::PluginDirective<&DescriptionBuilder::Material>},
    {"MediumInterface", Where::Anywhere, &FileParser::MediumInterface},
    {"NamedMaterial", Where::World, &FileParser::NameDirective<&DescriptionBuilder::NamedMaterial>},
    {"ObjectBegin", Where::World, &FileParser::NameDirective<&DescriptionBuilder::ObjectBegin>},
    {"ObjectEnd", Where::World, &FileParser::PlainDirective<&DescriptionBuilder::ObjectEnd>},
    {"ObjectInstance", Where::World, &FileParser::NameDirective<&DescriptionBuilder::ObjectInstance>},
    {"Option", Where::Anywhere, &FileParser::Option},
    {"PixelFilter", Where::Options, &FileParser::PluginDirective<&DescriptionBuilder::PixelFilter>},
    {"ReverseOrientation", Where::World, &FileParser::ReverseOrientation},
    {"Rotate", Where::Anywhere, &FileParser::Rotate},
    {"Sampler", Where::Options, &FileParser::PluginDirective<&DescriptionBuilder::Sampler>},
    {"Scale", Where::Anywhere, &FileParser::Scale},
    {"Shape", Where::World, &FileParser::PluginDirective<&DescriptionBuilder::Shape>},
    {"Texture", Where::World, &FileParser::Texture},
    {"Transform", Where::Anywhere, &FileParser::SetTransform},
    {"TransformBegin", Where::World, &FileParser::TransformBegin},
    {"TransformEnd", Where::World, &FileParser::TransformEnd},
    {"TransformTimes", Where::Options, &FileParser::TransformTimes},
    {"Translate", Where::Anywhere, &FileParser::Translate},
    {"WorldBegin", Where::Options, &FileParser::WorldBegin},
};

const FileParser::Directive* FileParser::Find(std::string_view name) {
    const auto* found = std::lower_bound(std::begin(kDirectives), std::end(kDirectives), name,
                                         [](const Directive& d, std::string_view n) { return d.name < n; });
    return found != std::end(kDirectives) && found->name == name ? found : nullptr;
}

void FileParser::Run() {
    while (true) {
        try {
            const Token token = lexer_.Next();
            if (token.kind == Token::Kind::End) return;
            RunOne(token);
        } catch (const SceneError& e) {
            log_.Error(e.Loc(), e.Message());
            SkipToDirective();
        } catch (const FileError& e) {
            log_.Error(e);
        }
    }
}

void FileParser::RunOne(const Token& token) {
    const Directive* directive = token.kind == Token::Kind::Word ? Find(token.text) : nullptr;
    if (!directive) {
        Unknown(token);
        SkipToDirective();
        return;
    }
    name_ = directive->name;
    loc_ = token.Loc();
    if (CheckPlace(*directive))
        (this->*directive->run)();
    else
        SkipToDirective();
}

void FileParser::Unknown(const Token& token) {
    const std::string text(token.text.substr(0, 100));
    if (token.kind != Token::Kind::Word) {
        log_.Error(token.Loc(), fmt::format("expected a directive, found {}", token.Excerpt()));
        return;
    }
    if (const auto advice = V3Directive(text)) {
        log_.V3(token.Loc(), fmt::format("the directive {}", text), *advice);
        return;
    }
    std::vector<std::string> names;
    for (const Directive& d : kDirectives) names.emplace_back(d.name);
    // What an unknown directive would have defined or begun is missing from here on.
    log_.MarkIncomplete();
    if (NearestName(text, names) == "WorldBegin") saidOutsideWorld_ = true;
    log_.Error(token.Loc(), fmt::format("unknown directive {}{}", token.Excerpt(), DidYouMean(text, names)));
}

// After an error: everything up to the next known directive is its consequence.
void FileParser::SkipToDirective() {
    while (true) {
        try {
            const Token& token = lexer_.Peek();
            const bool isWord = token.kind == Token::Kind::Word;
            if (token.kind == Token::Kind::End || (isWord && (Find(token.text) || V3Directive(token.text))))
                return;
            lexer_.Next();
        } catch (const SceneError& e) {
            log_.Error(e.Loc(), e.Message());
        }
    }
}

// True if the directive may stand here. The first directive before WorldBegin speaks for all that follow it.
bool FileParser::CheckPlace(const Directive& directive) {
    const bool inWorld = builder_.InWorld();
    if (directive.where == Where::Options && inWorld) {
        const char* place = open_.importers.empty() ? "after WorldBegin" : "in an imported file";
        log_.Error(loc_, fmt::format("{} is not allowed {}", directive.name, place));
        return false;
    }
    if (directive.where == Where::World && !inWorld && !saidOutsideWorld_) {
        saidOutsideWorld_ = true;
        log_.Error(loc_, fmt::format("{} is not allowed before WorldBegin", directive.name));
    }
    return true;
}

Token FileParser::Argument(const char* wanted) {
    const Token token = lexer_.Next();
    if (token.kind == Token::Kind::End)
        throw SceneError(loc_, fmt::format("{}: the file ends where {} is expected", name_, wanted));
    return token;
}

std::string FileParser::String(const char* wanted) {
    const Token token = Argument(wanted);
    if (token.kind != Token::Kind::String)
        throw SceneError(token.Loc(),
                         fmt::format("{}: expected {} in quotes, found {}", name_, wanted, token.Excerpt()));
    return std::string(token.text);
}

float FileParser::ToFloat(const Token& token) const {
    try {
        return ExpectFloat(token);
    } catch (const SceneError& e) {
        throw SceneError(e.Loc(), fmt::format("{}: {}", name_, e.Message()));
    }
}

Vec3 FileParser::Triple() {
    const float x = Number(), y = Number(), z = Number();
    return {x, y, z};
}

// Column by column, as GLM stores it.
glm::mat4 FileParser::Matrix() {
    const Token open = Argument("[");
    if (open.kind != Token::Kind::Open)
        throw SceneError(open.Loc(),
                         fmt::format("{}: expected [ and 16 numbers, found {}", name_, open.Excerpt()));
    glm::mat4 m;
    for (int i = 0; i < 16; ++i) {
        const Token number = Argument("a number");
        if (number.kind == Token::Kind::Close)
            throw SceneError(number.Loc(), fmt::format("{}: a matrix has 16 numbers, not {}", name_, i));
        m[i / 4][i % 4] = ToFloat(number);
    }
    const Token close = Argument("]");
    if (close.kind != Token::Kind::Close)
        throw SceneError(close.Loc(),
                         fmt::format("{}: expected ] after 16 numbers, found {}", name_, close.Excerpt()));
    return m;
}

std::vector<Parameter> FileParser::Parameters(const char* directive, std::string_view plugin) {
    std::vector<Parameter> parameters = ReadParameters(lexer_, builder_.CurrentColorSpace(), log_);
    const bool isV3Plugin = V3Plugin(directive, plugin).has_value();
    if (isV3Plugin || plugin == "interface") return parameters;
    for (const Parameter& p : parameters)
        if (const auto advice = V3Parameter(directive, plugin, p.type, p.name))
            log_.V3(p.loc, fmt::format("\"{} {}\"", p.type, p.name), *advice);
    return parameters;
}

PluginEntity FileParser::Plugin(const char* directive) {
    const FileLoc loc = loc_;
    std::string type = String("a type");
    if (const auto advice = V3Plugin(directive, type))
        log_.V3(loc, fmt::format("{} \"{}\"", directive, type), *advice);
    std::vector<Parameter> parameters = Parameters(directive, type);
    return builder_.MakeEntity(std::move(type), loc, std::move(parameters));
}

// The parameters of MakeNamedMaterial and MakeNamedMedium, whose type is one of them.
PluginEntity FileParser::TypedLater(const char* directive) {
    std::vector<Parameter> parameters = ReadParameters(lexer_, builder_.CurrentColorSpace(), log_);
    std::string type;
    for (const Parameter& p : parameters)
        if (p.type == "string" && p.name == "type" && p.strings.size() == 1) type = p.strings[0];
    const auto pluginAdvice = V3Plugin(directive, type);
    if (pluginAdvice) log_.V3(loc_, fmt::format("the {} type \"{}\"", directive, type), *pluginAdvice);
    for (const Parameter& p : parameters)
        if (const auto advice = V3Parameter(directive, type, p.type, p.name); advice && !pluginAdvice)
            log_.V3(p.loc, fmt::format("\"{} {}\"", p.type, p.name), *advice);
    return builder_.MakeEntity({}, loc_, std::move(parameters));
}

}  // namespace lacquer
