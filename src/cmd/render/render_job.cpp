#include "cmd/render/render_job.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cmd/command_support.h"
#include "cmd/log.h"
#include "cmd/mpi/manager.h"
#include "cmd/mpi/scene_units.h"
#include "cmd/mpi/worker.h"
#include "cmd/render/checkpoint.h"
#include "cmd/render/denoise_render.h"
#include "cmd/render/display.h"
#include "cmd/render/film_record.h"
#include "cmd/scenes/scene_arguments.h"
#include "cmd/version.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/passes.h"
#include "pbrt/image/image.h"
#include "pbrt/integrators/pilot_samples.h"
#include "pbrt/integrators/rendered_image.h"
#include "pbrt/scene/builder.h"

namespace lacquer::cmd {

namespace {

/// More invalid samples than this fraction make the image suspect (exit status 4).
constexpr double kAllowedBadFraction = 1e-5;

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
    /// @param manager, worker  of a render by several processes: null, or one of them
    RenderJob(const RenderArguments& arguments, std::shared_ptr<AssetCache> assets, JobManager* manager,
              JobWorker* worker)
        : a_(arguments),
          assets_(std::move(assets)),
          manager_(manager),
          worker_(worker),
          console_(ConsoleStyle::Detect(arguments.quiet)),
          log_(arguments.logFile, arguments.logLevel),
          noiseTarget_(NoiseTargetOf(arguments)),
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

    /// Of another process than the first.
    void Serve() {
        const ThreadLimit threads(a_.threads);
        const std::optional<LoadOrder> load = worker_->AwaitLoad();
        if (!load) return;
        if (load->filterSamples > 0) filterSamples_ = load->filterSamples;
        Prepare();
        const std::optional<StartOrder> start = worker_->AwaitStart(header_.Text(), AllowedThreads());
        if (!start) return;
        // The manager decides when all end; mpirun sends a signal to every process.
        for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) ::signal(signal, SIG_IGN);
        // Units have films of their own.
        const Int2 corner = setup_.film->PixelBounds().min;
        setup_.film = MakePartOfFilm(header_.film, setup_, {corner, corner + 1});
        aovs_.reset();
        const SceneUnits units = UnitsOf(start->halfBlock);
        worker_->Serve([&](const RenderUnit& unit, Observer& o) { return units.Render(unit, o); });
    }

  private:
    bool IsOneOfSeveral() const { return manager_ || worker_; }

    ExitStatus RunSteps() {
        const ThreadLimit threads(a_.threads);
        filterSamples_ = checkpoint_.FilterSamples();
        if (manager_) manager_->LetLoad(filterSamples_);
        Prepare();
        if (manager_) manager_->AwaitLoaded(header_);
        if (stats_.interrupted) return Status();
        ConnectDisplay();
        ReadReference();
        // Before this a signal simply ends the process: there is nothing to save yet.
        Console::CatchSignals();
        // mpirun passes it on, and does not kill its processes right after, as it does for others.
        if (manager_) Console::CatchUserSignal();
        RenderImage();
        if (stats_.samples == 0) return Status();  // stopped at once: what was there stays
        const Clock::time_point writing = Clock::now();
        std::unique_ptr<Image> image = Develop(stats_.samplesPerPixel);
        if (a_.denoise) DenoiseRender(denoise::MethodOf(a_.denoiser), a_.aovs, &console_, image.get());
        WriteImage(image, OutputName());
        if (pixelStats_)
            lacquer::WriteImage(*pixelStats_->Develop(setup_.film->Resolution()), PixelStatsName(), false);
        checkpoint_.Finish(stats_.seconds,
                           stats_.reachedNoise ? std::optional(stats_.samplesPerPixel) : std::nullopt);
        writeSeconds_ = SecondsSince(writing);
        FinishDisplay();
        Report();
        WarnOfMissedLimit();
        return Status();
    }

