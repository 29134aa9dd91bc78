// The checks of layered stacks fail on estimators and stacks that are broken in the ways that public
// implementations were found to be.
#include <gtest/gtest.h>

#include <array>
#include <set>

#include "layered/agreement.h"
#include "layered/estimators/walk_estimator.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/bxdfs/diffuse.h"
#include "pbrt/bxdfs/multiscatter_conductor.h"
#include "pbrt/core/sampling.h"

namespace lacquer::layered::test::negative_controls_test {

namespace {

const Vec3 kOblique = SphericalDirection(std::sin(Radians(60)), std::cos(Radians(60)), 1.1f);

/// What one query of the agreement test is judged by, as in its full set.
const double kAlpha = SidakAlpha(1e-3, 110 * 6 * 3 * kNumMoments);

/// Walks see `right`, an estimator sees `seen`.
double PValue(const Stack& right, const Stack& seen, const LayeredEstimator& estimator, int numValues,
              Vec3 wo = kOblique) {
    const LobeQuery query{right, wo};
    const ValueFunction f = [&](Vec3 wi, Rng& rng) {
        const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng, false};
        SampledSpectrum value = estimator.Evaluate(seen, wo, wi, context, kMaxPathVertices);
        if (SameHemisphere(wo, wi) || seen.Last() == 0)
            value += seen.interfaces[size_t(seen.OuterTowards(wo))].Evaluate(wo, wi, context).f;
        return value;
    };
    const Agreement a =
        Examine(query, f, {2 * numValues, numValues, 1, numValues}, SeedOf(FullTestName()), 1e300);
    return NormalTwoSided(a.WorstZ());
}
double PValue(const Stack& right, const Stack& seen, int numValues, Vec3 wo = kOblique) {
    return PValue(right, seen, *FindEstimator("bidirectional"), numValues, wo);
}

/// A copy of a stack whose parts can be exchanged.
struct MutableStack {
    std::array<StackInterface, 8> interfaces;
    std::array<Slab, 8> slabs;
    Stack stack;
    explicit MutableStack(const Stack& s) : stack(s) {
        std::copy(s.interfaces.begin(), s.interfaces.end(), interfaces.begin());
        std::copy(s.slabs.begin(), s.slabs.end(), slabs.begin());
        stack.interfaces = {interfaces.data(), s.interfaces.size()};
        stack.slabs = {slabs.data(), s.slabs.size()};
    }
    MutableStack(const MutableStack&) = delete;
    MutableStack& operator=(const MutableStack&) = delete;
};

/// Stack of a row, in an arena of its own.
struct Built {
    Arena arena;
    Stack stack;
    explicit Built(const std::string& name) : stack(FindStackCase(name).Build(arena)) {}
    explicit Built(const std::vector<Layer>& layers)
        : stack(StackCase{.name = "", .layers = layers}.Build(arena)) {}
};

// ---- The walk ---------------------------------------------------------------------------------------------

struct DropsVertices : WalkPolicy {
    static constexpr bool kCountsVertexBeforeSampling = false;
};
struct CountsRouletteTwice : WalkPolicy {
    static constexpr bool kRouletteInBothWeights = true;
};
struct DropsThinMedia : WalkPolicy {
    static constexpr float kThinnestMedium = 0.02f;
};
struct DropsNearVertices : WalkPolicy {
    static constexpr float kNearestVertex = 0.02f;
};
struct StopsAtSpecular : WalkPolicy {
    static constexpr bool kSpecularPasses = false;
};

/// The right policy passes and the broken one fails, at the same effort.
template <class Broken>
void ExpectSeen(const Stack& stack, int numValues) {
    EXPECT_GE(PValue(stack, stack, WalkEstimator<WalkPolicy>(), numValues), kAlpha);
    EXPECT_LT(PValue(stack, stack, WalkEstimator<Broken>(), numValues), kAlpha);
}

TEST(LayeredControl, SeesVerticesDroppedWhereTheNextDrawFails) {
    ExpectSeen<DropsVertices>(Built({Dielectric(0.7f, 1.5f), Metal(1)}).stack, 20000);
}
TEST(LayeredControl, SeesRouletteInBothWeights) {
    ExpectSeen<CountsRouletteTwice>(Built("coat_medium_metal").stack, 40000);
}
TEST(LayeredControl, SeesDroppedThinMedia) {
    ExpectSeen<DropsThinMedia>(Built("nothing_thin_medium_black").stack, 10000);
}
TEST(LayeredControl, SeesVerticesDroppedNearInterfaces) {
    ExpectSeen<DropsNearVertices>(Built("medium_under_nothing").stack, 60000);
}
TEST(LayeredControl, SeesPathsStoppedAtSmoothInterfaces) {
    ExpectSeen<StopsAtSpecular>(Built("smooth_coat_metal_020").stack, 5000);
    ExpectSeen<StopsAtSpecular>(Built("coat_020_mirror_smooth").stack, 5000);
    ExpectSeen<StopsAtSpecular>(Built("smooth_medium_diffuse").stack, 5000);
}
TEST(LayeredControl, SeesPathsStoppedAtNothing) {
    ExpectSeen<StopsAtSpecular>(Built("nothing_over_metal").stack, 5000);
    ExpectSeen<StopsAtSpecular>(Built({Dielectric(0.3f, 1.5f), Nothing(), Metal(0.2f)}).stack, 5000);
    ExpectSeen<StopsAtSpecular>(Built({Dielectric(0.3f, 1.5f), Nothing()}).stack, 5000);
}

// ---- The stack --------------------------------------------------------------------------------------------

/// A dielectric whose transmission carries eta^2 once more.
class ScaledTwice final : public BxDF {
  public:
    ScaledTwice(const BxDF& original, float eta) : original_(original), eta_(eta) {}
    Lobes Flags() const override { return original_.Flags(); }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override {
        BxDFValue value = original_.Evaluate(wo, wi, context);
        if (!SameHemisphere(wo, wi)) value.f *= Scale(context.mode == TransportMode::Radiance ? wo : wi);
        return value;
    }
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u,
                                     const BxDFContext& context) const override {
        std::optional<BxDFSample> s = original_.Sample(wo, u, context);
        if (s && s->IsTransmission())
            s->weight *= Scale(context.mode == TransportMode::Radiance ? wo : s->wi);
        return s;
    }

