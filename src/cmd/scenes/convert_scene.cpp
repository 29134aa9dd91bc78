#include "cmd/scenes/convert_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/scenes/scene_arguments.h"
#include "pbrt/image/image.h"
#include "pbrt/scene/directive.h"
#include "pbrt/scene/scene_to_ply.h"
#include "pbrt/scene/statements.h"
#include "pbrt/scene/v3_upgrade.h"

namespace lacquer::cmd {
namespace {

namespace fs = std::filesystem;

fs::path FolderOf(const std::string& path) {
    const fs::path folder = fs::path(path).parent_path();
    return folder.empty() ? fs::path(".") : folder;
}

/// "scene" of "folder/scene.pbrt.gz".
std::string StemOf(const std::string& path) {
    std::string name = fs::path(path).filename().string();
    for (const char* ending : {".gz", ".pbrt"})
        if (name.ends_with(ending)) name.resize(name.size() - std::string_view(ending).size());
    return name;
}

bool NamesSceneFile(const WrittenDirective& d) { return FindDirective(d.name)->Has(Argument::File); }

class ConvertSceneJob {
  public:
    explicit ConvertSceneJob(const ConvertArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        CheckArguments();
        SceneText scene = ReadSceneText(ReadInput());
        ExitStatus status = ExitStatus::Complete;
        if (a_.upgrade) status = ReportDiagnostics(UpgradeFromV3(&scene));
        if (a_.toPly) MoveMeshes(&scene);
        WarnOfOtherFolder(scene);
        const std::string text = WriteSceneText(scene);
        if (ToStandardOutput())
            fmt::print("{}", text);
        else
            WriteText(a_.output, text);
        return status;
    }

  private:
    bool FromStandardInput() const { return a_.input == "-"; }
    bool ToStandardOutput() const { return a_.output.empty() || a_.output == "-"; }
    /// Where the result will look for files with relative names.
    fs::path SceneFolder() const {
        if (!ToStandardOutput()) return FolderOf(a_.output);
        return FromStandardInput() ? fs::path(".") : FolderOf(a_.input);
    }
    fs::path MeshFolder() const { return a_.outDir.empty() ? SceneFolder() : fs::path(a_.outDir); }

    void CheckArguments() const {
        const bool isForImages = !a_.crop.empty() || !a_.resize.empty() || a_.exposure != 0 ||
                                 !a_.colorSpace.empty() || a_.toneMap != "none" || a_.half;
        if (isForImages)
            throw CLI::ValidationError(
                "--crop, --resize, --exposure, --colorspace, --tonemap and --half are for images, not for "
                "scenes");
        if (!a_.toPly && !a_.outDir.empty()) throw CLI::ValidationError("--outdir is for --toply");
        if (a_.minTriangles < 1)
            BadOption("min-triangles", std::to_string(a_.minTriangles), "a positive number");
        std::error_code error;
        if (!ToStandardOutput()) {
            if (CanWriteImage(a_.output))
                throw CLI::ValidationError(fmt::format(
                    "{}: the result is a scene, and this is the name of an image", Excerpt(a_.output)));
            if (a_.output.ends_with(".gz"))
                throw CLI::ValidationError(fmt::format(
                    "{}: the scene is written as plain text, not as gzip data", Excerpt(a_.output)));
            if (!FromStandardInput() && fs::equivalent(a_.input, a_.output, error))
                throw FileError(a_.output,
                                "is the input file, which is never overwritten; write to another one");
            if (!fs::is_directory(SceneFolder(), error))
                throw FileError(a_.output, "its folder does not exist");
        }
        if (!a_.outDir.empty()) CheckOutputFolder(a_.outDir);
    }

    Source ReadInput() const {
        if (!FromStandardInput()) return ReadSource(a_.input);
        std::vector<SceneInput> inputs = ReadSceneArguments({a_.input});
        Source source = SourceOf(inputs[0].name, *std::move(inputs[0].text));
        RejectOtherThanText(source);
        return source;
    }

    ExitStatus ReportDiagnostics(const std::vector<Diagnostic>& diagnostics) {
        bool isComplete = true;
        for (const Diagnostic& d : diagnostics)
            if (d.severity == Diagnostic::Severity::Error) {
                console_.Error(d);
                isComplete = false;
            } else {
                console_.Warn(d.ToString());
            }
        return isComplete ? ExitStatus::Complete : ExitStatus::Scene;
    }

    // ---- Meshes ----

    void MoveMeshes(SceneText* scene) {
        if (!a_.outDir.empty()) MakeOutputFolder(a_.outDir);
        int numIncluded = 0;
        for (const WrittenDirective& d : scene->directives) numIncluded += NamesSceneFile(d);
        const int count = MoveMeshesToPly(scene, a_.minTriangles,
                                          [this](const std::string& bytes) { return Store(bytes); });
        console_.Info(fmt::format("{}: {} meshes in PLY files", a_.input, count));
        if (numIncluded > 0)
            console_.Warn(
                fmt::format("{} included files stay as they are; convert each by itself", numIncluded));
    }

    /// Writes a mesh under the next free name, or finds the same one there. Its name from the scene's folder.
    std::string Store(const std::string& bytes) {
        const std::string stem = FromStandardInput() ? "scene" : StemOf(a_.input);
        while (true) {
            const fs::path path = MeshFolder() / fmt::format("{}-mesh-{:05}.ply", stem, ++lastMesh_);
            std::error_code error;
            const bool isThere = fs::exists(path, error);
            if (isThere && !Holds(path, bytes)) continue;
            if (!isThere) WriteText(path.string(), bytes);
            const fs::path relative = fs::relative(path, SceneFolder(), error);
            return relative.empty() ? fs::absolute(path).string() : relative.string();
        }
    }

    static bool Holds(const fs::path& path, const std::string& bytes) {
        std::error_code error;
        if (fs::file_size(path, error) != bytes.size() || error) return false;
        std::ifstream in(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {}) == bytes;
    }

    /// Relative names are looked for beside the scene file, wherever it is.
    void WarnOfOtherFolder(const SceneText& scene) {
        std::error_code error;
        const fs::path before = FromStandardInput() ? fs::path(".") : FolderOf(a_.input);
        if (fs::equivalent(before, SceneFolder(), error)) return;
        for (const WrittenDirective& d : scene.directives) {
            bool namesFiles = NamesSceneFile(d);
            for (const WrittenParameter& p : d.parameters)
                for (const WrittenValue& v : p.values)
                    namesFiles |= v.isString && fs::is_regular_file(before / v.text, error);
            if (!namesFiles) continue;
            return console_.Warn(fmt::format(
                "{}: the files that it names are looked for from its own folder, and some of them are in {}",
                a_.output, before.string()));
        }
    }

    const ConvertArguments& a_;
    Console console_;
    int lastMesh_ = 0;
};

}  // namespace

ExitStatus RunConvertScene(const ConvertArguments& arguments) { return ConvertSceneJob(arguments).Run(); }

}  // namespace lacquer::cmd
