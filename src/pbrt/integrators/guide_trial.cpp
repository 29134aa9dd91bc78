#include "pbrt/integrators/guide_trial.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "pbrt/core/math.h"
#include "pbrt/core/rng.h"

namespace lacquer {
namespace {

constexpr int64_t kPixelsOfOne = 150, kMinTrialPixels = 16, kMaxTrialPixels = 1024;
/// Part of the samples of an image that follow for a trial; of each pixel two sets by two ways.
constexpr int64_t kTrialPart = 20;
/// Tells the places from other random numbers.
constexpr int kTrialStream = 5;

double MeanSquare(const glm::dvec3& value) { return glm::dot(value, value) / 3; }

}  // namespace

GuideTrial::GuideTrial(Int2 resolution, int seed) : resolution_(resolution) {
    const int64_t area = int64_t(resolution.x) * resolution.y;
    const int64_t count = std::clamp(area / kPixelsOfOne, kMinTrialPixels, kMaxTrialPixels);
    // One in each cell of a grid, so that no part of the image is left out.
    const int side = std::max(1, int(std::sqrt(double(count))));
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            Rng rng(Hash(seed, x, y, kTrialStream, 0));
            const Vec2 at = (Vec2(float(x), float(y)) + rng.Uniform2D()) / float(side);
            Pixel pixel;
            pixel.place = glm::min(Int2(at * Vec2(resolution)), resolution - 1);
            pixels_.push_back(pixel);
        }
}

int GuideTrial::MostSamples(int samples) const {
    const int64_t area = int64_t(resolution_.x) * resolution_.y;
    return int(std::min(int64_t(samples), area * samples / (4 * kTrialPart * int64_t(pixels_.size()))));
}

double GuideTrial::Gain() const {
    // Of all sets of both ways: where those of one alone are bright or dark by chance, their difference would
    // count for less or for more.
    const auto meanOf = [](const Pixel& p) {
        return (2. * (p.sets[0].first + p.sets[1].first) + p.sets[0].rest + p.sets[1].rest +
                p.sets[0].guided + p.sets[1].guided) /
               4.;
    };
    const auto isNumber = [&](const Pixel& p) { return std::isfinite(MeanSquare(meanOf(p))); };
    double mean = 0, count = 0;
    for (const Pixel& p : pixels_)
        if (isNumber(p)) {
            mean += std::sqrt(MeanSquare(meanOf(p)));
            ++count;
        }
    if (!(mean > 0)) return 1;

    double without = 0, with = 0;
    for (const Pixel& p : pixels_)
        if (isNumber(p)) {
            const double unit = MeanSquare(meanOf(p)) + Sqr(mean / count / 4);
            const glm::dvec3 first = p.sets[0].first - p.sets[1].first;
            without += MeanSquare(first + p.sets[0].rest - p.sets[1].rest) / unit;
            with += MeanSquare(first + p.sets[0].guided - p.sets[1].guided) / unit;
        }
    if (without == with) return 1;
    return without / std::max(with, 1e-6 * without);
}

}  // namespace lacquer
