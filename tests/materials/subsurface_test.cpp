// What the material "subsurface" makes of its parameters.
#include <gtest/gtest.h>

#include "pbrt/scattering/bssrdf_table.h"
#include "support/scene_parts.h"

namespace lacquer::test::subsurface_test {
namespace {

/// The medium of a material at one point, and what can be seen of it.
struct Medium {
    SampledSpectrum effectiveAlbedo;
    float radius = 0;  ///< of the neighbourhood that is searched: goes with the mean free path
    SampledSpectrum Sp;
    bool operator==(const Medium&) const = default;
};

Medium MediumOf(const std::string& parameters) {
    // One table for all tests.
    static const std::shared_ptr<const BssrdfTable> table = BssrdfTable::Shared(0, 1.33f);
    const RenderSetup setup = BuildText("WorldBegin LightSource \"infinite\" Material \"subsurface\" " +
                                        parameters + " Shape \"sphere\"");
    SurfaceInteraction si;
    Medium medium;
    if (!test::NearestHit(setup, {{0, 0, 5}, {0, 0, -1}, 0}, &si)) return medium;
    Arena arena;
    const BSSRDF* bssrdf =
        si.material->MakeBSSRDF(TextureContext(si), SampledWavelengths::SampleVisible(0.4f), arena);
    if (!bssrdf) return medium;
    medium.effectiveAlbedo = bssrdf->EffectiveAlbedo();
    if (const auto probe = bssrdf->SampleProbe(0.9f, {0.5f, 0.5f})) medium.radius = probe->radius;
    medium.Sp = bssrdf->Evaluate(si.p + Vec3(0.3f, 0, 0), si.n).Sp;
    return medium;
}

const std::string kMilk = "\"rgb sigma_a\" [0.0011 0.0024 0.014] \"rgb sigma_s\" [2.55 3.21 3.77] ";

TEST(SubsurfaceMaterial, IsWholeMilkUnlessToldOtherwise) {
    const Medium milk = MediumOf("");
    EXPECT_GT(milk.effectiveAlbedo.MinComponent(), 0.7f);
    EXPECT_GT(milk.Sp.MinComponent(), 0);
    EXPECT_EQ(MediumOf("\"string name\" \"Wholemilk\""), milk);
    EXPECT_EQ(MediumOf(kMilk), milk);
    EXPECT_NE(MediumOf("\"string name\" \"Ketchup\""), milk);
}

TEST(SubsurfaceMaterial, NamedMediaScatterIsotropically) {
    EXPECT_EQ(MediumOf("\"string name\" \"Skin1\" \"float g\" 0.8"), MediumOf("\"string name\" \"Skin1\""));
    EXPECT_NE(MediumOf(kMilk + "\"float g\" 0.8"), MediumOf(kMilk));
}

TEST(SubsurfaceMaterial, ReflectanceIsTheShareThatComesOut) {
    const Medium medium =
        MediumOf("\"spectrum reflectance\" [300 0.6 900 0.6] \"spectrum mfp\" [300 0.1 900 0.1]");
    for (int i = 0; i < kNumWavelengths; ++i) EXPECT_NEAR(medium.effectiveAlbedo[i], 0.6f, 1e-4f);
}

// The coefficients are per length, the mean free path is a length.
TEST(SubsurfaceMaterial, ScaleMultipliesCoefficientsOrTheMeanFreePath) {
    // Radii are found to some 1e-6 of the table's range.
    EXPECT_NEAR(MediumOf(kMilk).radius / MediumOf(kMilk + "\"float scale\" 10").radius, 10, 1e-2f);
    const std::string reflectance = "\"rgb reflectance\" [0.6 0.5 0.4] ";
    EXPECT_NEAR(MediumOf(reflectance + "\"float scale\" 10").radius / MediumOf(reflectance).radius, 10,
                1e-4f);
    EXPECT_EQ(MediumOf(reflectance + "\"rgb mfp\" [2 2 2]"), MediumOf(reflectance + "\"float scale\" 2"));
}

// What has no effect is left over, as in pbrt.
TEST(SubsurfaceMaterial, OneFormTakesPrecedenceAndLeavesTheOthersUnused) {
    const auto errorsOf = [](const std::string& parameters) {
        return BuildErrorsOf("WorldBegin LightSource \"infinite\" Material \"subsurface\" " + parameters +
                             " Shape \"sphere\"");
    };
    EXPECT_EQ(errorsOf("\"string name\" \"Marble\""), "");
    EXPECT_NE(errorsOf("\"string name\" \"Marble\" " + kMilk).find("sigma_a"), std::string::npos);
    EXPECT_NE(errorsOf(kMilk + "\"rgb reflectance\" [.5 .5 .5]").find("reflectance"), std::string::npos);
    EXPECT_NE(errorsOf("\"rgb mfp\" [.5 .5 .5]").find("mfp"), std::string::npos);
}

TEST(SubsurfaceMaterial, EmptyMediaLetNothingOut) {
    const Medium none = MediumOf("\"float scale\" 0");
    EXPECT_EQ(none.effectiveAlbedo, SampledSpectrum(0));
    EXPECT_EQ(none.radius, 0);
    EXPECT_TRUE(MediumOf("\"rgb reflectance\" [1 1 1] \"rgb mfp\" [0 0 0]").Sp.IsValid());
}

}  // namespace
}  // namespace lacquer::test::subsurface_test
