#include "layered/paths/half_vectors/one_sample.h"

#include <limits>
#include <optional>

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

/// What light does at an event, drawn from the side that it comes from.
std::optional<BxDFSample> SampleEventForward(const InterfacePath& path, int k, const BxDFContext& context,
                                             const InnerDirections& inner) {
    const PathEvent& event = path.events[size_t(k)];
    const Vec3 from = k == 0 ? path.wi : -inner[size_t(k - 1)];
    auto sample = event.interface->Sample(from, ContextAt(event, !context.mode, context.rng));
    if (sample && !(sample->pdf > 0)) sample.reset();
    return sample;
}
/// The same from the side that it goes to.
std::optional<BxDFSample> SampleEventBackward(const InterfacePath& path, int k, const BxDFContext& context,
                                              const InnerDirections& inner) {
    const PathEvent& event = path.events[size_t(k)];
    const Vec3 to = k == path.NumInner() ? path.wo : inner[size_t(k)];
    auto sample = event.interface->Sample(to, ContextAt(event, context.mode, context.rng));
    if (sample && !(sample->pdf > 0)) sample.reset();
    return sample;
}

/// Follows the light through an event.
bool StepForward(const InterfacePath& path, int k, const BxDFContext& context, Walks& walks) {
    const auto sample = SampleEventForward(path, k, context, walks.inner);
    if (!sample) return false;
    walks.inner[size_t(k)] = sample->wi;
    walks.value *= sample->weight;
    walks.forward[size_t(k)] = sample->pdf;
    walks.backward[size_t(k)] = sample->pdfReverse;
    return true;
}

/// Goes through an event towards the light.
bool StepBackward(const InterfacePath& path, int k, const BxDFContext& context, Walks& walks) {
    const auto sample = SampleEventBackward(path, k, context, walks.inner);
    if (!sample) return false;
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

bool SampleForward(const InterfacePath& path, int k, const BxDFContext& context, InnerDirections* inner) {
    const auto sample = SampleEventForward(path, k, context, *inner);
    if (sample) (*inner)[size_t(k)] = sample->wi;
    return sample.has_value();
}

bool SampleBackward(const InterfacePath& path, int k, const BxDFContext& context, InnerDirections* inner) {
    const auto sample = SampleEventBackward(path, k, context, *inner);
    if (sample) (*inner)[size_t(k - 1)] = -sample->wi;
    return sample.has_value();
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

namespace {

using Shares = std::array<float, InterfacePath::kMaxEvents>;

/// Joins two walks at an event that both have reached: value over the sum of the densities of all
/// connections, times the shares of these.
SampledSpectrum Connect(const InterfacePath& path, int connection, Walks& walks, const Shares& shares,
                        TransportMode mode) {
    const BxDFValue met = EvaluateEvent(path, connection, walks.inner, mode);
    if (!met.f) return SampledSpectrum(0);
    walks.forward[size_t(connection)] = met.pdfReverse;
    walks.backward[size_t(connection)] = met.pdf;
    walks.value *= met.f;
    for (int k = 0; k < path.NumInner(); ++k)
        walks.value *= path.slabs[size_t(k)]->Cross(walks.inner[size_t(k)], 1).transmittance;

    // The density of all connections over that of this one, whose walks the weights are divided by already.
    // Connections that are neighbours differ in who draws the direction between them.
    constexpr float kMax = std::numeric_limits<float>::max();
    float sum = shares[size_t(connection)], ratio = 1;
    for (int k = connection; k < path.NumInner(); ++k) {
        ratio = std::min(ratio * walks.forward[size_t(k)] / walks.backward[size_t(k + 1)], kMax);
        sum += shares[size_t(k + 1)] * ratio;
    }
    ratio = 1;
    for (int k = connection; k > 0; --k) {
        ratio = std::min(ratio * walks.backward[size_t(k)] / walks.forward[size_t(k - 1)], kMax);
        sum += shares[size_t(k - 1)] * ratio;
    }
    return walks.value * (1 / sum);
}

}  // namespace

SampledSpectrum OneSample::Estimate(const InterfacePath& path, const BxDFContext& context) const {
    const int connection = SampleConnectionEvent(path, context.rng->Uniform());
    Walks walks;
    if (!WalkToConnection(path, connection, context, walks)) return SampledSpectrum(0);
    return Connect(path, connection, walks, shares_, context.mode);
}

SampledSpectrum EstimateByAllConnections(const InterfacePath& path, const BxDFContext& context) {
    // Both walks, as far as they come. The values are those of the walks up to each event.
    const int last = path.NumInner();
    Walks light, camera;
    std::array<SampledSpectrum, InterfacePath::kMaxEvents> fromLight, fromCamera;
    int lightEnd = 0, cameraEnd = last;
    fromLight[0] = fromCamera[size_t(last)] = SampledSpectrum(1);
    while (lightEnd < last && StepForward(path, lightEnd, context, light))
        fromLight[size_t(++lightEnd)] = light.value;
    while (cameraEnd > 0 && StepBackward(path, cameraEnd, context, camera))
        fromCamera[size_t(--cameraEnd)] = camera.value;

    // Join them wherever both are.
    static constexpr Shares kAll = {1, 1, 1, 1, 1, 1, 1};
    SampledSpectrum sum(0);
    for (int connection = cameraEnd; connection <= lightEnd; ++connection) {
        Walks joined = camera;
        for (int k = 0; k < connection; ++k) {
            joined.inner[size_t(k)] = light.inner[size_t(k)];
            joined.forward[size_t(k)] = light.forward[size_t(k)];
            joined.backward[size_t(k)] = light.backward[size_t(k)];
        }
        joined.value = fromLight[size_t(connection)] * fromCamera[size_t(connection)];
        sum += Connect(path, connection, joined, kAll, context.mode);
    }
    return sum;
}

}  // namespace lacquer::layered
