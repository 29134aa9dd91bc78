// What each directive reads and does, in alphabetical order, for those that need more than a line.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "pbrt/scene/file_parser.h"
#include "pbrt/scene/option_directive.h"
#include "pbrt/scene/parameter_list.h"
#include "pbrt/scene/v3.h"

namespace lacquer {

namespace {

constexpr size_t kDeepestInclude = 64, kMostFiles = 100000;

}  // namespace

void FileParser::ActiveTransform() {
    const Token token = Argument("All, StartTime or EndTime");
    if (token.text == "All") return builder_.ActiveTransform(true, true);
    if (token.text == "StartTime") return builder_.ActiveTransform(true, false);
    if (token.text == "EndTime") return builder_.ActiveTransform(false, true);
    throw SceneError(token.Loc(), fmt::format("ActiveTransform: expected All, StartTime or EndTime, found {}",
                                              token.Excerpt()));
}

void FileParser::Attribute() {
    const std::string target = String("a target");
    std::vector<Parameter> parameters = Parameters("", "");
    const auto found = std::find(kAttributeTargets.begin(), kAttributeTargets.end(), target);
    if (found == kAttributeTargets.end()) {
        const std::vector<std::string> names(kAttributeTargets.begin(), kAttributeTargets.end());
        throw SceneError(
            loc_, fmt::format("Attribute: unknown target \"{}\"; known are shape, light, material, medium "
                              "and texture{}",
                              Excerpt(target), DidYouMean(target, names)));
    }
    builder_.Attribute(AttributeTarget(found - kAttributeTargets.begin()), std::move(parameters));
}

// Reads a file that a directive names, or says why that cannot be.
Source FileParser::OpenNamed(const std::string& path) {
    if (lexer_.Depth() + open_.importers.size() >= kDeepestInclude)
        throw SceneError(
            loc_, fmt::format("{} \"{}\": more than {} files deep", name_, Excerpt(path), kDeepestInclude));
    if (++*open_.numFiles > kMostFiles)
        log_.Fatal(loc_, fmt::format("{} \"{}\": more than {} files", name_, Excerpt(path), kMostFiles));
    const std::string resolved = context_.scene.resolvers[size_t(context_.directory)].Resolve(path);
    std::error_code ignored;
    const std::string key = std::filesystem::weakly_canonical(resolved, ignored).string();
    const auto& importers = open_.importers;
    if (!key.empty() &&
        (lexer_.IsOpen(key) || std::find(importers.begin(), importers.end(), key) != importers.end()))
        throw SceneError(loc_, fmt::format("{} \"{}\": the file includes itself", name_, Excerpt(path)));
    try {
        Source source = ReadSource(resolved, loc_);
        context_.scene.files.push_back(source.name);
        return source;
    } catch (const FileError& e) {
        throw FileError(path, fmt::format("{} (named by {})", e.Problem(), name_), loc_);
    } catch (const SceneError&) {
        log_.MarkIncomplete();
        throw;
    }
}

void FileParser::Include() { lexer_.Push(OpenNamed(String("a file name"))); }

void FileParser::Import() {
    Source source = OpenNamed(String("a file name"));
    OpenFiles open = open_;
    lexer_.AppendOpen(&open.importers);
    DescriptionBuilder builder(builder_, builder_.AddImport());
    FileParser(context_, builder, std::move(source), std::move(open)).Run();
    builder.FinishFile();
    builder.FinishScopes();
}

void FileParser::LookAt() {
    const Vec3 eye = Triple(), look = Triple(), up = Triple();
    bool isValid = false;
    const Transform cameraFromWorld = Transform::LookAt(eye, look, up, &isValid);
    if (!isValid)
        throw SceneError(
            loc_,
            "LookAt: the eye and the point looked at must differ, and up must not be parallel to "
            "the view direction");
    builder_.ConcatTransform(cameraFromWorld, loc_);
}

void FileParser::MakeNamedMaterial() {
    const std::string name = String("a name");
    context_.declaredMaterials.insert(name);
    builder_.MakeNamedMaterial(name, TypedLater("Material"));
}

void FileParser::MakeNamedMedium() {
    const std::string name = String("a name");
    context_.declaredMedia.insert(name);
    builder_.MakeNamedMedium(name, TypedLater("Medium"));
}

void FileParser::MediumInterface() {
    const std::string inside = String("a medium");
    const std::string outside = lexer_.Peek().kind == Token::Kind::String ? String("a medium") : inside;
    builder_.MediumInterface(inside, outside, loc_);
}

void FileParser::Option() {
    const Token name = Argument("an option");
    if (name.kind != Token::Kind::String)
        throw SceneError(name.Loc(),
                         fmt::format("Option: expected a name in quotes, found {}", name.Excerpt()));
    const std::string text(name.text);
    SetOption(text, Argument("a value"), loc_, &context_.scene.options);
}

void FileParser::Rotate() {
    const float angle = Number();
    const Vec3 axis = Triple();
    builder_.ConcatTransform(Transform::Rotate(angle, axis), loc_);
}

void FileParser::Texture() {
    const std::string name = String("a name"), valueType = String("\"float\" or \"spectrum\"");
    const bool isSpectrum = valueType == "spectrum";
    const FileLoc loc = loc_;
    PluginEntity entity = Plugin("Texture");
    if (!isSpectrum && valueType != "float") {
        const auto advice = V3TextureType(valueType);
        if (!advice)
            throw SceneError(
                loc,
                fmt::format("texture \"{}\": the value type must be \"float\" or \"spectrum\", not \"{}\"",
                            Excerpt(name), Excerpt(valueType)));
        log_.V3(loc, fmt::format("the texture type \"{}\"", valueType), *advice);
        return;
    }
    builder_.Texture(name, isSpectrum, std::move(entity));
}

void FileParser::TransformBegin() {
    log_.Warn(loc_,
              "TransformBegin and TransformEnd are deprecated, and mean AttributeBegin and AttributeEnd");
    builder_.AttributeBegin(loc_);
}

void FileParser::TransformEnd() { builder_.AttributeEnd(loc_); }

void FileParser::TransformTimes() {
    const float start = Number(), end = Number();
    builder_.TransformTimes(start, end, loc_);
}

}  // namespace lacquer
