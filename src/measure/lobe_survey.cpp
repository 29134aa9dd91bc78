#include "measure/lobe_survey.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <tuple>

#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"

namespace lacquer::measure {

namespace {

constexpr int64_t kBatchesPerChunk = 64;
constexpr size_t kDirectionsPerChunk = 256;

using Clock = std::chrono::steady_clock;
double NanosecondsSince(Clock::time_point t) {
    return std::chrono::duration<double, std::nano>(Clock::now() - t).count();
}

/// Runs body(chunk, its batches, its generator) in parallel and returns the results in order, so that sums do
/// not depend on the number of threads.
template <class Result, class Body>
std::vector<Result> RunChunks(const LobeQuery& query, int64_t numBatches, uint64_t purpose,
                              const Body& body) {
    const int64_t chunks = (numBatches + kBatchesPerChunk - 1) / kBatchesPerChunk;
    std::vector<Result> results(static_cast<size_t>(chunks));
    ParallelFor(chunks, [&](int64_t chunk) {
        Rng rng(Hash(query.seed, purpose, chunk));
        const int64_t first = chunk * kBatchesPerChunk;
        const int64_t count = std::min(kBatchesPerChunk, numBatches - first);
        body(results[size_t(chunk)], first, count, rng);
        if (query.observer) query.observer->Advance(count * BsdfSubject::kNumSets);
    });
    return results;
}

/// Directions of specular peaks differ by rounding: they are told apart on a fine grid.
using PeakKey = std::tuple<int, int, bool>;
PeakKey KeyOf(Vec3 w) {
    constexpr float kCells = 2048;
    return {int(std::lround(w.x * kCells)), int(std::lround(w.y * kCells)), w.z > 0};
}

struct SampleChunk {
    SampledLobe lobe;
    std::map<PeakKey, SpecularPeak> peaks;
    bool hasEta = false;
};

class BatchSampler {
  public:
    BatchSampler(const LobeQuery& query, SampleChunk& chunk, Rng& rng) : q_(query), out_(chunk), rng_(rng) {}

    void Batch(int64_t batch) {
        reflected_ = transmitted_ = smoothReflected_ = smoothTransmitted_ = glm::dvec3(0);
        for (int set = 0; set < BsdfSubject::kNumSets; ++set) One(batch * BsdfSubject::kNumSets + set);
        out_.lobe.reflected.Add(reflected_);
        out_.lobe.transmitted.Add(transmitted_);
        out_.lobe.smoothReflected.Add(smoothReflected_);
        out_.lobe.smoothTransmitted.Add(smoothTransmitted_);
    }

  private:
    void One(int64_t i) {
        const float lobe = rng_.Uniform();
        const BxDFRandom u{lobe, rng_.Uniform2D()};
        const auto sample = q_.subject.At(i).Sample(q_.w, u, {.mode = q_.mode, .rng = &rng_});
        if (!sample) return;
        const bool isTransmitted = !SameHemisphere(q_.w, sample->wi);
        if (isTransmitted) {
            out_.lobe.eta = double(sample->eta);
            out_.hasEta = true;
        }
        if (!IsUsable(sample->weight)) {
            ++out_.lobe.badSamples;
            return;
        }
        // Radiance that crosses into another index is scaled; the environment there has its n^2.
        const double scale =
            isTransmitted && q_.mode == TransportMode::Radiance ? Sqr(double(sample->eta)) : 1.0;
        const glm::dvec3 energy =
            glm::dvec3(q_.subject.ToRGB(sample->weight, i)) * (scale / BsdfSubject::kNumSets);
        (isTransmitted ? transmitted_ : reflected_) += energy;
        if (sample->IsSpecular()) {
            SpecularPeak& peak = out_.peaks[KeyOf(sample->wi)];
            peak.w = sample->wi;
            peak.energy += energy;
        } else {
            (isTransmitted ? smoothTransmitted_ : smoothReflected_) += energy;
            if (out_.lobe.directions.size() < kDirectionsPerChunk && sample->wi.z != 0)
                out_.lobe.directions.push_back(sample->wi);
        }
    }

