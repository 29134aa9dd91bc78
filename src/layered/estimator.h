// How the value of a stack is estimated, and the density of its samples: the interfaces of all estimators.
#pragma once

#include <memory>

#include "layered/stack.h"
#include "pbrt/core/registry.h"

namespace lacquer {
class Params;
}

namespace lacquer::layered {

/// Estimates, for fixed directions outside, the light of all paths of two and more vertices: everything but
/// the single reflection or transmission by one interface, which is exact. What it has of its own are its
/// parameters: constant, and asked from several threads.
class LayeredEstimator {
  public:
    virtual ~LayeredEstimator() = default;
    /// An unbiased estimate of f - f0 [1/sr], without the cosine of wi; wo, wi unit and outside of the stack
    /// on either side. Takes its randomness from context.rng. `maxVertices`: longer paths count as 0.
    virtual SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                                     int maxVertices) const = 0;
    /// True if Evaluate() takes the closed form where a stack has one (see lambertian/). Densities and
    /// Sample() of the BxDF are then those of the closed form, too.
    virtual bool UsesClosedForms() const { return false; }
    /// True if Evaluate() is not unbiased but the value of a stack's lobes (see lobes/). Densities and
    /// Sample() of the BxDF are then those of the lobes, too.
    virtual bool IsLobes() const { return false; }
};

/// Counts an evaluation by products of lobes. @param applies  false: it was left to "bidirectional"
inline void CountProductQuery(const BxDFContext& context, bool applies) {
    if (!context.counters) return;
    ++context.counters->productQueries;
    context.counters->productFallbacks += !applies;
}

/// By the names that scenes and the command line use. A factory reads the estimator's parameters among those
/// of the material, which owns what it makes. Errors: SceneError at the parameter.
struct LayeredEstimatorKind {
    static constexpr const char* kKind = "estimator";
    static constexpr const char* kDefault = "auto";  ///< where neither command line nor scene names one
    using Factory = std::unique_ptr<const LayeredEstimator> (*)(const Params& params);
    struct Traits {
        bool isApproximate = false;  ///< it has another expectation than the others
    };
};

/// Of a class without parameters, for LACQUER_REGISTER.
template <class Estimator>
std::unique_ptr<const LayeredEstimator> MakeEstimator(const Params&) {
    return std::make_unique<Estimator>();
}

/// How the density of Sample() is estimated for multiple importance weights.
class LayeredPdf {
  public:
    virtual ~LayeredPdf() = default;
    /// An estimate of the density of drawing wi for wo [1/sr], all paths included; positive.
    virtual float Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                           int maxVertices) const = 0;
    /// True if Sample() of the BxDF should draw from the stack's lobes (see lobes/) where that finds all
    /// light. The density is then that of the lobes, too, whatever Evaluate() says.
    virtual bool PrefersLobes(const Stack& /*stack*/) const { return false; }
};
/// As LayeredEstimatorKind.
struct LayeredPdfKind {
    static constexpr const char* kKind = "pdf";
    static constexpr const char* kDefault = "auto";
    using Factory = std::unique_ptr<const LayeredPdf> (*)(const Params& params);
};
template <class Pdf>
std::unique_ptr<const LayeredPdf> MakePdf(const Params&) {
    return std::make_unique<Pdf>();
}

}  // namespace lacquer::layered
