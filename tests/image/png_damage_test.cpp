#include "pbrt/image/png_damage.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "image/png_bytes.h"
#include "pbrt/core/rng.h"
#include "pbrt/image/image.h"

namespace lacquer::png_damage_test {
namespace {

using namespace png_bytes;

class PngDamage : public testing::Test {
  protected:
    void SetUp() override {
        path_ = testing::TempDir() + "lacquer_png_damage_" +
                testing::UnitTest::GetInstance()->current_test_info()->name() + ".png";
    }
    void TearDown() override { std::filesystem::remove(path_); }
    /// The damage that is found in a file of these bytes.
    std::string Of(const std::string& bytes) const {
        std::ofstream(path_, std::ios::binary) << bytes;
        const std::string damage = PngChunkDamage(path_);
        return damage.empty() ? PngPixelDamage(path_) : damage;
    }
    std::string path_;
};

// One byte less is too short, so the number of bytes that the check expects is exact.
TEST_F(PngDamage, AllKindsOfSoundFilesPassAndShorterOnesDoNot) {
    struct Kind {
        char bits, type;
        int bitsPerPixel;
    };
    for (const Kind& kind : {Kind{1, 0, 1}, Kind{4, 0, 4}, Kind{16, 0, 16}, Kind{8, 2, 24}, Kind{16, 2, 48},
                             Kind{1, 3, 1}, Kind{2, 3, 2}, Kind{8, 3, 8}, Kind{8, 4, 16}, Kind{16, 6, 64}})
        for (const uint32_t width : {1u, 3u, 9u, 20u})
            for (const uint32_t height : {1u, 4u, 11u})
                for (const char interlace : {'\0', '\1'}) {
                    Png png{width, height, kind.bits, kind.type};
                    png.interlace = interlace;
                    if (kind.type == 3) png.palette = std::string(6, 'x');
                    png.rows.assign(NumRowBytes(width, height, kind.bitsPerPixel, interlace), '\0');
                    EXPECT_EQ(Of(png.File()), "") << width << " x " << height << ", type " << int(kind.type);
                    EXPECT_NO_THROW(ReadImage(path_, {}, {}));
                    png.rows.pop_back();
                    EXPECT_EQ(Of(png.File()), "the PNG data end too early");
                }
}

TEST_F(PngDamage, PixelsMayBeInSeveralChunks) {
    Png png;
    png.rows = std::string(30, '\0');
    const std::string zipped = Zipped(png.rows);
    std::string pixels = Chunk("IDAT", "");
    for (const char c : zipped) pixels += Chunk("IDAT", {c});
    EXPECT_EQ(Of(png.File(pixels)), "");
    EXPECT_EQ(Of(png.File(Chunk("IDAT", zipped.substr(0, 5)) + Chunk("teXt", "") +
                          Chunk("IDAT", zipped.substr(5)))),
              "the PNG data end too early");
}

TEST_F(PngDamage, IsNamed) {
    Png png;
    png.rows = std::string(30, '\0');
    const std::string pixels = Chunk("IDAT", Zipped(png.rows));
    const auto with = [&](auto field, auto value) {
        Png other = png;
        other.*field = value;
        return Of(other.File());
    };
    EXPECT_EQ(with(&Png::width, 0u), "the PNG header claims 0 x 3 pixels");
    EXPECT_EQ(with(&Png::height, 0x80000000u), "the PNG header claims 3 x 2147483648 pixels");
    EXPECT_EQ(with(&Png::bits, '\4'), "the PNG header claims 4 bits in colour type 2, which does not exist");
    EXPECT_EQ(with(&Png::type, '\1'), "the PNG header claims 8 bits in colour type 1, which does not exist");
    for (const auto field : {&Png::compression, &Png::filter, &Png::interlace})
        EXPECT_NE(with(field, '\2').find("that does not exist"), std::string::npos);
    EXPECT_EQ(with(&Png::type, '\3'), "the PNG palette is missing");
    EXPECT_EQ(with(&Png::palette, "1234"), "the PNG palette has 4 bytes");
    EXPECT_EQ(with(&Png::palette, std::string(771, 'x')), "the PNG palette has 771 bytes");
    EXPECT_EQ(with(&Png::rows, std::string(30, '\5')), "a row of the PNG file has an unknown filter");
    EXPECT_EQ(with(&Png::rows, std::string(31, '\0')), "");
    EXPECT_EQ(with(&Png::rows, std::string(200000, '\0')), "the PNG data go on after the last row");
    const std::string zipped = Zipped(png.rows);
    EXPECT_EQ(Of(png.File(Chunk("IDAT", zipped.substr(0, zipped.size() - 1)))), "the PNG data end too early");
    EXPECT_EQ(Of(png.File("")), "the PNG file has no pixels");
    EXPECT_EQ(Of(png.File(png.Header() + pixels)), "a second PNG header");
    EXPECT_EQ(Of(png.File(Chunk("ABCD", "") + pixels)), "a PNG chunk that no specification knows");
    EXPECT_EQ(Of(png.File(Chunk("a\1cd", "") + pixels)), "a PNG chunk has an impossible name");
    EXPECT_EQ(Of(png.File(Chunk("zTXt", std::string(8000001, 'x')) + pixels)), "a PNG chunk is too large");
    EXPECT_EQ(Of(png.File(Chunk("IDAT", "\x78\x9cnonsense"))), "the compressed PNG data make no sense");
    std::string wrong = png.File();
    wrong[50] = char(wrong[50] ^ 1);
    EXPECT_EQ(Of(wrong), "a PNG chunk has a wrong checksum");
    EXPECT_EQ(Of(png.File().substr(0, 60)), "the PNG data end too early");
    EXPECT_EQ(Of(png.File().substr(0, 8) + pixels), "the PNG header is not the first chunk");
}

// Random damage under valid checksums: whatever libpng would complain about must be found before it is asked,
// as it prints its complaints.
TEST_F(PngDamage, IsFoundBeforeLibpngPrintsIt) {
    Png png{9, 7, 4, 3};
    png.interlace = 1;
    png.palette = std::string(24, 'p');
    png.rows = std::string(NumRowBytes(9, 7, 4, true), '\1');
    const std::string pixels = Zipped(png.rows);
    Rng rng(1);
    int numDamaged = 0;
    testing::internal::CaptureStderr();
    for (int i = 0; i < 2000; ++i) {
        std::string parts[4] = {png.Header().substr(8, 13), png.palette, pixels, Zipped("iccp")};
        std::string& part = parts[rng.UniformInt(3)];
        const size_t at = rng.UniformInt(uint32_t(part.size()));
        part[at] = char(part[at] ^ (1 << (rng.UniformInt(8))));
        if (rng.UniformInt(8) == 0) part.resize(at);
        std::ofstream(path_, std::ios::binary) << "\x89PNG\r\n\x1a\n" + Chunk("IHDR", parts[0]) +
                                                      Chunk("PLTE", parts[1]) + Chunk("tRNS", parts[3]) +
                                                      Chunk("IDAT", parts[2]) + Chunk("IEND", "");
        try {
            ReadImage(path_, {}, {});
        } catch (const SceneError&) {
            ++numDamaged;
        }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_GT(numDamaged, 1000);
    EXPECT_LT(numDamaged, 2000);
}

}  // namespace
}  // namespace lacquer::png_damage_test
