// The conformance suite: every row of bxdf_cases.h x direction x transport mode passes the checks C1 to C11.
#include <gtest/gtest.h>

#include "support/bxdf_cases.h"
#include "support/bxdf_checks.h"

namespace lacquer::test::conformance_test {
namespace {

/// One test for each row; directions and modes are loops inside, named in messages and seeds.
class Conformance : public testing::TestWithParam<BxDFCase> {
  protected:
    using Check = testing::AssertionResult (*)(const BxDFSetup&);

    template <class Function>
    void ForEachSetup(const Function& function) {
        const BxDFCase& row = GetParam();
        const SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.3f);
        Arena arena;
        const BxDF* bxdf = row.make(lambda, arena);
        ASSERT_NE(bxdf, nullptr);
        for (const NamedDirection& direction : OutgoingDirections())
            for (const TransportMode mode : kTransportModes) {
                const std::string name = row.name + "_" + direction.name +
                                         (mode == TransportMode::Radiance ? "_radiance" : "_importance");
                SCOPED_TRACE(name);
                function(name,
                         BxDFSetup{*bxdf, direction.w, mode, row.lossless, row.tolerance, row.stochastic,
                                   row.takesMoreNumbers, row.takesThreeNumbers, row.isOneWay});
            }
    }
    void Apply(Check check) {
        ForEachSetup([&](const std::string&, const BxDFSetup& s) { EXPECT_TRUE(check(s)); });
    }
};

TEST_P(Conformance, C1IsFiniteEverywhere) { Apply(IsFiniteEverywhere); }
TEST_P(Conformance, C2KeepsToItsLobes) { Apply(KeepsToItsLobes); }
TEST_P(Conformance, C5RecordIsConsistent) { Apply(RecordIsConsistent); }
TEST_P(Conformance, C6HasAdjoint) { Apply(HasAdjoint); }
TEST_P(Conformance, C9JacobianIsPdf) { Apply(JacobianIsPdf); }
TEST_P(Conformance, C10IsReproducible) { Apply(IsReproducible); }
TEST_P(Conformance, C11SamplesAlikeWithoutPdf) { Apply(SamplesAlikeWithoutPdf); }

// One set of samples serves all of these.
TEST_P(Conformance, C3C4C7C8SamplesAgreeWithEvaluate) {
    constexpr std::pair<const char*, Outcome Survey::*> kChecks[] = {
        {"C3.FineGrid", &Survey::fineGrid}, {"C3.CoarseGrid", &Survey::coarseGrid},
        {"C3.Moments", &Survey::moments},   {"C4.Normalization", &Survey::normalization},
        {"C7.Albedo", &Survey::albedo},     {"C8.Reflected", &Survey::reflected}};
    static_assert(std::size(kChecks) == kOutcomesPerSurvey);
    ForEachSetup([&](const std::string& name, const BxDFSetup& s) {
        const std::string fullName = FullTestName() + "/" + name;
        // The modes rarely differ in what they draw: a quarter of the samples, and of the accuracy, for the
        // second one.
        const int share = s.mode == TransportMode::Radiance ? 1 : 4;
        const SphereIntegrals integrals = Integrate(s, SeedOf(fullName + "/quadrature"), 4e-6 * share);
        const int numSamples = Scaled(GetParam().numSamples / share);
        const auto take = [&](uint64_t seed) { return TakeSurvey(s, integrals, numSamples, seed); };
        const uint64_t seed = SeedOf(fullName);
        const Survey survey = take(seed);
        for (const auto& [check, outcome] : kChecks) {
            if (GetParam().sharesLight && outcome == &Survey::albedo) continue;
            EXPECT_TRUE(PassesAt(seed, fullName + "/" + check, ConformanceAlpha(), survey.*outcome,
                                 [&, member = outcome](uint64_t other) { return take(other).*member; }));
        }
    });
}

INSTANTIATE_TEST_SUITE_P(BxDF, Conformance, testing::ValuesIn(BxDFCases()),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace lacquer::test::conformance_test
