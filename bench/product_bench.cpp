// How much less noise product sampling has than bidirectional estimation.
//
// usage: product_bench [OPTION...] [GROUP...]
//   --estimators A,B,...  candidates. Default: pairproduct, multiproduct, halfvector, auto, as far as they
//   exist,
//                         and bidirectional@newton. A name with @newton, @rejection or @control stands for
//                         the estimator on interfaces that draw Beckmann normals so (slope_samplers.h), and
//                         multiproduct:5 for products of up to 5 events, pairproduct:all:9 for pairs of all
//                         strategies and paths of up to 9 events
//   --baseline A          default: bidirectional
//   --seconds S           of each candidate on each configuration, default 0.5
//   --quick               little time and coarse grids: half a minute in all
//   --pairs N             of directions, default 48
//   --uniform-pairs       directions independent of the stack, in place of those where its light goes
//   --resample WHAT       what the intervals' bootstrap draws anew: pairs, samples (random numbers and the
//                         clock's readings), or both, the default
//   --seed N              of the directions and of all random numbers
//   --json FILE, --csv FILE  all figures
//   --list                the groups and the estimators
//   --self                bidirectional against itself: 1 must be in the intervals
//   --battery N           auto, or the first of the estimators, against the baseline on N random stacks with
//   a
//                         pair of directions each: percentiles of the efficiency and the worst ten; --seconds
//                         is 0.04 then
//   --floor S             of the battery: standard deviations below S [1/sr] count as S, default 1e-4
//   --turned              of the battery: with anisotropic interfaces and perturbed normals
//   --worst N             of the battery: queries to print, default 10
//   --samplers            the ways to draw Beckmann normals: times, distributions, and what they make of
//                         bidirectional
// Exit status 1: an unknown name, a file that cannot be written, a check that fails.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>

#include "battery.h"
#include "ratio_report.h"
#include "sampler_bench.h"

namespace lacquer::bench {
namespace {

struct Options {
    ReportOptions report{"bidirectional", "", "", {}};
    std::vector<std::string> estimators, groups;
    bool isQuick = false, lists = false, isSelfCheck = false, isSamplerBench = false, isBattery = false;
    BatteryOptions battery;
};

// ---- The command line -------------------------------------------------------------------------------------

std::vector<std::string> SplitAtCommas(const std::string& text) {
    std::vector<std::string> parts;
    std::istringstream list(text);
    for (std::string part; std::getline(list, part, ',');) parts.push_back(part);
    return parts;
}

Resampling ResamplingOf(const std::string& name) {
    if (name == "pairs") return Resampling::Pairs;
    if (name == "samples") return Resampling::Samples;
    if (name == "both") return Resampling::Both;
    throw std::invalid_argument(fmt::format("no resampling \"{}\"", name));
}

std::vector<std::string> DefaultEstimators() {
    std::vector<std::string> names;
    for (const char* name : {"pairproduct", "multiproduct", "halfvector", "auto"})
        if (Registry<layered::LayeredEstimatorKind>::Find(name)) names.emplace_back(name);
    names.emplace_back(kSlowBaseline);
    return names;
}

/// Words of the command line, one after the other.
class Arguments {
  public:
    explicit Arguments(std::span<char*> words) : words_(words.subspan(std::min<size_t>(1, words.size()))) {}
    bool Next() {
        if (at_ == words_.size()) return false;
        option_ = words_[at_++];
        return true;
    }
    const std::string& Option() const { return option_; }
    /// What follows the option. Errors: std::invalid_argument.
    std::string Value() {
        if (at_ == words_.size()) throw std::invalid_argument(option_ + " wants a value");
        return words_[at_++];
    }
    double Number() {
        const std::string text = Value();
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        if (text.empty() || *end || !(value > 0 && value < 1e9))
            throw std::invalid_argument(fmt::format("{} wants a positive number, not \"{}\"", option_, text));
        return value;
    }

