#include "layered/paths/half_vectors/one_sample.h"

#include <limits>

namespace lacquer::layered {
namespace {

/// By how much facets spread light. A slope turns a reflection by twice its angle and a refraction by less
/// than 1 - 1/eta of it; the factor between was measured, and is larger than half because of wide tails.
float SquaredWidth(const PathEvent& event) {
    constexpr float kPerIndex = 0.7f;
    return event.surface.alphaX * event.surface.alphaY *
           (event.transmits ? Sqr(kPerIndex * (event.eta - 1) / std::max(event.eta, 1.f)) : 1.f);
}

/// Only the side that the path takes there.
BxDFContext ContextAt(const PathEvent& event, TransportMode mode, Rng* rng) {
    return {mode, event.transmits ? Lobes::Transmission : Lobes::Reflection, rng};
}

/// Both ends' walks up to the connection, as they go.
struct Walks {
    InnerDirections inner;
    SampledSpectrum value{1};
    /// As in PathTerms.
    std::array<float, InterfacePath::kMaxEvents> forward{}, backward{};
};

/// Follows the light through an event.
bool StepForward(const InterfacePath& path, int k, const BxDFContext& context, Walks& walks) {
    const PathEvent& event = path.events[size_t(k)];
    const Vec3 from = k == 0 ? path.wi : -walks.inner[size_t(k - 1)];
    const auto sample = event.interface->Sample(from, ContextAt(event, !context.mode, context.rng));
    if (!sample || !(sample->pdf > 0)) return false;
    walks.inner[size_t(k)] = sample->wi;
    walks.value *= sample->weight;
    walks.forward[size_t(k)] = sample->pdf;
    walks.backward[size_t(k)] = sample->pdfReverse;
    return true;
}

/// Goes through an event towards the light.
bool StepBackward(const InterfacePath& path, int k, const BxDFContext& context, Walks& walks) {
    const PathEvent& event = path.events[size_t(k)];
    const Vec3 to = k == path.NumInner() ? path.wo : walks.inner[size_t(k)];
    const auto sample = event.interface->Sample(to, ContextAt(event, context.mode, context.rng));
    if (!sample || !(sample->pdf > 0)) return false;
    walks.inner[size_t(k - 1)] = -sample->wi;
    walks.value *= sample->weight;
    walks.backward[size_t(k)] = sample->pdf;
    walks.forward[size_t(k)] = sample->pdfReverse;
    return true;
}

/// False if a walk ends too early.
bool WalkToConnection(const InterfacePath& path, int connection, const BxDFContext& context, Walks& walks) {
    for (int k = 0; k < connection; ++k)
        if (!StepForward(path, k, context, walks)) return false;
    for (int k = path.NumInner(); k > connection; --k)
        if (!StepBackward(path, k, context, walks)) return false;
    return true;
}

/// Value and densities of an event between the directions that light takes.
BxDFValue EvaluateEvent(const InterfacePath& path, int k, const InnerDirections& inner, TransportMode mode) {
    const PathEvent& event = path.events[size_t(k)];
    const Vec3 from = k == 0 ? path.wi : -inner[size_t(k - 1)];
    const Vec3 to = k == path.NumInner() ? path.wo : inner[size_t(k)];
    return event.interface->Evaluate(to, from, ContextAt(event, mode, nullptr));
}

}  // namespace

PathTerms EvaluatePathTerms(const InterfacePath& path, const InnerDirections& inner, TransportMode mode) {
    PathTerms terms;
    terms.value = SampledSpectrum(1);
    for (int k = 0; k < path.numEvents; ++k) {
        const bool isLast = k == path.NumInner();
        if (!isLast && !(inner[size_t(k)].z * path.signs[size_t(k)] > 0)) {
            terms.value = SampledSpectrum(0);
            return terms;
        }
        const BxDFValue event = EvaluateEvent(path, k, inner, mode);
        terms.value *= event.f;
        terms.forward[size_t(k)] = event.pdfReverse;
        terms.backward[size_t(k)] = event.pdf;
        if (!terms.value) return terms;
        if (!isLast)
            terms.value *= path.slabs[size_t(k)]->Cross(inner[size_t(k)], 1).transmittance *
                           std::abs(inner[size_t(k)].z);
    }
    return terms;
}

OneSample::OneSample(const InterfacePath& path, float smallestShare) {
    float sum = 0;
    for (int k = 0; k < path.numEvents; ++k) sum += shares_[size_t(k)] = SquaredWidth(path.events[size_t(k)]);
    const float over = (1 - float(path.numEvents) * smallestShare) / sum;
    for (int k = 0; k < path.numEvents; ++k) shares_[size_t(k)] = smallestShare + over * shares_[size_t(k)];
}

bool SampleForward(const InterfacePath& path, const BxDFContext& context, InnerDirections* inner) {
    Walks walks;
    if (!StepForward(path, 0, context, walks)) return false;
    (*inner)[0] = walks.inner[0];
    return true;
}

bool SampleBackward(const InterfacePath& path, const BxDFContext& context, InnerDirections* inner) {
    Walks walks;
    const int last = path.NumInner();
    if (!StepBackward(path, last, context, walks)) return false;
    (*inner)[size_t(last - 1)] = walks.inner[size_t(last - 1)];
    return true;
}

int OneSample::SampleConnectionEvent(const InterfacePath& path, float u) const {
    for (int k = 0; k < path.NumInner(); ++k) {
        if (u < shares_[size_t(k)]) return k;
        u -= shares_[size_t(k)];
    }
    return path.NumInner();
}

bool OneSample::Sample(const InterfacePath& path, const BxDFContext& context, InnerDirections* inner) const {
    Walks walks;
    if (!WalkToConnection(path, SampleConnectionEvent(path, context.rng->Uniform()), context, walks))
        return false;
    *inner = walks.inner;
    return true;
}

float OneSample::Pdf(const InterfacePath& path, const PathTerms& terms) const {
    float sum = 0;
    for (int connection = 0; connection < path.numEvents; ++connection) {
        float product = shares_[size_t(connection)];
        for (int k = 0; k < connection; ++k) product *= terms.forward[size_t(k)];
        for (int k = connection + 1; k < path.numEvents; ++k) product *= terms.backward[size_t(k)];
        sum += product;
    }
    return sum;
}

SampledSpectrum OneSample::Estimate(const InterfacePath& path, const BxDFContext& context) const {
    // Walk, and evaluate the connection.
    const int connection = SampleConnectionEvent(path, context.rng->Uniform());
    Walks walks;
    if (!WalkToConnection(path, connection, context, walks)) return SampledSpectrum(0);
    const BxDFValue met = EvaluateEvent(path, connection, walks.inner, context.mode);
    if (!met.f) return SampledSpectrum(0);
    walks.forward[size_t(connection)] = met.pdfReverse;
    walks.backward[size_t(connection)] = met.pdf;
    walks.value *= met.f;
    for (int k = 0; k < path.NumInner(); ++k)
        walks.value *= path.slabs[size_t(k)]->Cross(walks.inner[size_t(k)], 1).transmittance;

    // The density of all connections over that of this one, whose walks the weights are divided by already.
    // Connections that are neighbours differ in who draws the direction between them.
    constexpr float kMax = std::numeric_limits<float>::max();
    float sum = shares_[size_t(connection)], ratio = 1;
    for (int k = connection; k < path.NumInner(); ++k) {
        ratio = std::min(ratio * walks.forward[size_t(k)] / walks.backward[size_t(k + 1)], kMax);
        sum += shares_[size_t(k + 1)] * ratio;
    }
    ratio = 1;
    for (int k = connection; k > 0; --k) {
        ratio = std::min(ratio * walks.backward[size_t(k)] / walks.forward[size_t(k - 1)], kMax);
        sum += shares_[size_t(k - 1)] * ratio;
    }
    return walks.value * (1 / sum);
}

}  // namespace lacquer::layered
