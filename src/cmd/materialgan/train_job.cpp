// lacquer-materialgan train.
#include <fmt/format.h>

#include <charconv>
#include <filesystem>

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

std::string ProgressText(const materialgan::TrainProgress& p) {
    if (p.objective == materialgan::TrainingObjective::Gan)
        return fmt::format("step {}, losses {:.4f} of the generator, {:.4f} of the discriminator", p.step,
                           p.generatorLoss, p.discriminatorLoss);
    return fmt::format("step {}, error {:.4f}, {:.0f} nat off, {:.0f} in z, {:.0f} in noise", p.step, p.rmse,
                       p.reconstruction, p.klZ, p.klNoise);
}

std::string FinalText(const materialgan::TrainProgress& p) {
    if (p.objective == materialgan::TrainingObjective::Gan)
        return fmt::format("losses {:.4f} of the generator, {:.4f} of the discriminator", p.generatorLoss,
                           p.discriminatorLoss);
    return fmt::format("error {:.4f} of the maps' range", p.rmse);
}

/// Errors: usage; FileError for outputs that cannot be written.
materialgan::TrainOptions OptionsOf(const MaterialganArguments& a) {
    if (a.out.empty()) BadOption("out", "", "the name of a file");
    if (a.hours <= 0 && a.steps <= 0)
        throw CLI::ValidationError("--hours or --steps is required: how long to train");
    if ((a.resolution & (a.resolution - 1)) != 0)
        BadOption("resolution", fmt::format("{}", a.resolution), "a power of two");
    const int maxBatch = materialgan::MaxBatch(a.resolution);
    if (a.batch > maxBatch)
        BadOption("batch", fmt::format("{}", a.batch),
                  fmt::format("at most {} of {} x {} texels", maxBatch, a.resolution, a.resolution));
    for (const std::string& path :
         {a.out, materialgan::TrainingStatePath(a.out), materialgan::TrainingPreviewPath(a.out)})
        CheckOutputFile(path);
    const std::string state = materialgan::TrainingStatePath(a.out);
    if (!a.resume && std::filesystem::exists(state))
        throw FileError(state,
                        "is of an earlier training, which --resume goes on with; expected none: remove it "
                        "to begin anew");
    materialgan::TrainOptions options;
    options.objective = a.objective == "gan" ? materialgan::TrainingObjective::Gan
                                             : materialgan::TrainingObjective::Autoencoder;
    options.out = a.out;
    options.config.resolution = a.resolution;
    ReadFeatureMaps(a.featureMaps, &options.config);
    options.hours = a.hours;
    options.steps = a.steps;
    options.batch = a.batch;
    options.seed = a.seed;
    options.resume = a.resume;
    options.threads = a.threads > 0 ? a.threads : AllowedThreads();
    return options;
}

}  // namespace

ExitStatus RunTrain(const MaterialganArguments& a) {
    const materialgan::TrainOptions options = OptionsOf(a);
    Console console(ConsoleStyle::Detect(a.quiet));
    Console::CatchSignals();
    console.Begin("Training", 0, "");
    materialgan::TrainProgress last;
    bool isComplete = false;
    try {
        isComplete = materialgan::Train(options, console, [&](const materialgan::TrainProgress& p) {
            last = p;
            console.Describe(p.fraction, ProgressText(p));
            console.Advance(0);
        });
    } catch (const materialgan::TrainingError& e) {
        console.Error(fmt::format("{}: {}; what was stored before is still there", a.out, e.what()));
        return ExitStatus::NotConverged;
    }
    console.End();
    console.Info(fmt::format("{}: {} steps, {} materials, {}; {}", a.out, last.step, last.images,
                             FormatSeconds(last.seconds), FinalText(last)));
    return isComplete ? ExitStatus::Complete : Console::StatusOfSignal();
}

}  // namespace lacquer::cmd
