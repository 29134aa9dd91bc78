// Reads the directives of one text, and of what it includes.
#pragma once

#include <string>
#include <vector>

#include "pbrt/scene/description_builder.h"
#include "pbrt/scene/directive.h"
#include "pbrt/scene/lexer.h"

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

    // For the directives.
    ParseContext& Context() { return context_; }
    DescriptionBuilder& Builder() { return builder_; }
    ParseLog& Log() { return log_; }
    /// Of the directive in progress.
    const FileLoc& Loc() const { return loc_; }
    /// A plugin of the directive in progress; takes its parameters out of `arguments`.
    PluginEntity Entity(std::string type, DirectiveArguments& arguments) const;
    /// Goes on with another file, and then behind the directive.
    void Include(const std::string& path);
    /// Reads another file with a state of its own.
    void Import(const std::string& path);

  private:
    void RunOne(const Token& token);
    void Unknown(const Token& token, const Directive* ofV3);
    void SkipToDirective();
    bool CheckPlace(const Directive& directive);
    void ReadArguments(const Directive& directive);
    void CheckParameters(const Directive& directive, std::string type);
    Source OpenNamed(const std::string& path);

    ParseContext& context_;
    ParseLog& log_;
    DescriptionBuilder& builder_;
    Lexer lexer_;
    OpenFiles open_;
    std::string_view name_;  // of the directive in progress, its place and what follows it
    FileLoc loc_;
    DirectiveArguments arguments_;
    bool saidOutsideWorld_ = false;
};

}  // namespace lacquer
