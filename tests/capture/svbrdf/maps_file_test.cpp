// Maps to files and back.
#include "capture/svbrdf/maps_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/svbrdf/made_maps.h"
#include "capture/svbrdf/pixel_fit.h"
#include "capture/svbrdf/scratch_folder.h"
#include "capture/svbrdf/svbrdf_model.h"
#include "pbrt/core/error.h"
#include "pbrt/image/image.h"

namespace lacquer::capture::maps_file_test {
namespace {

using test::ScratchFolder;

double Largest(const Maps& a, const Maps& b, size_t first, size_t count) {
    double largest = 0;
    for (size_t c = first; c < first + count; ++c)
        for (size_t i = 0; i < a.NumTexels(); ++i)
            largest = std::max(largest, std::abs(a.Channel(c)[i] - b.Channel(c)[i]));
    return largest;
}

// Floats have 24 bits; what is stored has the slope 2/2.2 x^(-1.2) against linear values, of which none is
// below 1e-3 but for the roughness, which goes through the power 4.4.
TEST(MapsFile, LinearFilesRoundTrip) {
    const ScratchFolder folder;
    const Maps maps = test::MadeMaps(24, test::Pattern::Tiles, 2);
    WriteLinearMaps(maps, folder.Path());
    const Maps again = ReadLinearMaps(folder.Path());
    ASSERT_EQ(again.size, 24);
    EXPECT_LT(Largest(maps, again, 0, kNumChannels), 2e-6);
}

TEST(MapsFile, LinearFilesAreReadyToUse) {
    const ScratchFolder folder;
    Maps maps(2);
    for (double& value : maps.Channel(kAlbedo)) value = StoredOf(0.3);
    for (double& value : maps.Channel(kRoughness)) value = StoredOf(0.4);
    for (double& value : maps.Channel(kNormal)) value = 0.6;
    WriteLinearMaps(maps, folder.Path());
    const auto at = [&](const char* name, int channel) {
        return double(ReadImage(folder.File(name), {}, {}).Get({1, 1}, channel));
    };
    EXPECT_NEAR(at("albedo.exr", 0), 0.3, 1e-6);
    EXPECT_NEAR(at("alpha.exr", 0), 0.16, 1e-6);
    EXPECT_NEAR(at("normal.exr", 0), 0.8, 1e-6);
    EXPECT_NEAR(at("normal.exr", 1), 0.5, 1e-6);
    EXPECT_NEAR(at("normal.exr", 2), 0.9, 1e-6);
    EXPECT_EQ(ReadImage(folder.File("alpha.exr"), {}, {}).NumChannels(), 1);
}

// Bytes are cut off: a stored value, of twice the range, is lower by up to 2/255, and never higher.
TEST(MapsFile, EncodedFilesAreCutOff) {
    const ScratchFolder folder;
    const Maps maps = test::RandomMaps(40, 7);
    WriteEncodedMaps(maps, folder.Path());
    const Maps again = ReadEncodedMaps(folder.Path());
    ASSERT_EQ(again.size, 40);
    for (size_t c = 0; c < kNumChannels; ++c)
        for (size_t i = 0; i < maps.NumTexels() && c != kNormal && c != kNormal + 1; ++i) {
            const double byte = std::floor(255 * (0.5 * maps.Channel(c)[i] + 0.5));
            ASSERT_NEAR(255 * (0.5 * again.Channel(c)[i] + 0.5), byte, 1e-4);
        }
    EXPECT_LT(Largest(maps, again, kNormal, 2), 0.02);
    // Their own bytes come back as they are.
    WriteEncodedMaps(again, folder.Path());
    EXPECT_LT(Largest(ReadEncodedMaps(folder.Path()), again, kNormal, 2), 0.02);
}

TEST(MapsFile, AllBytesSurvive) {
    const ScratchFolder folder;
    Maps maps(16);
    for (size_t i = 0; i < 256; ++i) maps.Channel(kRoughness)[i] = 2 * (double(i) + 0.5) / 255 - 1;
    WriteEncodedMaps(maps, folder.Path());
    const Maps again = ReadEncodedMaps(folder.Path());
    for (size_t i = 0; i < 256; ++i)
        EXPECT_NEAR(127.5 * (again.Channel(kRoughness)[i] + 1), double(std::min<size_t>(i, 255)), 1e-4);
}

TEST(MapsFile, WrongFilesHaveTheirMessages) {
    const ScratchFolder folder;
    const auto error = [&] {
        try {
            ReadLinearMaps(folder.Path());
        } catch (const SceneError& e) {
            return e.Message();
        }
        return std::string();
    };
    const Maps maps = ConstantMaps(8);
    WriteLinearMaps(maps, folder.Path());
    EXPECT_EQ(error(), "");
    WriteImage(Image({8, 7}, {"R", "G", "B"}), folder.File("normal.exr"));
    EXPECT_EQ(error(), "the map has 8 x 7 texels; expected a square");
    WriteImage(Image({4, 4}, {"R", "G", "B"}), folder.File("normal.exr"));
    EXPECT_EQ(error(), "the map has 4 x 4 texels; expected 8 x 8, as the albedo has");
    WriteImage(Image({8, 8}, {"Y"}), folder.File("normal.exr"));
    EXPECT_EQ(error(), "the map has other channels; expected R, G and B");
    Image bright({8, 8}, {"R", "G", "B"});
    bright.Set({5, 2}, 1, 1.5F);
    WriteImage(bright, folder.File("normal.exr"));
    EXPECT_EQ(error(), "texel 5,2 has the value 1.5; expected one in [0, 1]");
    EXPECT_THROW(ReadLinearMaps("/nowhere"), FileError);
    EXPECT_THROW(WriteLinearMaps(maps, "/nowhere"), FileError);
    EXPECT_THROW(WriteEncodedMaps(maps, "/nowhere"), FileError);
}

}  // namespace
}  // namespace lacquer::capture::maps_file_test