    void Prepare() {
        if (!a_.statsJson.empty() && a_.statsJson != "-") CheckOutputFile(a_.statsJson);
        BuildOptions options = BuildOptionsOf(a_);
        options.filterSamples = filterSamples_;
        options.assets = assets_;
        Clock::time_point start = Clock::now();
        for (const std::string& path : a_.scenes)
            if (std::error_code error; std::filesystem::is_fifo(path, error))
                console_.Info(fmt::format("reading the scene from the pipe {}", path));
        const std::vector<SceneInput> inputs = ReadSceneArguments(a_.scenes);
        SceneDescription description = ParseInputs(inputs, &console_);
        for (const compare::Variation& setting : a_.settings) Set(setting, &description);
        const std::vector<std::string> sceneFiles = description.files;
        if (checkpoint_.IsUsed() || IsOneOfSeveral()) filmDirectives_ = FilmDirectives(description);
        parseSeconds_ = SecondsSince(start);
        log_.Info(fmt::format("parsed in {:.3f} s", parseSeconds_));
        start = Clock::now();
        setup_ = BuildScene(std::move(description), options, &console_);
        buildSeconds_ = SecondsSince(start);
        log_.Info(fmt::format("built in {:.3f} s: {} primitives, {} lights", buildSeconds_,
                              setup_.scene->NumPrimitives(), setup_.scene->Lights().size()));
        if (!worker_) CheckImageOutput(OutputName());
        if (!worker_) CheckOutputs(sceneFiles);
        const bool wantsAlphaAlone = a_.aovs == std::vector<std::string>{"alpha"};
        if (!a_.aovs.empty() && !IsEXR(OutputName()) && !(wantsAlphaAlone && HoldsAlpha(OutputName())))
            throw CLI::ValidationError(fmt::format(
                "--aov needs an EXR file for its channels; \"{}\" holds colours only", OutputName()));
        if (a_.spp && !a_.quick && setup_.samplesPerPixel != *a_.spp)
            console_.Warn(fmt::format("the scene's sampler takes {} samples per pixel instead of {}",
                                      setup_.samplesPerPixel, *a_.spp));
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
        range_ = SampleRangeOf(a_, setup_.samplesPerPixel);
        RefuseSharedLight();
        RefuseChains();
        if (IsOneOfSeveral()) RefuseWhatIsAlone();
        if (a_.adaptive) MeasureShares();
        // Of frames after the first, a signal comes while pilots are taken.
        stats_.interrupted = console_.ShouldStop();
        if (stats_.interrupted) return;
        if (a_.denoise)
            CheckDenoiser(denoise::MethodOf(a_.denoiser), FewestSamples(), setup_.integrator->MakesSplats());
        if (checkpoint_.IsUsed() || IsOneOfSeveral()) MakeHeader(sceneFiles, inputs);
        if (checkpoint_.IsUsed()) AttachCheckpoint();
    }

    /// What a scene can ask for and several processes cannot do.
    void RefuseWhatIsAlone() const {
        const char* option = setup_.options.pixelStats                   ? "--pixelstats"
                             : !setup_.options.mseReferenceImage.empty() ? "--mse-reference-image"
                                                                         : nullptr;
        if (option)
            throw CLI::ValidationError(
                fmt::format("{} looks at one process; it does not go with --mpi", option));
        if (setup_.integrator->UsesGuide())
            throw CLI::ValidationError(
                "--mpi divides an image into parts, and a guide learns from all of it; without \"bool "
                "guiding\" "
                "the integrator can, and with it --sample-range and --cropwindow divide the work");
        const Film& film = *setup_.film;
        // All sums of all pixels are one message, and splats have three more.
        constexpr size_t kBytesOfSplats = 3 * 17;
        size_t bytes = film.MemoryBytes() + (aovs_ ? aovs_->MemoryBytes() : 0);
        if (setup_.integrator->MakesSplats()) bytes += kBytesOfSplats * size_t(film.PixelBounds().Area());
        if (UsesAllPixels() && bytes > mpi::Messenger::kMaxBytes)
            throw CLI::ValidationError(fmt::format(
                "with light that is traced from the lights, a message of --mpi holds all pixels: {} bytes, "
                "of which it can have {}; see lacquer farm",
                bytes, mpi::Messenger::kMaxBytes));
    }

