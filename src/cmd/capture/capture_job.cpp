#include "cmd/capture/capture_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "capture/card/capture_photographs.h"
#include "capture/card/card.h"
#include "capture/card/photograph.h"
#include "capture/svbrdf/maps_file.h"
#include "capture/svbrdf/pixel_fit.h"
#include "capture/svbrdf/views_file.h"
#include "cmd/capture/capture_report.h"
#include "cmd/command_support.h"
#include "cmd/timed_console.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::cmd {
namespace {

using namespace capture;
namespace fs = std::filesystem;

/// Steps between those at which held-out photographs are looked at.
constexpr int kStepsBetweenLooks = 20;
constexpr size_t kMaxResultBytes = size_t(1) << 28;

class CaptureRun {
  public:
    CaptureRun(const CaptureArguments& arguments, MapFitter* fitter, Console* console)
        : a_(arguments),
          fitter_(fitter),
          sizes_(SizesOf(arguments, fitter->Size())),
          console_(console),
          observer_(console, arguments.timeLimit) {}

    ExitStatus Run() {
        const ThreadLimit threads(a_.threads);
        const Clock::time_point start = Clock::now();
        RefuseFolderOf(a_.views.empty() ? PhotographFiles() : std::vector{a_.views});
        CheckOutputFolder(a_.out);
        Console::CatchSignals();
        ReadInput();
        HoldOut();
        MakeOutputFolder(a_.out);
        OpenCheckpoint();  // which may be of another run: nothing is written before
        if (a_.views.empty()) TakeRectified();
        const FitResult::End end = Fit();
        results_.seconds = SecondsSince(start);
        results_.isComplete = end == FitResult::End::Finished;
        if (end == FitResult::End::Stopped && HasCompleteResults())
            return FinishStopped("keeps the maps that it had");
        Write();
        return Finish(end);
    }

  private:
    // ---- Input ----

    /// Maps have names that photographs can have, too. Links are followed.
    void RefuseFolderOf(const std::vector<std::string>& inputs) const {
        std::error_code ignored;
        for (const std::string& input : inputs)
            for (const fs::path& path : {fs::absolute(input), fs::weakly_canonical(input, ignored)})
                if (fs::equivalent(path.parent_path(), a_.out, ignored))
                    throw FileError(a_.out,
                                    fmt::format("has {}, which is read; --out wants another folder", input));
    }

    void ReadInput() {
        if (a_.views.empty())
            ReadCard();
        else
            ReadViewsFile();
        if (const auto power = LightPowerOf(a_)) results_.views.lightPower = *power;
        if (std::ranges::all_of(results_.views.views, &View::isTest))
            throw SceneError({a_.views}, "all views are for tests; expected some to be fitted");
    }

    void ReadViewsFile() {
        results_.title = fs::path(a_.views).filename().string();
        results_.views = ReadViews(a_.views);
        const std::string folder = fs::path(a_.views).parent_path().string();
        std::vector<std::string> images;
        for (const View& view : results_.views.views)
            images.push_back((fs::path(folder) / view.image).string());
        RefuseFolderOf(images);
        photographs_ = ReadViewImages(results_.views, folder.empty() ? "." : folder, sizes_.last);
        for (int size = sizes_.last; size > sizes_.first; size /= 2) photographs_ = Halved(photographs_);
        // Names stay right beside the copy that is written.
        for (View& view : results_.views.views) {
            results_.names.push_back(view.image);
            view.image = fs::absolute(fs::path(folder) / view.image).lexically_normal().string();
        }
    }

    void ReadCard() {
        CaptureOptions options;
        options.size = a_.CardSize();
        options.depth = a_.CardDepth();
        options.response = ResponseOf(a_);
        options.resolution = sizes_.last;
        options.focal = a_.focal;
        options.flash = FlashOf(a_);
        captured_ = CapturePhotographs(PhotographFiles(), options);
        for (const std::string& note : captured_.notes) console_->Info("note: " + note);
        Warn(captured_.warnings);
        results_.title = fs::path(a_.photos.front()).filename().string();
        if (results_.title.empty()) results_.title = a_.photos.front();
        results_.views = captured_.views;
        results_.cardSize = a_.CardSize();
        results_.focal = captured_.calibration.intrinsics.f;
        results_.focalError = captured_.calibration.focalError;
        for (const CapturedPhotograph& photograph : captured_.photographs) {
            const Eigen::Vector3d error = photograph.pose.PositionError();
            results_.names.push_back(fs::path(photograph.file).filename().string());
            results_.card.push_back(
                {photograph.pose.rms, int(photograph.pose.tags.size()), {error.x(), error.y(), error.z()}});
        }
    }
    std::vector<std::string> PhotographFiles() const {
        std::vector<std::string> files;
        std::error_code ignored;
        for (const std::string& path : a_.photos)
            if (fs::is_directory(path, ignored)) {
                const std::vector<std::string> inside = PhotographsOfFolder(path);
                files.insert(files.end(), inside.begin(), inside.end());
            } else {
                files.push_back(path);
            }
        return files;
    }
    void Warn(const std::vector<std::string>& warnings) {
        for (const std::string& warning : warnings) console_->Warn("warning: " + warning);
        results_.warnings.insert(results_.warnings.end(), warnings.begin(), warnings.end());
    }

