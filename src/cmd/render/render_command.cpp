// lacquer render: from a scene file to an image.
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/log.h"
#include "cmd/render/checkpoint.h"
#include "cmd/render/denoise_render.h"
#include "cmd/render/display.h"
#include "cmd/render/film_record.h"
#include "cmd/sandbox.h"
#include "cmd/scenes/scene_arguments.h"
#include "cmd/version.h"
#include "layered/estimator.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/passes.h"
#include "pbrt/image/image.h"
#include "pbrt/integrators/rendered_image.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/scene_options.h"

namespace lacquer::cmd {

namespace {

/// Between checkpoints [s].
constexpr double kCheckpointSeconds = 600;

/// Everything that the command line of `render` can say.
struct RenderArguments {
    std::vector<std::string> scenes;  ///< none, or "-": standard input
    std::string outfile;
    std::optional<int> spp;
    GivenOptions options;  ///< those that Option directives can set as well
    int threads = 0;
    bool quiet = false, quick = false, stats = false, writePartialImages = false;
    bool disableImageTextures = false;
    std::string cropWindow, pixelBounds, pixel, resolution, sampleRange;
    std::string displayServer;
    int textureMegabytes = 512;
    std::string textureCache;
    std::string logLevel = "error", logFile;
    std::string estimator, layeredPdf;
    std::optional<double> timeLimit;
    std::string statsJson;
    std::vector<std::string> aovs;
    int cryptomatteRanks = 6;
    bool denoise = false;
    std::string denoiser = "nfor";
    SandboxOptions sandbox;
    std::string checkpoint, resume;
    double checkpointEvery = kCheckpointSeconds;
    /// What is kept beside colours: what was asked for, and what the denoiser needs.
    std::vector<std::string> Aovs() const {
        return denoise ? denoise::WithAovsOf(denoise::MethodOf(denoiser), aovs) : aovs;
    }
};

/// More invalid samples than this fraction make the image suspect (exit status 4).
constexpr double kAllowedBadFraction = 1e-5;
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

BuildOptions BuildOptionsOf(const RenderArguments& a) {
    BuildOptions options;
    options.film = FilmOverridesOf(a);
    options.samplesPerPixel = a.spp;
    if (a.quick) options.samplesPerPixel = 1;
    options.given = a.options;
    options.keepNames = AovBuffer::NeedsSceneNames(a.aovs);
    options.film.keepsHalves = AovBuffer::NeedsHalves(a.Aovs());
    options.disableImageTextures = a.disableImageTextures;
    options.materials = {{"estimator", a.estimator}, {"pdf", a.layeredPdf}};
    options.textures = TexturesOf(a);
    return options;
}

/// Values that can be judged before the scene is read.
void CheckArguments(const RenderArguments& a) {
    if (a.timeLimit && !(*a.timeLimit > 0 && std::isfinite(*a.timeLimit)))
        BadOption("time-limit", fmt::format("{}", *a.timeLimit), "a positive number of seconds");
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

std::string WhyNoAov(const std::string& name) {
    return IsPass(name) ? WhyNoPass(name) : WhyUnknown(name, AovNames());
}

/// True for formats that have alpha beside colours, and nothing else.
bool HoldsAlpha(const std::string& path) { return ExtensionOf(path) == "png"; }
/// Colours as such formats have them, without the factor of alpha. Does nothing where there is no alpha.
void DivideByAlpha(Image* image) {
    const int alpha = image->FindChannel("A");
    if (alpha < 0) return;
    const Int2 size = image->Resolution();
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (int c = 0; c < 3; ++c)
                if (const float a = image->Get({x, y}, alpha); a > 0)
                    image->Set({x, y}, c, image->Get({x, y}, c) / a);
}

/// The one format that holds channels with names.
bool IsEXR(const std::string& path) { return ExtensionOf(path) == "exr"; }

/// Mean squared difference of the RGB values of two images of one size.
double MeanSquaredError(const Image& a, const Image& b) {
    double sum = 0;
    const Int2 r = a.Resolution();
    for (int y = 0; y < r.y; ++y)
        for (int x = 0; x < r.x; ++x)
            for (int c = 0; c < 3; ++c) sum += Sqr(double(a.Get({x, y}, c)) - double(b.Get({x, y}, c)));
    return sum / (3.0 * r.x * r.y);
}

/// One render from arguments to written files.
class RenderJob {
  public:
    explicit RenderJob(const RenderArguments& arguments)
        : a_(arguments),
          console_(ConsoleStyle::Detect(arguments.quiet)),
          log_(arguments.logFile, arguments.logLevel),
          checkpoint_(arguments.resume, arguments.checkpoint, arguments.checkpointEvery, &console_) {}

    ExitStatus Run() {
        ExitStatus status;
        try {
            status = RunSteps();
        } catch (const std::exception& e) {
            log_.Error(e.what());
            throw;
        }
        // The image is written; what else went wrong comes before a log that is not.
        if (status == ExitStatus::Complete) log_.CheckWritten();
        return status;
    }

  private:
    ExitStatus RunSteps() {
        if (a_.sandbox.isOn) EnterSandboxOfRender();
        const ThreadLimit threads(a_.threads);
        Prepare();
        ConnectDisplay();
        ReadReference();
        // Before this a signal simply ends the process: there is nothing to save yet.
        Console::CatchSignals();
        RenderImage();
        if (stats_.samples == 0) return Status();  // stopped at once: what was there stays
        const Clock::time_point writing = Clock::now();
        std::unique_ptr<Image> image = Develop(stats_.samplesPerPixel);
        if (a_.denoise) DenoiseRender(denoise::MethodOf(a_.denoiser), a_.aovs, &console_, image.get());
        WriteImage(image, OutputName());
        if (pixelStats_)
            lacquer::WriteImage(*pixelStats_->Develop(setup_.film->Resolution()), PixelStatsName(), false);
        checkpoint_.Finish(stats_.seconds);
        writeSeconds_ = SecondsSince(writing);
        FinishDisplay();
        Report();
        WarnOfMissedLimit();
        return Status();
    }

    /// Before the first thread, and before anything of the scene is read. What only the scene names as output
    /// is written into the current folder, or not at all.
    void EnterSandboxOfRender() const {
        const SceneOptions& options = a_.options.Values();
        AllowedPaths allowed{a_.sandbox.read, {a_.outfile.empty() ? "." : FolderOfFile(a_.outfile)}};
        for (const std::string& folder : FoldersOfScenes(a_.scenes)) allowed.read.push_back(folder);
        for (const std::string& path : {a_.resume, options.mseReferenceImage}) allowed.read.push_back(path);
        for (const std::string& path : {a_.checkpoint, a_.logFile, a_.statsJson, options.mseReferenceOut})
            allowed.write.push_back(FolderOfFile(path));
        allowed.write.push_back(TexturesOf(a_).cacheFolder);
        EnterSandbox(allowed);
    }

    void Prepare() {
        if (!a_.statsJson.empty() && a_.statsJson != "-") CheckOutputFile(a_.statsJson);
        BuildOptions options = BuildOptionsOf(a_);
        options.filterSamples = checkpoint_.FilterSamples();
        Clock::time_point start = Clock::now();
        for (const std::string& path : a_.scenes)
            if (std::error_code error; std::filesystem::is_fifo(path, error))
                console_.Info(fmt::format("reading the scene from the pipe {}", path));
        const std::vector<SceneInput> inputs = ReadSceneArguments(a_.scenes);
        SceneDescription description = ParseInputs(inputs, &console_);
        const std::vector<std::string> sceneFiles = description.files;
        if (checkpoint_.IsUsed()) filmDirectives_ = FilmDirectives(description);
        parseSeconds_ = SecondsSince(start);
        log_.Info(fmt::format("parsed in {:.3f} s", parseSeconds_));
        start = Clock::now();
        setup_ = BuildScene(std::move(description), options, &console_);
        buildSeconds_ = SecondsSince(start);
        log_.Info(fmt::format("built in {:.3f} s: {} primitives, {} lights", buildSeconds_,
                              setup_.scene->NumPrimitives(), setup_.scene->Lights().size()));
        CheckImageOutput(OutputName());
        CheckOutputs(sceneFiles);
        const bool wantsAlphaAlone = a_.aovs == std::vector<std::string>{"alpha"};
        if (!a_.aovs.empty() && !IsEXR(OutputName()) && !(wantsAlphaAlone && HoldsAlpha(OutputName())))
            throw CLI::ValidationError(fmt::format(
                "--aov needs an EXR file for its channels; \"{}\" holds colours only", OutputName()));
        if (a_.spp && !a_.quick && setup_.sampler->SamplesPerPixel() != *a_.spp)
            console_.Warn(fmt::format("the scene's sampler takes {} samples per pixel instead of {}",
                                      setup_.sampler->SamplesPerPixel(), *a_.spp));
        if (setup_.options.pixelStats) {
            pixelStats_ = std::make_unique<PixelStats>(setup_.film->PixelBounds());
            CheckOutputFile(PixelStatsName());
        }
        if (!setup_.scene->HasEmission()) console_.Warn("the scene has no light: the image will be black");
        CheckAovs(a_.aovs, setup_);
        try {
            passes_ = MakePasses(a_.Aovs(), setup_);
        } catch (const LightPathError& e) {
            throw CLI::ValidationError(fmt::format("--aov: {}", e.what()));
        }
        aovs_ = MakeAovBuffer(a_.Aovs(), a_.cryptomatteRanks, setup_);
        ReadSampleRange();
        if (a_.denoise)
            CheckDenoiser(denoise::MethodOf(a_.denoiser), range_.second - range_.first,
                          setup_.integrator->MakesSplats());
        if (checkpoint_.IsUsed()) AttachCheckpoint(sceneFiles, inputs);
    }

    /// Nothing that the render reads is replaced by what it writes. A log is looked after by itself.
    void CheckOutputs(std::vector<std::string> inputs) const {
        for (const FileUse& use : setup_.files) inputs.push_back(use.path);
        inputs.push_back(setup_.options.mseReferenceImage);
        CheckOutputsApart({{a_.outfile.empty() ? "the scene's film" : "--outfile", OutputName()},
                           {"--pixelstats", setup_.options.pixelStats ? PixelStatsName() : ""},
                           {"--stats-json", a_.statsJson == "-" ? "" : a_.statsJson},
                           {"--mse-reference-out", setup_.options.mseReferenceOut},
                           {"--checkpoint", a_.checkpoint},
                           {"--log-file", a_.logFile}},
                          inputs);
    }

    void AttachCheckpoint(const std::vector<std::string>& sceneFiles, const std::vector<SceneInput>& inputs) {
        std::string text;
        for (const SceneInput& input : inputs) text += input.text.value_or("");
        StateHeader header = HeaderOf(setup_, sceneFiles, text, aovs_.get(), passes_.get(),
                                      {{"estimator", a_.estimator},
                                       {"layered-pdf", a_.layeredPdf},
                                       {"disable-image-textures", a_.disableImageTextures},
                                       {"cryptomatte-ranks", a_.cryptomatteRanks}});
        header.film = FilmRecord(filmDirectives_, setup_, aovs_.get(), a_.cryptomatteRanks, passes_.get());
        header.name = SceneName();
        const int samples = setup_.sampler->SamplesPerPixel();
        header.filterSamples = samples;
        header.halfBlock = BestHalfBlock(samples);
        if (setup_.integrator->MakesSplats()) setup_.film->PrepareForSplats(MaxThreads());
        checkpoint_.Attach(std::move(header), range_, setup_.film.get(), aovs_.get());
    }

    void ConnectDisplay() {
        if (a_.displayServer.empty()) return;
        const Bounds2i pixels = setup_.film->PixelBounds();
        display_ = std::make_unique<DisplayServer>(*DisplayAddress::Parse(a_.displayServer), OutputName(),
                                                   Int2(pixels.Width(), pixels.Height()));
    }

    /// A viewer that fails costs one warning.
    void CheckDisplay() {
        if (!display_ || display_->Problem().empty()) return;
        console_.Warn(fmt::format("the display server \"{}\" {}; rendering without it", a_.displayServer,
                                  display_->Problem()));
        display_.reset();
    }

    void FinishDisplay() {
        // What came after the last whole pass: the viewer ends with the values of the file.
        if (display_ && PixelsDiffer(stats_)) display_->Show(setup_.film->Develop());
        if (display_) display_->Finish();
        CheckDisplay();
        display_.reset();
    }

    void ReadReference() {
        const std::string& path = setup_.options.mseReferenceImage;
        mseOut_ = setup_.options.mseReferenceOut;
        if (path.empty() != mseOut_.empty())
            throw CLI::ValidationError(
                "a reference image and a file for its errors go together; only one is given");
        if (path.empty()) return;
        CheckOutputFile(mseOut_);
        const Image reference = ReadImage(path, {ColorEncoding::Kind::SRGB, 1}, {});
        const Bounds2i bounds = setup_.film->PixelBounds();
        const bool whole = reference.Resolution() == setup_.film->Resolution();
        if ((!whole && reference.Resolution() != Int2(bounds.Width(), bounds.Height())) ||
            !reference.HasRGB())
            throw FileError(path,
                            fmt::format("is {} x {} pixels; an RGB image of {} x {} is expected as reference",
                                        reference.Resolution().x, reference.Resolution().y, bounds.Width(),
                                        bounds.Height()));
        const Int2 offset = whole ? bounds.min : Int2(0);
        reference_ = reference.Part({offset, offset + Int2(bounds.Width(), bounds.Height())}, {0, 1, 2});
    }

    void ReadSampleRange() {
        const int samples = setup_.sampler->SamplesPerPixel();
        range_ = {0, samples};
        if (a_.sampleRange.empty()) return;
        const auto range =
            ParseNumbers<int>("sample-range", a_.sampleRange, 2, ":", "FIRST:END, END not included");
        if (range[0] < 0 || range[1] <= range[0])
            BadOption("sample-range", a_.sampleRange, "0 <= FIRST < END");
        if (range[1] > samples)
            BadOption("sample-range", a_.sampleRange,
                      fmt::format("END of at most {}, the samples per pixel", samples));
        range_ = {range[0], range[1]};
    }

    RenderOptions OptionsOfRender() {
        RenderOptions options = RenderOptionsOf(setup_);
        options.firstSample = range_.first;
        options.endSample = range_.second;
        checkpoint_.AddTo(&options);
        if (a_.timeLimit) options.timeLimit = *a_.timeLimit;
        options.aovs = aovs_.get();
        options.passes = passes_.get();
        options.pixelStats = pixelStats_.get();
        options.afterPass = [this](int samples, double elapsed) {
            stats_.seconds = elapsed;
            AfterPass(samples);
        };
        return options;
    }

    void RenderImage() {
        const RenderOptions options = OptionsOfRender();
        stats_ = Render(*setup_.scene, *setup_.integrator, *setup_.sampler, *setup_.film, options, console_);
        log_.Info(fmt::format("rendered in {:.3f} s", stats_.seconds));
    }

    void AfterPass(int samples) {
        if (a_.writePartialImages) WriteImage(Develop(samples), OutputName());
        CheckDisplay();
        if (!display_ && !reference_) return;
        std::unique_ptr<Image> image = setup_.film->Develop();
        if (reference_) {
            mseLines_ += fmt::format("{}, {:.9g}\n", samples, MeanSquaredError(*image, *reference_));
            WriteText(mseOut_, mseLines_);
        }
        if (display_) display_->Show(std::move(image));
    }

    std::string OutputName() const { return setup_.film->Filename(); }
    /// "room-pixelstats.exr" for "room.png".
    std::string PixelStatsName() const {
        return std::filesystem::path(OutputName()).replace_extension().string() + "-pixelstats.exr";
    }

    std::unique_ptr<Image> Develop(int samples) const {
        ImageOrigin origin;
        origin.samplesPerPixel = samples;
        origin.firstSample = range_.first;
        origin.seconds = checkpoint_.SecondsBefore() + stats_.seconds;
        origin.showsSampleCounts = PixelsDiffer(stats_) && IsEXR(OutputName());
        origin.software = fmt::format("Lacquer {}", kVersion);
        origin.scene = SceneName();
        return DevelopRender(setup_, aovs_.get(), passes_.get(), origin);
    }

    std::string SceneName() const {
        return std::filesystem::path(FirstSceneName(a_.scenes)).filename().string();
    }

    /// "33" or "33 to 34".
    std::string SamplesInWords() const {
        if (PixelsDiffer(stats_))
            return fmt::format("{} to {} samples", stats_.samplesPerPixel, stats_.maxSamples);
        return fmt::format("{} {}", stats_.samplesPerPixel,
                           stats_.samplesPerPixel == 1 ? "sample" : "samples");
    }

    void WriteImage(const std::unique_ptr<Image>& image, const std::string& path) const {
        if (HoldsAlpha(path)) DivideByAlpha(image.get());
        lacquer::WriteImage(*image, path, setup_.film->SavesHalf());
    }

    /// As JSON.
    std::string Statistics() const {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        const RenderCosts costs = {parseSeconds_, buildSeconds_, writeSeconds_,
                                   int64_t(usage.ru_maxrss) * 1024};
        return StatisticsText(setup_, stats_, costs, kVersion, OutputName());
    }

    void Report() {
        const double rays = double(stats_.raysTraced + stats_.shadowRays);
        console_.Info(fmt::format(
            "{}: {} x {} pixels, {} each, {} after {} of loading ({}samples/s, {}rays/s)", OutputName(),
            setup_.film->PixelBounds().Width(), setup_.film->PixelBounds().Height(), SamplesInWords(),
            FormatSeconds(stats_.seconds), FormatSeconds(parseSeconds_ + buildSeconds_),
            FormatCount(double(stats_.cameraRays) / std::max(stats_.seconds, 1e-9)),
            FormatCount(rays / std::max(stats_.seconds, 1e-9))));
        if (a_.stats) console_.Print(Statistics());
        if (a_.statsJson == "-")
            fmt::print("{}\n", Statistics());
        else if (!a_.statsJson.empty())
            WriteText(a_.statsJson, Statistics() + "\n");
        if (stats_.badSamples > 0)
            console_.Warn(fmt::format("{} of {} samples were NaN, infinite or negative and count as black",
                                      stats_.badSamples, stats_.cameraRays));
    }

    void WarnOfMissedLimit() {
        if (a_.timeLimit && stats_.seconds > std::max(1.02 * *a_.timeLimit, *a_.timeLimit + 0.2) &&
            !stats_.interrupted)
            console_.Warn(fmt::format("one sample in every pixel took {}, more than the time limit of {}",
                                      FormatSeconds(stats_.seconds), FormatSeconds(*a_.timeLimit)));
    }

    ExitStatus Status() {
        if (stats_.interrupted) {
            const std::string when =
                stats_.samplesPerPixel == 0
                    ? "during the first samples"
                    : fmt::format("after {} of {} samples per pixel", stats_.samplesPerPixel,
                                  setup_.sampler->SamplesPerPixel());
            Error(stats_.samples == 0
                      ? "stopped by a signal before the first sample; nothing is written"
                      : fmt::format("stopped by a signal {}; {} holds the image so far", when, OutputName()));
            return Console::StatusOfSignal();
        }
        if (double(stats_.badSamples) > kAllowedBadFraction * double(stats_.cameraRays)) {
            Error(fmt::format("too many invalid samples: {} of {}", stats_.badSamples, stats_.cameraRays));
            return ExitStatus::BadPixels;
        }
        if (stats_.timedOut && a_.spp) {
            Error(fmt::format("the time limit came after {} of {} samples per pixel; {} is valid",
                              stats_.samplesPerPixel, setup_.sampler->SamplesPerPixel(), OutputName()));
            return ExitStatus::TimeLimit;
        }
        return ExitStatus::Complete;
    }

    void Error(const std::string& message) {
        log_.Error(message);
        console_.Error(message);
    }

    const RenderArguments& a_;
    Console console_;
    Log log_;
    RenderSetup setup_;
    std::unique_ptr<AovBuffer> aovs_;
    std::unique_ptr<PassSet> passes_;
    std::unique_ptr<PixelStats> pixelStats_;
    std::unique_ptr<DisplayServer> display_;
    std::optional<Image> reference_;
    std::string mseOut_, mseLines_;
    RenderStats stats_;
    RenderCheckpoint checkpoint_;
    std::pair<int, int> range_;  ///< of the samples
    nlohmann::ordered_json filmDirectives_;
    double parseSeconds_ = 0, buildSeconds_ = 0, writeSeconds_ = 0;
};

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
    app.add_option("--checkpoint-every", a.checkpointEvery, "Seconds of rendering between")
        ->check(CLI::Range(0.1, 1e9))
        ->capture_default_str();
    app.add_option("--resume", a.resume,
                   "State to go on from, to the same bits; --spp may be larger than before")
        ->type_name(kFile);
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
    AddAovOptions(app, a);
    AddCheckpointOptions(app, a);
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

ExitStatus RunRender(const RenderArguments& arguments) {
    CheckArguments(arguments);
    return RenderJob(arguments).Run();
}

constexpr const char* kRenderSynopsis =
    "Lacquer renders pbrt-v4 scenes.\n"
    "Usage: lacquer [render] [OPTIONS] scene.pbrt ...\n"
    "Without a scene file, or with -, the scene is read from standard input.";
constexpr const char* kRenderFooter = R"(
Exit status: 0 the image is complete; 1 wrong usage; 2 the scene is wrong; 3 a file cannot be read or
written; 4 rendered, but with too many invalid samples; 5 the time limit came before --spp was
reached (the image is valid); 129, 130 or 143 stopped by a signal (the image so far is written).)";

}  // namespace

LACQUER_REGISTER(CommandKind, "render", (CommandOf<RenderArguments, AddRenderOptions, RunRender>::Make),
                 {.synopsis = kRenderSynopsis, .footer = kRenderFooter});

}  // namespace lacquer::cmd
