// Small mixtures of Gaussians over the slopes of directions, and their products.
#pragma once

#include <array>

#include "pbrt/scattering/slope_gaussian.h"

namespace lacquer::gaussfit {

/// A mixture of at most kMax Gaussians; the weights are positive and sum to 1.
template <int kMax>
struct GaussianMixtureOf {
    std::array<Gaussian2, kMax> parts;
    std::array<float, kMax> weights{};
    int count = 0;

    GaussianMixtureOf() = default;
    explicit GaussianMixtureOf(const Gaussian2& single) : count(1) {
        parts[0] = single;
        weights[0] = 1;
    }

    /// Known at compile time where there is room for one only.
    int NumParts() const { return kMax == 1 ? 1 : count; }
    /// Density [per unit of slope area].
    float Pdf(Slope slope) const {
        if (NumParts() == 1) return parts[0].Pdf(slope);
        float sum = 0;
        for (int i = 0; i < count; ++i) sum += weights[size_t(i)] * parts[size_t(i)].Pdf(slope);
        return sum;
    }
    /// A slope drawn from it; u.x chooses the part, too. @param u  uniform in [0,1)^2
    Slope Sample(Point2 u) const {
        int i = 0;
        while (i + 1 < NumParts() && u.x >= weights[size_t(i)]) u.x -= weights[size_t(i++)];
        if (NumParts() > 1) u.x = std::clamp(u.x / weights[size_t(i)], 0.f, OneMinusEpsilon);
        return parts[size_t(i)].Sample(u);
    }
};

/// What approximates one lobe of an interface.
using GaussianMixture = GaussianMixtureOf<2>;
/// Of two of them.
using GaussianMixtureProduct = GaussianMixtureOf<4>;

using lacquer::Multiply;
/// The normalised product of two mixtures.
template <int kA, int kB>
GaussianMixtureOf<kA * kB> Multiply(const GaussianMixtureOf<kA>& a, const GaussianMixtureOf<kB>& b) {
    if (a.NumParts() == 1 && b.NumParts() == 1)
        return GaussianMixtureOf<kA * kB>(Multiply(a.parts[0], b.parts[0]));
    GaussianMixtureOf<kA * kB> product;
    std::array<float, kA * kB> exponents{};
    float largest = -Infinity;
    for (int i = 0; i < a.count; ++i) {
        for (int j = 0; j < b.count; ++j) {
            const size_t k = size_t(product.count++);
            const Gaussian2 &partA = a.parts[size_t(i)], &partB = b.parts[size_t(j)];
            product.parts[k] = Multiply(partA, partB);
            product.weights[k] = a.weights[size_t(i)] * b.weights[size_t(j)];
            exponents[k] = LogScaleOfProduct(partA, partB, product.parts[k]);
            largest = std::max(largest, exponents[k]);
        }
    }
    // Relative to the largest one: all may be too small for a float.
    float sum = 0;
    for (size_t k = 0; k < size_t(product.count); ++k)
        sum += product.weights[k] *= std::exp(exponents[k] - largest);
    for (size_t k = 0; k < size_t(product.count); ++k) product.weights[k] /= sum;
    return product;
}

/// Square of the distance of two mixtures' closest parts, in standard deviations of both together.
template <int kA, int kB>
float LeastDistance2(const GaussianMixtureOf<kA>& a, const GaussianMixtureOf<kB>& b) {
    float least = Infinity;
    for (int i = 0; i < a.count; ++i)
        for (int j = 0; j < b.count; ++j) {
            const Gaussian2 &partA = a.parts[size_t(i)], &partB = b.parts[size_t(j)];
            const Slope difference = partB.mean - partA.mean, pulled = partB.precision * difference;
            const CholeskyFactor both((partA.precision + partB.precision));
            least = std::min(least, Dot(partA.precision * both.Solve(pulled), difference));
        }
    return std::max(least, 0.f);
}

}  // namespace lacquer::gaussfit
