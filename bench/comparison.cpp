#include "comparison.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "cpu_time.h"
#include "layered/paths/interface_path.h"
#include "pbrt/core/check.h"
#include "pbrt/core/sampling.h"

namespace lacquer::bench {
namespace {

constexpr int kEstimatesPerTurn = 16;  ///< of each pair in each round

uint64_t HashOf(const std::string& text) {
    uint64_t h = 0;
    for (const char c : text) h = Hash(h, c);
    return h;
}

const layered::LayeredBxDF* MakeBxDF(const Configuration& configuration, SlopeSampler sampler, Arena& arena) {
    layered::LayeredOptions options;
    options.estimator = test::FindEstimator("bidirectional");
    options.pdf = test::FindPdf("approximate");
    options.maxVertices = configuration.maxVertices;
    test::StackCase row;
    row.layers = configuration.layers(sampler);
    return row.MakeBxDF(arena, options);
}

/// Uniform on the projected disk up to a sine.
Vec3 OnDisk(Rng& rng, float maxSine, float sign) {
    const Point2 u = rng.Uniform2D();
    const float r = maxSine * std::sqrt(u.x), phi = 2 * Pi * u.y;
    return {r * std::cos(phi), r * std::sin(phi), sign * std::sqrt(1 - r * r)};
}

constexpr float kMaxSineOut = 0.97f, kMaxSineIn = 0.995f, kMinCosineIn = 0.05f;

}  // namespace

Candidate FindCandidate(const std::string& name) {
    const size_t at = name.find('@');
    const std::string model = name.substr(0, at), estimator = model.substr(0, model.find(':'));
    if (!Registry<layered::LayeredEstimatorKind>::Find(estimator))
        throw std::invalid_argument(fmt::format("no estimator \"{}\"", estimator));
    Candidate candidate{name, nullptr};
    try {
        candidate.estimator = test::FindEstimator(model);
    } catch (const std::exception& error) {
        throw std::invalid_argument(fmt::format("no estimator \"{}\": {}", model, error.what()));
    }
    if (at == std::string::npos) return candidate;
    const std::string suffix = name.substr(at + 1);
    for (const NamedSlopeSampler& known : SlopeSamplers())
        if (suffix == known.name) {
            candidate.sampler = known.sampler;
            return candidate;
        }
    throw std::invalid_argument(fmt::format("no sampler \"{}\"", suffix));
}

// Light that the outermost interface reflects at once is exact and no estimator's business. With the number
// that chooses the lobe next to 1 that interface lets light in; the walk takes all further numbers from the
// generator.
std::vector<DirectionPair> LobePairs(const Configuration& configuration, size_t count, uint64_t seed) {
    constexpr float kEnters = 1 - 2 * MachineEpsilon;
    Arena arena;
    const layered::LayeredBxDF& bxdf = *MakeBxDF(configuration, SlopeSampler::Library, arena);
    Rng rng(Hash(seed, HashOf(configuration.name)));
    const BxDFContext context{TransportMode::Radiance, configuration.side, &rng};
    std::vector<DirectionPair> pairs;
    for (size_t i = 0; pairs.size() < count; ++i) {
        LACQUER_CHECK(i < 100000 * count);
        const Vec3 wo = OnDisk(rng, kMaxSineOut, 1);
        const auto sample = bxdf.Sample(wo, {kEnters, rng.Uniform2D()}, context);
        if (sample && !sample->IsSpecular() && std::abs(sample->wi.z) > kMinCosineIn)
            pairs.push_back({wo, sample->wi});
    }
    return pairs;
}

std::vector<DirectionPair> UniformPairs(const Configuration& configuration, size_t count, uint64_t seed) {
    Rng rng(Hash(seed, HashOf(configuration.name)));
    std::vector<DirectionPair> pairs;
    while (pairs.size() < count) {
        const Vec3 wo = OnDisk(rng, kMaxSineOut, 1);
        pairs.push_back(
            {wo, OnDisk(rng, kMaxSineIn, configuration.side == Lobes::Transmission ? -1.f : 1.f)});
    }
    return pairs;
}

namespace {

/// One candidate at work on one configuration.
class Contender {
  public:
    Contender(const Configuration& configuration, const Candidate& candidate, size_t numPairs, uint64_t seed)
        : sums(numPairs),
          estimator_(candidate.estimator),
          stack_(MakeBxDF(configuration, candidate.sampler, arena_)->GetStack()),
          maxVertices_(configuration.maxVertices),
          seed_(Hash(seed, HashOf(configuration.name), HashOf(candidate.name))) {}

