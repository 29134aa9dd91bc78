#include "pbrt/core/registry.h"

#include <gtest/gtest.h>

namespace lacquer::registry_test {
namespace {

struct NumberKind {
    using Factory = int (*)(int);
};
struct OtherKind {
    using Factory = int (*)(int);
};
int Twice(int x) { return 2 * x; }
int Next(int x) { return x + 1; }

LACQUER_REGISTER(NumberKind, "twice", Twice);
LACQUER_REGISTER(NumberKind, "next", Next);

TEST(Registry, FindsWhatWasRegisteredBeforeMain) {
    ASSERT_NE(Registry<NumberKind>::Find("twice"), nullptr);
    EXPECT_EQ(Registry<NumberKind>::Find("twice")(21), 42);
    EXPECT_EQ(Registry<NumberKind>::Find("next")(1), 2);
}

TEST(Registry, KnowsNothingElse) {
    EXPECT_EQ(Registry<NumberKind>::Find("Twice"), nullptr);
    EXPECT_EQ(Registry<NumberKind>::Find(""), nullptr);
    EXPECT_EQ(Registry<OtherKind>::Find("twice"), nullptr);
    EXPECT_TRUE(Registry<OtherKind>::Names().empty());
}

TEST(Registry, ListsNamesInAlphabeticalOrder) {
    EXPECT_EQ(Registry<NumberKind>::Names(), (std::vector<std::string>{"next", "twice"}));
}

struct MarkedKind {
    using Factory = int (*)(int);
    struct Traits {
        bool isMarked = false;
        int mark = 3;
    };
};
LACQUER_REGISTER(MarkedKind, "plain", Next);
LACQUER_REGISTER(MarkedKind, "marked", Twice, {.isMarked = true, .mark = 4});

TEST(Registry, TellsTraitsByName) {
    EXPECT_FALSE(Registry<MarkedKind>::TraitsOf("plain").isMarked);
    EXPECT_TRUE(Registry<MarkedKind>::TraitsOf("marked").isMarked);
    EXPECT_EQ(Registry<MarkedKind>::TraitsOf("marked").mark, 4);
    EXPECT_EQ(Registry<MarkedKind>::TraitsOf("unknown").mark, 3);
}

TEST(Registry, RemovesWhatATestAdded) {
    EXPECT_TRUE(Registry<OtherKind>::Add("once", Twice));
    Registry<OtherKind>::Remove("once");
    EXPECT_EQ(Registry<OtherKind>::Find("once"), nullptr);
}

TEST(Registry, KeepsTheFirstOfTwoWithOneName) {
    EXPECT_FALSE(Registry<NumberKind>::Add("next", Twice));
    EXPECT_EQ(Registry<NumberKind>::Find("next")(1), 2);
}

}  // namespace
}  // namespace lacquer::registry_test
