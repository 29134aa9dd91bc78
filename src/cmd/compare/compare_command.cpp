// Command "compare": ways to render a scene against each other at equal time.
#include "cmd/compare/compare_command.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>

#include "cmd/choices.h"
#include "cmd/command_support.h"
#include "cmd/compare/candidates.h"
#include "cmd/compare/images.h"
#include "cmd/compare/report.h"
#include "cmd/compare/results.h"
#include "cmd/console.h"
#include "cmd/earlier_files.h"
#include "cmd/scenes/scene_arguments.h"
#include "cmd/version.h"
#include "compare/fingerprint.h"
#include "pbrt/core/parallel.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/factory.h"

namespace lacquer::cmd {

namespace {

namespace fs = std::filesystem;

/// A reference takes this much more than a run, unless the user says how much: a sixteenth of the variance,
/// which is then subtracted.
constexpr int kReferenceEffort = 16;
/// From here on, the noise of the reference makes itself felt.
constexpr double kNoticeableNoiseShare = 0.1;
/// A run that took less than this part of its time is told of.
constexpr double kFullTime = 0.95;
/// A difference of so many standard errors comes once in 2000 unbiased boxes.
constexpr double kSuspectBias = 3.5;
constexpr size_t kLongestBoxName = 60;

class CompareJob {
  public:
    explicit CompareJob(const CompareArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        ReadArguments();
        CheckOutputFolder(a_.out);
        const ThreadLimit threads(a_.threads);
        setting_.threads = threads.Threads();
        ReadScene();
        plan_.denoiseSeconds = compare::Experiment(plan_, console_).TimeDenoisers();
        for (const char* folder : {"", "images", "crops"})
            MakeOutputFolder((fs::path(a_.out) / folder).string());
        earlierFiles_ = FilesOfEarlierComparison(a_.out);
        Console::CatchSignals();
        Announce();
        for (size_t v = 0; v < NumVariants() && !Console::Signal(); ++v) RunVariant(v);
        if (results_["variants"].empty()) {
            console_.Error("stopped by a signal before anything was finished; there is no report");
            return Console::StatusOfSignal();
        }
        Warn();
        fmt::print("{}", ToText(results_));
        console_.Info(fmt::format("{}: open it in a browser",
                                  (fs::path(a_.out) / "report.html").lexically_normal().string()));
        if (isComplete_) return ExitStatus::Complete;
        console_.Error("stopped by a signal; the report holds what was finished");
        return Console::StatusOfSignal();
    }

  private:
    // ---- What is asked for ----

    void WarnOfApproximation(const compare::Candidate& candidate, const std::string& consequence) {
        // That denoised images are biased needs no warning, but a number, which the report has.
        if (compare::IsDenoised(candidate)) return;
        if (IsApproximate(candidate))
            console_.Warn(fmt::format("\"{}\" is an approximation: {}", candidate.name, consequence));
    }

    void ReadArguments() {
        plan_.candidates = CandidatesOf(a_);
        setting_.subject = plan_.candidates.front().subject;
        for (const compare::Candidate& candidate : plan_.candidates) {
            WarnOfApproximation(candidate, "it has an error that no time takes away");
            setting_.estimators.push_back(candidate.Label());
        }
        setting_.baseline = a_.baseline.empty() ? setting_.estimators.front() : a_.baseline;
        CheckName("--baseline", setting_.baseline, setting_.estimators);
        plan_.baseline =
            size_t(std::find(setting_.estimators.begin(), setting_.estimators.end(), setting_.baseline) -
                   setting_.estimators.begin());
        if (!(a_.time > 0) || !std::isfinite(a_.time))
            BadOption("time", fmt::format("{}", a_.time), "a positive number of seconds");
        if (a_.equalSamples)
            plan_.budget.samplesPerPixel = *a_.equalSamples;
        else
            plan_.budget.seconds = a_.time;
        plan_.runs = a_.runs;
        plan_.seed = a_.seed;
        ReadReferencePlan();
        plan_.textures = DefaultTextureMemory();
        if (!a_.resolution.empty()) plan_.film.resolution = ParseResolution("resolution", a_.resolution);
        try {
            if (!a_.vary.empty()) variation_ = compare::ParseVariation(a_.vary);
        } catch (const std::invalid_argument& e) {
            throw CLI::ValidationError(fmt::format("--vary {}", e.what()));
        }
        setting_.command = a_.command;
        setting_.scene = FirstSceneName(a_.scenes);
        setting_.budget = plan_.budget;
        setting_.runs = plan_.runs;
    }

