// Integrals that tell two lobes apart, and the two ways to estimate them: by walks that are counted where
// they leave, and by evaluations in directions of a known density.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "layered/analog_walk.h"
#include "support/statistics.h"

namespace lacquer::layered::test {

using namespace lacquer::test;  // the checks of tests/support

/// Weighted integrals of f |cos theta_i| over each side of the stack: with weight 1 (the albedo), near the
/// mirrored or refracted direction (14 degrees), at grazing angles (|cos| < 0.35), and with x and y. Mean
/// over the wavelengths; then the albedo of each wavelength.
inline constexpr int kWeightsPerSide = 6;
inline constexpr int kNumMoments = 2 * kWeightsPerSide + kNumWavelengths;
std::string MomentName(int moment);

/// Running means of all moments.
class Moments {
  public:
    Moments(const Stack& stack, Vec3 wo);
    /// A sample that found nothing.
    void AddNothing() { ++count_; }
    /// @param value  f |cos theta_i| / pdf, or the weight of a walk that left along wi
    void Add(Vec3 wi, SampledSpectrum value);
    void Add(const Moments& others);

    double Mean(int moment) const { return sums_[size_t(moment)] / std::max(1., count_); }
    double StandardError(int moment) const;
    /// Of the mean over wavelengths of the albedo of both sides.
    double Albedo() const { return Mean(0) + Mean(kWeightsPerSide); }
    double AlbedoError() const { return StandardError(kNumMoments); }
    double Count() const { return count_; }
    /// Samples that were not finite or negative.
    int NumInvalid() const { return numInvalid_; }

  private:
    void AddTo(size_t i, double x) {
        sums_[i] += x;
        squares_[i] += x * x;
    }
    std::array<Vec3, 2> peaks_;  ///< above and below
    double count_ = 0;
    int numInvalid_ = 0;
    std::array<double, kNumMoments + 1> sums_{}, squares_{};  ///< the last one: albedo of both sides
};

/// A density over the sphere from which directions are drawn: a quadtree on the octahedral square, as fine as
/// the directions that it was made from are dense, mixed with cosine lobes on both sides so that it is
/// nowhere too small. Known exactly; however it was made, integrals by it are unbiased.
class GuideDensity {
  public:
    /// @param directions, weights  where light leaves, and how much
    /// @param transmits  false: few directions below, where values must be 0
    GuideDensity(const std::vector<Vec3>& directions, const std::vector<double>& weights, bool transmits);
    struct GuidedDirection {
        Vec3 w;
        double pdf;  ///< over solid angle [1/sr]
    };
    GuidedDirection Sample(Rng& rng) const;
    double Pdf(Vec3 w) const;

  private:
    struct Node {
        int child = -1;   ///< index of the first of four; -1: a leaf
        double mass = 0;  ///< fraction of all weight
    };
    struct Item {
        Point2 p;
        double weight;
    };
    void Split(int node, const std::vector<Item>& items, Point2 corner, float size, int depth);
    double TreeDensity(Vec3 w) const;
    std::vector<Node> nodes_;
    double treeShare_ = 0, upShare_ = 0;
};

/// Which query is examined.
struct LobeQuery {
    const Stack& stack;
    Vec3 wo;
    TransportMode mode = TransportMode::Radiance;
    int maxVertices = kMaxPathVertices;
};

/// By walks. Paths of specular events are left out unless `withSpecular`.
Moments MomentsByWalks(const LobeQuery& query, int numWalks, uint64_t seed, bool withSpecular = false);
/// Draws by BxDF::Sample(), all numbers from one generator. @param visit  gets each, also the empty ones
template <class Visitor>
void VisitSamples(const BxDF& bxdf, Vec3 wo, TransportMode mode, Lobes sides, int numSamples, uint64_t seed,
                  const Visitor& visit) {
    Rng rng(seed);
    const BxDFContext context{mode, sides, &rng};
    for (int i = 0; i < numSamples; ++i) {
        const float lobe = rng.Uniform();
        visit(bxdf.Sample(wo, {lobe, rng.Uniform2D()}, context));
    }
}
/// By draws, those of specular paths included.
Moments MomentsBySamples(const BxDF& bxdf, const LobeQuery& query, Lobes sides, int numSamples,
                         uint64_t seed);
/// A guide from walks.
GuideDensity GuideOf(const LobeQuery& query, uint64_t seed);
/// By evaluation.
/// @param f  a value or an estimate [1/sr] of f(wo, wi, mode), without the cosine; gets wi and a generator
template <class Function>
Moments MomentsByValues(const LobeQuery& query, const GuideDensity& guide, int numValues, uint64_t seed,
                        const Function& f) {
    Moments moments(query.stack, query.wo);
    Rng rng(seed);
    for (int i = 0; i < numValues; ++i) {
        const GuideDensity::GuidedDirection draw = guide.Sample(rng);
        moments.Add(draw.w, f(draw.w, rng) * float(std::abs(double(draw.w.z)) / draw.pdf));
    }
    return moments;
}

/// How far two estimates of the same moments are apart.
struct Comparison {
    std::array<double, kNumMoments> z{};  ///< difference in standard errors; 0 if both are exact and agree
    double albedoExcess = 0, albedoExcessError = 0;  ///< relative difference of albedos, and its error
    double WorstZ() const;
    std::string Describe(const Moments& found, const Moments& expected) const;
};
Comparison Compare(const Moments& found, const Moments& expected);

}  // namespace lacquer::layered::test
