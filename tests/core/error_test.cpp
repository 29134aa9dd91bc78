#include "pbrt/core/error.h"

#include <gtest/gtest.h>

namespace lacquer::test {
namespace {

TEST(Error, PlacesShowWhatIsKnown) {
    EXPECT_EQ((FileLoc{"a.pbrt", 3, 7}).ToString(), "a.pbrt:3:7");
    EXPECT_EQ((FileLoc{"a.pbrt", 0, 0}).ToString(), "a.pbrt");
    EXPECT_EQ(FileLoc{}.ToString(), "");
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

}  // namespace
}  // namespace lacquer::test