    /// True of images in the folder, but for the reference, which stays.
    bool IsMadeAnew(const std::string& image) const {
        std::error_code error;
        const fs::path folder = fs::path(image).parent_path();
        const bool isThere =
            fs::equivalent(folder.empty() ? "." : folder, fs::path(a_.out) / "images", error);
        return isThere && !fs::equivalent(image, fs::path(a_.out) / ReferenceName(""), error);
    }

    void ReadReferencePlan() {
        compare::ReferencePlan& r = plan_.reference;
        r.file = a_.reference;
        r.candidate = ReferenceCandidateOf(a_, setting_.subject);
        if (r.file.empty()) WarnOfApproximation(r.candidate, "what is compared with it gets its error");
        if (a_.referenceTime && !(*a_.referenceTime > 0 && std::isfinite(*a_.referenceTime)))
            BadOption("reference-time", fmt::format("{}", *a_.referenceTime), "a positive number of seconds");
        if (!r.file.empty() && (a_.referenceSpp || a_.referenceTime || !a_.referenceBy.empty()))
            throw CLI::ValidationError(
                "--reference names an image; it goes with none of --reference-by, --reference-spp and "
                "--reference-time, which render one");
        if (!r.file.empty() && IsMadeAnew(r.file))
            throw CLI::ValidationError(
                fmt::format("--reference: {} is in the images of {}, which are made anew; choose another "
                            "folder for --out",
                            r.file, a_.out));
        const auto isPlain = [](const compare::Candidate& c) { return !compare::IsDenoised(c); };
        if (!r.file.empty() && std::none_of(plan_.candidates.begin(), plan_.candidates.end(), isPlain))
            throw CLI::ValidationError(
                "--reference: how noisy an image is can be told by runs that are not denoised only; add "
                "\"none\" to --denoisers");
        if (!r.file.empty() && !a_.vary.empty())
            throw CLI::ValidationError(
                "--reference is one image; with --vary every value has its own, which is rendered");
        if (a_.referenceSpp)
            r.budget.samplesPerPixel = *a_.referenceSpp;
        else if (a_.referenceTime)
            r.budget.seconds = *a_.referenceTime;
        else if (plan_.budget.seconds)
            r.budget.seconds = kReferenceEffort * *plan_.budget.seconds;
        else
            r.budget.samplesPerPixel =
                int(std::min<int64_t>(int64_t(kReferenceEffort) * *a_.equalSamples, 1 << 24));
    }

    void ReadScene() {
        inputs_ = ReadSceneArguments(a_.scenes);
        scene_ = ParseInputs(inputs_, &console_);
        plan_.scene = scene_;
        if (plan_.reference.candidate.name.empty())
            plan_.reference.candidate = CandidateOfScene(scene_, setting_.subject);
        // Every value is tried before hours of work; the first one stays.
        for (size_t v = NumVariants(); v-- > 0;) {
            if (variation_) Vary(v);
            const RenderSetup setup = compare::Experiment(plan_, console_).BuildOnce();
            const compare::Experiment::Frame frame = compare::Experiment::FrameOf(setup);
            if (v + 1 < NumVariants() &&
                (frame.resolution != frame_.resolution || frame.pixels != frame_.pixels))
                throw CLI::ValidationError(
                    fmt::format("--vary {}: images of all values need the same pixels", a_.vary));
            frame_ = frame;
            ExamineCandidates(plan_, setup, v == 0 ? &console_ : nullptr);
        }
        if (a_.equalSamples) CheckEqualSamples();
        ReadBoxes();
        setting_.resolution = frame_.resolution;
        if (!a_.reference.empty()) compare::ReadReference(a_.reference, Frame());
    }