  private:
    /// Light that leaves gains what it should have lost when it entered, on the side of `w` alone.
    float Scale(Vec3 w) const { return w.z > 0 ? eta_ * eta_ : 1.f; }
    const BxDF& original_;
    float eta_;
};

TEST(LayeredControl, SeesEtaToTheFourth) {
    const Built right("coat_030_metal_010");
    const DielectricBxDF<TrowbridgeReitz> glass(Alphas(0.3f, 0.3f), 1.5f);
    const ScaledTwice broken(glass, 1.5f);
    MutableStack seen(right.stack);
    seen.interfaces[0] = StackInterface(&glass);
    EXPECT_GE(PValue(right.stack, seen.stack, 5000), kAlpha);
    seen.interfaces[0] = StackInterface(&broken);
    EXPECT_LT(PValue(right.stack, seen.stack, 5000), kAlpha);
}

// A frame from the normal alone swaps the tangents of |nx| > |ny|, and with them the two alphas.
TEST(LayeredControl, SeesATangentFrameMadeFromTheNormalAlone) {
    const Built right({Dielectric(0.1f, 1.5f), Tilted({0.1f, 0.3f, 1}, Metal(Alphas(0.05f, 0.5f)))});
    const Vec3 n = right.stack.interfaces[1].frame.z;
    MutableStack seen(right.stack);
    const bool isAlongY = std::abs(n.x) > std::abs(n.y);
    seen.interfaces[1].frame = Frame::FromZX(n, isAlongY ? Vec3(0, 1, 0) : Vec3(1, 0, 0));
    EXPECT_GE(PValue(right.stack, seen.stack, 5000), kAlpha);
    seen.interfaces[1].frame = Frame::FromZX(n, isAlongY ? Vec3(1, 0, 0) : Vec3(0, 1, 0));
    EXPECT_LT(PValue(right.stack, seen.stack, 5000), kAlpha);
}

