// The lobes that [Guo et al. 2018] published with their code, where the images are at hand: values and
// densities of the validation stacks on the projected unit disk.
//
// The first four files hold f |cos theta_i| of the directions wi = (u, v, sqrt(1 - u^2 - v^2)): u runs to the
// right and v upward in [-1, 1], and light arrives at 45 degrees from u < 0, so that the mirrored peak is at
// u = 0.71. Which way is up shows in the fibres of the fourth stack alone.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "layered/agreement.h"
#include "pbrt/image/image.h"

namespace lacquer::layered::test {

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
                lobe.blocks[i][c] =
                    std::max(0., squares_[i][c] / count_ - Sqr(sums_[i][c] / count_)) / count_;
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

/// What a block is measured by: itself, or a fifth of the mean where it is darker.
double Unit(const Lobe& lobe, size_t block, size_t c) {
    return std::max(lobe.blocks[block][c], 0.2 * lobe.Integral(int(c)) / 4);
}

/// Root of the mean square over all blocks and channels of relative differences.
double Distance(const Lobe& a, const Lobe& b) {
    double sum = 0;
    for (size_t i = 0; i < a.blocks.size(); ++i)
        for (size_t c = 0; c < kChannels; ++c)
            sum += Sqr((a.blocks[i][c] - b.blocks[i][c]) / Unit(b, i, c)) / kChannels;
    return std::sqrt(sum / double(a.blocks.size()));
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
        const GuideDensity::GuidedDirection draw = guide.Sample(rng);
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

/// What the authors published of one stack, and how much noise it has.
struct Published {
    std::vector<Lobe> images;  ///< whose means count
    Lobe shape;
    double noise = 0;  ///< Distance() of `shape` from the truth

    /// Values: one image by evaluation and one by sampling tell about each other's noise; the mean of both
    /// has half of their distance. The third one, by "eval_uni", is several times as noisy.
    static Published Values(const std::string& name) {
        const Lobe evaluated = ReadLobe(name + "_bsdf_eval_bi"), sampled = ReadLobe(name + "_bsdf_sample");
        return {{evaluated, sampled, ReadLobe(name + "_bsdf_eval_uni")},
                MeanOf(evaluated, sampled),
                Distance(evaluated, sampled) / 2};
    }
    /// Densities: the histogram "ref" alone, for their estimate "acr" has 3 % less in its mean. The distance
    /// of the two bounds the noise.
    static Published Density(const std::string& name) {
        const Lobe histogram = ReadLobe(name + "_ref");
        return {{histogram}, histogram, Distance(histogram, ReadLobe(name + "_acr"))};
    }
};

/// How a lobe of ours stands to the authors'.
struct Verdict {
    double worstMean = -1;  ///< relative difference of integrals, beyond four of our standard errors
    double distance = 0, allowedDistance = 0;
    double clearShare = 0;  ///< of the blocks, that these are about
    bool MeansAgree() const { return worstMean <= 0.01; }
    bool Agrees() const { return MeansAgree() && distance <= allowedDistance && clearShare > 0.9; }
    std::string Describe() const {
        return fmt::format(
            "means differ by {:.2f} % beyond noise, blocks by {:.2f} % ({:.2f} % allowed, {:.0f} % clear)",
            100 * worstMean, 100 * distance, 100 * allowedDistance, 100 * clearShare);
    }
};

Verdict Judge(const LobeSums& ours, const Published& theirs) {
    constexpr double kSlack = 1.25;  // the noise of the authors' images is an estimate
    const Lobe means = ours.Means();
    Verdict verdict;
    for (const Lobe& image : theirs.images)
        for (int c = 0; c < kChannels; ++c) {
            const double difference = std::abs(means.Integral(c) - image.Integral(c));
            verdict.worstMean =
                std::max(verdict.worstMean, (difference - 4 * ours.IntegralError(c)) / image.Integral(c));
        }
    // Blocks where rare bright values leave nothing to say are left out; there may be few of them.
    constexpr double kBlurred = 0.15;
    const Lobe variances = ours.Variances();
    double sum = 0, expected = 0;
    int numClear = 0;
    for (size_t i = 0; i < means.blocks.size(); ++i)
        for (size_t c = 0; c < kChannels; ++c) {
            const double unit = Unit(theirs.shape, i, c), variance = variances.blocks[i][c] / Sqr(unit);
            if (variance > Sqr(kBlurred)) continue;
            sum += Sqr((means.blocks[i][c] - theirs.shape.blocks[i][c]) / unit);
            expected += variance;
            ++numClear;
        }
    verdict.clearShare = double(numClear) / double(kChannels * means.blocks.size());
    verdict.distance = std::sqrt(sum / std::max(1, numClear));
    verdict.allowedDistance = kSlack * std::sqrt(Sqr(theirs.noise) + expected / std::max(1, numClear));
    return verdict;
}

/// By values of an estimator and by sampling.
/// @param valuesAreNoisy  the fast subset's values tell about means only
void ExpectAgreement(const StackCase& row, const Published& theirs, bool valuesAreNoisy = false) {
    const int numSamples = IsFullRun() ? 4000000 : 250000;
    const int numValues = IsFullRun() ? 2000000 : 160000;
    Arena arena;
    const LayeredBxDF* bxdf = row.MakeBxDF(arena, {.estimator = FindEstimator("auto")});
    const Vec3 wo = FromTheLeft(std::sqrt(0.5f));
    const uint64_t seed = SeedOf(FullTestName());
    const Verdict values = Judge(ByValues(*bxdf, bxdf->GetStack(), wo, numValues, Hash(seed, 1)), theirs);
    EXPECT_TRUE(valuesAreNoisy && !IsFullRun() ? values.MeansAgree() : values.Agrees())
        << "by values: " << values.Describe();
    const Verdict samples = Judge(BySampling(*bxdf, wo, numSamples, Hash(seed, 2)), theirs);
    EXPECT_TRUE(samples.Agrees()) << "by sampling: " << samples.Describe();
    testing::Test::RecordProperty("values", values.Describe());
    testing::Test::RecordProperty("samples", samples.Describe());
}

class PublishedValues : public testing::TestWithParam<std::string> {};

TEST_P(PublishedValues, HaveTheirMeansAndShape) {
    const std::string name = "val" + GetParam().substr(1);
    if (!IsThere(name + "_bsdf_eval_bi")) GTEST_SKIP() << "SKIP published lobes: no images of " << name;
    const bool isNarrow = GetParam() == "v3" || GetParam() == "v4";  // lobes of matter: rare bright values
    ExpectAgreement(FindStackCase(GetParam()), Published::Values(name), isNarrow);
}
INSTANTIATE_TEST_SUITE_P(Stacks, PublishedValues, testing::Values("v1", "v2", "v3", "v4"),
                         [](const auto& row) { return row.param; });

// ---- Densities ----------------------------------------------------------------------------------------

// The stacks of these images were found from the images: light arrives at 45 degrees, the normal of the coat
// is tilted away from it and the metal towards it by 8.4 degrees each (the two peaks of the smoothest stack
// tell), and the walks that were counted die at a scattering event with the largest albedo's complement, 5 %.
// An image holds the density over solid angle. With a perfect mirror as metal that is the value of the stack
// times the cosine, up to what the coat's facets shadow.
constexpr float kNormalSlope = 0.148f;
StackCase DensityCase(float coatAlpha, float metalAlpha, float slope = kNormalSlope) {
    return {.name = "",
            .layers = {Tilted({slope, 0, 1}, Dielectric(coatAlpha, 1.5f, kBeckmann)),
                       Medium(1, 0.95f, Isotropic()), Tilted({-slope, 0, 1}, Mirror(metalAlpha, kBeckmann))}};
}

struct Roughness {
    const char *name, *coat, *metal;
};
class PublishedDensities : public testing::TestWithParam<Roughness> {};

TEST_P(PublishedDensities, HaveTheirMeansAndShape) {
    const auto& [name, coat, metal] = GetParam();
    const std::string file = fmt::format("pdf_{}_{}", coat, metal);
    if (!IsThere(file + "_ref")) GTEST_SKIP() << "SKIP published lobes: no images of " << file;
    ExpectAgreement(DensityCase(std::stof(coat), std::stof(metal)), Published::Density(file));
}
INSTANTIATE_TEST_SUITE_P(Stacks, PublishedDensities,
                         testing::Values(Roughness{"both_rough", "0.1", "0.1"},
                                         Roughness{"rough_coat", "0.1", "0.005"},
                                         Roughness{"rough_metal", "0.005", "0.1"},
                                         Roughness{"both_smooth", "0.005", "0.005"}),
                         [](const auto& row) { return row.param.name; });

// ---- Power --------------------------------------------------------------------------------------------

// What the comparison can find: stacks with one number slightly off.
TEST(PublishedLobes, SlightlyDifferentStacksAreFound) {
    if (Scaled(8) != 8) GTEST_SKIP() << "SKIP under sanitizers: too few samples";
    if (!IsThere("val1_bsdf_eval_bi") || !IsThere("pdf_0.1_0.1_ref"))
        GTEST_SKIP() << "SKIP published lobes: no images to compare with";
    const auto stackOf = [](float coatAlpha, float thickness, float g, float metalAlpha) {
        return StackCase{
            .name = "",
            .layers = {Dielectric(coatAlpha, 1.5f, kBeckmann),
                       Medium(SampledSpectrum(thickness), Lanes(0.5f, 0.7f, 0.95f, 0.95f), HG(g)),
                       Copper(metalAlpha, kBeckmann)}};
    };
    const Published value = Published::Values("val1"), density = Published::Density("pdf_0.1_0.1");
    const std::tuple<const char*, StackCase, const Published*> rows[] = {
        {"coat a quarter rougher", stackOf(0.0625f, 1, 0.5f, 0.05f), &value},
        {"4 % more matter", stackOf(0.05f, 1.04f, 0.5f, 0.05f), &value},
        {"g = 0.55", stackOf(0.05f, 1, 0.55f, 0.05f), &value},
        {"metal half again as rough", stackOf(0.05f, 1, 0.5f, 0.075f), &value},
        {"normal tilted by 7.4 degrees", DensityCase(0.1f, 0.1f, 0.13f), &density},
    };
    for (const auto& [what, row, theirs] : rows) {
        Arena arena;
        const LayeredBxDF* bxdf = row.MakeBxDF(arena, {.estimator = FindEstimator("auto")});
        const LobeSums sums =
            BySampling(*bxdf, FromTheLeft(std::sqrt(0.5f)), 500000, SeedOf(FullTestName() + what));
        const Verdict verdict = Judge(sums, *theirs);
        EXPECT_FALSE(verdict.Agrees()) << what << ": " << verdict.Describe();
    }
}

}  // namespace
}  // namespace lacquer::layered::test
