// What LayeredBxDF::Sample() draws, and how dense.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "layered/agreement.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"

namespace lacquer::layered::test::sampling_test {

namespace {

const Vec3 kOblique = SphericalDirection(std::sin(Radians(50)), std::cos(Radians(50)), 1.1f);

// By walks through the stack and by lobes, both against the same walks. Power: at 20,000 samples of each, an
// error of 2 to 5 % of an albedo in any query.
TEST(LayeredSampling, DrawsWhatWalksFind) {
    const char* const pdfs[] = {"approximate", "belcour"};
    const int numSamples = IsFullRun() ? 1000000 : Scaled(20000);
    std::vector<const StackCase*> rows;
    for (const StackCase& row : StackCases())
        if (row.isSmall || IsFullRun()) rows.push_back(&row);
    const double alpha = SidakAlpha(1e-3, int(rows.size() * std::size(pdfs)) * 3 * kNumMoments);
    std::vector<std::string> failures(rows.size());
    ParallelFor(int64_t(rows.size()), [&](int64_t i) {
        const StackCase& row = *rows[size_t(i)];
        Arena arena;
        const Stack stack = row.Build(arena);
        for (const NamedQuery& q : QueriesOf(stack)) {
            const LobeQuery query{stack, q.wo, q.mode};
            const uint64_t seed = SeedOf(row.name + q.name);
            const Moments allWalks = MomentsByWalks(query, numSamples, Hash(seed, 2), true);
            for (const char* pdf : pdfs) {
                const LayeredBxDF* bxdf =
                    row.MakeBxDF(arena, {.estimator = FindEstimator("bidirectional"), .pdf = FindPdf(pdf)});
                Moments samples = MomentsBySamples(*bxdf, query, Lobes::BothSides, numSamples, Hash(seed, 1));
                Moments walks = allWalks;
                Comparison c = Compare(samples, walks);
                if (c.WorstZ() > kSuspicious) {
                    samples = MomentsBySamples(*bxdf, query, Lobes::BothSides, 8 * numSamples, Hash(seed, 3));
                    walks = MomentsByWalks(query, 8 * numSamples, Hash(seed, 4), true);
                    c = Compare(samples, walks);
                }
                if (!(NormalTwoSided(c.WorstZ()) >= alpha) || samples.NumInvalid() > 0)
                    failures[size_t(i)] +=
                        fmt::format("{} {} {}: {}\n", row.name, q.name, pdf, c.Describe(samples, walks));
            }
        }
    });
    for (const std::string& failure : failures) EXPECT_EQ(failure, "");
}

TEST(LayeredSampling, OneSideAloneDrawsThatSide) {
    const double alpha = SidakAlpha(1e-3, 4 * 2 * kNumMoments);
    for (const char* name :
         {"pane_020_010", "rough_pane_medium", "pane_smooth_rough", "lossless_smooth_medium_smooth"}) {
        Arena arena;
        const LayeredBxDF* bxdf =
            FindStackCase(name).MakeBxDF(arena, {.estimator = FindEstimator("bidirectional")});
        const LobeQuery query{bxdf->GetStack(), kOblique};
        const uint64_t seed = SeedOf(name);
        const Moments walks = MomentsByWalks(query, Scaled(40000), Hash(seed, 1), true);
        for (const Lobes side : {Lobes::Reflection, Lobes::Transmission}) {
            const Moments samples =
                MomentsBySamples(*bxdf, query, side, Scaled(40000), Hash(seed, 2 + int(side)));
            const Comparison c = Compare(samples, walks);
            const bool above = side == Lobes::Reflection;
            // Its own side is right in all moments, and nothing is on the other one.
            for (int i = 0; i < 2 * kWeightsPerSide; ++i) {
                if ((i < kWeightsPerSide) == above)
                    EXPECT_GE(NormalTwoSided(c.z[size_t(i)]), alpha)
                        << name << " " << MomentName(i) << ": " << samples.Mean(i) << " against "
                        << walks.Mean(i);
                else
                    EXPECT_EQ(samples.Mean(i), 0) << name;
            }
        }
    }
}

TEST(LayeredSampling, CutWalksAgree) {
    const double alpha = SidakAlpha(1e-3, 4 * 4 * kNumMoments);
    for (const char* name : {"coat_030_metal_010", "v1", "rough_pane_medium", "smooth_coat_diffuse_050"}) {
        Arena arena;
        for (const int maxVertices : {1, 2, 3, 6}) {
            const LayeredBxDF* bxdf = FindStackCase(name).MakeBxDF(
                arena, {.estimator = FindEstimator("bidirectional"), .maxVertices = maxVertices});
            const LobeQuery query{bxdf->GetStack(), kOblique, TransportMode::Radiance, maxVertices};
            const uint64_t seed = SeedOf(fmt::format("{} {}", name, maxVertices));
            const Moments samples =
                MomentsBySamples(*bxdf, query, Lobes::BothSides, Scaled(40000), Hash(seed, 1));
            const Moments walks = MomentsByWalks(query, Scaled(40000), Hash(seed, 2), true);
            const Comparison c = Compare(samples, walks);
            EXPECT_GE(NormalTwoSided(c.WorstZ()), alpha)
                << name << " " << maxVertices << ": " << c.Describe(samples, walks);
        }
    }
}

/// Directions with which walks leave that never end early: no weights, no roulette. What the pdf is the
/// density of. Gray stacks only.
Moments MomentsOfSamples(const LobeQuery& query, int numWalks, uint64_t seed) {
    Moments moments(query.stack, query.wo);
    Rng rng(seed);
    const int last = query.stack.Last();
    const auto draw = [&]() -> std::optional<Vec3> {
        Vec3 w = query.wo;  // where the light comes from
        bool isSpecular = true;
        for (int at = query.stack.OuterTowards(w);;) {
            const float lobe = rng.Uniform();
            const auto sample = query.stack.interfaces[size_t(at)].bxdf->Sample(
                w, {lobe, rng.Uniform2D()}, {query.mode, Lobes::BothSides, &rng});
            if (!sample) return std::nullopt;
            isSpecular &= sample->IsSpecular();
            Vec3 flight = sample->wi;
            if (flight.z > 0 ? at == 0 : at == last) return isSpecular ? std::nullopt : std::optional(flight);
            const int k = flight.z > 0 ? at - 1 : at;
            const Slab& slab = query.stack.slabs[size_t(k)];
            double depth = flight.z > 0 ? 1 : 0;
            while (slab.phase) {
                const double length = -std::log1p(-double(rng.Uniform())) /
                                      double(slab.opticalThickness[0] * slab.phase->Extinction(flight));
                depth -= double(flight.z) * length;
                if (!(depth > 0 && depth < 1)) break;
                flight = slab.phase->Sample(-flight, rng).wi;
                isSpecular = false;
            }
            at = flight.z > 0 ? k : k + 1;
            w = -flight;
        }
    };
    for (int i = 0; i < numWalks; ++i) {
        if (const auto w = draw())
            moments.Add(*w, SampledSpectrum(1));
        else
            moments.AddNothing();
    }
    return moments;
}

// Power: 3 % of the share of either side.
TEST(LayeredSampling, TheUnbiasedPdfIsTheDensityOfDirections) {
    const char* const kNames[] = {
        "coat_030_metal_010",    "pane_020_010", "smooth_coat_metal_020", "v1",
        "rough_pane_medium",     "two_media",    "fibres_metal",          "coat_absorber_metal",
        "smooth_medium_diffuse", "vmf_pane",     "diffuse_sheet_first",   "aniso_coat_aniso_metal"};
    const double alpha = SidakAlpha(1e-3, int(std::size(kNames)) * kNumMoments);
    const int effort = IsFullRun() ? 500000 : Scaled(20000);
    const LayeredPdf* pdf = FindPdf("unbiased");
    for (const char* name : kNames) {
        Arena arena;
        const LayeredBxDF* bxdf =
            FindStackCase(name).MakeBxDF(arena, {.estimator = FindEstimator("bidirectional"), .pdf = pdf});
        const LobeQuery query{bxdf->GetStack(), kOblique};
        const uint64_t seed = SeedOf(name);
        const Moments draws = MomentsOfSamples(query, 2 * effort, Hash(seed, 1));
        const Moments values = MomentsByValues(
            query, GuideOf(query, Hash(seed, 2)), effort, Hash(seed, 3), [&](Vec3 wi, Rng& rng) {
                const float p = bxdf->Pdf(kOblique, wi, {query.mode, Lobes::BothSides, &rng});
                return SampledSpectrum(p / std::abs(wi.z));  // the moments are of f |cos|
            });
        const Comparison c = Compare(values, draws);
        EXPECT_GE(NormalTwoSided(c.WorstZ()), alpha) << name << ": " << c.Describe(values, draws);
    }
}

// The approximate pdf is for weights only; it must be positive where light leaves.
TEST(LayeredSampling, TheApproximatePdfIsPositive) {
    const LayeredOptions options{.estimator = FindEstimator("bidirectional"), .pdf = FindPdf("approximate")};
    for (const StackCase& row : StackCases()) {
        Arena arena;
        const LayeredBxDF* bxdf = row.MakeBxDF(arena, options);
        Rng rng(SeedOf(row.name));
        const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
        for (int i = 0; i < 50; ++i) {
            const float lobe = rng.Uniform();
            const auto sample = bxdf->Sample(kOblique, {lobe, rng.Uniform2D()}, context);
            if (!sample || sample->IsSpecular()) continue;
            const float pdf = bxdf->Evaluate(kOblique, sample->wi, context).pdf;
            EXPECT_GT(pdf, 0) << row.name;
            EXPECT_TRUE(std::isfinite(pdf)) << row.name;
        }
    }
}

}  // namespace
}  // namespace lacquer::layered::test::sampling_test
