// The map between facets and directions against laws of optics and a second one in double precision: values,
// and derivatives by differences of it.
#include "layered/slopes/facet_map.h"

#include <gtest/gtest.h>

#include "layered/slopes/facet_slopes.h"
#include "layered/stack_cases.h"
#include "pbrt/core/sampling.h"
#include "support/statistics.h"

namespace lacquer::layered::test::facet_map_test {

using namespace lacquer::test;

namespace {

// ---- The same in double precision ---------------------------------------------------------------------

using DVec3 = glm::dvec3;
using DVec2 = glm::dvec2;

DVec2 SlopeOfD(DVec3 w) { return {w.x / w.z, w.y / w.z}; }
DVec3 DirectionOfD(DVec2 s) { return glm::normalize(DVec3(s, 1)); }

/// Where light goes by the laws in the plane of incidence, turned up; z < 0 where it does not get.
DVec3 Bent(double eta, DVec3 w, DVec2 m) {
    const DVec3 h = DirectionOfD(m);
    const double cosW = glm::dot(w, h);
    if (!(cosW > 0)) return {0, 0, -1};
    const DVec3 along = w - cosW * h;  // tangential to the facet
    if (eta < 0) return cosW * h - along;
    const double sine2 = glm::dot(along, along) / (eta * eta);
    if (sine2 >= 1) return {0, 0, -1};
    return std::sqrt(1 - sine2) * h + along / eta;
}
DVec2 Joined(double eta, DVec3 w, DVec3 u) { return SlopeOfD(eta * u - w); }

struct Derivative {
    DVec2 byX, byY;

