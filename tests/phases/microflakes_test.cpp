// Microflakes: extinction against brute force and closed forms, p against quadrature and samples.
#include <gtest/gtest.h>

#include <cmath>

#include "pbrt/phases/fibre.h"
#include "pbrt/phases/sggx.h"
#include "phases/phase_checks.h"

namespace lacquer::microflakes_test {
namespace {

using namespace test;

const Vec3 kAxis = Normalize({0.5f, 0.5f, 0.2f});
// Along the axis, nearly so, in between, nearly across.
const Vec3 kViews[] = {kAxis, Normalize(kAxis + Vec3(0.02f, 0, 0)), Normalize({0.3f, -0.5f, 0.7f}),
                       Normalize({0.5f, -0.52f, 0.01f})};

// Near -wo the half vector of float directions has few digits, which narrow lobes show.
constexpr float kTolerance = 2e-3f;

struct Case {
    std::string name;
    const PhaseFunction* phase;
};
std::vector<Case> Cases() {
    static const FibrePhase needle(kAxis, 0.01f), thin(kAxis, 0.05f), fibre(kAxis, 0.3f), wide(kAxis, 0.7f),
        loose(kAxis, 10);
    static const SggxPhase sggxFibre(kAxis, 0.2f, false), sggxThin(kAxis, 0.03f, false),
        sheet(kAxis, 0.2f, true), isotropic(kAxis, 1, true);
    return {{"fibre 0.01", &needle},        {"fibre 0.05", &thin},      {"fibre 0.3", &fibre},
            {"fibre 0.7", &wide},           {"fibre 10", &loose},       {"sggx fibre 0.2", &sggxFibre},
            {"sggx fibre 0.03", &sggxThin}, {"sggx sheet 0.2", &sheet}, {"sggx isotropic", &isotropic}};
}

// Midpoints: 16 x 80 in each of 62 x 12 cells about -wo, where p depends on the azimuth down to any distance.
// Lobes of needles, wide 0.01, have some points across.
TEST(Microflakes, IntegrateToOne) {
    for (const Case& c : Cases())
        for (const Vec3 wo : kViews)
            EXPECT_NEAR(SphereGrid::Fine(-wo).Integral([&](Vec3 wi) { return c.phase->Evaluate(wo, wi).p; }),
                        1, 1e-3)
                << c.name << ' ' << Dot(wo, kAxis);
}

// 200,000 draws over 744 cells: 5 % in the width of a lobe fail; see the control.
TEST(Microflakes, SamplesFollowThePdf) {
    // Needles: the edges of cells cut through lobes 0.01 wide.
    const std::vector<Case> cases = Cases();
    const double alpha = SidakAlpha(1e-3, int(cases.size() * std::size(kViews)));
    for (const Case& c : cases)
        for (const Vec3 wo : kViews) {
            const SphereGrid grid = SphereGrid::Fine(-wo, c.name == "fibre 0.01" ? 160 : 80);
            EXPECT_TRUE(
                Passes(fmt::format("{} {} {}", FullTestName(), c.name, wo.x), alpha,
                       [&](uint64_t seed) { return SamplesFollow(*c.phase, *c.phase, wo, grid, seed); }));
        }
}

TEST(Microflakes, SamplesOfSlightlyOtherFlakesAreFound) {
    const FibrePhase fibre(kAxis, 0.3f), otherFibre(kAxis, 0.315f), thin(kAxis, 0.05f),
        otherThin(kAxis, 0.0525f);
    const SggxPhase sggx(kAxis, 0.2f, false), otherSggx(kAxis, 0.21f, false), sheet(kAxis, 0.2f, true),
        otherSheet(kAxis, 0.21f, true);
    const std::pair<const PhaseFunction*, const PhaseFunction*> pairs[] = {
        {&fibre, &otherFibre}, {&thin, &otherThin}, {&sggx, &otherSggx}, {&sheet, &otherSheet}};
    const SphereGrid grid = SphereGrid::Fine(-kViews[2]);
    for (const auto& [sampler, model] : pairs) {
        const Outcome outcome = SamplesFollow(*sampler, *model, kViews[2], grid, SeedOf(FullTestName()));
        EXPECT_LT(outcome.pValue, 1e-6) << outcome.details;
    }
}

TEST(Microflakes, RecordsAgreeWithEvaluate) {
    for (const Case& c : Cases())
        EXPECT_TRUE(RecordsAreConsistent(*c.phase, SeedOf(FullTestName() + c.name), kTolerance)) << c.name;
}

// p alone, as if the extinction were the same in all directions, is far from symmetric.
class ForgetsExtinction final : public PhaseFunction {
  public:
    explicit ForgetsExtinction(const PhaseFunction& phase) : phase_(phase) {}
    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override { return phase_.Evaluate(wo, wi); }
    PhaseSample Sample(Vec3 wo, Rng& rng) const override { return phase_.Sample(wo, rng); }

