#include "layered/chains/half_vectors/one_sample.h"

#include <limits>

namespace lacquer::layered {
namespace {

/// By how much facets spread light. A slope turns a reflection by twice its angle and a refraction by less
/// than 1 - 1/eta of it; the factor between was measured, and is larger than half because of wide tails.
float SquaredWidth(const ChainEvent& event) {
    constexpr float kPerIndex = 0.7f;
    return event.surface.alphaX * event.surface.alphaY *
           (event.transmits ? Sqr(kPerIndex * (event.eta - 1) / std::max(event.eta, 1.f)) : 1.f);
}

/// Only the side that the chain takes there.
BxDFContext ContextAt(const ChainEvent& event, TransportMode mode, Rng* rng) {
    return {mode, event.transmits ? Lobes::Transmission : Lobes::Reflection, rng};
}

/// Both ends' walks up to the meeting, as they go.
struct Walks {
    ChainDirections inner;
    SampledSpectrum value{1};
    /// As in ChainTerms.
    std::array<float, Chain::kMaxEvents> forward{}, backward{};
};

/// Follows the light through an event.
bool StepForward(const Chain& chain, int k, const BxDFContext& context, Walks& walks) {
    const ChainEvent& event = chain.events[size_t(k)];
    const Vec3 from = k == 0 ? chain.wi : -walks.inner[size_t(k - 1)];
    const auto sample = event.interface->Sample(from, ContextAt(event, !context.mode, context.rng));
    if (!sample || !(sample->pdf > 0)) return false;
    walks.inner[size_t(k)] = sample->wi;
    walks.value *= sample->weight;
    walks.forward[size_t(k)] = sample->pdf;
    walks.backward[size_t(k)] = sample->pdfReverse;
    return true;
}

/// Goes through an event towards the light.
bool StepBackward(const Chain& chain, int k, const BxDFContext& context, Walks& walks) {
    const ChainEvent& event = chain.events[size_t(k)];
    const Vec3 to = k == chain.NumInner() ? chain.wo : walks.inner[size_t(k)];
    const auto sample = event.interface->Sample(to, ContextAt(event, context.mode, context.rng));
    if (!sample || !(sample->pdf > 0)) return false;
    walks.inner[size_t(k - 1)] = -sample->wi;
    walks.value *= sample->weight;
    walks.backward[size_t(k)] = sample->pdf;
    walks.forward[size_t(k)] = sample->pdfReverse;
    return true;
}

/// False if a walk ends too early.
bool WalkToMeeting(const Chain& chain, int meeting, const BxDFContext& context, Walks& walks) {
    for (int k = 0; k < meeting; ++k)
        if (!StepForward(chain, k, context, walks)) return false;
    for (int k = chain.NumInner(); k > meeting; --k)
        if (!StepBackward(chain, k, context, walks)) return false;
    return true;
}

/// Value and densities of an event between the directions that light takes.
BxDFValue EvaluateEvent(const Chain& chain, int k, const ChainDirections& inner, TransportMode mode) {
    const ChainEvent& event = chain.events[size_t(k)];
    const Vec3 from = k == 0 ? chain.wi : -inner[size_t(k - 1)];
    const Vec3 to = k == chain.NumInner() ? chain.wo : inner[size_t(k)];
    return event.interface->Evaluate(to, from, ContextAt(event, mode, nullptr));
}

}  // namespace

ChainTerms EvaluateChain(const Chain& chain, const ChainDirections& inner, TransportMode mode) {
    ChainTerms terms;
    terms.value = SampledSpectrum(1);
    for (int k = 0; k < chain.numEvents; ++k) {
        const bool isLast = k == chain.NumInner();
        if (!isLast && !(inner[size_t(k)].z * chain.signs[size_t(k)] > 0)) {
            terms.value = SampledSpectrum(0);
            return terms;
        }
        const BxDFValue event = EvaluateEvent(chain, k, inner, mode);
        terms.value *= event.f;
        terms.forward[size_t(k)] = event.pdfReverse;
        terms.backward[size_t(k)] = event.pdf;
        if (!terms.value) return terms;
        if (!isLast)
            terms.value *= chain.slabs[size_t(k)]->Cross(inner[size_t(k)], 1).transmittance *
                           std::abs(inner[size_t(k)].z);
    }
    return terms;
}

OneSample::OneSample(const Chain& chain, float smallestShare) {
    float sum = 0;
    for (int k = 0; k < chain.numEvents; ++k)
        sum += shares_[size_t(k)] = SquaredWidth(chain.events[size_t(k)]);
    const float over = (1 - float(chain.numEvents) * smallestShare) / sum;
    for (int k = 0; k < chain.numEvents; ++k) shares_[size_t(k)] = smallestShare + over * shares_[size_t(k)];
}

bool DrawForward(const Chain& chain, const BxDFContext& context, ChainDirections* inner) {
    Walks walks;
    if (!StepForward(chain, 0, context, walks)) return false;
    (*inner)[0] = walks.inner[0];
    return true;
}

bool DrawBackward(const Chain& chain, const BxDFContext& context, ChainDirections* inner) {
    Walks walks;
    const int last = chain.NumInner();
    if (!StepBackward(chain, last, context, walks)) return false;
    (*inner)[size_t(last - 1)] = walks.inner[size_t(last - 1)];
    return true;
}

int OneSample::DrawMeeting(const Chain& chain, float u) const {
    for (int k = 0; k < chain.NumInner(); ++k) {
        if (u < shares_[size_t(k)]) return k;
        u -= shares_[size_t(k)];
    }
    return chain.NumInner();
}

bool OneSample::Draw(const Chain& chain, const BxDFContext& context, ChainDirections* inner) const {
    Walks walks;
    if (!WalkToMeeting(chain, DrawMeeting(chain, context.rng->Uniform()), context, walks)) return false;
    *inner = walks.inner;
    return true;
}

float OneSample::Pdf(const Chain& chain, const ChainTerms& terms) const {
    float sum = 0;
    for (int meeting = 0; meeting < chain.numEvents; ++meeting) {
        float product = shares_[size_t(meeting)];
        for (int k = 0; k < meeting; ++k) product *= terms.forward[size_t(k)];
        for (int k = meeting + 1; k < chain.numEvents; ++k) product *= terms.backward[size_t(k)];
        sum += product;
    }
    return sum;
}

SampledSpectrum OneSample::Estimate(const Chain& chain, const BxDFContext& context) const {
    // Walk, and evaluate the meeting.
    const int meeting = DrawMeeting(chain, context.rng->Uniform());
    Walks walks;
    if (!WalkToMeeting(chain, meeting, context, walks)) return SampledSpectrum(0);
    const BxDFValue met = EvaluateEvent(chain, meeting, walks.inner, context.mode);
    if (!met.f) return SampledSpectrum(0);
    walks.forward[size_t(meeting)] = met.pdfReverse;
    walks.backward[size_t(meeting)] = met.pdf;
    walks.value *= met.f;
    for (int k = 0; k < chain.NumInner(); ++k)
        walks.value *= chain.slabs[size_t(k)]->Cross(walks.inner[size_t(k)], 1).transmittance;

    // The density of all meetings over that of this one, whose walks the weights are divided by already.
    // Meetings that are neighbours differ in who draws the direction between them.
    constexpr float kMax = std::numeric_limits<float>::max();
    float sum = shares_[size_t(meeting)], ratio = 1;
    for (int k = meeting; k < chain.NumInner(); ++k) {
        ratio = std::min(ratio * walks.forward[size_t(k)] / walks.backward[size_t(k + 1)], kMax);
        sum += shares_[size_t(k + 1)] * ratio;
    }
    ratio = 1;
    for (int k = meeting; k > 0; --k) {
        ratio = std::min(ratio * walks.backward[size_t(k)] / walks.forward[size_t(k - 1)], kMax);
        sum += shares_[size_t(k - 1)] * ratio;
    }
    return walks.value * (1 / sum);
}

}  // namespace lacquer::layered