    double Determinant() const { return byX.x * byY.y - byX.y * byY.x; }
};
/// Central differences; their error is that of step^2.
template <class Function>
Derivative Differentiate(const Function& f, DVec2 at) {
    constexpr double kStep = 1e-5;
    const DVec2 dx(kStep, 0), dy(0, kStep);
    return {(f(at + dx) - f(at - dx)) / (2 * kStep), (f(at + dy) - f(at - dy)) / (2 * kStep)};
}

/// Largest difference over the largest number of the second one.
double Difference(const Derivative& a, const Derivative& b) {
    const DVec2 x = glm::abs(a.byX - b.byX), y = glm::abs(a.byY - b.byY), sizeX = glm::abs(b.byX),
                sizeY = glm::abs(b.byY);
    return std::max({x.x, x.y, y.x, y.y}) / std::max({sizeX.x, sizeX.y, sizeY.x, sizeY.y});
}
Derivative ColumnsOf(const Matrix2& m) { return {{m.xx, m.yx}, {m.xy, m.yy}}; }

// ---- Cases --------------------------------------------------------------------------------------------

/// A direction and a facet.
struct Case {
    float eta;
    Vec3 w;
    Slope m;
};

constexpr float kEtas[] = {-1, 0.5f, 0.8f, 0.97f, 1.03f, 1.5f, 3};

/// Facets as alphas from 0.0001 to 3 have them, directions down to 0.1 degrees above the horizon.
Case SampleCase(int i, Rng& rng) {
    constexpr float kAlphas[] = {1e-4f, 0.02f, 0.3f, 3};
    Case c;
    c.eta = kEtas[size_t(i) % std::size(kEtas)];
    const float z = i % 3 ? rng.Uniform() : std::exp2(-9 * rng.Uniform());
    c.w = SphericalDirection(SafeSqrt(1 - z * z), z, 2 * Pi * rng.Uniform());
    const Point2 u = rng.Uniform2D();
    c.m = kAlphas[size_t(i / 7) % 4] * Slope{2 * u.x - 1, 2 * u.y - 1};
    return c;
}
constexpr int kNumCases = 4000;

/// True if the bounds that keep guesses finite are far.
bool IsRegular(const Case& c, const FacetDeflection& deflection) {
    return Dot(c.w, DirectionOf(c.m)) > 0.06f && deflection.cosU > 0.05f && deflection.u.z > 0.06f;
}

// ---- Values -------------------------------------------------------------------------------------------

TEST(FacetMap, FollowsTheLawsOfReflectionAndRefraction) {
    Rng rng(SeedOf(FullTestName()));
    int numBent = 0, numRefused = 0;
    for (int i = 0; i < kNumCases; ++i) {
        const Case c = SampleCase(i, rng);
        FacetDeflection deflection;
        const bool isBent = FacetMap(c.w, c.eta).Deflection(c.m, &deflection);
        const DVec2 m(c.m.x, c.m.y);
        const DVec3 expected = Bent(double(c.eta), DVec3(c.w), m);
        // Rounding may decide at the edges. Where the cosine inside is small, it is the root of a difference.
        const double cosW = glm::dot(DVec3(c.w), DirectionOfD(m)),
                     cos2U = 1 - (1 - cosW * cosW) / Sqr(double(c.eta));
        if (std::min({std::abs(cosW), std::abs(cos2U), std::abs(expected.z)}) < 1e-5) continue;
        const double tolerance = 1e-6 / std::max(0.01, std::sqrt(std::abs(cos2U)));
        ASSERT_EQ(isBent, expected.z > 0) << i;
        (isBent ? numBent : numRefused) += 1;
        if (!isBent) continue;
        EXPECT_LT(glm::length(DVec3(deflection.u) - expected),
                  tolerance / std::min(1., std::abs(double(c.eta))))
            << i;
        EXPECT_NEAR(double(deflection.cosU), glm::dot(expected, DirectionOfD(m)), tolerance);
    }
    EXPECT_GT(numBent, kNumCases / 3);
    EXPECT_GT(numRefused, kNumCases / 20);
}

TEST(FacetMap, TheJoiningFacetIsTheOneThatBends) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < kNumCases; ++i) {
        const Case c = SampleCase(i, rng);
        FacetDeflection deflection;
        if (!FacetMap(c.w, c.eta).Deflection(c.m, &deflection)) continue;
        const JoiningFacet joint(c.eta, c.w, deflection.u, 1e-6f);
        // A few roundings of both directions over the part of their sum that is along z; roundings of the
        // cosine inside as above.
        const float size = 1 + std::sqrt(Dot(c.m, c.m));
        const float tolerance = 4e-6f * size * std::abs(joint.OverSum()) * (1 + std::abs(c.eta)) /
                                std::max(deflection.cosU, 0.01f);
        const Slope difference = joint.FacetSlope() - c.m;
        EXPECT_LT(std::sqrt(Dot(difference, difference)), tolerance) << i << " " << c.eta;
    }
}

// Facets and directions beyond any that light meets: the model may be bad, not broken.
TEST(FacetMap, GuessesStayAboveTheHorizonAndFinite) {
    for (const float eta : {-1.f, 0.01f, 0.999f, 1.001f, 100.f})
        for (const float z : {1.f, 0.1f, 1e-4f, 0.f})
            for (const float slope : {-1e6f, -3.f, -1e-4f, 0.f, 1e-4f, 3.f, 1e6f}) {
                const Vec3 w = SphericalDirection(SafeSqrt(1 - z * z), z, 0.4f);
                const LinearDeflection deflection = FacetMap(w, eta).BoundedDeflection({slope, 0.5f * slope});
                EXPECT_GT(deflection.u.z, 0) << eta << " " << z << " " << slope;
                EXPECT_TRUE(IsFinite(deflection.u) && std::isfinite(deflection.stretch)) << eta << " " << z;
                const JoiningFacet joint(eta, w, deflection.u, 0.05f * std::abs(eta - 1));
                const Matrix2 j = joint.OverFacetOfU(deflection);
                EXPECT_TRUE(std::isfinite(joint.FacetSlope().x + joint.FacetSlope().y)) << eta << " " << z;
                EXPECT_TRUE(std::isfinite(j.xx + j.xy + j.yx + j.yy)) << eta << " " << z << " " << slope;
            }
}

