#include "pbrt/textures/texture_mapping.h"

#include "textures/texture_fixture.h"

namespace lacquer::texture_mapping_test {
namespace {

using namespace testing_support;

class TextureMapping : public Textures {
  protected:
    std::unique_ptr<TextureMapping2D> Make(std::vector<Parameter> parameters, Transform transform = {}) {
        const Params params = MakeParams(std::move(parameters));
        auto mapping = MakeTextureMapping2D({params, transform, library});
        params.CheckAllUsed();
        return mapping;
    }
};

TEST_F(TextureMapping, UvScalesAndShifts) {
    const auto mapping = Make({Numbers("float", "uscale", {2}), Numbers("float", "vscale", {3}),
                               Numbers("float", "udelta", {0.5f}), Numbers("float", "vdelta", {-1})});
    TextureContext context = At(0.25f, 0.5f);
    context.dudx = 1;
    context.dudy = 2;
    context.dvdx = 3;
    context.dvdy = 4;
    const TextureFootprint f = mapping->Map(context);
    EXPECT_EQ(f.st, Point2(1, 0.5f));
    EXPECT_EQ(f.dstdx, Vec2(2, 9));
    EXPECT_EQ(f.dstdy, Vec2(4, 12));
}

TEST_F(TextureMapping, SphericalHasThePolarAngleFirst) {
    const auto mapping = Make({Text("string", "mapping", "spherical")});
    const auto at = [&](Point3 p) { return mapping->Map(At(p)).st; };
    EXPECT_NEAR(at({0, 0, 2}).x, 0, 1e-6f);
    EXPECT_NEAR(at({0, 0, -2}).x, 1, 1e-6f);
    EXPECT_NEAR(at({3, 0, 0}).x, 0.5f, 1e-6f);
    EXPECT_NEAR(at({3, 0, 0}).y, 0, 1e-6f);
    EXPECT_NEAR(at({0, 3, 0}).y, 0.25f, 1e-6f);
    EXPECT_NEAR(at({0, -3, 0}).y, 0.75f, 1e-6f);
}

TEST_F(TextureMapping, CylindricalStartsBehind) {
    const auto mapping = Make({Text("string", "mapping", "cylindrical")});
    const Point2 st = mapping->Map(At(Point3(2, 0, -0.7f))).st;
    EXPECT_NEAR(st.x, 0.5f, 1e-6f);
    EXPECT_NEAR(st.y, -0.7f, 1e-6f);
    EXPECT_NEAR(mapping->Map(At(Point3(0, 1, 0))).st.x, 0.75f, 1e-6f);
}

TEST_F(TextureMapping, PlanarProjectsInTextureSpace) {
    const auto mapping = Make({Text("string", "mapping", "planar"), Numbers("vector3", "v1", {0.5f, 0, 0}),
                               Numbers("vector3", "v2", {0, 0.2f, 0.5f}), Numbers("float", "udelta", {0.3f})},
                              Transform::Translate({1, 2, 3}));
    const Point2 st = mapping->Map(At(Point3(3, 2, 4))).st;  // (2, 0, 1) in texture space
    EXPECT_NEAR(st.x, 1.3f, 1e-6f);
    EXPECT_NEAR(st.y, 0.5f, 1e-6f);
}

TEST_F(TextureMapping, FootprintsAreDerivatives) {
    // Central differences over 2h with h = 1e-2 times the footprint: error O(h^2) plus rounding of st / h,
    // below 1 %.
    const Transform transform = Transform::Rotate(30, {1, 2, 3}) * Transform::Scale({2, 1, 0.5f});
    for (const char* name : {"spherical", "cylindrical", "planar"}) {
        const auto mapping = Make({Text("string", "mapping", name)}, transform);
        for (const Point3 p :
             {Point3(0.4f, 0.5f, 0.6f), Point3(-1, 0.3f, 0.2f), Point3(0.5f, -0.7f, -0.9f)}) {
            TextureContext context = At(p);
            context.dpdx = {0.3f, -0.1f, 0.2f};
            context.dpdy = {0.1f, 0.2f, -0.4f};
            const TextureFootprint f = mapping->Map(context);
            const float h = 1e-2f;
            const auto difference = [&](Vec3 d) {
                return (mapping->Map(At(p + h * d)).st - mapping->Map(At(p - h * d)).st) / (2 * h);
            };
            const Vec2 dx = difference(context.dpdx), dy = difference(context.dpdy);
            for (int i = 0; i < 2; ++i) {
                EXPECT_NEAR(f.dstdx[i], dx[i], 1e-3f) << name;
                EXPECT_NEAR(f.dstdy[i], dy[i], 1e-3f) << name;
            }
        }
    }
}

TEST_F(TextureMapping, TheAxisGivesFiniteFootprints) {
    for (const char* name : {"spherical", "cylindrical"}) {
        const auto mapping = Make({Text("string", "mapping", name)});
        for (const Point3 p : {Point3(0, 0, 1), Point3(0, 0, 0)}) {
            TextureContext context = At(p);
            context.dpdx = {1, 1, 1};
            const TextureFootprint f = mapping->Map(context);
            EXPECT_TRUE(std::isfinite(f.st.x) && std::isfinite(f.st.y) && std::isfinite(f.dstdx.x) &&
                        std::isfinite(f.dstdx.y));
        }
    }
}

TEST_F(TextureMapping, BadParametersAreErrors) {
    EXPECT_THROW(Make({Text("string", "mapping", "sphere")}), SceneError);
    EXPECT_THROW(Make({Numbers("float", "uscale", {std::nanf("")})}), SceneError);
    EXPECT_THROW(Make({Text("string", "mapping", "planar"), Numbers("vector3", "v1", {Infinity, 0, 0})}),
                 SceneError);
    // Each mapping has its own parameters only.
    EXPECT_THROW(Make({Text("string", "mapping", "spherical"), Numbers("float", "uscale", {2})}),
                 SceneErrors);
}

}  // namespace
}  // namespace lacquer::texture_mapping_test
