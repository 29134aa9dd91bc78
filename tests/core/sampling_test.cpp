#include "pbrt/core/sampling.h"

#include <gtest/gtest.h>

#include <functional>

#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::sampling_test {
namespace {

using test::ChiSquareTest;
using test::Outcome;
using test::Passes;

/// A warp of the unit square to a surface in space, and a chart of that surface over the unit square.
struct Warp {
    std::string name;
    std::function<Vec3(Point2)> sample;
    std::function<Point2(Vec3)> invert;
    std::function<float(Vec3)> pdf;  ///< over the surface's own area
    std::function<Vec3(Point2)> chart;
    std::function<Point2(Vec3)> chartInverse;
    float area;  ///< of the surface; every chart keeps areas up to this factor
};

Warp OnSphere(std::string name, float zMin, std::function<Vec3(Point2)> sample,
              std::function<Point2(Vec3)> invert, std::function<float(Vec3)> pdf) {
    const auto chart = [zMin](Point2 s) {
        const float z = Lerp(s.x, zMin, 1);
        return SphericalDirection(SafeSqrt(1 - z * z), z, 2 * Pi * s.y);
    };
    const auto inverse = [zMin](Vec3 w) {
        return Point2((w.z - zMin) / (1 - zMin), SphericalPhi(w) * Inv2Pi);
    };
    return {std::move(name), std::move(sample), std::move(invert),  std::move(pdf),
            chart,           inverse,           2 * Pi * (1 - zMin)};
}

Warp OnDisk(std::string name, Point2 (*sample)(Point2), Point2 (*invert)(Point2)) {
    const auto lift = [sample](Point2 u) { return Vec3(sample(u), 0); };
    const auto chart = [](Point2 s) {
        return std::sqrt(s.x) * Vec3(std::cos(2 * Pi * s.y), std::sin(2 * Pi * s.y), 0);
    };
    const auto inverse = [](Vec3 p) { return Point2(p.x * p.x + p.y * p.y, SphericalPhi(p) * Inv2Pi); };
    return {std::move(name),
            lift,
            [invert](Vec3 p) {
                return invert({p.x, p.y});
            },
            [](Vec3) { return PdfUniformDisk(); },
            chart,
            inverse,
            Pi};
}

Warp OnTriangle() {
    const auto flatten = [](Vec3 b) { return Vec3(b.x, b.y, 0); };
    return {"triangle",
            [flatten](Point2 u) { return flatten(SampleUniformTriangle(u)); },
            [](Vec3 p) {
                return InvertUniformTriangle({p.x, p.y, 1 - p.x - p.y});
            },
            [](Vec3) { return 2.f; },
            [](Point2 s) { return Vec3(1 - std::sqrt(s.x), s.y * std::sqrt(s.x), 0); },
            [](Vec3 p) { return Point2(Sqr(1 - p.x), p.x < 1 ? p.y / (1 - p.x) : 0.f); },
            0.5f};
}

Warp OnSquare(std::string name, std::array<float, 4> w) {
    return {std::move(name),
            [w](Point2 u) { return Vec3(SampleBilinear(u, w), 0); },
            [w](Vec3 p) {
                return InvertBilinear({p.x, p.y}, w);
            },
            [w](Vec3 p) {
                return PdfBilinear({p.x, p.y}, w);
            },
            [](Point2 s) { return Vec3(s, 0); },
            [](Vec3 p) { return Point2(p.x, p.y); },
            1};
}

std::vector<Warp> AllWarps() {
    const auto cone = [](std::string name, float cosMax) {
        return OnSphere(
            std::move(name), cosMax, [cosMax](Point2 u) { return SampleUniformCone(u, cosMax); },
            [cosMax](Vec3 w) { return InvertUniformCone(w, cosMax); },
            [cosMax](Vec3) { return PdfUniformCone(1 - cosMax); });
    };
    return {OnSphere("cosineHemisphere", 0, SampleCosineHemisphere, InvertCosineHemisphere,
                     [](Vec3 w) { return PdfCosineHemisphere(w.z); }),
            OnSphere("uniformHemisphere", 0, SampleUniformHemisphere, InvertUniformHemisphere,
                     [](Vec3) { return PdfUniformHemisphere(); }),
            OnSphere("uniformSphere", -1, SampleUniformSphere, InvertUniformSphere,
                     [](Vec3) { return PdfUniformSphere(); }),
            cone("cone", 0.7f),
            cone("wideCone", -0.4f),
            OnDisk("concentricDisk", SampleUniformDiskConcentric, InvertUniformDiskConcentric),
            OnDisk("polarDisk", SampleUniformDiskPolar, InvertUniformDiskPolar),
            OnTriangle(),
            OnSquare("bilinear", {1, 3, 0.5f, 2}),
            OnSquare("bilinearWithZeros", {0, 1, 0, 2}),
            OnSquare("bilinearFlat", {0, 0, 0, 0})};
}

/// Points away from the edges and from the diagonals, where the concentric map has its kinks.
std::vector<Point2> InnerPoints() {
    std::vector<Point2> points;
    for (int i = 1; i < 20; ++i)
        for (int j = 1; j < 20; ++j) {
            const Point2 u{(float(i) + 0.2f) / 20.5f, (float(j) + 0.37f) / 20.5f};
            if (std::abs(u.x - u.y) > 0.005f && std::abs(u.x + u.y - 1) > 0.005f) points.push_back(u);
        }
    return points;
}

TEST(Warps, InvertUndoesSample) {
    // Square roots near zero turn a rounding of 2^-24 into its root, so the bound is on the well-conditioned
    // inside.
    for (const Warp& warp : AllWarps())
        for (const Point2 u : InnerPoints()) {
            const Point2 back = warp.invert(warp.sample(u));
            EXPECT_NEAR(back.x, u.x, 2e-5f) << warp.name;
            EXPECT_NEAR(back.y, u.y, 2e-5f) << warp.name;
        }
}

TEST(Warps, PdfIsTheInverseJacobian) {
    // Central differences over h: truncation O(h^2), below 1e-3 on these points; rounding 2^-24/h = 6e-5 of a
    // unit.
    const float h = 1e-3f;
    for (const Warp& warp : AllWarps())
        for (const Point2 u : InnerPoints()) {
            const Vec3 du = (warp.sample(u + Point2(h, 0)) - warp.sample(u - Point2(h, 0))) / (2 * h);
            const Vec3 dv = (warp.sample(u + Point2(0, h)) - warp.sample(u - Point2(0, h))) / (2 * h);
            EXPECT_NEAR(Length(Cross(du, dv)) * warp.pdf(warp.sample(u)), 1, 5e-3f) << warp.name;
        }
}

TEST(Warps, PdfIntegratesToOne) {
    // Midpoint rule; every density is at most bilinear in the chart, and the cosine linear: exact but for
    // rounding.
    const int n = 128;
    for (const Warp& warp : AllWarps()) {
        double sum = 0;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                sum += double(warp.pdf(warp.chart({(float(i) + 0.5f) / n, (float(j) + 0.5f) / n})));
        EXPECT_NEAR(sum * double(warp.area) / (n * n), 1, 1e-4) << warp.name;
    }
}

/// Chi-square over 10 x 20 cells of the chart against pdf * (1 + tilt * (2 s.x - 1)), each cell by 4 x 4
/// midpoints.
Outcome CompareToPdf(const Warp& warp, float tilt, uint64_t seed) {
    const int nx = 10, ny = 20, sub = 4, numSamples = 400000;
    std::vector<double> observed(nx * ny), expected(nx * ny);
    Rng rng(seed);
    for (int i = 0; i < numSamples; ++i) {
        const Point2 s = warp.chartInverse(warp.sample(rng.Uniform2D()));
        const int x = std::clamp(int(s.x * nx), 0, nx - 1), y = std::clamp(int(s.y * ny), 0, ny - 1);
        observed[size_t(y * nx + x)] += 1;
    }
    for (int y = 0; y < ny * sub; ++y)
        for (int x = 0; x < nx * sub; ++x) {
            const Point2 s{(float(x) + 0.5f) / (nx * sub), (float(y) + 0.5f) / (ny * sub)};
            expected[size_t(y / sub * nx + x / sub)] +=
                double(warp.pdf(warp.chart(s)) * (1 + tilt * (2 * s.x - 1)) * warp.area) * numSamples /
                (nx * ny * sub * sub);
        }
    return ChiSquareTest(observed, expected);
}

TEST(Warps, SamplesFollowPdf) {
    const std::vector<Warp> warps = AllWarps();
    const double alpha = test::SidakAlpha(1e-3, int(warps.size()));
    for (const Warp& warp : warps)
        EXPECT_TRUE(Passes(test::FullTestName() + warp.name, alpha,
                           [&](uint64_t seed) { return CompareToPdf(warp, 0, seed); }));
}

TEST(Warps, ATiltedPdfIsFound) {
    // Power: 5 % of tilt shifts chi-square by 400000 * 0.05^2 / 3 = 330, 16 of its standard deviations (200
    // cells).
    for (const Warp& warp : AllWarps())
        EXPECT_LT(CompareToPdf(warp, 0.05f, test::SeedOf(warp.name)).pValue, 1e-9) << warp.name;
}

TEST(Warps, StayInTheirDomainAtTheCorners) {
    for (const Warp& warp : AllWarps())
        for (const float a : {0.f, 0.5f, OneMinusEpsilon})
            for (const float b : {0.f, 0.5f, OneMinusEpsilon}) {
                const Vec3 p = warp.sample({a, b});
                EXPECT_TRUE(IsFinite(p)) << warp.name;
                const Point2 s = warp.chartInverse(p);
                EXPECT_TRUE(s.x >= -1e-6f && s.x <= 1 + 1e-6f && s.y >= 0 && s.y <= 1 + 1e-6f) << warp.name;
            }
}

TEST(Warps, NarrowConeKeepsItsDigits) {
    // Half angle 1e-3: 1 - cos = 5e-7 is only 8 units in the last place of 1, the sines of the angles are
    // exact.
    const float cosMax = std::cos(1e-3f);
    const float sin2Max = (1 - cosMax) * (1 + cosMax);
    const Vec3 w = SampleUniformCone({0.25f, 0.1f}, cosMax);
    EXPECT_NEAR((w.x * w.x + w.y * w.y) / sin2Max, 0.25f, 1e-5f);
    EXPECT_NEAR(InvertUniformCone(w, cosMax).x, 0.25f, 1e-5f);
    EXPECT_EQ(SampleUniformCone({0.5f, 0.5f}, 1).z, 1);
}

TEST(Warps, OneDimensionalOnesAgreeWithTheirPdfs) {
    struct Line {
        float a, b;
    };
    const float h = 1e-3f;
    for (const Line line : {Line{1, 1}, Line{0, 2}, Line{3, 0.5f}, Line{2, 0}})
        for (float u = 0.02f; u < 0.98f; u += 0.013f) {
            const float x = SampleLinear(u, line.a, line.b);
            const float slope =
                (SampleLinear(u + h, line.a, line.b) - SampleLinear(u - h, line.a, line.b)) / (2 * h);
            EXPECT_NEAR(InvertLinear(x, line.a, line.b), u, 1e-5f);
            EXPECT_NEAR(slope * PdfLinear(x, line.a, line.b), 1, 5e-3f);
        }
    for (const float r : {0.5f, 2.f, 7.f})
        for (float u = 0.02f; u < 0.98f; u += 0.013f) {
            const float x = SampleTent(u, r), slope = (SampleTent(u + h, r) - SampleTent(u - h, r)) / (2 * h);
            EXPECT_NEAR(InvertTent(x, r), u, 1e-5f);
            const bool isKink = std::abs(u - 0.5f) <= h;
            EXPECT_TRUE(isKink || std::abs(slope * PdfTent(x, r) - 1) < 5e-3f);
        }
    EXPECT_EQ(PdfTent(2, 2), 0);
    EXPECT_EQ(SampleTent(0, 2), -2);
}

/// How often each index comes up, and how its remapped numbers spread over four bins, for equally spaced u.
template <class Draw>
void CheckDiscrete(const std::vector<float>& weights, const Draw& draw) {
    const int n = 1 << 20;
    double sum = 0;
    for (const float w : weights) sum += double(w);
    std::vector<std::array<int, 4>> counts(weights.size());
    for (int i = 0; i < n; ++i) {
        float pmf, remapped;
        const int index = draw((float(i) + 0.5f) / n, &pmf, &remapped);
        ASSERT_TRUE(index >= 0 && index < int(weights.size()));
        ASSERT_TRUE(remapped >= 0 && remapped < 1);
        ASSERT_NEAR(pmf, double(weights[size_t(index)]) / sum, 1e-6);
        ++counts[size_t(index)][size_t(remapped * 4)];
    }
    // An index owns at most one interval of u for each bin: a count is wrong by one at each of their ends,
    // and by rounding.
    for (size_t i = 0; i < weights.size(); ++i)
        for (const int count : counts[i]) {
            EXPECT_TRUE(weights[i] > 0 || count == 0);
            EXPECT_NEAR(count, n * double(weights[i]) / sum / 4, 2.0 * double(weights.size()) + 4);
        }
}

const std::vector<std::vector<float>> kWeights = {
    {1}, {0, 1}, {1, 0, 0}, {0, 3, 0, 0, 1, 0.25f, 0}, {1, 1, 1, 1, 1, 1, 1}, {1e-3f, 1000, 3, 0, 500}};

TEST(SampleDiscrete, FollowsTheWeights) {
    for (const auto& weights : kWeights)
        CheckDiscrete(weights, [&](float u, float* pmf, float* remapped) {
            return SampleDiscrete(weights, u, pmf, remapped);
        });
}

TEST(SampleDiscrete, NoWeightsGiveNoIndex) {
    EXPECT_EQ(SampleDiscrete({}, 0.5f), -1);
    EXPECT_EQ(SampleDiscrete(std::vector<float>{0, 0}, 0.5f), -1);
}

TEST(AliasTable, FollowsTheWeights) {
    for (const auto& weights : kWeights) {
        const AliasTable table(weights);
        CheckDiscrete(weights,
                      [&](float u, float* pmf, float* remapped) { return table.Sample(u, pmf, remapped); });
        double sum = 0;
        for (int i = 0; i < table.Size(); ++i) sum += double(table.Pmf(i));
        EXPECT_NEAR(sum, 1, 1e-6);
    }
}

TEST(AliasTable, WithoutWeightsIsUniformOrEmpty) {
    EXPECT_EQ(AliasTable().Sample(0.5f), -1);
    const AliasTable table(std::vector<float>{0, 0, 0, 0});
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(table.Pmf(i), 0.25f);
        EXPECT_EQ(table.Sample((float(i) + 0.5f) / 4), i);
    }
}