    /// True if light that is traced from the lights is for all pixels.
    bool UsesAllPixels() const {
        return setup_.integrator->MakesSplats() || setup_.integrator->SharesSamples();
    }
    void RefuseSharedLight() const {
        const char* option = a_.adaptive ? "--adaptive" : noiseTarget_ > 0 ? "--noise-target" : nullptr;
        if (!option || !UsesAllPixels()) return;
        throw CLI::ValidationError(fmt::format(
            "{} needs pixels whose light their own samples find, and the integrator of this scene {}; "
            "\"path\" and \"volpath\" do not",
            option,
            setup_.integrator->MakesSplats() ? "traces light from the lights to any pixel"
                                             : "has photons that all pixels share"));
    }

    /// Each path of a Markov chain follows from the one before: no sample is made without those before it.
    void RefuseChains() const {
        const char* option = !a_.sampleRange.empty()     ? "--sample-range"
                             : !a_.checkpoint.empty()    ? "--checkpoint"
                             : !a_.resume.empty()        ? "--resume"
                             : IsOneOfSeveral()          ? "--mpi"
                             : setup_.options.pixelStats ? "--pixelstats"
                                                         : nullptr;
        if (option && setup_.integrator->UsesChains())
            throw CLI::ValidationError(fmt::format(
                "{} needs samples that do not depend on each other, and the integrator of this scene follows "
                "Markov chains across the image; \"bdpt\" does not",
                option));
    }

    void MeasureShares() {
        const Clock::time_point start = Clock::now();
        const RenderOptions options = RenderOptionsOf(setup_);
        // As when the render began: with more samples, it would divide them otherwise.
        const int samples = checkpoint_.FilterSamples().value_or(setup_.samplesPerPixel);
        shares_ = lacquer::MeasureShares(*setup_.scene, *setup_.integrator, *setup_.film,
                                         {samples, options.seed, options.jitter}, console_);
        pilotSeconds_ = SecondsSince(start);
        checkpoint_.AddSeconds(pilotSeconds_);
        log_.Info(fmt::format("pilot samples in {:.3f} s", pilotSeconds_));
        if (!shares_->AreEven())
            setup_.sampler = std::move(setup_.longSampler);
        else if (!console_.ShouldStop())
            console_.Info(
                "--adaptive: by its pilots this image would gain less than a twentieth; every pixel gets the "
                "same number of samples");
    }
    /// That any pixel gets.
    int FewestSamples() const {
        return shares_ ? int(shares_->FewestOf(range_.first, range_.second)) : range_.second - range_.first;
    }
    const SampleShares* Shares() const { return shares_ ? &*shares_ : nullptr; }

