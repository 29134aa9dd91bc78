// Light path expressions: an automaton against a search of the text itself, and what is refused.
#include "pbrt/film/light_path_automaton.h"

#include <gtest/gtest.h>

#include <regex>

#include "pbrt/core/rng.h"
#include "pbrt/film/light_path_expression.h"
#include "pbrt/film/pass_recorder.h"
#include "pbrt/film/passes.h"

namespace lacquer::light_path_automaton_test {
namespace {

const std::vector<std::string> kGroups{"", "key", "fill"};

/// A path: its events, and what it ends at.
struct TestPath {
    std::vector<PathEvent> events;
    PathSource source = PathSource::Light;
    int group = 0;
};
TestPath RandomPath(Rng* rng) {
    TestPath path;
    const int length = int(rng->Uniform() * 5);
    for (int i = 0; i < length; ++i) path.events.push_back(PathEvent(rng->Uniform() * kNumPathEvents));
    path.source = PathSource(rng->Uniform() * kNumPathSources);
    path.group = int(rng->Uniform() * float(kGroups.size()));
    return path;
}

/// One character for each event, and one for each source and group.
std::string AsText(const TestPath& path) {
    std::string text;
    for (const PathEvent event : path.events) text += char('a' + int(event));
    return text + char('A' + 3 * path.group + int(path.source));
}
uint64_t Matches(const LightPathAutomaton& automaton, const TestPath& path) {
    LightPathAutomaton::State state = LightPathAutomaton::kStart;
    for (const PathEvent event : path.events) state = automaton.Next(state, event);
    return automaton.PassesOf(state, path.source, path.group);
}

/// An expression, and the same for std::regex, on AsText(): a to c are reflections (diffuse, glossy,
/// specular), d to f transmissions, g volumes; A, B, C are a light, a background and a medium without group,
/// D to F those of "key", G to I those of "fill".
struct Expected {
    std::string expression, regex;
};
const std::vector<Expected> kExpected = {
    {"C.*", ".*"},
    {"C.*L", ".*[ABDEGH]"},
    {"C.+B", ".+[BEH]"},
    {"CD+O", "[ad]+[CFI]"},
    {"C<RD>S*L", "a[cf]*[ABDEGH]"},
    {"C<T.>.*", "[def].*"},
    {"C<[RT]G>?V.*", "[be]?g.*"},
    {"C[^S]*L", "[^cf]*[ABDEGH]"},
    {"C(D|GS?)+<L.'key'>", "([ad]|[be][cf]?)+[DE]"},
    {"C.*<[LO]'fill'>", ".*[GHI]"},
    {"CS*(D(G|V)*)?[LO]", "[cf]*([ad]([be]|g)*)?[A-I]"},
    {"C[R<TS>]V*<B'key'>", "[abcf]g*E"},
    {"C(T*R)*T?O", "([def]*[abc])*[def]?[CFI]"},
};

/// Every expression alone and all of them in one automaton, for paths of up to four events. A path is of 2801
/// kinds times 9 ends: 20000 random ones meet each of those with up to two events several times.
TEST(LightPathAutomaton, AgreesWithRegularExpressions) {
    std::vector<std::string> expressions;
    for (const Expected& e : kExpected) expressions.push_back(e.expression);
    const LightPathAutomaton together(expressions, kGroups);
    std::vector<int> matches(kExpected.size());
    Rng rng(1);
    std::vector<TestPath> paths;
    for (int i = 0; i < 20000; ++i) paths.push_back(RandomPath(&rng));
    for (size_t k = 0; k < kExpected.size(); ++k) {
        const std::regex regex(kExpected[k].regex);
        const LightPathAutomaton alone({kExpected[k].expression}, kGroups);
        int wrong = 0;
        for (const TestPath& path : paths) {
            const bool expected = std::regex_match(AsText(path), regex);
            matches[k] += expected;
            wrong += Matches(alone, path) != uint64_t(expected);
            wrong += (Matches(together, path) >> k & 1) != uint64_t(expected);
        }
        EXPECT_EQ(wrong, 0) << kExpected[k].expression;
        // The paths tell something about each expression.
        EXPECT_GT(matches[k], 20) << kExpected[k].expression;
        EXPECT_GT(alone.NumStates(), 0u);
    }
}

/// The named passes are two partitions of all paths, and the groups a third.
TEST(Passes, OfEachKindHoldEveryPathOnce) {
    const auto masks = [](const std::vector<std::string>& names) {
        std::vector<std::string> expressions;
        for (const Pass& pass : PassesOf(names, kGroups)) expressions.push_back(pass.expression);
        return LightPathAutomaton(expressions, kGroups);
    };
    Rng rng(2);
    for (const std::vector<std::string>& names : {std::vector<std::string>{"emission", "direct", "indirect"},
                                                  {"emission", "diffuse", "glossy", "transmission", "volume"},
                                                  {"lightgroups"}}) {
        const LightPathAutomaton automaton = masks(names);
        for (int i = 0; i < 5000; ++i) EXPECT_EQ(std::popcount(Matches(automaton, RandomPath(&rng))), 1);
    }
    // What this finds: a set without one of its members.
    const LightPathAutomaton lacking = masks({"emission", "diffuse", "transmission", "volume"});
    int lost = 0;
    for (int i = 0; i < 5000; ++i) lost += Matches(lacking, RandomPath(&rng)) == 0;
    EXPECT_GT(lost, 500);
}

TEST(Passes, OfASceneWithoutGroupsAreOneLayer) {
    const std::vector<Pass> passes = PassesOf({"lightgroups"}, std::vector<std::string>{""});
    ASSERT_EQ(passes.size(), 1u);
    EXPECT_EQ(passes[0].layer, "nolightgroup");
    const LightPathAutomaton all({passes[0].expression}, std::vector<std::string>{""});
    EXPECT_EQ(all.PassesOf(LightPathAutomaton::kStart, PathSource::Medium, 0), 1u);
}

std::string WhyWrong(const std::string& expression) {
    try {
        LightPathAutomaton({expression}, kGroups);
        return {};
    } catch (const LightPathError& e) {
        return e.what();
    }
}

TEST(LightPathExpression, IsRefusedWithThePlace) {
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {"", "character 1: \"C\""},
        {"DL", "character 1: \"C\""},
        {"C", "character 2: expected what follows"},
        {"CXL", "character 2: \"X\" is no event"},
        {"CDC", "character 3: \"C\""},
        {"C<RX>L", "character 4: \"X\" is no event"},
        {"C<RT>L", "character 4: no event is this"},
        {"C<RDS>L", "character 5: expected \">\""},
        {"C<RD", "character 2: this \"<\""},
        {"C<>L", "character 3: expected a letter"},
        {"C[]L", "character 3: the set is empty"},
        {"C[DG", "character 2: this \"[\""},
        {"C(D|G", "character 2: this \"(\""},
        {"CD)L", "character 3: \")\" closes nothing"},
        {"CD|CG", "character 3: \"|\""},
        {"C*L", "character 2: \"*\" has nothing to repeat"},
        {"C.*<L'kye'>", "character 6: the scene has no light group \"kye\"; did you mean \"key\"?"},
        {"C.*<L''>", "character 6: the name of the light group is empty"},
        {"C.*<L'key>", "character 6: this quote"},
        {"C.*<D'key'>L", "character 6: only lights have groups"},
        {"CD*", "matches no path"},
    };
    for (const auto& [expression, why] : wrong)
        EXPECT_NE(WhyWrong(expression).find(why), std::string::npos)
            << expression << ": " << WhyWrong(expression);
    EXPECT_NE(WhyWrong("C<RX>L").find("\n    C<RX>L\n       ^"), std::string::npos) << WhyWrong("C<RX>L");
    EXPECT_NE(WhyWrong("C" + std::string(300, 'D') + "L").find("too long"), std::string::npos);
    EXPECT_NE(WhyWrong("C" + std::string(100, '(')).find("too many parentheses"), std::string::npos);
    // The number of states doubles with each dot.
    EXPECT_NE(WhyWrong("C.*D..............L").find("4096 states"), std::string::npos);
}

TEST(LightPathExpression, NamesOfPassesAreLayers) {
    EXPECT_EQ(WhyNoPass("lpe:shine=C<RG>.*L"), "");
    EXPECT_NE(WhyNoPass("lpe:shine").find("NAME=EXPRESSION"), std::string::npos);
    EXPECT_NE(WhyNoPass("lpe:=CL").find("is empty"), std::string::npos);
    EXPECT_NE(WhyNoPass("lpe:a.b=CL").find("letters"), std::string::npos);
    EXPECT_NE(WhyNoPass("lpe:Albedo=CL").find("have that name"), std::string::npos);
    EXPECT_THROW(PassesOf({"lpe:direct=CL", "direct"}, kGroups), LightPathError);
    EXPECT_EQ(PassesOf({"direct", "direct"}, kGroups).size(), 1u);
    EXPECT_THROW(LightPathAutomaton(std::vector<std::string>(kMaxPasses + 1, "CL"), kGroups), LightPathError);
}

/// The kind of a scattering does not depend on what a sample drew, unless that was specular.
TEST(PassRecorder, EventsBelongToTheBxDF) {
    BxDFSample sample;
    sample.lobe = Lobes::GlossyReflection;
    EXPECT_EQ(EventOf(Lobes::DiffuseReflection, sample), PathEvent::DiffuseReflection);
    EXPECT_EQ(EventOf(Lobes::GlossyReflection, sample), PathEvent::GlossyReflection);
    sample.lobe = Lobes::SpecularTransmission;
    EXPECT_EQ(EventOf(Lobes::Diffuse | Lobes::Specular | Lobes::BothSides, sample),
              PathEvent::SpecularTransmission);
}

}  // namespace
}  // namespace lacquer::light_path_automaton_test
