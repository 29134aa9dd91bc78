#include "layered/paths/long_paths/long_path_tables.h"

#include <memory>
#include <vector>

namespace lacquer::layered {
namespace {

/// Sums of the first masses, up to the middle.
constexpr int kHalf = ReflectionQuantiles::kNumCells / 2;
constexpr std::array<double, kHalf + 1> kLevels = {0,    1e-6, 1e-5, 1e-4, 1e-3, 0.006, 0.02, 0.05, 0.1,
                                                   0.15, 0.2,  0.25, 0.3,  0.35, 0.4,   0.45, 0.5};

std::array<float, ReflectionQuantiles::kNumCells> MakeMasses() {
    std::array<float, ReflectionQuantiles::kNumCells> masses;
    for (size_t i = 0; i < kHalf; ++i)
        masses[i] = masses[2 * kHalf - 1 - i] = float(kLevels[i + 1] - kLevels[i]);
    return masses;
}

/// Points at which a density over x is known while its quantiles are found.
constexpr int kNumPoints = 1024;

struct Angle {
    double x, cos, sin;
    double area;  ///< ProjectedArea of the facets
};

template <MicrofacetDistribution Distribution>
std::vector<Angle> MakeAngles(const Distribution& facets) {
    std::vector<Angle> angles(kNumPoints);
    for (int i = 0; i < kNumPoints; ++i) {
        const double x = (i + 0.5) / kNumPoints, cos = 1 - x * x, sin = x * std::sqrt(2 - x * x);
        angles[size_t(i)] = {x, cos, sin, double(facets.ProjectedArea({float(sin), 0, float(cos)}))};
    }
    return angles;
}

// Integrals over the azimuth of D at the half vector, up to a constant; formulas in long_path_azimuth.h.

double IntegrateAzimuth(const Beckmann& facets, const Angle& a, const Angle& b) {
    constexpr int kSteps = 12;
    constexpr double kNothing = 40;  // exponent of a factor that no float would notice
    const double scale = 1 / (double(facets.AlphaX()) * (a.cos + b.cos));
    const double difference = Sqr((a.sin - b.sin) * scale);
    if (difference > kNothing) return 0;
    const double q = a.sin * b.sin, kappa = 2 * q * scale * scale, p = 1 + a.cos * b.cos;
    const double end = std::min(double(Pi), 7 / std::sqrt(kappa));
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double cosPsi = std::cos((i + 0.5) / kSteps * end);
        sum += std::exp(kappa * (cosPsi - 1)) * Sqr(p - q * cosPsi);
    }
    return sum * end * std::exp(-difference) / Sqr(Sqr(a.cos + b.cos));
}

double IntegrateAzimuth(const TrowbridgeReitz& facets, const Angle& a, const Angle& b) {
    // The sum of three of SampleAzimuth(), where each has its closed form.
    const double alpha2 = Sqr(double(facets.AlphaX())), s = Sqr(a.cos + b.cos);
    const double difference = 0.5 * (Sqr(a.sin - b.sin) + alpha2 * s),
                 sum = 0.5 * (Sqr(a.sin + b.sin) + alpha2 * s);
    const double middle = 0.5 * (sum + difference), d = 0.5 * (1 - alpha2) * s,
                 root = std::sqrt(sum * difference);
    return 1 + 2 * d / root + d * d * middle / (root * root * root);
}

/// Density over x of the cosine that follows `a`, up to a constant.
template <MicrofacetDistribution Distribution>
double Density(const Distribution& facets, const Angle& a, const Angle& b) {
    const double shadowing = b.cos / (a.area * b.cos + (b.area - b.cos) * a.cos);
    return b.x * shadowing * IntegrateAzimuth(facets, a, b);
}

/// Where the sum of `density`, taken from the first point or from the last one, reaches `level` of its total.
double Quantile(const std::vector<double>& density, double total, double level, bool fromEnd) {
    double sum = 0;
    for (int i = 0; i < kNumPoints; ++i) {
        const double next = density[size_t(fromEnd ? kNumPoints - 1 - i : i)] / total;
        if (sum + next >= level) {
            const double x = (i + (level - sum) / next) / kNumPoints;
            return fromEnd ? 1 - x : x;
        }
        sum += next;
    }
    return fromEnd ? 0 : 1;
}

template <MicrofacetDistribution Distribution>
void FillRow(const Distribution& facets, const std::vector<Angle>& angles, double x,
             ReflectionQuantiles::Row* row) {
    // At the horizon itself nothing is reflected.
    const double cos = std::max(1 - x * x, 1e-3), sin = std::sqrt((1 - cos) * (1 + cos));
    const Angle from{x, cos, sin, double(facets.ProjectedArea({float(sin), 0, float(cos)}))};
    std::vector<double> density(kNumPoints);
    double total = 0;
    for (size_t i = 0; i < kNumPoints; ++i) total += density[i] = Density(facets, from, angles[i]);

    row->ends.back() = 1;
    for (size_t i = 1; i <= kHalf; ++i) {
        row->ends[2 * kHalf - 1 - i] = float(Quantile(density, total, kLevels[i], true));
        row->ends[i - 1] = float(Quantile(density, total, kLevels[i], false));
    }
}

}  // namespace

const std::array<float, ReflectionQuantiles::kNumCells>& ReflectionQuantiles::Masses() {
    alignas(64) static const std::array<float, kNumCells> masses = MakeMasses();
    return masses;
}

template <MicrofacetDistribution Distribution>
const ReflectionQuantiles& ReflectionQuantiles::Of() {
    static const std::unique_ptr<const ReflectionQuantiles> table = [] {
        std::unique_ptr<ReflectionQuantiles> t(new ReflectionQuantiles);
        for (int i = 0; i < kNumAlphas; ++i) {
            const float alpha = kFirstAlpha * std::exp2(float(i) / kAlphasPerOctave);
            const Distribution facets(alpha, alpha);
            const std::vector<Angle> angles = MakeAngles(facets);
            for (int k = 0; k < kNumRows; ++k)
                FillRow(facets, angles, double(k) / (kNumRows - 1), &t->rows_[size_t(i)][size_t(k)]);
        }
        return t;
    }();
    return *table;
}

template const ReflectionQuantiles& ReflectionQuantiles::Of<Beckmann>();
template const ReflectionQuantiles& ReflectionQuantiles::Of<TrowbridgeReitz>();

ReflectionQuantiles::Slice ReflectionQuantiles::At(float alpha) const {
    const float position =
        std::clamp(kAlphasPerOctave * std::log2(alpha / kFirstAlpha), 0.f, float(kNumAlphas - 1));
    const int i = std::min(int(position), kNumAlphas - 2);
    Slice slice;
    slice.low_ = rows_[size_t(i)].data();
    slice.high_ = rows_[size_t(i) + 1].data();
    slice.share_ = position - float(i);
    return slice;
}

auto ReflectionQuantiles::Slice::Find(float x) const -> Row {
    const float position = std::clamp(x, 0.f, 1.f) * (kNumRows - 1);
    const int i = std::min(int(position), kNumRows - 2);
    const float t = position - float(i);
    const Row &a = low_[i], &b = low_[i + 1], &c = high_[i], &d = high_[i + 1];
    const float wa = (1 - share_) * (1 - t), wb = (1 - share_) * t, wc = share_ * (1 - t), wd = share_ * t;
    Row row;
    for (size_t k = 0; k < kNumCells; ++k)
        row.ends[k] = wa * a.ends[k] + wb * b.ends[k] + wc * c.ends[k] + wd * d.ends[k];
    return row;
}

}  // namespace lacquer::layered
