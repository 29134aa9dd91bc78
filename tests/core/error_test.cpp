#include "pbrt/core/error.h"

#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::test::error_test {
namespace {

TEST(Error, PlacesShowWhatIsKnown) {
    EXPECT_EQ((FileLoc{"a.pbrt", 3, 7}).ToString(), "a.pbrt:3:7");
    EXPECT_EQ((FileLoc{"a.pbrt", 0, 0}).ToString(), "a.pbrt");
    EXPECT_EQ(FileLoc{}.ToString(), "");
}

TEST(Error, NamesOfFilesAreKeptOnce) {
    const std::string path = "/a/path/that/is/longer/than/short/strings.pbrt";
    const FileName a = path, b = path.c_str(), other = "b.pbrt", none = "";
    EXPECT_EQ(a, b);
    EXPECT_EQ(&a.Text(), &b.Text());
    EXPECT_EQ(a.Text(), path);
    EXPECT_LT(a, other);
    EXPECT_NE(a, other);
    EXPECT_EQ(none, FileName());
    EXPECT_TRUE(none.IsEmpty());
    EXPECT_LE(sizeof(FileLoc), 16u);
}

TEST(Error, DiagnosticsPutThePlaceFirst) {
    EXPECT_EQ((Diagnostic{Diagnostic::Severity::Error, {"a", 1, 2}, "bad"}).ToString(), "a:1:2: error: bad");
    EXPECT_EQ((Diagnostic{Diagnostic::Severity::Warning, {}, "odd"}).ToString(), "warning: odd");
}

TEST(Error, ExcerptsAreShortAndPrintable) {
    EXPECT_EQ(Excerpt("a b"), "a b");
    EXPECT_EQ(Excerpt("a\n\x7f\x1b"), "a???");
    EXPECT_EQ(Excerpt(std::string(40, 'x')), std::string(40, 'x'));
    EXPECT_EQ(Excerpt(std::string(1000000, 'x')), std::string(40, 'x') + "...");
    // A character of two bytes that would be split is left out.
    EXPECT_EQ(Excerpt(std::string(39, 'x') + "\xc3\xa9"), std::string(39, 'x') + "...");
    EXPECT_EQ(Excerpt(std::string(38, 'x') + "\xc3\xa9z"), std::string(38, 'x') + "\xc3\xa9...");
}

TEST(Error, FileErrorsKeepPathAndProblemApart) {
    const FileError e("a.ply", "is too large", {"s.pbrt", 1, 2});
    EXPECT_EQ(e.Path(), "a.ply");
    EXPECT_EQ(e.Problem(), "is too large");
    EXPECT_EQ(e.Message(), "a.ply: is too large");
    EXPECT_STREQ(e.what(), "s.pbrt:1:2: error: a.ply: is too large");
}

TEST(Error, SceneErrorsKeepMessageAndPlaceApart) {
    const SceneError e({"a", 1, 2}, "bad");
    EXPECT_STREQ(e.what(), "a:1:2: error: bad");
    EXPECT_EQ(e.Message(), "bad");
    EXPECT_EQ(e.Loc().column, 2);
}

TEST(Error, SeveralErrorsAreOneALine) {
    const SceneErrors e(
        {{Diagnostic::Severity::Error, {"a", 1, 1}, "x"}, {Diagnostic::Severity::Error, {}, "y"}});
    EXPECT_STREQ(e.what(), "a:1:1: error: x\nerror: y");
}

TEST(Error, FileErrorsNameTheFileAndWhereItIsNamed) {
    const FileError e("mesh.ply", "cannot open", {"a", 4, 1});
    EXPECT_STREQ(e.what(), "a:4:1: error: mesh.ply: cannot open");
    EXPECT_EQ(e.Path(), "mesh.ply");
    EXPECT_EQ(e.Message(), "mesh.ply: cannot open");
}

TEST(Error, NearestNameIgnoresCaseAndAllowsAThirdOfTheLength) {
    const std::vector<std::string> names = {"sphere", "disk", "cylinder"};
    EXPECT_EQ(NearestName("Spehre", names), "sphere");
    EXPECT_EQ(NearestName("cylindre", names), "cylinder");
    EXPECT_EQ(NearestName("dsik", names), "disk");
    EXPECT_EQ(NearestName("torus", names), "");
    EXPECT_EQ(NearestName(std::string(101, 's'), names), "");
    EXPECT_EQ(NearestName("x", {}), "");
    EXPECT_EQ(DidYouMean("shpere", names), "; did you mean \"sphere\"?");
    EXPECT_EQ(DidYouMean("torus", names), "");
}

/// The definition of the distance, by recursion.
int DistanceByDefinition(std::string_view a, std::string_view b) {
    if (a.empty() || b.empty()) return int(a.size() + b.size());
    int least = std::min(DistanceByDefinition(a.substr(1), b), DistanceByDefinition(a, b.substr(1))) + 1;
    least = std::min(least, DistanceByDefinition(a.substr(1), b.substr(1)) + (a[0] != b[0]));
    if (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0])
        least = std::min(least, DistanceByDefinition(a.substr(2), b.substr(2)) + 1);
    return least;
}

// Names that are out of reach are left early: three letters make near ones and swaps frequent.
TEST(Error, NearestNameIsTheFirstOfTheSmallestDistance) {
    Rng rng(SeedOf(FullTestName()));
    const auto random = [&] {
        std::string name(size_t(rng.Uniform() * 8), 'a');
        for (char& c : name) c = char('a' + int(rng.Uniform() * 3));
        return name;
    };
    int numFound = 0, numSwaps = 0;
    for (int i = 0; i < 2000; ++i) {
        const std::string name = random();
        const std::vector<std::string> names = {random(), random(), random(), random(), random()};
        std::string expected;
        int distance = std::max(1, int(name.size()) / 3) + 1;
        for (const std::string& candidate : names)
            if (const int d = DistanceByDefinition(name, candidate); d < distance) {
                distance = d;
                expected = candidate;
            }
        ASSERT_EQ(NearestName(name, names), expected) << name << " in " << testing::PrintToString(names);
        numFound += !expected.empty();
        std::string sorted[] = {name, expected};
        for (std::string& letters : sorted) std::sort(letters.begin(), letters.end());
        numSwaps += distance == 1 && name != expected && sorted[0] == sorted[1];
    }
    EXPECT_GT(numFound, 100) << "power";
    EXPECT_GT(numSwaps, 3) << "power";
}

}  // namespace
}  // namespace lacquer::test::error_test
