// The tabulated profile against integrals made in other ways, closed forms, and random walks.
#include "pbrt/scattering/bssrdf_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"
#include "pbrt/scattering/fresnel.h"
#include "support/statistics.h"

namespace lacquer::test::bssrdf_table_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

const BssrdfTable& Table() {
    static const std::shared_ptr<const BssrdfTable> table = BssrdfTable::Shared(0, 1.33f);
    return *table;
}

/// Integral over [a, b] of a smooth function by Simpson's rule.
double Simpson(const std::function<double(double)>& f, double a, double b, int steps) {
    const double h = (b - a) / (2 * steps);
    double sum = f(a) + f(b);
    for (int i = 1; i < 2 * steps; ++i) sum += (i % 2 ? 4 : 2) * f(a + i * h);
    return sum * h / 3;
}
/// Integral over [a, b] with steps that grow with x.
double SimpsonLog(const std::function<double(double)>& f, double a, double b, int steps) {
    return Simpson([&](double l) { return std::exp(l) * f(std::exp(l)); }, std::log(a), std::log(b), steps);
}

// The polynomials are fits; 0.006 is what they are off by, within the range that the material takes.
TEST(BssrdfTable, FresnelMomentsAreThoseOfTheReflectance) {
    for (float eta = 0.4f; eta <= 2.5f; eta += 0.05f) {
        const auto moment = [&](int power) {
            return Simpson(
                [&](double c) { return double(FresnelDielectric(float(c), 1 / eta)) * std::pow(c, power); },
                0, 1, 2000);
        };
        EXPECT_NEAR(FresnelMoment1(eta), moment(1), 0.006) << eta;
        EXPECT_NEAR(FresnelMoment2(eta), moment(2), 0.006) << eta;
    }
}

// Without a boundary, isotropic scattering, all the light that scattered once and came out again:
// albedo/2 times the integral of c/(1+c) over c in [0,1]. 100 steps along the beam are off by 0.2 %.
TEST(BssrdfTable, SingleScatteringHasItsClosedForm) {
    const auto exitance = [](double r) { return 2 * kPi * r * BeamDiffusionSingle(0.6, 0.4, 0, 1, r); };
    EXPECT_NEAR(SimpsonLog(exitance, 1e-6, 60, 2000), 0.6 / 2 * (1 - std::log(2)), 2e-3 * 0.092);
}

// The flux through the boundary is the slope of the fluence: by differences here, in closed form there. The
// steps of the integral over depth are 100 there, and 4000 here; nearer to the beam than a tenth of a mean
// free path, 100 are not enough for 1 %.
TEST(BssrdfTable, MultipleScatteringIsFluenceAndItsSlope) {
    constexpr double sigma_s = 0.9, sigma_a = 0.1, eta = 1.33, g = 0.3;
    const double sp = sigma_s * (1 - g), tp = sp + sigma_a;
    const double D = (2 * sigma_a + sp) / (3 * tp * tp), tr = std::sqrt(sigma_a / D);
    const double F1 = double(FresnelMoment1(float(eta))), F2 = double(FresnelMoment2(float(eta)));
    const double extrapolated = 2 * D * (1 + 3 * F2) / (1 - 2 * F1);
    for (const double r : {0.1, 0.3, 1., 3., 10.}) {
        const auto exitance = [&](double source) {
            const auto fluence = [&](double z) {
                const double image = -source - 2 * extrapolated;
                const double d1 = std::hypot(r, z - source), d2 = std::hypot(r, z - image);
                return (std::exp(-tr * d1) / d1 - std::exp(-tr * d2) / d2) / (4 * kPi * D);
            };
            constexpr double h = 1e-4;
            const double slope = D * (fluence(h) - fluence(-h)) / (2 * h);
            const double kappa = 1 - std::exp(-2 * tp * (std::hypot(r, source) + source));
            return kappa * (fluence(0) * (1 - 2 * F1) / 4 + slope * (1 - 3 * F2) / 2) * tp *
                   std::exp(-tp * source);
        };
        const double expected = sp / tp * sp / tp * SimpsonLog(exitance, 1e-7, 40, 4000);
        EXPECT_NEAR(BeamDiffusionMultiple(sigma_s, sigma_a, g, eta, r), expected, 0.01 * expected) << r;
    }
}

