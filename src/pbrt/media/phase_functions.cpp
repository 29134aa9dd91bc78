#include "pbrt/media/phase_functions.h"

#include "pbrt/core/check.h"
#include "pbrt/core/sampling.h"

namespace lacquer {
namespace {

PhaseValue Symmetric(float p) { return {p, p, p}; }

// The end of all Sample(): value and density come from one place.
PhaseSample Record(const PhaseFunction& phase, Vec3 wo, Vec3 wi) {
    const PhaseValue value = phase.Evaluate(wo, wi);
    return {wi, 1, value.pdf, value.pdfReverse};
}

// 1 - cos of the angle between unit vectors, with a small relative error also where it is tiny.
float OneMinusCos(Vec3 a, Vec3 b) { return 0.5f * LengthSquared(a - b); }

// Unit vector at a given angle to the axis, at a random azimuth.
Vec3 AroundAxis(Vec3 axis, float oneMinusCos, float u) {
    const float sine = SafeSqrt(oneMinusCos * (2 - oneMinusCos)), phi = 2 * Pi * u;
    Vec3 x, y;
    CoordinateSystem(axis, &x, &y);
    // Long walks must not let the length drift.
    return Normalize(axis - oneMinusCos * axis + sine * (std::cos(phi) * x + std::sin(phi) * y));
}

}  // namespace

PhaseValue IsotropicPhase::Evaluate(Vec3 /*wo*/, Vec3 /*wi*/) const { return Symmetric(Inv4Pi); }

PhaseSample IsotropicPhase::Sample(Vec3 wo, Rng& rng) const {
    return Record(*this, wo, SampleUniformSphere(rng.Uniform2D()));
}

HenyeyGreensteinPhase::HenyeyGreensteinPhase(float g)
    : absG_(std::min(std::abs(g), kMaxG)), isForward_(!(g < 0)) {
    if (std::isnan(g)) absG_ = 0;
}

PhaseValue HenyeyGreensteinPhase::Evaluate(Vec3 wo, Vec3 wi) const {
    // 1 + g^2 - 2 |g| cos about the axis of the lobe, without cancellation.
    const float d = Sqr(1 - absG_) + 2 * absG_ * OneMinusCos(Axis(wo), wi);
    return Symmetric(Inv4Pi * (1 - absG_) * (1 + absG_) / (d * std::sqrt(d)));
}

PhaseSample HenyeyGreensteinPhase::Sample(Vec3 wo, Rng& rng) const {
    // The textbook inverse of the distribution function has 1/g; solved for 1 - cos it has not, and holds at
    // g = 0 as it stands.
    const Point2 u = rng.Uniform2D();
    const float a = absG_, b = 1 - a + 2 * a * (1 - u.x);
    const float oneMinusCos = 2 * Sqr((1 - a) / b) * u.x * (1 + a - a * u.x);
    return Record(*this, wo, AroundAxis(Axis(wo), std::min(oneMinusCos, 2.f), u.y));
}

VonMisesFisherPhase::VonMisesFisherPhase(float kappa)
    : kappa_(kappa > 0 ? std::min(kappa, kMaxKappa) : 0.f),
      tail_(std::expm1(-2 * kappa_)),
      peak_(tail_ < 0 ? -Inv2Pi * kappa_ / tail_ : Inv4Pi) {}

PhaseValue VonMisesFisherPhase::Evaluate(Vec3 wo, Vec3 wi) const {
    // Nothing is below exp(-80); denormal numbers would only be slow.
    return Symmetric(peak_ * std::exp(-std::min(kappa_ * OneMinusCos(-wo, wi), 80.f)));
}

PhaseSample VonMisesFisherPhase::Sample(Vec3 wo, Rng& rng) const {
    // [Jakob 2012], with the roles of u and 1 - u exchanged: no digit is lost at either end of kappa.
    const Point2 u = rng.Uniform2D();
    const float oneMinusCos = tail_ < 0 ? -std::log1p(u.x * tail_) / kappa_ : 2 * u.x;
    return Record(*this, wo, AroundAxis(-wo, std::min(oneMinusCos, 2.f), u.y));
}

PhaseTable::PhaseTable(std::span<const float> samples) : values(samples.begin(), samples.end()) {
    LACQUER_CHECK(samples.size() >= 2);
    for (float& value : values)
        if (!(value > 0) || !std::isfinite(value)) value = 0;

    // Trapezia are exact for what is linear between samples.
    const size_t last = values.size() - 1;
    double area = 0;
    std::vector<double> sums{0};
    for (size_t i = 0; i < last; ++i) {
        area += (double(values[i]) + double(values[i + 1])) / double(last);
        sums.push_back(area);
    }
    if (area == 0) {
        std::fill(values.begin(), values.end(), Inv4Pi);
        for (size_t i = 0; i <= last; ++i) cdf.push_back(float(i) / float(last));
        return;
    }
    for (float& value : values) value = float(double(value) / (2 * M_PI * area));
    for (const double sum : sums) cdf.push_back(float(sum / area));
}

TabulatedPhase::TabulatedPhase(std::span<const float> values, std::span<const float> cdf)
    : values_(values), cdf_(cdf) {
    LACQUER_CHECK(values.size() >= 2 && values.size() == cdf.size());
}

PhaseValue TabulatedPhase::Evaluate(Vec3 wo, Vec3 wi) const {
    const float last = float(values_.size() - 1);
    const float x = std::clamp(0.5f * (1 - Dot(wo, wi)) * last, 0.f, last);
    const size_t i = std::min(size_t(x), values_.size() - 2);
    return Symmetric(Lerp(x - float(i), values_[i], values_[i + 1]));
}

PhaseSample TabulatedPhase::Sample(Vec3 wo, Rng& rng) const {
    // Find the segment, then the place in it.
    const Point2 u = rng.Uniform2D();
    const int n = int(cdf_.size());
    const size_t i = size_t(FindInterval(n, [&](int k) { return cdf_[size_t(k)] <= u.x; }));
    const float left = (u.x - cdf_[i]) / (cdf_[i + 1] - cdf_[i]);
    const float x =
        (float(i) + SampleLinear(std::min(left, OneMinusEpsilon), values_[i], values_[i + 1])) / float(n - 1);
    return Record(*this, wo, AroundAxis(-wo, std::clamp(2 - 2 * x, 0.f, 2.f), u.y));
}

MixturePhase::MixturePhase(std::span<const PhaseFunction* const> parts, std::span<const float> weights)
    : parts_(parts), weights_(weights) {
    LACQUER_CHECK(!parts.empty() && parts.size() == weights.size());
    float sum = 0;
    for (size_t i = 0; i < parts.size(); ++i) {
        sum += std::max(0.f, weights[i]);
        isDirectional_ |= parts[i]->HasDirectionalExtinction();
    }
    if (sum > 0) scale_ = 1 / sum;
}

float MixturePhase::Share(size_t i) const {
    return scale_ > 0 ? std::max(0.f, weights_[i]) * scale_ : 1 / float(parts_.size());
}

float MixturePhase::PartExtinction(size_t i, Vec3 w) const {
    return isDirectional_ ? Share(i) * parts_[i]->Extinction(w) : Share(i);
}

float MixturePhase::Extinction(Vec3 w) const {
    if (!isDirectional_) return 1;
    float sum = 0;
    for (size_t i = 0; i < parts_.size(); ++i) sum += PartExtinction(i, w);
    return sum;
}

PhaseValue MixturePhase::Evaluate(Vec3 wo, Vec3 wi) const {
    float p = 0, pdf = 0, pdfReverse = 0, total_o = 0, total_i = 0;
    for (size_t k = 0; k < parts_.size(); ++k) {
        const PhaseValue value = parts_[k]->Evaluate(wo, wi);
        const float extinction_o = PartExtinction(k, wo);
        const float extinction_i = isDirectional_ ? PartExtinction(k, wi) : extinction_o;
        p += extinction_o * value.p;
        pdf += extinction_o * value.pdf;
        pdfReverse += extinction_i * value.pdfReverse;
        total_o += extinction_o;
        total_i += extinction_i;
    }
    return {p / total_o, pdf / total_o, pdfReverse / total_i};
}

PhaseSample MixturePhase::Sample(Vec3 wo, Rng& rng) const {
    // Choose the kind of particle that is hit. A part without a share is never the last one standing.
    float left = rng.Uniform() * Extinction(wo);
    size_t chosen = parts_.size();
    for (size_t i = 0; i < parts_.size(); ++i) {
        const float extinction = PartExtinction(i, wo);
        if (!(extinction > 0)) continue;
        chosen = i;
        if (left < extinction) break;
        left -= extinction;
    }
    LACQUER_DCHECK(chosen < parts_.size());
    const Vec3 wi = parts_[std::min(chosen, parts_.size() - 1)]->Sample(wo, rng).wi;
    const PhaseValue value = Evaluate(wo, wi);
    return {wi, value.pdf > 0 ? value.p / value.pdf : 0.f, value.pdf, value.pdfReverse};
}

}  // namespace lacquer
