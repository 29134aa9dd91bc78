// The lobes that [Guo et al. 2018] published with their code, where the images are at hand: values and
// densities of the validation stacks on the projected unit disk.
//
// The files hold f |cos theta_i| and pdf |cos theta_i| of directions wi = (u, v, sqrt(1 - u^2 - v^2)); u runs to
// the right in [-1, 1] and light arrives from u < 0, so that the mirrored peak is at u = sin(45 deg).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "layered/agreement.h"
#include "pbrt/image/image.h"

namespace lacquer::test {
namespace {

constexpr int kBlocks = 16;  ///< a side
constexpr int kChannels = 3;
using Channels = std::array<double, kChannels>;

std::string FileOf(const std::string& name) {
    return LACQUER_SOURCE_DIR "/../shared/references/guo2018/" + name + ".exr";
}
bool IsThere(const std::string& name) { return std::filesystem::exists(FileOf(name)); }

/// Means of an image over square blocks of its pixels. One channel fills all three.
struct Lobe {
    std::array<Channels, kBlocks * kBlocks> blocks{};

    /// Integral over the disk's square.
    double Integral(int c) const {
        double sum = 0;
        for (const Channels& b : blocks) sum += b[size_t(c)];
        return sum * 4 / (kBlocks * kBlocks);
    }
};

Lobe ReadLobe(const std::string& name) {
    const Image image = ReadImage(FileOf(name), {}, {});
    const int side = image.Resolution().x, perBlock = side / kBlocks;
    Lobe lobe;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
            for (int c = 0; c < kChannels; ++c)
                lobe.blocks[size_t(y / perBlock * kBlocks + x / perBlock)][size_t(c)] +=
                    double(image.Get({x, y}, std::min(c, image.NumChannels() - 1))) / Sqr(perBlock);
    return lobe;
}

Lobe MeanOf(const Lobe& a, const Lobe& b) {
    Lobe mean;
    for (size_t i = 0; i < a.blocks.size(); ++i)
        for (size_t c = 0; c < kChannels; ++c) mean.blocks[i][c] = (a.blocks[i][c] + b.blocks[i][c]) / 2;
    return mean;
}

/// The same of a stack of ours, from random directions.
class LobeSums {
  public:
    void AddNothing() { ++count_; }
    /// @param value  g |cos theta_i| / pdf of a direction, where the image holds g |cos theta_i|
    void Add(Vec3 wi, SampledSpectrum value) {
        ++count_;
        const auto column = [](float u) { return std::clamp(int((u + 1) / 2 * kBlocks), 0, kBlocks - 1); };
        // A block's mean is an integral over the disk: dA = |cos theta_i| d(solid angle).
        const double toImage = double(std::abs(wi.z)) * kBlocks * kBlocks / 4;
        const size_t block = size_t(column(-wi.y) * kBlocks + column(wi.x));
        for (size_t c = 0; c < kChannels; ++c) {
            const double v = double(value[int(c)]) * toImage;
            sums_[block][c] += v;
            squares_[block][c] += v * v;
        }
    }
    Lobe Means() const {
        Lobe lobe;
        for (size_t i = 0; i < sums_.size(); ++i)
            for (size_t c = 0; c < kChannels; ++c) lobe.blocks[i][c] = sums_[i][c] / count_;
        return lobe;
    }
    Lobe Variances() const {
        Lobe lobe;
        for (size_t i = 0; i < sums_.size(); ++i)
            for (size_t c = 0; c < kChannels; ++c)
                lobe.blocks[i][c] = std::max(0., squares_[i][c] / count_ - Sqr(sums_[i][c] / count_)) / count_;
        return lobe;
    }
    /// Standard error of Integral(), blocks taken as independent.
    double IntegralError(int c) const {
        const Lobe variances = Variances();
        double sum = 0;
        for (const Channels& b : variances.blocks) sum += b[size_t(c)];
        return std::sqrt(sum) * 4 / (kBlocks * kBlocks);
    }

