// lacquer-materialgan capture: `lacquer capture --prior`.
#include <fmt/format.h>

#include <filesystem>

#include "cmd/capture/capture_job.h"
#include "cmd/command.h"
#include "cmd/materialgan/generator_path.h"
#include "cmd/materialgan/latent_options.h"
#include "cmd/materialgan/materialgan_arguments.h"
#include "materialgan/latent_fit.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/hash_bytes.h"

namespace lacquer::cmd {
namespace {

using capture::FitCheckpoint;

constexpr size_t kMaxFileBytes = size_t(1) << 32;

class PriorFitter final : public MapFitter {
  public:
    PriorFitter(const PriorArguments& arguments, int threads)
        : a_(arguments),
          file_(GeneratorPath(arguments.file)),
          prior_(file_),
          threads_(UseThreads(prior_, threads)),
          hash_(HashOfBytes(ReadFileBytes(file_, {}, {.maxBytes = kMaxFileBytes}).View())) {}

    int Size() const override { return prior_.Config().resolution; }

    FitCheckpoint::Problem Problem() const override {
        return {{"--prior", fmt::format("{:016x}", hash_)},
                {"--prior-iterations", fmt::to_string(a_.iterations)},
                {"--prior-weight", a_.weight ? fmt::to_string(*a_.weight) : "default"},
                {"--strategy", fmt::to_string(a_.strategy)},
                {"--optimizer", a_.optimizer},
                {"--features", a_.features},
                {"--start", a_.start},
                {"--nthreads", fmt::to_string(threads_)}};
    }

    FittedMaps Fit(const capture::ViewSet& views, std::span<const capture::RectifiedImage> images,
                   const capture::FitSettings& settings, Observer* observer) override {
        const auto numFitted = size_t(std::ranges::count(views.views, false, &capture::View::isTest));
        const capture::FitResult texels = capture::FitTexels(views, images, {}, settings, observer);
        FittedMaps fitted{texels, {}, {}, {}};
        if (texels.end != capture::FitResult::End::Finished) return fitted;
        materialgan::FitInput input{views, {images.begin(), images.end()}};
        input.views.lightPower = texels.lightPower;
        const capture::FitResult start = StartOf(input, settings, observer);
        const materialgan::LatentFitOptions options = OptionsOf(settings, numFitted, texels.inputRmse.size());
        if (start.end != capture::FitResult::End::Finished) {
            fitted.fit.end = start.end;
            return fitted;
        }
        materialgan::FitResult fit = FitLatents(prior_, input, options, observer, &start.maps);
        latents_ = std::move(fit.latents);
        fitted.fit.maps = std::move(fit.maps);
        fitted.fit.end = fit.end;
        fitted.settings = {{"Prior", fmt::format("{}, {} x {} texels, {} steps, weight {:.3g}",
                                                 std::filesystem::path(file_).filename().string(), Size(),
                                                 Size(), options.iterations, options.priorWeight)},
                           {"Before it", fmt::format("{} steps of texels, total variation {:.3g}",
                                                     settings.iterations, settings.totalVariation)}};
        fitted.findings = {
            {"Prior",
             fmt::format("The generator explains the photographs to {:.2g}, texels by themselves to {:.2g}; "
                         "its noise has {:.2g} of the energy that it was trained with.",
                         fit.unrefinedRmse, texels.inputRmse.back(), fit.noiseEnergy)}};
        if (!a_.trust) fitted.doubt = DoubtOf(fit, texels.inputRmse.back(), int(numFitted));
        return fitted;
    }

    void WriteExtras(const std::string& folder) const override {
        if (!latents_.wPlus.empty())
            SaveLatents(latents_, prior_, (std::filesystem::path(folder) / kLatentName).string());
    }

  private:
    /// What the encoder reads, as materialgan::TexelFitSettings() says.
    static capture::FitResult StartOf(const materialgan::FitInput& input, capture::FitSettings settings,
                                      Observer* observer) {
        settings.fitLightPower = false;
        settings.afterStep = {};
        settings.name = "start";
        return capture::FitMaps(input.views, input.images, capture::ConstantMaps(input.images[0].size),
                                settings, observer);
    }

    materialgan::LatentFitOptions OptionsOf(const capture::FitSettings& settings, size_t numPhotographs,
                                            size_t numSteps) const {
        materialgan::LatentFitOptions options = LatentFitOptionsOf(a_);
        options.priorWeight = a_.weight.value_or(materialgan::DefaultPriorWeight(int(numPhotographs)));
        options.testEvery = settings.testEvery;
        options.checkpoint = settings.checkpoint;
        // Steps go on from those of the texels.
        options.afterStep = [after = settings.afterStep,
                             first = int(numSteps)](const capture::FitStep& step) {
            if (after) after({first + step.iteration, step.inputRmse, step.testRmse});
        };
        return options;
    }

    const PriorArguments& a_;
    std::string file_;
    materialgan::MaterialPrior prior_;
    int threads_;
    uint64_t hash_;
    materialgan::Latents latents_;
};

}  // namespace

ExitStatus RunCaptureWithPrior(const MaterialganArguments& arguments) {
    const CaptureArguments& a = arguments.capture;
    CheckCaptureArguments(a);
    if (!a.prior.IsGiven()) throw CLI::ValidationError("--prior is required: a generator of materials");
    Console console(ConsoleStyle::Detect(a.quiet));
    PriorFitter fitter(a.prior, a.threads);
    return Capture(a, &fitter, &console);
}

}  // namespace lacquer::cmd
