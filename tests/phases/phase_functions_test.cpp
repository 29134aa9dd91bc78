// Phase functions of the scattering angle, and mixtures: against closed forms, quadrature and their own
// samples.
#include <gtest/gtest.h>

#include "pbrt/phases/fibre.h"
#include "pbrt/phases/hg.h"
#include "pbrt/phases/isotropic.h"
#include "pbrt/phases/mixture.h"
#include "pbrt/phases/sggx.h"
#include "pbrt/phases/table.h"
#include "pbrt/phases/vmf.h"
#include "phases/phase_checks.h"

namespace lacquer::phase_functions_test {
namespace {

using namespace test;

const Vec3 kWo = Normalize({0.3f, -0.5f, 0.7f});
constexpr float kNumbers[] = {0.2f, 0, 0, 1, 3, 0.5f, 0.5f, 8};

struct Case {
    std::string name;
    const PhaseFunction* phase;
};
// One of each, and the extremes.
std::vector<Case> Cases() {
    static const IsotropicPhase isotropic;
    static const HenyeyGreensteinPhase hg0(0), hgTiny(1e-7f), hg8(0.8f), hgBack(-0.5f), hg999(0.999f),
        hgLast(1), hgFirst(-1);
    static const VonMisesFisherPhase vmf0(0), vmfTiny(1e-6f), vmf3(3), vmf1e4(1e4f);
    static const PhaseTable table(kNumbers);
    static const TabulatedPhase tabulated(table);
    static const FibrePhase fibre({1, 1, 0}, 0.2f);
    static const SggxPhase sheet({0, 1, 1}, 0.3f, true);
    static const PhaseFunction* const scalars[] = {&hg8, &vmf3, &isotropic};
    static const PhaseFunction* const oriented[] = {&fibre, &hgBack, &sheet};
    static const float weights[] = {3, 1, 2};
    static const MixturePhase mixture(scalars, weights), directional(oriented, weights);
    return {{"isotropic", &isotropic}, {"hg 0", &hg0},        {"hg 1e-7", &hgTiny},
            {"hg 0.8", &hg8},          {"hg -0.5", &hgBack},  {"hg 0.999", &hg999},
            {"hg 1", &hgLast},         {"hg -1", &hgFirst},   {"vmf 0", &vmf0},
            {"vmf 1e-6", &vmfTiny},    {"vmf 3", &vmf3},      {"vmf 1e4", &vmf1e4},
            {"table", &tabulated},     {"mixture", &mixture}, {"mixture of flakes", &directional}};
}

// The mixture of flakes has structure away from the axis of scattering.
SphereGrid GridFor(const Case& c) {
    if (c.phase->HasDirectionalExtinction()) return SphereGrid::Fine(-kWo);
    if (c.name == "table") return SphereGrid::Fine(-kWo, 2);
    return SphereGrid::Geometric(c.name.starts_with("hg -") ? kWo : -kWo);
}

// Midpoints in t on 48 geometric steps per 11 decades, 16 points each: relative error (0.53/16)^2/24 times
// a few.
TEST(PhaseFunctions, IntegrateToOne) {
    for (const Case& c : Cases())
        EXPECT_NEAR(GridFor(c).Integral([&](Vec3 wi) { return c.phase->Evaluate(kWo, wi).p; }), 1, 1e-3)
            << c.name;
}

// 200,000 draws over up to 400 cells (744 for flakes and the table): a lobe whose width is wrong by 5 %
// fails, and a table with one of eight numbers wrong by 10 %; see the control.
TEST(PhaseFunctions, SamplesFollowThePdf) {
    const std::vector<Case> cases = Cases();
    const double alpha = SidakAlpha(1e-3, int(cases.size()));
    for (const Case& c : cases)
        EXPECT_TRUE(Passes(FullTestName() + c.name, alpha, [&](uint64_t seed) {
            return SamplesFollow(*c.phase, *c.phase, kWo, GridFor(c), seed);
        }));
}

TEST(PhaseFunctions, SamplesOfSlightlyOtherLobesAreFound) {
    float numbers[8];
    std::copy(std::begin(kNumbers), std::end(kNumbers), numbers);
    numbers[4] = 3.3f;
    const PhaseTable table(kNumbers), otherTable(numbers);
    const HenyeyGreensteinPhase hg8(0.8f), hg82(0.82f), hg999(0.999f), hg99905(0.99905f);
    const VonMisesFisherPhase vmf(1e4f), otherVmf(1.05e4f);
    const TabulatedPhase tabulated(table), otherTabulated(otherTable);
    const PhaseFunction* const parts[] = {&hg8, &vmf};
    const float half[] = {0.5f, 0.5f}, other[] = {0.475f, 0.525f};
    const MixturePhase mixture(parts, half), otherMixture(parts, other);
    const std::pair<const PhaseFunction*, const PhaseFunction*> pairs[] = {{&hg8, &hg82},
                                                                           {&hg999, &hg99905},
                                                                           {&vmf, &otherVmf},
                                                                           {&tabulated, &otherTabulated},
                                                                           {&mixture, &otherMixture}};
    for (const auto& [sampler, model] : pairs) {
        const SphereGrid grid = GridFor({sampler == &tabulated ? "table" : "", sampler});
        const Outcome outcome = SamplesFollow(*sampler, *model, kWo, grid, SeedOf(FullTestName()));
        EXPECT_LT(outcome.pValue, 1e-6) << outcome.details;
    }
}

TEST(PhaseFunctions, RecordsAgreeWithEvaluate) {
    for (const Case& c : Cases())
        EXPECT_TRUE(RecordsAreConsistent(*c.phase, SeedOf(FullTestName() + c.name))) << c.name;
}

// A mixture that forgets to weight by extinction: the mistake that the class comment warns of.
class CarelessMixture final : public PhaseFunction {
  public:
    CarelessMixture(const PhaseFunction& a, const PhaseFunction& b) : a_(a), b_(b) {}
    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override {
        const float p = 0.5f * (a_.Evaluate(wo, wi).p + b_.Evaluate(wo, wi).p);
        return {p, p, 0};
    }
    PhaseSample Sample(Vec3 wo, Rng& rng) const override { return a_.Sample(wo, rng); }
    float Extinction(Vec3 w) const override { return 0.5f * (a_.Extinction(w) + b_.Extinction(w)); }

