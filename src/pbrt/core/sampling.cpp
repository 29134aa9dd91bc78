#include "pbrt/core/sampling.h"

#include <numeric>

#include "pbrt/core/check.h"

namespace lacquer {

namespace {

/// A finite weight that is not below zero; NaN counts as zero.
float FiniteWeight(float value) {
    return value > 0 ? std::min(value, std::numeric_limits<float>::max()) : 0.f;
}

/// SampleLinear, uniform where the line is zero at both ends.
float SampleLinearOrUniform(float u, float a, float b) { return a + b > 0 ? SampleLinear(u, a, b) : u; }
float InvertLinearOrUniform(float x, float a, float b) {
    return a + b > 0 ? std::clamp(InvertLinear(x, a, b), 0.f, 1.f) : x;
}

/// Azimuth of p as a fraction of the full turn, in [0,1].
float TurnOf(float x, float y) { return SphericalPhi({x, y, 0}) * Inv2Pi; }

}  // namespace

int SampleDiscrete(std::span<const float> weights, float u, float* pmf, float* remapped) {
    float sum = 0;
    for (const float w : weights) sum += FiniteWeight(w);
    if (!(sum > 0)) return -1;

    // Walk the weights; `chosen` stays on the last positive one where rounding leaves a remainder.
    const float target = u * sum;
    float below = 0, belowChosen = 0;
    int chosen = -1;
    for (size_t i = 0; i < weights.size(); ++i) {
        const float w = FiniteWeight(weights[i]);
        if (w > 0) {
            chosen = int(i);
            belowChosen = below;
            below += w;
            if (target < below) break;
        }
    }
    const float weight = FiniteWeight(weights[size_t(chosen)]);
    if (pmf) *pmf = weight / sum;
    if (remapped) *remapped = std::clamp((target - belowChosen) / weight, 0.f, OneMinusEpsilon);
    return chosen;
}

float SampleTent(float u, float r) {
    return u < 0.5f ? r * (SampleLinear(2 * u, 0, 1) - 1) : r * SampleLinear(2 * u - 1, 1, 0);
}

float PdfTent(float x, float r) { return std::abs(x) >= r ? 0.f : (1 - std::abs(x) / r) / r; }

float InvertTent(float x, float r) {
    const float outer = InvertLinear(std::abs(x) / r, 1, 0) / 2;
    return x <= 0 ? 0.5f - outer : 0.5f + outer;
}

Point2 InvertUniformDiskConcentric(Point2 p) {
    const float radius = std::sqrt(p.x * p.x + p.y * p.y);
    Point2 offset;
    if (std::abs(p.x) > std::abs(p.y)) {
        offset.x = std::copysign(radius, p.x);
        offset.y = offset.x * std::atan(p.y / p.x) / PiOver4;
    } else {
        offset.y = std::copysign(radius, p.y);
        offset.x = p.y == 0 ? 0.f : offset.y * std::atan(p.x / p.y) / PiOver4;
    }
    return 0.5f * (offset + Point2(1, 1));
}

Point2 SampleUniformDiskPolar(Point2 u) {
    const float r = std::sqrt(u.x), theta = 2 * Pi * u.y;
    return {r * std::cos(theta), r * std::sin(theta)};
}

Point2 InvertUniformDiskPolar(Point2 p) { return {p.x * p.x + p.y * p.y, TurnOf(p.x, p.y)}; }

Vec3 SampleUniformHemisphere(Point2 u) {
    return SphericalDirection(SafeSqrt(1 - u.x * u.x), u.x, 2 * Pi * u.y);
}

Point2 InvertUniformHemisphere(Vec3 w) { return {w.z, TurnOf(w.x, w.y)}; }

Vec3 SampleUniformSphere(Point2 u) {
    // 1 - z^2 = 4 u (1 - u) keeps its digits near the poles.
    return SphericalDirection(2 * SafeSqrt(u.x * (1 - u.x)), 1 - 2 * u.x, 2 * Pi * u.y);
}

Point2 InvertUniformSphere(Vec3 w) { return {(1 - w.z) / 2, TurnOf(w.x, w.y)}; }

Vec3 SampleUniformCone(Point2 u, float cosThetaMax) {
    // With c = 1 - cos(theta), sin(theta)^2 = c (2 - c): no cancellation in narrow cones.
    const float oneMinusCos = u.x * (1 - cosThetaMax);
    return SphericalDirection(SafeSqrt(oneMinusCos * (2 - oneMinusCos)), 1 - oneMinusCos, 2 * Pi * u.y);
}

Point2 InvertUniformCone(Vec3 w, float cosThetaMax) {
    if (!(cosThetaMax < 1)) return {0, TurnOf(w.x, w.y)};
    const float oneMinusCos = w.z > 0 ? (w.x * w.x + w.y * w.y) / (1 + w.z) : 1 - w.z;
    return {oneMinusCos / (1 - cosThetaMax), TurnOf(w.x, w.y)};
}

Point2 InvertUniformTriangle(Vec3 b) {
    return b.x < b.y ? Point2(2 * b.x, b.x + b.y) : Point2(b.x + b.y, 2 * b.y);
}

Point2 SampleBilinear(Point2 u, std::span<const float, 4> w) {
    const float y = SampleLinearOrUniform(u.y, w[0] + w[1], w[2] + w[3]);
    const float x = SampleLinearOrUniform(u.x, Lerp(y, w[0], w[2]), Lerp(y, w[1], w[3]));
    return {x, y};
}

float PdfBilinear(Point2 p, std::span<const float, 4> w) {
    if (p.x < 0 || p.x > 1 || p.y < 0 || p.y > 1) return 0;
    const float sum = w[0] + w[1] + w[2] + w[3];
    if (!(sum > 0)) return 1;
    return 4 * Lerp(p.y, Lerp(p.x, w[0], w[1]), Lerp(p.x, w[2], w[3])) / sum;
}

Point2 InvertBilinear(Point2 p, std::span<const float, 4> w) {
    return {InvertLinearOrUniform(p.x, Lerp(p.y, w[0], w[2]), Lerp(p.y, w[1], w[3])),
            InvertLinearOrUniform(p.y, w[0] + w[1], w[2] + w[3])};
}

PiecewiseConstant1D::PiecewiseConstant1D(std::span<const float> values, float min, float max)
    : min_(min),
      max_(max),
      cellWidth_((max - min) / float(values.size())),
      cellsPerUnit_(float(values.size()) / (max - min)) {
    LACQUER_CHECK(!values.empty() && min < max);
    for (const float value : values) values_.push_back(FiniteWeight(value));

    // Normalise the running sum; without any weight it is that of the uniform density.
    const double count = double(values_.size());
    const double sum = std::accumulate(values_.begin(), values_.end(), 0.0);
    integral_ = FiniteWeight(float(sum * (double(max) - double(min)) / count));
    double below = 0;
    cdf_.push_back(0);
    for (size_t i = 0; i < values_.size(); ++i) {
        below += double(values_[i]);
        cdf_.push_back(integral_ > 0 ? float(below / sum) : float(double(i + 1) / count));
    }
    for (int k = 0; k < Size(); ++k) {
        const float u = float(k) / float(Size());
        guide_.push_back(FindInterval(int(cdf_.size()), [&](int i) { return cdf_[size_t(i)] <= u; }));
    }
}

int PiecewiseConstant1D::CellAt(float u) const {
    // Backwards only if rounding put u*size into the next slot; forwards one step on average.
    int i = guide_[size_t(std::clamp(int(u * float(Size())), 0, Size() - 1))];
    while (i > 0 && cdf_[size_t(i)] > u) --i;
    while (i + 1 < Size() && cdf_[size_t(i) + 1] <= u) ++i;
    return i;
}

int PiecewiseConstant1D::CellOf(float x) const {
    return std::clamp(int((x - min_) * cellsPerUnit_), 0, Size() - 1);
}

float PiecewiseConstant1D::Sample(float u, float* pdf, int* cell) const {
    const int i = CellAt(u);
    const float low = cdf_[size_t(i)], high = cdf_[size_t(i) + 1];
    const float within = high > low ? std::min((u - low) / (high - low), OneMinusEpsilon) : 0.f;
    const auto at = [&](float t) { return std::min(min_ + (float(i) + t) * cellWidth_, max_); };
    float x = at(within);

    // Rounding may have put x into the neighbour, where the density differs: keep a margin, as narrow as will
    // do.
    for (float margin = 0x1p-22f; margin <= 0.5f && CellOf(x) != i; margin *= 2)
        x = at(std::clamp(within, margin, 1 - margin));
    if (cell) *cell = i;
    if (pdf) *pdf = integral_ > 0 ? values_[size_t(i)] / integral_ : 1 / (max_ - min_);
    return x;
}

float PiecewiseConstant1D::Pdf(float x) const {
    if (!(x >= min_ && x <= max_)) return 0;
    return integral_ > 0 ? values_[size_t(CellOf(x))] / integral_ : 1 / (max_ - min_);
}

float PiecewiseConstant1D::Invert(float x) const {
    const int i = CellOf(x);
    const float within = std::clamp((x - min_) * cellsPerUnit_ - float(i), 0.f, 1.f);
    return Lerp(within, cdf_[size_t(i)], cdf_[size_t(i) + 1]);
}

PiecewiseConstant2D::PiecewiseConstant2D(std::span<const float> values, int nx, int ny, Point2 min,
                                         Point2 max)
    : min_(min), max_(max) {
    LACQUER_CHECK(nx > 0 && ny > 0 && values.size() == size_t(nx) * size_t(ny));
    conditional_.reserve(size_t(ny));
    std::vector<float> rowIntegrals;
    for (int y = 0; y < ny; ++y) {
        conditional_.emplace_back(values.subspan(size_t(y) * size_t(nx), size_t(nx)), min.x, max.x);
        rowIntegrals.push_back(conditional_.back().Integral());
    }
    marginal_ = PiecewiseConstant1D(rowIntegrals, min.y, max.y);
}

Point2 PiecewiseConstant2D::Sample(Point2 u, float* pdf, Int2* cell) const {
    float pdfX, pdfY;
    Int2 at;
    const float y = marginal_.Sample(u.y, &pdfY, &at.y);
    const float x = conditional_[size_t(at.y)].Sample(u.x, &pdfX, &at.x);
    if (pdf) *pdf = pdfX * pdfY;
    if (cell) *cell = at;
    return {x, y};
}

float PiecewiseConstant2D::Pdf(Point2 p) const {
    if (!(p.x >= min_.x && p.x <= max_.x && p.y >= min_.y && p.y <= max_.y)) return 0;
    return marginal_.Pdf(p.y) * conditional_[size_t(marginal_.CellOf(p.y))].Pdf(p.x);
}

Point2 PiecewiseConstant2D::Invert(Point2 p) const {
    return {conditional_[size_t(marginal_.CellOf(p.y))].Invert(p.x), marginal_.Invert(p.y)};
}

AliasTable::AliasTable(std::span<const float> weights) : bins_(weights.size()) {
    double sum = 0;
    for (const float w : weights) sum += double(FiniteWeight(w));

    // Sort the indices into those with less and those with more than an equal share.
    std::vector<double> share(weights.size());
    std::vector<size_t> under, over;
    size_t heaviest = 0;
    for (size_t i = 0; i < weights.size(); ++i) {
        const double p = sum > 0 ? double(FiniteWeight(weights[i])) / sum : 1 / double(weights.size());
        bins_[i].p = float(p);
        share[i] = p * double(weights.size());
        if (share[i] > share[heaviest]) heaviest = i;
        (share[i] < 1 ? under : over).push_back(i);
    }
    // Fill up each small bin from a large one.
    while (!under.empty() && !over.empty()) {
        const size_t small = under.back(), large = over.back();
        under.pop_back();
        bins_[small].q = float(share[small]);
        bins_[small].alias = int(large);
        share[large] -= 1 - share[small];
        if (share[large] < 1) {
            over.pop_back();
            under.push_back(large);
        }
    }
    // What is left is full but for rounding; an index without weight must not become drawable by that.
    for (const auto* rest : {&under, &over})
        for (const size_t i : *rest) {
            bins_[i].q = bins_[i].p > 0 ? 1.f : 0.f;
            bins_[i].alias = int(heaviest);
        }
}

int AliasTable::Sample(float u, float* pmf, float* remapped) const {
    if (bins_.empty()) return -1;
    const float scaled = u * float(bins_.size());
    const int i = std::min(int(scaled), Size() - 1);
    const float up = std::clamp(scaled - float(i), 0.f, OneMinusEpsilon);
    const Bin& bin = bins_[size_t(i)];
    const bool stays = up < bin.q;
    const int chosen = stays ? i : bin.alias;
    if (pmf) *pmf = bins_[size_t(chosen)].p;
    if (remapped) *remapped = std::min(stays ? up / bin.q : (up - bin.q) / (1 - bin.q), OneMinusEpsilon);
    return chosen;
}

}  // namespace lacquer
