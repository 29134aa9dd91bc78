#include "cmd/materialgan/evaluation_trial.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cmd/materialgan/latent_options.h"
#include "compare/flip.h"
#include "compare/ssim.h"
#include "pbrt/core/clock.h"

namespace lacquer::cmd {
namespace {

using capture::Maps;

constexpr double kGamma = 2.2;

/// Root mean squared difference of some channels of the maps, as parts of their range.
double ChannelError(const Maps& a, const Maps& b, size_t first, size_t count) {
    double sum = 0;
    for (size_t c = first; c < first + count; ++c)
        for (size_t i = 0; i < a.NumTexels(); ++i) {
            const double difference = 0.5 * (a.Channel(c)[i] - b.Channel(c)[i]);
            sum += difference * difference;
        }
    return std::sqrt(sum / double(count * a.NumTexels()));
}

/// @param power  of the encoded values: 1, or kGamma for linear ones
Image ImageOf(const capture::RectifiedImage& values, double power) {
    Image image({values.size, values.size}, {"R", "G", "B"});
    for (size_t c = 0; c < 3; ++c)
        for (size_t i = 0; i < values.NumPixels(); ++i)
            image.Pixels()[3 * i + c] = float(std::pow(values.Channel(c)[i], power));
    return image;
}

/// One material's photographs, and what fits make of them. The generator has its own size and sees the
/// photographs in it; what it finds is doubled from there to the size of the material.
class Trial {
  public:
    /// @param settings  of fits of texels
    Trial(const EvaluationCase& known, int count, int generatorSize, const capture::FitSettings& settings)
        : truth_(known.truth), settings_(settings) {
        const capture::ViewSet views = EvaluationViews(count);
        std::vector<capture::RectifiedImage> images;
        for (const capture::View& view : views.views)
            images.push_back(capture::RenderView(truth_, views, view));
        inputs_.push_back({views, std::move(images)});
        while (Small().images[0].size > generatorSize)
            inputs_.push_back({views, capture::Halved(Small().images)});
    }

    TrialResult Run(const materialgan::MaterialPrior& prior, const MaterialganArguments& a) {
        FitTexels();
        FitPrior(prior, a);
        return result_;
    }

  private:
    using Input = materialgan::FitInput;
    const Input& Whole() const { return inputs_.front(); }
    const Input& Small() const { return inputs_.back(); }

    void FitTexels() {
        const Input& input = Whole();
        Keep(CoarseToFine,
             [&] { return capture::FitFromConstant(input.views, input.images, {}, settings_).maps; });
        Keep(BetterTexels, [&] { return capture::FitTexels(input.views, input.images, {}, settings_).maps; });
        Keep(Smooth, [&] { return AtOneSize(input, settings_); });
        capture::FitSettings plain = settings_;
        plain.totalVariation = 0;
        Keep(Plain, [&] { return AtOneSize(input, plain); });
    }

    void FitPrior(const materialgan::MaterialPrior& prior, const MaterialganArguments& a) {
        materialgan::LatentFitOptions options = LatentFitOptionsOf(a.capture.prior);
        options.iterations = a.fitIterations;
        options.priorWeight = a.priorWeight.value_or(materialgan::DefaultPriorWeight(a.views));
        const Clock::time_point begin = Clock::now();
        const Maps start = AtOneSize(Small(), settings_);
        const materialgan::FitResult fit = materialgan::FitLatents(prior, Small(), options, nullptr, &start);
        const double seconds = SecondsSince(begin);
        Keep(LatentsOnly, [&] { return Enlarged(fit.beforeRefinement, 0); });
        Keep(Refined, [&] { return Enlarged(fit.maps, a.capture.refine); });
        for (const FitMethod m : {LatentsOnly, Refined}) result_.errors[m].seconds += seconds;
        const double ofTexels =
            capture::FitTexels(Small().views, Small().images, {}, settings_).inputRmse.back();
        result_.isDoubted = !DoubtOf(fit, ofTexels, a.views).empty();
        result_.errors[WithFallback] = result_.errors[result_.isDoubted ? BetterTexels : Refined];
        if (result_.isDoubted) result_.errors[WithFallback].seconds += result_.errors[Refined].seconds;
        result_.styleEnergy = fit.styleEnergy;
        result_.noiseEnergy = fit.noiseEnergy;
    }

