#include "layered/paths/products/multiple_product.h"

#include <cmath>

#include "layered/paths/half_vectors/one_sample.h"
#include "layered/paths/products/pair_walk.h"

namespace lacquer::layered {
namespace {

// ---- Lobes as steps ---------------------------------------------------------------------------------------

bool IsDefinite(const Symmetric2& m) { return m.xx > 0 && m.xx * m.yy > m.xy * m.xy; }

/// A lobe near one direction: the slope behind the event is `mean` + `turn` * (change of the slope before it)
/// + noise of the lobe's precision.
struct Step {
    Slope mean;
    Matrix2 turn;
    Symmetric2 precision;
};

/// True if the side of sign `side` is the denser one of a refraction.
bool LeavesDenseSide(const PathEvent& event, float side) {
    return event.transmits && IsDenseSide(event.surface, {0, 0, side});
}
/// Index behind a refraction over the one before it.
float IndexBehind(const PathEvent& event, float side) {
    return side > 0 ? event.surface.eta : 1 / event.surface.eta;
}

/// The lobe of an event for light of slope `a` on the side of sign `side`, which is not the denser one of a
/// refraction. The mean turns with a's azimuth; how it changes with a's length is what the mirror's law or
/// Snell's law say, times the table's own deviation from them.
bool FindStep(const PathEvent& event, Slope a, float side, Step* step) {
    constexpr float kSmallest = 1e-8f;
    gaussfit::GaussianMixture lobe;
    if (!FindLobeOf(event.surface, event.transmits, DirectionOf(a, side), &lobe) || lobe.count != 1)
        return false;
    step->mean = lobe.parts[0].mean;
    step->precision = lobe.parts[0].precision;
    const float t = Dot(a, a);
    float across = -1, alongOverAcross;
    if (event.transmits) {
        const float eta = IndexBehind(event, side), cos2 = 1 / (1 + t);
        const float cos2Behind = 1 - (1 - cos2) / Sqr(eta);
        across = std::sqrt(cos2 / cos2Behind) / eta;
        alongOverAcross = cos2 / cos2Behind;
    } else {
        // Means of rough reflections stay behind the mirror's: see ReflectionBasis().
        alongOverAcross = 1 / (1 + 1.8f * Sqr(event.surface.alphaX) * t);
    }
    if (t > kSmallest) across = Dot(step->mean, a) / t;
    const float excess = t > kSmallest ? across * (alongOverAcross - 1) / t : 0;
    const float mixed = excess * a.x * a.y;
    step->turn = {across + excess * a.x * a.x, mixed, mixed, across + excess * a.y * a.y};
    return true;
}

// ---- Messages ---------------------------------------------------------------------------------------------

/// Slope behind a smooth refraction out of the denser side; kept from total reflection.
Slope RefractedOut(Slope slope, float indexBehind) {
    constexpr float kLargestSine2 = 0.95f;
    const float t = Dot(slope, slope);
    const float sine2 = std::min(t / ((1 + t) * Sqr(indexBehind)), kLargestSine2);
    return t > 0 ? slope * std::sqrt(sine2 / ((1 - sine2) * t)) : slope;
}

/// False if a part of a Gaussian over the slopes on the denser side of a dielectric lies beyond the critical
/// angle, or close to it. Reflections from there are 25 times as bright, which makes the tails heavy;
/// refractions bend most where they end, which is not linear at all.
bool IsFarFromTotalReflection(const PathEvent& event, const Gaussian2& before, float side) {
    if (event.surface.eta == 0 || !IsDenseSide(event.surface, {0, 0, side})) return true;
    const float deviations = event.transmits ? 3 : 5;
    const float critical = 1 / std::sqrt(1 / Sqr(IndexBehind(event, side)) - 1);
    const Symmetric2 covariance = before.precision.Inverse();
    const float widest = std::sqrt(covariance.Trace());
    return std::sqrt(Dot(before.mean, before.mean)) + deviations * widest < critical;
}

/// The Gaussian over the direction behind an event, given the one over the direction before it.
/// @param side  sign of z of the latter, away from the event
bool Pass(const PathEvent& event, const Gaussian2& before, float side, Gaussian2* behind) {
    if (!IsFarFromTotalReflection(event, before, side)) return false;
    const Symmetric2 covariance = before.precision.Inverse();
    Step step;
    if (!LeavesDenseSide(event, side)) {
        if (!FindStep(event, before.mean, side, &step)) return false;
        const Symmetric2 sum = step.turn.PushForward(covariance) + step.precision.Inverse();
        *behind = {step.mean, sum.Inverse()};
        return IsDefinite(behind->precision);
    }
    // Lobes out of the denser side fit badly. The step the other way is undone instead.
    const Slope at = RefractedOut(before.mean, IndexBehind(event, side));
    if (!FindStep(event, at, -side, &step)) return false;
    const Symmetric2 sum = covariance + step.precision.Inverse();
    *behind = {at + step.turn.Inverse() * (before.mean - step.mean), step.turn.PullBack(sum.Inverse())};
    return IsDefinite(behind->precision);
}

/// The lobe of an outer event.
bool FindEnd(const PathEvent& event, Vec3 w, Gaussian2* message) {
    gaussfit::GaussianMixture lobe;
    if (!event.IsIsotropic() || IsDenseSide(event.surface, w) || !FindLobeOf(event.surface, true, w, &lobe) ||
        lobe.count != 1)
        return false;
    *message = lobe.parts[0];
    return true;
}

/// The lobe of an inner event seen from w. Beyond the tables a wide one: the message knows where light goes.
Gaussian2 LobeSeenFrom(const PathEvent& event, Vec3 w) {
    gaussfit::GaussianMixture lobe;
    if (!FindLobeOf(event.surface, event.transmits, w, &lobe)) return Gaussian2{};
    return lobe.parts[0];
}

/// Rough lobes fall off more slowly than Gaussians on the side of the horizon: so a part of the draws comes
/// from one twice as wide. Measured: without it some weights are above 1000; larger shares cost more noise
/// than they save.
float WideShareOf(const InterfacePath& path) {
    constexpr float kPerSquaredAlpha = 0.06f, kMinOfLong = 0.001f;
    const float first = path.events[0].surface.alphaX,
                last = path.events[size_t(path.NumInner())].surface.alphaX;
    const float share = kPerSquaredAlpha * Sqr(std::max(first, last));
    return path.numEvents > 3 ? std::max(share, kMinOfLong) : share;
}

/// A Gaussian with a share of one twice as wide.
class WidenedGaussian {
  public:
    WidenedGaussian(const Gaussian2& g, float wideShare)
        : factor_(g.Factorize()), mean_(g.mean), wideShare_(wideShare) {}