    /// Some samplers take other numbers of samples than they are asked for.
    void CheckEqualSamples() {
        std::vector<std::string> counts;
        std::set<int> different;
        for (const compare::Candidate& candidate : plan_.candidates) {
            SceneDescription scene = plan_.scene;
            Apply(candidate, &scene);
            const PluginEntity& sampler = scene.sampler;
            const Params params = MakeParams(sampler, SamplerKind::kKind, scene.FilesOf(sampler));
            const int count = FactoryOf<SamplerKind>(sampler)({params, frame_.resolution, a_.equalSamples})
                                  ->SamplesPerPixel();
            counts.push_back(fmt::format("{} takes {}", sampler.type, count));
            different.insert(count);
        }
        if (different.size() > 1)
            BadOption("equal-samples", fmt::format("{}", *a_.equalSamples),
                      fmt::format("a number that all samplers take; {}", fmt::join(counts, ", ")));
        const int count = *different.begin();
        if (count == *a_.equalSamples) return;
        console_.Warn(fmt::format("the scene's sampler {} samples per pixel instead of {}", counts.front(),
                                  *a_.equalSamples));
        plan_.budget.samplesPerPixel = count;
    }

    void ReadBoxes() {
        for (const std::string& text : a_.boxes) try {
                AddBox(compare::ParseBox(text, frame_.resolution));
            } catch (const std::invalid_argument& e) {
                throw CLI::ValidationError(fmt::format("--{}", e.what()));
            }
        if (a_.boxes.empty())
            for (const SceneInput& input : inputs_)
                for (const compare::Box& box : SuggestedBoxes(input)) try {
                        AddBox(box);
                    } catch (const std::invalid_argument& e) {
                        console_.Warn(fmt::format("{}: left out: {}", input.name, e.what()));
                    }
        if (setting_.boxes.empty()) setting_.boxes.push_back({"all", frame_.pixels});
    }

    std::vector<compare::Box> SuggestedBoxes(const SceneInput& input) const {
        if (!input.text) return compare::BoxesOfScene(input.name, frame_.resolution);
        std::istringstream text(*input.text);
        return compare::BoxesOfScene(text, frame_.resolution);
    }

    /// Cut to the pixels that are rendered. Errors: std::invalid_argument.
    void AddBox(compare::Box box) {
        const auto fail = [&](const std::string& problem) {
            throw std::invalid_argument(fmt::format("box \"{}\": {}", Excerpt(box.name), problem));
        };
        box.pixels = box.pixels.Intersect(frame_.pixels);
        if (box.pixels.IsEmpty()) fail("it has no pixel that the scene's crop window leaves");
        if (box.name.size() > kLongestBoxName)
            fail(fmt::format("a name has at most {} bytes", kLongestBoxName));
        // Names become parts of file names, where only plain letters are kept.
        for (const compare::Box& other : setting_.boxes)
            if (FileWord(other.name) == FileWord(box.name))
                fail("each name once, also as part of a file's name");
        setting_.boxes.push_back(std::move(box));
    }

    size_t NumVariants() const { return variation_ ? variation_->values.size() : 1; }

    /// Sets the value in the plan's scene.
    void Vary(size_t index) {
        plan_.scene = scene_;
        try {
            compare::Apply(*variation_, variation_->values[index], &plan_.scene);
        } catch (const std::invalid_argument& e) {
            throw CLI::ValidationError(fmt::format("--vary {}: {}", a_.vary, e.what()));
        }
    }

