// lacquer preview: a ball of a material in a standard light, in seconds, and sheets of them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "cmd/bsdf/color_table.h"
#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/preview/preview_scene.h"
#include "cmd/scenes/scene_arguments.h"
#include "cmd/version.h"
#include "compare/variation.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"
#include "pbrt/integrators/rendered_image.h"
#include "plot/canvas.h"
#include "plot/plot.h"

namespace lacquer::cmd {
namespace {

/// Everything that the command line of `preview` can say.
struct PreviewArguments {
    std::vector<std::string> scenes;
    std::string define;  ///< directives instead of scene files
    std::string material, reference, outfile = "preview.png", resolution;
    std::vector<std::string> vary;
    std::optional<int> spp;
    bool wantsColors = false;
    int seed = 0, threads = 0;
    bool quiet = false;
};

constexpr int kWholeSide = 512, kSwatchSide = 192;
/// Samples per pixel of swatches, which are small; of a whole ball, the stage says them.
constexpr int kSwatchSamples = 16;
/// Of a sheet [pixels]: between swatches, and for a line of text.
constexpr int kGap = 8, kLine = 26, kMargin = 14;
constexpr float kTextSize = 9;
constexpr size_t kMaxSwatches = 400;

using plot::SheetStyle;

/// Of many renders: what they say, but not how far they are.
class WarningsOnly final : public Observer {
  public:
    explicit WarningsOnly(Observer& observer) : observer_(observer) {}
    void Warn(const std::string& message) override { observer_.Warn(message); }

  private:
    Observer& observer_;
};

/// The swatches of one or two parameters: columns are the values of the first, rows those of the second.
class Sheet {
  public:
    Sheet(const std::vector<compare::Variation>& vary, Int2 side)
        : vary_(vary),
          side_(side),
          left_(kMargin + LabelWidth()),
          top_(kMargin + 2 * kLine),
          canvas_(left_ + Columns() * (side.x + kGap) - kGap + kMargin,
                  top_ + Rows() * (side.y + kGap) - kGap + kMargin, SheetStyle::Get().background) {
        const SheetStyle& style = SheetStyle::Get();
        canvas_.Text({float(left_), float(kMargin + kLine - 12)}, kTextSize, style.accent, vary[0].target);
        for (int column = 0; column < Columns(); ++column)
            canvas_.Text({float(CornerOf(column, 0).x + side_.x / 2), float(top_ - 9)}, kTextSize,
                         style.faint, vary[0].values[size_t(column)], plot::Align::Center);
        if (vary_.size() < 2) return;
        canvas_.Text({float(kMargin), float(top_ - 9)}, kTextSize, style.accent, vary[1].target);
        for (int row = 0; row < Rows(); ++row)
            canvas_.Text({float(kMargin), float(CornerOf(0, row).y + side_.y / 2)}, kTextSize, style.faint,
                         vary[1].values[size_t(row)]);
    }
    int Columns() const { return int(vary_[0].values.size()); }
    int Rows() const { return vary_.size() > 1 ? int(vary_[1].values.size()) : 1; }

    void Put(int column, int row, const Image& swatch) {
        const Int2 corner = CornerOf(column, row);
        for (int y = 0; y < side_.y; ++y)
            for (int x = 0; x < side_.x; ++x)
                canvas_.Blend(corner.x + x, corner.y + y,
                              {swatch.Get({x, y}, 0), swatch.Get({x, y}, 1), swatch.Get({x, y}, 2)}, 1);
    }
    const Image& AsImage() const { return canvas_.AsImage(); }

  private:
    Int2 CornerOf(int column, int row) const {
        return {left_ + column * (side_.x + kGap), top_ + row * (side_.y + kGap)};
    }
    int LabelWidth() const {
        if (vary_.size() < 2) return 0;
        float width = plot::Canvas::TextWidth(kTextSize, vary_[1].target) * 1.1f;
        for (const std::string& value : vary_[1].values)
            width = std::max(width, plot::Canvas::TextWidth(kTextSize, value));
        return int(width) + kMargin;
    }

    const std::vector<compare::Variation>& vary_;
    Int2 side_;
    int left_, top_;
    plot::Canvas canvas_;
};

class PreviewJob {
  public:
    explicit PreviewJob(const PreviewArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        const ThreadLimit threads(a_.threads);
        CheckArguments();
        CheckImageOutput(a_.outfile);
        scene_ = ReadMaterials();
        if (material_.empty()) material_ = LastMaterial(scene_);
        if (!a_.reference.empty()) CheckMaterial(scene_, a_.reference);
        Console::CatchSignals();
        const Clock::time_point start = Clock::now();
        std::unique_ptr<Image> image = vary_.empty() ? Render(scene_) : RenderSheet();
        if (console_.ShouldStop()) return Console::StatusOfSignal();
        image->metadata["Software"] = fmt::format("Lacquer {}", kVersion);
        image->metadata["material"] = material_;
        WriteImage(*image, a_.outfile, false);
        console_.Info(fmt::format("{}: \"{}\", {} x {} pixels in {}", a_.outfile, material_,
                                  image->Resolution().x, image->Resolution().y,
                                  FormatSeconds(SecondsSince(start))));
        if (a_.wantsColors || !a_.reference.empty())
            fmt::print("{}", ToText(MakeColorTable(scene_, Colors(), &console_)));
        return ExitStatus::Complete;
    }

