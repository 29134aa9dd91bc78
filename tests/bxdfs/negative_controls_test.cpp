// Each check of the conformance suite fails on a BxDF that is broken in the way that it is there to find.
#include <gtest/gtest.h>

#include <atomic>
#include <utility>

#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/bxdfs/diffuse.h"
#include "pbrt/bxdfs/diffuse_transmission.h"
#include "support/bxdf_cases.h"
#include "support/bxdf_checks.h"

namespace lacquer::test::negative_controls_test {
namespace {

const Vec3 kOblique = OutgoingDirections()[1].w;

/// A BxDF whose answers pass through functions that break them.
template <class ChangeValue, class ChangeSample>
class Altered final : public BxDF {
  public:
    Altered(const BxDF& original, ChangeValue value, ChangeSample sample)
        : original_(original), value_(std::move(value)), sample_(std::move(sample)) {}
    Lobes Flags() const override { return original_.Flags(); }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override {
        return value_(original_.Evaluate(wo, wi, context), wo, wi, context);
    }
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u,
                                     const BxDFContext& context) const override {
        const auto sample = original_.Sample(wo, u, context);
        return sample ? std::optional(sample_(*sample, wo)) : std::nullopt;
    }

  private:
    const BxDF& original_;
    ChangeValue value_;
    ChangeSample sample_;
};

const auto kSameSample = [](BxDFSample s, Vec3) { return s; };
const auto kSameValue = [](BxDFValue v, Vec3, Vec3, const BxDFContext&) { return v; };

/// Multiplies the pdf, in both answers, by factor(wo, wi).
template <class Factor>
auto WithPdfTimes(const BxDF& original, Factor factor) {
    return Altered(
        original,
        [=](BxDFValue v, Vec3 wo, Vec3 wi, const BxDFContext&) {
            v.pdf *= factor(wo, wi);
            return v;
        },
        [=](BxDFSample s, Vec3 wo) {
            s.pdf *= factor(wo, s.wi);
            return s;
        });
}

Survey SurveyOf(const BxDF& bxdf, bool lossless = false, int numSamples = 500000) {
    const BxDFSetup s{.bxdf = bxdf, .wo = kOblique, .lossless = lossless};
    return TakeSurvey(s, Integrate(s, SeedOf(FullTestName())), numSamples, Hash(SeedOf(FullTestName()), 1));
}

const DiffuseBxDF kWhite(SampledSpectrum(1));
const ConductorBxDF<TrowbridgeReitz> kMetal(Alphas(0.3f, 0.3f), SampledSpectrum(0.2f), SampledSpectrum(3));
const DielectricBxDF<Beckmann> kGlass(Alphas(0.3f, 0.3f), 1.5f);

TEST(ConformanceControl, UnbrokenModelsPass) {
    for (const BxDF* bxdf : {static_cast<const BxDF*>(&kWhite), static_cast<const BxDF*>(&kMetal),
                             static_cast<const BxDF*>(&kGlass)}) {
        const Survey s = SurveyOf(*bxdf);
        for (const Outcome& o : {s.fineGrid, s.coarseGrid, s.moments, s.normalization, s.albedo, s.reflected})
            EXPECT_GE(o.pValue, ConformanceAlpha()) << o.details;
    }
}

TEST(ConformanceControl, C1SeesNaNInTheSurface) {
    const Altered broken(
        kWhite,
        [](BxDFValue v, Vec3, Vec3 wi, const BxDFContext&) {
            v.f *= wi.z / wi.z;
            return v;
        },
        kSameSample);
    EXPECT_FALSE(IsFiniteEverywhere({broken, kOblique}));
}

TEST(ConformanceControl, C2SeesAWrongFlag) {
    const Altered broken(kGlass, kSameValue, [](BxDFSample s, Vec3) {
        s.lobe = Lobes::SpecularReflection;
        return s;
    });
    EXPECT_FALSE(KeepsToItsLobes({broken, kOblique}));
}

TEST(ConformanceControl, C2SeesSidesThatWereNotAskedFor) {
    class Deaf final : public BxDF {
      public:
        Lobes Flags() const override { return kWhite.Flags(); }
        BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext&) const override {
            return kWhite.Evaluate(wo, wi, {});
        }
        std::optional<BxDFSample> Sample(Vec3, const BxDFRandom&, const BxDFContext&) const override {
            return std::nullopt;
        }
    };
    const Deaf broken;
    EXPECT_FALSE(KeepsToItsLobes({broken, kOblique}));
}

