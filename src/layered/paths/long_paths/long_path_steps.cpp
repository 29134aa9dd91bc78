#include "layered/paths/long_paths/long_path_steps.h"

#include "layered/paths/long_paths/long_path_azimuth.h"

namespace lacquer::layered {
namespace {

/// How many of `sums`, running sums, are not above x: the cell that x falls into. Branches that depend on
/// random numbers would cost more than the arithmetic.
template <int kCount>
int CellOf(const float (&sums)[kCount], float x) {
    int cell = 0;
    for (int j = 0; j < kCount - 1; ++j) cell += x >= sums[j] ? 1 : 0;
    return cell;
}

/// An index drawn in proportion to `masses`, not negative. Small masses should be at both ends: they are
/// drawn with the right probability even where it is 1e-10. @param pmf  its probability
template <int kCount>
int SampleCell(const float* masses, Rng& rng, float* pmf) {
    // In two steps, column and row: few additions wait for each other.
    constexpr int kColumns = 8;
    constexpr std::array<int, 4> kRows = {0, 3, 1, 2};  // the ends first
    static_assert(kCount == kColumns * int(kRows.size()));
    float columns[kColumns] = {}, sums[kColumns];
    for (int k = 0; k < kCount; k += kColumns)
        for (int j = 0; j < kColumns; ++j) columns[j] += masses[k + j];
    float total = 0;
    for (int j = 0; j < kColumns; ++j) sums[j] = total += columns[j];
    const uint64_t bits = rng.NextBits();
    const int column = CellOf(sums, UnitFloat(bits) * total);

    // A float near 0 resolves all of the 40 bits.
    const float u = std::min(float(bits & 0xffffffffff) * 0x1p-40f, OneMinusEpsilon);
    float rows[4], sum = 0;
    for (size_t i = 0; i < 4; ++i) rows[i] = sum += masses[kRows[i] * kColumns + column];
    const int cell = kRows[size_t(CellOf(rows, u * sum))] * kColumns + column;
    *pmf = masses[cell] / total;
    return cell;
}

}  // namespace

// ---- Base -----------------------------------------------------------------------------------------------

template <MicrofacetDistribution Distribution>
BaseReflection<Distribution>::BaseReflection(float alphaBase, float alphaCoat, float eta,
                                             float opticalThickness)
    : quantiles_(ReflectionQuantiles::Of<Distribution>().At(alphaBase)),
      alpha_(alphaBase),
      opticalThickness_(opticalThickness) {
    // Facets tilt by about alpha/sqrt(2); the critical angle is smeared by as much.
    const float sinCritical = std::min(1.f, 1 / eta);
    cosCritical_ = SafeSqrt(1 - sinCritical * sinCritical);
    invWidth_ = 1 / (0.01f + 0.7f * alphaCoat * sinCritical);
    least_ = 0.01f + Sqr((eta - 1) / (eta + 1));
}

template <MicrofacetDistribution Distribution>
void BaseReflection<Distribution>::FillMasses(const ReflectionQuantiles::Row& row, float* masses) const {
    // A step from the loss before the critical angle to nearly 1 behind it, taken where cells end: too much
    // for the cell in which it happens is better than too little.
    const float* cellMasses = ReflectionQuantiles::Masses().data();
    for (int k = 0; k < ReflectionQuantiles::kNumCells; ++k) {
        const float end = row.ends[size_t(k)], t = (1 - end * end - cosCritical_) * invWidth_;
        masses[k] = cellMasses[k] * (least_ + 0.5f * (1 - t / std::sqrt(1 + t * t)));
    }
    if (!(opticalThickness_ > 0)) return;
    // Nearly e^-d, d the loss on the way up and down again; no cell may come out empty.
    constexpr float kMinCos = 0.05f;
    for (int k = 0; k < ReflectionQuantiles::kNumCells; ++k) {
        const float d = 2 * opticalThickness_ / (1 - Sqr(row.ends[size_t(k)]) + kMinCos);
        masses[k] *= 1 / (1 + d * (1 + d * (0.5f + d * (1.f / 6))));
    }
}

template <MicrofacetDistribution Distribution>
bool BaseReflection<Distribution>::Sample(Vec3 w, Rng& rng, Vec3* wi, float* pdf) const {
    // The cosine first...
    const PolarAngle from{w.z, std::sqrt(w.x * w.x + w.y * w.y)};
    const ReflectionQuantiles::Row row = quantiles_.Find(from.sin / std::sqrt(1 + from.cos));
    alignas(64) float masses[ReflectionQuantiles::kNumCells];
    FillMasses(row, masses);
    float pmf;
    const int cell = SampleCell<ReflectionQuantiles::kNumCells>(masses, rng, &pmf);
    const float low = cell > 0 ? row.ends[size_t(cell) - 1] : 0.f, width = row.ends[size_t(cell)] - low;
    const float x = low + rng.Uniform() * width;
    const PolarAngle to{1 - x * x, x * SafeSqrt(2 - x * x)};
    if (!(to.cos > 0) || !(x > 0)) return false;

    // ... then the azimuth.
    const AzimuthSample psi = SampleAzimuth(Distribution(alpha_, alpha_), from, to, rng.Uniform2D());
    const Vec2 mirror = from.sin > 0 ? Vec2(-w.x, -w.y) / from.sin : Vec2(1, 0);
    *wi = {to.sin * (mirror.x * psi.cos - mirror.y * psi.sin),
           to.sin * (mirror.y * psi.cos + mirror.x * psi.sin), to.cos};
    // |d cos| = 2 x dx.
    *pdf = pmf / width * psi.pdf / (2 * x);
    return *pdf > 0 && *pdf <= std::numeric_limits<float>::max();
}

// ---- Coat -----------------------------------------------------------------------------------------------

namespace {

/// A facet's slope along the view in units of alpha is scale b(t) / a(t), t being what is drawn; `scale`
/// depends on the slope across. The density of t for facets of any orientation is norm g(t) a(t), and for
/// visible ones norm g(t) times their visible area with the length of the normal multiplied by a(t).
struct SlopeAlong {
    float a, b, g;
};
/// What the two distributions have different.
template <class Distribution>
struct SlopeLaw;

template <>
struct SlopeLaw<Beckmann> {
    // The range holds all but 1e-9 of the Gaussian of variance 1/2.
    static constexpr float kEnd = 4.2f, kNorm = 0.56418958354775628695f;
    static float SampleAcross(float u) { return SampleBeckmannSlope(u); }
    static float Scale(float) { return 1; }
    static SlopeAlong At(float t) { return {1, t, std::exp(-t * t)}; }
};
template <>
struct SlopeLaw<TrowbridgeReitz> {
    // Slopes have the density 1 / (pi (1 + x^2 + y^2)^2); x / sqrt(1 + y^2) = tan t.
    static constexpr float kEnd = PiOver2, kNorm = 2 * InvPi;
    static float SampleAcross(float u) {
        const float s = std::clamp(2 * u - 1, -1 + 2 * MachineEpsilon, 1 - 2 * MachineEpsilon);
        return s / std::sqrt((1 - s) * (1 + s));
    }
    static float Scale(float across) { return std::sqrt(1 + across * across); }
    static SlopeAlong At(float t) { return {std::cos(t), std::sin(t), std::cos(t)}; }
};

/// Evenly spaced on [-kEnd, kEnd].
constexpr int kNodes = 32;
template <class Distribution>
struct SlopeNodes {
    static constexpr float kSpacing = 2 * SlopeLaw<Distribution>::kEnd / (kNodes - 1);
    alignas(64) float a[kNodes], b[kNodes], g[kNodes];

