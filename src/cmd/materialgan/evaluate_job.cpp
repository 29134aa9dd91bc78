// lacquer-materialgan evaluate: fits of materials whose maps are known, with a generator and without.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/materialgan/evaluation_cases.h"
#include "cmd/materialgan/generator_path.h"
#include "cmd/materialgan/latent_options.h"
#include "cmd/materialgan/materialgan_arguments.h"
#include "compare/flip.h"
#include "compare/ssim.h"
#include "materialgan/latent_fit.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {
namespace {

using capture::Maps;
using Json = nlohmann::ordered_json;

constexpr std::array kMethods = {"texels",  "texels, smooth", "coarse to fine", "texels, better",
                                 "latents", "and refined",    "with fallback"};
enum Method : size_t {
    Plain,
    Smooth,
    CoarseToFine,
    BetterTexels,
    LatentsOnly,
    Refined,
    WithFallback,
    NumMethods
};

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

constexpr double kGamma = 2.2;

/// @param power  of the encoded values: 1, or kGamma for linear ones
Image ImageOf(const capture::RectifiedImage& values, double power) {
    Image image({values.size, values.size}, {"R", "G", "B"});
    for (size_t c = 0; c < 3; ++c)
        for (size_t i = 0; i < values.NumPixels(); ++i)
            image.Pixels()[3 * i + c] = float(std::pow(values.Channel(c)[i], power));
    return image;
}

/// What one method leaves of one material, or the mean over some.
struct Errors {
    double novel = 0, flip = 0, ssim = 0, input = 0, albedo = 0, normal = 0, roughness = 0, specular = 0,
           seconds = 0;
    void Add(const Errors& e, double weight) {
        novel += weight * e.novel;
        flip += weight * e.flip;
        ssim += weight * e.ssim;
        input += weight * e.input;
        albedo += weight * e.albedo;
        normal += weight * e.normal;
        roughness += weight * e.roughness;
        specular += weight * e.specular;
        seconds += weight * e.seconds;
    }
};
struct TrialResult {
    std::array<Errors, NumMethods> errors;
    double styleEnergy = 0, noiseEnergy = 0;
    bool isDoubted = false;
};

/// One material's photographs, and what fits make of them.
class Trial {
  public:
    Trial(const EvaluationCase& known, int count) : truth_(known.truth), input_{EvaluationViews(count), {}} {
        for (const capture::View& view : input_.views.views)
            input_.images.push_back(capture::RenderView(truth_, input_.views, view));
    }

    TrialResult Run(const materialgan::MaterialPrior& prior, const MaterialganArguments& a,
                    Observer* observer) {
        TrialResult result;
        auto& errors = result.errors;
        capture::FitSettings settings;
        settings.iterations = a.texelIterations;
        settings.totalVariation = a.capture.totalVariation;
        double seconds = 0;  // of the last fit
        const auto timed = [&seconds](const auto& fit) {
            const Clock::time_point start = Clock::now();
            auto made = fit();
            seconds = SecondsSince(start);
            return made;
        };
        const Maps constant = capture::ConstantMaps(truth_.size);
        const Maps coarseToFine = timed([&] {
            return capture::FitFromConstant(input_.views, input_.images, {}, settings, observer).maps;
        });
        errors[CoarseToFine] = ErrorsOf(coarseToFine, seconds);
        const auto fitAtOneSize = [&] {
            return capture::FitMaps(input_.views, input_.images, constant, settings, observer).maps;
        };
        const Maps smooth = timed(fitAtOneSize);
        errors[Smooth] = ErrorsOf(smooth, seconds);
        const Maps better = timed(
            [&] { return capture::FitTexels(input_.views, input_.images, {}, settings, observer).maps; });
        errors[BetterTexels] = ErrorsOf(better, seconds);
        settings.totalVariation = 0;
        const Maps plain = timed(fitAtOneSize);
        errors[Plain] = ErrorsOf(plain, seconds);
        materialgan::LatentFitOptions latent = LatentFitOptionsOf(a.capture.prior);
        latent.iterations = a.fitIterations;
        latent.priorWeight = a.priorWeight.value_or(materialgan::DefaultPriorWeight(a.views));
        const materialgan::FitResult fit =
            timed([&] { return materialgan::FitLatents(prior, input_, latent, observer, &smooth); });
        errors[Refined] = ErrorsOf(fit.maps, seconds);
        errors[LatentsOnly] = ErrorsOf(fit.beforeRefinement, seconds);
        result.isDoubted = !DoubtOf(fit, errors[BetterTexels].input, a.views).empty();
        errors[WithFallback] = errors[result.isDoubted ? BetterTexels : Refined];
        errors[WithFallback].seconds =
            errors[BetterTexels].seconds + errors[Smooth].seconds + errors[Refined].seconds;
        result.styleEnergy = fit.styleEnergy;
        result.noiseEnergy = fit.noiseEnergy;
        return result;
    }

