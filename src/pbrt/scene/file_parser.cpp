#include "pbrt/scene/file_parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "pbrt/scene/parameter_list.h"
#include "pbrt/scene/v3.h"

namespace lacquer {

namespace {

constexpr size_t kDeepestInclude = 64, kMaxFiles = 100000;

}  // namespace

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
    const Directive* directive = token.kind == Token::Kind::Word ? FindDirective(token.text) : nullptr;
    if (!directive || !directive->run) {
        Unknown(token, directive);
        SkipToDirective();
        return;
    }
    name_ = directive->name;
    loc_ = token.Loc();
    if (!CheckPlace(*directive)) return SkipToDirective();
    ReadArguments(*directive);
    directive->run(*this, arguments_);
}

void FileParser::Unknown(const Token& token, const Directive* ofV3) {
    const std::string text(token.text.substr(0, 100));
    if (token.kind != Token::Kind::Word) {
        log_.Error(token.Loc(), fmt::format("expected a directive, found {}", token.Excerpt()));
        return;
    }
    if (ofV3) {
        log_.V3(token.Loc(), fmt::format("the directive {}", text), ofV3->advice);
        return;
    }
    // What an unknown directive would have defined or begun is missing from here on.
    log_.MarkIncomplete();
    const std::vector<std::string> names = DirectiveNames();
    if (NearestName(text, names) == "WorldBegin") saidOutsideWorld_ = true;
    log_.Error(token.Loc(), fmt::format("unknown directive {}{}", token.Excerpt(), DidYouMean(text, names)));
}

// After an error: everything up to the next known directive is its consequence.
void FileParser::SkipToDirective() {
    while (true) {
        try {
            const Token& token = lexer_.Peek();
            const bool isWord = token.kind == Token::Kind::Word;
            if (token.kind == Token::Kind::End || (isWord && FindDirective(token.text))) return;
            lexer_.Next();
        } catch (const SceneError& e) {
            log_.Error(e.Loc(), e.Message());
        }
    }
}

// True if the directive may stand here. The first directive before WorldBegin speaks for all that follow it.
bool FileParser::CheckPlace(const Directive& directive) {
    const bool inWorld = builder_.InWorld();
    if (directive.where == Directive::Where::Options && inWorld) {
        const char* place = open_.importers.empty() ? "after WorldBegin" : "in an imported file";
        log_.Error(loc_, fmt::format("{} is not allowed {}", directive.name, place));
        return false;
    }
    if (directive.where == Directive::Where::World && !inWorld && !saidOutsideWorld_) {
        saidOutsideWorld_ = true;
        log_.Error(loc_, fmt::format("{} is not allowed before WorldBegin", directive.name));
    }
    return true;
}

void FileParser::ReadArguments(const Directive& directive) {
    size_t numTexts = 0, numNumbers = 0;
    std::string type;
    for (const Argument argument : directive.arguments) {
        const ArgumentForm& form = FormOf(argument);
        if (form.isOptional && lexer_.Peek().kind != Token::Kind::String) {
            arguments_.texts[numTexts] = arguments_.texts[numTexts - 1];
            continue;
        }
        for (size_t i = 0; i < form.numTokens; ++i) {
            const Token token = lexer_.Next();
            if (token.kind == Token::Kind::End) FailAtEnd(name_, argument, i, loc_);
            const float number = CheckToken(name_, argument, i, token);
            if (argument == Argument::Value)
                arguments_.value = token;
            else if (!form.isNumber)
                arguments_.texts[numTexts++] = token.text;
            else if (!form.isBracketed || (i > 0 && i + 1 < form.numTokens))
                arguments_.numbers[numNumbers++] = number;
        }
        if (argument == Argument::NewMaterial) context_.declaredMaterials.insert(arguments_.texts[0]);
        if (argument == Argument::NewMedium) context_.declaredMedia.insert(arguments_.texts[0]);
        if (argument == Argument::Type) {
            type = arguments_.texts[numTexts - 1];
            if (const auto advice = V3Plugin(directive.Plugin(), type))
                log_.V3(loc_, fmt::format("{} \"{}\"", name_, type), *advice);
        }
        if (argument == Argument::Parameters) {
            arguments_.parameters = ReadParameters(lexer_, builder_.CurrentColorSpace(), log_);
            CheckParameters(directive, type);
        }
    }
}

// Says what is spelled as in pbrt-v3. @param type  that stands before the parameters, or else is one of them
void FileParser::CheckParameters(const Directive& directive, std::string type) {
    const std::string_view plugin = directive.Plugin();
    if (plugin.empty()) return;
    const bool isParameter = !directive.Has(Argument::Type);
    if (isParameter)
        for (const Parameter& p : arguments_.parameters)
            if (p.type == "string" && p.name == "type" && p.strings.size() == 1) type = p.strings[0];
    const auto ofPlugin = V3Plugin(plugin, type);
    if (ofPlugin && isParameter) log_.V3(loc_, fmt::format("the {} type \"{}\"", plugin, type), *ofPlugin);
    // The surface that is not there keeps what other materials left behind.
    if (ofPlugin || type == "interface") return;
    for (const Parameter& p : arguments_.parameters)
        if (const auto advice = V3Parameter(plugin, type, p.type, p.name))
            log_.V3(p.loc, fmt::format("\"{} {}\"", p.type, p.name), *advice);
}

PluginEntity FileParser::Entity(std::string type, DirectiveArguments& arguments) const {
    return builder_.MakeEntity(std::move(type), loc_, std::move(arguments.parameters));
}

// Reads a file that a directive names, or says why that cannot be.
Source FileParser::OpenNamed(const std::string& path) {
    if (lexer_.Depth() + open_.importers.size() >= kDeepestInclude)
        throw SceneError(
            loc_, fmt::format("{} \"{}\": more than {} files deep", name_, Excerpt(path), kDeepestInclude));
    if (++*open_.numFiles > kMaxFiles)
        log_.Fatal(loc_, fmt::format("{} \"{}\": more than {} files", name_, Excerpt(path), kMaxFiles));
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

void FileParser::Include(const std::string& path) { lexer_.Push(OpenNamed(path)); }

void FileParser::Import(const std::string& path) {
    Source source = OpenNamed(path);
    OpenFiles open = open_;
    lexer_.AppendOpen(&open.importers);
    DescriptionBuilder builder(builder_, builder_.AddImport());
    FileParser(context_, builder, std::move(source), std::move(open)).Run();
    builder.FinishFile();
    builder.FinishScopes();
}

}  // namespace lacquer
