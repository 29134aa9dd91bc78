// Lobes of the tables against moments of the functions that they were fitted to, by sampling.
#include <gtest/gtest.h>

#include <cmath>

#include "gaussfit/lobe/lobe_models.h"
#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/dielectric.h"
#include "support/statistics.h"

namespace lacquer::gaussfit::test::find_lobe_test {

using namespace lacquer::test;

namespace {

/// One query.
struct Point {
    const LobeModel* model;
    float alpha, eta;
    Vec3 w;

    MicrofacetSurface Surface() const { return {model->distribution, alpha, alpha, 0}; }
    bool Find(GaussianMixture* lobe) const { return FindLobe(Surface(), model->event, eta, w, lobe); }
};

/// A point inside of the tables' range, azimuth and sign of z included.
Point RandomPoint(const LobeModel& model, Rng& rng) {
    const float alpha = 0.005f * std::pow(200.f, rng.Uniform());
    const float index = Lerp(rng.Uniform(), 1.06f, 2.49f), angle = Radians(87.9f) * rng.Uniform();
    const float phi = 2 * Pi * rng.Uniform();
    float theta = angle;
    // By the refracted angle, up to 80 degrees: the table ends at a sine of 0.995, which is 84.
    if (model.event == LobeEvent::Leaving) theta = std::asin(std::sin(angle * 80 / 88) / index);
    const float side = rng.Uniform() < 0.5f ? 1.f : -1.f;
    return {&model, alpha, model.event == LobeEvent::Leaving ? 1 / index : index,
            side * SphericalDirection(std::sin(theta), std::cos(theta), phi)};
}

/// Mean and deviations along the slope of w and across it, of slopes turned into w's plane.
struct Moments {
    double mean = 0, along = 0, across = 0;
};

/// Moments of f cos^c, without what is below 1/1000 of its maximum, by drawing from the BxDF itself. A drawn
/// direction has the density p over solid angle and 1/cos^3 as much slope: an integral over slopes of f cos^c
/// g is the mean of (f cos / p) cos^(c-4) g. Shares no code with the fit.
template <class Boundary>
Moments SampledMoments(const Point& p, const Boundary& boundary, Rng& rng) {
    constexpr int kSamples = 16000;
    const Vec3 w(std::sqrt(1 - p.w.z * p.w.z), 0, std::abs(p.w.z));
    BxDFContext context{.mode = TransportMode::Importance, .rng = &rng};
    context.sides = p.model->Transmits() ? Lobes::Transmission : Lobes::Reflection;
    struct Drawn {
        double weight, value, x, y;
    };
    std::vector<Drawn> drawn;
    double largest = 0;
    for (int i = 0; i < kSamples; ++i) {
        const auto sample = boundary.Sample(w, {rng.Uniform(), rng.Uniform2D()}, context);
        if (!sample) continue;
        const double cosine = std::abs(double(sample->wi.z)), power = p.model->cosinePower;
        const double f = double(boundary.Evaluate(w, sample->wi, context).f[0]);
        const Slope slope = SlopeOf(sample->wi);
        drawn.push_back({double(sample->weight[0]) * std::pow(cosine, power - 4), f * std::pow(cosine, power),
                         double(slope.x), double(slope.y)});
        largest = std::max(largest, drawn.back().value);
    }
    double sum = 0, x = 0, xx = 0, yy = 0;
    for (const Drawn& d : drawn) {
        if (!(d.value > 1e-3 * largest)) continue;
        sum += d.weight;
        x += d.weight * d.x;
        xx += d.weight * d.x * d.x;
        yy += d.weight * d.y * d.y;
    }
    const double mean = x / sum;
    return {mean, std::sqrt(xx / sum - mean * mean), std::sqrt(yy / sum)};
}

template <class Distribution>
Moments SampledMoments(const Point& p, Rng& rng) {
    if (p.model->Transmits())
        return SampledMoments(p, DielectricBxDF<Distribution>({p.alpha, p.alpha}, p.eta), rng);
    const SampledSpectrum zero(0.f);
    return SampledMoments(p, ConductorBxDF<Distribution>({p.alpha, p.alpha}, zero, zero), rng);
}

Moments SampledMoments(const Point& p, Rng& rng) {
    return p.model->distribution == MicrofacetModel::Beckmann ? SampledMoments<Beckmann>(p, rng)
                                                              : SampledMoments<TrowbridgeReitz>(p, rng);
}

/// Moments of a lobe, in the plane of w.
Moments MomentsOf(const GaussianMixture& lobe, Vec3 w) {
    const Slope slope = SlopeOf(w);
    const double length = std::hypot(double(slope.x), double(slope.y));
    const double ex = length > 0 ? double(slope.x) / length : 1,
                 ey = length > 0 ? double(slope.y) / length : 0;
    Moments m;
    double xx = 0, yy = 0;
    for (size_t i = 0; i < size_t(lobe.count); ++i) {
        const Gaussian2& g = lobe.parts[i];
        const double weight = double(lobe.weights[i]), mean = double(g.mean.x) * ex + double(g.mean.y) * ey;
        const double pxx = double(g.precision.xx), pxy = double(g.precision.xy), pyy = double(g.precision.yy);
        const double along = pxx * ex * ex + 2 * pxy * ex * ey + pyy * ey * ey;
        const double across = pxx * ey * ey - 2 * pxy * ex * ey + pyy * ex * ex;
        m.mean += weight * mean;
        xx += weight * (1 / along + mean * mean);
        yy += weight / across;
    }
    m.along = std::sqrt(xx - m.mean * m.mean);
    m.across = std::sqrt(yy);
    return m;
}

/// Root of mean square of the differences over many points, each against its tolerance.
struct Differences {
    double mean = 0, along = 0, across = 0;
    int count = 0;
    void Add(const Moments& lobe, const Moments& sampled) {
        mean += std::pow((lobe.mean - sampled.mean) / sampled.along, 2);
        along += std::pow(std::log(lobe.along / sampled.along), 2);
        across += std::pow(std::log(lobe.across / sampled.across), 2);
        ++count;
    }
    double Mean() const { return std::sqrt(mean / count); }
    double Along() const { return std::sqrt(along / count); }
    double Across() const { return std::sqrt(across / count); }
    // The tables' own errors are at most 0.018, 0.046 and 0.014 (docs/gaussfit.md). 16,000 draws add up to
    // 0.02 to each, and as the maximum is found from below, the truncation is a little too low. An alpha that
    // is wrong by 1.3 moves the logs by 0.26; what this finds are means off by 0.05 and widths off by 8 % or
    // 5 %.
    bool AreSmall() const { return Mean() < 0.05 && Along() < 0.08 && Across() < 0.05; }
    std::string Text() const {
        return "rms of mean " + std::to_string(Mean()) + ", along " + std::to_string(Along()) + ", across " +
               std::to_string(Across());
    }
};

class FindLobeForModel : public testing::TestWithParam<const LobeModel*> {};

TEST_P(FindLobeForModel, HasTheMomentsOfItsFunction) {
    constexpr int kPoints = 60;
    Rng rng(SeedOf(FullTestName()));
    Differences right, widerAlpha, otherEvent;
    const LobeModel& model = *GetParam();
    for (int i = 0; i < kPoints; ++i) {
        const Point p = RandomPoint(model, rng);
        GaussianMixture lobe;
        ASSERT_TRUE(p.Find(&lobe)) << p.alpha << " " << p.eta << " " << p.w.z;
        const Moments sampled = SampledMoments(p, rng);
        right.Add(MomentsOf(lobe, p.w), sampled);

        // Negative controls: another roughness, and another event.
        Point wrong = p;
        wrong.alpha = p.alpha * 1.3f;
        if (wrong.Find(&lobe)) widerAlpha.Add(MomentsOf(lobe, p.w), sampled);
        const LobeEvent event = model.Transmits() ? LobeEvent::Reflection : LobeEvent::Entering;
        if (FindLobe(p.Surface(), event, 1.5f, p.w, &lobe)) otherEvent.Add(MomentsOf(lobe, p.w), sampled);
    }
    EXPECT_TRUE(right.AreSmall()) << right.Text();
    EXPECT_FALSE(widerAlpha.AreSmall()) << widerAlpha.Text();
    EXPECT_FALSE(otherEvent.AreSmall()) << otherEvent.Text();
    RecordProperty("differences", right.Text());
}

TEST_P(FindLobeForModel, TurnsWithTheDirectionAndForgetsItsSign) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 40; ++i) {
        Point p = RandomPoint(*GetParam(), rng);
        const float phi = SphericalPhi(p.w), sinTheta = std::sqrt(Sin2Theta(p.w));
        GaussianMixture turned, opposite, straight;
        ASSERT_TRUE(p.Find(&turned));
        p.w = -p.w;
        ASSERT_TRUE(p.Find(&opposite));
        p.w = Vec3(sinTheta, 0, -p.w.z);
        ASSERT_TRUE(p.Find(&straight));
        for (size_t k = 0; k < size_t(turned.count); ++k) {
            const Gaussian2 &a = turned.parts[k], &b = opposite.parts[k], &c = straight.parts[k];
            // A direction and its opposite have the same slope, so the whole lobe is the same.
            EXPECT_EQ(a.mean.x, b.mean.x);
            EXPECT_EQ(a.precision.xy, b.precision.xy);
            EXPECT_EQ(turned.weights[k], straight.weights[k]);
            // Rounding of the azimuth, relative to the largest entry.
            const float tolerance = 1e-4f * (std::abs(c.mean.x) + 1e-3f),
                        scale = 1e-4f * (c.precision.xx + c.precision.yy);
            EXPECT_NEAR(a.mean.x, c.mean.x * std::cos(phi), tolerance);
            EXPECT_NEAR(a.mean.y, c.mean.x * std::sin(phi), tolerance);
            EXPECT_NEAR(a.precision.xx,
                        c.precision.xx * Sqr(std::cos(phi)) + c.precision.yy * Sqr(std::sin(phi)), scale);
            EXPECT_NEAR(a.precision.xy, (c.precision.xx - c.precision.yy) * std::cos(phi) * std::sin(phi),
                        scale);
        }
    }
}

