// What Lacquer renders of exported maps, against the model that they were fitted by.
#include "capture/svbrdf/scene_export.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "capture/svbrdf/made_maps.h"
#include "capture/svbrdf/pixel_fit.h"
#include "capture/svbrdf/scratch_folder.h"
#include "capture/svbrdf/svbrdf_model.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"

namespace lacquer::capture::scene_export_test {
namespace {

using test::ScratchFolder;

constexpr int kSize = 32;

RectifiedImage Rendered(const std::string& scene, const std::string& directory) {
    const RenderSetup setup = BuildScene(ParseText(scene, "view.pbrt", directory, nullptr), {}, nullptr);
    RenderOptions options;
    options.endSample = setup.sampler->SamplesPerPixel();
    Observer nobody;
    Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, nobody);
    const Image image = *setup.film->Develop();
    RectifiedImage result(image.Resolution().x);
    size_t i = 0;
    for (int y = 0; y < result.size; ++y)
        for (int x = 0; x < result.size; ++x, ++i)
            for (size_t c = 0; c < 3; ++c)
                result.Channel(c)[i] = EncodedOf(double(image.Get({x, y}, int(c))));
    return result;
}

/// Root mean square over views of the difference of renders from the model.
double RenderRmse(const Maps& maps, const ViewSet& views, ExportAs as, int samples) {
    const ScratchFolder folder;
    ExportMaterial(maps, folder.Path(), as);
    double sum = 0;
    for (const View& view : views.views) {
        const double rmse =
            Rmse(Rendered(ViewScene(views, view, maps.size, "view.exr", samples), folder.Path()),
                 RenderView(maps, views, view));
        sum += rmse * rmse;
    }
    return std::sqrt(sum / double(views.views.size()));
}

/// One with the light at the camera, one with it aside.
ViewSet TwoViews() {
    ViewSet views = test::GridViews(1);
    views.views[0].camera = views.views[0].light = {2.5, -1, 16};
    views.views.push_back({"", {0, 0.5, 16}, {-6, 6, 10}, false});
    return views;
}

TEST(SceneExport, SvbrdfIsTheModel) {
    for (const test::Pattern pattern : {test::Pattern::Patches, test::Pattern::Tiles, test::Pattern::Waves})
        EXPECT_LT(RenderRmse(test::MadeMaps(kSize, pattern, 2), TwoViews(), ExportAs::Svbrdf, 64), 0.004);
}

// The choice at each hit leaves noise of up to 1/sqrt(2048), half of that in encoded values: 0.01.
TEST(SceneExport, AMixtureIsNearlyTheModel) {
    EXPECT_LT(RenderRmse(test::MadeMaps(16, test::Pattern::Tiles, 2), TwoViews(), ExportAs::Mix, 2048),
              0.012);
}

TEST(SceneExport, WrongMapsShow) {
    const Maps maps = test::MadeMaps(kSize, test::Pattern::Tiles, 2);
    const ViewSet views = TwoViews();
    const ScratchFolder folder;
    ExportMaterial(maps, folder.Path(), ExportAs::Svbrdf);
    const RectifiedImage render =
        Rendered(ViewScene(views, views.views[0], kSize, "view.exr", 64), folder.Path());
    for (const size_t changed : {size_t(kAlbedo), size_t(kNormal), size_t(kNormal + 1), size_t(kRoughness)}) {
        Maps other = maps;
        for (double& value : other.Channel(changed)) value += 0.03;
        EXPECT_GT(Rmse(render, RenderView(other, views, views.views[0])), 0.004) << changed;
    }
    View swapped = views.views[0];
    std::swap(swapped.camera[0], swapped.camera[1]);
    EXPECT_GT(Rmse(render, RenderView(maps, views, swapped)), 0.01);
}

TEST(SceneExport, MixturesChooseTheirAmount) {
    const ScratchFolder folder;
    const auto report = [&](double albedo, double specular) {
        return ExportMaterial(ConstantMaps(8, {.albedo = albedo, .specular = specular}), folder.Path(),
                              ExportAs::Mix);
    };
    EXPECT_DOUBLE_EQ(report(0.3, 0.04).mixAmount, 0.5);
    const ExportReport metal = report(0.01, 0.8), paper = report(0.8, 0.04);
    EXPECT_NEAR(metal.mixAmount, 0.8, 1e-9);
    EXPECT_NEAR(paper.mixAmount, 1 - 0.8 * 0.96, 1e-9);
    // One reflects a half, the other nearly all of the rest, in another channel.
    Maps both = ConstantMaps(8, {.albedo = 0, .specular = 0.8});
    for (double& value : both.Channel(kSpecular)) value = StoredOf(0.02);
    for (double& value : both.Channel(kAlbedo)) value = StoredOf(0.9);
    const ExportReport clipped = ExportMaterial(both, folder.Path(), ExportAs::Mix);
    EXPECT_GT(clipped.clippedShare, 0.1);
    ASSERT_EQ(clipped.warnings.size(), 1U);
    EXPECT_NE(clipped.warnings[0].find("% of the values of the mixture are cut off at 1"), std::string::npos);
}

TEST(SceneExport, ACoatHasTheIndexOfItsReflectance) {
    const ScratchFolder folder;
    const ExportReport report = ExportMaterial(ConstantMaps(8), folder.Path(), ExportAs::Coated);
    EXPECT_NEAR(report.coatIndex, 1.5, 1e-3);
    EXPECT_TRUE(report.warnings.empty());
    // It shows what the sample shows, but for the roughness of the coat, and the noise of its light.
    ViewSet views = test::GridViews(1);
    const RectifiedImage image = Rendered(ViewScene(views, views.views[0], 8, "view.exr", 64), folder.Path());
    EXPECT_LT(Rmse(image, RenderView(ConstantMaps(8), views, views.views[0])), 0.03);
    const ExportReport metal =
        ExportMaterial(ConstantMaps(8, {.specular = 0.6}), folder.Path(), ExportAs::Coated);
    ASSERT_EQ(metal.warnings.size(), 1U);
    EXPECT_NE(metal.warnings[0].find("median 0.600"), std::string::npos);
}

TEST(SceneExport, TurntablesAreScenes) {
    const ScratchFolder folder;
    ExportMaterial(test::MadeMaps(16, test::Pattern::Waves, 3), folder.Path(), ExportAs::Svbrdf);
    ExportTurntable(6.848, folder.Path(), 3);
    for (const char* name : {"turntable.pbrt", "turntable.0001.pbrt", "turntable.0003.pbrt"}) {
        BuildOptions options;
        options.film.resolution = Int2(24, 18);
        options.samplesPerPixel = 1;
        const RenderSetup setup = BuildScene(ParseFile(folder.File(name), nullptr), options, nullptr);
        RenderOptions render;
        render.endSample = 1;
        Observer nobody;
        Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, render, nobody);
        const Image image = *setup.film->Develop();
        double mean = 0;
        for (const float value : image.Pixels()) mean += double(value) / double(image.Pixels().size());
        EXPECT_GT(mean, 0.05) << name;
        EXPECT_LT(mean, 1) << name;
    }
    EXPECT_THROW(ExportTurntable(6.848, "/nowhere"), FileError);
}

}  // namespace
}  // namespace lacquer::capture::scene_export_test
