// Measured BRDFs: a file that was made from a known model gives that model back.
#include "pbrt/bxdfs/measured.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "bxdfs/measured_fixture.h"
#include "pbrt/core/sampling.h"
#include "support/bxdf_checks.h"
#include "support/lanes.h"

namespace lacquer::test::measured_test {
namespace {

std::shared_ptr<const MeasuredBrdf> ReadBytes(const std::string& bytes) {
    const std::string path = WriteTestFile("measured.bsdf", bytes);
    struct Remove {
        const std::string& path;
        ~Remove() { std::filesystem::remove(path); }
    } remove{path};
    return MeasuredBrdf::Read(path, {"scene.pbrt", 3, 9});
}
const FacetModel kIsotropic;
const FacetModel kBrushed{.alphaX = 0.25f, .alphaY = 0.5f, .numTheta = 12, .numPhi = 25};

const MeasuredBrdf& BrdfOf(const FacetModel& model) {
    static const auto isotropic = ReadBytes(TensorFileBytes(kIsotropic.Fields()));
    static const auto brushed = ReadBytes(TensorFileBytes(kBrushed.Fields()));
    return model.numPhi == 1 ? *isotropic : *brushed;
}

/// Mean of |f - expected| cos, over the mean of expected cos, for directions that see each other in the
/// highlight and elsewhere.
double MeanError(const MeasuredBrdf& brdf, const FacetModel& model) {
    Rng rng(SeedOf("MeasuredBrdf"));
    const SampledSpectrum lambda = Lanes(400, 500, 600, 700);
    double error = 0, sum = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3 wo = SampleUniformCone(rng.Uniform2D(), std::cos(1.4f)),
                   wi = SampleCosineHemisphere(rng.Uniform2D());
        const SampledSpectrum f = brdf.Evaluate(wo, wi, lambda).f;
        for (int k = 0; k < kNumWavelengths; ++k) {
            const double expected = double(model.Brdf(wo, wi, lambda[k]));
            error += std::abs(double(f[k]) - expected);
            sum += expected;
        }
    }
    return error / sum;
}

// What is left is interpolation between the directions that are tabulated: 5 degrees apart, or 8 and 15.
TEST(MeasuredBrdf, ReproducesTheModelThatTheFileWasMadeFrom) {
    EXPECT_LT(MeanError(BrdfOf(kIsotropic), kIsotropic), 0.02);
    EXPECT_LT(MeanError(BrdfOf(kBrushed), kBrushed), 0.04);
}

TEST(MeasuredBrdfControl, AnotherModelIsNotReproduced) {
    EXPECT_GT(MeanError(BrdfOf(kIsotropic), {.alphaX = 0.33f, .alphaY = 0.33f}), 0.08);
    EXPECT_GT(MeanError(BrdfOf(kBrushed), {.alphaX = 0.5f, .alphaY = 0.25f}), 0.3);
}

TEST(MeasuredBrdf, OneAzimuthIsTheSameAllAround) {
    const SampledSpectrum lambda(550);
    const MeasuredBrdf& brdf = BrdfOf(kIsotropic);
    for (float phi = 0; phi < 6; phi += 0.7f) {
        const auto turned = [&](float theta, float azimuth) {
            return SphericalDirection(std::sin(theta), std::cos(theta), azimuth + phi);
        };
        EXPECT_NEAR(brdf.Evaluate(turned(0.5f, 0), turned(0.7f, 2.6f), lambda).f[0],
                    brdf.Evaluate(SphericalDirection(std::sin(0.5f), std::cos(0.5f), 0),
                                  SphericalDirection(std::sin(0.7f), std::cos(0.7f), 2.6f), lambda)
                        .f[0],
                    1e-4f);
    }
}

// C6, reciprocity, is no property of measured data.
class MeasuredConformance : public testing::TestWithParam<const FacetModel*> {
  protected:
    template <class Function>
    void ForEachDirection(const Function& function) {
        const MeasuredBxDF bxdf(BrdfOf(*GetParam()), SampledWavelengths::SampleVisible(0.3f));
        for (const NamedDirection& direction : OutgoingDirections()) {
            SCOPED_TRACE(direction.name);
            // The inverses of the warps lose digits where the density is small.
            function(direction.name, BxDFSetup{.bxdf = bxdf, .wo = direction.w, .tolerance = 2e-3});
        }
    }
};

TEST_P(MeasuredConformance, C1C2C5C10) {
    ForEachDirection([](const char*, const BxDFSetup& s) {
        EXPECT_TRUE(IsFiniteEverywhere(s));
        EXPECT_TRUE(KeepsToItsLobes(s));
        EXPECT_TRUE(RecordIsConsistent(s));
        EXPECT_TRUE(IsReproducible(s));
    });
}

// Power, at 20,000 samples: a pdf off by 5 % changes the normalisation by 16 standard errors; see
// bxdf_checks.h.
TEST_P(MeasuredConformance, SamplesAgreeWithEvaluate) {
    constexpr std::pair<const char*, Outcome Survey::*> kChecks[] = {
        {"coarse", &Survey::coarseGrid},
        {"moments", &Survey::moments},
        {"normalization", &Survey::normalization},
        {"albedo", &Survey::albedo},
        {"reflected", &Survey::reflected}};
    ForEachDirection([&](const char* name, const BxDFSetup& s) {
        const std::string fullName = FullTestName() + "/" + name;
        const SphereIntegrals integrals = Integrate(s, SeedOf(fullName + "/quadrature"), 1e-4);
        const auto take = [&](uint64_t seed) { return TakeSurvey(s, integrals, 20000, seed); };
        const uint64_t seed = SeedOf(fullName);
        const Survey survey = take(seed);
        for (const auto& [check, outcome] : kChecks)
            EXPECT_TRUE(PassesAt(seed, fullName + "/" + check, 1e-5, survey.*outcome,
                                 [&, member = outcome](uint64_t other) { return take(other).*member; }));
    });
}

// The same check finds a density that is off by 5 %.
TEST(MeasuredControl, ADensityOffByFivePercentIsFound) {
    class Broken final : public BxDF {
      public:
        explicit Broken(const BxDF& original) : original_(original) {}
        Lobes Flags() const override { return original_.Flags(); }
        BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override {
            BxDFValue v = original_.Evaluate(wo, wi, context);
            v.pdf *= 1.05f;
            return v;
        }
        std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u,
                                         const BxDFContext& context) const override {
            return original_.Sample(wo, u, context);
        }

      private:
        const BxDF& original_;
    };
    const MeasuredBxDF bxdf(BrdfOf(kIsotropic), SampledWavelengths::SampleVisible(0.3f));
    const Broken broken(bxdf);
    const BxDFSetup s{.bxdf = broken, .wo = OutgoingDirections()[1].w};
    const SphereIntegrals integrals = Integrate(s, SeedOf(FullTestName()), 1e-4);
    EXPECT_LT(TakeSurvey(s, integrals, 20000, SeedOf(FullTestName())).normalization.pValue, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Measured, MeasuredConformance, testing::Values(&kIsotropic, &kBrushed),
                         [](const auto& row) { return row.param->numPhi == 1 ? "isotropic" : "brushed"; });

/// The smallest file that is complete.
std::vector<TensorField> SmallFields() {
    return {{"theta_i", {2}, {0, 1.5f}},
            {"phi_i", {1}, {0}},
            {"ndf", {2, 2}, {1, 1, 1, 1}},
            {"sigma", {2, 2}, {1, 1, 1, 1}},
            {"vndf", {1, 2, 2, 2}, std::vector<float>(8, 1.f)},
            {"luminance", {1, 2, 2, 2}, std::vector<float>(8, 1.f)},
            {"spectra", {1, 2, 1, 2, 2}, std::vector<float>(8, 1.f)},
            {"wavelengths", {1}, {550}},
            {"jacobian", {1}, {}, "\1"}};
}

TEST(MeasuredBrdf, DamagedFilesAreReadOrRefusedButNothingElse) {
    const std::string whole = TensorFileBytes(SmallFields());
    ASSERT_TRUE(ReadBytes(whole));
    for (size_t size = 0; size < whole.size(); size += 7)
        EXPECT_THROW(ReadBytes(whole.substr(0, size)), SceneError) << size;
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 2000; ++i) {
        std::string damaged = whole;
        for (int k = 0; k < 3; ++k)
            damaged[rng.UniformInt(uint32_t(whole.size()))] = char(rng.UniformInt(256));
        try {
            // What is still read gives numbers, or nothing.
            const auto brdf = ReadBytes(damaged);
            const MeasuredBxDF bxdf(*brdf, SampledWavelengths::SampleVisible(0.5f));
            bxdf.Evaluate({0, 0, 1}, {0.6f, 0, 0.8f}, {});
            const auto s = bxdf.Sample({0, 0.6f, 0.8f}, {0.5f, {0.3f, 0.6f}}, {});
            EXPECT_TRUE(!s || std::isfinite(s->pdf));
        } catch (const SceneError& e) {
            EXPECT_EQ(e.Loc().line, 3);
        }
    }
}

}  // namespace
}  // namespace lacquer::test::measured_test