    /// Evenly spaced over those that are given, which often were taken along a path.
    void HoldOut() {
        if (a_.holdOut == 0) return;
        std::vector<View*> fitted;
        for (View& view : results_.views.views)
            if (!view.isTest) fitted.push_back(&view);
        if (size_t(a_.holdOut) >= fitted.size())
            BadOption("hold-out", fmt::to_string(a_.holdOut),
                      fmt::format("fewer than the {} photographs", fitted.size()));
        for (int k = 0; k < a_.holdOut; ++k)
            fitted[(2 * size_t(k) + 1) * fitted.size() / (2 * size_t(a_.holdOut))]->isTest = true;
    }

    /// The fit reads what is written: by --views it can be repeated from there, with the same bits.
    void TakeRectified() {
        WriteRectified(captured_, a_.out);
        WriteViews(results_.views, PathOf("views.json"));
        captured_.photographs.clear();
        photographs_ = ImagesOfSize(sizes_.first);
    }

    // ---- The fit ----

    FitResult::End Fit() {
        FittedMaps fitted = fitter_->Fit(results_.views, photographs_, Settings("texels"), &observer_);
        results_.fitSettings = std::move(fitted.settings);
        results_.fitFindings = std::move(fitted.findings);
        if (!fitted.doubt.empty() && fitted.fit.end == FitResult::End::Finished) {
            fitted.fit = FallBack(fitted.doubt);
            hasExtras_ = false;
        }
        FitResult fit = std::move(fitted.fit);
        results_.lightPower = fit.lightPower;
        while (fit.end == FitResult::End::Finished && fit.maps.size < sizes_.last) fit = Refined(fit);
        results_.maps = std::move(fit.maps);
        return fit.end;
    }

    FitSettings Settings(const char* name) {
        FitSettings settings;
        settings.iterations = a_.iterations;
        settings.totalVariation = a_.totalVariation;
        settings.fitLightPower = FitsLight(a_);
        settings.testEvery = kStepsBetweenLooks;
        settings.afterStep = [this](const FitStep& step) { Look(step); };
        settings.checkpoint = &*checkpoint_;
        settings.name = name;
        return settings;
    }

    /// What the maps of texels by themselves are where those of the fitter are not to be trusted.
    FitResult FallBack(const std::string& doubt) {
        Warn({doubt + "; the maps are those of a fit without it (--trust-prior keeps its own)"});
        results_.history.clear();
        numSteps_ = 0;
        photographs_ = ImagesOfSize(sizes_.last);
        FittedMaps fitted =
            MakeTexelFitter()->Fit(results_.views, photographs_, Settings("without prior"), &observer_);
        results_.fitSettings = std::move(fitted.settings);
        return std::move(fitted.fit);
    }

    FitResult Refined(const FitResult& coarse) {
        photographs_ = ImagesOfSize(2 * coarse.maps.size);
        FitSettings settings = Settings("doubled");
        settings.iterations = a_.refine;
        return FitDoubled(coarse, results_.views, photographs_, settings, &observer_);
    }
    std::vector<RectifiedImage> ImagesOfSize(int size) const {
        return ReadViewImages(results_.views, a_.views.empty() ? a_.out : "", size);
    }

    void Look(const FitStep& step) {
        const int iteration = numSteps_++;
        if (!step.testRmse && iteration % kStepsBetweenLooks != 0) return;
        results_.history.push_back({iteration, step.inputRmse, step.testRmse});
    }

    // ---- The checkpoint ----

    void OpenCheckpoint() {
        const std::string path = PathOf("checkpoint.safetensors");
        checkpoint_.emplace(path, Problem());
        const bool isThere = fs::exists(path);
        if (a_.resume && isThere) return checkpoint_->Load();
        if (a_.resume)
            console_->Info(fmt::format("there is no {}: beginning anew", path));
        else if (isThere)
            console_->Info(
                fmt::format("{} of a run that was stopped is not used: --resume would go on with it", path));
    }

    /// What the bits of the fit depend on.
    FitCheckpoint::Problem Problem() const {
        FitCheckpoint::Problem problem = fitter_->Problem();
        problem["--iterations"] = fmt::to_string(a_.iterations);
        problem["--refine"] = fmt::to_string(a_.refine);
        problem["--total-variation"] = fmt::to_string(a_.totalVariation);
        problem["--resolution"] = fmt::to_string(sizes_.first);
        problem["--final-resolution"] = fmt::to_string(sizes_.last);
        problem["--light"] =
            fmt::format("{}{}", FitsLight(a_) ? "auto from " : "", fmt::join(results_.views.lightPower, ","));
        if (a_.views.empty()) {
            problem["--size"] = fmt::to_string(a_.CardSize());
            problem["--depth"] = fmt::to_string(a_.CardDepth());
            problem["--focal"] = a_.focal ? fmt::to_string(*a_.focal) : "found";
            problem["--flash"] = fmt::format("{}", fmt::join(FlashOf(a_), ","));
            problem["--response"] = fmt::to_string(int(ResponseOf(a_)));
        }
        problem["--hold-out"] = fmt::to_string(a_.holdOut);
        problem["photographs"] = fmt::format("{:016x}", HashOfPhotographs());
        return problem;
    }
    uint64_t HashOfPhotographs() const {
        uint64_t hash = Hash(results_.views.size);
        for (const View& view : results_.views.views) {
            hash = Hash(hash, view.isTest);
            for (const Point& point : {view.camera, view.light})
                hash = Hash(hash, point[0], point[1], point[2]);
        }
        for (const RectifiedImage& photograph : photographs_)
            for (const double value : photograph.values) hash = Hash(hash, value);
        for (const CapturedPhotograph& photograph : captured_.photographs)
            for (const float value : photograph.rectified.Pixels()) hash = Hash(hash, value);
        return hash;
    }

