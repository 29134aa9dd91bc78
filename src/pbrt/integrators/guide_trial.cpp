#include "pbrt/integrators/guide_trial.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "pbrt/core/math.h"
#include "pbrt/core/rng.h"

namespace lacquer {
namespace {

constexpr int64_t kPixelsOfOne = 200, kMinTrialPixels = 16, kMaxTrialPixels = 1024;
/// Part of the samples of an image that follow for a trial; of each pixel the sets by two ways.
constexpr int64_t kTrialPart = 20;
/// Tells the places from other random numbers.
constexpr int kTrialStream = 5;

double MeanSquare(const glm::dvec3& value) { return glm::dot(value, value) / 3; }

/// Between sets, of what `light` gives of each; the mean over channels.
template <class Sets, class Light>
double VarianceOf(const Sets& sets, const Light& light) {
    glm::dvec3 sum(0);
    for (const auto& set : sets) sum += light(set);
    const double count = double(sets.size());
    double squares = 0;
    for (const auto& set : sets) squares += MeanSquare(light(set) - sum / count);
    return squares / (count - 1);
}

/// Bounded where one of the two is nothing.
double QuotientOf(glm::dvec2 sum) {
    sum = glm::max(sum, 1e-6 * std::max(sum.x, sum.y));
    return sum.x / sum.y;
}

/// Standard error of the logarithm of QuotientOf(sum) by the jackknife. The delta method tells less than it
/// is where one pixel has most of both sums.
double LogErrorOf(const std::vector<glm::dvec2>& parts, const glm::dvec2& sum) {
    const double count = double(parts.size());
    double mean = 0, squares = 0;
    for (const glm::dvec2& part : parts) {
        const glm::dvec2 others = sum - part;
        const double logarithm = others.x > 0 || others.y > 0 ? std::log(QuotientOf(others)) : 0;
        mean += logarithm / count;
        squares += Sqr(logarithm) / count;
    }
    return std::sqrt((count - 1) * std::max(0., squares - Sqr(mean)));
}

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
    return int(
        std::min(int64_t(samples), area * samples / (2 * kSets * kTrialPart * int64_t(pixels_.size()))));
}

Int2 GuideTrial::NumbersOf(size_t k, int set) const {
    const int64_t width = resolution_.x, area = width * resolution_.y;
    const Int2 place = PixelAt(k);
    const int64_t index = (place.y * width + place.x + (set + 1) * area / (kSets + 1)) % area;
    return {int(index % width), int(index / width)};
}

double GuideTrial::Gain::AtLeast() const { return value * std::exp(-0.43 * logError); }

double GuideTrial::CostOfGuide() const {
    double rays = 0, guidedRays = 0;
    for (const Pixel& p : pixels_)
        for (const Set& set : p.sets) {
            rays += double(set.rays.nearest + set.rays.shadow);
            guidedRays += (1 + kRaysOfDraw) * double(set.guidedRays.nearest) + double(set.guidedRays.shadow);
        }
    return rays > 0 ? guidedRays / rays : 1;
}

GuideTrial::Gain GuideTrial::GainOfGuide() const {
    // Of all sets of both ways: where those of one alone are bright or dark by chance, their difference would
    // count for less or for more.
    const auto meanOf = [](const Pixel& p) {
        glm::dvec3 sum(0);
        for (const Set& set : p.sets) sum += 2. * set.first + set.rest + set.guided;
        return sum / (2. * kSets);
    };
    const auto isNumber = [&](const Pixel& p) { return std::isfinite(MeanSquare(meanOf(p))); };
    double mean = 0, count = 0;
    for (const Pixel& p : pixels_)
        if (isNumber(p)) {
            mean += std::sqrt(MeanSquare(meanOf(p)));
            ++count;
        }
    if (!(mean > 0)) return {};

    std::vector<glm::dvec2> variances;  // without a guide, with one
    glm::dvec2 sum(0);
    for (const Pixel& p : pixels_)
        if (isNumber(p)) {
            const double unit = MeanSquare(meanOf(p)) + Sqr(mean / count / 4);
            variances.emplace_back(
                VarianceOf(p.sets, [](const Set& set) { return set.first + set.rest; }) / unit,
                VarianceOf(p.sets, [](const Set& set) { return set.first + set.guided; }) / unit);
            sum += variances.back();
        }
    if (sum.x == sum.y) return {};
    return {QuotientOf(sum), LogErrorOf(variances, sum), CostOfGuide()};
}

}  // namespace lacquer
