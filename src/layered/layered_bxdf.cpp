#include "layered/layered_bxdf.h"

#include <type_traits>

#include "layered/lambertian/lambertian_base.h"
#include "layered/lobes/lobe_sampler.h"
#include "pbrt/base/bxdf_numbers.h"

namespace lacquer::layered {

LayeredBxDF::LayeredBxDF(const Stack& stack, std::span<StackInterface> interfaces,
                         std::span<BxDF* const> bxdfs, const LayeredOptions& options)
    : stack_(stack),
      interfaces_(interfaces),
      bxdfs_(bxdfs),
      options_(options),
      usesClosedForms_(options.estimator->UsesClosedForms()),
      isLobes_(options.estimator->IsLobes()) {
    stack_.interfaces = interfaces_;
    prefersLobes_ = options.pdf && options.pdf->PrefersLobes(stack_);
    Classify();
}

void LayeredBxDF::Classify() {
    bool isRough = false, isDiffuse = false, reflects = false;
    transmits_ = true;
    for (const StackInterface& interface : interfaces_) {
        const Lobes lobes = interface.bxdf->Flags();
        isRough |= Any(lobes, Lobes::Glossy);
        isDiffuse |= Any(lobes, Lobes::Diffuse);
        reflects |= Any(lobes, Lobes::Reflection);
        transmits_ &= interface.transmits;
    }
    isDiffuse |= stack_.Scatters();
    reflects |= isDiffuse;

    const bool hasMirrorLobe = interfaces_.front().hasSpecular || interfaces_.back().hasSpecular;
    roughLobe_ = isDiffuse ? Lobes::Diffuse : isRough ? Lobes::Glossy : Lobes::None;
    const auto isGlossy = [](const StackInterface& interface) {
        return Any(interface.bxdf->Flags(), Lobes::Glossy);
    };
    const bool hasGlossySurface = isGlossy(interfaces_.front()) || isGlossy(interfaces_.back());
    flags_ = roughLobe_ | (hasGlossySurface ? Lobes::Glossy : Lobes::None) |
             (reflects ? Lobes::Reflection : Lobes::None) | (transmits_ ? Lobes::Transmission : Lobes::None) |
             (hasMirrorLobe ? Lobes::Specular : Lobes::None);
}

// ---- Value and density ------------------------------------------------------------------------------------

BxDFValue LayeredBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    BxDFValue value;
    if (!FlipDirections(&wo, &wi) || !IsAsked(wo, wi, context)) return value;

    // Paths of one vertex are exact.
    const bool isGlossyPart = Any(context.sides, Lobes::Glossy);
    if (SameHemisphere(wo, wi) || stack_.Last() == 0) {
        BxDFContext single = context;
        single.sides = Lobes::BothSides;
        const StackInterface& outer = interfaces_[size_t(stack_.OuterTowards(wo))];
        if (!isGlossyPart || Any(outer.bxdf->Flags(), Lobes::Glossy))
            value.f = outer.Evaluate(wo, wi, single).f;
    }
    if (isGlossyPart || context.maxVertices < 2) return value;
    const int maxVertices = std::min(options_.maxVertices, context.maxVertices);
    BxDFNumbers numbers(context, BxDFQuery::Value, options_.numSamples);
    SampledSpectrum sum(0);
    for (int i = 0; i < options_.numSamples; ++i) {
        numbers.StartCopy(i);
        sum += options_.estimator->Evaluate(stack_, wo, wi, numbers.Context(), maxVertices);
    }
    value.f += sum / float(options_.numSamples);

    // With numbers of its own: weights may not depend on the noise of the value.
    if (context.needsPdf) value.pdf = DensityOf(wo, wi, context);
    return value;
}

float LayeredBxDF::Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!FlipDirections(&wo, &wi) || !IsAsked(wo, wi, context)) return 0;
    return DensityOf(wo, wi, context);
}

float LayeredBxDF::DensityOf(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    LambertianBase base;
    if (usesClosedForms_ && FindLambertianBase(stack_, wo, wi, &base))
        return LambertianBasePdf(base, wo, wi, options_.maxVertices);
    if (SamplesLobes(wo)) return LobeSampler(stack_, wo, context, isLobes_).Pdf(wi);
    BxDFNumbers numbers(context, BxDFQuery::Density);
    return options_.pdf->Evaluate(stack_, wo, wi, numbers.Context(), options_.maxVertices);
}

bool LayeredBxDF::FlipDirections(Vec3* wo, Vec3* wi) const {
    if (options_.isTwoSided && wo->z < 0) {
        *wo = -*wo;
        *wi = -*wi;
    }
    return wo->z != 0 && wi->z != 0;
}