  private:
    double count_ = 0;
    std::array<Channels, kBlocks * kBlocks> sums_{}, squares_{};
};

/// What a block is measured by: itself, or 3 % of the mean where it is darker.
double Unit(const Lobe& lobe, size_t block, size_t c) {
    return std::max(lobe.blocks[block][c], 0.03 * lobe.Integral(int(c)) / 4);
}

/// Root of the mean square over all blocks and channels of relative differences.
double Distance(const Lobe& a, const Lobe& b) {
    double sum = 0;
    for (size_t i = 0; i < a.blocks.size(); ++i)
        for (size_t c = 0; c < kChannels; ++c)
            sum += Sqr((a.blocks[i][c] - b.blocks[i][c]) / Unit(b, i, c)) / kChannels;
    return std::sqrt(sum / double(a.blocks.size()));
}
/// What noise alone makes of it.
double ExpectedDistance(const LobeSums& ours, const Lobe& theirs) {
    const Lobe variances = ours.Variances();
    double sum = 0;
    for (size_t i = 0; i < theirs.blocks.size(); ++i)
        for (size_t c = 0; c < kChannels; ++c)
            sum += variances.blocks[i][c] / Sqr(Unit(theirs, i, c)) / kChannels;
    return std::sqrt(sum / double(theirs.blocks.size()));
}

Vec3 FromTheLeft(float sinTheta) { return {-sinTheta, 0, SafeSqrt(1 - Sqr(sinTheta))}; }

// ---- Values -------------------------------------------------------------------------------------------

LobeSums ByValues(const BxDF& bxdf, const Stack& stack, Vec3 wo, int numValues, uint64_t seed) {
    const LobeQuery query{stack, wo};
    const GuideDensity guide = GuideOf(query, Hash(seed, 1));
    const ValueFunction f = ValuesOf(bxdf, wo, query.mode);
    LobeSums sums;
    Rng rng(Hash(seed, 2));
    for (int i = 0; i < numValues; ++i) {
        const GuideDensity::Draw draw = guide.Sample(rng);
        if (draw.w.z > 0)
            sums.Add(draw.w, f(draw.w, rng) * float(double(draw.w.z) / draw.pdf));
        else
            sums.AddNothing();
    }
    return sums;
}

LobeSums BySampling(const BxDF& bxdf, Vec3 wo, int numSamples, uint64_t seed) {
    LobeSums sums;
    Rng rng(seed);
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
    for (int i = 0; i < numSamples; ++i) {
        const float lobe = rng.Uniform();
        const auto sample = bxdf.Sample(wo, {lobe, rng.Uniform2D()}, context);
        if (sample && sample->wi.z > 0)
            sums.Add(sample->wi, sample->weight);
        else
            sums.AddNothing();
    }
    return sums;
}

/// How a lobe of ours stands to the authors'. Their own two best images, one by evaluation and one by
/// sampling, tell how much noise they have: if ours had none, its distance to their mean would be half of
/// that between the two.
struct Verdict {
    double worstMean = 0;  ///< relative difference of integrals, beyond four of our standard errors
    double distance = 0, allowedDistance = 0;
    bool Agrees() const { return worstMean <= 0.01 && distance <= allowedDistance; }
    std::string Describe() const {
        return fmt::format("means differ by {:.2f} % beyond noise, blocks by {:.2f} % ({:.2f} % allowed)",
                           100 * worstMean, 100 * distance, 100 * allowedDistance);
    }
};

Verdict Judge(const LobeSums& ours, const std::string& name) {
    const Lobe evaluated = ReadLobe(name + "_bsdf_eval_bi"), sampled = ReadLobe(name + "_bsdf_sample"),
               means = ours.Means();
    Verdict verdict;
    for (const Lobe& theirs : {evaluated, sampled, ReadLobe(name + "_bsdf_eval_uni")})
        for (int c = 0; c < kChannels; ++c) {
            const double difference = std::abs(means.Integral(c) - theirs.Integral(c));
            verdict.worstMean = std::max(
                verdict.worstMean, (difference - 4 * ours.IntegralError(c)) / theirs.Integral(c));
        }
    const Lobe theirs = MeanOf(evaluated, sampled);
    constexpr double kSlack = 1.25;  // their two images need not be equally noisy
    verdict.distance = Distance(means, theirs);
    verdict.allowedDistance =
        kSlack * std::hypot(Distance(evaluated, sampled) / 2, ExpectedDistance(ours, theirs));
    return verdict;
}

class PublishedValues : public testing::TestWithParam<std::string> {};

TEST_P(PublishedValues, HaveTheirMeansAndShape) {
    const std::string name = "val" + GetParam().substr(1);
    if (!IsThere(name + "_bsdf_eval_bi")) GTEST_SKIP() << "SKIP published lobes: no images of " << name;
    const int numSamples = IsFullRun() ? 4000000 : Scaled(250000);
    const int numValues = IsFullRun() ? 2000000 : Scaled(100000);
    Arena arena;
    const LayeredBxDF* bxdf =
        FindStackCase(GetParam()).MakeBxDF(arena, {.estimator = FindEstimator("auto")});
    const Vec3 wo = FromTheLeft(std::sqrt(0.5f));
    const uint64_t seed = SeedOf(FullTestName());
    const Verdict values = Judge(ByValues(*bxdf, bxdf->GetStack(), wo, numValues, Hash(seed, 1)), name);
    EXPECT_TRUE(values.Agrees()) << "by values: " << values.Describe();
    const Verdict samples = Judge(BySampling(*bxdf, wo, numSamples, Hash(seed, 2)), name);
    EXPECT_TRUE(samples.Agrees()) << "by sampling: " << samples.Describe();
    RecordProperty("values", values.Describe());
    RecordProperty("samples", samples.Describe());
}
INSTANTIATE_TEST_SUITE_P(Stacks, PublishedValues, testing::Values("v1", "v2", "v3", "v4"),
                         [](const auto& row) { return row.param; });

// What the comparison can find: the first stack with one number slightly off.
TEST(PublishedLobes, SlightlyDifferentStacksAreFound) {
    if (!IsThere("val1_bsdf_eval_bi")) GTEST_SKIP() << "SKIP published lobes: no images of val1";
    const auto stackOf = [](float coatAlpha, float thickness, float g, float metalAlpha) {
        return StackCase{.name = "",
                         .layers = {Dielectric(coatAlpha, 1.5f, kBeckmann),
                                    Medium(SampledSpectrum(thickness), Lanes(0.5f, 0.7f, 0.95f, 0.95f), HG(g)),
                                    Copper(metalAlpha, kBeckmann)}};
    };
    const std::pair<const char*, StackCase> rows[] = {
        {"coat 10 % rougher", stackOf(0.055f, 1, 0.5f, 0.05f)},
        {"4 % more matter", stackOf(0.05f, 1.04f, 0.5f, 0.05f)},
        {"g = 0.53", stackOf(0.05f, 1, 0.53f, 0.05f)},
        {"metal half again as rough", stackOf(0.05f, 1, 0.5f, 0.075f)},
    };
    for (const auto& [what, row] : rows) {
        Arena arena;
        const LayeredBxDF* bxdf = row.MakeBxDF(arena, {.estimator = FindEstimator("auto")});
        const Verdict verdict = Judge(BySampling(*bxdf, FromTheLeft(std::sqrt(0.5f)), Scaled(1000000),
                                                 SeedOf(FullTestName() + what)),
                                      "val1");
        EXPECT_FALSE(verdict.Agrees()) << what << ": " << verdict.Describe();
    }
}

// ---- Densities ----------------------------------------------------------------------------------------

// What the images of the smoothest stack show: the mirrored peak stands at u = 0.8815, and the peak of the light
// that the metal sent back at u = 0.1120, which needs a metal that leans by 15.85 degrees.
constexpr float kIncidentSine = 0.8815f, kLeaningSlope = 0.2839f;

/// "1 -> 1.5 alpha a1 / sigma_t 1, isotropic / metal alpha a2", whose metal leans towards the light. The density
/// does not depend on colours.
StackCase DensityCase(float coatAlpha, float metalAlpha) {
    return {.name = "",
            .layers = {Dielectric(coatAlpha, 1.5f, kBeckmann), Medium(1, 1, Isotropic()),
                       Tilted({-kLeaningSlope, 0, 1}, Mirror(metalAlpha, kBeckmann))}};
}

// No image tells what the authors' walk does about absorption: nothing, as their totals show, and ours draws its
// directions without it, too. Both leave out the walks that an interface loses.
LobeSums DensityBySampling(const BxDF& bxdf, Vec3 wo, int numSamples, uint64_t seed) {
    LobeSums sums;
    Rng rng(seed);
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
    for (int i = 0; i < numSamples; ++i) {
        const float lobe = rng.Uniform();
        const auto sample = bxdf.Sample(wo, {lobe, rng.Uniform2D()}, context);
        if (sample && sample->wi.z > 0)
            sums.Add(sample->wi, SampledSpectrum(sample->wi.z));
        else
            sums.AddNothing();
    }
    return sums;
}

LobeSums DensityByStrategy(const LayeredPdf& pdf, const Stack& stack, Vec3 wo, int numValues, uint64_t seed) {
    const LobeQuery query{stack, wo};
    const GuideDensity guide = GuideOf(query, Hash(seed, 1));
    LobeSums sums;
    Rng rng(Hash(seed, 2));
    for (int i = 0; i < numValues; ++i) {
        const GuideDensity::Draw draw = guide.Sample(rng);
        const BxDFContext context{query.mode, Lobes::BothSides, &rng};
        if (draw.w.z > 0)
            sums.Add(draw.w, SampledSpectrum(pdf.Evaluate(stack, wo, draw.w, context, query.maxVertices) *
                                             float(double(draw.w.z) / draw.pdf)));
        else
            sums.AddNothing();
    }
    return sums;
}
}  // namespace
}  // namespace lacquer::test