// Non-centrality 1250 at 200 degrees of freedom: seen with certainty.
TEST(ConformanceControl, C3AndC4SeeAPdfThatIsTooLarge) {
    const auto broken = WithPdfTimes(kMetal, [](Vec3, Vec3) { return 1.05f; });
    const Survey s = SurveyOf(broken);
    EXPECT_LT(s.coarseGrid.pValue, ConformanceAlpha());
    EXPECT_LT(s.normalization.pValue, ConformanceAlpha());
}

// A tilt along x keeps the integral. Its effect on the mean of x is 0.02 E[x^2] = 0.005 against a standard
// error of 0.5/sqrt(500000): 7 sigma, 5 are needed, missed by 2 % of all seeds. At a million samples: 10
// sigma, missed never.
TEST(ConformanceControl, C3SeesASmoothTilt) {
    const auto broken = WithPdfTimes(kWhite, [](Vec3, Vec3 wi) { return 1 + 0.02f * wi.x; });
    EXPECT_LT(SurveyOf(broken, false, 1000000).moments.pValue, ConformanceAlpha());
}

// A peak that is moved by one twentieth of a radian keeps its mass: the fine grid sees it.
TEST(ConformanceControl, C3SeesAMisplacedPeak) {
    const ConductorBxDF<TrowbridgeReitz> narrow(Alphas(0.03f, 0.03f), SampledSpectrum(0.2f),
                                                SampledSpectrum(3));
    const Altered broken(
        narrow,
        [&](BxDFValue v, Vec3 wo, Vec3 wi, const BxDFContext& context) {
            const Vec3 turned{std::cos(0.05f) * wi.x - std::sin(0.05f) * wi.y,
                              std::sin(0.05f) * wi.x + std::cos(0.05f) * wi.y, wi.z};
            v.pdf = narrow.Evaluate(wo, turned, context).pdf;
            return v;
        },
        kSameSample);
    EXPECT_LT(SurveyOf(broken).fineGrid.pValue, ConformanceAlpha());
}

TEST(ConformanceControl, C4SeesADroppedNormalization) {
    // The probability of the side is forgotten: the pdf integrates to 2.
    const DiffuseTransmissionBxDF sheet(SampledSpectrum(0.5f), SampledSpectrum(0.5f));
    const auto broken = WithPdfTimes(sheet, [](Vec3, Vec3) { return 2.f; });
    EXPECT_LT(SurveyOf(broken).normalization.pValue, ConformanceAlpha());
}

TEST(ConformanceControl, C5SeesAStalePdf) {
    // The pdf is that of the direction before it was mirrored.
    const Altered broken(kMetal, kSameValue, [](BxDFSample s, Vec3 wo) {
        s.pdf = kMetal.Evaluate(wo, {-s.wi.x, -s.wi.y, s.wi.z}, {}).pdf;
        return s;
    });
    EXPECT_FALSE(RecordIsConsistent({broken, kOblique}));
}

TEST(ConformanceControl, C6SeesAMissingEtaSquared) {
    const Altered broken(
        kGlass,
        [](BxDFValue, Vec3 wo, Vec3 wi, const BxDFContext& context) {
            return kGlass.Evaluate(wo, wi, {TransportMode::Importance, context.sides, context.rng});
        },
        kSameSample);
    EXPECT_FALSE(HasAdjoint({.bxdf = broken, .wo = kOblique, .tolerance = 3e-5}));
}

TEST(ConformanceControl, C6SeesABiasOfAStochasticModel) {
    const NoisyDiffuse noisy(0.8f);
    // A mean that depends on wo by 20 %: 8 sigma in 4000 evaluations of relative noise 0.58, against 6.
    const Altered broken(
        noisy,
        [](BxDFValue v, Vec3 wo, Vec3, const BxDFContext&) {
            v.f *= 1 + 0.5f * wo.z;
            return v;
        },
        kSameSample);
    EXPECT_TRUE(HasAdjoint({.bxdf = noisy, .wo = {0, 0, 1}, .stochastic = true}));
    EXPECT_FALSE(HasAdjoint({.bxdf = broken, .wo = {0, 0, 1}, .stochastic = true}));
}

TEST(ConformanceControl, C7SeesAGain) {
    // Weights of a lossless model do not vary: any gain above rounding is seen.
    const Altered broken(kWhite, kSameValue, [](BxDFSample s, Vec3) {
        s.weight *= 1.02f;
        return s;
    });
    EXPECT_LT(SurveyOf(broken, true).albedo.pValue, ConformanceAlpha());
    EXPECT_LT(SurveyOf(broken, false).albedo.pValue, ConformanceAlpha())
        << "an albedo above 1 is seen without the mark, too";
}