const std::vector<float> kRow = {0, 0, 2, 0, 1, 5, 0, 0.5f, 0};

TEST(PiecewiseConstant1D, SampleInvertAndPdfAgree) {
    const PiecewiseConstant1D f(kRow, -1, 2);
    EXPECT_NEAR(f.Integral(), 8.5f * 3 / 9, 1e-6f);
    const int n = 10000;
    for (int i = 0; i < n; ++i) {
        const float u = (float(i) + 0.5f) / n;
        float pdf;
        int cell;
        const float x = f.Sample(u, &pdf, &cell);
        ASSERT_GT(kRow[size_t(cell)], 0);
        ASSERT_EQ(pdf, f.Pdf(x));
        ASSERT_NEAR(pdf, kRow[size_t(cell)] / f.Integral(), 1e-6f);
        ASSERT_NEAR(f.Invert(x), u, 1e-5f);
    }
}

TEST(PiecewiseConstant1D, NeverDrawsZeroCells) {
    // At and next to every value of the cumulative distribution, where rounding could lead astray.
    const PiecewiseConstant1D f(kRow, -1, 2);
    std::vector<float> us = {0, OneMinusEpsilon};
    for (const float edge : {2 / 8.5f, 3 / 8.5f, 8 / 8.5f})
        for (float u = edge - 4e-7f; u < edge + 4e-7f; u = std::nextafter(u, 1.f)) us.push_back(u);
    for (const float u : us) {
        const float x = f.Sample(u);
        EXPECT_TRUE(x >= -1 && x <= 2);
        EXPECT_GT(f.Pdf(x), 0) << u;
    }
}

