// Splines against what they must reproduce, and against sums of small steps.
#include "pbrt/scattering/catmull_rom.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace lacquer::catmull_rom_test {
namespace {

const std::vector<float> kNodes = {0, 0.1f, 0.4f, 0.5f, 1.2f, 3, 3.5f};

template <class Function>
std::vector<float> AtNodes(const Function& f) {
    std::vector<float> values;
    for (const float x : kNodes) values.push_back(f(x));
    return values;
}

float SplineAt(const std::vector<float>& values, float x) {
    const std::optional<SplineWeights> w = CatmullRomWeights(kNodes, x);
    EXPECT_TRUE(w) << x;
    return w ? w->Sum([&](int i) { return values[size_t(i)]; }) : 0;
}

TEST(CatmullRom, PassesThroughItsNodesAndReproducesLines) {
    const std::vector<float> line = AtNodes([](float x) { return 3 - 2 * x; });
    const std::vector<float> curve = AtNodes([](float x) { return std::sin(x); });
    for (size_t i = 0; i < kNodes.size(); ++i) EXPECT_NEAR(SplineAt(curve, kNodes[i]), curve[i], 1e-6f);
    for (float x = 0; x <= 3.5f; x += 0.01f) EXPECT_NEAR(SplineAt(line, x), 3 - 2 * x, 2e-6f);
}

// The slope at an inner node is that of the chord between its neighbours.
TEST(CatmullRom, IsSmoothAtItsNodes) {
    const std::vector<float> values = AtNodes([](float x) { return std::sin(2 * x); });
    for (size_t i = 1; i + 1 < kNodes.size(); ++i) {
        constexpr float h = 1e-3f;
        const float chord = (values[i + 1] - values[i - 1]) / (kNodes[i + 1] - kNodes[i - 1]);
        const float right = (SplineAt(values, kNodes[i] + h) - values[i]) / h;
        const float left = (values[i] - SplineAt(values, kNodes[i] - h)) / h;
        // The second derivative of these pieces is below 60.
        EXPECT_NEAR(right, chord, 60 * h) << i;
        EXPECT_NEAR(left, chord, 60 * h) << i;
    }
}

TEST(CatmullRom, HasNoValueOutside) {
    for (const float x :
         {-1e-6f, 3.51f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
        EXPECT_FALSE(CatmullRomWeights(kNodes, x)) << x;
}

TEST(CatmullRom, PiecesAndWeightsAreOneCurve) {
    const std::vector<float> values = AtNodes([](float x) { return std::exp(-x) * x; });
    for (int i = 0; i + 1 < int(kNodes.size()); ++i)
        for (const float t : {0.f, 0.25f, 0.5f, 0.9f}) {
            const float x = kNodes[size_t(i)] + t * (kNodes[size_t(i) + 1] - kNodes[size_t(i)]);
            const HermiteCubic piece = CatmullRomPiece(
                kNodes, [&](int k) { return values[size_t(k)]; }, i);
            EXPECT_NEAR(piece.Value(t), SplineAt(values, x), 1e-6f);
        }
}

// Midpoint rule, 4000 steps: error below 1e-6 for curves with second derivatives below 10.
TEST(CatmullRom, IntegratesItself) {
    const std::vector<float> values = AtNodes([](float x) { return 1 + std::sin(x); });
    std::vector<float> integrals(kNodes.size());
    IntegrateCatmullRom(kNodes, values, integrals);
    double sum = 0;
    size_t node = 1;
    constexpr int kSteps = 3500 * 4;
    for (int i = 0; i < kSteps; ++i) {
        const double h = 3.5 / kSteps;
        sum += double(SplineAt(values, float((i + 0.5) * h))) * h;
        const bool atNode = node < kNodes.size() && std::abs((i + 1) * h - double(kNodes[node])) < 0.5 * h;
        if (atNode) {
            EXPECT_NEAR(integrals[node], sum, 1e-4 * sum);
            ++node;
        }
    }
    EXPECT_EQ(node, kNodes.size());
}

TEST(CatmullRom, InvertsIncreasingValues) {
    const std::vector<float> values = AtNodes([](float x) { return x * x + x; });
    for (float y = 0; y < 15.75f; y += 0.05f) {
        const float x = InvertCatmullRom(kNodes, values, y);
        EXPECT_NEAR(SplineAt(values, x), y, 2e-6f * (1 + y));
    }
    EXPECT_EQ(InvertCatmullRom(kNodes, values, -1), 0);
    EXPECT_EQ(InvertCatmullRom(kNodes, values, 100), 3.5f);
}

TEST(CatmullRom, InvertsIntegrals) {
    const HermiteCubic piece{1, 4, -2, 3};
    for (float t = 0; t <= 1; t += 0.03125f) EXPECT_NEAR(piece.InvertIntegral(piece.Integral(t)), t, 1e-5f);
}

}  // namespace
}  // namespace lacquer::catmull_rom_test
