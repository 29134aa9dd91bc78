#include "layered/paths/products/multiple_product.h"

#include <cmath>

#include "layered/paths/half_vectors/one_sample.h"
#include "layered/paths/products/pair_walk.h"

namespace lacquer::layered {
namespace {

// ---- Lobes as steps ---------------------------------------------------------------------------------------

bool IsDefinite(const Symmetric2& m) { return m.xx > 0 && m.xx * m.yy > m.xy * m.xy; }

using gaussfit::GaussianMixture;
using gaussfit::GaussianMixtureOf;

/// A lobe near one direction: the slope behind the event is `mean` + `turn` * (change of the slope before it)
/// + noise of the lobe's precision.
struct Step {
    Slope mean;
    Matrix2 turn;
    Symmetric2 precision;
};
/// One for each part of a lobe.
template <int kParts>
struct Steps {
    std::array<Step, kParts> parts;
    std::array<float, kParts> weights;
    int count = 0;
    int NumParts() const { return kParts == 1 ? 1 : count; }
};

/// True if the side of sign `side` is the denser one of a refraction.
bool LeavesDenseSide(const PathEvent& event, float side) {
    return event.transmits && IsDenseSide(event.surface, {0, 0, side});
}
/// Index behind a refraction over the one before it.
float IndexBehind(const PathEvent& event, float side) {
    return side > 0 ? event.surface.eta : 1 / event.surface.eta;
}

/// How the mean of a part changes with the slope `a` before the event: it turns with the azimuth, and with
/// the length it changes as the mirror's law or Snell's law say, times the table's own deviation from them.
Matrix2 TurnOf(const PathEvent& event, Slope a, float side, Slope mean) {
    constexpr float kSmallest = 1e-8f;
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
    if (t > kSmallest) across = Dot(mean, a) / t;
    const float excess = t > kSmallest ? across * (alongOverAcross - 1) / t : 0;
    const float mixed = excess * a.x * a.y;
    return {across + excess * a.x * a.x, mixed, mixed, across + excess * a.y * a.y};
}

/// The lobe of an event for light of slope `a` on the side of sign `side`, which is not the denser one of a
/// refraction.
template <int kParts>
bool FindSteps(const PathEvent& event, Slope a, float side, Steps<kParts>* steps) {
    GaussianMixture lobe;
    if (!FindLobeOf(event.surface, event.transmits, DirectionOf(a, side), &lobe) || lobe.count > kParts)
        return false;
    steps->count = lobe.count;
    for (size_t k = 0; k < size_t(steps->NumParts()); ++k) {
        const Gaussian2& part = lobe.parts[k];
        steps->parts[k] = {part.mean, TurnOf(event, a, side, part.mean), part.precision};
        steps->weights[k] = lobe.weights[k];
    }
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

/// The Gaussian over the direction behind an event, given the one over the direction before it, by a step
/// that starts there...
Gaussian2 PassForward(const Step& step, const Symmetric2& covariance) {
    const Symmetric2 sum = step.turn.PushForward(covariance) + step.precision.Inverse();
    return {step.mean, sum.Inverse()};
}
/// ... or by a step the other way. @param at  the slope behind the event that it starts from
Gaussian2 PassBackward(const Step& step, const Gaussian2& before, const Symmetric2& covariance, Slope at) {
    const Symmetric2 sum = covariance + step.precision.Inverse();
    return {at + step.turn.Inverse() * (before.mean - step.mean), step.turn.PullBack(sum.Inverse())};
}

/// A message behind an event, given the one before it: a part for each part of both.
/// @param side  sign of z of the direction before the event, away from it
template <int kParts>
bool Pass(const PathEvent& event, const GaussianMixtureOf<kParts>& before, float side,
          GaussianMixtureOf<kParts * kParts>* behind) {
    // Lobes out of the denser side fit badly. The step the other way is undone instead.
    const bool isBackward = LeavesDenseSide(event, side);
    float sum = 0;
    behind->count = 0;
    for (size_t i = 0; i < size_t(before.NumParts()); ++i) {
        const Gaussian2& part = before.parts[i];
        if (!IsFarFromTotalReflection(event, part, side)) return false;
        const Symmetric2 covariance = part.precision.Inverse();
        const Slope at = isBackward ? RefractedOut(part.mean, IndexBehind(event, side)) : part.mean;
        Steps<kParts> steps;
        if (!FindSteps(event, at, isBackward ? -side : side, &steps)) return false;
        for (size_t k = 0; k < size_t(steps.NumParts()); ++k) {
            const Step& step = steps.parts[k];
            const size_t next = size_t(behind->count++);
            behind->parts[next] =
                isBackward ? PassBackward(step, part, covariance, at) : PassForward(step, covariance);
            if (!IsDefinite(behind->parts[next].precision)) return false;
            behind->weights[next] = before.weights[i] * steps.weights[k];
            if (kParts > 1 && isBackward) behind->weights[next] /= std::abs(step.turn.Determinant());
            sum += behind->weights[next];
        }
    }
    if constexpr (kParts > 1)
        for (size_t k = 0; k < size_t(behind->count); ++k) behind->weights[k] /= sum;
    return true;
}

/// As many parts of a lobe as there is room for.
template <int kParts>
GaussianMixtureOf<kParts> FirstParts(const GaussianMixture& lobe) {
    if constexpr (kParts == 1)
        return GaussianMixtureOf<1>(lobe.parts[0]);
    else
        return lobe;
}
/// The lobe of an outer event.
template <int kParts>
bool FindEnd(const PathEvent& event, Vec3 w, GaussianMixtureOf<kParts>* message) {
    GaussianMixture lobe;
    if (!event.IsIsotropic() || IsDenseSide(event.surface, w) || !FindLobeOf(event.surface, true, w, &lobe) ||
        lobe.count > kParts)
        return false;
    *message = FirstParts<kParts>(lobe);
    return true;
}

/// The lobe of an inner event seen from w. Beyond the tables a wide one: the message knows where light goes.
template <int kParts>
GaussianMixtureOf<kParts> LobeSeenFrom(const PathEvent& event, Vec3 w) {
    GaussianMixture lobe;
    if (!FindLobeOf(event.surface, event.transmits, w, &lobe)) return GaussianMixtureOf<kParts>(Gaussian2{});
    return FirstParts<kParts>(lobe);
}
/// Of the narrowest part.
template <int kParts>
float LargestVolume(const GaussianMixtureOf<kParts>& lobe) {
    float largest = 0;
    for (size_t k = 0; k < size_t(lobe.NumParts()); ++k)
        largest = std::max(largest, lobe.parts[k].Factorize().Volume());
    return largest;
}

/// Squared alpha of the rougher one of a path's ends.
float RougherEnd2(const InterfacePath& path) {
    return Sqr(std::max(path.events[0].surface.alphaX, path.events[size_t(path.NumInner())].surface.alphaX));
}

/// Rough lobes fall off more slowly than Gaussians on the side of the horizon: so a part of the draws comes
/// from one twice as wide. Measured: without it some weights are above 1000; larger shares cost more noise
/// than they save.
float WideShareOf(const InterfacePath& path) {
    constexpr float kPerSquaredAlpha = 0.06f, kMinOfLong = 0.001f;
    const float share = kPerSquaredAlpha * RougherEnd2(path);
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

/// What a direction is drawn from: mixtures have wide parts of their own.
WidenedGaussian SamplerOf(const GaussianMixtureOf<1>& g, float wideShare) {
    return WidenedGaussian(g.parts[0], wideShare);
}
template <int kParts>
class MixtureSampler {
  public:
    explicit MixtureSampler(const GaussianMixtureOf<kParts>& mixture) : mixture_(mixture) {}
    float Sample(Point2 u, Slope* slope) const {
        *slope = mixture_.Sample(u);
        return mixture_.Pdf(*slope);
    }
    float Pdf(Slope slope) const { return mixture_.Pdf(slope); }

  private:
    const GaussianMixtureOf<kParts>& mixture_;
};
template <int kParts>
MixtureSampler<kParts> SamplerOf(const GaussianMixtureOf<kParts>& mixture, float /*wideShare*/) {
    return MixtureSampler<kParts>(mixture);
}

/// Share of the paths that walks draw, by whatever facets are visible: rough lobes are no Gaussians in their
/// tails, and directions off the lobe lead there. Longer paths have none: products of so many densities leave
/// the range of a float.
/// @param distance2  by how many standard deviations the directions are off the lobe, squared
float WalkShareOf(const InterfacePath& path, float distance2) {
    constexpr float kMin = 1e-4f, kFarIfRough2 = 12, kFar2 = 40, kMax = 0.5f;
    if (path.numEvents > 3) return 0;
    const float alpha2 = RougherEnd2(path);
    const float bend2 = alpha2 * Sqr(distance2 / kFarIfRough2) + Sqr(Sqr(distance2 / kFar2)),
                far = kMax * bend2 / (1 + bend2);
    return std::clamp(0.5f * Sqr(alpha2) + far, kMin, kMax);
}

/// The same where lobes are mixtures: tails longer than those of any Gaussian are then everywhere, and those
/// of an interface that spreads light widely matter most in the middle, between two narrow ones.
float WalkShareOfMixtures(const InterfacePath& path, float distance2) {
    constexpr float kMin = 0.05f, kPerEndAlpha2 = 0.1f, kAtGrazing = 0.4f, kFar2 = 7, kFar = 0.6f,
                    kPerIndex = 0.7f, kMax = 0.9f;
    const PathEvent &light = path.events[0], &camera = path.events[size_t(path.NumInner())];
    float width = 0;
    if (path.numEvents > 2) {
        const PathEvent& middle = path.events[1];
        width = middle.surface.alphaX;
        if (middle.transmits) width *= kPerIndex * std::abs(middle.eta - 1) / std::max(middle.eta, 1.f);
    }
    const float bend2 = Sqr(distance2 / kFar2), far = kFar * bend2 / (1 + bend2);
    return std::min(kMin + kPerEndAlpha2 * RougherEnd2(path) + width + far +
                        kAtGrazing * GrazingOf(light.surface, path.wi, camera.surface, path.wo),
                    kMax);
}

}  // namespace

template <int kParts>
bool MultipleProductOf<kParts>::Set(const InterfacePath& path) {
    path_ = &path;
    if (kParts > 1 && path.numEvents > InterfacePath::kMaxShortestEvents) return false;
    const int last = path.NumInner() - 1;
    for (int k = 1; k <= last; ++k)
        if (!path.events[size_t(k)].IsIsotropic()) return false;
    GaussianMixtureOf<kParts> fromLight, fromCamera;
    if (!FindEnd(path.events[0], path.wi, &fromLight) ||
        !FindEnd(path.events[size_t(last + 1)], path.wo, &fromCamera))
        return false;

    // Messages go from one end to the other, where the first direction is drawn. Measured: with two
    // directions that is best next to the narrower outer lobe, with more next to the wider one.
    const bool lightIsNarrower = LargestVolume(fromLight) > LargestVolume(fromCamera);
    const bool startsAtLight = lightIsNarrower == (last > 1);
    first_ = startsAtLight ? last : 0;
    const GaussianMixtureOf<kParts>&start = startsAtLight ? fromLight : fromCamera,
          &end = startsAtLight ? fromCamera : fromLight;
    if (last == 0) return SetProduct(start, end);
    const int step = startsAtLight ? 1 : -1;
    GaussianMixtureOf<kParts * kParts> message;
    for (int j = last - first_; j != first_; j += step) {
        if (j == last - first_)
            messages_[size_t(j)] = start;
        else if constexpr (kParts == 1)
            messages_[size_t(j)] = message;
        const PathEvent& event = path.events[size_t(startsAtLight ? j + 1 : j)];
        // Away from the event is against the light where messages go along with it.
        const float side = path.signs[size_t(j)] * float(-step);
        if (!Pass(event, messages_[size_t(j)], side, &message)) return false;
    }
    return SetProduct(message, end);
}

template <int kParts>
template <int kOther>
bool MultipleProductOf<kParts>::SetProduct(const GaussianMixtureOf<kOther>& message,
                                           const GaussianMixtureOf<kParts>& end) {
    wideShare_ = WideShareOf(*path_);
    if constexpr (kParts == 1) {
        product_ = Multiply(message, end);
        const Gaussian2 &product = product_.parts[0], &other = end.parts[0];
        const float distance2 =
            Dot(other.mean - product.mean, other.precision * (other.mean - message.parts[0].mean));
        walkShare_ = WalkShareOf(*path_, std::max(distance2, 0.f));
    } else {
        const auto product = Multiply(message, end);
        product_.count = product.count;
        std::copy_n(product.parts.begin(), product.count, product_.parts.begin());
        std::copy_n(product.weights.begin(), product.count, product_.weights.begin());
        walkShare_ = WalkShareOfMixtures(*path_, gaussfit::LeastDistance2(message, end));
    }
    return true;
}

template <int kParts>
void MultipleProductOf<kParts>::SetDirections(Rng* rng, InnerDirections* inner,
                                              InnerDensities* densities) const {
    const auto set = [&](const auto& mixture, int j) {
        const auto sampler = SamplerOf(mixture, wideShare_);
        Vec3& w = (*inner)[size_t(j)];
        float pdf;
        if (rng) {
            Slope slope;
            pdf = sampler.Sample(rng->Uniform2D(), &slope);
            w = DirectionOf(slope, path_->signs[size_t(j)]);
        } else {
            pdf = sampler.Pdf(SlopeOf(w));
        }
        (*densities)[size_t(j)] = pdf * SlopePerSolidAngle(w);
    };
    set(product_, first_);
    // Back along the messages: each direction given the one just set.
    const int last = path_->NumInner() - 1, step = first_ == 0 ? 1 : -1;
    for (int j = first_ + step; j >= 0 && j <= last; j += step) {
        const PathEvent& event = path_->events[size_t(step > 0 ? j : j + 1)];
        const Vec3 seenFrom = (*inner)[size_t(j - step)] * float(-step);
        set(Multiply(messages_[size_t(j)], LobeSeenFrom<kParts>(event, seenFrom)), j);
    }
}

template <int kParts>
SampledSpectrum MultipleProductOf<kParts>::Estimate(TransportMode mode, Rng& rng) const {
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

template class MultipleProductOf<1>;
template class MultipleProductOf<2>;

namespace {

/// Of paths whose lobes are mixtures, against pair products, which need one draw fewer from a mixture: a
/// middle reflection as sharp as the ends, or three refractions.
bool ProductOfMixturesIsWorthwhile(const InterfacePath& path) {
    constexpr float kMaxMiddle = 0.15f;
    if (path.numEvents != InterfacePath::kMaxShortestEvents) return false;
    const PathEvent& middle = path.events[1];
    const float narrower = std::min(path.events[0].surface.alphaX, path.events[2].surface.alphaX);
    return middle.transmits || middle.surface.alphaX <= std::min(kMaxMiddle, narrower);
}

}  // namespace

bool MultipleProductIsWorthwhile(const InterfacePath& path) {
    constexpr int kMaxEventsOfOthers = 5;
    if (HasMixtures(path)) return ProductOfMixturesIsWorthwhile(path);
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