    SlopeNodes() {
        for (int k = 0; k < kNodes; ++k) {
            const SlopeAlong s = SlopeLaw<Distribution>::At(Position(float(k)));
            a[k] = s.a;
            b[k] = s.b;
            g[k] = std::max(0.f, s.g);
        }
    }
    static float Position(float node) { return node * kSpacing - SlopeLaw<Distribution>::kEnd; }
    static const SlopeNodes& Get() {
        static const SlopeNodes nodes;
        return nodes;
    }
};

/// Added to Fresnel's factor and to shadowing, so that nothing is drawn too rarely.
constexpr float kMinFresnel = 0.03f, kMinSeen = 0.03f;

/// The density of t, up to a constant, at all nodes: visible area times Fresnel's factor times roughly what
/// shadowing leaves. @param eta  index on this side over index on the other one
template <class Distribution>
void FillDensity(float alpha, float eta, float cosView, float sinView, float across, float* density) {
    const SlopeNodes<Distribution>& nodes = SlopeNodes<Distribution>::Get();
    const float tilt = alpha * SlopeLaw<Distribution>::Scale(across), tilt2 = tilt * tilt;
    const float lean = tilt * sinView, flat = 1 + Sqr(alpha * across), rough = 0.3f * alpha;
    for (int k = 0; k < kNodes; ++k) {
        const float a = nodes.a[k], b = nodes.b[k];
        const float area = std::max(0.f, cosView * a - lean * b);
        const float over2 = 1 / (flat * a * a + tilt2 * b * b), cos = area * std::sqrt(over2) + 1e-6f;
        const float down = 2 * area * a * over2 - cosView, seen = std::max(0.f, down),
                    of = std::abs(down) + rough;
        // Fresnel's factor of both polarisations over one denominator; 1 under total reflection, where t is
        // 0.
        const float t = std::sqrt(std::max(0.f, 1 - (1 - cos * cos) * (eta * eta)));
        const float p1 = Sqr(cos - eta * t), p2 = Sqr(cos + eta * t);
        const float s1 = Sqr(eta * cos - t), s2 = Sqr(eta * cos + t);
        const float fresnel = p1 * s2 + s1 * p2, whole = 2 * p2 * s2;
        density[k] =
            nodes.g[k] * area * (kMinSeen * of + seen) * (kMinFresnel * whole + fresnel) / (of * whole);
    }
}

}  // namespace

template <MicrofacetDistribution Distribution>
bool CoatReflection<Distribution>::Sample(Vec3 w, Rng& rng, Vec3* wi, float* weight) const {
    using Law = SlopeLaw<Distribution>;
    using Nodes = SlopeNodes<Distribution>;
    const float alpha = facets_.AlphaX(), sin = std::sqrt(w.x * w.x + w.y * w.y);
    const float across = Law::SampleAcross(rng.Uniform());

    // The density is a sum of tents around the nodes, between two nodes of density 0.
    constexpr int kFirst = 16;  // keeps the rest aligned
    alignas(64) float density[kFirst + kNodes + 1];
    density[kFirst - 1] = density[kFirst + kNodes] = 0;
    FillDensity<Distribution>(alpha, eta_, w.z, sin, across, density + kFirst);
    float pmf;
    const int node = SampleCell<kNodes>(density + kFirst, rng, &pmf);
    if (!(pmf > 0)) return false;
    const Point2 u = rng.Uniform2D();
    const float offset = u.x + u.y - 1, share = std::abs(offset);
    const float own = density[kFirst + node], neighbour = density[kFirst + node + (offset < 0 ? -1 : 1)];
    const float pdf = pmf / Nodes::kSpacing * ((1 - share) + share * neighbour / own);

    // The facet, and what it does.
    const SlopeAlong slope = Law::At(Nodes::Position(float(node) + offset));
    const float scale = Law::Scale(across), area = w.z * slope.a - alpha * sin * scale * slope.b;
    if (!(area > 0) || !(slope.a > 0)) return false;
    const Vec2 view = sin > 0 ? Vec2(w.x, w.y) / sin : Vec2(1, 0);
    const float x = alpha * scale * slope.b, y = alpha * across * slope.a;
    const Vec3 wm = Normalize({-(view.x * x - view.y * y), -(view.y * x + view.x * y), slope.a});
    const float cos = Dot(w, wm);
    *wi = Normalize(2 * cos * wm - w);
    if (!(wi->z > 0) || !(cos > 0)) return false;
    const Shadowing<Distribution> shadowing(facets_, w, *wi);
    *weight =
        FresnelDielectric(cos, 1 / eta_) * wi->z * shadowing.overCosines * Law::kNorm * slope.g * area / pdf;
    return *weight <= std::numeric_limits<float>::max();
}

template class BaseReflection<Beckmann>;
template class BaseReflection<TrowbridgeReitz>;
template class CoatReflection<Beckmann>;
template class CoatReflection<TrowbridgeReitz>;

}  // namespace lacquer::layered