  private:
    const PhaseFunction &a_, &b_;
};

TEST(PhaseFunctions, AreReciprocal) {
    for (const Case& c : Cases())
        EXPECT_LT(ReciprocityError(*c.phase, SeedOf(FullTestName() + c.name)), 1e-5) << c.name;
    const FibrePhase fibre({1, 1, 0}, 0.2f);
    const IsotropicPhase isotropic;
    EXPECT_GT(ReciprocityError(CarelessMixture(fibre, isotropic), SeedOf(FullTestName())), 0.1);
}

// 100,000 cosines each: the standard error is at most 0.0019.
TEST(PhaseFunctions, MeanCosinesHaveTheirClosedForms) {
    const auto meanOf = [](const PhaseFunction& phase, double expected, uint64_t seed) {
        Rng rng(seed);
        RunningMean mean;
        for (int i = 0; i < 100000; ++i) {
            const Vec3 wo = SampleUniformSphere(rng.Uniform2D());
            mean.Add(1 - 0.5 * double(LengthSquared(phase.Sample(wo, rng).wi + wo)));
        }
        return ZTest(mean, expected, 1e-7, "mean cosine");
    };
    const auto check = [&](const PhaseFunction& phase, double expected, const std::string& name) {
        EXPECT_TRUE(Passes(FullTestName() + name, SidakAlpha(1e-3, 20),
                           [&](uint64_t seed) { return meanOf(phase, expected, seed); }));
    };
    for (const float g : {-0.9f, -0.3f, 0.f, 1e-4f, 0.5f, 0.95f, 0.999f})
        check(HenyeyGreensteinPhase(g), double(g), fmt::format("hg {}", g));
    for (const double kappa : {0.01, 0.5, 4., 100., 1e4})
        check(VonMisesFisherPhase(float(kappa)), 1 / std::tanh(kappa) - 1 / kappa,
              fmt::format("vmf {}", kappa));
    // p = (1 + c) / (4 pi): the mean of c is 1/3.
    const float line[] = {0, 2};
    const PhaseTable table(line);
    check(TabulatedPhase(table), 1. / 3, "line");
    // Forward and backward in the wrong places would not pass.
    EXPECT_LT(meanOf(HenyeyGreensteinPhase(-0.3f), 0.3, SeedOf(FullTestName())).pValue, 1e-6);
    EXPECT_LT(meanOf(HenyeyGreensteinPhase(0.5f), 0.49, SeedOf(FullTestName())).pValue, 1e-4);
}

TEST(HenyeyGreenstein, ValuesInDoubleArithmetic) {
    for (const double g : {-0.9, -0.2, 0., 1e-6, 0.3, 0.97, 0.9995})
        for (const double angle : {0., 1e-4, 1e-3, 0.01, 0.3, 1.5, 3.}) {
            const Vec3 wo(0, 0, -1), wi(float(std::sin(angle)), 0, float(std::cos(angle)));
            const double gf = double(float(g)), s = std::sin(angle / 2);
            const double d = (1 - gf) * (1 - gf) + 4 * gf * s * s;
            const double expected = (1 - gf * gf) / (4 * M_PI * d * std::sqrt(d));
            EXPECT_NEAR(double(HenyeyGreensteinPhase(float(g)).Evaluate(wo, wi).p) / expected, 1, 3e-5)
                << g << ' ' << angle;
        }
}

TEST(VonMisesFisher, ValuesInDoubleArithmetic) {
    for (const double kappa : {1e-5, 0.1, 5., 300., 1e4})
        for (const double angle : {0., 1e-4, 1e-3, 0.01, 0.03}) {
            const Vec3 wo(0, 0, -1), wi(float(std::sin(angle)), 0, float(std::cos(angle)));
            const double k = double(float(kappa)), s = std::sin(angle / 2);
            const double expected = -k / (2 * M_PI * std::expm1(-2 * k)) * std::exp(-2 * k * s * s);
            EXPECT_NEAR(double(VonMisesFisherPhase(float(kappa)).Evaluate(wo, wi).p) / expected, 1, 1e-5)
                << kappa << ' ' << angle;
        }
}

TEST(PhaseTable, SurvivesBadNumbers) {
    const float zero[] = {0, NAN, -1};
    const PhaseTable isotropic(zero);
    const TabulatedPhase phase(isotropic);
    EXPECT_FLOAT_EQ(phase.Evaluate(kWo, {0, 0, 1}).p, Inv4Pi);
    EXPECT_TRUE(RecordsAreConsistent(phase, SeedOf(FullTestName())));
    // Empty segments at both ends and inside are never drawn.
    const float gaps[] = {0, 0, 1, 0, 0, Infinity, 0, 2e30f, 0, 0};
    const PhaseTable gappy(gaps);
    EXPECT_TRUE(RecordsAreConsistent(TabulatedPhase(gappy), SeedOf(FullTestName())));
}

TEST(HenyeyGreenstein, ParametersOutsideOfTheirDomain) {
    EXPECT_FLOAT_EQ(HenyeyGreensteinPhase(NAN).Evaluate(kWo, {0, 0, 1}).p, Inv4Pi);
    EXPECT_FLOAT_EQ(VonMisesFisherPhase(NAN).Evaluate(kWo, {0, 0, 1}).p, Inv4Pi);
    EXPECT_FLOAT_EQ(VonMisesFisherPhase(-1).Evaluate(kWo, {0, 0, 1}).p, Inv4Pi);
    EXPECT_TRUE(RecordsAreConsistent(VonMisesFisherPhase(Infinity), SeedOf(FullTestName())));
    EXPECT_TRUE(RecordsAreConsistent(HenyeyGreensteinPhase(-Infinity), SeedOf(FullTestName())));
}

TEST(Mixture, ZeroWeights) {
    const IsotropicPhase isotropic;
    const HenyeyGreensteinPhase hg(0.9f);
    const PhaseFunction* const parts[] = {&isotropic, &hg};
    const float first[] = {1, 0}, none[] = {0, 0};
    const Vec3 wi = Normalize({1, 2, 3});
    EXPECT_FLOAT_EQ(MixturePhase(parts, first).Evaluate(kWo, wi).p, Inv4Pi);
    EXPECT_FLOAT_EQ(MixturePhase(parts, none).Evaluate(kWo, wi).p, 0.5f * (Inv4Pi + hg.Evaluate(kWo, wi).p));
    EXPECT_EQ(MixturePhase(parts, none).Extinction(wi), 1);
}

}  // namespace
}  // namespace lacquer::phase_functions_test
