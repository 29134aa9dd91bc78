#include "materialgan/latent_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "materialgan/fit/embedding.h"
#include "pbrt/core/check.h"

namespace lacquer::materialgan {
namespace {

/// Iterations after which one of two starts is taken, as in the programs of the paper.
constexpr int kTrialIterations = 80;
constexpr double kEmbeddingRate = 0.02;
/// Errors of photographs, with the generator over without, above which it is not trusted.
constexpr double kMuchWorse = 6;

using End = capture::FitResult::End;

/// Infinite if it has not begun or went wrong.
double LastRmse(const LatentDescent& descent) {
    return descent.end == End::NotFinite || descent.steps.empty() ? std::numeric_limits<double>::infinity()
                                                                  : descent.steps.back().inputRmse;
}

class LatentFit {
  public:
    LatentFit(const GeneratorFile& file, const FitInput& input, const LatentFitOptions& options,
              Observer* observer, const capture::Maps* texels)
        : file_(file),
          input_(input),
          options_(options),
          observer_(observer),
          target_(TargetOf(input, false)),
          tests_(TargetOf(input, true)),
          objective_(target_, MakePhotoFeatures(options.features, options.featuresFile), options.pixelWeight,
                     options.featureWeight),
          generator_(file.config, file.generator) {
        if (input.images[0].size != file.config.resolution)
            throw std::invalid_argument(fmt::format("images of size {}, and the generator makes {}",
                                                    input.images[0].size, file.config.resolution));
        if (texels) result_.texels = *texels;
        generator_.KeepKernels();
    }

    FitResult Run() {
        const FitStart start = options_.start.value_or(file_.encoder ? FitStart::Encoder : FitStart::Two);
        Finish(start == FitStart::Encoder
                   ? Descend(EncodedStart(), options_.iterations, "fitting latents", options_.afterStep)
                   : DescendFromBetter(start == FitStart::Full));
        return std::move(result_);
    }

  private:
    /// From the mean material or from a smooth metal [Guo et al. 2020b, sec. 4.3].
    LatentDescent DescendFromBetter(bool isFull) {
        const int trial = isFull ? options_.iterations : std::min(kTrialIterations, options_.iterations);
        const LatentTensors mean = MeanLatents(file_), metal = MetalStart();
        LatentDescent ofMean = Descend(mean, trial, "from the mean", {}),
                      ofMetal = Descend(metal, trial, "from a smooth metal", {});
        const bool isMean = LastRmse(ofMean) <= LastRmse(ofMetal);
        if (!isFull && result_.end == End::Finished)
            return Descend(isMean ? mean : metal, options_.iterations, "fitting latents", options_.afterStep);
        LatentDescent better = std::move(isMean ? ofMean : ofMetal);
        if (options_.afterStep) std::ranges::for_each(better.steps, options_.afterStep);
        return better;
    }

    /// @param afterStep  empty: the steps are not told, for it is not known whether they count
    LatentDescent Descend(const LatentTensors& start, int iterations, const char* name,
                          const std::function<void(const capture::FitStep&)>& afterStep) {
        const LatentObjective objective = [this](const Tensor& maps, const LatentTensors& latents,
                                                 FitPhase phase) {
            PhotoObjective::Value value = objective_.Evaluate(maps, phase);
            if (options_.priorWeight > 0) value.loss = value.loss + options_.priorWeight * Prior(latents);
            return value;
        };
        LatentSchedule schedule{.iterations = result_.end == End::Finished ? iterations : 0,
                                .strategy = options_.strategy,
                                .optimizer = options_.optimizer,
                                .rateW = options_.rateW,
                                .rateNoise = options_.rateNoise,
                                .name = name,
                                .testEvery = options_.testEvery,
                                .afterStep = afterStep,
                                .checkpoint = options_.checkpoint};
        if (tests_.NumViews() > 0)
            schedule.testRmse = [this](const Tensor& maps) { return tests_.Rmse(maps); };
        LatentDescent descent = DescendLatents(generator_, start, schedule, objective, observer_);
        if (result_.end == End::Finished) result_.end = descent.end;
        return descent;
    }

    Tensor StyleSquares(const LatentTensors& latents) const {
        return ((latents.wPlus - file_.meanW) / file_.deviationW).square();
    }

    /// Minus twice the log of the latents' density as trained, for each value of the maps.
    Tensor Prior(const LatentTensors& latents) const {
        Tensor sum = StyleSquares(latents).sum() / double(file_.config.NumColumns());
        for (const Tensor& map : latents.noise) sum = sum + map.square().sum();
        const double size = file_.config.resolution;
        return sum / (double(capture::kNumChannels) * size * size);
    }

    static double NoiseEnergy(const std::vector<Tensor>& noise) {
        double sum = 0, count = 0;
        for (const Tensor& map : noise) {
            sum += map.square().sum().item<double>();
            count += double(map.numel());
        }
        return sum / count;
    }

    LatentTensors EncodedStart() {
        if (!file_.encoder)
            throw std::invalid_argument("the generator has no encoder, which the start asks for");
        if (result_.texels.size == 0) {
            capture::FitResult fit =
                capture::FitMaps(input_.views, input_.images, capture::ConstantMaps(file_.config.resolution),
                                 Stored(TexelFitSettings(), "texels"), observer_);
            result_.texels = std::move(fit.maps);
            result_.end = fit.end;
        }
        return EncodedLatents(file_, ToTensor(result_.texels).unsqueeze(0));
    }

