#include "pbrt/integrators/noise_level.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"
#include "pbrt/core/math.h"
#include "pbrt/image/image.h"
#include "pbrt/integrators/window_sums.h"

namespace lacquer {
namespace {

constexpr int kErrorWindow = 8;
/// The part of the pixels that the noise level holds for.
constexpr double kPart = 0.95;

}  // namespace

std::vector<double> SquaredScales(Int2 size, const std::vector<RGB>& values, int window) {
    std::vector<double> scales(values.size());
    double mean = 0;
    for (int c = 0; c < 3; ++c) {
        WindowSums sums(size);
        ForAllPixels(size, [&](Int2 p, size_t i) { sums.Set(p, double(values[i][c])); });
        sums.GrowTo(window);
        ForAllPixels(size, [&](Int2 p, size_t i) { scales[i] += Sqr(sums.Mean(p)) / 3; });
        for (const RGB& value : values) mean += double(value[c]) / (3 * double(values.size()));
    }
    const double least = std::max(Sqr(mean / 4), 1e-30);
    for (double& scale : scales) scale += least;
    return scales;
}

double NoiseLevel(const Film& film) {
    const std::unique_ptr<Image> image = film.Develop();
    const int half = image->FindChannel("Half.R");
    LACQUER_CHECK(half >= 0);
    const Int2 size = image->Resolution();
    std::vector<RGB> values(size_t(size.x) * size_t(size.y));
    WindowSums errors(size);
    ForAllPixels(size, [&](Int2 p, size_t i) {
        values[i] = {image->Get(p, 0), image->Get(p, 1), image->Get(p, 2)};
    });
    const std::vector<double> scales = SquaredScales(size, values, kNoiseScaleWindow);
    ForAllPixels(size, [&](Int2 p, size_t i) {
        const RGB d = values[i] - RGB(image->Get(p, half), image->Get(p, half + 1), image->Get(p, half + 2));
        errors.Set(p, double(glm::dot(d, d)) / (3 * scales[i]));
    });
    errors.GrowTo(kErrorWindow);
    std::vector<double> relative(scales.size());
    ForAllPixels(size, [&](Int2 p, size_t i) { relative[i] = std::sqrt(errors.Mean(p)); });
    const auto rank = relative.begin() + ptrdiff_t(kPart * double(relative.size() - 1));
    std::nth_element(relative.begin(), rank, relative.end());
    return *rank;
}

}  // namespace lacquer
