// Estimators side by side on one configuration.
#pragma once

#include "noise_ratio.h"
#include "product_stacks.h"

namespace lacquer::bench {

/// An estimator on a stack whose Beckmann interfaces draw facets in some way.
struct Candidate {
    /// "halfvector", "multiproduct:5" for products of up to 5 events, "pairproduct:all:9" for pairs of all
    /// strategies and up to 9 events, "bidirectional@newton" with another sampler
    std::string name;
    const layered::LayeredEstimator* estimator;
    SlopeSampler sampler = SlopeSampler::Library;
};
/// The candidate of this name. Errors: std::invalid_argument that names what is unknown.
Candidate FindCandidate(const std::string& name);

struct CompareOptions {
    double seconds = 0.5;           ///< of each candidate on each configuration
    size_t numPairs = 48;           ///< of directions
    bool usesUniformPairs = false;  ///< in place of pairs from the stack's lobes
    Resampling resampling = Resampling::Both;
    int numReplicas = 400;  ///< of the bootstrap
    uint64_t seed = 1;
};

struct DirectionPair {
    Vec3 wo, wi;
};
/// wo uniform on the projected disk, to 76 degrees; wi what light that enters by it becomes, followed through
/// the stack, of the configuration's component only. `u`niform: wi uniform on the projected disk as well, on
/// the component's side.
std::vector<DirectionPair> LobePairs(const Configuration& configuration, size_t count, uint64_t seed);
std::vector<DirectionPair> UniformPairs(const Configuration& configuration, size_t count, uint64_t seed);

struct CandidateResult {
    std::string name;
    Noise noise;                      ///< of the average over the wavelengths of f |cos theta_i|
    LogRatios ratios;                 ///< against the baseline
    std::vector<LogRatios> replicas;  ///< drawn alike for all candidates; empty for the baseline
    double deviation = 0;             ///< of the mean from the baseline's, in standard errors
};
/// The first candidate is the baseline. Candidates take turns in batches of about a millisecond; the time is
/// that of the calling thread. Random numbers depend on the candidate's name and on the seed, not on time;
/// only the number of rounds does.
std::vector<CandidateResult> Compare(const Configuration& configuration,
                                     std::span<const Candidate> candidates, const CompareOptions& options);

}  // namespace lacquer::bench
