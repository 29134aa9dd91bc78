#include "pbrt/scene/parser.h"

#include <filesystem>
#include <functional>

#include "pbrt/scene/file_parser.h"

namespace lacquer {

namespace {

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
        scene_.files.push_back(source.name);
        FileParser(context_, builder_, std::move(source), {{}, &numFiles_}).Run();
        builder_.FinishFile();
    }
    SceneDescription Finish() {
        builder_.FinishScopes();
        if (!builder_.InWorld() && log_.Errors().empty())
            log_.Error({last_, 0, 0}, "the scene has no WorldBegin");
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

// Runs `feed` on a new scene; hopeless ones end early.
SceneDescription Parse(Observer* observer, const std::function<void(SceneParse&)>& feed) {
    SceneParse parse(observer);
    try {
        feed(parse);
        return parse.Finish();
    } catch (const ParsingStops&) {
        return parse.Result();
    }
}

// Reads a top-level file; wrong contents are reported as the parse's errors are.
Source OpenTopLevel(const std::string& path) {
    try {
        return ReadSource(path);
    } catch (const SceneError& e) {
        throw SceneErrors({{Diagnostic::Severity::Error, e.Loc(), e.Message()}});
    }
}

// The same for a text from elsewhere.
Source TextOnly(Source source) {
    try {
        RejectOtherThanText(source);
    } catch (const SceneError& e) {
        throw SceneErrors({{Diagnostic::Severity::Error, e.Loc(), e.Message()}});
    }
    return source;
}

std::string DirectoryOf(const std::string& path) {
    const std::string parent = std::filesystem::path(path).parent_path().string();
    return parent.empty() ? "." : parent;
}

}  // namespace

SceneDescription ParseFiles(const std::vector<std::string>& paths, Observer* observer) {
    std::vector<SceneInput> inputs;
    for (const std::string& path : paths) inputs.push_back({path, std::nullopt});
    return ParseInputs(std::move(inputs), observer);
}

SceneDescription ParseInputs(std::vector<SceneInput> inputs, Observer* observer) {
    return Parse(observer, [&](SceneParse& parse) {
        for (SceneInput& input : inputs)
            if (input.text)
                parse.Add(TextOnly(SourceOf(std::move(input.name), *std::move(input.text))), "");
            else
                parse.Add(OpenTopLevel(input.name), DirectoryOf(input.name));
    });
}

SceneDescription ParseFile(const std::string& path, Observer* observer) {
    return ParseFiles({path}, observer);
}

SceneDescription ParseText(std::string text, std::string name, std::string directory, Observer* observer) {
    return Parse(observer, [&](SceneParse& parse) {
        parse.Add(TextOnly(SourceOf(std::move(name), std::move(text))), directory);
    });
}

}  // namespace lacquer
