// Negative controls of the sanitizers' build: mistakes that must end the process, in a test's own code and in
// the library's. Only that build has this file.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "pbrt/core/sampling.h"
#include "support/statistics.h"

namespace lacquer::test::sanitizers_test {
namespace {

/// A number that the compiler does not know.
template <class T>
T Hidden(T value) {
    volatile T hidden = value;
    return hidden;
}

TEST(SanitizersDeathTest, ReadingBehindAnArrayIsFound) {
    const std::vector<float> values(8);
    EXPECT_DEATH(Hidden(values.data()[Hidden(8)]), "heap-buffer-overflow");
}

TEST(SanitizersDeathTest, ReadingFreedMemoryIsFound) {
    EXPECT_DEATH(
        {
            float* value = new float(1);
            float* volatile kept = value;
            delete value;
            Hidden(*kept);
        },
        "heap-use-after-free");
}

TEST(SanitizersDeathTest, OverflowOfIntegersIsFound) {
    EXPECT_DEATH(Hidden(Hidden(std::numeric_limits<int>::max()) + Hidden(1)), "signed integer overflow");
}

// The library itself is instrumented: it reads behind what it is given.
TEST(SanitizersDeathTest, TheLibraryIsInstrumented) {
    const std::vector<float> weights(4, 1.f);
    const std::span<const float> tooLong(weights.data(), size_t(Hidden(5)));
    EXPECT_DEATH(PiecewiseConstant1D{tooLong}, "heap-buffer-overflow");
}

}  // namespace
}  // namespace lacquer::test::sanitizers_test
