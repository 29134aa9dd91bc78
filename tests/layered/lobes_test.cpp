// Lobes by their shape, block by block of the projected hemisphere: the validation stacks of [Guo et al.
// 2018] against paths between triangles, and coats on tilted metal against the analog walk.
#include "layered/agreement.h"
#include "layered/analog_walk.h"
#include "layered/block_lobe.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pbrt/core/parallel.h"

namespace lacquer::layered::test::lobes_test {

namespace {

constexpr int kChannels = BlockLobe::kChannels;
const Vec3 kWo = FromTheLeft(std::sqrt(0.5f));

/// What a block is measured by: itself, or a fifth of the mean where it is darker.
double Unit(const BlockLobe& lobe, size_t block, size_t c) {
    return std::max(lobe.means[block][c], 0.2 * lobe.Integral(int(c)) / 4);
}

// ---- Lobes --------------------------------------------------------------------------------------------

BlockLobe ByValues(const BxDF& bxdf, const Stack& stack, int numValues, uint64_t seed) {
    const LobeQuery query{stack, kWo};
    const GuideDensity guide = GuideOf(query, Hash(seed, 1));
    const ValueFunction f = ValuesOf(bxdf, kWo, query.mode);
    BlockLobeSums sums;
    Rng rng(Hash(seed, 2));
    for (int i = 0; i < numValues; ++i) {
        const GuideDensity::GuidedDirection draw = guide.Sample(rng);
        if (draw.w.z > 0)
            sums.Add(draw.w, f(draw.w, rng) * float(double(draw.w.z) / draw.pdf));
        else
            sums.AddNothing();
    }
    return sums.Lobe();
}

BlockLobe BySampling(const BxDF& bxdf, int numSamples, uint64_t seed) {
    BlockLobeSums sums;
    VisitSamples(bxdf, kWo, TransportMode::Radiance, Lobes::BothSides, numSamples, seed,
                 [&](const std::optional<BxDFSample>& sample) {
                     if (sample && sample->wi.z > 0)
                         sums.Add(sample->wi, sample->weight);
                     else
                         sums.AddNothing();
                 });
    return sums.Lobe();
}

BlockLobe ByWalks(const Stack& stack, int numWalks, uint64_t seed) {
    constexpr int kParts = 16;
    std::array<BlockLobeSums, kParts> parts;
    ParallelFor(kParts, [&](int64_t part) {
        Rng rng(Hash(seed, part));
        for (int i = 0; i < numWalks / kParts; ++i) {
            const auto exit = AnalogWalk(stack, kWo, TransportMode::Radiance, kMaxPathVertices, rng);
            if (exit && exit->wi.z > 0)
                parts[size_t(part)].Add(exit->wi, exit->weight);
            else
                parts[size_t(part)].AddNothing();
        }
    });
    BlockLobeSums sums;
    for (const BlockLobeSums& part : parts) sums.Merge(part);
    return sums.Lobe();
}

// ---- Comparison ---------------------------------------------------------------------------------------

/// How a lobe stands to a reference.
struct Verdict {
    double worstMean = -1;  ///< relative difference of integrals, beyond four standard errors of it
    double distance = 0;    ///< root of the mean squared difference of blocks, in Unit()s
    double noise = 0;       ///< that which the variances of both explain
    double clearShare = 0;  ///< of the blocks, that these are about
    /// Means: the references are good to 0.2 % beside their noise (positions of paths are floats).
    bool MeansAgree() const { return worstMean <= 0.002; }
    /// The noise is an estimate; that of values with rare bright ones is too low.
    bool Agrees() const { return MeansAgree() && distance <= 1.25 * noise + 0.002 && clearShare > 0.9; }
    std::string Describe() const {
        return fmt::format(
            "means differ by {:.2f} % beyond noise, blocks by {:.2f} % ({:.2f} % is noise, {:.0f} % clear)",
            100 * worstMean, 100 * distance, 100 * noise, 100 * clearShare);
    }
};

Verdict Judge(const BlockLobe& ours, const BlockLobe& reference) {
    Verdict verdict;
    for (int c = 0; c < kChannels; ++c) {
        const double difference = std::abs(ours.Integral(c) - reference.Integral(c)),
                     error = std::hypot(ours.IntegralError(c), reference.IntegralError(c));
        verdict.worstMean = std::max(verdict.worstMean, (difference - 4 * error) / reference.Integral(c));
    }
    // Blocks where rare bright values leave nothing to say are left out; there may be few of them.
    constexpr double kBlurred = 0.15;
    double sum = 0, expected = 0;
    int numClear = 0;
    for (size_t b = 0; b < BlockLobe::kBlocks; ++b)
        for (size_t c = 0; c < kChannels; ++c) {
            const double unit = Unit(reference, b, c),
                         variance = (ours.variances[b][c] + reference.variances[b][c]) / Sqr(unit);
            if (variance > Sqr(kBlurred)) continue;
            sum += Sqr((ours.means[b][c] - reference.means[b][c]) / unit);
            expected += variance;
            ++numClear;
        }
    verdict.clearShare = double(numClear) / (kChannels * BlockLobe::kBlocks);
    verdict.distance = std::sqrt(sum / std::max(1, numClear));
    verdict.noise = std::sqrt(expected / std::max(1, numClear));
    return verdict;
}

/// By values of an estimator and by sampling.
/// @param valuesAreNoisy  the fast subset's values tell about means only
void ExpectAgreement(const StackCase& row, const BlockLobe& reference, bool valuesAreNoisy = false) {
    const int numSamples = IsFullRun() ? 4000000 : Scaled(250000);
    const int numValues = IsFullRun() ? 2000000 : Scaled(200000);
    Arena arena;
    const LayeredBxDF* bxdf = row.MakeBxDF(arena, {.estimator = FindEstimator("auto")});
    const uint64_t seed = SeedOf(FullTestName());
    const Verdict values = Judge(ByValues(*bxdf, bxdf->GetStack(), numValues, Hash(seed, 1)), reference);
    EXPECT_TRUE(valuesAreNoisy && !IsFullRun() ? values.MeansAgree() : values.Agrees())
        << "by values: " << values.Describe();
    const Verdict samples = Judge(BySampling(*bxdf, numSamples, Hash(seed, 2)), reference);
    EXPECT_TRUE(samples.Agrees()) << "by sampling: " << samples.Describe();
    testing::Test::RecordProperty("values", values.Describe());
    testing::Test::RecordProperty("samples", samples.Describe());
}

// ---- Validation stacks --------------------------------------------------------------------------------

/// build/release/tests/trace_lobes v1 3e7 tests/layered/lobes/v1.txt
BlockLobe TracedLobe(const std::string& stack) {
    return ReadLobe(LACQUER_SOURCE_DIR "/tests/layered/lobes/" + stack + ".txt");
}

class TracedLobes : public testing::TestWithParam<std::string> {};

TEST_P(TracedLobes, AreThoseOfTheStacks) {
    const bool isNarrow = GetParam() == "v3" || GetParam() == "v4";  // lobes of matter: rare bright values
    ExpectAgreement(FindStackCase(GetParam()), TracedLobe(GetParam()), isNarrow);
}
INSTANTIATE_TEST_SUITE_P(Stacks, TracedLobes, testing::Values("v1", "v2", "v3", "v4"),
                         [](const auto& row) { return row.param; });

// ---- Tilted interfaces --------------------------------------------------------------------------------

// The normal of the coat is tilted away from the light and the metal's towards it by 8.4 degrees each, so
// that the lobe of the coat and that of the metal part.
constexpr float kNormalSlope = 0.148f;
StackCase TiltedCase(float coatAlpha, float metalAlpha, float slope = kNormalSlope) {
    return {.name = "",
            .layers = {Tilted({slope, 0, 1}, Dielectric(coatAlpha, 1.5f, kBeckmann)),
                       Medium(1, 0.95f, Isotropic()), Tilted({-slope, 0, 1}, Mirror(metalAlpha, kBeckmann))}};
}
BlockLobe WalkedLobe(const StackCase& row) {
    Arena arena;
    return ByWalks(row.Build(arena), IsFullRun() ? 16000000 : Scaled(1000000), SeedOf(FullTestName()));
}

struct Roughness {
    const char* name;
    float coat, metal;
};
class TiltedLobes : public testing::TestWithParam<Roughness> {
  protected:
    static void ExpectWalks() {
        const StackCase row = TiltedCase(GetParam().coat, GetParam().metal);
        ExpectAgreement(row, WalkedLobe(row));
    }
};
/// A smooth one and a rough one: what each does with its normal shows beside one of its kind as well.
class TiltedLobesLong : public TiltedLobes {};

TEST_P(TiltedLobes, AreThoseOfWalks) { ExpectWalks(); }
TEST_P(TiltedLobesLong, AreThoseOfWalks) { ExpectWalks(); }
INSTANTIATE_TEST_SUITE_P(Stacks, TiltedLobes,
                         testing::Values(Roughness{"both_rough", 0.1f, 0.1f},
                                         Roughness{"both_smooth", 0.005f, 0.005f}),
                         [](const auto& row) { return row.param.name; });
INSTANTIATE_TEST_SUITE_P(Stacks, TiltedLobesLong,
                         testing::Values(Roughness{"rough_coat", 0.1f, 0.005f},
                                         Roughness{"rough_metal", 0.005f, 0.1f}),
                         [](const auto& row) { return row.param.name; });

// ---- Power --------------------------------------------------------------------------------------------

// What the comparison can find: stacks with one number slightly off.
TEST(BlockLobes, SlightlyDifferentStacksAreFound) {
    if (Scaled(8) != 8) GTEST_SKIP() << "SKIP under sanitizers: too few samples";
    const auto stackOf = [](float coatAlpha, float thickness, float g, float metalAlpha) {
        return StackCase{
            .name = "",
            .layers = {Dielectric(coatAlpha, 1.5f, kBeckmann),
                       Medium(SampledSpectrum(thickness), Lanes(0.5f, 0.7f, 0.95f, 0.95f), HG(g)),
                       Copper(metalAlpha, kBeckmann)}};
    };
    const BlockLobe traced = TracedLobe("v1"), tilted = WalkedLobe(TiltedCase(0.1f, 0.1f));
    const std::tuple<const char*, StackCase, const BlockLobe*> rows[] = {
        {"coat a quarter rougher", stackOf(0.0625f, 1, 0.5f, 0.05f), &traced},
        {"4 % more matter", stackOf(0.05f, 1.04f, 0.5f, 0.05f), &traced},
        {"g = 0.55", stackOf(0.05f, 1, 0.55f, 0.05f), &traced},
        {"metal a quarter rougher", stackOf(0.05f, 1, 0.5f, 0.0625f), &traced},
        {"normals tilted by 7.4 degrees", TiltedCase(0.1f, 0.1f, 0.13f), &tilted},
    };
    for (const auto& [what, row, reference] : rows) {
        Arena arena;
        const LayeredBxDF* bxdf = row.MakeBxDF(arena, {.estimator = FindEstimator("auto")});
        const Verdict verdict = Judge(BySampling(*bxdf, 500000, SeedOf(FullTestName() + what)), *reference);
        EXPECT_FALSE(verdict.Agrees()) << what << ": " << verdict.Describe();
    }
}

TEST(BlockLobes, AFileIsReadAsItWasWritten) {
    const BlockLobe lobe = TracedLobe("v1");
    const std::string copy = testing::TempDir() + "lacquer-lobe.txt";
    WriteLobe(copy, lobe, "# a copy\n");
    const BlockLobe again = ReadLobe(copy);
    for (size_t b = 0; b < BlockLobe::kBlocks; ++b)
        for (size_t c = 0; c < kChannels; ++c)
            EXPECT_NEAR(again.means[b][c], lobe.means[b][c], 1e-4 * lobe.means[b][c]);
    EXPECT_THROW(ReadLobe(copy + ".not"), std::runtime_error);
}

}  // namespace
}  // namespace lacquer::layered::test::lobes_test
