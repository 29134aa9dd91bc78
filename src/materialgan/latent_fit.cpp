#include "materialgan/latent_fit.h"

#include <fmt/format.h>

#include "materialgan/fit/latent_descent.h"
#include "pbrt/core/check.h"

namespace lacquer::materialgan {
namespace {

/// Iterations after which one of two starts is taken, as in the programs of the paper.
constexpr int kTrialIterations = 80, kMetalIterations = 100;
constexpr double kEmbeddingRate = 0.02;
/// Of the fit of texels that the encoder reads.
constexpr TexelFitOptions kFirstFit{.iterations = 150, .rate = 0.02, .totalVariation = 0.003};
constexpr double kRefineRate = 0.01;

LatentDescent EmbedMaps(const StyleGenerator& generator, const Tensor& maps, const LatentTensors& start,
                        const LatentSchedule& schedule, const FitObserver& observer,
                        const std::function<Tensor(const Tensor&)>& toPlus = {}) {
    const LatentObjective objective = [&](const Tensor& made, const LatentTensors&, FitPhase) {
        const Tensor loss = (made - maps).square().mean();
        return PhotoObjective::Value{loss, loss.item<double>()};
    };
    return DescendLatents(generator, start, schedule, objective, observer, toPlus);
}

class LatentFit {
  public:
    LatentFit(const GeneratorFile& file, const FitInput& input, const LatentFitOptions& options,
              const FitObserver& observer)
        : file_(file),
          options_(options),
          observer_(observer),
          target_(TargetOf(input, false)),
          tests_(TargetOf(input, true)),
          objective_(target_, options.features, options.pixelWeight, options.featureWeight),
          generator_(file.config, file.generator) {
        if (input.size != file.config.resolution)
            throw std::invalid_argument(fmt::format("images of size {}, and the generator makes {}",
                                                    input.size, file.config.resolution));
        generator_.KeepKernels();
    }

    FitResult Run() {
        const FitStart start = options_.start.value_or(file_.encoder ? FitStart::Encoder : FitStart::Two);
        LatentDescent best;
        if (start == FitStart::Encoder) {
            best = Descend(EncodedStart(), options_.iterations, "fit");
        } else {
            const bool isFull = start == FitStart::Full;
            const int trial = isFull ? options_.iterations : std::min(kTrialIterations, options_.iterations);
            const LatentTensors mean = MeanLatents(file_), metal = MetalStart();
            LatentDescent ofMean = Descend(mean, trial, "start: mean"),
                          ofMetal = Descend(metal, trial, "start: smooth metal");
            const bool isMean = !ofMetal.isFinite || ofMean.pixelLoss <= ofMetal.pixelLoss;
            if (isFull)
                best = isMean ? std::move(ofMean) : std::move(ofMetal);
            else
                best = Descend(isMean ? mean : metal, options_.iterations, "fit");
        }
        return Finish(std::move(best));
    }

  private:
    LatentDescent Descend(const LatentTensors& start, int iterations, const char* stage) {
        const LatentObjective objective = [this](const Tensor& maps, const LatentTensors& latents,
                                                 FitPhase phase) {
            PhotoObjective::Value value = objective_.Evaluate(maps, phase);
            if (options_.priorWeight > 0) value.loss = value.loss + options_.priorWeight * Prior(latents);
            return value;
        };
        const LatentSchedule schedule{.iterations = isStopped_ ? 0 : iterations,
                                      .strategy = options_.strategy,
                                      .optimizer = options_.optimizer,
                                      .rateW = options_.rateW,
                                      .rateNoise = options_.rateNoise,
                                      .stage = stage};
        LatentDescent descent = DescendLatents(generator_, start, schedule, objective, observer_);
        isStopped_ = isStopped_ || descent.isStopped;
        return descent;
    }

    /// Minus twice the log of the latents' density as trained, for each value of the maps.
    Tensor Prior(const LatentTensors& latents) const {
        Tensor sum = ((latents.wPlus - file_.meanW) / file_.deviationW).square().sum() /
                     double(file_.config.NumColumns());
        for (const Tensor& map : latents.noise) sum = sum + map.square().sum();
        const double size = file_.config.resolution;
        return sum / (double(capture::kNumChannels) * size * size);
    }

    LatentTensors EncodedStart() {
        if (!file_.encoder)
            throw std::invalid_argument("the generator has no encoder, which the start asks for");
        const TexelDescent first =
            DescendTexels(target_, GreyMaps(file_.config.resolution), kFirstFit, "texels", observer_);
        isStopped_ = first.isStopped;
        return EncodedLatents(file_, first.maps);
    }

