#include "pbrt/scene/naming.h"

#include <gtest/gtest.h>

#include "pbrt/core/arena.h"
#include "support/scene_parts.h"

namespace lacquer::naming_test {
namespace {

RenderSetup BuildWithNames(const std::string& text) {
    BuildOptions options;
    options.keepNames = true;
    return BuildScene(ParseText(text, "folder/room.pbrt", "", nullptr), options, nullptr);
}

constexpr const char* kRoom = R"(Camera "perspective"
WorldBegin
Shape "sphere"
ObjectBegin "tree"
    Shape "sphere" "float radius" .1
    Shape "disk"
ObjectEnd
ObjectInstance "tree"
Material "conductor"
Shape "sphere" "float radius" 2 Shape "sphere" "float radius" 3
MakeNamedMaterial "bark" "string type" "diffuse"
NamedMaterial "bark"
Translate 9 0 0
ObjectInstance "tree"
ActiveTransform EndTime
Translate 0 1 0
ActiveTransform All
Shape "sphere" "float radius" .5
)";

TEST(SceneNames, AreThoseOfInstancesAndPlacesOfShapes) {
    const RenderSetup setup = BuildWithNames(kRoom);
    EXPECT_EQ(setup.scene->Names().objects,
              (std::vector<std::string>{"sphere@room.pbrt:3", "sphere@room.pbrt:10", "sphere@room.pbrt:10#2",
                                        "sphere@room.pbrt:18", "tree", "tree#2"}));
    std::vector<std::string> materials;
    for (const auto& [material, name] : setup.scene->Names().materials) materials.push_back(name);
    EXPECT_EQ(materials, (std::vector<std::string>{"bark", "default", "conductor@room.pbrt:9"}));
}

TEST(SceneNames, AreNotKeptUnlessAskedFor) {
    const RenderSetup setup = test::BuildText(kRoom);
    EXPECT_TRUE(setup.scene->Names().objects.empty());
    EXPECT_TRUE(setup.scene->Names().materials.empty());
}

/// What a ray meets is named rightly: a shape of the world, an instance, and one that moves.
TEST(SceneNames, BelongToWhatRaysMeet) {
    const RenderSetup setup = BuildWithNames(kRoom);
    const auto seen = [&](Point3 world, Vec3 direction) {
        SurfaceInteraction si;
        const Ray ray{setup.renderFromWorld.Point(world), setup.renderFromWorld.Vector(direction), 0};
        if (!test::NearestHit(setup, ray, &si)) return std::string("nothing");
        return setup.scene->Names().objects.at(size_t(si.object));
    };
    EXPECT_EQ(seen({-20, 0, 0}, {1, 0, 0}), "sphere@room.pbrt:10#2");
    EXPECT_EQ(seen({-2.5f, 0, 0}, {1, 0, 0}), "sphere@room.pbrt:10");
    EXPECT_EQ(seen({-.5f, 0, .01f}, {1, 0, 0}), "tree");
    EXPECT_EQ(seen({20, 0, .01f}, {-1, 0, 0}), "sphere@room.pbrt:18");
    EXPECT_EQ(seen({9, 0, .3f}, {0, 0, -1}), "tree#2");
    EXPECT_EQ(seen({0, 20, 0}, {0, 1, 0}), "nothing");
}

TEST(SceneNames, OfShapesFromFilesAreTheirStems) {
    ShapeEntity shape;
    shape.type = "plymesh";
    shape.loc = {"a/b.pbrt", 7, 1};
    Parameter file;
    file.name = "filename";
    for (const auto& [path, name] :
         {std::pair("meshes/vase.ply", "vase"), std::pair("vase.001.ply.gz", "vase.001"),
          std::pair("", "plymesh@b.pbrt:7")}) {
        file.strings = {path};
        shape.parameters = {file};
        EXPECT_EQ(NameOf(shape), name);
    }
    shape.parameters.clear();
    EXPECT_EQ(NameOf(shape), "plymesh@b.pbrt:7");
}

TEST(UniqueNames, CountRepeatedOnes) {
    UniqueNames names;
    EXPECT_EQ(names.Make("tree"), "tree");
    EXPECT_EQ(names.Make("tree#3"), "tree#3");
    EXPECT_EQ(names.Make("tree"), "tree#2");
    EXPECT_EQ(names.Make("tree"), "tree#4");
    EXPECT_EQ(names.Make("tree#3"), "tree#3#2");
}

TEST(UniqueNames, LeaveToTheSceneWhatItCallsItself) {
    UniqueNames names;
    for (const char* name : {"o", "o", "o#2", "o"}) names.Reserve(name);
    EXPECT_EQ(names.Make("o"), "o");
    EXPECT_EQ(names.Make("o"), "o#3");
    EXPECT_EQ(names.Make("o#2"), "o#2");
    EXPECT_EQ(names.Make("o"), "o#4");
}

TEST(SceneNames, OfTheSceneAreNotGivenToOthers) {
    const RenderSetup setup = BuildWithNames(R"(Camera "perspective"
WorldBegin
ObjectBegin "o" Shape "sphere" ObjectEnd
ObjectBegin "o#2" Shape "disk" ObjectEnd
ObjectInstance "o" ObjectInstance "o" ObjectInstance "o#2"
MakeNamedMaterial "m#2" "string type" "diffuse"
)");
    EXPECT_EQ(setup.scene->Names().objects, (std::vector<std::string>{"o", "o#3", "o#2"}));
}

}  // namespace
}  // namespace lacquer::naming_test