    void Announce() {
        const auto budget = [](const compare::Budget& b) {
            return b.seconds ? FormatSeconds(*b.seconds)
                             : fmt::format("{} sample{} per pixel", b.samplesPerPixel,
                                           b.samplesPerPixel == 1 ? "" : "s");
        };
        const size_t renders = plan_.candidates.size() * size_t(plan_.runs) * NumVariants();
        console_.Info(fmt::format("{} render{} of {} each{}, {} x {} pixels", renders,
                                  renders == 1 ? "" : "s", budget(plan_.budget),
                                  plan_.reference.file.empty()
                                      ? fmt::format(", and {} for {}", budget(plan_.reference.budget),
                                                    NumVariants() > 1 ? "each reference" : "the reference")
                                      : "",
                                  frame_.pixels.Width(), frame_.pixels.Height()));
    }

    // ---- The renders ----

    void RunVariant(size_t index) {
        CompareVariant variant;
        variant.filePrefix = FilePrefix(index);
        if (variation_) {
            Vary(index);
            variant.label = fmt::format("{} = {}", variation_->target, variation_->values[index]);
        }
        compare::Experiment experiment(plan_, console_);
        if (!FindReference(experiment, &variant)) return;
        variant.results = experiment.Run(variant.reference);
        compare::KeepWholeRounds(&variant.results);
        const std::optional<size_t> baseline = BaselineIn(variant.results);
        if (!baseline) return;
        compare::MeasureBoxes(&variant.results, variant.reference, LocalBoxes(), *baseline,
                              plan_.budget.seconds.has_value());
        results_ = results_.is_null() ? ToJson(setting_, true) : results_;
        results_["variants"].push_back(ToJson(variant, setting_.boxes, frame_.pixels.min));
        results_["baseline"] = setting_.baseline;
        isComplete_ = Console::Signal() == 0 && results_["variants"].size() == NumVariants();
        results_["complete"] = isComplete_;
        Write(variant);
    }

    /// Where a stop left the baseline without a run, the first that has one takes its place, unless other
    /// variants have been measured against it. None where nothing can be said.
    std::optional<size_t> BaselineIn(const std::vector<compare::CandidateResult>& results) {
        for (size_t i = 0; i < results.size(); ++i)
            if (results[i].candidate.Label() == setting_.baseline) return i;
        if (results.empty() || !results_.is_null()) return std::nullopt;
        setting_.baseline = results[0].candidate.Label();
        console_.Warn(fmt::format("the baseline has no finished run; {} takes its place", setting_.baseline));
        return 0;
    }

    std::vector<Bounds2i> LocalBoxes() const {
        std::vector<Bounds2i> boxes;
        for (const compare::Box& box : setting_.boxes)
            boxes.push_back({box.pixels.min - frame_.pixels.min, box.pixels.max - frame_.pixels.min});
        return boxes;
    }

    /// An empty image of the size of the runs.
    Image Frame() const {
        Image image({frame_.pixels.Width(), frame_.pixels.Height()}, {"R", "G", "B"});
        image.dataWindow = frame_.pixels;
        image.fullResolution = frame_.resolution;
        image.SetColorSpace(frame_.colorSpace);
        return image;
    }

    /// Takes the user's reference, one kept from before, or a new one. False if stopped before there is one.
    bool FindReference(compare::Experiment& experiment, CompareVariant* variant) {
        variant->referenceFile = ReferenceName(variant->filePrefix);
        variant->isReferenceGiven = !plan_.reference.file.empty();
        if (variant->isReferenceGiven) {
            variant->reference = compare::ReadReference(plan_.reference.file, Frame());
            std::error_code error;
            if (!fs::equivalent(plan_.reference.file, fs::path(a_.out) / variant->referenceFile, error))
                SaveImage(variant->reference.image, variant->referenceFile);
            return true;
        }
        const std::string purpose = ReferencePurpose();
        if (ReadKeptReference(purpose, variant)) return true;
        std::optional<compare::Reference> rendered = experiment.RenderReference();
        if (!rendered) return false;
        variant->reference = std::move(*rendered);
        Metadata& metadata = variant->reference.image.metadata;
        metadata[KeyOf(setting_.subject)] = variant->reference.renderedBy;
        metadata["samplesPerPixel"] = int(std::lround(variant->reference.samplesPerPixel));
        // One that was cut short by a signal is kept as well, but not taken for what was asked for.
        metadata["referenceFor"] = Console::Signal() ? "unfinished " + purpose : purpose;
        SaveImage(variant->reference.image, variant->referenceFile);
        return !Console::Signal();
    }