// What comes out in all, by the spline of the table and by steps of one per cent of the radius.
TEST(BssrdfTable, EffectiveAlbedoIsTheIntegralOfTheProfile) {
    for (const int i : {5, 30, 60, 90}) {
        const double albedo = double(Table().Albedos()[size_t(i)]);
        const auto profile = [&](double r) {
            return 2 * kPi * r *
                   (BeamDiffusionSingle(albedo, 1 - albedo, 0, double(1.33f), r) +
                    BeamDiffusionMultiple(albedo, 1 - albedo, 0, double(1.33f), r));
        };
        const double expected = SimpsonLog(profile, 1e-5, 200, 300);
        EXPECT_NEAR(Table().EffectiveAlbedos()[size_t(i)], expected, 0.01 * expected) << albedo;
    }
}

/// Light that leaves a half space, by counting walks: refraction inwards at normal incidence has happened.
double WalkedAlbedo(double albedo, float eta, int numWalks, Rng& rng) {
    int64_t left = 0;
    for (int i = 0; i < numWalks; ++i) {
        float z = 0, w = 1;  // depth, cosine
        for (;;) {
            z -= std::log1p(-rng.Uniform()) * w;
            if (z < 0) {
                // The rest of the flight is drawn anew after a reflection, which changes nothing.
                z = 0;
                if (rng.Uniform() >= FresnelDielectric(w, eta)) {
                    ++left;
                    break;
                }
                w = -w;
                continue;
            }
            if (double(rng.Uniform()) >= albedo) break;
            w = 1 - 2 * rng.Uniform();
        }
    }
    return double(left) / numWalks;
}

// Diffusion is an approximation. 20,000 walks have a standard error of at most 0.0035; the model agrees with
// them to 0.04 at these albedos, so that a lost factor would show.
TEST(BssrdfTable, EffectiveAlbedoIsNearThatOfRandomWalks) {
    Rng rng(SeedOf(FullTestName()));
    for (const float albedo : {0.5f, 0.9f, 0.98f, 0.999f}) {
        const double walked = WalkedAlbedo(double(albedo), 1.33f, 20000, rng);
        EXPECT_NEAR(BssrdfSlice(Table(), albedo).EffectiveAlbedo(), walked, 0.04 + 4 * 0.0035) << albedo;
    }
}

// Diffusion makes light near albedo 1. By how much is known here, and no slice does.
TEST(BssrdfTable, EffectiveAlbedoRisesFromNothingToAtMostOne) {
    struct Row {
        float g, eta;
        double largest;
    };
    for (const Row& row :
         {Row{0, 1.33f, 1.02}, Row{0, 1, 1.09}, Row{0.9f, 1.5f, 1}, Row{1, 2, 1}, Row{-0.9f, 0.7f, 1.4}}) {
        const BssrdfTable table(row.g, row.eta);
        const std::span<const float> share = table.EffectiveAlbedos();
        EXPECT_EQ(share.front(), 0);
        for (size_t i = 1; i < share.size(); ++i) {
            EXPECT_GT(share[i], share[i - 1]) << row.eta << ' ' << row.g;
            EXPECT_LE(BssrdfSlice(table, table.Albedos()[i]).EffectiveAlbedo(), 1);
        }
        EXPECT_LE(double(share.back()), row.largest) << row.eta << ' ' << row.g;
    }
}

// The integral of the profile, in steps of a per mille of the radius, is the effective albedo that the slice
// says, also where the profile was scaled down.
TEST(BssrdfSlice, LetsOutItsEffectiveAlbedo) {
    for (const float albedo : {0.3f, 0.95f, 1.f}) {
        const BssrdfSlice slice(Table(), albedo);
        const double sum = SimpsonLog([&](double r) { return 2 * kPi * r * double(slice.Profile(float(r))); },
                                      1e-5, 203, 8000);
        EXPECT_NEAR(sum, double(slice.EffectiveAlbedo()), 1e-3 * sum) << albedo;
    }
    EXPECT_EQ(BssrdfSlice(Table(), 1).EffectiveAlbedo(), 1);
}

