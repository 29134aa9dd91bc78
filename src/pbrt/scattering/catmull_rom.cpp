#include "pbrt/scattering/catmull_rom.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/math.h"

namespace lacquer {
namespace {

/// Root in [0,1] of a function with f(0) <= 0 <= f(1), by Newton steps that fall back on halving.
/// `evaluate(t)` gives the value and the derivative.
template <class Function>
float FindRoot(const Function& evaluate) {
    float low = 0, high = 1, t = 0.5f;
    for (int i = 0; i < 32; ++i) {
        const auto [value, slope] = evaluate(t);
        (value < 0 ? low : high) = t;
        if (std::abs(value) < 1e-7f || high - low < 1e-7f) break;
        const float newton = t - value / slope;
        t = newton > low && newton < high ? newton : 0.5f * (low + high);
    }
    return t;
}

}  // namespace

float HermiteCubic::Value(float t) const {
    return f0 + t * (d0 + t * (3 * (f1 - f0) - 2 * d0 - d1 + t * (2 * (f0 - f1) + d0 + d1)));
}

float HermiteCubic::Integral(float t) const {
    return t *
           (f0 + t * (d0 / 2 + t * ((3 * (f1 - f0) - 2 * d0 - d1) / 3 + t * (2 * (f0 - f1) + d0 + d1) / 4)));
}

// Both divide by the scale of the function, for the tolerance of the search is absolute.
float HermiteCubic::InvertValue(float y) const {
    const float scale = 1 / (f1 - f0);
    if (!std::isfinite(scale)) return 0;
    return FindRoot([&](float t) {
        const float slope = d0 + t * (2 * (3 * (f1 - f0) - 2 * d0 - d1) + t * 3 * (2 * (f0 - f1) + d0 + d1));
        return std::pair((Value(t) - y) * scale, slope * scale);
    });
}

float HermiteCubic::InvertIntegral(float y) const {
    const float scale = 1 / Integral(1);
    if (!std::isfinite(scale)) return 0;
    return FindRoot([&](float t) { return std::pair((Integral(t) - y) * scale, Value(t) * scale); });
}

std::optional<SplineWeights> CatmullRomWeights(std::span<const float> nodes, float x) {
    if (!(x >= nodes.front() && x <= nodes.back())) return std::nullopt;
    const int n = int(nodes.size());
    const int i = FindInterval(n, [&](int k) { return nodes[size_t(k)] <= x; });
    const float x0 = nodes[size_t(i)], x1 = nodes[size_t(i) + 1], width = x1 - x0;
    // The four Hermite polynomials; those of the slopes go to the nodes that the slopes are made of.
    const float t = (x - x0) / width, t2 = t * t, t3 = t2 * t;
    SplineWeights w{{std::max(i - 1, 0), i, i + 1, std::min(i + 2, n - 1)},
                    {0, 2 * t3 - 3 * t2 + 1, 3 * t2 - 2 * t3, 0}};
    const float slope0 = t3 - 2 * t2 + t, slope1 = t3 - t2;
    if (i > 0) {
        const float s = slope0 * width / (x1 - nodes[size_t(i) - 1]);
        w.weight[0] -= s;
        w.weight[2] += s;
    } else {
        w.weight[1] -= slope0;
        w.weight[2] += slope0;
    }
    if (i + 2 < n) {
        const float s = slope1 * width / (nodes[size_t(i) + 2] - x0);
        w.weight[1] -= s;
        w.weight[3] += s;
    } else {
        w.weight[1] -= slope1;
        w.weight[2] += slope1;
    }
    return w;
}

float IntegrateCatmullRom(std::span<const float> nodes, std::span<const float> values,
                          std::span<float> integrals) {
    const auto at = [&](int i) { return values[size_t(i)]; };
    double sum = 0;
    integrals[0] = 0;
    for (size_t i = 0; i + 1 < nodes.size(); ++i) {
        sum += double(CatmullRomPiece(nodes, at, int(i)).Integral(1) * (nodes[i + 1] - nodes[i]));
        integrals[i + 1] = float(sum);
    }
    return integrals.back();
}

float InvertCatmullRom(std::span<const float> nodes, std::span<const float> values, float y) {
    if (!(y > values.front())) return nodes.front();
    if (!(y < values.back())) return nodes.back();
    const int i = FindInterval(int(nodes.size()), [&](int k) { return values[size_t(k)] <= y; });
    const float t = CatmullRomPiece(
                        nodes, [&](int k) { return values[size_t(k)]; }, i)
                        .InvertValue(y);
    return Lerp(t, nodes[size_t(i)], nodes[size_t(i) + 1]);
}

}  // namespace lacquer