TEST(FacetMap, GuessesAreExactWhereLightPasses) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < kNumCases; ++i) {
        const Case c = SampleCase(i, rng);
        FacetDeflection deflection;
        if (!FacetMap(c.w, c.eta).Deflection(c.m, &deflection) || !IsRegular(c, deflection)) continue;
        EXPECT_EQ(FacetMap(c.w, c.eta).BoundedDeflection(c.m).u, deflection.u);
    }
}

// ---- Derivatives --------------------------------------------------------------------------------------

/// What the derivatives of all regular cases differ by at most, and how many there are.
struct Worst {
    double deflection = 0, jacobian = 0, joined = 0, chained = 0;
    int count = 0;
};
/// Single precision near eta = 1 or small cosines loses digits in proportion.
double Conditioned(const Case& c, const FacetDeflection& deflection, double difference) {
    return difference * std::min(1., std::abs(double(c.eta) - 1)) * double(deflection.u.z * deflection.cosU);
}

/// @param etaError  what the examined maps have the index multiplied by: a control
Worst CompareDerivatives(uint64_t seed, float etaError) {
    Rng rng(seed);
    Worst worst;
    for (int i = 0; i < kNumCases; ++i) {
        const Case c = SampleCase(i, rng);
        const double eta = double(c.eta);
        const FacetMap map(c.w, c.eta * etaError);
        FacetDeflection exact;
        if (!map.Deflection(c.m, &exact) || !IsRegular(c, exact)) continue;
        ++worst.count;
        const auto note = [&](double* most, double difference) {
            *most = std::max(*most, Conditioned(c, exact, difference));
        };
        const DVec3 w(c.w);
        const DVec2 m(c.m.x, c.m.y);
        const auto slopeBehind = [&](DVec2 at) { return SlopeOfD(Bent(eta, w, at)); };
        const Derivative bent = Differentiate(slopeBehind, m);

        // The slope behind, row by row.
        const LinearDeflection deflection = map.BoundedDeflection(c.m);
        const Slope rowX = FacetMap::GradientOverFacet(deflection, {1, 0}),
                    rowY = FacetMap::GradientOverFacet(deflection, {0, 1});
        note(&worst.deflection, Difference({{rowX.x, rowY.x}, {rowX.y, rowY.y}}, bent));

        // Areas: dm/ds ds/domega.
        const double perSolidAngle = 1 / (std::abs(bent.Determinant()) * std::pow(double(exact.u.z), 3));
        note(&worst.jacobian, std::abs(double(map.SlopesPerSolidAngle(exact)) / perSolidAngle - 1));
        const JoiningFacet same(c.eta * etaError, c.w, exact.u);
        note(&worst.jacobian, std::abs(double(same.SlopesPerSolidAngle()) / perSolidAngle - 1));

        // A second facet behind the first, which joins u to some other direction.
        const float etaNext = kEtas[size_t(i / 5) % std::size(kEtas)];
        const Vec3 other = SampleCosineHemisphere(rng.Uniform2D());
        const JoiningFacet joint(etaNext * etaError, other, exact.u, 1e-6f);
        if (!(std::abs(etaNext * exact.u.z - other.z) > 0.1f) || ((etaNext < 1) == (joint.OverSum() > 0)))
            continue;
        const auto joined = [&](DVec2 slope) {
            return Joined(double(etaNext), DVec3(other), DirectionOfD(slope));
        };
        if (((etaNext * exact.u.z - other.z) > 0) != (etaNext > 1)) continue;
        note(&worst.joined,
             Difference(ColumnsOf(joint.OverSlopeOfU()), Differentiate(joined, SlopeOfD(DVec3(exact.u)))));
        note(&worst.chained, Difference(ColumnsOf(joint.OverFacetOfU(deflection)),
                                        Differentiate([&](DVec2 at) { return joined(slopeBehind(at)); }, m)));
    }
    return worst;
}

