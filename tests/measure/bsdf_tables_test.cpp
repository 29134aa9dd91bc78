#include "measure/bsdf_tables.h"

#include <gtest/gtest.h>

#include <cstring>

#include "measure/scene_material.h"
#include "pbrt/scattering/fresnel.h"
#include "pbrt/scene/parser.h"

namespace lacquer::measure::bsdf_tables_test {
namespace {

SceneMaterial Make(const std::string& rest) {
    return LoadMaterial(
        ParseText("WorldBegin MakeNamedMaterial \"m\" \"string type\" " + rest, "scene.pbrt", "", nullptr),
        "m");
}
double CellOf(const MerlTable& t, int channel, int half, int difference, int azimuth) {
    return t.values[size_t(((channel * MerlTable::kHalf + half) * MerlTable::kDifference + difference) *
                               MerlTable::kAzimuth +
                           azimuth)];
}

TEST(MerlTable, LambertianIsTheSameWhereverItIsSeen) {
    const MerlTable t =
        TabulateMerl(*Make("\"diffuse\" \"rgb reflectance\" [0.5 0.25 0.1]").bsdf, {}, nullptr);
    EXPECT_NEAR(CellOf(t, 0, 10, 20, 30), 0.5 / 3.14159265, 2e-3);
    EXPECT_NEAR(CellOf(t, 1, 40, 5, 170), 0.25 / 3.14159265, 2e-3);
    EXPECT_NEAR(CellOf(t, 2, 0, 88, 3), 0.1 / 3.14159265, 2e-3);
    // Half vector and difference both almost flat: one of the directions lies below.
    EXPECT_EQ(CellOf(t, 0, 89, 80, 5), -1);
}

// A lobe about the mirror direction depends on the half angle, and by Fresnel's factor on the difference.
TEST(MerlTable, RoughMetalFollowsItsHalfAngle) {
    const MerlTable t = TabulateMerl(*Make("\"conductor\" \"float roughness\" 0.1").bsdf, {}, nullptr);
    EXPECT_GT(CellOf(t, 0, 0, 10, 90), 10 * CellOf(t, 0, 70, 10, 90));
    EXPECT_NEAR(CellOf(t, 0, 5, 0, 10), CellOf(t, 0, 5, 0, 100), 0.01 * CellOf(t, 0, 5, 0, 10));
    EXPECT_GT(CellOf(t, 2, 0, 88, 90) / CellOf(t, 0, 0, 88, 90),
              CellOf(t, 2, 0, 10, 90) / CellOf(t, 0, 0, 10, 90));
}

TEST(MerlTable, FilesAreScaledAsTheDatabase) {
    MerlTable t;
    t.values.assign(size_t(3) * MerlTable::kHalf * MerlTable::kDifference * MerlTable::kAzimuth, 1);
    t.values[0] = -1;
    const std::string bytes = t.Bytes();
    ASSERT_EQ(bytes.size(), 12 + 8 * t.values.size());
    int sizes[3];
    std::memcpy(sizes, bytes.data(), sizeof(sizes));
    EXPECT_EQ(sizes[2], 180);
    const auto stored = [&](size_t i) {
        double x;
        std::memcpy(&x, bytes.data() + 12 + 8 * i, sizeof(x));
        return x;
    };
    EXPECT_EQ(stored(0), -1);
    EXPECT_NEAR(stored(1), 1500, 1e-9);
    EXPECT_NEAR(stored(t.values.size() - 1), 1500 / 1.66, 1e-9);
}

double Reflected(const KlemsTable& t, const std::vector<double>& values, int incoming) {
    double sum = 0;
    for (int outgoing = 0; outgoing < KlemsTable::kPatches; ++outgoing)
        sum += values[size_t(outgoing * KlemsTable::kPatches + incoming)] * t.SolidAngleOf(outgoing);
    return sum;
}

TEST(KlemsTable, PatchesCoverTheHemisphere) {
    double sum = 0;
    for (int patch = 0; patch < KlemsTable::kPatches; ++patch) sum += KlemsTable::SolidAngleOf(patch);
    EXPECT_NEAR(sum, 3.14159265, 1e-6);
}

TEST(KlemsTable, LambertianHasOneValue) {
    const KlemsTable t =
        TabulateKlems(*Make("\"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]").bsdf, {64, 1}, nullptr);
    for (const int incoming : {0, 30, 144}) EXPECT_NEAR(Reflected(t, t.frontReflection, incoming), 0.5, 2e-3);
    // Patch 100 of 32,768 draws: 1 / (solid angle share) of them.
    EXPECT_NEAR(t.frontReflection[size_t(100 * KlemsTable::kPatches + 40)], 0.5 / 3.14159265, 0.05);
    EXPECT_EQ(Reflected(t, t.frontTransmission, 10), 0);
}

TEST(KlemsTable, GlassSendsLightToThePatchOfItsRefraction) {
    // A pane: straight through, and the mirror direction on the other side of the normal.
    const KlemsTable t = TabulateKlems(*Make("\"thindielectric\" \"float eta\" 1.5").bsdf, {4, 1}, nullptr);
    const int incoming = 1;  // of the first ring, at azimuth 0
    const double reflected = Reflected(t, t.frontReflection, incoming),
                 transmitted = Reflected(t, t.frontTransmission, incoming);
    EXPECT_NEAR(reflected + transmitted, 1, 1e-5);
    EXPECT_NEAR(reflected, 2 * 0.04 / 1.04, 5e-3);
    const int opposite = 5;  // half a turn from it
    EXPECT_NEAR(t.frontTransmission[size_t(opposite * KlemsTable::kPatches + incoming)] *
                    KlemsTable::SolidAngleOf(opposite),
                transmitted, 1e-9);
}

TEST(KlemsTable, WritesADocument) {
    const KlemsTable t = TabulateKlems(*Make("\"diffuse\"").bsdf, {1, 1}, nullptr);
    const std::string xml = t.Xml("a <b> & c");
    for (const char* part :
         {"<Name>a &lt;b&gt; &amp; c</Name>", "LBNL/Klems Full", "Transmission Back", "Reflection Front"})
        EXPECT_NE(xml.find(part), std::string::npos) << part;
}

}  // namespace
}  // namespace lacquer::measure::bsdf_tables_test
