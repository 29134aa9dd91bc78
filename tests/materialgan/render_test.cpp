// The model of photographs as tensor operations, against the formulas one texel at a time.
#include "materialgan/network/torch_render.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "capture/svbrdf/dual.h"
#include "capture/svbrdf/svbrdf_model.h"

namespace lacquer::materialgan::render_test {
namespace {

using Vector = std::array<double, 3>;

double DotOf(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector UnitOf(Vector v) {
    const double length = std::sqrt(DotOf(v, v));
    for (double& x : v) x /= length;
    return v;
}

/// Linear value of a texel at a point in one colour, straight from the formulas of the paper.
double LinearValueOf(const std::array<double, 9>& t, size_t color, const Vector& p, const Vector& camera,
                     const Vector& light, double power) {
    constexpr double kPi = std::numbers::pi, kEpsilon = 1e-6;
    const auto linear = [](double stored) { return std::pow((stored + 1) / 2, 2.2); };
    const double a = linear(t[color]), r = linear(t[5]), s = linear(t[6 + color]);
    const Vector n = UnitOf({t[3], t[4], std::sqrt(1 - t[3] * t[3] - t[4] * t[4])});
    const Vector toLight{light[0] - p[0], light[1] - p[1], light[2] - p[2]};
    const Vector v = UnitOf({camera[0] - p[0], camera[1] - p[1], camera[2] - p[2]}), l = UnitOf(toLight);
    const Vector h = UnitOf({v[0] + l[0], v[1] + l[1], v[2] + l[2]});
    const auto positive = [](double c) { return std::max(c, 0.); };
    const double nv = positive(DotOf(n, v)), nl = positive(DotOf(n, l)), nh = positive(DotOf(n, h)),
                 vh = positive(DotOf(v, h));
    const double alpha = r * r, core = nh * nh * (alpha * alpha - 1) + 1;
    const double d = alpha * alpha / (kPi * core * core + kEpsilon);
    const double f = s + (1 - s) * std::pow(2., (-5.55473 * vh - 6.98316) * vh), k = alpha / 2 + kEpsilon;
    const double g = nv / (nv * (1 - k) + k) * nl / (nl * (1 - k) + k);
    return power * (a * (1 - s) / kPi + d * f * g / (4 * nv * nl + kEpsilon)) * nl / DotOf(toLight, toLight);
}

capture::ViewSet TwoViews() {
    capture::ViewSet set;
    set.size = 8;
    set.lightPower = {1500, 1200, 900};
    set.views = {{"", {1, 2, 15}, {1, 2, 15}, false}, {"", {-2, 0, 16}, {5, -3, 11}, false}};
    return set;
}

/// Numbers in (-0.7,0.7), so that normals have a z.
Tensor SomeMaps(int size) {
    return 1.4 * torch::rand({1, 9, size, size}, SeededGenerator(3), torch::TensorOptions(torch::kFloat)) -
           0.7;
}

TEST(TorchRender, IsThePapersModel) {
    constexpr int kSize = 4;
    const capture::ViewSet set = TwoViews();
    const Tensor maps = SomeMaps(kSize), rendered = RenderLinear(maps, ViewsOf(set, false));
    ASSERT_EQ(rendered.sizes(), (torch::IntArrayRef{1, 2, 3, kSize, kSize}));
    for (int view = 0; view < 2; ++view)
        for (int row = 0; row < kSize; ++row)
            for (int column = 0; column < kSize; ++column) {
                std::array<double, 9> t;
                for (int c = 0; c < 9; ++c) t[size_t(c)] = maps[0][c][row][column].item<double>();
                const Vector p{((column + 0.5) / kSize - 0.5) * set.size,
                               -((row + 0.5) / kSize - 0.5) * set.size, 0};
                const auto& v = set.views[size_t(view)];
                for (size_t c = 0; c < 3; ++c) {
                    const double wanted = LinearValueOf(t, c, p, v.camera, v.light, set.lightPower[c]);
                    // D is the worst: of numbers near 1, roundings of 6e-8 are multiplied by 1 / alpha^2.
                    EXPECT_NEAR(rendered[0][view][int64_t(c)][row][column].item<double>(), wanted,
                                1e-4 * wanted);
                }
            }
}

TEST(TorchRender, GradientsAreThoseOfDifferences) {
    const TorchViews views = ViewsOf(TwoViews(), false);
    Tensor maps = SomeMaps(4).to(torch::kDouble).requires_grad_();
    const TorchViews precise{views.camera.to(torch::kDouble), views.light.to(torch::kDouble),
                             views.power.to(torch::kDouble), views.size};
    const auto value = [&](const Tensor& m) { return RenderEncoded(m, precise).sum(); };
    value(maps).backward();
    for (const int64_t index : {3, 20, 50, 57, 70, 85, 100, 120, 143}) {
        constexpr double kStep = 1e-6;
        Tensor more = maps.detach().clone(), less = more.clone();
        more.view(-1)[index] += kStep;
        less.view(-1)[index] -= kStep;
        const double slope = (value(more) - value(less)).item<double>() / (2 * kStep);
        EXPECT_NEAR(maps.grad().view(-1)[index].item<double>(), slope, 1e-5 * std::abs(slope) + 1e-7)
            << index;
    }
}

// Single precision by autograd, as fits take it, against dual numbers through the model of src/capture, for
// each colour of each photograph by all nine values of each texel.
TEST(TorchRender, GradientsAreThoseOfDualNumbers) {
    constexpr int kSize = 4;
    using Nonuple = capture::Dual<capture::kNumChannels>;
    const capture::ViewSet set = TwoViews();
    const TorchViews views = ViewsOf(set, false);
    int compared = 0;
    for (int64_t view = 0; view < 2; ++view)
        for (int64_t color = 0; color < 3; ++color) {
            Tensor maps = SomeMaps(kSize).requires_grad_();
            // Texels have nothing to do with each other: the sum has the derivatives of each.
            RenderEncoded(maps, views)[0][view][color].sum().backward();
            for (int row = 0; row < kSize; ++row)
                for (int column = 0; column < kSize; ++column) {
                    capture::StoredTexel<Nonuple> t;
                    for (size_t c = 0; c < 9; ++c)
                        t[c] = Nonuple::Unknown(maps[0][int64_t(c)][row][column].item<double>(), c);
                    const auto& v = set.views[size_t(view)];
                    const capture::TexelGeometry g =
                        capture::GeometryAt(capture::TexelX(column, kSize, set.size),
                                            capture::TexelY(row, kSize, set.size), v.camera, v.light);
                    const Nonuple wanted = capture::EncodedValue(t, g, set.lightPower)[size_t(color)];
                    if (wanted.value >= 1) continue;  // beyond white each has a slope of its own
                    for (size_t c = 0; c < 9; ++c) {
                        const double found = maps.grad()[0][int64_t(c)][row][column].item<double>();
                        EXPECT_NEAR(found, wanted.by[c], 1e-4 * std::max(1., std::abs(wanted.by[c])));
                        compared += wanted.by[c] != 0;
                    }
                }
        }
    EXPECT_GT(compared, 200);
}

// At the ends of the ranges, and for normals beyond the rim.
TEST(TorchRender, GradientsAreFinite) {
    for (const float extreme : {-1.f, 1.f, 2.f}) {
        Tensor maps = torch::full({1, 9, 4, 4}, extreme).requires_grad_();
        RenderEncoded(maps, ViewsOf(TwoViews(), false)).sum().backward();
        EXPECT_TRUE(maps.grad().isfinite().all().item<bool>()) << extreme;
    }
}

TEST(TorchRender, ClampsRoughnessToItsRange) {
    GeneratorConfig config;
    config.roughnessRange = {-0.5, 0.5};
    const Tensor maps = torch::full({1, 9, 2, 2}, 3.f), clamped = ClampMaps(maps, config);
    EXPECT_EQ(clamped[0][5].max().item<float>(), 0.5f);
    EXPECT_EQ(clamped[0][4].max().item<float>(), 1.f);
    EXPECT_NEAR(SoftClampMaps(maps, config)[0][4].max().item<float>(), 1.02f, 1e-6f);
}

}  // namespace
}  // namespace lacquer::materialgan::render_test