// Relative to the largest number of each derivative and to how well it is conditioned.
constexpr double kTolerance = 3e-5;

TEST(FacetMap, DerivativesAreThoseOfTheMaps) {
    const Worst worst = CompareDerivatives(SeedOf(FullTestName()), 1);
    EXPECT_GT(worst.count, kNumCases / 5);
    EXPECT_LT(worst.deflection, kTolerance);
    EXPECT_LT(worst.jacobian, kTolerance);
    EXPECT_LT(worst.joined, kTolerance);
    EXPECT_LT(worst.chained, kTolerance);
}

TEST(FacetMapControls, AnIndexThatIsOffByATenthOfAPerCentIsFound) {
    const Worst worst = CompareDerivatives(SeedOf(FullTestName()), 1.001f);
    EXPECT_GT(worst.deflection, kTolerance);
    EXPECT_GT(worst.jacobian, kTolerance);
    EXPECT_GT(worst.joined, kTolerance);
    EXPECT_GT(worst.chained, kTolerance);
}

// The area of slopes per solid angle as an integral: facets of a known density, bent, have the density that
// the Jacobian says. Sums over a grid of directions; power: 1 %.
TEST(FacetMap, DensitiesOfFacetsBecomeDensitiesOfDirections) {
    const auto total = [](float eta, float alpha, float scale) {
        constexpr int kRows = 300, kColumns = 600;
        const Vec3 w = Normalize(Vec3(0.5f, 0.2f, 0.8f));
        double sum = 0, missed = 0;
        const auto density = [&](Slope m) {
            return double(InvPi) / Sqr(double(alpha)) * std::exp(-double(Dot(m, m)) / Sqr(double(alpha)));
        };
        // Directions.
        for (int i = 0; i < kRows; ++i)
            for (int j = 0; j < kColumns; ++j) {
                const float z = (float(i) + 0.5f) / kRows;
                const Vec3 u =
                    SphericalDirection(std::sqrt(1 - z * z), z, 2 * Pi * (float(j) + 0.5f) / kColumns);
                const JoiningFacet joint(eta, w, u, 1e-6f);
                FacetDeflection deflection;
                if (!FacetMap(w, eta).Deflection(joint.FacetSlope(), &deflection) ||
                    Length(deflection.u - u) > 1e-3f)
                    continue;
                sum += density(joint.FacetSlope()) *
                       double(scale * FacetMap(w, eta).SlopesPerSolidAngle(deflection)) * 2 * double(Pi) /
                       (kRows * kColumns);
            }
        // Facets that let no light pass.
        constexpr int kCells = 400;
        for (int i = 0; i < kCells; ++i)
            for (int j = 0; j < kCells; ++j) {
                const float step = 10 * alpha / kCells;
                const Slope m{(float(i) + 0.5f) * step - 5 * alpha, (float(j) + 0.5f) * step - 5 * alpha};
                FacetDeflection deflection;
                if (!FacetMap(w, eta).Deflection(m, &deflection)) missed += density(m) * double(step * step);
            }
        return sum + missed;
    };
    for (const float eta : {-1.f, 1.5f, 0.7f})
        for (const float alpha : {0.2f, 0.5f})
            EXPECT_NEAR(total(eta, alpha, 1), 1, 0.01) << eta << " " << alpha;
    EXPECT_GT(std::abs(total(1.5f, 0.2f, 1.02f) - 1), 0.01) << "negative control";
}

