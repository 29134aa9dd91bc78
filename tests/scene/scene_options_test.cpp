// Which of scene file, command line and default wins, for every row of the table of options.
#include "pbrt/scene/scene_options.h"

#include <gtest/gtest.h>

namespace lacquer::scene_options_test {
namespace {

/// Another value than the default, and one more. @param i  0 or 1
template <class Value>
Value Other(int i) {
    if constexpr (std::is_same_v<Value, std::string>)
        return i == 0 ? "camera" : "world";
    else if constexpr (std::is_same_v<Value, bool>)
        return i == 0;
    else
        return Value(17 + i);
}

TEST(SceneOptions, TheFirstThatIsGivenWins) {
    for (const SceneOption& option : OptionTable()) {
        const auto check = [&](auto field) {
            using Value = std::decay_t<decltype(SceneOptions().*field)>;
            const Value first = Other<Value>(0), second = Other<Value>(1), fallback = SceneOptions().*field;
            GivenOptions none, ofScene, ofCommandLine;
            EXPECT_FALSE(ofScene.IsGiven(field));
            ofScene.Set(field, second);
            ofCommandLine.Set(field, first);
            EXPECT_TRUE(ofScene.IsGiven(field));
            EXPECT_EQ(Resolve(none, none).*field, fallback);
            EXPECT_EQ(Resolve(none, ofCommandLine).*field, first);
            // Also where the scene says what is the default anyway.
            EXPECT_EQ(Resolve(ofScene, ofCommandLine).*field, second);
            EXPECT_EQ(Resolve(ofScene, none).*field, second);
            EXPECT_NE(first, fallback);
            // No other option is touched.
            for (const SceneOption& o : OptionTable()) EXPECT_EQ(ofScene.IsGiven(o.field), &o == &option);
        };
        SCOPED_TRACE(option.name);
        std::visit(check, option.field);
    }
}

TEST(SceneOptions, TheTableHasEachFieldOnce) {
    EXPECT_EQ(OptionTable().size(), 11u);
    for (const SceneOption& a : OptionTable())
        for (const SceneOption& b : OptionTable())
            EXPECT_EQ(a.field == b.field, &a == &b) << a.name << " " << b.name;
}

}  // namespace
}  // namespace lacquer::scene_options_test