bool LayeredBxDF::IsAsked(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (SameHemisphere(wo, wi)) return Any(context.sides, Lobes::Reflection);
    return transmits_ && Any(context.sides, Lobes::Transmission);
}

// ---- Sampling ---------------------------------------------------------------------------------------------

namespace {

/// Light on its way through a stack [Guo et al. 2018, sec. 5.1].
class ExitWalk {
  public:
    ExitWalk(const Stack& stack, Vec3 wo, const BxDFContext& context, int maxVertices)
        : stack_(stack),
          context_(context),
          maxVertices_(maxVertices),
          verticesLeft_(maxVertices),
          at_(stack.OuterTowards(wo)),
          w_(wo) {
        isAskedAbove_ = Any(context.sides, wo.z > 0 ? Lobes::Reflection : Lobes::Transmission);
        isAskedBelow_ = Any(context.sides, wo.z > 0 ? Lobes::Transmission : Lobes::Reflection);
    }

    struct Exit {
        Vec3 wi;
        SampledSpectrum weight;
        float pdf, pdfReverse;
        bool isSpecular;
        int numVertices;
        bool isGlossySurface;  ///< reflected by the rough outer interface, and nothing else
    };

    /// @param u  for the first vertex; the others take theirs from the generator
    std::optional<Exit> Run(BxDFRandom u) {
        for (bool isFirst = true;; isFirst = false) {
            if (verticesLeft_-- == 0) return std::nullopt;
            BxDFContext here = context_;
            here.sides = SidesAllowed();
            here.needsSamplePdf = false;
            const StackInterface& interface = stack_.interfaces[size_t(at_)];
            const std::optional<BxDFSample> sample =
                isFirst ? interface.Sample(w_, u, here) : interface.Sample(w_, here);
            if (!sample || sample->wi.z == 0) return std::nullopt;
            Apply(*sample);
            if (w_.z > 0 ? at_ == 0 : at_ == stack_.Last())
                return Exit{w_,
                            weight_,
                            pdf_,
                            pdfReverse_,
                            isSpecular_,
                            maxVertices_ - verticesLeft_,
                            isFirst && Any(sample->lobe, Lobes::Glossy)};
            if (!SurvivesRoulette() || !CrossSlab()) return std::nullopt;
        }
    }

  private:
    /// Sides of an interface, seen from w: out of the stack only where the caller asks for it.
    Lobes SidesAllowed() const {
        const bool above = at_ > 0 || isAskedAbove_, below = at_ < stack_.Last() || isAskedBelow_;
        const bool same = w_.z > 0 ? above : below, other = w_.z > 0 ? below : above;
        return (same ? Lobes::Reflection : Lobes::None) | (other ? Lobes::Transmission : Lobes::None);
    }

    void Apply(const BxDFSample& sample) {
        weight_ *= sample.weight;
        pdf_ *= sample.pdf;
        pdfReverse_ *= sample.pdfReverse;
        if (context_.mode == TransportMode::Radiance) etaScale_ *= Sqr(sample.eta);
        isSpecular_ &= sample.IsSpecular();
        w_ = sample.wi;
    }

    /// Flies and scatters along w until the next interface; then w points back to where the light came from.
    bool CrossSlab() {
        const int k = w_.z < 0 ? at_ : at_ - 1;
        const Slab& slab = stack_.slabs[size_t(k)];
        float x = w_.z < 0 ? 0.f : 1.f;
        for (;;) {
            const Flight flight = slab.SampleFlight(x, w_, weight_, *context_.rng);
            weight_ *= flight.crossing.transmittance / flight.pdf;
            if (!flight.scatters) break;
            if (verticesLeft_-- == 0) return false;
            const SlabSample sample = slab.SampleScatter(-w_, weight_, *context_.rng);
            weight_ *= sample.weight / Slab::AbsCos(w_);
            isSpecular_ = false;
            w_ = sample.wi;
            x = flight.x;
            if (w_.z == 0 || !SurvivesRoulette()) return false;
        }
        at_ = w_.z < 0 ? k + 1 : k;
        w_ = -w_;
        return true;
    }

    bool SurvivesRoulette() {
        constexpr float kSafety = 4;  // so that weights stay below what one interface can do
        const float survival = std::min(1.f, kSafety * weight_.MaxComponent() * etaScale_);
        if (!(context_.rng->Uniform() < survival)) return false;
        weight_ /= survival;
        return true;
    }

    const Stack& stack_;
    const BxDFContext& context_;
    int maxVertices_, verticesLeft_;
    int at_;  ///< the interface
    Vec3 w_;  ///< where the light came from
    bool isAskedAbove_, isAskedBelow_;
    SampledSpectrum weight_{1};
    float pdf_ = 1, pdfReverse_ = 1, etaScale_ = 1;
    bool isSpecular_ = true;
};

}  // namespace

