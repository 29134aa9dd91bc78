#include "cmd/render/render_arguments.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <sstream>

#include "cmd/choices.h"
#include "cmd/command_support.h"
#include "cmd/render/display.h"
#include "layered/estimator.h"
#include "pbrt/film/aov.h"
#include "pbrt/film/passes.h"
#include "pbrt/integrators/rendered_image.h"
#include "pbrt/integrators/sample_shares.h"

namespace lacquer::cmd {

namespace {

const std::vector<std::string> kLogLevels = {"verbose", "error", "fatal"};

/// Exactly `count` numbers separated by any of `separators`.
template <class Number>
std::vector<Number> ParseNumbers(const std::string& name, const std::string& text, size_t count,
                                 const std::string& separators, const std::string& expected) {
    std::string spaced = text;
    for (char& c : spaced)
        if (separators.find(c) != std::string::npos) c = ' ';
    std::istringstream in(spaced);
    std::vector<Number> numbers;
    Number number;
    while (in >> number) numbers.push_back(number);
    if (!in.eof() || numbers.size() != count) BadOption(name, text, expected);
    return numbers;
}

FilmOverrides FilmOverridesOf(const RenderArguments& a) {
    FilmOverrides film;
    film.filename = a.outfile;
    film.quick = a.quick;
    if (!a.resolution.empty()) film.resolution = ParseResolution("resolution", a.resolution);
    if (!a.cropWindow.empty()) {
        const auto c =
            ParseNumbers<float>("cropwindow", a.cropWindow, 4, ",", "x0,x1,y0,y1 as fractions of the image");
        for (const float x : c)
            if (!(x >= 0 && x <= 1))
                BadOption("cropwindow", a.cropWindow, "x0,x1,y0,y1 from 0 to 1, as fractions of the image");
        film.cropWindow = {c[0], c[1], c[2], c[3]};
    }
    if (!a.pixelBounds.empty()) {
        const auto b = ParseNumbers<int>("pixelbounds", a.pixelBounds, 4, ",", "x0,x1,y0,y1 in pixels");
        film.pixelBounds = Bounds2i{{b[0], b[2]}, {b[1], b[3]}};
    }
    if (!a.pixel.empty()) {
        const auto p = ParseNumbers<int>("pixel", a.pixel, 2, ",", "x,y in pixels");
        if (p[0] < 0 || p[1] < 0 || p[0] >= kMaxFilmSide || p[1] >= kMaxFilmSide)
            BadOption("pixel", a.pixel, fmt::format("two numbers from 0 to {}", kMaxFilmSide - 1));
        film.pixelBounds = Bounds2i{{p[0], p[1]}, {p[0] + 1, p[1] + 1}};
    }
    return film;
}

/// In a sandbox, what would go to the folder for temporary files goes to that of the image.
TextureMemory TexturesOf(const RenderArguments& a) {
    TextureMemory memory = TextureMemoryOf(a.textureMegabytes, a.textureCache);
    if (a.sandbox.isOn) memory.temporaryFolder = a.outfile.empty() ? "." : FolderOfFile(a.outfile);
    return memory;
}

std::string WhyNoAov(const std::string& name) {
    return IsPass(name) ? WhyNoPass(name) : WhyUnknown(name, AovNames());
}

/// An empty value, as of a variable that a script forgot to set, would mean that the option is not given.
void RefuseEmptyValues(CLI::App& app) {
    for (CLI::Option* option : app.get_options(
             [](const CLI::Option* o) { return !o->get_positional() && o->get_items_expected_max() > 0; }))
        option->check([](const std::string& value) {
            return value.empty() ? std::string("the value is empty") : std::string();
        });
}

/// An option that scene files have as well.
void AddSceneOption(CLI::App& app, const SceneOption& option, GivenOptions* given) {
    const auto add = [&](auto field) {
        using Value = std::decay_t<decltype(SceneOptions().*field)>;
        if constexpr (std::is_same_v<Value, bool>) {
            app.add_flag_function(
                option.commandLine, [=](int64_t count) { given->Set(field, count > 0); }, option.help);
        } else {
            CLI::Option* added = app.add_option_function<Value>(
                option.commandLine, [=](const Value& value) { given->Set(field, value); }, option.help);
            if (option.isPositive) added->check(Positive());
            if (option.choices) added->check(OneOf(option.choices()));
            if (option.isFile) added->type_name(kFile);
        }
    };
    std::visit(add, option.field);
}

/// What is written beside colours, or needs it.
void AddAovOptions(CLI::App& app, RenderArguments& a) {
    app.add_option("--aov", a.aovs,
                   "Extra outputs, with commas between; lpe:NAME=EXPRESSION, too (docs/aovs.md)")
        ->type_name("A,B,...")
        ->check(OneOf(AovNames(), WhyNoAov))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_flag("--denoise", a.denoise, "Removes the noise after the render; see lacquer denoise --help");
    AddDenoiserOption(app, a.denoiser);
    app.add_option("--cryptomatte-ranks", a.cryptomatteRanks,
                   fmt::format("Objects and materials that a pixel of --aov cryptoobject, cryptomaterial can "
                               "name: even, 2 to {}",
                               CryptomatteLayer::kMaxRanks))
        ->check(CLI::Range(2, CryptomatteLayer::kMaxRanks));
}

/// What is kept for a render that goes on later.
void AddCheckpointOptions(CLI::App& app, RenderArguments& a) {
    app.add_option(
           "--checkpoint", a.checkpoint,
           "File for the state of the render, now and then and in the end, to go on from with --resume")
        ->type_name(kFile);
    AddCheckpointInterval(app, a.checkpointEvery);
    app.add_option("--resume", a.resume,
                   "State to go on from, to the same bits; --spp may be larger than before")
        ->type_name(kFile);
}

/// Many frames in one process.
void AddSequenceOptions(CLI::App& app, RenderArguments& a) {
    CLI::Option* frames =
        app.add_option(
               "--frames", a.frames,
               "Frames to render, as in 1-100 or 1-9x2,20: # in the names of scene files, and of what is "
               "written, is the frame's number")
            ->type_name("A-B,...");
    app.add_option(
           "--vary", a.vary,
           "PART.PARAMETER=FROM:TO, or a value for each frame: as of lacquer compare; may be repeated")
        ->needs(frames)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--summary", a.summary, "JSON file that tells how each frame ended")
        ->type_name(kFile)
        ->needs(frames);
    app.add_flag(
           "--restart", a.restart,
           "Leaves out the frames that --summary says are complete, and goes on from the states of others")
        ->needs(frames);
}

}  // namespace

BuildOptions BuildOptionsOf(const RenderArguments& a) {
    BuildOptions options;
    options.film = FilmOverridesOf(a);
    options.samplesPerPixel = a.spp;
    if (a.quick) options.samplesPerPixel = 1;
    options.given = a.options;
    options.keepNames = AovBuffer::NeedsSceneNames(a.aovs);
    options.film.keepsHalves = AovBuffer::NeedsHalves(a.Aovs()) || NoiseTargetOf(a) > 0;
    if (a.adaptive) options.maxTimes = SampleShares::kMaxTimes;
    options.disableImageTextures = a.disableImageTextures;
    options.materials = {{"estimator", a.estimator}, {"pdf", a.layeredPdf}};
    options.textures = TexturesOf(a);
    return options;
}

/// Values that can be judged before the scene is read.
void CheckArguments(const RenderArguments& a) {
    if (a.timeLimit && !(*a.timeLimit > 0 && std::isfinite(*a.timeLimit)))
        BadOption("time-limit", fmt::format("{}", *a.timeLimit), "a positive number of seconds");
    if (NoiseTargetOf(a) > 0 && !a.sampleRange.empty())
        throw CLI::ValidationError(
            "--noise-target decides how many samples there are; it does not go with --sample-range");
    if (!a.displayServer.empty() && !DisplayAddress::Parse(a.displayServer))
        BadOption("display-server", a.displayServer, "HOST or HOST:PORT, as in localhost:14158");
    const SceneOptions& options = a.options.Values();
    if (options.mseReferenceImage.empty() != options.mseReferenceOut.empty())
        throw CLI::ValidationError("--mse-reference-image and --mse-reference-out go together");
    if (options.pixelStats && !(a.checkpoint + a.resume).empty())
        throw CLI::ValidationError(
            "--pixelstats measures one run; it does not go with --checkpoint and --resume");
    if (a.cryptomatteRanks % 2 != 0)
        BadOption("cryptomatte-ranks", fmt::format("{}", a.cryptomatteRanks), "an even number");
}

double NoiseTargetOf(const RenderArguments& a) {
    if (a.noiseTarget.empty()) return 0;
    const auto bad = [&] {
        BadOption("noise-target", a.noiseTarget, "a part above 0 and below 1, as in 0.5% or 0.005");
    };
    const char* end = a.noiseTarget.data() + a.noiseTarget.size();
    double value = 0;
    const auto [rest, error] = std::from_chars(a.noiseTarget.data(), end, value);
    const std::string_view unit(rest, end);
    if (unit == "%") value /= 100;
    if (error != std::errc() || !(unit.empty() || unit == "%") || !(value > 0 && value < 1)) bad();
    return value;
}

std::pair<int, int> SampleRangeOf(const RenderArguments& a, int samples) {
    if (a.sampleRange.empty()) return {0, samples};
    const auto range =
        ParseNumbers<int>("sample-range", a.sampleRange, 2, ":", "FIRST:END, END not included");
    if (range[0] < 0 || range[1] <= range[0]) BadOption("sample-range", a.sampleRange, "0 <= FIRST < END");
    if (range[1] > samples)
        BadOption("sample-range", a.sampleRange,
                  fmt::format("END of at most {}, the samples per pixel", samples));
    return {range[0], range[1]};
}

/// Before anything of the scene is read. What only the scene names as output is written into the current
/// folder, or not at all.
void EnterSandboxOf(std::span<const RenderArguments> frames, const std::string& summary) {
    AllowedPaths allowed{frames[0].sandbox.read, {FolderOfFile(summary), TexturesOf(frames[0]).cacheFolder}};
    for (const RenderArguments& a : frames) {
        const SceneOptions& options = a.options.Values();
        for (const std::string& folder : FoldersOfScenes(a.scenes)) allowed.read.push_back(folder);
        for (const std::string& path : {a.resume, options.mseReferenceImage}) allowed.read.push_back(path);
        allowed.write.push_back(a.outfile.empty() ? "." : FolderOfFile(a.outfile));
        for (const std::string& path : {a.checkpoint, a.logFile, a.statsJson, options.mseReferenceOut})
            allowed.write.push_back(FolderOfFile(path));
    }
    EnterSandbox(allowed);
}

void AddRenderOptions(CLI::App& app, RenderArguments& a) {
    // Of an option given twice, the last one counts: wrappers can add theirs behind.
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("scene", a.scenes,
                   "Scene files, read one after another as one scene (.pbrt, .pbrt.gz; -: standard input)")
        ->type_name(kFile)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--outfile", a.outfile,
                   "Image to write, instead of the scene's; the extension chooses the format")
        ->type_name(kFile);
    app.add_option("--spp", a.spp, "Samples per pixel, instead of the scene's")
        ->check(CLI::Range(1, 1 << 24));
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_option("--resolution", a.resolution, "WxH, instead of the scene's");
    app.add_option("--cropwindow", a.cropWindow, "x0,x1,y0,y1: part of the image, as fractions");
    app.add_option("--pixelbounds", a.pixelBounds, "x0,x1,y0,y1: part of the image, in pixels");
    app.add_option("--pixel", a.pixel, "x,y: one pixel");
    app.add_option("--sample-range", a.sampleRange, "a:b: only these samples of each pixel, b not included");
    app.add_option("--time-limit", a.timeLimit,
                   "Seconds of rendering, within 2 % or 0.2 s; pixels may then differ by a few samples");
    app.add_flag("--adaptive", a.adaptive,
                 "Gives more samples to pixels with more noise, and others fewer: --spp is the mean");
    app.add_option("--noise-target", a.noiseTarget,
                   "Stops when 95 % of the pixels have at most this relative error, as in 0.5%; --spp is the "
                   "most samples")
        ->type_name("ERROR");
    app.add_flag("--mpi", a.mpi, "One render by all processes that mpirun has started (docs/farm.md)");
    AddAovOptions(app, a);
    AddCheckpointOptions(app, a);
    AddSequenceOptions(app, a);
    AddSandboxOptions(app, a.sandbox);
    app.add_option("--estimator", a.estimator, "Estimator of every layered material, instead of the scene's")
        ->check(OneOf(Registry<layered::LayeredEstimatorKind>::Names()));
    app.add_option("--layered-pdf", a.layeredPdf, "The same for the density of their sampling")
        ->check(OneOf(Registry<layered::LayeredPdfKind>::Names()));
    app.add_flag("--quick", a.quick, "A quarter of the resolution, one sample per pixel");
    app.add_flag("--quiet", a.quiet, "No progress and no warnings");
    app.add_flag("--stats", a.stats, "Print statistics at the end");
    app.add_option("--stats-json", a.statsJson, "Write statistics to a file (-: standard output)")
        ->type_name(kFile);
    app.add_flag("--write-partial-images", a.writePartialImages, "Write the image after every pass");
    app.add_option("--display-server", a.displayServer, "HOST[:PORT] of a tev viewer (port 14158)");
    app.add_flag("--disable-image-textures", a.disableImageTextures,
                 "Image textures have their mean everywhere");
    app.add_option("--texture-memory", a.textureMegabytes,
                   "Megabytes for image textures; those beyond it are read from prepared files as needed")
        ->check(CLI::Range(16, 1 << 20))
        ->capture_default_str();
    app.add_option("--texture-cache", a.textureCache,
                   "Folder of prepared textures, instead of lacquer/textures in ~/.cache; \"none\": make "
                   "them anew, and remove them at the end")
        ->type_name(kFolder);
    app.add_option("--log-level", a.logLevel, "Least severe messages of the log file")
        ->check(OneOf(kLogLevels));
    app.add_option("--log-file", a.logFile, "File for the log")->type_name(kFile);
    for (const SceneOption& option : OptionTable())
        if (option.commandLine) AddSceneOption(app, option, &a.options);
    RefuseEmptyValues(app);
}

}  // namespace lacquer::cmd