    /// Draws a slope; gives its density [per unit of slope area].
    float Sample(Point2 u, Slope* slope) const {
        const bool isWide = u.x < wideShare_;
        u.x = isWide ? u.x / wideShare_ : (u.x - wideShare_) / (1 - wideShare_);
        u.x = std::min(u.x, OneMinusEpsilon);
        const StandardNormalSample normal = SampleStandardNormal(u);
        const float width = isWide ? kWidth : 1;
        *slope = mean_ + factor_.FromStandard(width * normal.point);
        return PdfAt(normal.square * Sqr(width));
    }
    float Pdf(Slope slope) const {
        const Slope normal = factor_.ToStandard(slope - mean_);
        return PdfAt(Dot(normal, normal));
    }

  private:
    static constexpr float kWidth = 2;

    /// @param square  of the distance from the mean in standard deviations
    float PdfAt(float square) const {
        return factor_.Volume() * Inv2Pi *
               ((1 - wideShare_) * std::exp(-0.5f * square) +
                wideShare_ / Sqr(kWidth) * std::exp(-0.5f / Sqr(kWidth) * square));
    }

    CholeskyFactor factor_;
    Slope mean_;
    float wideShare_;
};

/// Share of the paths that walks draw, by whatever facets are visible: rough lobes are no Gaussians in their
/// tails, and directions off the lobe lead there. Longer paths have none: products of so many densities leave
/// the range of a float.
/// @param distance2  by how many standard deviations the directions are off the lobe, squared
float WalkShareOf(const InterfacePath& path, float distance2) {
    constexpr float kMin = 1e-4f, kFarIfRough2 = 12, kFar2 = 40, kMax = 0.5f;
    if (path.numEvents > 3) return 0;
    const float alpha2 =
        Sqr(std::max(path.events[0].surface.alphaX, path.events[size_t(path.NumInner())].surface.alphaX));
    const float bend2 = alpha2 * Sqr(distance2 / kFarIfRough2) + Sqr(Sqr(distance2 / kFar2)),
                far = kMax * bend2 / (1 + bend2);
    return std::clamp(0.5f * Sqr(alpha2) + far, kMin, kMax);
}

}  // namespace

bool MultipleProduct::Set(const InterfacePath& path) {
    path_ = &path;
    const int last = path.NumInner() - 1;
    for (int k = 1; k <= last; ++k)
        if (!path.events[size_t(k)].IsIsotropic()) return false;
    Gaussian2 fromLight, fromCamera;
    if (!FindEnd(path.events[0], path.wi, &fromLight) ||
        !FindEnd(path.events[size_t(last + 1)], path.wo, &fromCamera))
        return false;

    // Messages go from one end to the other, where the first direction is drawn. Measured: with two
    // directions that is best next to the narrower outer lobe, with more next to the wider one.
    const bool lightIsNarrower = fromLight.Factorize().Volume() > fromCamera.Factorize().Volume();
    const bool startsAtLight = lightIsNarrower == (last > 1);
    first_ = startsAtLight ? last : 0;
    Gaussian2 message = startsAtLight ? fromLight : fromCamera;
    const int step = startsAtLight ? 1 : -1;
    for (int j = last - first_; j != first_; j += step) {
        messages_[size_t(j)] = message;
        const PathEvent& event = path.events[size_t(startsAtLight ? j + 1 : j)];
        // Away from the event is against the light where messages go along with it.
        const float side = path.signs[size_t(j)] * float(-step);
        if (!Pass(event, messages_[size_t(j)], side, &message)) return false;
    }
    wideShare_ = WideShareOf(path);
    const Gaussian2& end = startsAtLight ? fromCamera : fromLight;
    product_ = Multiply(message, end);
    const float distance2 = Dot(end.mean - product_.mean, end.precision * (end.mean - message.mean));
    walkShare_ = WalkShareOf(path, std::max(distance2, 0.f));
    return true;
}

void MultipleProduct::SetDirections(Rng* rng, InnerDirections* inner, InnerDensities* densities) const {
    const auto set = [&](const Gaussian2& g, int j) {
        const WidenedGaussian gaussian(g, wideShare_);
        Vec3& w = (*inner)[size_t(j)];
        float pdf;
        if (rng) {
            Slope slope;
            pdf = gaussian.Sample(rng->Uniform2D(), &slope);
            w = DirectionOf(slope, path_->signs[size_t(j)]);
        } else {
            pdf = gaussian.Pdf(SlopeOf(w));
        }
        (*densities)[size_t(j)] = pdf * SlopePerSolidAngle(w);
    };
    set(product_, first_);
    // Back along the messages: each direction given the one just set.
    const int last = path_->NumInner() - 1, step = first_ == 0 ? 1 : -1;
    for (int j = first_ + step; j >= 0 && j <= last; j += step) {
        const PathEvent& event = path_->events[size_t(step > 0 ? j : j + 1)];
        const Vec3 seenFrom = (*inner)[size_t(j - step)] * float(-step);
        set(Multiply(messages_[size_t(j)], LobeSeenFrom(event, seenFrom)), j);
    }
}

SampledSpectrum MultipleProduct::Estimate(TransportMode mode, Rng& rng) const {
    constexpr float kSmallestShare = 0.1f;  // of each connection
    InnerDirections inner;
    InnerDensities densities;
    if (walkShare_ == 0) {
        SetDirections(&rng, &inner, &densities);
        return PathContribution(*path_, inner, mode, &densities);
    }
    const OneSample walks(*path_, kSmallestShare);
    const bool isWalk = rng.Uniform() < walkShare_;
    if (isWalk && !walks.Sample(*path_, {mode, Lobes::BothSides, &rng}, &inner)) return SampledSpectrum(0);
    SetDirections(isWalk ? nullptr : &rng, &inner, &densities);
    const PathTerms terms = EvaluatePathTerms(*path_, inner, mode);
    if (!terms.value) return terms.value;
    float pdf = 1 - walkShare_;
    for (int j = 0; j < path_->NumInner(); ++j) pdf *= densities[size_t(j)];
    pdf += walkShare_ * walks.Pdf(*path_, terms);
    return pdf > 0 && pdf < Infinity ? terms.value / pdf : SampledSpectrum(0);
}

bool MultipleProductIsWorthwhile(const InterfacePath& path) {
    constexpr int kMaxEventsOfOthers = 5;
    // Others' lobes are mixtures, which need no look-up to be refused.
    if (path.events[0].surface.model != MicrofacetModel::Beckmann) return false;
    const float roughest = path.numEvents <= 3 ? 0.33f : 0.2f;
    int turns = 0;
    for (int k = 0; k < path.numEvents; ++k) {
        const PathEvent& event = path.events[size_t(k)];
        if (event.transmits) continue;
        ++turns;
        if (!(event.surface.alphaX < roughest)) return false;
    }
    return turns <= 1 || path.numEvents <= kMaxEventsOfOthers;
}

}  // namespace lacquer::layered