TEST(PiecewiseConstant1D, AllZeroIsUniform) {
    const PiecewiseConstant1D f(std::vector<float>{0, 0, 0}, 1, 3);
    EXPECT_EQ(f.Integral(), 0);
    for (float u = 0; u < 1; u += 0.01f) {
        float pdf;
        EXPECT_NEAR(f.Sample(u, &pdf), 1 + 2 * u, 1e-6f);
        EXPECT_EQ(pdf, 0.5f);
        EXPECT_EQ(f.Pdf(1 + 2 * u), 0.5f);
    }
    EXPECT_EQ(f.Pdf(0.5f), 0);
}

TEST(PiecewiseConstant1D, NanAndHugeValuesStayFinite) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const PiecewiseConstant1D f(std::vector<float>{nan, Infinity, 1e38f, -1});
    for (float u = 0; u < 1; u += 0.01f) {
        float pdf;
        const float x = f.Sample(u, &pdf);
        EXPECT_TRUE(x >= 0.25f && x <= 0.75f && std::isfinite(pdf));
    }
}

class PiecewiseConstant2DTest : public testing::Test {
  protected:
    static constexpr int kNx = 6, kNy = 4;
    const std::vector<float> values_ = {0, 1, 2, 0, 4, 0, 0, 0,    0, 0, 0, 0,
                                        3, 0, 0, 1, 1, 2, 0, 0.1f, 0, 7, 0, 0};
    const PiecewiseConstant2D f_{values_, kNx, kNy, {-1, 0}, {2, 1}};

