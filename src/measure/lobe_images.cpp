#include "measure/lobe_images.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::measure {

namespace {

constexpr int kBlocks = 64;
constexpr double kMinSamples = 32;

/// Index of the pixel that holds (x, y), -1 outside.
int64_t PixelOf(Vec3 w, int resolution) {
    const int x = int(std::floor((double(w.x) + 1) / 2 * resolution));
    const int y = int(std::floor((1 - double(w.y)) / 2 * resolution));
    if (x < 0 || y < 0 || x >= resolution || y >= resolution) return -1;
    return int64_t(y) * resolution + x;
}

bool Transmits(const LobeQuery& query) { return Any(query.subject.Flags(), Lobes::Transmission); }

/// One side of the image of Evaluate().
class Evaluation {
  public:
    Evaluation(const LobeQuery& query, bool transmitted, int samplesPerPixel, LobeImage& out,
               std::vector<double>* pdf)
        : q_(query), transmitted_(transmitted), samples_(samplesPerPixel), out_(out), pdf_(pdf) {}

    void Row(int y) {
        Rng rng(Hash(q_.seed, 5, transmitted_, y));
        for (int x = 0; x < out_.resolution; ++x) Pixel(x, y, rng);
        if (q_.observer) q_.observer->Advance(int64_t(out_.resolution) * samples_);
    }

  private:
    void Pixel(int x, int y, Rng& rng) {
        // Points of the additive recurrence with the plastic number [Roberts 2018], moved at random.
        const Point2 start = rng.Uniform2D();
        const int64_t firstVariant = int64_t(rng.UniformInt(1u << 20)) * BsdfSubject::kNumSets;
        const int groups = samples_ / BsdfSubject::kNumSets;
        glm::dvec3 sum(0);
        double luminances = 0, squares = 0, pdf = 0;
        const size_t pixel = size_t(y) * size_t(out_.resolution) + size_t(x);
        for (int group = 0; group < groups; ++group) {
            glm::dvec3 value(0);
            for (int set = 0; set < BsdfSubject::kNumSets; ++set) {
                const int k = group * BsdfSubject::kNumSets + set;
                const double u = Fraction(double(start.x) + k * 0.7548776662466927);
                const double v = Fraction(double(start.y) + k * 0.5698402909980532);
                value += At((x + u) / out_.resolution * 2 - 1, 1 - (y + v) / out_.resolution * 2,
                            firstVariant + k, rng, &pdf) /
                         double(BsdfSubject::kNumSets);
            }
            const double luminance = Luminance(value);
            sum += value;
            luminances += luminance;
            squares += luminance * luminance;
        }
        const double n = groups, mean = luminances / n;
        out_.value[pixel] = sum / n;
        out_.variance[pixel] = std::max(0.0, squares / n - mean * mean) / (n - 1);
        out_.count[pixel] = samples_;
        if (pdf_) (*pdf_)[pixel] = pdf / samples_;
    }

    /// f |cos| in RGB at a point of the disk, 0 outside of it.
    glm::dvec3 At(double x, double y, int64_t i, Rng& rng, double* pdf) {
        const double z2 = 1 - x * x - y * y;
        if (!(z2 > 0)) return glm::dvec3(0);
        const bool up = (q_.w.z > 0) != transmitted_;
        const Vec3 w = Normalize(Vec3(glm::dvec3(x, y, up ? std::sqrt(z2) : -std::sqrt(z2))));
        const BxDFContext context{.mode = q_.mode, .rng = &rng, .needsPdf = pdf_ != nullptr};
        const BxDFValue value = q_.subject.At(i).Evaluate(q_.w, w, context);
        if (pdf_ && std::isfinite(value.pdf)) *pdf += double(value.pdf);
        if (!IsUsable(value.f)) return glm::dvec3(0);
        return glm::dvec3(q_.subject.ToRGB(value.f, i)) * double(AbsCosTheta(w));
    }

    static double Fraction(double x) { return x - std::floor(x); }

    const LobeQuery& q_;
    bool transmitted_;
    int samples_;
    LobeImage& out_;
    std::vector<double>* pdf_;
};

/// A sample as the histogram needs it.
struct Hit {
    int64_t pixel = -1;
    bool isTransmitted = false;
    double cosine = 0;
    glm::dvec3 weight{0};
};

Hit SampleHit(const LobeQuery& q, int64_t i, int resolution, Rng& rng) {
    const float lobe = rng.Uniform();
    const BxDFRandom u{lobe, rng.Uniform2D()};
    const auto sample = q.subject.At(i).Sample(q.w, u, {.mode = q.mode, .rng = &rng});
    if (!sample || sample->IsSpecular() || !IsUsable(sample->weight)) return {};
    return {PixelOf(sample->wi, resolution), !SameHemisphere(q.w, sample->wi),
            double(AbsCosTheta(sample->wi)), glm::dvec3(q.subject.ToRGB(sample->weight, i))};
}

}  // namespace