TEST(FacetMap, ClearanceOfTotalReflectionCountsDeviations) {
    const Vec3 w = SphericalDirection(std::sin(Radians(35.f)), std::cos(Radians(35.f)), 0);
    // Out of glass; the critical angle, 41.8 degrees, is 6.8 away.
    const FacetMap map(w, 1 / 1.5f);
    const Symmetric2 covariance{Sqr(0.02f), 0, Sqr(0.02f)};
    EXPECT_TRUE(map.IsFarFromTotalReflection({}, covariance, 0));
    EXPECT_TRUE(map.IsFarFromTotalReflection({}, covariance, 4));
    EXPECT_FALSE(map.IsFarFromTotalReflection({}, covariance, 8));
    EXPECT_FALSE(map.IsFarFromTotalReflection({-0.2f, 0}, covariance, 0)) << "a facet beyond it";
    EXPECT_TRUE(FacetMap(w, 1.5f).IsFarFromTotalReflection({}, covariance, 100))
        << "into glass there is none";
}

// ---- Slopes of an interface -----------------------------------------------------------------------------

TEST(FacetCovariance, TurnsWithTheInterface) {
    Arena arena;
    StackBuilder builder(arena);
    for (const float deg : {0.f, 30.f, 90.f, 200.f})
        Rotated(deg, Dielectric(Alphas(0.4f, 0.1f), 1.5f, kBeckmann))(builder);
    Rotated(30, Dielectric(0.3f, 1.5f, kBeckmann))(builder);
    const Stack stack = builder.Build();
    const auto covariance = [&](size_t i) {
        return FacetCovariance(stack.interfaces[i],
                               std::get<MicrofacetSurface>(stack.interfaces[i].bxdf->Model()));
    };
    constexpr float kAngles[] = {0, 30, 90, 200};
    for (size_t i = 0; i < 4; ++i) {
        const float c = std::cos(Radians(kAngles[i])), s = std::sin(Radians(kAngles[i]));
        const Symmetric2 expected = Matrix2{c, -s, s, c}.PushForward({0.08f, 0, 0.005f}),
                         found = covariance(i);
        EXPECT_NEAR(found.xx, expected.xx, 1e-7f) << kAngles[i];
        EXPECT_NEAR(found.xy, expected.xy, 1e-7f) << kAngles[i];
        EXPECT_NEAR(found.yy, expected.yy, 1e-7f) << kAngles[i];
    }
    EXPECT_GT(std::abs(covariance(1).xy), 0.01f) << "negative control: the turn shows";
    EXPECT_NEAR(covariance(4).xy, 0, 1e-8f) << "round ones do not turn";
    EXPECT_NEAR(covariance(4).xx, 0.5f * Sqr(0.3f), 1e-8f);
}

// Facets that an interface draws from a view, in its relative slopes: all facets but for the factor 1 + s.x,
// so dividing by it gives their means and covariances, which are known. Beckmann's distribution: others have
// none. Power: 4.5 standard errors, of 0.004 to 0.02 standard deviations of the slopes.
TEST(RelativeSlopes, HaveTheDistributionOfUnperturbedFacets) {
    Arena arena;
    StackBuilder builder(arena);
    Turned({0.3f, -0.25f, 1}, 35, Dielectric(Alphas(0.35f, 0.1f), 1.5f, kBeckmann))(builder);
    const StackInterface& interface = builder.Build().interfaces[0];
    const RelativeSlopes slopes(interface);
    const Symmetric2 covariance = FacetCovariance(interface, std::get<MicrofacetSurface>(interface.model));
    const Beckmann facets(0.35f, 0.1f);
    Rng rng(SeedOf(FullTestName()));
    const Vec3 w = Normalize(Vec3(-0.5f, 0.3f, 0.8f));
    const Slope view = slopes.View(w, 1e-6f);
    RunningMean x, y, xx, xy, yy, stackX;
    for (int i = 0; i < Scaled(200000); ++i) {
        const Vec3 h =
            interface.frame.FromLocal(facets.SampleVisible(interface.frame.ToLocal(w), rng.Uniform2D()));
        if (!(h.z > 0)) continue;
        ASSERT_TRUE(slopes.Contains(SlopeOf(h)));
        const Slope s = slopes.Of(SlopeOf(h));
        const double weight = 1 / (1 + double(Dot(view, s)));
        x.Add(weight * double(s.x));
        y.Add(weight * double(s.y));
        xx.Add(weight * (double(s.x) * double(s.x) - double(covariance.xx)));
        xy.Add(weight * (double(s.x) * double(s.y) - double(covariance.xy)));
        yy.Add(weight * (double(s.y) * double(s.y) - double(covariance.yy)));
        stackX.Add(weight * double(SlopeOf(h).x));
    }
    for (const RunningMean* mean : {&x, &y, &xx, &xy, &yy})
        EXPECT_LT(std::abs(mean->Mean()), 4.5 * mean->StandardError());
    // Negative controls: about the stack's normal, and without the turn.
    EXPECT_GT(std::abs(stackX.Mean()), 50 * stackX.StandardError());
    EXPECT_GT(std::abs(double(covariance.xy)), 20 * xy.StandardError());
}