    /// All that a reference depends on.
    std::string ReferencePurpose() const {
        const compare::ReferencePlan& r = plan_.reference;
        const std::string effort = r.budget.seconds ? fmt::format("{} s", *r.budget.seconds)
                                                    : fmt::format("{} samples", r.budget.samplesPerPixel);
        const std::string who =
            (r.candidate.subject == compare::Subject::Estimators ? "" : KeyOf(r.candidate.subject) + " ") +
            r.candidate.Label();
        return fmt::format("Lacquer {}, scene {:016x}, {}, {}, seed {}, {} x {}", kVersion,
                           compare::FingerprintOf(plan_.scene), who, effort, plan_.seed, frame_.resolution.x,
                           frame_.resolution.y);
    }

    bool ReadKeptReference(const std::string& purpose, CompareVariant* variant) {
        const std::string path = (fs::path(a_.out) / variant->referenceFile).string();
        if (!fs::exists(path)) return false;
        try {
            variant->reference = compare::ReadReference(path, Frame());
        } catch (const std::exception&) {
            return false;  // of another size, or damaged: a new one takes its place
        }
        const Metadata& metadata = variant->reference.image.metadata;
        const auto kept = metadata.find("referenceFor");
        if (kept == metadata.end() || kept->second != MetadataValue(purpose)) {
            console_.Info(
                fmt::format("{}: of another scene, effort or version; a new one takes its place", path));
            return false;
        }
        if (const auto it = metadata.find(KeyOf(setting_.subject)); it != metadata.end())
            if (const auto* name = std::get_if<std::string>(&it->second))
                variant->reference.renderedBy = *name;
        if (const auto it = metadata.find("samplesPerPixel"); it != metadata.end())
            if (const auto* samples = std::get_if<int>(&it->second))
                variant->reference.samplesPerPixel = *samples;
        console_.Info(fmt::format("{}: kept from before", path));
        return true;
    }

    // ---- Files ----

    void SaveImage(Image image, const std::string& name) const {
        image.metadata["Software"] = fmt::format("Lacquer {}", kVersion);
        WriteImage(image, (fs::path(a_.out) / name).string());
    }

    /// Of the images of a variant.
    std::string FilePrefix(size_t index) const {
        return variation_ ? fmt::format("v{}-", index + 1) : std::string();
    }
    static std::string ReferenceName(const std::string& filePrefix) {
        return fmt::format("images/{}reference.exr", filePrefix);
    }
    std::set<std::string> ReferenceNames() const {
        std::set<std::string> names;
        for (size_t v = 0; v < NumVariants(); ++v) names.insert(ReferenceName(FilePrefix(v)));
        return names;
    }

    void ListFile(const std::string& name) { results_["files"].push_back(name); }