TEST(LayeredControl, SeesAPerturbedNormalForgotten) {
    const Built right("leaning_metal");
    MutableStack seen(right.stack);
    EXPECT_GE(PValue(right.stack, seen.stack, 5000), kAlpha);
    seen.interfaces[1] = StackInterface(right.stack.interfaces[1].bxdf);
    EXPECT_LT(PValue(right.stack, seen.stack, 5000), kAlpha);
}

TEST(LayeredControl, SeesInterfacesSkipped) {
    // A smooth one, first and last.
    const Built coated("smooth_coat_diffuse_050"), bare({Diffuse(0.5f)});
    EXPECT_LT(PValue(coated.stack, bare.stack, 5000), kAlpha);
    const Built pane({Dielectric(0.3f, 1.5f), Dielectric(0, 1 / 1.5f)}), open({Dielectric(0.3f, 1.5f)});
    EXPECT_LT(PValue(pane.stack, open.stack, 5000), kAlpha);
    // A black one: light that goes on behind it.
    const Built black("coat_over_black"), mirror({Dielectric(0.3f, 1.5f), Mirror(0.1f)});
    EXPECT_LT(PValue(black.stack, mirror.stack, 5000), kAlpha);
    EXPECT_LT(PValue(black.stack, open.stack, 40000), kAlpha);
    EXPECT_GE(PValue(black.stack, black.stack, 5000), kAlpha);
}

TEST(LayeredControl, SeesAMediumWithoutItsAbsorption) {
    const Built right("coat_absorber_metal"), clear({Dielectric(0.2f, 1.5f), Absorber(0), Metal(0.2f)});
    EXPECT_LT(PValue(right.stack, clear.stack, 5000), kAlpha);
}

// ---- Queries ----------------------------------------------------------------------------------------------

/// Makes its randomness from the directions.
class FrozenEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        Rng frozen(Hash(wo, wi));
        BxDFContext own = context;
        own.rng = &frozen;
        return FindEstimator("bidirectional")->Evaluate(stack, wo, wi, own, maxVertices);
    }
};

/// Different values among 64 of one pair of directions: what RandomnessIsTheCallersAndNothingElse looks at.
size_t NumDifferentValues(const LayeredEstimator& estimator) {
    Arena arena;
    const LayeredBxDF* bxdf = FindStackCase("coat_medium_metal").MakeBxDF(arena, {.estimator = &estimator});
    Rng rng(SeedOf(FullTestName()));
    std::set<float> values;
    for (int i = 0; i < 64; ++i)
        values.insert(bxdf->Evaluate(kOblique, Normalize(Vec3(-0.5f, -0.8f, 0.7f)),
                                     {TransportMode::Radiance, Lobes::BothSides, &rng, false})
                          .f[0]);
    return values.size();
}

TEST(LayeredControl, SeesFrozenRandomness) {
    EXPECT_GT(NumDifferentValues(*FindEstimator("bidirectional")), 8u);
    EXPECT_EQ(NumDifferentValues(FrozenEstimator()), 1u);
}

