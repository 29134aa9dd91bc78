#include "pbrt/scene/parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "pbrt/scene/description_builder.h"
#include "pbrt/scene/lexer.h"
#include "pbrt/scene/option_directive.h"
#include "pbrt/scene/parameter_list.h"
#include "pbrt/scene/v3.h"

namespace lacquer {

namespace {

constexpr size_t kDeepestInclude = 64, kMostFiles = 100000;

/// Files that are being read, from the top-level one to the one that imports this one.
struct OpenFiles {
    std::vector<std::string> importers;  ///< keys
    size_t* numFiles = nullptr;          ///< opened so far, for all files of the scene
};

/// Reads the directives of one text, and of what it includes, and carries them out.
class Parser {
  public:
    Parser(ParseContext& context, DescriptionBuilder& builder, Source source, OpenFiles open)
        : context_(context), log_(context.log), builder_(builder), lexer_(std::move(source)), open_(std::move(open)) {}
    void Run();

  private:
    enum class Where { Options, World, Anywhere };
    struct Directive {
        const char* name;
        Where where;
        void (Parser::*run)();
    };
    static const Directive kDirectives[];
    static const Directive* Find(std::string_view name);

    void RunOne(const Token& token);
    void Unknown(const Token& token);
    void SkipToDirective();
    bool CheckPlace(const Directive& directive);

    // Arguments.
    Token Argument(const char* wanted);
    std::string String(const char* wanted);
    float Number() { return ExpectFloat(Argument("a number")); }
    Vec3 Triple();
    glm::mat4 Matrix();
    /// The parameters that follow; `plugin` is the type that they go to.
    std::vector<Parameter> Parameters(const char* directive, std::string_view plugin);
    PluginEntity Plugin(const char* directive);
    PluginEntity TypedLater(const char* directive);
    Source OpenNamed(const std::string& path);

    // One function for each directive that needs more than a line.
    template <void (DescriptionBuilder::*method)(PluginEntity)>
    void PluginDirective() {
        (builder_.*method)(Plugin(name_));
    }
    template <void (DescriptionBuilder::*method)(const FileLoc&)>
    void PlainDirective() {
        (builder_.*method)(loc_);
    }
    template <void (DescriptionBuilder::*method)(const std::string&, const FileLoc&)>
    void NameDirective() {
        (builder_.*method)(String("a name"), loc_);
    }
    void ActiveTransform();
    void Attribute();
    void ConcatTransform() { builder_.ConcatTransform(Transform(Matrix()), loc_); }
    void CoordinateSystem() { builder_.CoordinateSystem(String("a name")); }
    void Identity() { builder_.SetTransform({}, loc_); }
    void Import();
    void Include();
    void LookAt();
    void MakeNamedMaterial();
    void MakeNamedMedium();
    void MediumInterface();
    void Option();
    void ReverseOrientation() { builder_.ReverseOrientation(); }
    void Rotate();
    void Scale() { builder_.ConcatTransform(Transform::Scale(Triple()), loc_); }
    void SetTransform() { builder_.SetTransform(Transform(Matrix()), loc_); }
    void Texture();
    void TransformBegin();
    void TransformEnd();
    void TransformTimes();
    void Translate() { builder_.ConcatTransform(Transform::Translate(Triple()), loc_); }
    void WorldBegin() { builder_.WorldBegin(); }