    void Write(const CompareVariant& variant) {
        ListFile(variant.referenceFile);
        for (const compare::CandidateResult& result : variant.results) {
            for (size_t run = 0; run < result.images.size(); ++run) {
                Image image = result.images[run];
                image.metadata[KeyOf(setting_.subject)] = result.candidate.Label();
                image.metadata["seed"] = result.records[run].seed;
                image.metadata["samplesPerPixel"] = result.records[run].minSamples;
                image.metadata["firstSample"] = 0;
                SaveImage(image, RunImageName(variant, result.candidate, run));
                ListFile(RunImageName(variant, result.candidate, run));
            }
            reportImages_.emplace_back(RunImageName(variant, result.candidate, 0),
                                       ColoursOnly(result.images[0]));
            Image errors = ErrorMapOf(result, variant.reference);
            SaveImage(errors, ErrorImageName(variant, result.candidate));
            ListFile(ErrorImageName(variant, result.candidate));
            reportImages_.emplace_back(ErrorImageName(variant, result.candidate), std::move(errors));
        }
        reportImages_.emplace_back(variant.referenceFile, ColoursOnly(variant.reference.image));
        for (const std::string& name :
             WriteCrops(variant, setting_.boxes, frame_.pixels.min, (fs::path(a_.out) / "crops").string()))
            ListFile("crops/" + name);
        WriteText((fs::path(a_.out) / "results.json").string(), JsonText(results_, 1) + "\n");
        std::vector<ReportImage> images;
        for (const auto& [name, image] : reportImages_) images.push_back({name, &image});
        WriteText((fs::path(a_.out) / "report.html").string(), MakeCompareReport(results_, images));
        RemoveEarlierFiles(a_.out, earlierFiles_, results_, ReferenceNames());
    }

    void Warn() {
        WarnOfUnevenTimes();
        for (const auto& variant : results_["variants"])
            for (const auto& estimator : variant["estimators"])
                for (const auto& box : estimator["boxes"]) WarnOf(estimator, box);
    }

    /// Few samples of a sampler that prefers some counts: the runs then end before their time.
    void WarnOfUnevenTimes() {
        if (!plan_.budget.seconds) return;
        std::string who;
        for (const auto& variant : results_["variants"])
            for (const auto& e : variant["estimators"])
                if (double(e["seconds"]) < kFullTime * *plan_.budget.seconds)
                    who += fmt::format("{}{} {:.2g} s ({:.0f} samples)", who.empty() ? "" : ", ",
                                       std::string(e["name"]), double(e["seconds"]),
                                       double(e["samples_per_pixel"]));
        if (!who.empty())
            console_.Warn(fmt::format(
                "below {} samples a run stops at a count that is good for {}, before its "
                "{:g} s are over: {}; the ratios are scaled to equal time; more time tightens them",
                kFreeCounts,
                setting_.subject == compare::Subject::Samplers
                    ? "its sampler"
                    : fmt::format("the sampler \"{}\"", scene_.sampler.type),
                *plan_.budget.seconds, who));
    }

    void WarnOf(const nlohmann::ordered_json& estimator, const nlohmann::ordered_json& box) {
        const std::string name = estimator["name"], part = box["name"];
        if (!box["bias"].is_null() && std::abs(double(box["bias"]["z"])) > kSuspectBias)
            console_.Warn(
                fmt::format("{} differs from the reference by {:.2g} % in \"{}\", {:.1f} standard errors: "
                            "one of the two is biased, or has rare bright samples",
                            name, 100 * double(box["bias"]["relative"]), part, double(box["bias"]["z"])));
        if (double(box["shared_errors"]) > 1)
            console_.Warn(fmt::format(
                "errors of whole images of {} in \"{}\" differ from run to run by more than their "
                "pixels explain: intervals are {:.1f} times as wide; more runs tighten them",
                name, part, double(box["shared_errors"])));
        if (double(box["reference_noise_share"]) > kNoticeableNoiseShare)
            console_.Warn(
                fmt::format("{:.0f} % of the squared error of {} in \"{}\" is noise of the reference; it was "
                            "subtracted, but a better reference tightens the intervals",
                            100 * double(box["reference_noise_share"]), name, part));
    }

    const CompareArguments& a_;
    Console console_;
    compare::ExperimentPlan plan_;
    std::vector<SceneInput> inputs_;
    SceneDescription scene_;
    std::optional<compare::Variation> variation_;
    compare::Experiment::Frame frame_;
    CompareSetting setting_;
    nlohmann::ordered_json results_;
    std::set<std::string> earlierFiles_;
    bool isComplete_ = false;
    std::vector<std::pair<std::string, Image>> reportImages_;
};

}  // namespace

ExitStatus RunCompare(const CompareArguments& arguments) { return CompareJob(arguments).Run(); }

}  // namespace lacquer::cmd