// A BxDF that gives both sides whatever it is asked for: OneSideAloneGivesThatSide finds light on the other.
TEST(LayeredControl, SeesIgnoredSides) {
    Arena arena;
    const LayeredBxDF* bxdf =
        FindStackCase("pane_020_010").MakeBxDF(arena, {.estimator = FindEstimator("bidirectional")});
    const Vec3 below{-kOblique.x, -kOblique.y, -kOblique.z};
    const auto mean = [&](Lobes asked, bool isIgnored) {
        RunningMean m;
        Rng rng(SeedOf(FullTestName()));
        for (int i = 0; i < 1000; ++i)
            m.Add(double(
                bxdf->Evaluate(kOblique, below,
                               {TransportMode::Radiance, isIgnored ? Lobes::BothSides : asked, &rng, false})
                    .f.Average()));
        return m.Mean();
    };
    EXPECT_EQ(mean(Lobes::Reflection, false), 0);
    EXPECT_GT(mean(Lobes::Transmission, false), 0);
    EXPECT_GT(mean(Lobes::Reflection, true), 0);
}

// A base whose walks between facets end after two bounces, where others take what they like.
TEST(LayeredControl, SeesWalksBetweenFacetsThatEndEarly) {
    const auto base = [](int maxBounces) -> Layer {
        return [=](StackBuilder& b) {
            b.AddInterface(b.Memory().New<MultiscatterConductorBxDF<TrowbridgeReitz>>(
                Alphas(0.8f, 0.8f), SampledSpectrum(0), SampledSpectrum(1), maxBounces));
        };
    };
    const Layer coat = RescatteringDielectric(Alphas(0.5f, 0.5f), 1.5f);
    const Built right({coat, base(MultiscatterConductorBxDF<TrowbridgeReitz>::kMaxBounces)}),
        cut({coat, base(2)});
    EXPECT_GT(PValue(right.stack, right.stack, Scaled(30000)), kAlpha);
    EXPECT_LT(PValue(right.stack, cut.stack, Scaled(30000)), kAlpha);
}

// The oracle itself: known answers, so that it cannot be wrong together with the estimators.
TEST(AnalogWalk, FindsAnalyticAlbedos) {
    constexpr int kNumWalks = 200000;
    const auto check = [&](const std::vector<Layer>& layers, Vec3 wo, double above, double below,
                           TransportMode mode = TransportMode::Radiance) {
        const Built built(layers);
        const Moments m = MomentsByWalks({built.stack, wo, mode}, kNumWalks, SeedOf(FullTestName()), true);
        EXPECT_NEAR(m.Mean(0), above, 4.5 * m.StandardError(0) + 1e-5);
        EXPECT_NEAR(m.Mean(kWeightsPerSide), below, 4.5 * m.StandardError(kWeightsPerSide) + 1e-5);
    };
    const Vec3 wo = kOblique;  // 60 degrees: twice the thickness
    check({Nothing(), Absorber(0.4f), Nothing()}, wo, 0, std::exp(-0.8));
    check({Nothing(), Absorber(0.4f), Diffuse(0.5f)}, wo,
          // 2 E_3(0.4): diffuse light on its way up.
          0.5 * std::exp(-0.8) * 2 * 0.2572864, 0);
    // A plate of glass: R + T^2 R / (1 - R^2) and what passes, for both directions of refraction.
    const double r = double(FresnelDielectric(wo.z, 1.5f));
    check({Dielectric(0, 1.5f), Dielectric(0, 1 / 1.5f)}, wo, 2 * r / (1 + r), (1 - r) / (1 + r));
    // Into glass: radiance shrinks by eta^2, importance does not.
    check({Nothing(), Dielectric(0, 1.5f)}, wo, r, (1 - r) / 2.25);
    check({Nothing(), Dielectric(0, 1.5f)}, wo, r, 1 - r, TransportMode::Importance);
    // Isotropic white slab between nothings loses nothing.
    const Built white({Nothing(), Medium(5, 1, Isotropic()), Nothing()});
    const Moments m = MomentsByWalks({white.stack, wo}, 20000, SeedOf(FullTestName()), true);
    EXPECT_NEAR(m.Albedo(), 1, 1e-6);
}

}  // namespace
}  // namespace lacquer::layered::test::negative_controls_test
