#include "cmd/gaussfit/gaussfit_command.h"

#include <fmt/format.h>
#include <time.h>

#include <filesystem>

#include "cmd/choices.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/gaussfit/report.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::cmd {

namespace {

namespace fs = std::filesystem;

/// Points of the survey: indices, alphas, angles.
constexpr int kSurveyEtas = 3, kSurveyAlphas = 24, kSurveyAngles = 16;
/// A fit that misses means by more than this, or loses more likelihood, is none [standard deviations; nat].
constexpr double kWorstMean = 0.1, kWorstLoss = 0.1;
constexpr size_t kLargestFile = size_t(1) << 20;

double ThreadSeconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/// The best of several runs over queries all over the table's range.
double NanosecondsOf(const gaussfit::LobeTable& table) {
    struct Query {
        float alpha, eta;
        Vec3 w;
    };
    const gaussfit::LobeTable::Content& content = table.Get();
    Rng rng(1);
    std::vector<Query> queries;
    while (queries.size() < 1024) {
        const float index = Lerp(rng.Uniform(), float(content.etaMin), float(content.etaMax));
        const float z = rng.Uniform();
        const Query q{Lerp(rng.Uniform(), 0.01f, 1.f),
                      content.model->event == gaussfit::LobeEvent::Leaving ? 1 / index : index,
                      SphericalDirection(std::sqrt(1 - z * z), z, 2 * Pi * rng.Uniform())};
        gaussfit::GaussianMixture lobe;
        if (table.Find(q.alpha, q.eta, q.w, &lobe)) queries.push_back(q);
    }
    double best = 1;
    volatile float sink = 0;
    for (int run = 0; run < 100; ++run) {
        const double start = ThreadSeconds();
        float sum = 0;
        for (const Query& q : queries) {
            gaussfit::GaussianMixture lobe;
            table.Find(q.alpha, q.eta, q.w, &lobe);
            sum += lobe.parts[0].mean.x + lobe.parts[0].precision.xy;
        }
        sink = sink + sum;
        best = std::min(best, (ThreadSeconds() - start) / double(queries.size()));
    }
    return best * 1e9;
}

class GaussfitJob {
  public:
    explicit GaussfitJob(const GaussfitArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        const std::vector<const gaussfit::LobeModel*> models = Models();
        const ThreadLimit threads(a_.threads);
        Console::CatchSignals();
        if (!a_.noFit) MakeFolder();
        try {
            for (const gaussfit::LobeModel* model : models) a_.noFit ? Read(*model) : Fit(*model);
            if (!a_.report.empty()) WriteReport();
        } catch (const gaussfit::FitStopped&) {
            // Tables that were written before are whole.
            return Console::StatusOfSignal();
        }
        return ExitStatus::Complete;
    }

  private:
    std::vector<const gaussfit::LobeModel*> Models() const {
        std::vector<std::string> known;
        for (const gaussfit::LobeModel& model : gaussfit::LobeModels()) known.emplace_back(model.name);
        for (const std::string& name : a_.models) CheckName("MODEL", name, known);
        std::vector<const gaussfit::LobeModel*> models;
        for (const std::string& name : a_.models.empty() ? known : a_.models)
            models.push_back(gaussfit::FindLobeModel(name));
        return models;
    }

    void MakeFolder() const {
        std::error_code error;
        fs::create_directories(a_.out, error);
        if (error || !fs::is_directory(a_.out, error))
            throw FileError(a_.out, "is no folder, and cannot be made one");
    }

    std::string PathOf(const gaussfit::LobeModel& model) const {
        return (fs::path(a_.out) / fmt::format("{}.txt", model.name)).string();
    }

    void Fit(const gaussfit::LobeModel& model) {
        gaussfit::LobeFitResult fit = gaussfit::FitLobes(model, options_, &console_);
        const gaussfit::LobeError& rms = fit.training.rms;
        const std::string path = PathOf(model), text = fit.table.ToText();
        // What would be a bad file does not take the place of a good one.
        gaussfit::LobeTable::Parse(text, path);
        if (!(rms.meanInSigmas < kWorstMean && rms.lostLikelihood < kWorstLoss))
            throw FileError(path, fmt::format("is left as it is: the new fit misses means by {:.2g} standard "
                                              "deviations and loses {:.2g} nat",
                                              rms.meanInSigmas, rms.lostLikelihood));
        WriteText(path, text);
        console_.Info(fmt::format(
            "{}: {} slices in {}, polynomials in {}; rms error of the mean {:.4f} sigma, of log "
            "L {:.4f} and {:.4f}; {:.5f} nat lost",
            path, fit.training.count, FormatSeconds(fit.sliceSeconds), FormatSeconds(fit.fitSeconds),
            rms.meanInSigmas, rms.logL11, rms.logL22, rms.lostLikelihood));
        if (a_.report.empty()) return;
        GaussfitEntry entry = Survey(std::move(fit.table), text.size());
        entry.sliceSeconds = fit.sliceSeconds;
        entry.fitSeconds = fit.fitSeconds;
        entries_.push_back(std::move(entry));
    }

    void Read(const gaussfit::LobeModel& model) {
        const std::string path = PathOf(model);
        const FileBytes bytes = ReadFileBytes(path, {}, {.maxBytes = kLargestFile});
        gaussfit::LobeTable table = gaussfit::LobeTable::Parse(bytes.View(), path);
        if (table.Get().model != &model)
            throw FileError(path, fmt::format("holds the model {}", table.Get().model->name));
        console_.Info(fmt::format("{}: read", path));
        if (!a_.report.empty()) entries_.push_back(Survey(std::move(table), bytes.size));
    }

    GaussfitEntry Survey(gaussfit::LobeTable table, size_t bytes) {
        if (console_.ShouldStop()) throw gaussfit::FitStopped();
        gaussfit::LobeSurvey survey =
            gaussfit::SurveyTable(table, options_, kSurveyEtas, kSurveyAlphas, kSurveyAngles);
        const gaussfit::LobeErrorSummary errors = gaussfit::Summarize(survey.errors);
        const double nanoseconds = NanosecondsOf(table);
        return {std::move(table), options_, std::move(survey), errors, bytes, nanoseconds, {}, {}};
    }

    void WriteReport() {
        WriteText(a_.report, GaussfitReport(entries_));
        console_.Info(fmt::format("{}: the report", a_.report));
    }

    const GaussfitArguments& a_;
    const gaussfit::LobeFitOptions options_;
    Console console_;
    std::vector<GaussfitEntry> entries_;
};

}  // namespace

void AddGaussfitOptions(CLI::App& app, GaussfitArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    std::vector<std::string> names;
    for (const gaussfit::LobeModel& model : gaussfit::LobeModels()) names.emplace_back(model.name);
    app.add_option("model", a.models, "Models to fit; default: all")
        ->check(OneOf(names))
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--out", a.out,
                   "Folder of the tables, one file MODEL.txt for each; made if it is not there")
        ->type_name(kFolder)
        ->capture_default_str();
    app.add_option("--report", a.report, "HTML page about the tables: slices, lobes, errors")
        ->type_name(kFile);
    app.add_flag("--no-fit", a.noFit, "Reads the tables that are in the folder and writes none");
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No progress");
}

ExitStatus RunGaussfit(const GaussfitArguments& arguments) { return GaussfitJob(arguments).Run(); }

}  // namespace lacquer::cmd