    /// "camera.fov=40", one after another.
    std::string Settings() const {
        std::string text;
        for (const compare::Variation& setting : a_.settings)
            text += fmt::format("{}{}={}", text.empty() ? "" : ", ", setting.target, setting.values[0]);
        return text;
    }
    static void Set(const compare::Variation& setting, SceneDescription* scene) {
        try {
            compare::Apply(setting, setting.values[0], scene);
        } catch (const std::invalid_argument& e) {
            throw CLI::ValidationError(fmt::format("--vary {}: {}", setting.target, e.what()));
        }
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

    void MakeHeader(const std::vector<std::string>& sceneFiles, const std::vector<SceneInput>& inputs) {
        std::string text;
        for (const SceneInput& input : inputs) text += input.text.value_or("");
        header_ = HeaderOf(setup_, sceneFiles, text, aovs_.get(), passes_.get(),
                           {{"estimator", a_.estimator},
                            {"layered-pdf", a_.layeredPdf},
                            {"disable-image-textures", a_.disableImageTextures},
                            {"cryptomatte-ranks", a_.cryptomatteRanks},
                            {"vary", Settings()},
                            {"noise-target", noiseTarget_ > 0}});
        if (shares_) header_.settings["adaptive"] = fmt::format("{:016x}", shares_->Fingerprint());
        header_.film = FilmRecord(filmDirectives_, setup_, aovs_.get(), a_.cryptomatteRanks, passes_.get());
        header_.name = SceneName();
        header_.filterSamples = setup_.samplesPerPixel;
        header_.halfBlock =
            noiseTarget_ > 0 ? kNoiseHalfBlock : BestHalfBlock(setup_.samplesPerPixel, shares_.has_value());
    }

    void AttachCheckpoint() {
        if (setup_.integrator->MakesSplats()) setup_.film->PrepareForSplats(MaxThreads());
        checkpoint_.Attach(header_, range_, Shares(), setup_.film.get(), aovs_.get());
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

    RenderOptions OptionsOfRender() {
        RenderOptions options = RenderOptionsOf(setup_);
        options.firstSample = range_.first;
        options.endSample = range_.second;
        checkpoint_.AddTo(&options);
        if (a_.timeLimit) options.timeLimit = std::max(*a_.timeLimit - pilotSeconds_, 1e-3);
        options.shares = Shares();
        options.noiseTarget = noiseTarget_;
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
        stats_ = manager_ ? RenderWithOthers(options)
                          : Render(*setup_.scene, *setup_.integrator, *setup_.sampler, *setup_.film, options,
                                   console_);
        log_.Info(fmt::format("rendered in {:.3f} s", stats_.seconds));
    }

    SceneUnits UnitsOf(int halfBlock) const {
        return {&setup_, header_.film, a_.Aovs(), a_.cryptomatteRanks, passes_.get(), halfBlock};
    }

    RenderStats RenderWithOthers(const RenderOptions& options) {
        if (setup_.integrator->MakesSplats()) setup_.film->PrepareForSplats(1);
        ManagedRender render;
        // As it was when the render began, where there is a state to go on from.
        render.halfBlock = options.halfBlock > 0 ? options.halfBlock : header_.halfBlock;
        const SceneUnits units = UnitsOf(render.halfBlock);
        render.render = [&](const RenderUnit& unit, Observer& o) { return units.Render(unit, o); };
        render.film = setup_.film.get();
        render.aovs = aovs_.get();
        render.range = range_;
        render.wholeImages = UsesAllPixels();
        render.threads = AllowedThreads();
        render.options = &options;
        if (a_.writePartialImages || display_) render.showImage = options.afterPass;
        const RenderStats stats = manager_->Render(render, &console_);
        const JobTraffic& traffic = manager_->Traffic();
        log_.Info(fmt::format("added {} results, {} bytes, in {:.3f} s", traffic.results, traffic.bytes,
                              traffic.seconds));
        return stats;
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
        origin.seconds = checkpoint_.SecondsBefore() + pilotSeconds_ + stats_.seconds;
        origin.showsSampleCounts = (PixelsDiffer(stats_) || shares_) && IsEXR(OutputName());
        origin.software = fmt::format("Lacquer {}", kVersion);
        origin.scene = SceneName();
        std::unique_ptr<Image> image = DevelopRender(setup_, aovs_.get(), passes_.get(), origin);
        // Halves that the noise is measured by.
        if (noiseTarget_ > 0 && !AovBuffer::NeedsHalves(a_.Aovs())) *image = AovBuffer::WithoutHalves(*image);
        return image;
    }

    std::string SceneName() const {
        return std::filesystem::path(FirstSceneName(a_.scenes)).filename().string();
    }

    /// "33 samples", "33 to 34 samples" or "33 samples on average (5 to 180)".
    std::string SamplesInWords() const {
        if (shares_) {
            const std::vector<int> counts = setup_.film->SampleCounts();
            const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
            return fmt::format("{:.4g} samples on average ({} to {})",
                               double(stats_.samples) / double(counts.size()), *least, *most);
        }
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
        const RenderCosts costs = {parseSeconds_, buildSeconds_, pilotSeconds_, writeSeconds_,
                                   int64_t(usage.ru_maxrss) * 1024};
        return StatisticsText(setup_, stats_, costs, kVersion, OutputName());
    }

    void Report() {
        const double rays = double(stats_.raysTraced + stats_.shadowRays);
        console_.Info(fmt::format(
            "{}: {} x {} pixels, {} each, {} after {} of loading{} ({}samples/s, {}rays/s)", OutputName(),
            setup_.film->PixelBounds().Width(), setup_.film->PixelBounds().Height(), SamplesInWords(),
            FormatSeconds(stats_.seconds), FormatSeconds(parseSeconds_ + buildSeconds_),
            shares_ ? fmt::format(" and {} of pilot samples", FormatSeconds(pilotSeconds_)) : "",
            FormatCount(double(stats_.cameraRays) / std::max(stats_.seconds, 1e-9)),
            FormatCount(rays / std::max(stats_.seconds, 1e-9))));
        ReportNoise();
        if (a_.stats) console_.Print(Statistics());
        if (a_.statsJson == "-")
            fmt::print("{}\n", Statistics());
        else if (!a_.statsJson.empty())
            WriteText(a_.statsJson, Statistics() + "\n");
        if (stats_.badSamples > 0)
            console_.Warn(fmt::format("{} of {} samples were NaN, infinite or negative and count as black",
                                      stats_.badSamples, stats_.cameraRays));
    }

    void ReportNoise() {
        if (noiseTarget_ <= 0) return;
        const std::string target = fmt::format("the target of {:.2g} %", 100 * noiseTarget_);
        if (!stats_.noise) {
            console_.Warn(fmt::format("{} was not looked at: that takes {} samples per pixel", target,
                                      FirstNoiseCount(shares_.has_value())));
            return;
        }
        const std::string noise =
            fmt::format("the relative error of 95 % of the pixels is {:.2g} % after {} samples per pixel",
                        100 * *stats_.noise, stats_.noiseSamples);
        if (stats_.reachedNoise)
            console_.Info(noise);
        else if (stats_.timedOut || stats_.interrupted)
            console_.Warn(fmt::format("{}, above {}", noise, target));
        else
            console_.Warn(fmt::format("{}, above {}; --spp allows more", noise, target));
    }

    void WarnOfMissedLimit() {
        if (a_.timeLimit &&
            pilotSeconds_ + stats_.seconds > std::max(1.02 * *a_.timeLimit, *a_.timeLimit + 0.2) &&
            !stats_.interrupted)
            console_.Warn(fmt::format("one sample in every pixel took {}, more than the time limit of {}",
                                      FormatSeconds(pilotSeconds_ + stats_.seconds),
                                      FormatSeconds(*a_.timeLimit)));
    }

    ExitStatus Status() {
        if (stats_.interrupted) {
            const std::string when = stats_.samplesPerPixel == 0
                                         ? "during the first samples"
                                         : fmt::format("after {} of {} samples per pixel",
                                                       stats_.samplesPerPixel, setup_.samplesPerPixel);
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
                              stats_.samplesPerPixel, setup_.samplesPerPixel, OutputName()));
            return ExitStatus::TimeLimit;
        }
        return ExitStatus::Complete;
    }

