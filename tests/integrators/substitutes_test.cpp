// Integrators that are not ours: the image of volpath, and one warning.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"

namespace lacquer::substitutes_test {
namespace {

std::string Scene(const std::string& integrator) {
    return "LookAt 0 0 -3  0 0 0  0 1 0 Camera \"perspective\" Film \"rgb\" \"integer xresolution\" 8 "
           "\"integer "
           "yresolution\" 8 Sampler \"independent\" Integrator " +
           integrator + " WorldBegin LightSource \"infinite\" Shape \"sphere\"";
}
void ExpectVolPath(const std::string& name, const std::string& parameters, const std::string& same) {
    test::WarningList warnings;
    const auto setup = test::BuildText(Scene("\"" + name + "\" " + parameters), &warnings);
    EXPECT_EQ(warnings.text, "scene.pbrt:1:131: warning: integrator \"" + name +
                                 "\" is not in Lacquer; \"volpath\" renders the scene instead\n");
    test::RenderAll(setup);
    const auto image = setup.film->Develop(), expected = test::RenderText(Scene("\"volpath\" " + same));
    EXPECT_EQ(image->Pixels(), expected->Pixels());
}

TEST(Substitutes, RenderLikeVolPathAndSaySoOnce) {
    ExpectVolPath("function",
                  "\"string function\" \"disk\" \"string filename\" \"e.txt\" \"bool skipbad\" true "
                  "\"string imagefilename\" \"a.exr\"",
                  "");
}

TEST(Substitutes, KnowTheirParameters) {
    EXPECT_NE(test::BuildErrorsOf(Scene("\"function\" \"integer maxdepth\" -1")).find("maxdepth"),
              std::string::npos);
}

/// What is asked of the name alone, before a scene is built, is what the integrator says.
TEST(Integrators, MakeSplatsIfTheirTraitsSaySo) {
    int count = 0;
    for (const std::string& name : Registry<IntegratorKind>::Names()) {
        std::string scene = Scene("\"" + name + "\"");
        scene.resize(scene.find("Shape"));  // one of them knows no surfaces
        const auto setup = test::BuildText(scene);
        const bool makes = Registry<IntegratorKind>::TraitsOf(name).makesSplats;
        EXPECT_EQ(setup.integrator->MakesSplats(), makes) << name;
        EXPECT_EQ(setup.integrator->UsesChains(),
                  Registry<IntegratorKind>::TraitsOf(name).mutationsPerPixel != nullptr)
            << name;
        count += makes;
    }
    EXPECT_EQ(count, 3);
}

TEST(LightTracers, NeedThePerspectiveCameraAndAFilmForSplats) {
    for (const std::string name : {"bdpt", "lightpath", "mlt"})
        for (const std::string camera : {"orthographic", "spherical"}) {
            const std::string errors = test::BuildErrorsOf("Camera \"" + camera + "\" Integrator \"" + name +
                                                           "\" WorldBegin Shape \"sphere\"");
            EXPECT_NE(errors.find("perspective camera only"), std::string::npos) << errors;
        }
    EXPECT_NE(test::BuildErrorsOf("Integrator \"bdpt\" \"bool visualizeweights\" true WorldBegin")
                  .find("single strategies"),
              std::string::npos);
}

}  // namespace
}  // namespace lacquer::substitutes_test