LobePair EvaluateImages(const LobeQuery& query, int resolution, int samplesPerPixel, DensityPair* pdf) {
    LACQUER_CHECK(samplesPerPixel % BsdfSubject::kNumSets == 0 &&
                  samplesPerPixel >= 2 * BsdfSubject::kNumSets);
    LobePair pair;
    const auto fill = [&](bool transmitted, LobeImage& image, std::vector<double>* density) {
        image = LobeImage(resolution);
        if (density) density->assign(image.value.size(), 0);
        ParallelFor(resolution, [&](int64_t y) {
            Evaluation(query, transmitted, samplesPerPixel, image, density).Row(int(y));
        });
    };
    fill(false, pair.reflection, pdf ? &pdf->reflection : nullptr);
    if (Transmits(query)) fill(true, pair.transmission, pdf ? &pdf->transmission : nullptr);
    return pair;
}

LobePair SampleImages(const LobeQuery& query, int resolution, int64_t numSamples, DensityPair* density) {
    LobePair pair;
    pair.reflection = LobeImage(resolution);
    density->reflection.assign(pair.reflection.value.size(), 0);
    if (Transmits(query)) {
        pair.transmission = LobeImage(resolution);
        density->transmission.assign(pair.transmission.value.size(), 0);
    }
    // Chunks are drawn in parallel and added in their order: sums do not depend on the threads.
    constexpr int64_t kChunk = 1 << 14, kWave = 64;
    const double pixelArea = 4.0 / (double(resolution) * resolution), n = double(numSamples);
    std::vector<std::vector<Hit>> wave(kWave);
    for (int64_t start = 0; start < numSamples; start += kWave * kChunk) {
        ParallelFor(kWave, [&](int64_t chunk) {
            const int64_t first = start + chunk * kChunk;
            const int64_t end = std::min(first + kChunk, numSamples);
            Rng rng(Hash(query.seed, 6, first));
            wave[size_t(chunk)].clear();
            for (int64_t i = first; i < end; ++i)
                wave[size_t(chunk)].push_back(SampleHit(query, i, resolution, rng));
            if (query.observer && end > first) query.observer->Advance(end - first);
        });
        for (const auto& hits : wave)
            for (const Hit& hit : hits) {
                if (hit.pixel < 0) continue;
                LobeImage& image = hit.isTransmitted ? pair.transmission : pair.reflection;
                if (image.IsEmpty()) continue;
                // d omega = d area / cos theta: a pixel's mean of x over its area from samples of density p.
                const glm::dvec3 x = hit.weight * (hit.cosine / (n * pixelArea));
                const auto pixel = size_t(hit.pixel);
                image.value[pixel] += x;
                image.variance[pixel] += Sqr(Luminance(x));
                image.count[pixel] += 1;
                (hit.isTransmitted ? density->transmission : density->reflection)[pixel] +=
                    hit.cosine / (n * pixelArea);
            }
    }
    return pair;
}

Difference Compare(const LobeImage& estimate, const LobeImage& histogram) {
    const int resolution = histogram.resolution;
    const int size = std::max(1, resolution / kBlocks);
    Difference d;
    d.resolution = (resolution + size - 1) / size;
    std::vector<double> noise;
    for (int by = 0; by < d.resolution; ++by)
        for (int bx = 0; bx < d.resolution; ++bx) {
            double difference = 0, value = 0, variance = 0, count = 0;
            for (int y = by * size; y < std::min(resolution, (by + 1) * size); ++y)
                for (int x = bx * size; x < std::min(resolution, (bx + 1) * size); ++x) {
                    const size_t i = size_t(y) * size_t(resolution) + size_t(x);
                    value += histogram.LuminanceAt(i);
                    difference += estimate.LuminanceAt(i) - histogram.LuminanceAt(i);
                    variance += estimate.variance[i] + histogram.variance[i];
                    count += histogram.count[i];
                }
            if (!(count >= kMinSamples) || !(variance > 0)) {
                d.sigmas.push_back(std::nan(""));
                continue;
            }
            const double z = difference / std::sqrt(variance);
            d.sigmas.push_back(z);
            d.rms += z * z;
            d.largest = std::max(d.largest, std::abs(z));
            if (value > 0) noise.push_back(std::sqrt(variance) / value);
            ++d.numBlocks;
        }
    if (d.numBlocks > 0) d.rms = std::sqrt(d.rms / d.numBlocks);
    if (!noise.empty()) {
        const auto middle = noise.begin() + std::ptrdiff_t(noise.size() / 2);
        std::nth_element(noise.begin(), middle, noise.end());
        d.medianNoise = *middle;
    }
    return d;
}

Image ToImage(const LobeImage& lobe) {
    Image image({lobe.resolution, lobe.resolution}, {"R", "G", "B", "Noise.Y"});
    image.SetColorSpace(&ColorSpace::SRGB());
    for (size_t i = 0; i < lobe.value.size(); ++i) {
        for (int c = 0; c < 3; ++c) image.Pixels()[4 * i + size_t(c)] = float(lobe.value[i][c]);
        image.Pixels()[4 * i + 3] = float(std::sqrt(lobe.variance[i]));
    }
    return image;
}

Image ToImage(const std::vector<double>& density) {
    const int side = int(std::lround(std::sqrt(double(density.size()))));
    Image image({side, side}, {"Y"});
    for (size_t i = 0; i < density.size(); ++i) image.Pixels()[i] = float(density[i]);
    return image;
}

}  // namespace lacquer::measure
