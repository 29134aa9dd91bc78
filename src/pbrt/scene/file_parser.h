// Reads the directives of one text, and of what it includes.
#pragma once

#include <string>
#include <vector>

#include "pbrt/scene/description_builder.h"
#include "pbrt/scene/lexer.h"
#include "pbrt/scene/parameter_list.h"

namespace lacquer {

/// Files that are being read, from the top-level one to the one that imports this one.
struct OpenFiles {
    std::vector<std::string> importers;  ///< keys
    size_t* numFiles = nullptr;          ///< opened so far, for all files of the scene
};

/// Reads the directives of one text, and of what it includes, and carries them out.
class FileParser {
  public:
    FileParser(ParseContext& context, DescriptionBuilder& builder, Source source, OpenFiles open)
        : context_(context),
          log_(context.log),
          builder_(builder),
          lexer_(std::move(source)),
          open_(std::move(open)) {}
    void Run();

  private:
    enum class Where { Options, World, Anywhere };
    struct Directive {
        const char* name;
        Where where;
        void (FileParser::*run)();
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
    float Number() { return ToFloat(Argument("a number")); }
    float ToFloat(const Token& token) const;
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

}  // namespace lacquer
