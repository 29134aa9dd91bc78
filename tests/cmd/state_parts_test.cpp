// Boxes of samples and pixels, against counting all samples one by one.
#include "cmd/render/state_parts.h"

#include <gtest/gtest.h>

#include <array>

#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::cmd::state_parts_test {
namespace {

constexpr int kWidth = 7, kHeight = 5, kSamples = 6;
const Bounds2i kPixels{{0, 0}, {kWidth, kHeight}};

/// How often each sample of each pixel is there.
struct Counts {
    std::array<int, size_t(kWidth* kHeight* kSamples)> counts{};
    void Add(const SampleBox& box) {
        for (int s = box.first; s < box.end; ++s)
            for (int y = box.pixels.min.y; y < box.pixels.max.y; ++y)
                for (int x = box.pixels.min.x; x < box.pixels.max.x; ++x)
                    ++counts[size_t((s * kHeight + y) * kWidth + x)];
    }
    bool operator==(const Counts&) const = default;
};

SampleBox BoxOf(const StatePart& part) { return {part.pixels, part.first, part.first + part.least}; }

StatePart RandomPart(Rng* rng) {
    const auto interval = [&](int size) {
        const int a = int(rng->UniformInt(uint32_t(size))), b = int(rng->UniformInt(uint32_t(size)));
        return std::pair(std::min(a, b), std::max(a, b) + 1);
    };
    const auto [x0, x1] = interval(kWidth);
    const auto [y0, y1] = interval(kHeight);
    const auto [first, end] = interval(kSamples);
    return {{{x0, y0}, {x1, y1}}, first, end - first, end - first};
}

TEST(StateParts, WhatIsMissingIsWhatNoPartHas) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<StatePart> parts;
        Counts there;
        for (uint32_t i = rng.UniformInt(6); i > 0; --i) {
            parts.push_back(RandomPart(&rng));
            there.Add(BoxOf(parts.back()));
        }
        Counts missing, expected;
        for (const SampleBox& box : MissingSamples(parts, {kPixels, 0, kSamples})) {
            EXPECT_FALSE(box.IsEmpty());
            missing.Add(box);
        }
        for (size_t i = 0; i < there.counts.size(); ++i) expected.counts[i] = there.counts[i] == 0 ? 1 : 0;
        ASSERT_EQ(missing, expected) << trial;
    }
}

TEST(StateParts, WhatTwoShareIsWhatBothHave) {
    Rng rng(test::SeedOf(test::FullTestName()));
    int sharing = 0;
    for (int trial = 0; trial < 300; ++trial) {
        const StatePart a = RandomPart(&rng), b = RandomPart(&rng);
        Counts both, expected, shared;
        both.Add(BoxOf(a));
        both.Add(BoxOf(b));
        for (size_t i = 0; i < both.counts.size(); ++i) expected.counts[i] = both.counts[i] == 2 ? 1 : 0;
        const SampleBox box = SharedSamples(a, b);
        if (!box.IsEmpty()) shared.Add(box);
        ASSERT_EQ(shared, expected) << trial;
        sharing += box.IsEmpty() ? 0 : 1;
    }
    EXPECT_GT(sharing, 20);
    EXPECT_LT(sharing, 280);
}

/// Of a render that was stopped amid a pass, some pixels may have more: these count as there when it is about
/// doubles, and as missing otherwise.
TEST(StateParts, WhatIsNotCertainIsNeitherTwiceThereNorThere) {
    const StatePart stopped{kPixels, 0, 2, 4}, next{kPixels, 3, 2, 2};
    EXPECT_EQ(SamplesInWords(SharedSamples(stopped, next), kPixels), "sample 3 of all pixels");
    EXPECT_EQ(SamplesInWords(MissingSamples({stopped}, {kPixels, 0, 6}), kPixels),
              "samples 2 to 5 of all pixels");
}

TEST(StateParts, BecomeOneWhereTheyMakeABox) {
    std::vector<StatePart> parts;
    for (const int first : {4, 0, 2})
        for (const int x : {3, 0, 5}) {
            const int end = x == 0 ? 3 : x == 3 ? 5 : 7;
            AddPart({{{x, 0}, {end, kHeight}}, first, 2, 2}, &parts);
        }
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].pixels, kPixels);
    EXPECT_EQ(parts[0].first, 0);
    EXPECT_EQ(parts[0].least, 6);
    AddPart({{{0, 0}, {1, 1}}, 9, 2, 3}, &parts);
    EXPECT_EQ(parts.size(), 2u);
}

TEST(StateParts, InWords) {
    EXPECT_EQ(SamplesInWords(SampleBox{{{2, 0}, {7, 1}}, 3, 4}, kPixels),
              "sample 3 of the pixels x 2..6, y 0..0");
    const std::vector<SampleBox> many(5, SampleBox{kPixels, 0, 2});
    EXPECT_EQ(SamplesInWords(many, kPixels),
              "samples 0 to 1 of all pixels; samples 0 to 1 of all pixels; samples 0 to 1 of all pixels; and "
              "2 more");
}

}  // namespace
}  // namespace lacquer::cmd::state_parts_test