    // ---- Output ----

    /// Of an earlier run: a stopped one has worse maps, and can go on.
    bool HasCompleteResults() const {
        std::error_code error;
        const std::string path = PathOf("result.json");
        if (fs::file_size(path, error) > kMaxResultBytes || error) return false;
        const auto page = nlohmann::json::parse(ReadFileBytes(path, {}, {.maxBytes = kMaxResultBytes}).View(),
                                                nullptr, false);
        return page.is_object() && page.value("complete", nlohmann::json(false)) == true;
    }

    std::string PathOf(const char* name) const { return (fs::path(a_.out) / name).string(); }

    void Write() {
        results_.command = a_.command;
        results_.fittedLight = FitsLight(a_);
        results_.materialType = a_.as;
        ViewSet lit = results_.views;
        lit.lightPower = results_.lightPower;
        for (const View& view : lit.views) results_.models.push_back(RenderView(results_.maps, lit, view));
        results_.photographs = std::move(photographs_);
        for (size_t i = 0; i < lit.views.size(); ++i)
            results_.rmse.push_back(Rmse(results_.photographs[i], results_.models[i]));
        results_.material = ExportMaterial(results_.maps, a_.out, ExportOf(a_));
        WriteEncodedMaps(results_.maps, a_.out);
        for (const std::string& warning : results_.material.warnings) console_->Warn("warning: " + warning);
        std::error_code ignored;
        fs::remove(PathOf(kLatentName), ignored);  // of an earlier run, whose maps these are not
        if (hasExtras_) fitter_->WriteExtras(a_.out);
        ExportTurntable(lit.size, a_.out, a_.numFrames);
        WriteViews(lit, PathOf("views.json"));
        const nlohmann::ordered_json page = CaptureReportResults(results_);
        WriteText(PathOf("result.json"), JsonText(page, 2) + "\n");
        WriteText(PathOf("report.html"), MakeCaptureReport(results_, page));
    }

    ExitStatus Finish(FitResult::End end) {
        console_->Info(VerdictOf(results_));
        console_->Info(fmt::format("{}: maps of {} x {} texels, material.pbrt, turntable.pbrt, report.html",
                                   a_.out, results_.maps.size, results_.maps.size));
        if (end == FitResult::End::NotFinite) {
            console_->Error(
                "the fit came to values that are no numbers; the maps are the last ones before that");
            return ExitStatus::NotConverged;
        }
        if (end == FitResult::End::Finished) {
            checkpoint_->Remove();
            return ExitStatus::Complete;
        }
        return FinishStopped("has the maps so far");
    }
    ExitStatus FinishStopped(const char* state) {
        const bool isSignal = Console::Signal() != 0;
        console_->Error(fmt::format("stopped {}; {} {}, and --resume goes on",
                                    isSignal ? "by a signal" : "at the end of the time", a_.out, state));
        return isSignal ? Console::StatusOfSignal() : ExitStatus::TimeLimit;
    }

    const CaptureArguments& a_;
    MapFitter* fitter_;
    CaptureSizes sizes_;
    Console* console_;
    TimedConsole observer_;
    CaptureResults results_;
    CapturedPhotographs captured_;
    std::vector<RectifiedImage> photographs_;
    std::optional<FitCheckpoint> checkpoint_;
    int numSteps_ = 0;
    bool hasExtras_ = true;  ///< what the fitter wrote is of the maps that are taken
};

}  // namespace

ExitStatus WriteCard(const CaptureArguments& a, Console* console) {
    if (!a.photos.empty() || !a.views.empty() || !a.out.empty())
        throw CLI::ValidationError(
            "--card writes the card and does nothing else; photographs and --out have no effect");
    CheckOutputFile(a.card);
    WriteText(a.card, CardSvg(a.CardSize()));
    console->Info(
        fmt::format("{}: print it at 100 %; the square of tags then has an edge of {:g} cm, which --size "
                    "must say if it comes out otherwise",
                    a.card, a.CardSize()));
    return ExitStatus::Complete;
}

ExitStatus Capture(const CaptureArguments& a, MapFitter* fitter, Console* console) {
    return CaptureRun(a, fitter, console).Run();
}

}  // namespace lacquer::cmd