    void Error(const std::string& message) {
        log_.Error(message);
        console_.Error(message);
    }

    const RenderArguments& a_;
    std::shared_ptr<AssetCache> assets_;  ///< outlives the scene
    JobManager* manager_;                 ///< of a render by several processes; else null
    JobWorker* worker_;                   ///< this process is one of the others; else null
    Console console_;
    Log log_;
    RenderSetup setup_;
    std::unique_ptr<AovBuffer> aovs_;
    std::unique_ptr<PassSet> passes_;
    std::unique_ptr<PixelStats> pixelStats_;
    std::unique_ptr<DisplayServer> display_;
    std::optional<Image> reference_;
    std::string mseOut_, mseLines_;
    std::optional<SampleShares> shares_;
    RenderStats stats_;
    const double noiseTarget_;
    RenderCheckpoint checkpoint_;
    std::pair<int, int> range_;         ///< of the samples
    std::optional<int> filterSamples_;  ///< of a render to go on from
    StateHeader header_;                ///< of states, and by which processes know that they render the same
    nlohmann::ordered_json filmDirectives_;
    double parseSeconds_ = 0, buildSeconds_ = 0, pilotSeconds_ = 0, writeSeconds_ = 0;
};

}  // namespace

ExitStatus RunRenderJob(const RenderArguments& arguments, std::shared_ptr<AssetCache> assets,
                        JobManager* manager) {
    return RenderJob(arguments, std::move(assets), manager, nullptr).Run();
}

void ServeRenderJob(const RenderArguments& arguments, JobWorker* worker) {
    RenderJob(arguments, nullptr, nullptr, worker).Serve();
}

}  // namespace lacquer::cmd