    LatentTensors MetalStart() {
        const Tensor maps = SmoothMetalMaps(file_.config.resolution);
        if (file_.encoder) return EncodedLatents(file_, maps);
        const LatentSchedule schedule{.iterations = kMetalIterations,
                                      .strategy = 2,
                                      .rateW = kEmbeddingRate,
                                      .rateNoise = kEmbeddingRate,
                                      .stage = "smooth metal"};
        LatentDescent descent = EmbedMaps(generator_, maps, MeanLatents(file_), schedule, observer_);
        isStopped_ = descent.isStopped;
        return std::move(descent.latents);
    }

    FitResult Finish(LatentDescent descent) {
        const torch::NoGradGuard noGradients;
        const Tensor made =
            ClampMaps(generator_.Synthesize(descent.latents.wPlus, descent.latents.noise), file_.config);
        FitResult result;
        result.latents = FromTensors(descent.latents);
        result.beforeRefinement = ToMaps(made);
        result.losses = std::move(descent.losses);
        result.isFinite = descent.isFinite;
        const Tensor refined = Refine(made);
        result.maps = ToMaps(refined);
        result.inputRmse = target_.Rmse(refined);
        result.testRmse = tests_.Rmse(refined);
        result.isStopped = isStopped_;
        return result;
    }

    Tensor Refine(const Tensor& maps) {
        const torch::AutoGradMode gradients(true);
        const TexelFitOptions options{.iterations = isStopped_ ? 0 : options_.refineIterations,
                                      .rate = kRefineRate};
        const TexelDescent descent = DescendTexels(target_, maps, options, "refinement", observer_);
        isStopped_ = isStopped_ || descent.isStopped;
        return descent.maps;
    }

    const GeneratorFile& file_;
    const LatentFitOptions& options_;
    const FitObserver& observer_;
    FitTarget target_, tests_;
    PhotoObjective objective_;
    StyleGenerator generator_;
    bool isStopped_ = false;
};

}  // namespace

FitResult FitLatents(const MaterialPrior& prior, const FitInput& input, const LatentFitOptions& options,
                     const FitObserver& observer) {
    return LatentFit(prior.File(), input, options, observer).Run();
}

FitResult FitTexels(const FitInput& input, const TexelFitOptions& options, const capture::Maps* start,
                    const FitObserver& observer) {
    const FitTarget target = TargetOf(input, false), tests = TargetOf(input, true);
    if (start && start->size != input.size)
        throw std::invalid_argument(
            fmt::format("a start of size {} for images of {}", start->size, input.size));
    const Tensor first = start ? ToTensor(*start).unsqueeze(0) : GreyMaps(input.size);
    TexelDescent descent = DescendTexels(target, first, options, "texels", observer);
    FitResult result;
    result.maps = result.beforeRefinement = ToMaps(descent.maps);
    result.inputRmse = target.Rmse(descent.maps);
    result.testRmse = tests.Rmse(descent.maps);
    result.losses = std::move(descent.losses);
    result.isFinite = descent.isFinite;
    result.isStopped = descent.isStopped;
    return result;
}

Projection ProjectMaps(const MaterialPrior& prior, const capture::Maps& maps, LatentSpace space,
                       int iterations, const FitObserver& observer) {
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
        .stage = "projection"};
    const LatentDescent descent = EmbedMaps(generator, wanted, start, schedule, observer, toPlus);
    const torch::NoGradGuard noGradients;
    const Tensor made =
        ClampMaps(generator.Synthesize(descent.latents.wPlus, descent.latents.noise), file.config);
    return {FromTensors(descent.latents), ToMaps(made),
            0.5 * (made - wanted).square().mean().sqrt().item<double>()};
}

std::vector<std::vector<float>> RenderViews(const capture::Maps& maps, const capture::ViewSet& views) {
    const torch::NoGradGuard noGradients;
    capture::ViewSet all = views;
    for (capture::View& view : all.views) view.isTest = false;
    const Tensor linear = RenderLinear(ToTensor(maps).unsqueeze(0), ViewsOf(all, false))[0];
    Tensor values = EncodeLinear(linear);
    if (views.response != capture::Response::Gamma22) values = linear.clamp(0, 1);
    if (views.response == capture::Response::SRGB)
        values = torch::where(values <= 0.0031308, values * 12.92, 1.055 * values.pow(1 / 2.4) - 0.055);
    std::vector<std::vector<float>> images;
    for (int64_t i = 0; i < values.size(0); ++i) images.push_back(ToNamedTensor("", values[i]).values);
    return images;
}

}  // namespace lacquer::materialgan