  private:
    const PhaseFunction& phase_;
};

TEST(Microflakes, AreReciprocalWithTheirExtinction) {
    for (const Case& c : Cases()) {
        EXPECT_LT(ReciprocityError(*c.phase, SeedOf(FullTestName() + c.name)), 1e-5) << c.name;
        if (c.name == "fibre 10" || c.name == "sggx isotropic") continue;
        EXPECT_GT(ReciprocityError(ForgetsExtinction(*c.phase), SeedOf(FullTestName() + c.name)), 0.2);
    }
}

TEST(Microflakes, WithoutOrderTheyScatterEvenly) {
    const SggxPhase sggx(kAxis, 1, false);
    const FibrePhase fibre(kAxis, 100);
    for (const Vec3 wo : kViews)
        for (const Vec3 wi : {Vec3(0, 0, 1), Vec3(0.6f, 0.8f, 0), -wo, wo}) {
            EXPECT_NEAR(sggx.Evaluate(wo, wi).p, Inv4Pi, 1e-6f);
            EXPECT_NEAR(fibre.Evaluate(wo, wi).p, Inv4Pi, 1e-5f);
            EXPECT_NEAR(sggx.Extinction(wo), 1, 1e-6f);
            EXPECT_NEAR(fibre.Extinction(wo), 0.5f, 1e-5f);
        }
}

// The definition, in double: midpoints of |w.m| D(m) over normals with z along the fibre. The kink of the
// absolute value leaves about 1e-6. z reaches to `range`, in steps that shrink where the radius has an
// infinite slope, and D(z) need not be normalised.
template <class Density>
double BruteForce(double cosTheta, double range, const Density& density) {
    constexpr int kN = 1500, kM = 720;
    const double sinTheta = std::sqrt(1 - cosTheta * cosTheta);
    double sum = 0, total = 0;
    for (int i = 0; i < kN; ++i) {
        const double x = 2 * (i + 0.5) / kN - 1, z = range * x * (1.5 - 0.5 * x * x);
        const double radius = std::sqrt(1 - z * z), d = density(z) * (1 - x * x);
        double ring = 0;
        for (int j = 0; j < kM; ++j)
            ring += std::abs(cosTheta * z + sinTheta * radius * std::cos(2 * M_PI * (j + 0.5) / kM));
        sum += d * ring / kM;
        total += d;
    }
    return sum / total;
}

TEST(FibreExtinction, IsTheMeanCosineOfTheFlakes) {
    for (const double s : {0.01, 0.04, 0.2, 0.5, 1., 10.})
        for (const double cosTheta : {1., 0.9999, 0.99, 0.7, 0.3, 0.02, 0.}) {
            const double judge = BruteForce(cosTheta, std::min(1., 8 * s),
                                            [&](double z) { return std::exp(-z * z / (2 * s * s)); });
            const double sin2 = 1 - cosTheta * cosTheta;
            EXPECT_NEAR(FibreProjectedArea(s, std::sqrt(sin2)) / judge, 1, 2e-5) << s << ' ' << cosTheta;
            EXPECT_NEAR(double(FibreExtinction(float(s))(float(sin2), float(cosTheta * cosTheta))) / judge, 1,
                        2e-5);
        }
}

// Along: integral of |z| over a cut-off Gaussian. Across: modified Bessel functions of 1/(4 s^2). And any
// convex body's projected area averages to a quarter of its surface: flakes of two sides, 1/2.
TEST(FibreExtinction, ClosedForms) {
    for (const double s : {0.05, 0.1, 0.3, 1., 5.}) {
        const double c = 1 / (2 * M_PI * std::sqrt(2 * M_PI) * s * std::erf(1 / (std::sqrt(2.) * s)));
        const double q = 1 / (4 * s * s), along = 4 * M_PI * c * s * s * (1 - std::exp(-2 * q));
        const double across =
            2 * M_PI * c * std::exp(-q) * (std::cyl_bessel_i(0., q) + std::cyl_bessel_i(1., q));
        EXPECT_NEAR(FibreProjectedArea(s, 0) / along, 1, 1e-11);
        EXPECT_NEAR(FibreProjectedArea(s, 1) / across, 1, 1e-11);
        const FibreExtinction extinction{float(s)};
        EXPECT_NEAR(double(extinction(0, 1)) / along, 1, 1e-6);
        EXPECT_NEAR(double(extinction(1, 0)) / across, 1, 1e-6);
        EXPECT_NEAR(double(extinction.Normalization()) / c, 1, 1e-6);

        constexpr int kN = 4000;
        double mean = 0;
        for (int i = 0; i < kN; ++i) {
            const double z = (i + 0.5) / kN;
            mean += FibreProjectedArea(s, std::sqrt(1 - z * z)) / kN;
        }
        EXPECT_NEAR(mean, 0.5, 1e-6) << s;
    }
}

TEST(FibreExtinction, TableIsAccurateToOnePartInAMillion) {
    double worst = 0;
    for (double s = 0.001; s < 100; s *= 1.037)
        for (int i = 0; i <= 60; ++i) {
            // Angles crowd where the sine is about s.
            const double x = double(i) / 60, sine = std::min(1., x < 0.5 ? 8 * s * x : 2 * x - 1);
            const FibreExtinction extinction{float(s)};
            const double judge = FibreProjectedArea(double(float(s)), sine);
            const double value = double(extinction(float(sine * sine), float(1 - sine * sine)));
            worst = std::max(worst, std::abs(value / judge - 1));
        }
    EXPECT_LT(worst, 1e-6);
    RecordProperty("worst", fmt::format("{:.3g}", worst));
}

TEST(Sggx, ExtinctionIsTheProjectedAreaOfItsFlakes) {
    for (const bool isSurface : {false, true})
        for (const double r : {0.1, 0.3, 1.})
            for (const double cosTheta : {1., 0.8, 0.1, 0.}) {
                // D over z of the normals. It integrates to a surface, not to 1, so compare with the value
                // along the axis; that one is the matrix' definition.
                const double across = isSurface ? r : 1, along = isSurface ? 1 : r;
                const auto density = [&](double z) {
                    const double form = (1 - z * z) / (across * across) + z * z / (along * along);
                    return 1 / (form * form);
                };
                const double judge = BruteForce(cosTheta, 1, density) / BruteForce(1, 1, density) * along;
                const SggxPhase phase({0, 0, 1}, float(r), isSurface);
                const Vec3 w(float(std::sqrt(1 - cosTheta * cosTheta)), 0, float(cosTheta));
                EXPECT_NEAR(double(phase.Extinction(w)) / judge, 1, 1e-4) << r << ' ' << cosTheta;
            }
}

TEST(Microflakes, ParametersOutsideOfTheirDomain) {
    for (const float x : {NAN, 0.f, -1.f, 1e-30f, 1e30f, Infinity})
        for (const Vec3 axis : {Vec3(0), Vec3(NAN, 0, 1), Vec3(1e-3f, 0, 0), Vec3(Infinity, 0, 0)}) {
            EXPECT_TRUE(RecordsAreConsistent(FibrePhase(axis, x), SeedOf(FullTestName()), kTolerance)) << x;
            EXPECT_TRUE(RecordsAreConsistent(SggxPhase(axis, x, false), SeedOf(FullTestName()), kTolerance))
                << x;
            EXPECT_TRUE(RecordsAreConsistent(SggxPhase(axis, x, true), SeedOf(FullTestName()), kTolerance))
                << x;
        }
    // A direction that is no number ends the draw all the same.
    Rng rng(SeedOf(FullTestName()));
    (void)FibrePhase(kAxis, 0.1f).Sample(Vec3(NAN), rng);
}

}  // namespace
}  // namespace lacquer::microflakes_test