TEST(ConformanceControl, C8SeesSwappedDirections) {
    // f(wi, wo) instead of f(wo, wi): for refracted radiance they differ by eta^4 = 5.
    const Altered broken(
        kGlass,
        [](BxDFValue v, Vec3 wo, Vec3 wi, const BxDFContext& context) {
            v.f = kGlass.Evaluate(wi, wo, context).f;
            return v;
        },
        kSameSample);
    EXPECT_LT(SurveyOf(broken).reflected.pValue, ConformanceAlpha());
}

TEST(ConformanceControl, C9SeesAMissingHalfVectorJacobian) {
    // The density of the half vector is returned in place of that of wi: a factor 4 |wo.wm|.
    const auto broken =
        WithPdfTimes(kMetal, [](Vec3 wo, Vec3 wi) { return 4 * Dot(wo, Normalize(wo + wi)); });
    EXPECT_TRUE(JacobianIsPdf({kMetal, kOblique}));
    EXPECT_FALSE(JacobianIsPdf({broken, kOblique}));
}

TEST(ConformanceControl, C10SeesStaticState) {
    static std::atomic<int> calls = 0;
    const Altered broken(
        kWhite,
        [](BxDFValue v, Vec3, Vec3, const BxDFContext&) {
            v.pdf *= 1 + 1e-3f * float(++calls % 7);
            return v;
        },
        kSameSample);
    EXPECT_FALSE(IsReproducible({broken, kOblique}));
}

/// Draws without densities as `change` spoils them.
template <class Change>
class SpoiledWithoutPdf final : public BxDF {
  public:
    SpoiledWithoutPdf(const BxDF& original, Change change) : original_(original), change_(change) {}
    Lobes Flags() const override { return original_.Flags(); }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override {
        return original_.Evaluate(wo, wi, context);
    }
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u,
                                     const BxDFContext& context) const override {
        std::optional<BxDFSample> sample = original_.Sample(wo, u, context);
        if (sample && !context.needsSamplePdf) change_(&sample, u);
        return sample;
    }

  private:
    const BxDF& original_;
    Change change_;
};

TEST(ConformanceControl, C11SeesOtherSamples) {
    static const DielectricBxDF<Beckmann> polished(Alphas(0, 0), 1.5f);
    const auto passes = [](const BxDF& original, auto change) {
        return bool(SamplesAlikeWithoutPdf({SpoiledWithoutPdf(original, change), kOblique}));
    };
    using Sample = std::optional<BxDFSample>;
    for (const BxDF* bxdf : {static_cast<const BxDF*>(&kMetal), static_cast<const BxDF*>(&kGlass)}) {
        EXPECT_TRUE(passes(*bxdf, [](Sample*, const BxDFRandom&) {}));
        EXPECT_TRUE(passes(*bxdf, [](Sample* s, const BxDFRandom&) { (*s)->pdf = (*s)->pdfReverse = 0; }));
        EXPECT_FALSE(passes(*bxdf, [](Sample* s, const BxDFRandom&) { (*s)->weight *= 1.002f; }));
        EXPECT_FALSE(passes(*bxdf, [](Sample* s, const BxDFRandom&) { (*s)->wi.x = -(*s)->wi.x; }));
        EXPECT_FALSE(passes(*bxdf, [](Sample* s, const BxDFRandom& u) {
            if (u.lobe < 0.02f) s->reset();
        }));
    }
    // What only one of its sides does.
    EXPECT_FALSE(passes(kGlass, [](Sample* s, const BxDFRandom&) {
        if ((*s)->IsTransmission()) (*s)->weight *= 1.002f;
    }));
    EXPECT_FALSE(passes(kGlass, [](Sample* s, const BxDFRandom&) { (*s)->eta = 1; }));
    EXPECT_FALSE(passes(kGlass, [](Sample* s, const BxDFRandom&) {
        if ((*s)->IsReflection()) (*s)->lobe = Lobes::SpecularReflection;
    }));
    EXPECT_TRUE(passes(polished, [](Sample*, const BxDFRandom&) {}));
    EXPECT_FALSE(passes(polished, [](Sample* s, const BxDFRandom&) { (*s)->pdf *= 0.5f; }));
    EXPECT_FALSE(passes(polished, [](Sample* s, const BxDFRandom&) { (*s)->pdfReverse = 0; }));
}

}  // namespace
}  // namespace lacquer::test::negative_controls_test