  private:
    /// Mean FLIP of linear values.
    static double FlipOf(const capture::RectifiedImage& shown, const capture::RectifiedImage& seen) {
        const Image map = compare::LdrFlip(ImageOf(shown, kGamma), ImageOf(seen, kGamma));
        double sum = 0;
        for (const float value : map.Pixels()) sum += double(value);
        return sum / double(map.Pixels().size());
    }
    Errors ErrorsOf(const Maps& maps, double seconds) const {
        Errors errors{.albedo = ChannelError(truth_, maps, capture::kAlbedo, 3),
                      .normal = ChannelError(truth_, maps, capture::kNormal, 2),
                      .roughness = ChannelError(truth_, maps, capture::kRoughness, 1),
                      .specular = ChannelError(truth_, maps, capture::kSpecular, 3),
                      .seconds = seconds};
        const auto numNovel = double(std::ranges::count(input_.views.views, true, &capture::View::isTest)),
                   numFitted = double(input_.views.views.size()) - numNovel;
        for (size_t i = 0; i < input_.images.size(); ++i) {
            const capture::View& view = input_.views.views[i];
            const capture::RectifiedImage shown = capture::RenderView(maps, input_.views, view);
            const capture::RectifiedImage& seen = input_.images[i];
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
    materialgan::FitInput input_;
};

Json ToJson(const EvaluationCase& known, const TrialResult& result) {
    Json entry = {{"family", known.family},
                  {"held_out_family", known.isHeldOut},
                  {"style_energy", result.styleEnergy},
                  {"noise_energy", result.noiseEnergy},
                  {"doubted", result.isDoubted}};
    for (size_t m = 0; m < NumMethods; ++m) {
        const Errors& e = result.errors[m];
        entry[kMethods[m]] = {{"novel_rmse", e.novel},    {"novel_flip", e.flip},   {"novel_ssim", e.ssim},
                              {"input_rmse", e.input},    {"albedo", e.albedo},     {"normal", e.normal},
                              {"roughness", e.roughness}, {"specular", e.specular}, {"seconds", e.seconds}};
    }
    return entry;
}

std::string TableOf(const std::vector<EvaluationCase>& cases, const std::vector<TrialResult>& results) {
    std::array<int, 2> counts{};
    for (const EvaluationCase& c : cases) ++counts[c.isHeldOut];
    std::string table =
        fmt::format("{} materials of trained families, {} of another\n", counts[0], counts[1]);
    table +=
        "                   trained   other    FLIP    SSIM   input  albedo  normal roughn. specul. "
        "seconds\n";
    for (size_t m = 0; m < NumMethods; ++m) {
        std::array<Errors, 2> mean;
        Errors all;
        for (size_t i = 0; i < cases.size(); ++i) {
            mean[cases[i].isHeldOut].Add(results[i].errors[m], 1. / counts[cases[i].isHeldOut]);
            all.Add(results[i].errors[m], 1. / double(cases.size()));
        }
        table += fmt::format(
            "{:<18} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.1f}\n",
            kMethods[m], mean[0].novel, mean[1].novel, all.flip, all.ssim, all.input, all.albedo, all.normal,
            all.roughness, all.specular, all.seconds);
    }
    return table;
}

}  // namespace

ExitStatus RunEvaluate(const MaterialganArguments& a) {
    if (!a.out.empty()) CheckOutputFile(a.out);
    const int threads = a.threads > 0 ? a.threads : AllowedThreads();
    const ThreadLimit limit(threads);
    materialgan::SetTorchThreads(threads);
    const materialgan::MaterialPrior prior(GeneratorPath(a.file));
    Console console(ConsoleStyle::Detect(a.quiet));
    Console::CatchSignals();
    Observer silent;
    std::vector<EvaluationCase> cases;
    std::vector<TrialResult> results;
    console.Begin("Evaluation", a.count, "");
    for (int i = 0; i < a.count && !console.ShouldStop(); ++i) {
        cases.push_back(EvaluationCaseOf(i, prior.Config().resolution, a.seed));
        results.push_back(Trial(cases.back(), a.views).Run(prior, a, &silent));
        console.Advance(1);
    }
    console.End();
    if (console.ShouldStop()) return Console::StatusOfSignal();
    if (!a.out.empty()) {
        Json file = {
            {"generator", a.file}, {"views", a.views}, {"seed", a.seed}, {"materials", Json::array()}};
        for (size_t i = 0; i < cases.size(); ++i) file["materials"].push_back(ToJson(cases[i], results[i]));
        WriteText(a.out, JsonText(file, 2) + "\n");
    }
    std::cout << TableOf(cases, results);
    return ExitStatus::Complete;
}

}  // namespace lacquer::cmd