bool LayeredBxDF::SamplesLobes(Vec3 wo) const {
    if (stack_.Last() == 0 || options_.maxVertices < 2) return false;
    return isLobes_ || (prefersLobes_ && LobeSampler::FindsAllLight(stack_, wo));
}

std::optional<BxDFSample> LayeredBxDF::SampleLobes(Vec3 wo, const BxDFRandom& u,
                                                   const BxDFContext& context) const {
    const LobeSampler sampler(stack_, wo, context, isLobes_);
    const std::optional<LobeSampler::Drawn> drawn = sampler.Sample(u);
    if (!drawn || !IsAsked(wo, drawn->wi, context)) return std::nullopt;
    const bool isReflected = SameHemisphere(wo, drawn->wi);
    BxDFSample sample;
    sample.wi = drawn->wi;
    sample.pdf = drawn->pdf;
    sample.lobe = (isReflected ? Lobes::Reflection : Lobes::Transmission) |
                  (drawn->isSpecular ? Lobes::Specular : roughLobe_);
    sample.eta = isReflected ? 1 : sampler.Lobes().Eta();
    if (drawn->isSpecular) {
        // Radiance takes the factor of refraction, and a beam's solid angle times its cosine shrinks by
        // eta^2.
        const float scale = context.mode == TransportMode::Radiance ? 1 / Sqr(sample.eta) : 1.f;
        sample.weight = drawn->energy * (scale / drawn->pdf);
        sample.numVertices = isLobes_ ? 0 : 1;  // see LobeSampler::FindsAllLight()
        sample.pdfReverse = drawn->pdf * std::abs(wo.z / (Sqr(sample.eta) * drawn->wi.z));
        return sample;
    }
    // Else the weight is one of many, and records of known density know that of the way back.
    sample.pdfExact = isLobes_;
    BxDFContext value = context;
    value.needsPdf = false;
    sample.weight = Evaluate(wo, drawn->wi, value).f * (std::abs(drawn->wi.z) / drawn->pdf);
    return sample;
}

std::optional<BxDFSample> LayeredBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                              const BxDFContext& context) const {
    if (wo.z == 0) return std::nullopt;
    const bool hasOwnFrame = options_.isTwoSided && wo.z < 0;
    if (hasOwnFrame) wo = -wo;
    BxDFNumbers numbers(context, BxDFQuery::Sample);
    LambertianBase base;
    if (usesClosedForms_ && FindLambertianBase(stack_, wo, wo, &base)) {
        if (!Any(context.sides, Lobes::Reflection)) return std::nullopt;
        std::optional<BxDFSample> drawn =
            SampleLambertianBaseDirection(base, wo, u, numbers.Context(), options_.maxVertices);
        if (drawn && hasOwnFrame) drawn->wi = -drawn->wi;
        if (drawn && drawn->IsSpecular()) drawn->numVertices = 1;
        return drawn;
    }
    if (SamplesLobes(wo)) {
        std::optional<BxDFSample> drawn = SampleLobes(wo, u, numbers.Context());
        if (drawn && hasOwnFrame) drawn->wi = -drawn->wi;
        return drawn;
    }
    const std::optional<ExitWalk::Exit> exit =
        ExitWalk(stack_, wo, numbers.Context(), options_.maxVertices).Run(u);
    if (!exit) return std::nullopt;

    const bool isReflected = SameHemisphere(wo, exit->wi);
    BxDFSample sample;
    sample.wi = hasOwnFrame ? -exit->wi : exit->wi;
    sample.weight = exit->weight;
    sample.lobe =
        (isReflected ? Lobes::Reflection : Lobes::Transmission) | (exit->isSpecular        ? Lobes::Specular
                                                                   : exit->isGlossySurface ? Lobes::Glossy
                                                                                           : roughLobe_);
    sample.eta = isReflected ? 1 : wo.z > 0 ? stack_.eta : 1 / stack_.eta;
    // The probability of a path of specular events is known; the density of any other path is one of many.
    sample.pdf = exit->isSpecular ? exit->pdf : 0;
    sample.pdfReverse = exit->isSpecular ? exit->pdfReverse : 0;
    sample.pdfExact = exit->isSpecular;
    sample.numVertices = exit->numVertices;
    return sample;
}

void LayeredBxDF::Regularize() {
    for (size_t i = 0; i < bxdfs_.size(); ++i) {
        bxdfs_[i]->Regularize();
        interfaces_[i].Refresh();
    }
    Classify();
}

static_assert(std::is_trivially_destructible_v<LayeredBxDF>);

}  // namespace lacquer::layered