    template <class FitFunction>
    void Keep(FitMethod method, const FitFunction& fit) {
        const Clock::time_point start = Clock::now();
        Maps maps = fit();
        const double seconds = SecondsSince(start);
        result_.errors[method] = ErrorsOf(maps, seconds);
        if (method == BetterTexels) result_.texels = std::move(maps);
        if (method == Refined) result_.refined = std::move(maps);
    }
    static Maps AtOneSize(const Input& input, const capture::FitSettings& settings) {
        return capture::FitMaps(input.views, input.images, capture::ConstantMaps(input.images[0].size),
                                settings)
            .maps;
    }
    /// Doubled up to the size of the material.
    Maps Enlarged(const Maps& maps, int iterations) const {
        capture::FitSettings settings = settings_;
        settings.iterations = iterations;
        capture::FitResult fit;
        fit.maps = maps;
        fit.lightPower = Whole().views.lightPower;
        for (size_t k = inputs_.size() - 1; k-- > 0;)
            fit = capture::FitDoubled(fit, inputs_[k].views, inputs_[k].images, settings);
        return std::move(fit.maps);
    }
    /// Mean FLIP of linear values.
    static double FlipOf(const capture::RectifiedImage& shown, const capture::RectifiedImage& seen) {
        const Image map = compare::LdrFlip(ImageOf(shown, kGamma), ImageOf(seen, kGamma));
        double sum = 0;
        for (const float value : map.Pixels()) sum += double(value);
        return sum / double(map.Pixels().size());
    }
    FitErrors ErrorsOf(const Maps& maps, double seconds) const {
        FitErrors errors{.albedo = ChannelError(truth_, maps, capture::kAlbedo, 3),
                         .normal = ChannelError(truth_, maps, capture::kNormal, 2),
                         .roughness = ChannelError(truth_, maps, capture::kRoughness, 1),
                         .specular = ChannelError(truth_, maps, capture::kSpecular, 3),
                         .seconds = seconds};
        const auto& [views, images] = Whole();
        const auto numNovel = double(std::ranges::count(views.views, true, &capture::View::isTest)),
                   numFitted = double(views.views.size()) - numNovel;
        for (size_t i = 0; i < images.size(); ++i) {
            const capture::View& view = views.views[i];
            const capture::RectifiedImage shown = capture::RenderView(maps, views, view);
            const capture::RectifiedImage& seen = images[i];
            const double square = Sqr(capture::Rmse(seen, shown));
            if (!view.isTest) {
                errors.input += square / numFitted;
                continue;
            }
            errors.novel += square / numNovel;
            errors.flip += FlipOf(shown, seen) / numNovel;
            errors.ssim += compare::Ssim(ImageOf(shown, 1), ImageOf(seen, 1), {"R", "G", "B"}) / numNovel;
        }
        errors.input = std::sqrt(errors.input);
        errors.novel = std::sqrt(errors.novel);
        return errors;
    }

    const Maps& truth_;
    capture::FitSettings settings_;
    std::vector<Input> inputs_;  ///< in the size of the material, and halved up to that of the generator
    TrialResult result_;
};

}  // namespace

TrialResult RunTrial(const EvaluationCase& known, const materialgan::MaterialPrior& prior,
                     const MaterialganArguments& arguments, const capture::FitSettings& settings) {
    return Trial(known, arguments.views, prior.Config().resolution, settings).Run(prior, arguments);
}

}  // namespace lacquer::cmd
