// Of two ways from nothing to maps the better one, and from maps to larger ones.
#include <algorithm>
#include <utility>

#include "capture/svbrdf/pixel_fit.h"

namespace lacquer::capture {
namespace {

/// A fit and its steps, which wait until it is known whether it is the one that is taken.
struct Attempt {
    FitResult fit;
    std::vector<FitStep> steps;

    bool IsStopped() const { return fit.end == FitResult::End::Stopped; }
};

template <class FitFunction>
Attempt Try(FitSettings settings, const FitFunction& fit) {
    Attempt attempt;
    settings.afterStep = [&](const FitStep& step) { attempt.steps.push_back(step); };
    attempt.fit = fit(settings);
    return attempt;
}

FitResult Taken(Attempt attempt, const FitSettings& settings) {
    if (settings.afterStep) std::ranges::for_each(attempt.steps, settings.afterStep);
    return std::move(attempt.fit);
}

}  // namespace

FitResult FitTexels(const ViewSet& views, std::span<const RectifiedImage> images, const ConstantStart& start,
                    const FitSettings& settings, Observer* observer) {
    CheckFit(views, images, images.empty() ? 0 : images[0].size);
    FitSettings ofOneSize = settings;
    ofOneSize.name += ", one size";
    Attempt oneSize = Try(ofOneSize, [&](const FitSettings& s) {
        return FitMaps(views, images, ConstantMaps(images[0].size, start), s, observer);
    });
    const auto numFitted = std::ranges::count(views.views, false, &View::isTest);
    if (oneSize.IsStopped() || numFitted == 1) return Taken(std::move(oneSize), settings);
    Attempt coarse = Try(
        settings, [&](const FitSettings& s) { return FitFromConstant(views, images, start, s, observer); });
    if (coarse.IsStopped()) return Taken(std::move(coarse), settings);
    const auto objective = [&](const FitResult& fit) {
        ViewSet lit = views;
        lit.lightPower = fit.lightPower;
        return FitObjective(lit, images, fit.maps, settings.totalVariation);
    };
    const auto isSound = [](const FitResult& fit) { return fit.end == FitResult::End::Finished; };
    const bool isCoarse = isSound(oneSize.fit) != isSound(coarse.fit)
                              ? isSound(coarse.fit)
                              : objective(coarse.fit) <= objective(oneSize.fit);
    return Taken(std::move(isCoarse ? coarse : oneSize), settings);
}

FitResult FitDoubled(const FitResult& coarse, const ViewSet& views, std::span<const RectifiedImage> images,
                     FitSettings settings, Observer* observer) {
    FitResult fine;
    fine.maps = ResizeMaps(coarse.maps, 2 * coarse.maps.size);
    fine.lightPower = coarse.lightPower;
    if (settings.iterations == 0) return fine;
    settings.learningRate /= 2;
    settings.fitLightPower = false;
    ViewSet lit = views;
    lit.lightPower = coarse.lightPower;
    return FitMaps(lit, images, fine.maps, settings, observer);
}

}  // namespace lacquer::capture
