#include "layered/paths/long_paths/long_path.h"

#include "layered/paths/long_paths/long_path_steps.h"

namespace lacquer::layered {
namespace {

/// A walk between coat and base. Its directions are turned up, see long_path_steps.h; none of its factors
/// has the eta^2 of the two refractions.
template <class CoatFacets, class BaseFacets>
class LongPathWalk {
  public:
    LongPathWalk(const Stack& stack, const MicrofacetSurface& coat, const MicrofacetSurface& base, Rng& rng)
        : coat_(stack.interfaces[0]),
          base_(stack.interfaces[1]),
          slab_(stack.slabs[0]),
          baseStep_(base.alphaX, coat.alphaX, coat.eta, slab_.opticalThickness.MinComponent()),
          coatStep_(coat.alphaX, coat.eta),
          rng_(rng) {}

    SampledSpectrum Estimate(Vec3 start, Vec3 end, int maxVertices, int minVertices) {
        State first, last;
        rng_.StartPart();
        SampledSpectrum sum(0);
        if (!Enter(start, &first) || !Enter(end, &last)) return sum;
        State walk = first;
        float reference = 0;
        for (int vertices = 3;; vertices += 2) {
            if (vertices >= minVertices) sum += walk.beta * BaseValue(walk.w, last.w);
            rng_.StartPart();
            if (vertices > maxVertices - 2 || !Bounce(&walk)) break;
            // Roulette right after the first bounce would bring back the noise of internal reflection.
            if (vertices == 3)
                reference = walk.beta.MaxComponent();
            else if (!SurvivesRoulette(&walk.beta, reference))
                break;
        }
        return sum * last.beta;
    }

  private:
    struct State {
        Vec3 w;                ///< away from the base
        SampledSpectrum beta;  ///< f cos / density of all that was drawn
    };

    bool Enter(Vec3 outside, State* state) const {
        const BxDFContext context{.mode = TransportMode::Importance,
                                  .sides = Lobes::Transmission,
                                  .rng = &rng_,
                                  .needsSamplePdf = false};
        const std::optional<BxDFSample> sample = coat_.Sample(outside, context);
        if (!sample || !(sample->wi.z < 0)) return false;
        *state = {-sample->wi, sample->weight};
        Cross(state->w, &state->beta);
        return bool(state->beta);
    }
    void Cross(Vec3 w, SampledSpectrum* beta) const {
        if (!slab_.IsClear()) *beta *= slab_.Cross(w, 1).transmittance;
    }
    SampledSpectrum BaseValue(Vec3 wo, Vec3 wi) const {
        return base_.Evaluate(wo, wi, {TransportMode::Radiance, Lobes::Reflection, &rng_, false}).f;
    }

    /// Up from the base, off the coat, and down again.
    bool Bounce(State* state) const {
        Vec3 up, down;
        float pdf, coatWeight;
        if (!baseStep_.Sample(state->w, rng_, &up, &pdf) || !coatStep_.Sample(up, rng_, &down, &coatWeight))
            return false;
        SampledSpectrum& beta = state->beta;
        beta *= BaseValue(state->w, up) * (up.z / pdf * coatWeight);
        Cross(up, &beta);
        Cross(down, &beta);
        state->w = down;
        return beta.MaxComponent() > std::numeric_limits<float>::min();
    }
    bool SurvivesRoulette(SampledSpectrum* beta, float reference) const {
        constexpr float kSafety = 3;
        const float survival = std::min(1.f, kSafety * beta->MaxComponent() / reference);
        if (!(rng_.Uniform() < survival)) return false;
        *beta /= survival;
        return true;
    }

    const StackInterface &coat_, &base_;
    const Slab& slab_;
    BaseReflection<BaseFacets> baseStep_;
    CoatReflection<CoatFacets> coatStep_;
    Rng& rng_;
};

template <class CoatFacets>
SampledSpectrum EstimateUnder(const Stack& stack, const MicrofacetSurface& coat,
                              const MicrofacetSurface& base, Rng& rng, Vec3 start, Vec3 end, int maxVertices,
                              int minVertices) {
    if (base.model == MicrofacetModel::Beckmann)
        return LongPathWalk<CoatFacets, Beckmann>(stack, coat, base, rng)
            .Estimate(start, end, maxVertices, minVertices);
    return LongPathWalk<CoatFacets, TrowbridgeReitz>(stack, coat, base, rng)
        .Estimate(start, end, maxVertices, minVertices);
}

}  // namespace

bool LongPathWalkApplies(const Stack& stack, Vec3 wo, Vec3 wi) {
    if (stack.Last() != 1 || !(wo.z > 0) || !(wi.z > 0) || stack.slabs[0].Scatters()) return false;
    const auto coat = stack.interfaces[0].IsotropicFacets(), base = stack.interfaces[1].IsotropicFacets();
    return coat && base && coat->eta > 0 && base->eta == 0;
}

// Reflection between two directions outside: radiance loses eta^2 at one refraction, importance at the other
// one, and it does not matter which side is which.
SampledSpectrum EstimateLongPaths(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                                  int maxVertices, int minVertices) {
    if (maxVertices < std::max(3, minVertices)) return SampledSpectrum(0);
    const MicrofacetSurface coat = *stack.interfaces[0].IsotropicFacets(),
                            base = *stack.interfaces[1].IsotropicFacets();
    // Less noise than from the other side.
    const Vec3 start = wo.z < wi.z ? wo : wi, end = wo.z < wi.z ? wi : wo;
    const auto estimate =
        coat.model == MicrofacetModel::Beckmann ? EstimateUnder<Beckmann> : EstimateUnder<TrowbridgeReitz>;
    return estimate(stack, coat, base, *context.rng, start, end, maxVertices, minVertices) / Sqr(coat.eta);
}

}  // namespace lacquer::layered
