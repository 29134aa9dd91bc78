// Displacement and normal maps: Material::Bump.
#include <filesystem>

#include "pbrt/base/material.h"
#include "textures/texture_fixture.h"

namespace lacquer::bump_test {
namespace {

using namespace testing_support;

class BareMaterial final : public Material {
  public:
    BareMaterial(const Params& params, TextureLibrary& textures) { ReadBump(params, textures); }
    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths&, Arena&) const override { return nullptr; }
};

/// d = a u + b v.
class Slope final : public FloatTexture {
  public:
    Slope(float a, float b) : a_(a), b_(b) {}
    float Evaluate(const TextureContext& context) const override {
        return a_ * context.uv.x + b_ * context.uv.y;
    }

  private:
    float a_, b_;
};

class Bump : public Textures {
  protected:
    /// A plane z = 0 with tangents of lengths 2 and 3.
    static SurfaceInteraction Plane() {
        SurfaceInteraction si;
        si.SetGeometry({0, 0, 0}, 0, {0.3f, 0.4f}, {2, 0, 0}, {0, 3, 0}, false);
        return si;
    }
    void Displace(SurfaceInteraction& si, float a, float b) {
        library.floats["d"] = library.Own(std::make_unique<Slope>(a, b));
        BareMaterial(MakeParams({Text("texture", "displacement", "d")}), library).Bump(si);
    }
    void MapNormal(SurfaceInteraction& si, RGB rgb) {
        Image image({2, 2}, {"R", "G", "B"});
        for (int i = 0; i < 12; ++i) image.Pixels()[size_t(i)] = rgb[i % 3];
        const auto path = (std::filesystem::temp_directory_path() /
                           (std::string("lacquer-bump-") +
                            testing::UnitTest::GetInstance()->current_test_info()->name() + ".exr"))
                              .string();
        WriteImage(image, path);
        BareMaterial(MakeParams({Text("string", "normalmap", path)}), library).Bump(si);
        std::filesystem::remove(path);
    }
};

TEST_F(Bump, LinearDisplacementTiltsThePlane) {
    // The displaced tangents are (2, 0, a) and (0, 3, b); the normal is their cross product.
    for (const auto& [a, b] : {std::pair(0.7f, 0.f), {0.f, -1.2f}, {0.5f, 0.8f}})
        for (const float footprint : {0.f, 0.01f}) {
            SurfaceInteraction si = Plane();
            si.dudx = si.dvdy = footprint;
            Displace(si, a, b);
            const Vec3 expected = Normalize(Vec3(-a * 3, -b * 2, 6));
            // Rounding of d (about 0.3) over the step 0.0005: 1e-4.
            EXPECT_LT(AngleBetween(si.shading.n, expected), 5e-4f);
            EXPECT_EQ(si.n, Vec3(0, 0, 1));
        }
}

TEST_F(Bump, ConstantDisplacementOfAPlaneChangesNothing) {
    SurfaceInteraction si = Plane();
    BareMaterial(MakeParams({Numbers("float", "displacement", {0.5f})}), library).Bump(si);
    EXPECT_EQ(si.shading.n, Vec3(0, 0, 1));
    EXPECT_EQ(si.shading.dpdu, Vec3(2, 0, 0));
}

TEST_F(Bump, TheNormalStaysOnTheGeometricSide) {
    SurfaceInteraction si = Plane();
    si.n = -si.n;
    si.shading.n = -si.shading.n;
    Displace(si, 0.5f, 0);
    EXPECT_LT(si.shading.n.z, 0);
}

TEST_F(Bump, FlatNormalMapChangesNothing) {
    SurfaceInteraction si = Plane();
    MapNormal(si, {0.5f, 0.5f, 1});
    EXPECT_LT(AngleBetween(si.shading.n, {0, 0, 1}), 1e-6f);
    EXPECT_NEAR(Length(si.shading.dpdu - Vec3(2, 0, 0)), 0, 1e-6f);
    EXPECT_NEAR(Length(si.shading.dpdv - Vec3(0, 3, 0)), 0, 1e-6f);
}

TEST_F(Bump, NormalMapTurnsTheFrameAndKeepsLengths) {
    SurfaceInteraction si = Plane();
    const Vec3 n = Normalize(Vec3(0.3f, -0.2f, 1));
    MapNormal(si, 0.5f * n + 0.5f);
    EXPECT_LT(AngleBetween(si.shading.n, n), 1e-5f);
    EXPECT_NEAR(Length(si.shading.dpdu), 2, 1e-5f);
    EXPECT_NEAR(Length(si.shading.dpdv), 3, 1e-5f);
    EXPECT_NEAR(Dot(si.shading.dpdu, si.shading.n), 0, 1e-5f);
}

TEST_F(Bump, DegenerateInputLeavesTheFrame) {
    SurfaceInteraction si = Plane();
    MapNormal(si, {0.5f, 0.5f, 0.5f});  // no direction at all
    EXPECT_EQ(si.shading.n, Vec3(0, 0, 1));
    Displace(si, 1e38f, 1e38f);
    EXPECT_TRUE(IsFinite(si.shading.n));
    SurfaceInteraction collapsed = Plane();
    collapsed.shading.dpdu = Vec3(0);
    MapNormal(collapsed, {0.6f, 0.5f, 0.9f});
    EXPECT_TRUE(IsFinite(collapsed.shading.n));
}

TEST_F(Bump, UnsuitableNormalMapsAreErrors) {
    SurfaceInteraction si = Plane();
    EXPECT_THROW(MapNormal(si, {0.5f, std::nanf(""), 1}), SceneError);
    EXPECT_THROW(BareMaterial(MakeParams({Text("string", "normalmap", "/nowhere/n.png")}), library),
                 FileError);
}

}  // namespace
}  // namespace lacquer::bump_test
