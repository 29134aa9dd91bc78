// lacquer bulk: from particles to a table that media and slabs render.
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "bulk/input/particles_input.h"
#include "bulk/table/bulk_computation.h"
#include "bulk/table/bulk_problem.h"
#include "cmd/bulk/bulk_output.h"
#include "cmd/bulk/bulk_plan.h"
#include "cmd/bulk/bulk_run.h"
#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/version.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {
namespace {

using namespace bulk;

constexpr int kDefaultRealizations = 50, kRealizationLimit = 1000000;

/// Everything that the command line of `bulk` can say.
struct BulkArguments {
    std::string command;  ///< the command line, as it was given
    std::string input, out, wavelengths, error, time, report;
    std::optional<int> realizations;
    std::optional<uint64_t> seed;
    int threads = 0;
    bool quiet = false, resume = false, dryRun = false, checkDegree = false;
};

/// "550", "400:700:50" or "450,550,650"; empty if the option is not given. Errors: usage.
std::vector<double> ParseWavelengths(const std::string& text) {
    if (text.empty()) return {};
    const char separator = text.find(':') != std::string::npos ? ':' : ',';
    std::vector<double> numbers;
    std::istringstream in(text);
    double number = 0;
    char read = separator;
    while (read == separator && in >> number) {
        numbers.push_back(number);
        read = 0;
        in >> read;
    }
    bool isFine = in.eof() && read == 0;
    if (separator == ':')
        numbers =
            numbers.size() == 3 ? EvenWavelengths(numbers[0], numbers[1], numbers[2]) : std::vector<double>();
    isFine = isFine && !numbers.empty() && numbers.size() <= size_t(kMaxWavelengths);
    for (size_t i = 0; isFine && i < numbers.size(); ++i)
        isFine = numbers[i] >= (i > 0 ? numbers[i - 1] + 1e-3 : 1) && numbers[i] <= 1e6;
    if (!isFine)
        BadOption("wavelengths", text,
                  fmt::format("BEGIN:END:STEP, or growing numbers with commas between, at most {} [nm]",
                              kMaxWavelengths));
    return numbers;
}

/// A positive number and one of some units, or no unit; 0 if the option is not given. Errors: usage.
double ParseQuantity(const std::string& option, const std::string& text,
                     const std::vector<std::pair<std::string, double>>& units, const std::string& expected) {
    if (text.empty()) return 0;
    std::istringstream in(text);
    double number = 0;
    std::string unit, rest;
    in >> number;
    const bool isNumber = !in.fail();
    in >> unit >> rest;
    double factor = unit.empty() ? 1 : 0;
    for (const auto& [name, value] : units)
        if (unit == name) factor = value;
    number *= factor;
    if (!isNumber || !rest.empty() || !(number > 0) || !(number < 1e9)) BadOption(option, text, expected);
    return number;
}

BulkLimits LimitsOf(const BulkArguments& a) {
    BulkLimits limits;
    limits.error = ParseQuantity("error", a.error, {{"%", 0.01}}, "a positive number, as in 1% or 0.01");
    limits.seconds = ParseQuantity("time", a.time, {{"s", 1}, {"m", 60}, {"h", 3600}},
                                   "a positive number of seconds, as in 90, 90s, 10m or 2h");
    const bool isOpen = limits.error > 0 || limits.seconds > 0;
    limits.maxRealizations = a.realizations.value_or(isOpen ? kRealizationLimit : kDefaultRealizations);
    return limits;
}

/// One table, from arguments to the written file.
class BulkJob {
  public:
    explicit BulkJob(const BulkArguments& arguments)
        : a_(arguments), limits_(LimitsOf(arguments)), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        const ThreadLimit threads(a_.threads);
        input_ = ReadParticles(a_.input, {ParseWavelengths(a_.wavelengths), a_.seed});
        if (!a_.dryRun) Console::CatchSignals();
        Plan();
        if (a_.dryRun) return ExitStatus::Complete;
        const BulkFiles files{a_.out, a_.report, a_.command};
        const std::unique_ptr<BulkOutput> output =
            input_.oriented ? MakeOrientedOutput(input_, files) : MakeIsotropicOutput(input_, files);
        CheckFiles(*output);
        BulkRun run(output->Computations(), input_, limits_, PartName(), kVersion, &console_);
        if (!a_.resume) CheckNoCheckpoint();
        CheckRealizations(*output);
        if (HasClusters() && a_.resume) Resume(output.get(), &run);
        const BulkRun::End end = run.Solve();
        if (end == BulkRun::End::Signal) return Stopped(run);
        try {
            output->WriteTable();
        } catch (const SceneError& error) {
            throw SceneError(input_.placeOfArrangement, error.Message());
        }
        run.RemoveCheckpoint();
        output->Tell(&console_);
        if (!a_.report.empty()) output->WritePage();
        if (a_.checkDegree && HasClusters()) CheckDegree();
        if (end != BulkRun::End::Time || (!a_.realizations && limits_.error == 0))
            return ExitStatus::Complete;
        console_.Error(fmt::format("the time came before {}; {} is valid",
                                   a_.realizations ? fmt::format("{} realisations", *a_.realizations)
                                                   : fmt::format("the error {}", a_.error),
                                   a_.out));
        return ExitStatus::TimeLimit;
    }

