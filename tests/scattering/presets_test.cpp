// The table of measured media.
#include "pbrt/scattering/presets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace lacquer::presets_test {
namespace {

// Twelve materials of the one paper and thirty-five of the other.
TEST(ScatteringPresets, AreAllThereOnceAndSane) {
    const std::vector<std::string> names = ScatteringPresetNames();
    EXPECT_EQ(names.size(), 47u);
    EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
    for (const std::string& name : names) {
        const std::optional<ScatteringPreset> preset = FindScatteringPreset(name);
        ASSERT_TRUE(preset) << name;
        for (int c = 0; c < 3; ++c) {
            EXPECT_GE(preset->reducedSigma_s[c], 0) << name;
            EXPECT_GE(preset->sigma_a[c], 0) << name;
            EXPECT_LT(preset->reducedSigma_s[c] + preset->sigma_a[c], 100) << name;
            EXPECT_GT(preset->reducedSigma_s[c] + preset->sigma_a[c], 0) << name;
        }
    }
}

TEST(ScatteringPresets, HaveThePublishedFigures) {
    const std::optional<ScatteringPreset> milk = FindScatteringPreset("Wholemilk");
    ASSERT_TRUE(milk);
    EXPECT_EQ(milk->reducedSigma_s, RGB(2.55f, 3.21f, 3.77f));
    EXPECT_EQ(milk->sigma_a, RGB(0.0011f, 0.0024f, 0.014f));
    const std::optional<ScatteringPreset> sea = FindScatteringPreset("Pacific Ocean Surface Water");
    ASSERT_TRUE(sea);
    EXPECT_EQ(sea->reducedSigma_s, RGB(0.0001764f, 0.00032095f, 0.00019617f));
}

TEST(ScatteringPresets, UnknownNamesHaveNone) {
    for (const char* name : {"", "wholemilk", "Wholemilk ", "#", "Milk"})
        EXPECT_FALSE(FindScatteringPreset(name)) << name;
}

}  // namespace
}  // namespace lacquer::presets_test