    ParseContext& context_;
    ParseLog& log_;
    DescriptionBuilder& builder_;
    Lexer lexer_;
    OpenFiles open_;
    const char* name_ = "";  // of the directive in progress, and its place
    FileLoc loc_;
    bool saidOutsideWorld_ = false;
};

/// Sorted by name.
const Parser::Directive Parser::kDirectives[] = {
    {"Accelerator", Where::Options, &Parser::PluginDirective<&DescriptionBuilder::Accelerator>},
    {"ActiveTransform", Where::Anywhere, &Parser::ActiveTransform},
    {"AreaLightSource", Where::World, &Parser::PluginDirective<&DescriptionBuilder::AreaLightSource>},
    {"Attribute", Where::Anywhere, &Parser::Attribute},
    {"AttributeBegin", Where::World, &Parser::PlainDirective<&DescriptionBuilder::AttributeBegin>},
    {"AttributeEnd", Where::World, &Parser::PlainDirective<&DescriptionBuilder::AttributeEnd>},
    {"Camera", Where::Options, &Parser::PluginDirective<&DescriptionBuilder::Camera>},
    {"ColorSpace", Where::Anywhere, &Parser::NameDirective<&DescriptionBuilder::SetColorSpace>},
    {"ConcatTransform", Where::Anywhere, &Parser::ConcatTransform},
    {"CoordSysTransform", Where::Anywhere, &Parser::NameDirective<&DescriptionBuilder::CoordSysTransform>},
    {"CoordinateSystem", Where::Anywhere, &Parser::CoordinateSystem},
    {"Film", Where::Options, &Parser::PluginDirective<&DescriptionBuilder::Film>},
    {"Identity", Where::Anywhere, &Parser::Identity},
    {"Import", Where::World, &Parser::Import},
    {"Include", Where::Anywhere, &Parser::Include},
    {"Integrator", Where::Options, &Parser::PluginDirective<&DescriptionBuilder::Integrator>},
    {"LightSource", Where::World, &Parser::PluginDirective<&DescriptionBuilder::LightSource>},
    {"LookAt", Where::Anywhere, &Parser::LookAt},
    {"MakeNamedMaterial", Where::World, &Parser::MakeNamedMaterial},
    {"MakeNamedMedium", Where::Anywhere, &Parser::MakeNamedMedium},
    {"Material", Where::World, &Parser::PluginDirective<&DescriptionBuilder::Material>},
    {"MediumInterface", Where::Anywhere, &Parser::MediumInterface},
    {"NamedMaterial", Where::World, &Parser::NameDirective<&DescriptionBuilder::NamedMaterial>},
    {"ObjectBegin", Where::World, &Parser::NameDirective<&DescriptionBuilder::ObjectBegin>},
    {"ObjectEnd", Where::World, &Parser::PlainDirective<&DescriptionBuilder::ObjectEnd>},
    {"ObjectInstance", Where::World, &Parser::NameDirective<&DescriptionBuilder::ObjectInstance>},
    {"Option", Where::Anywhere, &Parser::Option},
    {"PixelFilter", Where::Options, &Parser::PluginDirective<&DescriptionBuilder::PixelFilter>},
    {"ReverseOrientation", Where::World, &Parser::ReverseOrientation},
    {"Rotate", Where::Anywhere, &Parser::Rotate},
    {"Sampler", Where::Options, &Parser::PluginDirective<&DescriptionBuilder::Sampler>},
    {"Scale", Where::Anywhere, &Parser::Scale},
    {"Shape", Where::World, &Parser::PluginDirective<&DescriptionBuilder::Shape>},
    {"Texture", Where::World, &Parser::Texture},
    {"Transform", Where::Anywhere, &Parser::SetTransform},
    {"TransformBegin", Where::World, &Parser::TransformBegin},
    {"TransformEnd", Where::World, &Parser::TransformEnd},
    {"TransformTimes", Where::Options, &Parser::TransformTimes},
    {"Translate", Where::Anywhere, &Parser::Translate},
    {"WorldBegin", Where::Options, &Parser::WorldBegin},
};

const Parser::Directive* Parser::Find(std::string_view name) {
    const auto* found = std::lower_bound(std::begin(kDirectives), std::end(kDirectives), name,
                                         [](const Directive& d, std::string_view n) { return d.name < n; });
    return found != std::end(kDirectives) && found->name == name ? found : nullptr;
}

void Parser::Run() {
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

void Parser::RunOne(const Token& token) {
    const Directive* directive = token.kind == Token::Kind::Word ? Find(token.text) : nullptr;
    if (!directive) {
        Unknown(token);
        SkipToDirective();
        return;
    }
    name_ = directive->name;
    loc_ = token.Loc();
    if (CheckPlace(*directive)) (this->*directive->run)();
    else SkipToDirective();
}

void Parser::Unknown(const Token& token) {
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
void Parser::SkipToDirective() {
    while (true) {
        try {
            const Token& token = lexer_.Peek();
            const bool isWord = token.kind == Token::Kind::Word;
            if (token.kind == Token::Kind::End || (isWord && (Find(token.text) || V3Directive(token.text)))) return;
            lexer_.Next();
        } catch (const SceneError& e) {
            log_.Error(e.Loc(), e.Message());
        }
    }
}

// True if the directive may stand here. The first directive before WorldBegin speaks for all that follow it.
bool Parser::CheckPlace(const Directive& directive) {
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

Token Parser::Argument(const char* wanted) {
    const Token token = lexer_.Next();
    if (token.kind == Token::Kind::End)
        throw SceneError(loc_, fmt::format("{}: the file ends where {} is expected", name_, wanted));
    return token;
}

std::string Parser::String(const char* wanted) {
    const Token token = Argument(wanted);
    if (token.kind != Token::Kind::String)
        throw SceneError(token.Loc(), fmt::format("{}: expected {} in quotes, found {}", name_, wanted, token.Excerpt()));
    return std::string(token.text);
}

Vec3 Parser::Triple() {
    const float x = Number(), y = Number(), z = Number();
    return {x, y, z};
}

// Column by column, as GLM stores it.
glm::mat4 Parser::Matrix() {
    const Token open = Argument("[");
    if (open.kind != Token::Kind::Open)
        throw SceneError(open.Loc(), fmt::format("{}: expected [ and 16 numbers, found {}", name_, open.Excerpt()));
    glm::mat4 m;
    for (int i = 0; i < 16; ++i) {
        const Token number = Argument("a number");
        if (number.kind == Token::Kind::Close)
            throw SceneError(number.Loc(), fmt::format("{}: a matrix has 16 numbers, not {}", name_, i));
        m[i / 4][i % 4] = ExpectFloat(number);
    }
    const Token close = Argument("]");
    if (close.kind != Token::Kind::Close)
        throw SceneError(close.Loc(), fmt::format("{}: expected ] after 16 numbers, found {}", name_, close.Excerpt()));
    return m;
}

std::vector<Parameter> Parser::Parameters(const char* directive, std::string_view plugin) {
    std::vector<Parameter> parameters = ReadParameters(lexer_, builder_.CurrentColorSpace(), log_);
    const bool isV3Plugin = V3Plugin(directive, plugin).has_value();
    if (isV3Plugin || plugin == "interface") return parameters;
    for (const Parameter& p : parameters)
        if (const auto advice = V3Parameter(directive, plugin, p.type, p.name))
            log_.V3(p.loc, fmt::format("\"{} {}\"", p.type, p.name), *advice);
    return parameters;
}

PluginEntity Parser::Plugin(const char* directive) {
    const FileLoc loc = loc_;
    std::string type = String("a type");
    if (const auto advice = V3Plugin(directive, type)) log_.V3(loc, fmt::format("{} \"{}\"", directive, type), *advice);
    std::vector<Parameter> parameters = Parameters(directive, type);
    return builder_.MakeEntity(std::move(type), loc, std::move(parameters));
}

// The parameters of MakeNamedMaterial and MakeNamedMedium, whose type is one of them.
PluginEntity Parser::TypedLater(const char* directive) {
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

void Parser::ActiveTransform() {
    const Token token = Argument("All, StartTime or EndTime");
    if (token.text == "All") return builder_.ActiveTransform(true, true);
    if (token.text == "StartTime") return builder_.ActiveTransform(true, false);
    if (token.text == "EndTime") return builder_.ActiveTransform(false, true);
    throw SceneError(token.Loc(), fmt::format("ActiveTransform: expected All, StartTime or EndTime, found {}",
                                              token.Excerpt()));
}

void Parser::Attribute() {
    const std::string target = String("a target");
    std::vector<Parameter> parameters = Parameters("", "");
    const auto found = std::find(kAttributeTargets.begin(), kAttributeTargets.end(), target);
    if (found == kAttributeTargets.end()) {
        const std::vector<std::string> names(kAttributeTargets.begin(), kAttributeTargets.end());
        throw SceneError(loc_, fmt::format("Attribute: unknown target \"{}\"; known are shape, light, material, medium "
                                           "and texture{}",
                                           Excerpt(target), DidYouMean(target, names)));
    }
    builder_.Attribute(AttributeTarget(found - kAttributeTargets.begin()), std::move(parameters));
}

// Reads a file that a directive names, or says why that cannot be.
Source Parser::OpenNamed(const std::string& path) {
    if (lexer_.Depth() + open_.importers.size() >= kDeepestInclude)
        throw SceneError(loc_, fmt::format("{} \"{}\": more than {} files deep", name_, Excerpt(path), kDeepestInclude));
    if (++*open_.numFiles > kMostFiles)
        throw SceneError(loc_, fmt::format("{} \"{}\": more than {} files", name_, Excerpt(path), kMostFiles));
    const std::string resolved = context_.scene.resolvers[size_t(context_.directory)].Resolve(path);
    std::error_code ignored;
    const std::string key = std::filesystem::weakly_canonical(resolved, ignored).string();
    const auto& importers = open_.importers;
    if (!key.empty() && (lexer_.IsOpen(key) || std::find(importers.begin(), importers.end(), key) != importers.end()))
        throw SceneError(loc_, fmt::format("{} \"{}\": the file includes itself", name_, Excerpt(path)));
    try {
        return ReadSource(resolved);
    } catch (const FileError& e) {
        throw FileError(path, fmt::format("{} cannot read it: {}", name_, e.Message().substr(e.Path().size() + 2)), loc_);
    }
}

void Parser::Include() { lexer_.Push(OpenNamed(String("a file name"))); }

void Parser::Import() {
    Source source = OpenNamed(String("a file name"));
    OpenFiles open = open_;
    lexer_.AppendOpen(&open.importers);
    DescriptionBuilder builder(builder_, builder_.AddImport());
    Parser(context_, builder, std::move(source), std::move(open)).Run();
    builder.FinishFile();
    builder.FinishScopes();
}

void Parser::LookAt() {
    const Vec3 eye = Triple(), look = Triple(), up = Triple();
    bool isValid = false;
    const Transform cameraFromWorld = Transform::LookAt(eye, look, up, &isValid);
    if (!isValid)
        throw SceneError(loc_, "LookAt: the eye and the point looked at must differ, and up must not be parallel to "
                               "the view direction");
    builder_.ConcatTransform(cameraFromWorld, loc_);
}

void Parser::MakeNamedMaterial() {
    const std::string name = String("a name");
    context_.declaredMaterials.insert(name);
    builder_.MakeNamedMaterial(name, TypedLater("Material"));
}

void Parser::MakeNamedMedium() {
    const std::string name = String("a name");
    context_.declaredMedia.insert(name);
    builder_.MakeNamedMedium(name, TypedLater("Medium"));
}

void Parser::MediumInterface() {
    const std::string inside = String("a medium");
    const std::string outside = lexer_.Peek().kind == Token::Kind::String ? String("a medium") : inside;
    builder_.MediumInterface(inside, outside, loc_);
}

void Parser::Option() {
    const Token name = Argument("an option");
    if (name.kind != Token::Kind::String)
        throw SceneError(name.Loc(), fmt::format("Option: expected a name in quotes, found {}", name.Excerpt()));
    const std::string text(name.text);
    SetOption(text, Argument("a value"), loc_, &context_.scene.options);
}

void Parser::Rotate() {
    const float angle = Number();
    const Vec3 axis = Triple();
    if (axis == Vec3(0)) throw SceneError(loc_, "Rotate: the axis is zero");
    builder_.ConcatTransform(Transform::Rotate(angle, axis), loc_);
}

void Parser::Texture() {
    const std::string name = String("a name"), valueType = String("\"float\" or \"spectrum\"");
    const bool isSpectrum = valueType == "spectrum";
    const FileLoc loc = loc_;
    PluginEntity entity = Plugin("Texture");
    if (!isSpectrum && valueType != "float") {
        const auto advice = V3TextureType(valueType);
        if (!advice)
            throw SceneError(loc, fmt::format("texture \"{}\": the value type must be \"float\" or \"spectrum\", not \"{}\"",
                                              Excerpt(name), Excerpt(valueType)));
        log_.V3(loc, fmt::format("the texture type \"{}\"", valueType), *advice);
        return;
    }
    builder_.Texture(name, isSpectrum, std::move(entity));
}

void Parser::TransformBegin() {
    log_.Warn(loc_, "TransformBegin and TransformEnd are deprecated, and mean AttributeBegin and AttributeEnd");
    builder_.AttributeBegin(loc_);
}

void Parser::TransformEnd() { builder_.AttributeEnd(loc_); }

void Parser::TransformTimes() {
    const float start = Number(), end = Number();
    builder_.TransformTimes(start, end, loc_);
}

/// A scene in the making, fed one top-level text after the other.
class SceneParse {
  public:
    explicit SceneParse(Observer* observer)
        : log_(observer), context_{scene_, log_, {}, {}, {}, {}, {}, {}, 0}, builder_(context_) {
        scene_.resolvers.clear();
    }
    void Add(Source source, const std::string& directory) {
        context_.directory = int(scene_.resolvers.size());
        scene_.resolvers.emplace_back(directory);
        last_ = source.name;
        Parser(context_, builder_, std::move(source), {{}, &numFiles_}).Run();
        builder_.FinishFile();
    }
    SceneDescription Finish() {
        builder_.FinishScopes();
        if (!builder_.InWorld() && log_.Errors().empty()) log_.Error({last_, 0, 0}, "the scene has no WorldBegin");
        if (!log_.IsIncomplete()) builder_.CheckReferences();
        return Result();
    }
    /// What there is, or everything that is wrong with it.
    SceneDescription Result() {
        log_.ThrowIfErrors();
        scene_.warnings = log_.Warnings();
        return std::move(scene_);
    }

  private:
    SceneDescription scene_;
    ParseLog log_;
    ParseContext context_;
    DescriptionBuilder builder_;
    std::string last_;
    size_t numFiles_ = 0;
};

// Runs `feed` on a new scene; too many errors end it early.
SceneDescription Parse(Observer* observer, const std::function<void(SceneParse&)>& feed) {
    SceneParse parse(observer);
    try {
        feed(parse);
        return parse.Finish();
    } catch (const TooManyErrors&) {
        return parse.Result();
    }
}

// Reads a top-level file; a wrong encoding is reported as the parse's errors are.
Source OpenTopLevel(const std::string& path) {
    try {
        return ReadSource(path);
    } catch (const SceneError& e) {
        throw SceneErrors({{Diagnostic::Severity::Error, e.Loc(), e.Message()}});
    }
}

std::string DirectoryOf(const std::string& path) {
    const std::string parent = std::filesystem::path(path).parent_path().string();
    return parent.empty() ? "." : parent;
}

}  // namespace

SceneDescription ParseFiles(const std::vector<std::string>& paths, Observer* observer) {
    return Parse(observer, [&](SceneParse& parse) {
        for (const std::string& path : paths) parse.Add(OpenTopLevel(path), DirectoryOf(path));
    });
}

SceneDescription ParseFile(const std::string& path, Observer* observer) { return ParseFiles({path}, observer); }

SceneDescription ParseText(std::string text, std::string name, std::string directory, Observer* observer) {
    return Parse(observer, [&](SceneParse& parse) {
        Source source{std::move(name), std::move(text), {}};
        try {
            RejectByteOrderMark(source);
        } catch (const SceneError& e) {
            throw SceneErrors({{Diagnostic::Severity::Error, e.Loc(), e.Message()}});
        }
        parse.Add(std::move(source), directory);
    });
}

}  // namespace lacquer