  private:
    bool HasClusters() const { return input_.settings.method == BulkMethod::Clusters; }

    // ---- Before the work ----

    void Plan() {
        if (!HasClusters()) return;
        for (const BulkSettings& settings : SettingsOf(input_)) {
            BulkPlan plan = PlanOf(settings, input_.oriented);
            CheckMemory(plan);
            if (a_.dryRun) {
                MeasureTime(settings, &plan);
                fmt::print("{}", ToText(plan, std::min(limits_.maxRealizations,
                                                       a_.realizations.value_or(kDefaultRealizations))));
            }
            for (const std::string& warning : WarningsOf(settings, plan)) console_.Warn(warning);
        }
    }

    /// And makes the folder of the report: what cannot be written is said before the work.
    void CheckFiles(const BulkOutput& output) const {
        if (a_.out.empty()) throw CLI::ValidationError("--out is required (but for --dry-run)");
        CheckOutputFile(a_.out);
        CheckOutIsNoInput();
        output.CheckFiles();
        if (a_.report.empty()) return;
        CheckOutputFolder(a_.report);
        std::error_code ignored;
        for (const std::string& file : {a_.out, PartName()})
            if (file.empty() || std::filesystem::weakly_canonical(a_.report, ignored) ==
                                    std::filesystem::weakly_canonical(file, ignored))
                BadOption("report", a_.report, "a folder, and for --out a regular file beside or in it");
        MakeOutputFolder(a_.report);
        CheckOutputFile(a_.report + "/report.html");
    }

    void CheckOutIsNoInput() const {
        std::error_code ignored;
        if (std::filesystem::equivalent(a_.input, a_.out, ignored))
            BadOption("out", a_.out, "another file than the particles");
    }

    void CheckMemory(const BulkPlan& plan) const {
        const double bytes = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGE_SIZE));
        if (plan.memory > bytes)
            throw SceneError(input_.placeOfArrangement,
                             fmt::format("{} particles need {:.3g} GB of memory, and this machine has {:.3g} "
                                         "GB; expected fewer particles, or fewer wavelengths",
                                         plan.count, plan.memory / 1e9, bytes / 1e9));
    }

    /// Of the checkpoint; empty if the table goes to a device or a pipe.
    std::string PartName() const {
        std::error_code ignored;
        const bool isSpecial =
            std::filesystem::exists(a_.out, ignored) && !std::filesystem::is_regular_file(a_.out, ignored);
        return isSpecial ? "" : a_.out + ".part";
    }

    void CheckNoCheckpoint() const {
        if (HasClusters() && access(PartName().c_str(), F_OK) == 0)
            throw FileError(PartName(),
                            "is the checkpoint of a run that did not end: --resume goes on with it; without "
                            "this file the work begins anew");
    }

    void CheckRealizations(BulkOutput& output) const {
        for (const EnsembleComputation* computation : output.Computations())
            if (const int needed = computation->NumNeeded(); limits_.maxRealizations < needed)
                BadOption("realisations", std::to_string(limits_.maxRealizations),
                          fmt::format("at least {}, as the average \"medium\" or \"chapter\" is one of pairs",
                                      needed));
    }

    void Resume(BulkOutput* output, BulkRun* run) {
        if (PartName().empty())
            return console_.Info("there are no checkpoints beside a device: beginning anew");
        if (!run->Resume()) return console_.Info(fmt::format("there is no {}: beginning anew", PartName()));
        for (const EnsembleComputation* computation : output->Computations())
            if (computation->NumRealizations() > limits_.maxRealizations)
                BadOption("realisations", std::to_string(limits_.maxRealizations),
                          fmt::format("at least {}, as {} has them already", computation->NumRealizations(),
                                      PartName()));
    }

    // ---- After it ----

    ExitStatus Stopped(const BulkRun& run) {
        const int done = run.NumRealizations();
        if (done == 0 || PartName().empty())
            console_.Error("stopped by a signal; nothing is written");
        else
            console_.Error(
                fmt::format("stopped by a signal after {} realisations; {} holds them, and --resume goes on",
                            done, PartName()));
        return Console::StatusOfSignal();
    }

    /// One realisation with two degrees more, at the shortest wavelength.
    void CheckDegree() {
        ScatteringAverage averages[2];
        int degrees[2];
        for (int i = 0; i < 2; ++i) {
            BulkSettings settings = SettingsOf(input_).back();
            settings.wavelengths.resize(1);
            settings.mode = AverageMode::Aggregate;
            settings.realization.extraDegree += 2 * i;
            BulkComputation computation(settings);
            computation.AddRealizations(1, nullptr);
            if (computation.NumAveraged(0) == 0)
                return console_.Warn("the degree cannot be checked: no solution");
            averages[i] = computation.AverageAt(0);
            if (!(averages[i].scattering.mean > 0))
                return console_.Warn("the degree cannot be checked: the first realisation has no particles");
            degrees[i] = DegreesAt(settings, computation.GetEnsemble(), settings.wavelengths[0]).spheres;
        }
        const auto change = [&](ScatteringAverage::Value ScatteringAverage::*value) {
            return 100 * ((averages[1].*value).mean / (averages[0].*value).mean - 1);
        };
        console_.Info(fmt::format(
            "degree {} instead of {} at {:g} nm: C_ext {:+.2g} %, C_sca {:+.2g} %, g "
            "{:+.2g}",
            degrees[1], degrees[0], input_.settings.wavelengths[0], change(&ScatteringAverage::extinction),
            change(&ScatteringAverage::scattering), averages[1].g.mean - averages[0].g.mean));
    }

    const BulkArguments& a_;
    BulkLimits limits_;
    Console console_;
    ParticlesInput input_;
};

