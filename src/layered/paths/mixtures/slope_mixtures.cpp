#include "layered/paths/mixtures/slope_mixtures.h"

#include "pbrt/scattering/slope_gaussian.h"

namespace lacquer::layered {
namespace {

constexpr SlopeScales MakeScales(const PerScale& t, const PerScale& weight, float typical) {
    SlopeScales scales{t, weight, {}, {}, typical};
    for (size_t j = 0; j < kNumScales; ++j)
        for (size_t k = 0; k < kNumScales; ++k) {
            scales.tOfPair[kNumScales * j + k] = t[j];
            scales.weightOfPair[kNumScales * j + k] = weight[j];
        }
    return scales;
}

constexpr SlopeScales kTrowbridgeReitzScales =
    MakeScales({0.029f, 0.16f, 0.6416f, 2.2525f}, {0.0589f, 0.2046f, 0.444f, 0.2925f}, 2);
constexpr SlopeScales kBeckmannScales = MakeScales({1, 1, 1, 1}, {1, 0, 0, 0}, 1);

/// The view of an outer direction, kept finite for grazing ones.
Slope OuterView(const PathEnd& end) {
    constexpr float kSmallestCos = 1e-4f;
    return end.slopes.View(end.w, kSmallestCos);
}

/// The mode of (1 + s.x) exp(-t x'C^-1 x/2) is this times C s. @param q  s'C s
float ModeAtScale(float t, float q) {
    const float overT = 1 / t;
    return ModeOfVisible(q * overT, overT);
}

/// The facet with its normal along kappa u - w, a guess where that is in the boundary.
JoiningFacet Join(float kappa, Vec3 w, Vec3 u) {
    constexpr float kMin = 0.02f;
    return {kappa, w, u, kMin};
}

/// Index of a weight, drawn in proportion to it; u in [0, sum).
template <size_t N>
size_t SampleIndex(const std::array<float, N>& weights, float& u) {
    size_t i = 0;
    for (; i + 1 < N && u >= weights[i]; ++i) u -= weights[i];
    return i;
}

}  // namespace

const SlopeScales& ScalesOf(MicrofacetModel model) {
    return model == MicrofacetModel::Beckmann ? kBeckmannScales : kTrowbridgeReitzScales;
}

// ---- Visible facets -----------------------------------------------------------------------------------

VisibleSlopeMixture::VisibleSlopeMixture(const PathEnd& end) {
    const Slope s = OuterView(end), cs = end.covariance * s;
    const Symmetric2 precision = end.covariance.Inverse();
    const float q = Dot(s, cs), volume = std::sqrt(precision.Determinant());
    const PerScale t = end.scales->t, weight = end.scales->weight;
    for (size_t k = 0; k < kNumScales; ++k) {
        const float mode = ModeAtScale(t[k], q);
        const float visible = 1 + mode * q, tilt = 1 / (visible * visible);
        meanX[k] = mode * cs.x;
        meanY[k] = mode * cs.y;
        xx[k] = t[k] * precision.xx + tilt * s.x * s.x;
        xy[k] = t[k] * precision.xy + tilt * s.x * s.y;
        yy[k] = t[k] * precision.yy + tilt * s.y * s.y;
        peak[k] = weight[k] * t[k] * volume * visible * PositiveExp(-0.5f * t[k] * mode * mode * q);
    }
}

float VisibleSlopeMixture::At(Slope slope) const {
    PerScale values;
    for (size_t k = 0; k < kNumScales; ++k) {
        const float x = slope.x - meanX[k], y = slope.y - meanY[k];
        values[k] = peak[k] * PositiveExp(-0.5f * (x * (xx[k] * x + 2 * xy[k] * y) + yy[k] * y * y));
    }
    return SumOf(values);
}

namespace {

/// Derivative of the relative slope of an end's facet by that of the direction behind it.
Matrix2 FacetPerInner(const PathEnd& end, Slope facet, Vec3 inner) {
    const Matrix2 j = Join(end.eta, end.w, inner).OverSlopeOfU();
    return end.slopes.IsPerturbed() ? end.slopes.PerStack(facet) * j : j;
}

}  // namespace

EndModel::EndModel(const PathEnd& pathEnd)
    : end(pathEnd), facets(pathEnd), precision(pathEnd.covariance.Inverse()) {
    const Slope s = OuterView(end), cs = end.covariance * s;
    mode = ModeAtScale(end.scales->typical, Dot(s, cs)) * cs;
    inner = end.BoundedDeflection(mode).u;
    innerPerFacet = FacetPerInner(end, mode, inner).Inverse();
}

// ---- First facet --------------------------------------------------------------------------------------

FirstFacet::FirstFacet(const EndModel& own, const EndModel& other, const JoiningFacets& joining)
    : facets_(own.facets), center_(own.mode) {
    const JoiningFacet byOther = Join(joining.kappa, own.inner, other.inner);
    const JoiningFacet byOwn = Join(1 / joining.kappa, other.inner, own.inner);
    const Slope residual = joining.slopes.Of(byOther.FacetSlope());
    const Matrix2 perOwn = joining.OverSlopeOfU(byOwn, residual) * own.innerPerFacet,
                  perOther = joining.OverSlopeOfU(byOther, residual) * other.innerPerFacet;
    SetMarginals(other, joining, residual, perOwn, perOther);
    SetWeights();
    // What the three events make of the residual together.
    const Symmetric2 covariance = joining.covariance + perOwn.PushForward(own.end.covariance) +
                                  perOther.PushForward(other.end.covariance);
    distance_ = Dot(residual, covariance.Inverse() * residual);
}

// The slope of the joining facet is residual + perOwn d + perOther d', d and d' being what the outer facets'
// slopes differ from their modes by. For Gaussian d' it is a Gaussian around the first two terms: of
// covariance C = joining/t + perOther Sigma' perOther^T, with its mean shifted by perOther times that of d'.
void FirstFacet::SetMarginals(const EndModel& other, const JoiningFacets& joining, Slope residual,
                              const Matrix2& perOwn, const Matrix2& perOther) {
    // For each scale of the other end.
    const VisibleSlopeMixture& f = other.facets;
    const Matrix2 p = perOther;
    PerScale shiftX, shiftY, varianceXX, varianceXY, varianceYY, mass;
    for (size_t k = 0; k < kNumScales; ++k) {
        const float x = f.meanX[k] - other.mode.x, y = f.meanY[k] - other.mode.y;
        shiftX[k] = residual.x + p.xx * x + p.xy * y;
        shiftY[k] = residual.y + p.yx * x + p.yy * y;
        const float over = 1 / (f.xx[k] * f.yy[k] - f.xy[k] * f.xy[k]);
        const float sxx = over * f.yy[k], sxy = -over * f.xy[k], syy = over * f.xx[k];
        varianceXX[k] = p.xx * (sxx * p.xx + 2 * sxy * p.xy) + syy * p.xy * p.xy;
        varianceXY[k] = p.xx * (sxx * p.yx + sxy * p.yy) + p.xy * (sxy * p.yx + syy * p.yy);
        varianceYY[k] = p.yx * (sxx * p.yx + 2 * sxy * p.yy) + syy * p.yy * p.yy;
        mass[k] = f.peak[k] * std::sqrt(over);
    }
    // For each scale of the joining facets, too.
    const PerPair eX = RepeatForPairs(shiftX), eY = RepeatForPairs(shiftY), vXX = RepeatForPairs(varianceXX),
                  vXY = RepeatForPairs(varianceXY), vYY = RepeatForPairs(varianceYY),
                  masses = RepeatForPairs(mass);
    const PerPair t = joining.scales->tOfPair, weight = joining.scales->weightOfPair;
    const Symmetric2 facets = joining.covariance;
    const Matrix2 j = perOwn;
    for (size_t i = 0; i < kNumPairs; ++i) {
        const float overT = 1 / t[i];
        const float cXX = vXX[i] + overT * facets.xx, cXY = vXY[i] + overT * facets.xy,
                    cYY = vYY[i] + overT * facets.yy;
        const float over = 1 / (cXX * cYY - cXY * cXY);
        const float iXX = over * cYY, iXY = -over * cXY, iYY = over * cXX;
        const float gX = iXX * eX[i] + iXY * eY[i], gY = iXY * eX[i] + iYY * eY[i];
        curvatureXX_[i] = j.xx * (iXX * j.xx + 2 * iXY * j.yx) + iYY * j.yx * j.yx;
        curvatureXY_[i] = j.xx * (iXX * j.xy + iXY * j.yy) + j.yx * (iXY * j.xy + iYY * j.yy);
        curvatureYY_[i] = j.xy * (iXX * j.xy + 2 * iXY * j.yy) + iYY * j.yy * j.yy;
        gradientX_[i] = j.xx * gX + j.yx * gY;
        gradientY_[i] = j.xy * gX + j.yy * gY;
        atCenter_[i] = eX[i] * gX + eY[i] * gY;
        peak_[i] = masses[i] * weight[i] * std::sqrt(over);
    }
}

// The integral of each product of an own scale and a pair.
void FirstFacet::SetWeights() {
    for (size_t k = 0; k < kNumScales; ++k) {
        const float x = facets_.meanX[k] - center_.x, y = facets_.meanY[k] - center_.y;
        const float xx = facets_.xx[k], xy = facets_.xy[k], yy = facets_.yy[k], peak = facets_.peak[k];
        const float lx = xx * x + xy * y, ly = xy * x + yy * y, square = x * lx + y * ly;
        PerPair& weights = weights_[k];
        for (size_t i = 0; i < kNumPairs; ++i) {
            const float pXX = xx + curvatureXX_[i], pXY = xy + curvatureXY_[i], pYY = yy + curvatureYY_[i];
            const float bX = lx - gradientX_[i], bY = ly - gradientY_[i];
            const float over = 1 / (pXX * pYY - pXY * pXY);
            const float reduced = over * (bX * (pYY * bX - 2 * pXY * bY) + pXX * bY * bY);
            weights[i] =
                peak * peak_[i] * std::sqrt(over) * PositiveExp(-0.5f * (atCenter_[i] + square - reduced));
        }
        totals_[k] = SumOf(weights);
    }
    total_ = SumOf(totals_);
}

Slope FirstFacet::Sample(Rng& rng) const {
    float u = rng.Uniform() * total_;
    const size_t k = SampleIndex(totals_, u), i = SampleIndex(weights_[k], u);
    const Symmetric2 own{facets_.xx[k], facets_.xy[k], facets_.yy[k]};
    const Symmetric2 precision = own + Symmetric2{curvatureXX_[i], curvatureXY_[i], curvatureYY_[i]};
    const Slope mean = Slope{facets_.meanX[k], facets_.meanY[k]} - center_;
    const Slope gradient = own * mean - Slope{gradientX_[i], gradientY_[i]};
    return FactoredGaussian2(center_, precision, gradient).Sample(rng.Uniform2D()).slope;
}

// The sum over all choices is a product of two sums: over its own scales and over the pairs.
float FirstFacet::Pdf(Slope slope) const {
    const float x = slope.x - center_.x, y = slope.y - center_.y;
    PerPair values;
    for (size_t i = 0; i < kNumPairs; ++i) {
        const float square = atCenter_[i] + 2 * (gradientX_[i] * x + gradientY_[i] * y) +
                             x * (curvatureXX_[i] * x + 2 * curvatureXY_[i] * y) + curvatureYY_[i] * y * y;
        values[i] = peak_[i] * PositiveExp(-0.5f * square);
    }
    return facets_.At(slope) * SumOf(values) * Inv2Pi / total_;
}

// ---- Second facet -------------------------------------------------------------------------------------

SecondFacet::SecondFacet(const EndModel& own, Vec3 fixed, const JoiningFacets& joining)
    : facets_(own.facets), scales_(*joining.scales), precision_(joining.covariance.Inverse()) {
    constexpr float kLargestSlope = 100, kLargestChange = 1e5f;
    volume_ = std::sqrt(precision_.Determinant());
    // One step of Gauss and Newton from the end's own mode, at typical scales.
    const Symmetric2 prior = own.precision * own.end.scales->typical,
                     likelihood = precision_ * scales_.typical;
    const JoiningFacet first = Join(joining.kappa, fixed, own.inner);
    const Slope firstJoined = joining.slopes.Of(first.FacetSlope());
    const Matrix2 perFacet = joining.OverSlopeOfU(first, firstJoined) * own.innerPerFacet;
    const Symmetric2 curvature = perFacet.PullBack(likelihood) + prior;
    center_ = own.mode - CholeskyFactor(curvature).Solve(perFacet.TransposeTimes(likelihood * firstJoined));
    if (!(std::abs(center_.x) + std::abs(center_.y) < kLargestSlope)) return;

    // Linearise again where it led.
    const Vec3 inner = own.end.BoundedDeflection(center_).u;
    const Matrix2 facetPerInner = FacetPerInner(own.end, center_, inner);
    const float change = std::abs(facetPerInner.Determinant());
    if (!(change > 1 / kLargestChange && change < kLargestChange)) return;
    const JoiningFacet joint = Join(joining.kappa, fixed, inner);
    joined_ = joining.slopes.Of(joint.FacetSlope());
    if (!(std::abs(joined_.x) + std::abs(joined_.y) < kLargestSlope)) return;
    joinedPerOwn_ = joining.OverSlopeOfU(joint, joined_) * facetPerInner.Inverse();
    const Slope moved = center_ - own.mode;
    distance_ = Dot(moved, own.precision * moved) + Dot(joined_, precision_ * joined_);
    SetWeights();
    // Farther out the exponents are small differences of numbers that have no digits left for them.
    constexpr float kFarthestMode = 3000;
    isUsable_ = distance_ < kFarthestMode && total_ > FirstFacet::kSmallestTotal &&
                total_ < FirstFacet::kLargestTotal;
}

// The integral of each product of one of its own scales (k) and one of the joining facets (j).
void SecondFacet::SetWeights() {
    PerScale x, y, squares;
    for (size_t k = 0; k < kNumScales; ++k) {
        const float dx = facets_.meanX[k] - center_.x, dy = facets_.meanY[k] - center_.y;
        x[k] = facets_.xx[k] * dx + facets_.xy[k] * dy;
        y[k] = facets_.xy[k] * dx + facets_.yy[k] * dy;
        squares[k] = dx * x[k] + dy * y[k];
    }
    const PerPair lx = RepeatForPairs(x), ly = RepeatForPairs(y), square = RepeatForPairs(squares),
                  xx = RepeatForPairs(facets_.xx), xy = RepeatForPairs(facets_.xy),
                  yy = RepeatForPairs(facets_.yy), peak = RepeatForPairs(facets_.peak);
    const Symmetric2 h = joinedPerOwn_.PullBack(precision_);
    const Slope scaled = precision_ * joined_, q = joinedPerOwn_.TransposeTimes(scaled);
    const float residual2 = Dot(joined_, scaled), volume = volume_;
    const PerPair t = scales_.tOfPair, weight = scales_.weightOfPair;
    for (size_t i = 0; i < kNumPairs; ++i) {
        const float pXX = xx[i] + t[i] * h.xx, pXY = xy[i] + t[i] * h.xy, pYY = yy[i] + t[i] * h.yy;
        const float bX = lx[i] - t[i] * q.x, bY = ly[i] - t[i] * q.y;
        const float over = 1 / (pXX * pYY - pXY * pXY);
        const float reduced = over * (bX * (pYY * bX - 2 * pXY * bY) + pXX * bY * bY);
        weights_[i] = peak[i] * weight[i] * t[i] * volume * std::sqrt(over) *
                      PositiveExp(-0.5f * (t[i] * residual2 + square[i] - reduced));
    }
    total_ = SumOf(weights_);
}

Slope SecondFacet::Sample(Rng& rng) const {
    float u = rng.Uniform() * total_;
    const size_t i = SampleIndex(weights_, u), j = i / kNumScales, k = i % kNumScales;
    const float t = scales_.t[j];
    const Symmetric2 own{facets_.xx[k], facets_.xy[k], facets_.yy[k]};
    const Symmetric2 precision = own + joinedPerOwn_.PullBack(precision_) * t;
    const Slope mean = Slope{facets_.meanX[k], facets_.meanY[k]} - center_;
    const Slope gradient = own * mean - joinedPerOwn_.TransposeTimes(precision_ * joined_) * t;
    return FactoredGaussian2(center_, precision, gradient).Sample(rng.Uniform2D()).slope;
}

float SecondFacet::Pdf(Slope slope) const {
    const Slope joined = joined_ + joinedPerOwn_ * (slope - center_);
    const float square = Dot(joined, precision_ * joined), volume = volume_;
    const PerScale t = scales_.t, weight = scales_.weight;
    PerScale values;
    for (size_t j = 0; j < kNumScales; ++j)
        values[j] = weight[j] * t[j] * volume * PositiveExp(-0.5f * t[j] * square);
    return facets_.At(slope) * SumOf(values) * Inv2Pi / total_;
}

}  // namespace lacquer::layered
