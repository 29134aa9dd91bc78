// Smooth curves through values at uneven places: Catmull-Rom splines, their integrals and inverses.
#pragma once

#include <optional>
#include <span>

namespace lacquer {

/// The value at a place is the sum of weight[i] * value[index[i]]. Weights sum to 1; indices are always
/// valid.
struct SplineWeights {
    int index[4];
    float weight[4];

    /// The sum over values at(index).
    template <class Function>
    float Sum(const Function& at) const {
        return weight[0] * at(index[0]) + weight[1] * at(index[1]) + weight[2] * at(index[2]) +
               weight[3] * at(index[3]);
    }
};

/// A cubic on [0,1] by its values and derivatives at the ends.
struct HermiteCubic {
    float f0, f1, d0, d1;

    float Value(float t) const;
    /// Integral from 0 to t.
    float Integral(float t) const;
    /// t with Value(t) = y, between the ends. y should lie between the values at the ends; else the nearer
    /// end.
    float InvertValue(float y) const;
    /// t with Integral(t) = y, likewise.
    float InvertIntegral(float y) const;
};

/// Weights of the spline at x over strictly increasing nodes (at least 2). Slopes at inner nodes are those of
/// the chord between their neighbours; at the ends, of the one interval there. Empty outside of the nodes,
/// and for NaN.
std::optional<SplineWeights> CatmullRomWeights(std::span<const float> nodes, float x);

/// The piece of the spline between nodes i and i + 1, over t in [0,1]; values at(index) at the nodes.
template <class Function>
HermiteCubic CatmullRomPiece(std::span<const float> nodes, const Function& at, int i) {
    const size_t n = nodes.size(), k = size_t(i);
    const float width = nodes[k + 1] - nodes[k], f0 = at(i), f1 = at(i + 1);
    const float d0 = k > 0 ? width * (f1 - at(i - 1)) / (nodes[k + 1] - nodes[k - 1]) : f1 - f0;
    const float d1 = k + 2 < n ? width * (at(i + 2) - f0) / (nodes[k + 2] - nodes[k]) : f1 - f0;
    return {f0, f1, d0, d1};
}

/// Writes the spline's integral from the first node to each node, and returns the last one.
float IntegrateCatmullRom(std::span<const float> nodes, std::span<const float> values,
                          std::span<float> integrals);

/// x at which the spline through strictly increasing values has the value y; the nearer end outside.
float InvertCatmullRom(std::span<const float> nodes, std::span<const float> values, float y);

}  // namespace lacquer
