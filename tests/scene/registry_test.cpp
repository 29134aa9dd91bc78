// The exact list of names that scene files may use. A new plugin adds its name here; a name that is lost
// (say, by linking the library in a way that drops static registration) is found.
#include <gtest/gtest.h>

#include "layered/estimator.h"
#include "pbrt/base/camera.h"
#include "pbrt/base/film.h"
#include "pbrt/base/integrator.h"
#include "pbrt/base/light.h"
#include "pbrt/base/material.h"
#include "pbrt/base/medium.h"
#include "pbrt/base/sampler.h"
#include "pbrt/base/shape.h"
#include "pbrt/film/aov_output.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"

namespace lacquer::registry_test {
namespace {

using Names = std::vector<std::string>;

TEST(RegisteredNames, AreExactlyThese) {
    EXPECT_EQ(Registry<CameraKind>::Names(),
              (Names{"orthographic", "perspective", "realistic", "spherical"}));
    EXPECT_EQ(Registry<FilmKind>::Names(), (Names{"gbuffer", "rgb", "spectral"}));
    EXPECT_EQ(Registry<FilterKind>::Names(), (Names{"box", "gaussian", "mitchell", "sinc", "triangle"}));
    EXPECT_EQ(Registry<SamplerKind>::Names(),
              (Names{"halton", "independent", "paddedsobol", "pmj02bn", "sobol", "stratified", "zsobol"}));
    EXPECT_EQ(Registry<IntegratorKind>::Names(),
              (Names{"ambientocclusion", "bdpt", "function", "lightpath", "mlt", "path", "randomwalk",
                     "simplepath", "simplevolpath", "sppm", "volpath"}));
    EXPECT_EQ(Registry<LightSamplerKind>::Names(), (Names{"bvh", "exhaustive", "power", "uniform"}));
    EXPECT_EQ(Registry<LightKind>::Names(),
              (Names{"distant", "goniometric", "infinite", "point", "projection", "spot"}));
    EXPECT_EQ(Registry<AreaLightKind>::Names(), (Names{"diffuse"}));
    EXPECT_EQ(Registry<MaterialKind>::Names(),
              (Names{"coatedconductor", "coateddiffuse", "conductor", "dielectric", "diffuse",
                     "diffusetransmission", "flakes", "hair", "interface", "layered", "measured", "mix",
                     "openpbr", "slab", "subsurface", "svbrdf", "thindielectric"}));
    EXPECT_EQ(Registry<layered::LayeredEstimatorKind>::Names(),
              (Names{"auto", "belcour", "bidirectional", "forward", "halfvector", "multiproduct",
                     "pairproduct", "unidirectional"}));
    EXPECT_EQ(Registry<layered::LayeredPdfKind>::Names(),
              (Names{"approximate", "auto", "belcour", "gaussian", "unbiased"}));
    EXPECT_EQ(Registry<FloatTextureKind>::Names(),
              (Names{"bilerp", "checkerboard", "constant", "directionmix", "dots", "fbm", "imagemap", "mix",
                     "scale", "windy", "wrinkled"}));
    EXPECT_EQ(Registry<SpectrumTextureKind>::Names(),
              (Names{"bilerp", "checkerboard", "constant", "directionmix", "dots", "imagemap", "marble",
                     "mix", "scale"}));
    EXPECT_EQ(Registry<MediumKind>::Names(),
              (Names{"cloud", "homogeneous", "nanovdb", "rgbgrid", "uniformgrid"}));
    EXPECT_EQ(Registry<AovKind>::Names(),
              (Names{"albedo", "alpha", "depth", "motion", "ng", "normal", "position", "samples",
                     "sensorvariance", "slope", "uv", "variance"}));
    EXPECT_EQ(Registry<PhaseKind>::Names(),
              (Names{"bulk", "fibre", "hg", "isotropic", "mixture", "sggx", "table", "vmf"}));
    EXPECT_EQ(Registry<ShapeKind>::Names(), (Names{"bilinearmesh", "curve", "cylinder", "disk", "loopsubdiv",
                                                   "plymesh", "sphere", "trianglemesh"}));
}

/// What the scene says is wrong with a material of this type that is given a stack and no known estimator.
std::string ErrorsOf(const std::string& type) {
    const std::string text =
        "WorldBegin MakeNamedMaterial \"d\" \"string type\" \"diffuse\"\n"
        "MakeNamedMaterial \"x\" \"string type\" \"" +
        type + "\" \"string stack\" [\"d\"] \"string estimator\" \"guesswork\"";
    try {
        BuildMaterial(ParseText(text, "t", ".", nullptr), "x", {}, nullptr);
        return "";
    } catch (const std::exception& e) {
        return e.what();
    }
}

// Commands take the registry's word for it; a material that takes an estimator and does not say so would be
// left out by `info` and `compare`.
TEST(RegisteredNames, LayeredMaterialsAreThoseThatTakeAnEstimator) {
    int numLayered = 0;
    for (const std::string& name : Registry<MaterialKind>::Names()) {
        const bool takesEstimator = ErrorsOf(name).find("not \"guesswork\"") != std::string::npos;
        EXPECT_EQ(Registry<MaterialKind>::TraitsOf(name).isLayered, takesEstimator)
            << name << ": " << ErrorsOf(name);
        numLayered += takesEstimator;
    }
    EXPECT_EQ(numLayered, 4);
}

}  // namespace
}  // namespace lacquer::registry_test