void AddBulkOptions(CLI::App& app, BulkArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("input", a.input, "What the particles are: a JSON file (docs/bulk.md)")
        ->type_name(kFile)
        ->required();
    app.add_option("--out", a.out, "File for the table; needed unless --dry-run is given")->type_name(kFile);
    app.add_option("--report", a.report, "Folder for a page about the table, report.html")
        ->type_name(kFolder);
    CLI::Option* count =
        app.add_option("--realisations", a.realizations,
                       fmt::format("Random clusters to average, of each size; {} if neither --error nor "
                                   "--time is given",
                                   kDefaultRealizations))
            ->check(CLI::Range(1, kRealizationLimit));
    app.add_option("--error", a.error,
                   "As many as it takes until the standard errors of C_ext, C_sca (relative) and g are no "
                   "larger: 1% or 0.01")
        ->excludes(count);
    app.add_option("--time", a.time, "No longer than this: 90s, 10m, 2h");
    app.add_option("--wavelengths", a.wavelengths,
                   "BEGIN:END:STEP or A,B,...: wavelengths in vacuum [nm] instead of the file's");
    app.add_option("--seed", a.seed, "Seed of all random numbers instead of the file's")
        ->check(CLI::Range(uint64_t(0), uint64_t(1) << 53));
    app.add_flag("--resume", a.resume,
                 "Go on from FILE.part, which a run leaves that was stopped; the result has the same bits");
    app.add_flag("--dry-run", a.dryRun, "Only tell what would be computed: sizes, memory, time, warnings");
    app.add_flag("--check-degree", a.checkDegree,
                 "Solve one realisation again with two degrees more, and tell what changes");
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No progress and no warnings");
}

ExitStatus RunBulk(const BulkArguments& arguments) { return BulkJob(arguments).Run(); }

constexpr const char* kBulkSynopsis =
    "Computes how a medium of many small particles scatters light, from Maxwell's equations: coefficients\n"
    "and phase functions, for the parameter \"bulk\" of media and slabs.\n"
    "Usage: lacquer bulk [OPTIONS] particles.json --out FILE";
constexpr const char* kBulkFooter = R"(
Exit status: 0 the table is written; 1 wrong usage; 2 the particles make no sense, or find no places; 3 a
file cannot be read or written; 5 the time came before --realisations or --error was reached (the table
is valid); 129, 130 or 143 stopped by a signal (FILE.part holds what was done).)";

}  // namespace

LACQUER_REGISTER(CommandKind, "bulk", (CommandOf<BulkArguments, AddBulkOptions, RunBulk>::Make),
                 {.synopsis = kBulkSynopsis, .footer = kBulkFooter});

}  // namespace lacquer::cmd