    /// Of the file; or of its encoder; or embedded, which takes a while.
    LatentTensors MetalStart() {
        if (file_.startLow) return file_.startLow->Clone();
        if (file_.encoder) return EncodedLatents(file_, SmoothMetalMaps(file_.config.resolution));
        LatentDescent descent = EmbedSmoothMetal(file_, generator_, options_.checkpoint, observer_);
        result_.end = descent.end;
        return std::move(descent.latents);
    }

    void Finish(LatentDescent descent) {
        const torch::NoGradGuard noGradients;
        result_.latents = FromTensors(descent.latents);
        result_.beforeRefinement =
            MadeMaps(file_, generator_.Synthesize(descent.latents.wPlus, descent.latents.noise));
        result_.losses = std::move(descent.losses);
        result_.unrefinedRmse = target_.Rmse(ToTensor(result_.beforeRefinement).unsqueeze(0));
        result_.styleEnergy = StyleSquares(descent.latents).mean().item<double>();
        result_.noiseEnergy = NoiseEnergy(descent.latents.noise);
        result_.maps = Refined(result_.beforeRefinement);
        const Tensor maps = ToTensor(result_.maps).unsqueeze(0);
        result_.inputRmse = target_.Rmse(maps);
        result_.testRmse = tests_.Rmse(maps);
    }

    capture::FitSettings Stored(capture::FitSettings settings, const char* name) const {
        settings.checkpoint = options_.checkpoint;
        settings.name = name;
        return settings;
    }

    /// What the photographs say beyond what the generator can make.
    capture::Maps Refined(const capture::Maps& maps) {
        if (options_.refinement.iterations == 0 || result_.end != End::Finished) return maps;
        capture::FitResult fit = capture::FitMaps(input_.views, input_.images, maps,
                                                  Stored(options_.refinement, "refinement"), observer_);
        result_.end = fit.end;
        return std::move(fit.maps);
    }

    const GeneratorFile& file_;
    const FitInput& input_;
    const LatentFitOptions& options_;
    Observer* observer_;
    FitTarget target_, tests_;
    PhotoObjective objective_;
    StyleGenerator generator_;
    FitResult result_;
};

}  // namespace

void SetFeatures(const std::string& text, LatentFitOptions* options) {
    const bool isFile = text != "none" && text != "steerable";
    options->features = isFile           ? FitFeatures::Vgg
                        : text == "none" ? FitFeatures::None
                                         : FitFeatures::Steerable;
    options->featuresFile = isFile ? text : "";
}

capture::FitSettings TexelFitSettings() {
    capture::FitSettings settings;
    settings.iterations = 300;
    return settings;
}

capture::FitSettings RefinementSettings() {
    capture::FitSettings settings;
    settings.iterations = 20;
    settings.learningRate = 0.01;
    settings.fallingPart = 0;
    settings.totalVariation = 0;
    return settings;
}

FitResult FitLatents(const MaterialPrior& prior, const FitInput& input, const LatentFitOptions& options,
                     Observer* observer, const capture::Maps* texels) {
    return LatentFit(prior.File(), input, options, observer, texels).Run();
}

double DefaultPriorWeight(int numPhotographs) {
    if (numPhotographs <= 2) return 0.01;
    return numPhotographs <= 7 ? 0.001 : 0.0005;
}

std::string DoubtOf(const FitResult& fit, double texelRmse, int numPhotographs) {
    if (numPhotographs == 1)
        return "one photograph leaves too much to the generator, whose maps would show other views worse";
    if (fit.unrefinedRmse > kMuchWorse * texelRmse)
        return fmt::format(
            "the generator explains the photographs to {:.2g}, where texels by themselves come to {:.2g}: it "
            "does not know such a material",
            fit.unrefinedRmse, texelRmse);
    return {};
}

Projection ProjectMaps(const MaterialPrior& prior, const capture::Maps& maps, LatentSpace space,
                       int iterations, Observer* observer) {
    const GeneratorFile& file = prior.File();
    LACQUER_CHECK(maps.size == file.config.resolution);
    StyleGenerator generator(file.config, file.generator);
    generator.KeepKernels();
    const Tensor wanted = ToTensor(maps).unsqueeze(0);
    LatentTensors start = MeanLatents(file);
    std::function<Tensor(const Tensor&)> toPlus;
    if (space == LatentSpace::W) {
        start.wPlus = file.meanW.unsqueeze(0).clone();
        toPlus = [&](const Tensor& w) { return generator.Repeat(w); };
    }
    const LatentSchedule schedule{
        .iterations = iterations,
        .strategy = 2,
        .movesW = space != LatentSpace::Noise,
        .movesNoise = space == LatentSpace::WPlusNoise || space == LatentSpace::Noise,
        .rateW = kEmbeddingRate,
        .rateNoise = kEmbeddingRate,
        .name = "projection"};
    const LatentDescent descent = EmbedMaps(generator, wanted, start, schedule, observer, toPlus);
    const torch::NoGradGuard noGradients;
    const capture::Maps made =
        MadeMaps(file, generator.Synthesize(descent.latents.wPlus, descent.latents.noise));
    const Tensor difference = ToTensor(made).unsqueeze(0) - wanted;
    return {FromTensors(descent.latents), made, 0.5 * difference.square().mean().sqrt().item<double>()};
}

}  // namespace lacquer::materialgan