  private:
    void CheckArguments() {
        if (a_.define.empty() == a_.scenes.empty())
            throw CLI::ValidationError(a_.define.empty()
                                           ? "a scene file or --define is needed: what has the material"
                                           : "--define is instead of a scene file; both are given");
        for (const std::string& text : a_.vary) {
            try {
                vary_.push_back(compare::ParseVariation(text));
            } catch (const std::invalid_argument& e) {
                throw CLI::ValidationError(fmt::format("--vary: {}", e.what()));
            }
        }
        if (vary_.size() > 2)
            throw CLI::ValidationError(
                fmt::format("--vary is given {} times; a sheet has two directions", vary_.size()));
        size_t swatches = 1;
        for (const compare::Variation& v : vary_) swatches *= v.values.size();
        if (swatches > kMaxSwatches)
            throw CLI::ValidationError(
                fmt::format("--vary: {} swatches; expected at most {}", swatches, kMaxSwatches));
        const int side = vary_.empty() ? kWholeSide : kSwatchSide;
        side_ = a_.resolution.empty() ? Int2(side) : ParseResolution("resolution", a_.resolution);
        material_ = a_.material;
    }

    SceneDescription ReadMaterials() {
        if (!a_.define.empty()) return ParseInputs({{"--define", "WorldBegin\n" + a_.define}}, &console_);
        return ParseInputs(ReadMaterialArguments(a_.scenes, &console_), &console_);
    }

    std::unique_ptr<Image> Render(SceneDescription scene) {
        BuildOptions options;
        options.film.resolution = side_;
        options.film.filename = a_.outfile;
        options.samplesPerPixel = a_.spp;
        if (!a_.spp && !vary_.empty()) options.samplesPerPixel = kSwatchSamples;
        options.given.Set(&SceneOptions::seed, a_.seed);
        options.textures = DefaultTextureMemory();
        // A sheet has one bar for all of its swatches.
        WarningsOnly warnings(console_);
        Observer& observer = vary_.empty() ? static_cast<Observer&>(console_) : warnings;
        const RenderSetup setup = BuildScene(OnStage(std::move(scene), material_), options, &observer);
        RenderOptions render = RenderOptionsOf(setup);
        lacquer::Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, render, observer);
        return setup.film->Develop();
    }

    std::unique_ptr<Image> RenderSheet() {
        Sheet sheet(vary_, side_);
        console_.Begin("Swatches", int64_t(sheet.Columns()) * sheet.Rows(), "");
        for (int row = 0; row < sheet.Rows(); ++row)
            for (int column = 0; column < sheet.Columns() && !console_.ShouldStop(); ++column) {
                SceneDescription scene = scene_;
                Set(vary_[0], column, &scene);
                if (vary_.size() > 1) Set(vary_[1], row, &scene);
                sheet.Put(column, row, *Render(std::move(scene)));
                console_.Advance(1);
            }
        console_.End();
        return std::make_unique<Image>(sheet.AsImage());
    }
    static void Set(const compare::Variation& variation, int value, SceneDescription* scene) {
        try {
            compare::Apply(variation, variation.values[size_t(value)], scene);
        } catch (const std::invalid_argument& e) {
            throw CLI::ValidationError(fmt::format("--vary {}: {}", variation.target, e.what()));
        }
    }

    ColorQuery Colors() const {
        ColorQuery query{material_, a_.reference, Point2(0.5f), {}, {}};
        query.survey.seed = uint64_t(a_.seed);
        query.build.given.Set(&SceneOptions::seed, a_.seed);
        query.build.textures = DefaultTextureMemory();
        return query;
    }

    const PreviewArguments& a_;
    Console console_;
    std::vector<compare::Variation> vary_;
    Int2 side_{0};
    std::string material_;
    SceneDescription scene_;
};

void AddPreviewOptions(CLI::App& app, PreviewArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("scene", a.scenes,
                   "Scene files, of which the materials and textures count; or documents of MaterialX")
        ->type_name(kFile)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--define", a.define, "Directives in place of a scene file: 'Material \"openpbr\" ...'");
    app.add_option("--material", a.material,
                   "Name of a named material; @1, @2, ...: the unnamed ones; default: the last one");
    app.add_option("--outfile", a.outfile, "Image to write")->type_name(kFile);
    app.add_option("--resolution", a.resolution,
                   "WxH, of each swatch; default: 512x512, or 192x192 with --vary");
    app.add_option("--spp", a.spp, "Samples per pixel; default: 8, or 16 with --vary")
        ->check(CLI::Range(1, 1 << 20));
    app.add_option("--vary", a.vary,
                   "MATERIAL.PARAMETER=VALUE,VALUE,...: a sheet of swatches; given twice, one direction each")
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->allow_extra_args(false);
    app.add_flag("--colors", a.wantsColors, "Print the table of colours that a paint laboratory reads");
    app.add_option("--reference", a.reference, "Another material of the scene: color differences from it");
    app.add_option("--seed", a.seed, "Seed of all random numbers");
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No progress and no warnings");
}

ExitStatus RunPreview(const PreviewArguments& arguments) { return PreviewJob(arguments).Run(); }

constexpr const char* kSynopsis =
    "Shows a material: a ball in a standard light, in seconds, or a sheet of swatches.\n"
    "Usage: lacquer preview [OPTIONS] scene.pbrt ... [--material NAME]\n"
    "       lacquer preview [OPTIONS] --define 'Material \"openpbr\" \"float coat_weight\" 1'";
constexpr const char* kFooter = R"(
Exit status: 0 the image is written; 1 wrong usage; 2 the scene is wrong, or has no such material; 3 a
file cannot be read or written; 129, 130 or 143 stopped by a signal (nothing is written).)";

}  // namespace

LACQUER_REGISTER(CommandKind, "preview", (CommandOf<PreviewArguments, AddPreviewOptions, RunPreview>::Make),
                 {.synopsis = kSynopsis, .footer = kFooter});

}  // namespace lacquer::cmd
