// The model against the formulas written down once more, and its derivatives against Ceres' and differences.
#include "capture/svbrdf/svbrdf_model.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "capture/svbrdf/dual.h"
#include "capture/svbrdf/made_maps.h"

namespace lacquer::capture::svbrdf_model_test {
namespace {

using Stored = StoredTexel<double>;
using Nonuple = Dual<kNumChannels>;
using Jet = ceres::Jet<double, int(kNumChannels)>;

struct Vector {
    double x, y, z;
    Vector operator+(Vector b) const { return {x + b.x, y + b.y, z + b.z}; }
    Vector operator-(Vector b) const { return {x - b.x, y - b.y, z - b.z}; }
    double Length() const { return std::sqrt(x * x + y * y + z * z); }
    Vector Unit() const { return {x / Length(), y / Length(), z / Length()}; }
};
double Cosine(Vector a, Vector b) { return std::max(a.x * b.x + a.y * b.y + a.z * b.z, 0.); }

/// The same from the paper's formulas, as one would write them for one pixel and one channel.
double PlainValue(const Stored& t, size_t channel, Vector p, Vector camera, Vector light, double power) {
    const double e = 1e-6;
    const double a = std::pow((t[channel] + 1) / 2, 2.2), s = std::pow((t[6 + channel] + 1) / 2, 2.2);
    const double r = std::pow((t[5] + 1) / 2, 2.2), alpha = r * r, alpha2 = alpha * alpha;
    const double xy2 = std::min(std::max(t[3] * t[3] + t[4] * t[4], 0.), 1 - e);
    const Vector n = Vector{t[3], t[4], std::sqrt(1 - xy2)}.Unit();
    const Vector v = (camera - p).Unit(), l = (light - p).Unit(), h = (v + l).Unit();
    const double d = (light - p).Length(), nv = Cosine(n, v), nl = Cosine(n, l), nh = Cosine(n, h),
                 vh = Cosine(v, h);
    const double D = alpha2 / (M_PI * std::pow(nh * nh * (alpha2 - 1) + 1, 2) + e);
    const double F = s + (1 - s) * std::pow(2, (-5.55473 * vh - 6.98316) * vh);
    const double k = alpha / 2 + e, G = nv / (nv * (1 - k) + k) * nl / (nl * (1 - k) + k);
    const double f = a * (1 - s) / M_PI + D * F * G / (4 * nv * nl + e);
    return std::pow(std::min(std::max(power * f * nl / (d * d), e), 1.), 1 / 2.2);
}

/// Texels that are ordinary, and those at the ends of what is stored.
std::vector<Stored> Texels() {
    std::vector<Stored> texels;
    const Maps maps = test::RandomMaps(8, 1);
    for (size_t i = 0; i < maps.NumTexels(); ++i) {
        Stored t;
        for (size_t c = 0; c < kNumChannels; ++c) t[c] = maps.Channel(c)[i];
        texels.push_back(t);
    }
    const Stored middle{0.1, 0, -0.2, 0.1, -0.2, 0.3, -0.4, -0.3, -0.5};
    for (const double alpha : {-0.98, -0.6, 1.}) {
        texels.push_back(middle);
        texels.back()[kRoughness] = alpha;
    }
    for (const double tilt : {0.9, 0.99, -0.7}) {  // grazing; the last leaves the unit circle together with y
        texels.push_back(middle);
        texels.back()[kNormal] = tilt;
        texels.back()[kNormal + 1] = tilt < 0 ? 0.9 : 0.05;
    }
    return texels;
}

const Point kCamera{2.5, -1, 16}, kLight{-6, 6, 10};
constexpr std::array<double, 3> kPower{1500, 1400, 900};
struct Place {
    double x, y;
    Point camera, light;
};
const std::vector<Place> kPlaces = {
    {1.2, -2.1, kCamera, kCamera}, {-3, 0.4, kCamera, kLight}, {0, 0, {0, 0, 16}, {0, 0, 16}}};

Vector VectorOf(const Point& p) { return {p[0], p[1], p[2]}; }

TEST(SvbrdfModel, IsThePublishedFormulas) {
    for (const Stored& t : Texels())
        for (const Place& at : kPlaces) {
            const auto value = EncodedValue(t, GeometryAt(at.x, at.y, at.camera, at.light), kPower);
            for (size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(
                    value[c],
                    PlainValue(t, c, {at.x, at.y, 0}, VectorOf(at.camera), VectorOf(at.light), kPower[c]),
                    1e-12);
        }
}

// A value beside a step may fall on either side of it by rounding, and no other.
TEST(SvbrdfModel, TruncatedImagesAgreeWithinAStep) {
    const ViewSet views = test::GridViews(3);
    const Maps maps = test::MadeMaps(32, test::Pattern::Tiles, 3);
    for (const View& view : views.views) {
        const RectifiedImage image = RenderView(maps, views, view);
        for (size_t i = 0; i < maps.NumTexels(); ++i) {
            Stored t;
            for (size_t c = 0; c < kNumChannels; ++c) t[c] = maps.Channel(c)[i];
            const Vector p{(double(i % 32) + 0.5 - 16) / 32 * views.size,
                           -(double(i / 32) + 0.5 - 16) / 32 * views.size, 0};
            for (size_t c = 0; c < 3; ++c) {
                const double plain =
                    PlainValue(t, c, p, VectorOf(view.camera), VectorOf(view.light), views.lightPower[c]);
                ASSERT_LE(std::abs(std::floor(255 * image.Channel(c)[i]) - std::floor(255 * plain)), 1);
            }
        }
    }
}

TEST(SvbrdfModel, AnErrorOfAPercentShows) {
    const Place& at = kPlaces[1];
    Stored t = Texels().front();
    const double before =
        PlainValue(t, 0, {at.x, at.y, 0}, VectorOf(at.camera), VectorOf(at.light), kPower[0]);
    t[kRoughness] += 0.02;
    const auto value = EncodedValue(t, GeometryAt(at.x, at.y, at.camera, at.light), kPower);
    EXPECT_GT(std::abs(value[0] - before), 1e-4);
}

// Both work by the chain rule, in other orders of sums.
TEST(SvbrdfModel, DualNumbersAgreeWithJets) {
    for (const Stored& t : Texels())
        for (const Place& at : kPlaces) {
            StoredTexel<Nonuple> dual;
            StoredTexel<Jet> jet;
            for (size_t c = 0; c < kNumChannels; ++c) {
                dual[c] = Nonuple::Unknown(t[c], c);
                jet[c] = Jet(t[c], int(c));
            }
            const TexelGeometry g = GeometryAt(at.x, at.y, at.camera, at.light);
            const auto byDual = EncodedValue(dual, g, kPower);
            const auto byJet = EncodedValue(jet, g, kPower);
            for (size_t c = 0; c < 3; ++c)
                for (size_t i = 0; i < kNumChannels; ++i)
                    EXPECT_NEAR(byDual[c].by[i], byJet[c].v[Eigen::Index(i)],
                                1e-10 * (1 + std::abs(byDual[c].by[i])));
        }
}

// Where nothing is clamped: differences know no sides. Those of five points have an error of step^4, and
// rounding of 1e-16 over the step.
TEST(SvbrdfModel, DualNumbersAgreeWithDifferences) {
    constexpr double kStep = 1e-4;
    int numCompared = 0;
    for (const Stored& t : Texels())
        for (const Place& at : kPlaces) {
            const TexelGeometry g = GeometryAt(at.x, at.y, at.camera, at.light);
            for (size_t i = 0; i < kNumChannels; ++i) {
                const auto value = [&](double change) {
                    StoredTexel<Nonuple> dual;
                    for (size_t c = 0; c < kNumChannels; ++c)
                        dual[c] = Nonuple::Unknown(t[c] + (c == i ? change : 0), c);
                    return EncodedValue(dual, g, kPower)[0];
                };
                const Nonuple v = value(0);
                const double xy2 = t[kNormal] * t[kNormal] + t[kNormal + 1] * t[kNormal + 1];
                if (v.value >= 1 || v.value < 0.01 || std::abs(t[i]) > 0.99 || xy2 > 0.95) continue;
                const double difference = (8 * (value(kStep).value - value(-kStep).value) -
                                           (value(2 * kStep).value - value(-2 * kStep).value)) /
                                          (12 * kStep);
                EXPECT_NEAR(v.by[i], difference, 1e-4 * std::abs(difference) + 1e-8);
                ++numCompared;
            }
        }
    EXPECT_GT(numCompared, 500);
}

TEST(SvbrdfModel, IsFiniteAtTheEndsOfEverything) {
    for (const double end : {-1., 1.})
        for (size_t i = 0; i < kNumChannels; ++i)
            for (const Place& at : kPlaces) {
                StoredTexel<Nonuple> t;
                for (size_t c = 0; c < kNumChannels; ++c) t[c] = Nonuple::Unknown(c == i ? end : 0.1, c);
                for (const Nonuple& v :
                     EncodedValue(t, GeometryAt(at.x, at.y, at.camera, at.light), kPower)) {
                    EXPECT_TRUE(std::isfinite(v.value));
                    for (const double by : v.by) EXPECT_TRUE(std::isfinite(by));
                }
            }
}

TEST(SvbrdfModel, StoredValuesRoundTrip) {
    for (const double linear : {0., 0.01, 0.2, 0.5, 1.})
        EXPECT_NEAR(LinearOf(StoredOf(linear)), linear, 1e-15);
}

}  // namespace
}  // namespace lacquer::capture::svbrdf_model_test