    Outcome Compare(double scaleOfOne, uint64_t seed) const {
        const int numSamples = 100000;
        std::vector<double> observed(values_.size()), expected;
        Rng rng(seed);
        for (int i = 0; i < numSamples; ++i) {
            Int2 cell;
            f_.Sample(rng.Uniform2D(), nullptr, &cell);
            observed[size_t(cell.y * kNx + cell.x)] += 1;
        }
        for (const float value : values_) expected.push_back(double(value) / 21.1 * numSamples);
        expected[2] *= scaleOfOne;
        return ChiSquareTest(observed, expected);
    }
};

TEST_F(PiecewiseConstant2DTest, SamplesFollowTheValues) {
    EXPECT_TRUE(Passes(test::FullTestName(), 1e-4, [&](uint64_t seed) { return Compare(1, seed); }));
    // Negative control: 10 % less of a cell with 9500 samples is 9.7 standard deviations of it.
    EXPECT_LT(Compare(0.9, test::SeedOf(test::FullTestName())).pValue, 1e-9);
}

TEST_F(PiecewiseConstant2DTest, SampleInvertAndPdfAgree) {
    EXPECT_EQ(f_.Resolution(), Int2(kNx, kNy));
    EXPECT_NEAR(f_.Integral(), 21.1f * 3 / 24, 1e-5f);
    for (float ux = 0.0003f; ux < 1; ux += 0.0171f)
        for (float uy = 0.0007f; uy < 1; uy += 0.0171f) {
            float pdf;
            Int2 cell;
            const Point2 p = f_.Sample({ux, uy}, &pdf, &cell), u = f_.Invert(p);
            const float value = values_[size_t(cell.y * kNx + cell.x)];
            ASSERT_GT(value, 0);
            ASSERT_NEAR(pdf, value / f_.Integral(), 1e-5f * pdf);
            ASSERT_NEAR(f_.Pdf(p), pdf, 1e-5f * pdf);
            ASSERT_NEAR(u.x, ux, 1e-5f);
            ASSERT_NEAR(u.y, uy, 1e-5f);
        }
    EXPECT_EQ(f_.Pdf({-1.1f, 0.5f}), 0);
}

TEST_F(PiecewiseConstant2DTest, AllZeroIsUniform) {
    const PiecewiseConstant2D zero(std::vector<float>(6), 3, 2, {0, 0}, {2, 2});
    float pdf;
    const Point2 p = zero.Sample({0.25f, 0.75f}, &pdf);
    EXPECT_NEAR(p.x, 0.5f, 1e-6f);
    EXPECT_NEAR(p.y, 1.5f, 1e-6f);
    EXPECT_EQ(pdf, 0.25f);
}

}  // namespace
}  // namespace lacquer::sampling_test
