#include <filesystem>

#include "textures/texture_fixture.h"

namespace lacquer::imagemap_test {
namespace {

using namespace testing_support;

/// Writes a 4 x 2 EXR with R = column / 4, G = row / 2, B = 0.25.
class ImageMap : public Textures {
  protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() /
                  (std::string("lacquer-imagemap-") +
                   testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::create_directories(folder_);
        Image image({4, 2}, {"R", "G", "B"});
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 4; ++x) {
                image.Set({x, y}, 0, float(x) / 4);
                image.Set({x, y}, 1, float(y) / 2);
                image.Set({x, y}, 2, 0.25f);
            }
        path_ = (folder_ / "a.exr").string();
        WriteImage(image, path_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    std::vector<Parameter> With(std::vector<Parameter> parameters) const {
        parameters.push_back(Text("string", "filename", path_));
        return parameters;
    }
    /// (u, v) of a pixel's centre: v = 0 is the bottom of the image.
    static TextureContext Pixel(int x, int y) { return At((float(x) + 0.5f) / 4, 1 - (float(y) + 0.5f) / 2); }

    std::filesystem::path folder_;
    std::string path_;
};

TEST_F(ImageMap, RowsGoDownWhereVGoesUp) {
    const SpectrumTexture* texture = MakeSpectrum("imagemap", With({}));
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 4; ++x) {
            const SampledSpectrum expected = SampleRGB(
                ColorSpace::SRGB(), {float(x) / 4, float(y) / 2, 0.25f}, SpectrumKind::Albedo, lambda);
            for (int i = 0; i < kNumWavelengths; ++i)
                EXPECT_NEAR(texture->Evaluate(Pixel(x, y), lambda)[i], expected[i], 1e-4f);
        }
}

TEST_F(ImageMap, FloatsAreMeansOrRed) {
    EXPECT_NEAR(MakeFloat("imagemap", With({}))->Evaluate(Pixel(2, 1)), (0.5f + 0.5f + 0.25f) / 3, 1e-6f);
    EXPECT_NEAR(MakeFloat("imagemap", With({Text("string", "filter", "point")}))->Evaluate(Pixel(2, 1)), 0.5f,
                1e-6f);
}

TEST_F(ImageMap, ScaleIsInsideOfTheInversion) {
    const FloatTexture* texture = MakeFloat(
        "imagemap",
        With({Flag("invert", true), Numbers("float", "scale", {0.7f}), Text("string", "filter", "point")}));
    EXPECT_NEAR(texture->Evaluate(Pixel(3, 0)), 1 - 0.7f * 0.75f, 1e-6f);
    // A constant scale texture around it is folded in, from either side.
    library.floats["i"] = texture;
    library.floats["two"] = MakeFloat("constant", {Numbers("float", "value", {0.5f})});
    for (const auto& parameters :
         {std::vector<Parameter>{Text("texture", "tex", "i"), Numbers("float", "scale", {0.5f})},
          {Text("texture", "scale", "i"), Text("texture", "tex", "two")}})
        EXPECT_NEAR(MakeFloat("scale", parameters)->Evaluate(Pixel(3, 0)), 1 - 0.35f * 0.75f, 1e-6f);
    // A scale that is not constant is not.
    library.floats["f"] =
        MakeFloat("bilerp", {Numbers("float", "v00", {0.5f}), Numbers("float", "v01", {0.5f}),
                             Numbers("float", "v10", {0.5f}), Numbers("float", "v11", {0.5f})});
    EXPECT_NEAR(MakeFloat("scale", {Text("texture", "tex", "i"), Text("texture", "scale", "f")})
                    ->Evaluate(Pixel(3, 0)),
                0.5f * (1 - 0.7f * 0.75f), 1e-6f);
    EXPECT_NEAR(MakeFloat("imagemap", With({Flag("invert", true), Numbers("float", "scale", {9})}))
                    ->Evaluate(Pixel(3, 1)),
                0, 0);
}

TEST_F(ImageMap, KindsDecideTheSpectrum) {
    for (const SpectrumKind kind :
         {SpectrumKind::Albedo, SpectrumKind::Unbounded, SpectrumKind::Illuminant}) {
        const SampledSpectrum actual = MakeSpectrum("imagemap", With({Numbers("float", "scale", {4})}), kind)
                                           ->Evaluate(Pixel(2, 1), lambda);
        const SampledSpectrum expected = SampleRGB(ColorSpace::SRGB(), {2, 2, 1}, kind, lambda);
        for (int i = 0; i < kNumWavelengths; ++i)
            EXPECT_NEAR(actual[i], expected[i], 1e-3f * std::max(1.f, expected[i]));
    }
}

TEST_F(ImageMap, WrapModesReachTheLookup) {
    TextureContext outside = Pixel(5, 1);  // one period minus three pixels to the right
    EXPECT_NEAR(MakeFloat("imagemap", With({Text("string", "filter", "point")}))->Evaluate(outside), 0.25f,
                1e-6f);
    EXPECT_NEAR(
        MakeFloat("imagemap", With({Text("string", "filter", "point"), Text("string", "wrap", "clamp")}))
            ->Evaluate(outside),
        0.75f, 1e-6f);
    EXPECT_EQ(
        MakeFloat("imagemap", With({Text("string", "filter", "point"), Text("string", "wrap", "black")}))
            ->Evaluate(outside),
        0);
}

TEST_F(ImageMap, EwaFollowsDiagonalFootprintsInTheImagesFrame) {
    // Anti-diagonal stripes in the image: u + v is constant along them only if the flip of v reaches the
    // footprint.
    Image image({64, 64}, {"Y"});
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) image.Set({x, y}, 0, (x + 63 - y) / 4 % 2 ? 1.f : 0.f);
    path_ = (folder_ / "stripes.exr").string();
    WriteImage(image, path_);
    const FloatTexture* texture = MakeFloat(
        "imagemap", With({Text("string", "filter", "ewa"), Numbers("float", "maxanisotropy", {32})}));
    const auto contrast = [&](float sign) {
        float low = 1, high = 0;
        for (int i = 0; i < 16; ++i) {
            TextureContext context = At(0.5f + float(i) / 128, 0.5f + float(i) / 128);
            context.dudx = 0.1f;
            context.dvdx = sign * 0.1f;
            context.dudy = 0.004f;
            context.dvdy = -sign * 0.004f;
            const float value = texture->Evaluate(context);
            low = std::min(low, value);
            high = std::max(high, value);
        }
        return high - low;
    };
    EXPECT_GT(contrast(-1), 0.6f);  // along the stripes
    EXPECT_LT(contrast(1), 0.2f);   // across
}

TEST_F(ImageMap, HugeAnisotropyIsLimited) {
    const FloatTexture* texture = MakeFloat(
        "imagemap", With({Text("string", "filter", "ewa"), Numbers("float", "maxanisotropy", {3e38f})}));
    TextureContext context = Pixel(1, 1);
    context.dudx = 1e10f;
    context.dvdy = 1e-10f;
    EXPECT_TRUE(std::isfinite(texture->Evaluate(context)));
}

TEST_F(ImageMap, BadParametersAreErrors) {
    EXPECT_THROW(MakeFloat("imagemap", {}), SceneError);
    EXPECT_THROW(MakeFloat("imagemap", {Text("string", "filename", (folder_ / "none.png").string())}),
                 FileError);
    EXPECT_THROW(MakeFloat("imagemap", With({Text("string", "filter", "cubic")})), SceneError);
    EXPECT_THROW(MakeFloat("imagemap", With({Text("string", "wrap", "mirror")})), SceneError);
    EXPECT_THROW(MakeFloat("imagemap", With({Text("string", "encoding", "gamma 0")})), SceneError);
    EXPECT_THROW(MakeFloat("imagemap", With({Numbers("float", "maxanisotropy", {0.5f})})), SceneError);
    EXPECT_THROW(MakeFloat("imagemap", With({Numbers("float", "maxanisotropy", {std::nanf("")})})),
                 SceneError);
    EXPECT_THROW(MakeFloat("imagemap", With({Numbers("float", "scale", {Infinity})})), SceneError);
}

}  // namespace
}  // namespace lacquer::imagemap_test