std::vector<const LobeModel*> AllModels() {
    std::vector<const LobeModel*> models;
    for (const LobeModel& model : LobeModels()) models.push_back(&model);
    return models;
}
std::string TestNameOf(const testing::TestParamInfo<const LobeModel*>& model) {
    std::string name = model.param->name;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}
INSTANTIATE_TEST_SUITE_P(Models, FindLobeForModel, testing::ValuesIn(AllModels()), TestNameOf);

TEST(FindLobe, IsFalseWhereTheTablesEndAndSetsNothing) {
    const auto found = [](float alpha, LobeEvent event, float eta, float thetaDeg, float alphaY = 0) {
        const MicrofacetSurface surface{MicrofacetModel::Beckmann, alpha, alphaY > 0 ? alphaY : alpha, 1.5f};
        GaussianMixture lobe;
        lobe.count = -7;
        const Vec3 w(std::sin(Radians(thetaDeg)), 0, std::cos(Radians(thetaDeg)));
        const bool result = FindLobe(surface, event, eta, w, &lobe);
        EXPECT_EQ(lobe.count, result ? 1 : -7);
        return result;
    };
    constexpr auto kReflection = LobeEvent::Reflection, kEntering = LobeEvent::Entering,
                   kLeaving = LobeEvent::Leaving;
    const float nan = std::numeric_limits<float>::quiet_NaN();

    EXPECT_TRUE(found(0.005f, kReflection, 1, 88));
    EXPECT_TRUE(found(1, kReflection, nan, 0));
    EXPECT_FALSE(found(0.0049f, kReflection, 1, 30));
    EXPECT_FALSE(found(1.01f, kReflection, 1, 30));
    EXPECT_FALSE(found(0.1f, kReflection, 1, 88.1f));
    EXPECT_FALSE(found(nan, kReflection, 1, 30));
    EXPECT_FALSE(found(0.1f, kReflection, 1, nan));
    EXPECT_FALSE(found(0.1f, kReflection, 1, 30, 0.2f)) << "anisotropic";

    EXPECT_TRUE(found(0.1f, kEntering, 1.05f, 30));
    EXPECT_TRUE(found(0.1f, kEntering, 2.5f, 88));
    EXPECT_FALSE(found(0.1f, kEntering, 1.04f, 30));
    EXPECT_FALSE(found(0.1f, kEntering, 2.51f, 30));
    EXPECT_FALSE(found(0.1f, kEntering, 1 / 1.5f, 30)) << "leaves";
    EXPECT_FALSE(found(0.1f, kEntering, nan, 30));

    EXPECT_TRUE(found(0.1f, kLeaving, 1 / 1.5f, 41));
    EXPECT_FALSE(found(0.1f, kLeaving, 1 / 1.5f, 41.8f)) << "at the critical angle";
    EXPECT_FALSE(found(0.1f, kLeaving, 1 / 1.5f, 60)) << "total reflection";
    EXPECT_TRUE(found(0.1f, kLeaving, 1 / 1.05f, 30));
    EXPECT_TRUE(found(0.1f, kLeaving, 1 / 2.5f, 20));
    EXPECT_FALSE(found(0.1f, kLeaving, 1.5f, 30)) << "enters";
    EXPECT_FALSE(found(0.1f, kLeaving, 0, 30));
}

}  // namespace
}  // namespace lacquer::gaussfit::test::find_lobe_test