    const LobeQuery& q_;
    SampleChunk& out_;
    Rng& rng_;
    glm::dvec3 reflected_{0}, transmitted_{0}, smoothReflected_{0}, smoothTransmitted_{0};
};

/// Point i of the additive recurrence in four dimensions [Roberts 2018], from `start`.
glm::dvec4 RecurrencePoint(glm::dvec4 start, int64_t i) {
    // Powers of the inverse of the root of x^5 = x + 1.
    constexpr double a = 0.8566748838545029;
    const glm::dvec4 x = start + double(i) * glm::dvec4(a, a * a, a * a * a, a * a * a * a);
    return x - glm::floor(x);
}

}  // namespace

SampledLobe SampleLobe(const LobeQuery& query, int64_t numBatches) {
    const auto chunks = RunChunks<SampleChunk>(query, numBatches, 1,
                                               [&](SampleChunk& out, int64_t first, int64_t count, Rng& rng) {
                                                   BatchSampler sampler(query, out, rng);
                                                   for (int64_t b = first; b < first + count; ++b)
                                                       sampler.Batch(b);
                                               });
    SampledLobe lobe;
    std::map<PeakKey, SpecularPeak> peaks;
    for (const SampleChunk& chunk : chunks) {
        lobe.reflected.Merge(chunk.lobe.reflected);
        lobe.transmitted.Merge(chunk.lobe.transmitted);
        lobe.smoothReflected.Merge(chunk.lobe.smoothReflected);
        lobe.smoothTransmitted.Merge(chunk.lobe.smoothTransmitted);
        lobe.badSamples += chunk.lobe.badSamples;
        if (chunk.hasEta) lobe.eta = chunk.lobe.eta;
        const auto& directions = chunk.lobe.directions;
        lobe.directions.insert(lobe.directions.end(), directions.begin(), directions.end());
        for (const auto& [key, peak] : chunk.peaks) {
            peaks[key].w = peak.w;
            peaks[key].energy += peak.energy / double(numBatches);
        }
    }
    for (const auto& [key, peak] : peaks) lobe.peaks.push_back(peak);
    std::stable_sort(lobe.peaks.begin(), lobe.peaks.end(), [](const SpecularPeak& a, const SpecularPeak& b) {
        return Luminance(a.energy) > Luminance(b.energy);
    });
    constexpr size_t kMaxPeaks = 8;
    if (lobe.peaks.size() > kMaxPeaks) lobe.peaks.resize(kMaxPeaks);
    return lobe;
}

DirectionGuide LearnGuide(const LobeQuery& query, const SampledLobe& lobe) {
    const bool up = query.w.z > 0;
    bool reflects = Any(query.subject.Flags(), Lobes::Reflection);
    const bool transmits = Any(query.subject.Flags(), Lobes::Transmission);
    if (!transmits) reflects = true;
    return {lobe.directions, up ? reflects : transmits, up ? transmits : reflects};
}

LobeEnergy IntegrateLobe(const LobeQuery& query, const DirectionGuide& guide, double eta,
                         int64_t numBatches) {
    // Well-spread points, moved at random in each of many parts, whose means give the error.
    constexpr int64_t kParts = 64;
    const int64_t batchesPerPart = std::max<int64_t>(1, numBatches / kParts);
    std::vector<LobeEnergy> parts(kParts);
    ParallelFor(kParts, [&](int64_t part) {
        Rng rng(Hash(query.seed, 2, part));
        const glm::dvec4 start(rng.Uniform(), rng.Uniform(), rng.Uniform(), rng.Uniform());
        glm::dvec3 reflected(0), transmitted(0);
        LobeEnergy& out = parts[size_t(part)];
        for (int64_t b = 0; b < batchesPerPart; ++b) {
            // One direction for all wavelengths: their sum has no noise of its own.
            const DirectionGuide::Draw draw = guide.Sample(RecurrencePoint(start, b));
            const bool isTransmitted = !SameHemisphere(query.w, draw.w);
            const bool isScaled = isTransmitted && query.mode == TransportMode::Radiance;
            const double scale =
                double(Pi) / draw.diskDensity / BsdfSubject::kNumSets * (isScaled ? Sqr(eta) : 1.0);
            for (int set = 0; set < BsdfSubject::kNumSets; ++set) {
                const int64_t i = (part * batchesPerPart + b) * BsdfSubject::kNumSets + set;
                const BxDFContext context{.mode = query.mode, .rng = &rng, .needsPdf = false};
                const SampledSpectrum f = query.subject.At(i).Evaluate(query.w, draw.w, context).f;
                if (IsUsable(f))
                    (isTransmitted ? transmitted : reflected) +=
                        glm::dvec3(query.subject.ToRGB(f, i)) * scale;
                else
                    ++out.badSamples;
            }
        }
        out.reflected.Add(reflected / double(batchesPerPart));
        out.transmitted.Add(transmitted / double(batchesPerPart));
        if (query.observer) query.observer->Advance(batchesPerPart * BsdfSubject::kNumSets);
    });
    LobeEnergy energy;
    for (const LobeEnergy& part : parts) {
        energy.reflected.Merge(part.reflected);
        energy.transmitted.Merge(part.transmitted);
        energy.badSamples += part.badSamples;
    }
    return energy;
}

Reciprocity MeasureReciprocity(const BsdfSubject& subject, Vec3 w, double eta, int numPairs,
                               int64_t numBatches, uint64_t seed) {
    // One way round transmission is scaled by the index below over that above, or its inverse.
    const double etaBelow = w.z > 0 ? eta : 1 / eta;
    struct Pair {
        ColorMean forth, back;
    };
    std::vector<Pair> pairs(static_cast<size_t>(numPairs));
    ParallelFor(numPairs, [&](int64_t i) {
        Rng rng(Hash(seed, 3, i));
        const bool bothSides = Any(subject.Flags(), Lobes::Transmission);
        const auto randomDirection = [&] {
            const Vec3 d = SampleCosineHemisphere(rng.Uniform2D());
            return bothSides && rng.Uniform() < 0.5f ? -d : d;
        };
        const Vec3 wo = randomDirection();
        Vec3 wi = randomDirection();
        // Half of the pairs lie in the lobe, half anywhere.
        const float lobe = rng.Uniform();
        const BxDFRandom u{lobe, rng.Uniform2D()};
        const auto sample = subject.At(i).Sample(wo, u, {.rng = &rng});
        if (i % 2 == 0 && sample && !sample->IsSpecular()) wi = sample->wi;
        const double relative = wo.z > 0 ? etaBelow : 1 / etaBelow;
        const double scale = SameHemisphere(wo, wi) ? 1 : Sqr(relative);
        Pair& pair = pairs[size_t(i)];
        pair.forth = subject.Evaluate(wo, wi, TransportMode::Radiance, numBatches, rng, scale);
        pair.back = subject.Evaluate(wi, wo, TransportMode::Radiance, numBatches, rng);
    });
    Reciprocity result;
    for (const Pair& pair : pairs) {
        const double forth = pair.forth.Luminance(), back = pair.back.Luminance(),
                     middle = (forth + back) / 2;
        if (!(middle > 0)) continue;
        const double difference = std::abs(forth - back);
        const double sigma =
            subject.IsStochastic() ? std::hypot(pair.forth.LuminanceError(), pair.back.LuminanceError()) : 0;
        ++result.numPairs;
        result.meanRelative += difference / middle;
        result.maxRelative = std::max(result.maxRelative, difference / middle);
        result.expectedMean += std::sqrt(2 / double(Pi)) * sigma / middle;  // mean of |normal|
        if (sigma > 0) result.largestSigmas = std::max(result.largestSigmas, difference / sigma);
    }
    if (result.numPairs > 0) {
        result.meanRelative /= result.numPairs;
        result.expectedMean /= result.numPairs;
    }
    return result;
}

EvaluationCost MeasureCost(const LobeQuery& query, const SampledLobe& lobe) {
    constexpr double kSecondsEach = 0.1;
    constexpr int64_t kRound = 256;
    EvaluationCost cost;
    Rng rng(Hash(query.seed, 4));
    // Directions are drawn beforehand: only the BxDF is on the clock.
    std::vector<Vec3> directions = lobe.directions;
    if (directions.empty())
        for (int64_t i = 0; i < kRound; ++i) {
            const Vec3 d = SampleCosineHemisphere(rng.Uniform2D());
            directions.push_back(query.w.z > 0 ? d : -d);
        }
    const auto directionAt = [&](int64_t i) { return directions[size_t(i * 7919) % directions.size()]; };
    SampledSpectrum sink;
    const auto time = [&](const auto& body) {
        int64_t count = 0;
        const Clock::time_point start = Clock::now();
        do {
            for (int64_t k = 0; k < kRound; ++k) body(count++);
        } while (NanosecondsSince(start) < 1e9 * kSecondsEach);
        return NanosecondsSince(start) / double(count);
    };
    const auto evaluate = [&](int64_t i, bool needsPdf) {
        const BxDFContext context{.mode = query.mode, .rng = &rng, .needsPdf = needsPdf};
        return query.subject.At(i).Evaluate(query.w, directionAt(i), context).f;
    };
    cost.evaluateNs = time([&](int64_t i) { sink += evaluate(i, true); });
    cost.evaluateWithoutPdfNs = time([&](int64_t i) { sink += evaluate(i, false); });
    cost.sampleNs = time([&](int64_t i) {
        const float u = rng.Uniform();
        const BxDFRandom random{u, rng.Uniform2D()};
        const auto sample = query.subject.At(i).Sample(query.w, random, {.mode = query.mode, .rng = &rng});
        if (sample) sink += sample->weight;
    });
    // The sums must be used, or they would not be computed.
    if (sink.Sum() == -1) cost.noise = 1;
    if (!query.subject.IsStochastic()) return cost;
    double variance = 0, squares = 0;
    constexpr int64_t kPairs = 1 << 14;
    for (int64_t i = 0; i < kPairs; ++i) {
        const double a = double(evaluate(i, true).Average()), b = double(evaluate(i, true).Average());
        if (!std::isfinite(a) || !std::isfinite(b)) continue;
        variance += Sqr(a - b) / 2;
        squares += a * b;
    }
    cost.noise = squares > 0 ? std::sqrt(variance / squares) : 0;
    return cost;
}

}  // namespace lacquer::measure