  private:
    std::span<char*> words_;
    size_t at_ = 0;
    std::string option_;
};

Options ParseOptions(std::span<char*> words) {
    Options o;
    Arguments arguments(words);
    const std::map<std::string, std::function<void()>> actions = {
        {"--estimators", [&] { o.estimators = SplitAtCommas(arguments.Value()); }},
        {"--baseline", [&] { o.report.baseline = arguments.Value(); }},
        {"--seconds", [&] { o.report.compare.seconds = o.battery.seconds = arguments.Number(); }},
        {"--pairs", [&] { o.report.compare.numPairs = std::max<size_t>(1, size_t(arguments.Number())); }},
        {"--seed", [&] { o.report.compare.seed = o.battery.seed = uint64_t(arguments.Number()); }},
        {"--resample", [&] { o.report.compare.resampling = ResamplingOf(arguments.Value()); }},
        {"--uniform-pairs", [&] { o.report.compare.usesUniformPairs = true; }},
        {"--quick",
         [&] {
             o.isQuick = true;
             o.report.compare.seconds = 0.02;
         }},
        {"--json", [&] { o.report.json = arguments.Value(); }},
        {"--csv", [&] { o.report.csv = arguments.Value(); }},
        {"--list", [&] { o.lists = true; }},
        {"--self", [&] { o.isSelfCheck = true; }},
        {"--samplers", [&] { o.isSamplerBench = true; }},
        {"--battery",
         [&] {
             o.isBattery = true;
             o.battery.numQueries = std::max(1, int(arguments.Number()));
         }},
        {"--turned", [&] { o.battery.isTurned = true; }},
        {"--worst", [&] { o.battery.numWorst = int(arguments.Number()); }},
        {"--floor", [&] { o.battery.floor = arguments.Number(); }},
    };
    while (arguments.Next()) {
        const auto action = actions.find(arguments.Option());
        if (action != actions.end())
            action->second();
        else if (arguments.Option().starts_with("-"))
            throw std::invalid_argument(fmt::format("no option \"{}\"", arguments.Option()));
        else
            o.groups.push_back(arguments.Option());
    }
    return o;
}

/// The groups asked for, all if none. Errors: std::invalid_argument.
std::vector<ConfigurationGroup> ChooseGroups(const Options& options) {
    std::vector<ConfigurationGroup> all = ProductConfigurations(options.isQuick);
    if (options.groups.empty()) return all;
    std::vector<ConfigurationGroup> chosen;
    for (const std::string& name : options.groups) {
        const auto at = std::find_if(all.begin(), all.end(), [&](const auto& g) { return g.name == name; });
        if (at == all.end()) throw std::invalid_argument(fmt::format("no group \"{}\"; see --list", name));
        chosen.push_back(*at);
    }
    return chosen;
}

std::vector<Candidate> ChooseCandidates(const Options& options) {
    std::vector<Candidate> candidates = {FindCandidate(options.report.baseline)};
    for (const std::string& name : options.estimators.empty() ? DefaultEstimators() : options.estimators)
        if (name != options.report.baseline) candidates.push_back(FindCandidate(name));
    return candidates;
}

// ---- What the program does --------------------------------------------------------------------------------

int RunComparisons(const Options& options) {
    const std::vector<ConfigurationGroup> groups = ChooseGroups(options);
    const std::vector<Candidate> candidates = ChooseCandidates(options);
    Report report(options.report);
    report.PrintLegend();
    for (const ConfigurationGroup& group : groups) {
        std::vector<Candidate> here = candidates;
        if (!group.hasBeckmann)
            std::erase_if(here, [](const Candidate& c) { return c.sampler != SlopeSampler::Library; });
        report.StartGroup(group);
        for (const Configuration& row : group.rows)
            report.AddRow(row, Compare(row, here, options.report.compare));
        report.EndGroup();
    }
    report.WriteFiles();
    return 0;
}

/// Bidirectional against itself with other random numbers, and, as what the intervals must be able to tell,
/// against a forward walk.
int RunSelfCheck(Options options) {
    constexpr int kRepetitions = 10, kNeeded = 9;
    const std::vector<Candidate> candidates = {
        FindCandidate("bidirectional"), FindCandidate("bidirectional@library"), FindCandidate("forward")};
    int samples = 0, time = 0, forward = 0;
    options.groups = {"figure5"};
    const Configuration row = ChooseGroups(options)[0].rows[0];
    for (int i = 0; i < kRepetitions; ++i) {
        options.report.compare.seed = uint64_t(i) + 1;
        const auto results = Compare(row, candidates, options.report.compare);
        const Ratio bySamples = RatioOf(results[1], &LogRatios::samples);
        const Ratio byTime = RatioOf(results[1], &LogRatios::time);
        const Ratio control = RatioOf(results[2], &LogRatios::samples);
        samples += bySamples.interval.Contains(1);
        time += byTime.interval.Contains(1);
        forward += !control.interval.Contains(1);
        fmt::print(
            "itself: samples {:.4f} [{:.4f}, {:.4f}], time {:.4f} [{:.4f}, {:.4f}]; forward: {:.3f} [{:.3f},"
            " {:.3f}]\n",
            bySamples.value, bySamples.interval.low, bySamples.interval.high, byTime.value,
            byTime.interval.low, byTime.interval.high, control.value, control.interval.low,
            control.interval.high);
        std::fflush(stdout);
    }
    const bool isRight = samples >= kNeeded && time >= kNeeded && forward >= kNeeded;
    fmt::print(
        "1 is in the interval at equal samples {}, at equal time {}, not in forward's {} times of {}: {}\n",
        samples, time, forward, kRepetitions, isRight ? "passed" : "FAILED");
    return isRight ? 0 : 1;
}

int RunSamplers(Options options) {
    const bool isRight = RunSamplerBench(options.isQuick ? 0.002 : 0.02);
    fmt::print(
        "\nWhat they make of bidirectional; control is the library's way in the benchmark's own models.\n");
    if (options.groups.empty()) options.groups = {"figure5", "grid", "full", "sheet"};
    if (options.estimators.empty())
        options.estimators = {"bidirectional@control", "bidirectional@newton", "bidirectional@rejection"};
    RunComparisons(options);
    return isRight ? 0 : 1;
}

int RunRandomQueries(const Options& options) {
    const std::string candidate = options.estimators.empty() ? "auto" : options.estimators[0];
    RunBattery(FindCandidate(options.report.baseline), FindCandidate(candidate), options.battery);
    return 0;
}

void List() {
    for (const ConfigurationGroup& group : ProductConfigurations(false))
        fmt::print("{:<22} {} ({})\n", group.name, group.title, group.rows.size());
    fmt::print("estimators: {}\n", fmt::join(Registry<layered::LayeredEstimatorKind>::Names(), " "));
}

int Main(std::span<char*> arguments) {
    try {
        const Options options = ParseOptions(arguments);
        if (options.lists) {
            List();
            return 0;
        }
        if (options.isSelfCheck) return RunSelfCheck(options);
        if (options.isBattery) return RunRandomQueries(options);
        return options.isSamplerBench ? RunSamplers(options) : RunComparisons(options);
    } catch (const std::exception& error) {
        fmt::print(stderr, "product_bench: {}\n", error.what());
        return 1;
    }
}

}  // namespace
}  // namespace lacquer::bench

int main(int argc, char** argv) { return lacquer::bench::Main({argv, size_t(argc)}); }
