// lacquer-materialgan evaluate: fits of materials whose maps are known, with a generator and without.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iostream>

#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/materialgan/materialgan_arguments.h"
#include "materialgan/latent_fit.h"
#include "materialgan/procedural/procedural.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::cmd {
namespace {

using materialgan::Family;
using materialgan::FitInput;
using materialgan::FitResult;

constexpr double kEdge = 6.848, kHeight = 16, kVariationWeight = 0.003;
/// Every fifth material is of the family that no training has seen.
constexpr int kHeldOutEvery = 5;

/// Numbers of views and which of a grid of 3 x 3 they are, rows from the top.
const std::vector<int>& GridViews(int count) {
    static const std::map<int, std::vector<int>> views = {{1, {4}},
                                                          {3, {0, 5, 7}},
                                                          {5, {4, 0, 2, 6, 8}},
                                                          {7, {0, 1, 2, 3, 5, 6, 7}},
                                                          {9, {0, 1, 2, 3, 4, 5, 6, 7, 8}}};
    return views.at(count);
}

/// With the flash at the camera; held out are four of those elsewhere and four with the light far aside.
capture::ViewSet ViewsToEvaluate(int count) {
    capture::ViewSet set;
    set.size = kEdge;
    const double step = 0.365 * kEdge;
    for (const int i : GridViews(count)) {
        const capture::Point p{(i % 3 - 1) * step, (1 - i / 3) * step, kHeight};
        set.views.push_back({"", p, p, false});
    }
    for (const double x : {-1., 1.})
        for (const double y : {-1., 1.}) {
            const capture::Point p{0.18 * kEdge * x, 0.18 * kEdge * y, 14. / 16 * kHeight};
            set.views.push_back({"", p, p, true});
            set.views.push_back(
                {"", {0, 0, kHeight}, {0.88 * kEdge * x, 0.88 * kEdge * y, 10. / 16 * kHeight}, true});
        }
    return set;
}

/// Root mean squared difference of some channels of the maps, from 0 to 1.
double ChannelError(const capture::Maps& a, const capture::Maps& b, size_t first, size_t count) {
    double sum = 0;
    for (size_t c = first; c < first + count; ++c)
        for (size_t i = 0; i < a.NumTexels(); ++i) {
            const double difference = 0.5 * (a.Channel(c)[i] - b.Channel(c)[i]);
            sum += difference * difference;
        }
    return std::sqrt(sum / double(count * a.NumTexels()));
}

/// Sums over materials of what one method leaves.
struct MethodErrors {
    const char* name;
    std::array<double, 2> novel{};  ///< trained families, held-out family
    double albedo = 0, normal = 0, roughness = 0, specular = 0, input = 0, seconds = 0;

    void Add(const capture::Maps& truth, const FitResult& fit, bool isHeldOut, double time) {
        novel[isHeldOut] += fit.testRmse;
        input += fit.inputRmse;
        albedo += ChannelError(truth, fit.maps, capture::kAlbedo, 3);
        normal += ChannelError(truth, fit.maps, capture::kNormal, 2);
        roughness += ChannelError(truth, fit.maps, capture::kRoughness, 1);
        specular += ChannelError(truth, fit.maps, capture::kSpecular, 3);
        seconds += time;
    }
    std::string Row(int numTrained, int numHeldOut) const {
        const double n = numTrained + numHeldOut;
        const auto mean = [](double sum, int count) { return count > 0 ? sum / count : 0.; };
        return fmt::format("{:<18} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.1f}\n",
                           name, (novel[0] + novel[1]) / n, mean(novel[0], numTrained),
                           mean(novel[1], numHeldOut), input / n, albedo / n, normal / n, roughness / n,
                           specular / n, seconds / n);
    }
};

/// One material: what is known of it, and whether its family was trained.
struct EvaluationCase {
    capture::Maps truth;
    bool isHeldOut;
};
EvaluationCase CaseOf(int index, int size, uint64_t seed) {
    const bool isHeldOut = index % kHeldOutEvery == kHeldOutEvery - 1;
    const int trained = index - index / kHeldOutEvery;
    const auto family = isHeldOut ? Family::Dots : Family(trained % materialgan::kNumTrainedFamilies);
    // Not the seeds that a training has.
    return {ProceduralMaterial(family, size, Hash(seed, index, uint64_t(0x6576616c))), isHeldOut};
}

}  // namespace

ExitStatus RunEvaluate(const MaterialganArguments& a) {
    materialgan::SetTorchThreads(a.threads > 0 ? a.threads : AllowedThreads());
    const materialgan::MaterialPrior prior(a.file);
    Console console(ConsoleStyle::Detect(a.quiet));
    Console::CatchSignals();
    console.Begin("Evaluation", a.count, "");
    const auto observer = [&](const materialgan::FitProgress&) { return !console.ShouldStop(); };
    std::array<MethodErrors, 4> methods{
        MethodErrors{"texels"}, {"texels, smooth"}, {"latents"}, {"and refined"}};
    std::array<int, 2> counts{};
    for (int i = 0; i < a.count; ++i) {
        const EvaluationCase c = CaseOf(i, prior.Config().resolution, a.seed);
        FitInput input{ViewsToEvaluate(a.views), {}, prior.Config().resolution};
        input.images = materialgan::RenderViews(c.truth, input.views);
        const auto add = [&](size_t method, const auto& fit) {
            const Clock::time_point start = Clock::now();
            const FitResult result = fit();
            methods[method].Add(c.truth, result, c.isHeldOut, SecondsSince(start));
        };
        const materialgan::TexelFitOptions plain{.iterations = a.texelIterations},
            smooth{.iterations = a.texelIterations, .totalVariation = kVariationWeight};
        add(0, [&] { return FitTexels(input, plain, nullptr, observer); });
        add(1, [&] { return FitTexels(input, smooth, nullptr, observer); });
        materialgan::LatentFitOptions latent;
        latent.iterations = a.iterations;
        latent.priorWeight = a.priorWeight;
        latent.refineIterations = 0;
        FitResult before;
        add(2, [&] { return before = FitLatents(prior, input, latent, observer); });
        add(3, [&] { return FitTexels(input, {.iterations = 20, .rate = 0.01}, &before.maps, observer); });
        if (console.ShouldStop()) break;
        ++counts[c.isHeldOut];
        console.Advance(1);
    }
    console.End();
    if (console.ShouldStop()) return Console::StatusOfSignal();
    std::cout
        << fmt::format("{} materials, {} of them of a family that was not trained; {} views\n", a.count,
                       counts[1], a.views)
        << "                     novel trained heldout   input  albedo  normal roughn. specul. seconds\n";
    for (const MethodErrors& method : methods) std::cout << method.Row(counts[0], counts[1]);
    return ExitStatus::Complete;
}

}  // namespace lacquer::cmd
