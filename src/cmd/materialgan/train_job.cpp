// lacquer-materialgan train.
#include <fmt/format.h>

#include <charconv>

#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/materialgan/materialgan_arguments.h"
#include "materialgan/train.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {
namespace {

/// "128:32" of generators of a resolution.
void ReadFeatureMaps(const std::string& text, materialgan::GeneratorConfig* config) {
    const std::string expected = "two numbers from 1 to 1024, the first not smaller: MAX:MIN";
    const size_t colon = text.find(':');
    if (colon == std::string::npos) BadOption("maps", text, expected);
    const auto number = [&](const char* begin, const char* end) {
        int value = 0;
        const auto [stop, error] = std::from_chars(begin, end, value);
        if (error != std::errc() || stop != end || value < 1 ||
            value > materialgan::GeneratorConfig::kMaxMaps)
            BadOption("maps", text, expected);
        return value;
    };
    const char* data = text.data();
    config->mapsMax = number(data, data + colon);
    const int least = number(data + colon + 1, data + text.size());
    if (least > config->mapsMax) BadOption("maps", text, expected);
    config->mapsBase = least * config->resolution;
}

}  // namespace

ExitStatus RunTrain(const MaterialganArguments& a) {
    if (a.hours <= 0 && a.steps <= 0) BadOption("hours", "0", "a time, or a number of --steps");
    if ((a.resolution & (a.resolution - 1)) != 0)
        BadOption("resolution", fmt::format("{}", a.resolution), "a power of two");
    CheckOutputFile(a.out);
    materialgan::TrainOptions options;
    options.out = a.out;
    options.config.resolution = a.resolution;
    ReadFeatureMaps(a.featureMaps, &options.config);
    options.hours = a.hours;
    options.steps = a.steps;
    options.batch = a.batch;
    options.seed = a.seed;
    options.resume = a.resume;
    options.threads = a.threads > 0 ? a.threads : AllowedThreads();
    Console console(ConsoleStyle::Detect(a.quiet));
    Console::CatchSignals();
    console.Begin("Training", 0, "");
    materialgan::TrainProgress last;
    const bool isComplete = materialgan::Train(options, console, [&](const materialgan::TrainProgress& p) {
        last = p;
        console.Describe(p.fraction,
                         fmt::format("step {}, error {:.4f}, {:.0f} nat off, {:.0f} in z, {:.0f} in noise",
                                     p.step, p.rmse, p.reconstruction, p.klZ, p.klNoise));
        console.Advance(0);
    });
    console.End();
    console.Info(fmt::format("{}: {} steps, {} materials, {}; error {:.4f} of the maps' range", a.out,
                             last.step, last.images, FormatSeconds(last.seconds), last.rmse));
    return isComplete ? ExitStatus::Complete : Console::StatusOfSignal();
}

}  // namespace lacquer::cmd
