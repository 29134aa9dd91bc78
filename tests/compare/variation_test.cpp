// Parts of a scene by their names.
#include "compare/variation.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "pbrt/scene/parser.h"

namespace lacquer::compare::variation_test {
namespace {

SceneDescription Scene() {
    return ParseText(R"(
        Camera "perspective" "float fov" 40
        Sampler "halton" "integer pixelsamples" 8
        WorldBegin
        LightSource "distant"
        LightSource "infinite" "rgb L" [1 1 1]
        MakeNamedMaterial "film" "string type" "diffuse"
        MakeNamedMaterial "paint" "string type" "diffuse" "float a.b" 1
        NamedMaterial "paint"
        AttributeBegin
        AreaLightSource "diffuse"
        Shape "sphere" "float radius" 2
        AttributeEnd
        Shape "disk")",
                     "scene.pbrt", "", nullptr);
}

const Parameter& Find(const PluginEntity& entity, const std::string& name) {
    for (const Parameter& p : entity.parameters)
        if (p.name == name) return p;
    throw std::out_of_range(name);
}

TEST(Variation, PartsHaveNames) {
    SceneDescription scene = Scene();
    Apply({"camera.fov", {}}, "30", &scene);
    EXPECT_EQ(Find(scene.camera, "fov").floats, std::vector<float>{30});
    Apply({"sampler.pixelsamples", {}}, "16", &scene);
    EXPECT_EQ(Find(scene.sampler, "pixelsamples").integers, std::vector<int>{16});
    Apply({"integrator.maxdepth", {}, "integer"}, "3", &scene);
    EXPECT_EQ(Find(scene.integrator, "maxdepth").integers, std::vector<int>{3});
    Apply({"light@2.rgb L", {}}, "1 2 3", &scene);
    EXPECT_EQ(Find(scene.lights[1], "L").floats, (std::vector<float>{1, 2, 3}));
    Apply({"arealight@1.scale", {}}, "4", &scene);
    EXPECT_EQ(Find(scene.areaLights[0], "scale").floats, std::vector<float>{4});
    Apply({"shape@1.radius", {}}, "5", &scene);
    EXPECT_EQ(Find(scene.shapes[0], "radius").floats, std::vector<float>{5});
    // Materials come first.
    Apply({"film.rgb reflectance", {}}, ".1 .2 .3", &scene);
    EXPECT_EQ(Find(scene.namedMaterials[0], "reflectance").floats.size(), 3u);
    Apply({"paint.a.b", {}}, "7", &scene);
    EXPECT_EQ(Find(scene.namedMaterials[1], "a.b").floats, std::vector<float>{7});
}

TEST(Variation, PartsAreListed) {
    std::vector<std::string> names;
    for (const auto& [name, type] : PartsOf(Scene())) names.push_back(name + " " + type);
    EXPECT_EQ(names, (std::vector<std::string>{"camera perspective", "film rgb", "filter gaussian",
                                               "sampler halton", "integrator volpath", "accelerator bvh",
                                               "light@1 distant", "light@2 infinite", "arealight@1 diffuse",
                                               "shape@1 sphere", "shape@2 disk"}));
}

TEST(Variation, UnknownPartsNameTheNearest) {
    const auto why = [](const std::string& target) -> std::string {
        SceneDescription scene = Scene();
        try {
            Apply({target, {}}, "1", &scene);
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
        return {};
    };
    EXPECT_NE(why("camrea.fov").find("did you mean \"camera\"?"), std::string::npos) << why("camrea.fov");
    EXPECT_NE(why("pait.a").find("did you mean \"paint\"?"), std::string::npos);
    EXPECT_EQ(why("paint"), "\"paint\" names no parameter; expected paint.PARAMETER");
    EXPECT_NE(why("light@3.scale").find("light@1 to light@2"), std::string::npos) << why("light@3.scale");
    EXPECT_NE(why("light@0.scale"), "");
    EXPECT_NE(why("shape.radius"), "");
    EXPECT_NE(why("camera.fov 1"), "");
    EXPECT_EQ(why("camera.fov"), "");
}

}  // namespace
}  // namespace lacquer::compare::variation_test
