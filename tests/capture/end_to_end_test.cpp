// From photographs of known maps to maps: rendered, bent by a lens, noisy, exposed differently, in eight
// bits.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "capture/card/capture_photographs.h"
#include "capture/card/card_photographs.h"
#include "capture/photograph_scene.h"
#include "capture/svbrdf/made_maps.h"
#include "capture/svbrdf/pixel_fit.h"
#include "capture/svbrdf/scene_export.h"
#include "capture/svbrdf/scratch_folder.h"
#include "capture/svbrdf/views_file.h"

namespace lacquer::capture::end_to_end_test {
namespace {

using test::MadeMaps;
using test::ScratchFolder;

constexpr int kSize = 64;
constexpr int kPhotographs = 5;

/// The directives of the maps as a material, with files by their whole paths.
std::string MaterialOf(const Maps& maps, const ScratchFolder& folder) {
    ExportMaterial(maps, folder.Path(), ExportAs::Svbrdf);
    std::ifstream file(folder.File("material.pbrt"));
    std::stringstream text;
    text << file.rdbuf();
    return std::regex_replace(text.str(), std::regex("\"(\\w+\\.exr)\""), "\"" + folder.Path() + "/$1\"") +
           "NamedMaterial \"captured\"\n";
}

/// Files of photographs: every other one with half of the exposure, which its metadata tell.
std::vector<std::string> Photograph(const lacquer::test::PhotographScene& scene,
                                    const ScratchFolder& folder) {
    const std::string card = lacquer::test::WriteCardTexture(folder.Path(), scene.size);
    Intrinsics bent = scene.Intrinsics();
    bent.k1 = 0.05;
    std::vector<std::string> files;
    for (int i = 0; i < kPhotographs; ++i) {
        const CameraPose pose = test_cards::NinePoses()[size_t(2 * i)];
        Image image = test_cards::Distorted(lacquer::test::RenderPhotograph(scene, pose, card),
                                            scene.Intrinsics(), bent);
        image = test_cards::WithNoise(std::move(image), 0.004, uint64_t(i) + 1);
        const bool isDark = i % 2 == 1;
        for (float& value : image.Pixels()) value *= isDark ? 0.5F : 1.F;
        image.metadata = {{"ExposureTime", isDark ? 0.005F : 0.01F},
                          {"FNumber", 2.F},
                          {"Exif:PhotographicSensitivity", 100},
                          {"Exif:FocalLengthIn35mmFilm", 28}};
        files.push_back(folder.File(fmt::format("{}.jpg", i)));
        WriteImage(image, files.back());
    }
    return files;
}

double RmseOf(const Maps& a, const Maps& b, size_t firstChannel, size_t numChannels) {
    double sum = 0;
    for (size_t c = firstChannel; c < firstChannel + numChannels; ++c)
        for (size_t i = 0; i < a.NumTexels(); ++i) sum += std::pow(a.Channel(c)[i] - b.Channel(c)[i], 2);
    // Stored values run from -1 to 1.
    return std::sqrt(sum / double(numChannels * a.NumTexels())) / 2;
}
/// The same maps with the rows from below, or columns from the right.
Maps Mirrored(const Maps& maps, bool rows) {
    Maps mirrored = maps;
    const size_t n = size_t(maps.size);
    for (size_t c = 0; c < kNumChannels; ++c)
        for (size_t y = 0; y < n; ++y)
            for (size_t x = 0; x < n; ++x)
                mirrored.Channel(c)[y * n + x] =
                    maps.Channel(c)[rows ? (n - 1 - y) * n + x : y * n + n - 1 - x];
    return mirrored;
}

TEST(CaptureFromPhotographs, FindsKnownMaps) {
    const ScratchFolder known, photographs, rectified;
    const Maps truth = MadeMaps(kSize, test::Pattern::Tiles, 3);
    lacquer::test::PhotographScene scene;
    scene.material = MaterialOf(truth, known);
    scene.flash = {1.5, 0.5, 0};
    scene.maxDepth = 1;
    CaptureOptions options;
    options.response = Response::SRGB;
    options.flash = {1.5, 0.5, 0};
    options.resolution = kSize;
    CapturedPhotographs found = CapturePhotographs(Photograph(scene, photographs), options);
    EXPECT_EQ(found.notes.size(), 3u);  // of the brighter exposures
    // All photographs are as dark as the darkest now: so is the light.
    for (double& power : found.views.lightPower) power *= 0.5;
    WriteRectified(found, rectified.Path());
    const auto images = ReadViewImages(found.views, rectified.Path(), kSize);
    const FitResult fit = FitTexels(found.views, images, {}, {});
    ASSERT_EQ(fit.end, FitResult::End::Finished);

    const double novel = test::NovelRmse(fit.maps, truth, found.views);
    const double albedo = RmseOf(fit.maps, truth, kAlbedo, 3), normal = RmseOf(fit.maps, truth, kNormal, 2);
    // Found: 0.028, 0.016, 0.029; the controls 0.114 and 0.125, and 0.169.
    EXPECT_LT(novel, 0.04);
    EXPECT_LT(albedo, 0.03);
    EXPECT_LT(normal, 0.04);
    // Controls: maps the wrong way round, and none.
    for (const bool rows : {false, true})
        EXPECT_GT(test::NovelRmse(Mirrored(fit.maps, rows), truth, found.views), 2 * novel);
    EXPECT_GT(test::NovelRmse(ConstantMaps(kSize), truth, found.views), 3 * novel);
}

}  // namespace
}  // namespace lacquer::capture::end_to_end_test
