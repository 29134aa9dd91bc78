#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "capture/svbrdf/pixel_fit.h"
#include "capture/svbrdf/svbrdf_model.h"
#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::capture {
namespace {

constexpr size_t kNumCoarse = 2;
constexpr int kMinCoarseSize = 8;
constexpr int kLobes = 4;

double Lanczos(double x) {
    const double px = std::numbers::pi * x;
    if (std::abs(x) >= kLobes) return 0;
    return std::abs(px) < 1e-6 ? 1 : kLobes * std::sin(px) * std::sin(px / kLobes) / (px * px);
}

/// What one output value is made of: weights of inputs from `first` on, which sum to 1.
struct Weights {
    int first;
    std::vector<double> values;
};
std::vector<Weights> WeightsOf(int from, int to) {
    const double scale = double(from) / to, width = std::max(scale, 1.);
    std::vector<Weights> all;
    for (int i = 0; i < to; ++i) {
        const double center = (i + 0.5) * scale - 0.5;
        Weights w{int(std::ceil(center - kLobes * width)), {}};
        double sum = 0;
        for (int k = w.first; k <= center + kLobes * width; ++k) {
            w.values.push_back(Lanczos((k - center) / width));
            sum += w.values.back();
        }
        for (double& value : w.values) value /= sum;
        all.push_back(std::move(w));
    }
    return all;
}

/// Sum of values `stride` apart; beyond the ends the last ones go on.
double Weighted(const double* values, size_t stride, int count, const Weights& w) {
    double sum = 0;
    for (size_t k = 0; k < w.values.size(); ++k)
        sum += w.values[k] * values[size_t(std::clamp(w.first + int(k), 0, count - 1)) * stride];
    return sum;
}

}  // namespace

Maps ResizeMaps(const Maps& maps, int size) {
    LACQUER_CHECK(maps.size > 0);
    Maps resized(size);
    const std::vector<Weights> weights = WeightsOf(maps.size, size);
    const auto from = size_t(maps.size), to = size_t(size);
    for (size_t c = 0; c < kNumChannels; ++c) {
        const std::span<const double> values = maps.Channel(c);
        std::vector<double> wide(from * to);
        ParallelFor(maps.size, [&](int64_t row) {
            for (size_t column = 0; column < to; ++column)
                wide[size_t(row) * to + column] =
                    Weighted(&values[size_t(row) * from], 1, maps.size, weights[column]);
        });
        ParallelFor(size, [&](int64_t row) {
            for (size_t column = 0; column < to; ++column)
                resized.Channel(c)[size_t(row) * to + column] =
                    ClampTo(Weighted(&wide[column], to, maps.size, weights[size_t(row)]), -1, 1);
        });
    }
    return resized;
}

FitResult FitFromConstant(const ViewSet& views, std::span<const RectifiedImage> images,
                          const ConstantStart& start, const FitSettings& settings, Observer* observer) {
    CheckFit(views, images, images.empty() ? 0 : images[0].size);
    // The photographs in all sizes, the finest first.
    std::vector<std::vector<RectifiedImage>> halves;
    halves.reserve(kNumCoarse);
    std::vector<std::span<const RectifiedImage>> sizes{images};
    while (halves.size() < kNumCoarse && sizes.back()[0].size % 2 == 0 &&
           sizes.back()[0].size >= 2 * kMinCoarseSize) {
        halves.push_back(Halved(sizes.back()));
        sizes.emplace_back(halves.back());
    }

    FitResult fit;
    fit.maps = ConstantMaps(sizes.back()[0].size, start);
    ViewSet lit = views;
    std::vector<double> inputRmse;
    FitSettings stage = settings;
    if (settings.afterStep)
        stage.afterStep = [&](const FitStep& step) {
            settings.afterStep({int(inputRmse.size()) + step.iteration, step.inputRmse, step.testRmse});
        };
    const auto inSize = [&](int size) {
        return fit.maps.size == size ? std::move(fit.maps) : ResizeMaps(fit.maps, size);
    };
    for (size_t k = sizes.size(); k-- > 0 && fit.end == FitResult::End::Finished;) {
        stage.iterations = k > 0 ? settings.iterations / 2 : settings.iterations;
        fit = FitMaps(lit, sizes[k], inSize(sizes[k][0].size), stage, observer);
        inputRmse.insert(inputRmse.end(), fit.inputRmse.begin(), fit.inputRmse.end());
        lit.lightPower = fit.lightPower;
    }
    fit.maps = inSize(images[0].size);
    fit.inputRmse = std::move(inputRmse);
    fit.isCoarseToFine = true;
    return fit;
}

}  // namespace lacquer::capture