    /// Adds a round of estimates of all pairs; returns its time [s].
    double Turn(std::span<const DirectionPair> pairs, uint64_t round) {
        const size_t block = round % NoiseSums::kBlocks;
        const double start = CpuSeconds();
        for (size_t i = 0; i < pairs.size(); ++i) {
            Rng rng(Hash(seed_, round, i));
            const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
            const double cosine = std::abs(double(pairs[i].wi.z));
            double sum = 0, squares = 0;
            for (int k = 0; k < kEstimatesPerTurn; ++k) {
                const double x =
                    cosine *
                    double(estimator_->Evaluate(stack_, pairs[i].wo, pairs[i].wi, context, maxVertices_)
                               .Average());
                sum += x;
                squares += x * x;
            }
            sums.Add(block, i, kEstimatesPerTurn, sum, squares);
        }
        const double seconds = CpuSeconds() - start;
        sums.AddTime(block, seconds);
        return seconds;
    }

    NoiseSums sums;

  private:
    Arena arena_;
    const layered::LayeredEstimator* estimator_;
    layered::Stack stack_;
    int maxVertices_;
    uint64_t seed_;
};

/// Fills the sums of all, in turns whose order changes from round to round.
void RunRounds(std::span<const std::unique_ptr<Contender>> contenders, std::span<const DirectionPair> pairs,
               double seconds) {
    double used = 0;
    const double budget = seconds * double(contenders.size());
    for (uint64_t round = 0; round < NoiseSums::kBlocks || used < budget; ++round)
        for (size_t i = 0; i < contenders.size(); ++i)
            used += contenders[(i + round) % contenders.size()]->Turn(pairs, round);
}

}  // namespace

std::vector<CandidateResult> Compare(const Configuration& configuration,
                                     std::span<const Candidate> candidates, const CompareOptions& options) {
    const std::vector<DirectionPair> pairs =
        (options.usesUniformPairs ? UniformPairs : LobePairs)(configuration, options.numPairs, options.seed);
    std::vector<std::unique_ptr<Contender>> contenders;
    for (const Candidate& candidate : candidates) {
        contenders.push_back(
            std::make_unique<Contender>(configuration, candidate, pairs.size(), options.seed));
        // Tables that an estimator makes at its first use, and the caches, are not measured.
        Contender(configuration, candidate, pairs.size(), options.seed).Turn(pairs, 0);
    }
    RunRounds(contenders, pairs, options.seconds);

    const Multiplicity once = Once(pairs.size());
    const NoiseSums& baseline = contenders[0]->sums;
    const Noise baselineNoise = NoiseOf(baseline, once);
    std::vector<CandidateResult> results;
    for (size_t i = 0; i < contenders.size(); ++i) {
        const NoiseSums& sums = contenders[i]->sums;
        CandidateResult result{candidates[i].name, NoiseOf(sums, once), {}, {}, 0};
        const double error = std::hypot(result.noise.meanError, baselineNoise.meanError);
        if (error > 0) result.deviation = (result.noise.mean - baselineNoise.mean) / error;
        result.ratios = LogRatiosOf(baselineNoise, result.noise);
        if (i > 0)
            // The same seed for all: replicas of two candidates belong together, and their quotients say how
            // these compare.
            result.replicas =
                Bootstrap(baseline, sums, options.resampling, options.numReplicas, options.seed);
        results.push_back(std::move(result));
    }
    return results;
}

}  // namespace lacquer::bench
