// lacquer bulk: from particles to a table that media and slabs render.
#include <fmt/format.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "bulk/input/particles_input.h"
#include "bulk/table/bulk_computation.h"
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

/// Everything that the command line of `bulk` can say.
struct BulkArguments {
    std::string input, out, wavelengths;
    int realizations = 50;
    std::optional<uint64_t> seed;
    int threads = 0;
    bool quiet = false;
};

/// "550", "400:700:50" or "450,550,650"; empty if the option is not given. Errors: usage.
std::vector<double> ParseWavelengths(const std::string& text) {
    if (text.empty()) return {};
    const char separator = text.find(':') != std::string::npos ? ':' : ',';
    std::vector<double> numbers;
    std::istringstream in(text);
    double number = 0;
    while (in >> number) {
        numbers.push_back(number);
        if (in.peek() != separator) break;
        in.get();
    }
    const bool isWhole = in.eof() || in.peek() == std::istringstream::traits_type::eof();
    if (separator == ':')
        numbers =
            numbers.size() == 3 ? EvenWavelengths(numbers[0], numbers[1], numbers[2]) : std::vector<double>();
    bool isFine = isWhole && !numbers.empty() && numbers.size() <= size_t(kMaxWavelengths);
    for (size_t i = 0; isFine && i < numbers.size(); ++i)
        isFine = numbers[i] >= (i > 0 ? numbers[i - 1] + 1e-3 : 1) && numbers[i] <= 1e6;
    if (!isFine)
        BadOption("wavelengths", text,
                  fmt::format("BEGIN:END:STEP, or growing numbers with commas between, at most {} [nm]",
                              kMaxWavelengths));
    return numbers;
}

/// One table, from arguments to the written file.
class BulkJob {
  public:
    explicit BulkJob(const BulkArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        const ThreadLimit threads(a_.threads);
        input_ = ReadParticles(a_.input, {ParseWavelengths(a_.wavelengths), a_.seed});
        CheckOutputFile(a_.out);
        BulkComputation computation(input_.settings);
        if (HasClusters() && a_.realizations < computation.NumNeeded())
            BadOption("realisations", std::to_string(a_.realizations),
                      fmt::format("at least {}, as the average \"medium\" or \"chapter\" is one of pairs",
                                  computation.NumNeeded()));
        Console::CatchSignals();
        if (HasClusters()) Solve(&computation);
        if (Console::Signal() != 0) {
            console_.Error("stopped by a signal; nothing is written");
            return Console::Signal() == SIGTERM ? ExitStatus::Terminated : ExitStatus::Interrupted;
        }
        BulkTable table = computation.Table();
        table.made = Made(computation).dump();
        WriteText(a_.out, WriteBulkTable(table));
        console_.Info(fmt::format("{}: {} wavelengths, {} realisations", a_.out, table.wavelengths.size(),
                                  computation.NumRealizations()));
        return ExitStatus::Complete;
    }

  private:
    bool HasClusters() const { return input_.settings.method == BulkMethod::Clusters; }

    void Solve(BulkComputation* computation) {
        const int64_t numWavelengths = int64_t(input_.settings.wavelengths.size());
        console_.Begin("solving", a_.realizations * numWavelengths, "");
        try {
            computation->AddRealizations(a_.realizations, &console_);
        } catch (const SceneError& error) {
            throw SceneError(input_.placeOfArrangement, error.Message());
        }
        console_.End();
        if (Console::Signal() != 0) return;
        for (size_t w = 0; w < size_t(numWavelengths); ++w)
            if (computation->NumAveraged(w) < computation->NumNeeded())
                throw SceneError(input_.placeOfArrangement,
                                 fmt::format("at {:g} nm {} of {} realisations have no solution: the waves "
                                             "of such particles are not computed accurately",
                                             input_.settings.wavelengths[w],
                                             computation->NumRealizations() - computation->NumAveraged(w),
                                             computation->NumRealizations()));
        if (computation->NumRefused() > 0)
            console_.Warn(fmt::format("{} of {} solutions did not converge, and are in no average",
                                      computation->NumRefused(),
                                      computation->NumRealizations() * numWavelengths));
    }

    nlohmann::ordered_json Made(const BulkComputation& computation) const {
        nlohmann::ordered_json made;
        made["by"] = fmt::format("Lacquer {}", kVersion);
        made["seed"] = input_.settings.seed;
        if (HasClusters()) {
            made["realisations"] = computation.NumRealizations();
            made["refused"] = computation.NumRefused();
        }
        made["input"] = nlohmann::ordered_json::parse(input_.json);
        return made;
    }

    const BulkArguments& a_;
    Console console_;
    ParticlesInput input_;
};

void AddBulkOptions(CLI::App& app, BulkArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("input", a.input, "What the particles are: a JSON file (docs/bulk.md)")
        ->type_name(kFile)
        ->required();
    app.add_option("--out", a.out, "File for the table")->type_name(kFile)->required();
    app.add_option("--realisations", a.realizations, "Random clusters to average, of each size")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    app.add_option("--wavelengths", a.wavelengths,
                   "BEGIN:END:STEP or A,B,...: wavelengths in vacuum [nm] instead of the file's");
    app.add_option("--seed", a.seed, "Seed of all random numbers instead of the file's")
        ->check(CLI::Range(uint64_t(0), uint64_t(1) << 53));
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No progress and no warnings");
}

ExitStatus RunBulk(const BulkArguments& arguments) { return BulkJob(arguments).Run(); }

constexpr const char* kSynopsis =
    "Computes how a medium of many small particles scatters light, from Maxwell's equations: coefficients\n"
    "and phase functions, for the parameter \"bulk\" of media and slabs.\n"
    "Usage: lacquer bulk [OPTIONS] particles.json --out FILE";
constexpr const char* kFooter = R"(
Exit status: 0 the table is written; 1 wrong usage; 2 the particles make no sense, or find no places; 3 a
file cannot be read or written; 130 or 143 stopped by a signal (nothing is written).)";

}  // namespace

LACQUER_REGISTER(CommandKind, "bulk", (CommandOf<BulkArguments, AddBulkOptions, RunBulk>::Make),
                 {.synopsis = kSynopsis, .footer = kFooter});

}  // namespace lacquer::cmd