TEST(BssrdfTable, InversionUndoesTheEffectiveAlbedo) {
    for (float albedo = 0; albedo <= 1; albedo += 1 / 64.f) {
        const float share = BssrdfSlice(Table(), albedo).EffectiveAlbedo();
        // The effective albedo is steep near 1: a rounding of the albedo (6e-8) becomes some 2e-5 there.
        EXPECT_NEAR(BssrdfSlice(Table(), Table().InvertEffectiveAlbedo(share)).EffectiveAlbedo(), share,
                    4e-5f);
    }
    EXPECT_EQ(Table().InvertEffectiveAlbedo(0), 0);
    EXPECT_NEAR(Table().InvertEffectiveAlbedo(1), 1, 1e-3f);
}

TEST(BssrdfTable, IsSharedWhileSomebodyHoldsIt) {
    const auto table = BssrdfTable::Shared(0.125f, 1.25f);
    EXPECT_EQ(BssrdfTable::Shared(0.125f, 1.25f), table);
    EXPECT_NE(BssrdfTable::Shared(0.25f, 1.25f), table);
}

TEST(BssrdfSlice, ProfileIsFiniteNonNegativeAndEnds) {
    for (const float albedo : {0.f, 0.3f, 0.987f, 1.f, 2.f, -1.f}) {
        const BssrdfSlice slice(Table(), albedo);
        for (const float r : {0.f, 1e-30f, 1e-6f, 1e-3f, 0.1f, 1.f, 30.f, 170.f}) {
            EXPECT_TRUE(std::isfinite(slice.Profile(r))) << r;
            EXPECT_GE(slice.Profile(r), 0) << r;
        }
        for (const float r : {1e3f, Infinity, std::nanf("")}) EXPECT_EQ(slice.Profile(r), 0) << r;
        EXPECT_GE(slice.SampleRadius(0), 0);
        EXPECT_LE(slice.SampleRadius(OneMinusEpsilon), Table().Radii().back());
    }
}

/// Draws of the slice of one albedo, against the profile of another one, in 30 rings.
Outcome CompareRadii(float drawn, float expected, uint64_t seed) {
    constexpr int kNumRings = 30, kNumSamples = 40000;
    const BssrdfSlice draws(Table(), drawn), profile(Table(), expected);
    std::vector<double> edges(kNumRings + 1, 0.), counts(kNumRings, 0.), expectations;
    for (int i = 1; i <= kNumRings; ++i) edges[size_t(i)] = 0.01 * std::pow(1.37, i);
    for (size_t i = 0; i < size_t(kNumRings); ++i)
        expectations.push_back(
            kNumSamples / double(profile.EffectiveAlbedo()) *
            Simpson([&](double r) { return 2 * kPi * r * double(profile.Profile(float(r))); }, edges[i],
                    edges[i + 1], 200));
    Rng rng(seed);
    for (int i = 0; i < kNumSamples; ++i) {
        const double r = double(draws.SampleRadius(rng.Uniform()));
        const size_t ring = size_t(std::upper_bound(edges.begin(), edges.end(), r) - edges.begin());
        if (ring >= 1 && ring <= size_t(kNumRings)) ++counts[ring - 1];
    }
    return ChiSquareTest(counts, expectations);
}

// Power: densities that differ by 3 % (rms) are found at 40,000 draws: non-centrality 36 over 30 degrees.
TEST(BssrdfSlice, DrawsRadiiWithTheDensityOfTheProfile) {
    for (const float albedo : {0.2f, 0.9f, 0.999f})
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(albedo), 1e-4,
                           [&](uint64_t seed) { return CompareRadii(albedo, albedo, seed); }));
}

TEST(BssrdfSliceControl, DrawsOfAnotherAlbedoAreFound) {
    EXPECT_LT(CompareRadii(0.9f, 0.85f, SeedOf(FullTestName())).pValue, 1e-4);
}

}  // namespace
}  // namespace lacquer::test::bssrdf_table_test