TEST(RelativeSlopes, AreUndoneAndHaveTheirDerivatives) {
    Arena arena;
    StackBuilder builder(arena);
    Tilted({0.4f, -0.3f, 1}, Dielectric(0.2f, 1.5f))(builder);
    const StackInterface& interface = builder.Build().interfaces[0];
    const RelativeSlopes slopes(interface);
    EXPECT_TRUE(slopes.IsPerturbed());
    constexpr float kStep = 1e-3f;
    for (const Slope m : {Slope{0.4f, -0.3f}, Slope{0.1f, 0.5f}, Slope{-1, -0.7f}, Slope{2, 1}}) {
        const Slope x = slopes.Of(m), back = slopes.ToStack(x);
        EXPECT_NEAR(back.x, m.x, 1e-5f);
        EXPECT_NEAR(back.y, m.y, 1e-5f);
        const Slope byX = (slopes.Of({m.x + kStep, m.y}) - slopes.Of({m.x - kStep, m.y})) * (0.5f / kStep),
                    byY = (slopes.Of({m.x, m.y + kStep}) - slopes.Of({m.x, m.y - kStep})) * (0.5f / kStep);
        const Matrix2 j = slopes.PerStack(x), one = j * slopes.StackPer(x);
        EXPECT_NEAR(j.xx, byX.x, 2e-3f);
        EXPECT_NEAR(j.yx, byX.y, 2e-3f);
        EXPECT_NEAR(j.xy, byY.x, 2e-3f);
        EXPECT_NEAR(j.yy, byY.y, 2e-3f);
        EXPECT_NEAR(one.xx, 1, 1e-5f);
        EXPECT_NEAR(one.xy, 0, 1e-5f);
        EXPECT_NEAR(slopes.AreaPerStack(x) / j.Determinant(), 1, 1e-5f);
    }
    // A facet at more than a right angle to the normal, and one that is turned down.
    EXPECT_FALSE(slopes.Contains({-4, 3}));
    EXPECT_FALSE(slopes.IsUp({4, -3}));
}

// The peak of (1 + s.m) exp(-m'P m/2) has the gradient s / (1 + s.m) - P m = 0.
TEST(VisibleSlopes, TheModeIsWhereTheDensityIsLevel) {
    for (const float alpha : {1e-4f, 0.1f, 1.f, 30.f})
        for (const float tangent : {1e-4f, 0.5f, 20.f, 1e4f}) {
            const double variance = 0.5 * Sqr(double(alpha)), s = double(tangent);
            const double m = double(ModeOfVisible(float(variance * s * s), float(variance))) * s;
            EXPECT_NEAR(m / variance * (1 + s * m) / s, 1, 1e-5) << alpha << " " << tangent;
        }
}

}  // namespace
}  // namespace lacquer::layered::test::facet_map_test
