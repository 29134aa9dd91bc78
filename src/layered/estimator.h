// How the value of a stack is estimated: the interface of all estimators.
#pragma once

#include "layered/stack.h"
#include "pbrt/core/registry.h"

namespace lacquer::layered {

/// Estimates, for fixed directions outside, the light of all paths of two and more vertices: everything but
/// the single reflection or transmission by one interface, which is exact. Stateless.
class LayeredEstimator {
  public:
    virtual ~LayeredEstimator() = default;
    /// An unbiased estimate of f - f0 [1/sr], without the cosine of wi; wo, wi unit and outside of the stack
    /// on either side. Takes its randomness from context.rng. `maxVertices`: longer paths count as 0.
    virtual SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                                     int maxVertices) const = 0;
    /// The same estimator with products of the lobes of up to `maxEvents` events (kDefaultProductEvents to
    /// Chain::kMaxEvents).
    /// Itself for those that have no such choice.
    virtual const LayeredEstimator* WithProductEvents(int /*maxEvents*/) const { return this; }
};

/// As many as in [Xia et al. 2020].
inline constexpr int kDefaultProductEvents = 3;

/// Counts an evaluation by products of lobes. @param applies  false: it was left to "bidirectional"
inline void CountProductQuery(const BxDFContext& context, bool applies) {
    if (!context.counters) return;
    ++context.counters->productQueries;
    context.counters->productFallbacks += !applies;
}

/// By the names that scenes and the command line use. The objects live as long as the program.
struct LayeredEstimatorKind {
    static constexpr const char* kKind = "estimator";
    using Factory = const LayeredEstimator* (*)();
};

/// The one object of a stateless class, for LACQUER_REGISTER.
template <class Estimator>
const LayeredEstimator* TheEstimator() {
    static const Estimator estimator;
    return &estimator;
}

/// How the density of Sample() is estimated for multiple importance weights.
class LayeredPdf {
  public:
    virtual ~LayeredPdf() = default;
    /// An estimate of the density of drawing wi for wo [1/sr], all paths included; positive.
    virtual float Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                           int maxVertices) const = 0;
};
struct LayeredPdfKind {
    static constexpr const char* kKind = "pdf";
    using Factory = const LayeredPdf* (*)();
};
template <class Pdf>
const LayeredPdf* ThePdf() {
    static const Pdf pdf;
    return &pdf;
}

}  // namespace lacquer::layered
