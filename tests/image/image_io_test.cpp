#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "pbrt/image/half.h"
#include "pbrt/image/image_cache.h"
#include "support/file_size_limit.h"

namespace lacquer::image_io_test {
namespace {

namespace fs = std::filesystem;

const ColorEncoding kSRGB{ColorEncoding::Kind::SRGB, 1};
const FileLoc kLoc{"scene.pbrt", 7, 3};

/// A fresh folder that is removed afterwards.
class ImageIO : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / (std::string("lacquer-image-io-") +
                                               testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string Path(const std::string& name) const { return (folder_ / name).string(); }
    std::string Write(const std::string& name, const std::string& bytes) const {
        std::ofstream(Path(name), std::ios::binary) << bytes;
        return Path(name);
    }
    static std::string Bytes(const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    size_t NumFiles() const { return size_t(std::distance(fs::directory_iterator(folder_), {})); }
    fs::path folder_;
};

/// Smooth, different in each channel, in [0, top].
Image Gradient(Int2 resolution, std::vector<std::string> channels, float top = 1) {
    Image image(resolution, std::move(channels));
    for (int y = 0; y < resolution.y; ++y)
        for (int x = 0; x < resolution.x; ++x)
            for (int c = 0; c < image.NumChannels(); ++c) {
                const float u = float(x) / float(resolution.x), v = float(y) / float(resolution.y);
                image.Set({x, y}, c, top * (c % 2 ? 0.5f * (u + v) : u * (1 - 0.3f * float(c) * v)));
            }
    return image;
}

/// Largest difference over the channels that `b` has.
float Difference(const Image& a, const Image& b) {
    EXPECT_EQ(a.Resolution(), b.Resolution());
    float difference = 0;
    for (int y = 0; y < a.Resolution().y; ++y)
        for (int x = 0; x < a.Resolution().x; ++x)
            for (int c = 0; c < std::min(a.NumChannels(), b.NumChannels()); ++c)
                difference = std::max(difference, std::abs(a.Get({x, y}, c) - b.Get({x, y}, c)));
    return difference;
}

/// "scene" or "file", and the message, of what reading throws.
std::pair<std::string, std::string> ErrorOf(const std::string& path) {
    try {
        ReadImage(path, kSRGB, kLoc);
    } catch (const SceneError& e) {
        EXPECT_EQ(e.Loc().line, kLoc.line);
        return {"scene", e.Message()};
    } catch (const FileError& e) {
        EXPECT_EQ(e.Loc().line, kLoc.line);
        return {"file", e.Message()};
    }
    return {"none", ""};
}

void ExpectDamaged(const std::string& path, const std::string& text = "") {
    const auto [kind, message] = ErrorOf(path);
    EXPECT_EQ(kind, "scene") << path;
    EXPECT_NE(message.find(path), std::string::npos) << message;
    EXPECT_NE(message.find(text), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST_F(ImageIO, FloatExrIsExact) {
    const Image image = Gradient({31, 17}, {"R", "G", "B"}, 1e5f);
    WriteImage(image, Path("a.exr"));
    const Image back = ReadImage(Path("a.exr"), kSRGB, kLoc);
    EXPECT_EQ(back.Channels(), image.Channels());
    EXPECT_EQ(Difference(image, back), 0);
    EXPECT_EQ(back.format, PixelFormat::Float);
}

TEST_F(ImageIO, HalfExrRoundsToHalvesAndStaysFinite) {
    Image image = Gradient({31, 17}, {"R", "G", "B"}, 100);
    image.Set({3, 3}, 1, 1e9f);
    WriteImage(image, Path("a.exr"), true);
    const Image back = ReadImage(Path("a.exr"), kSRGB, kLoc);
    EXPECT_EQ(back.format, PixelFormat::Half);
    EXPECT_EQ(back.Get({3, 3}, 1), kMaxHalf);
    for (size_t i = 0; i < image.Pixels().size(); ++i)
        EXPECT_EQ(back.Pixels()[i], HalfToFloat(FloatToHalf(std::min(image.Pixels()[i], kMaxHalf))));
}

TEST_F(ImageIO, ManyNamedChannelsSurviveInExr) {
    const Image image = Gradient({9, 5}, {"R", "G", "B", "Albedo.R", "N.X", "u"});
    WriteImage(image, Path("a.exr"));
    const Image back = ReadImage(Path("a.exr"), kSRGB, kLoc);
    ASSERT_EQ(back.NumChannels(), 6);
    EXPECT_TRUE(back.HasRGB());
    for (int c = 0; c < 6; ++c) {
        const int d = back.FindChannel(image.Channels()[size_t(c)]);
        ASSERT_GE(d, 0);
        EXPECT_EQ(back.Get({4, 2}, d), image.Get({4, 2}, c));
    }
}

TEST_F(ImageIO, PngIsWithinHalfAStepPlusDither) {
    const Image image = Gradient({64, 48}, {"R", "G", "B"});
    WriteImage(image, Path("a.png"));
    const Image back = ReadImage(Path("a.png"), kSRGB, kLoc);
    // Rounding and dither together are less than one step of the stored value.
    for (size_t i = 0; i < image.Pixels().size(); ++i)
        EXPECT_LT(std::abs(kSRGB.FromLinear(back.Pixels()[i]) - kSRGB.FromLinear(image.Pixels()[i])),
                  1.0f / 255 + 1e-5f);
    EXPECT_EQ(back.format, PixelFormat::Byte);
}

TEST_F(ImageIO, DitherKeepsTheMeanAndLeavesExactValuesAlone) {
    // 100.3/255 cannot be stored; the mean over 64^2 dithered pixels is nearer to it than rounding (0.3
    // steps) could be.
    Image image({64, 64}, {"Y"});
    const float between = kSRGB.ToLinear(100.3f / 255);
    for (float& v : image.Pixels()) v = between;
    WriteImage(image, Path("a.png"));
    double sum = 0;
    const Image dithered = ReadImage(Path("a.png"), kSRGB, kLoc);
    for (const float v : dithered.Pixels()) sum += double(255 * kSRGB.FromLinear(v));
    EXPECT_NEAR(sum / (64 * 64), 100.3, 0.03);

    for (float& v : image.Pixels()) v = kSRGB.ToLinear(100.f / 255);
    WriteImage(image, Path("b.png"));
    const Image exact = ReadImage(Path("b.png"), kSRGB, kLoc);
    for (const float v : exact.Pixels()) EXPECT_NEAR(255 * kSRGB.FromLinear(v), 100, 1e-3f);
}

TEST_F(ImageIO, PngAlphaIsStoredLinearAndReadByTheColourCurve) {
    Image image({4, 4}, {"R", "G", "B", "A"});
    for (float& v : image.Pixels()) v = 0.5f;
    WriteImage(image, Path("a.png"));
    const Image back = ReadImage(Path("a.png"), kSRGB, kLoc);
    ASSERT_EQ(back.NumChannels(), 4);
    EXPECT_NEAR(back.Get({1, 1}, 3), kSRGB.ToLinear(128.f / 255), 1e-6f);  // 127.5 rounds up
    // Colours are not multiplied by alpha.
    EXPECT_NEAR(back.Get({1, 1}, 0), 0.5f, 0.01f);
}

TEST_F(ImageIO, PngHonoursItsEncodingAndJpegDoesNot) {
    const Image image = Gradient({16, 16}, {"Y"});
    WriteImage(image, Path("a.png"));
    WriteImage(image, Path("a.jpg"));
    const Image srgb = ReadImage(Path("a.png"), kSRGB, kLoc), linear = ReadImage(Path("a.png"), {}, kLoc);
    EXPECT_NEAR(linear.Get({8, 8}, 0), kSRGB.FromLinear(srgb.Get({8, 8}, 0)), 1e-5f);
    EXPECT_EQ(Difference(ReadImage(Path("a.jpg"), kSRGB, kLoc), ReadImage(Path("a.jpg"), {}, kLoc)), 0);
}

TEST_F(ImageIO, EveryWritableExtensionWritesAnImageThatReadsBack) {
    for (const std::string& extension : WritableExtensions())
        for (const auto& channels :
             {std::vector<std::string>{"Y"}, {"R", "G", "B"}, {"R", "G", "B", "A"}, {"Y", "Z"}}) {
            const Image image = Gradient({40, 24}, channels);
            const std::string path = Path("a." + extension);
            EXPECT_TRUE(CanWriteImage(path));
            ASSERT_NO_THROW(WriteImage(image, path)) << extension << " " << channels.size();
            Image back = ReadImage(path, kSRGB, kLoc);
            ASSERT_EQ(back.Resolution(), image.Resolution());
            // Palettes of 256 colours and JPEG's chroma are the coarsest of all. Alpha has its own test.
            for (int c = 0; c < std::min(3, std::min(back.NumChannels(), image.NumChannels())); ++c)
                EXPECT_NEAR(back.Get({20, 12}, c), image.Get({20, 12}, c), 0.08f)
                    << extension << " " << channels.size();
        }
    EXPECT_EQ(NumFiles(), WritableExtensions().size());
}

TEST_F(ImageIO, PfmIsExactWithRowsFromTheBottom) {
    Image image({2, 2}, {"Y"});
    image.Pixels() = {1, 2, 3, 4};
    WriteImage(image, Path("a.pfm"));
    const std::string bytes = Bytes(Path("a.pfm"));
    const float expected[4] = {3, 4, 1, 2};
    EXPECT_EQ(bytes.substr(0, 12), "Pf\n2 2\n-1.0\n");
    EXPECT_EQ(bytes.substr(12), std::string(reinterpret_cast<const char*>(expected), 16));
    EXPECT_EQ(ReadImage(Path("a.pfm"), kSRGB, kLoc).Pixels(), image.Pixels());
}

TEST_F(ImageIO, MetadataIsReadBack) {
    Image image = Gradient({8, 8}, {"R", "G", "B"});
    glm::mat4 m(1.f);
    m[3] = {1, 2, 3, 1};  // a translation
    image.metadata = {{"samplesPerPixel", 64},
                      {"renderTimeSeconds", 1.5f},
                      {"lacquerVersion", std::string("0.1 é")},
                      {"worldToCamera", m},
                      {"someFloats", std::vector<float>{1, 2, 3, 4, 5}}};
    image.SetColorSpace(ColorSpace::Find("rec2020"));
    WriteImage(image, Path("a.exr"));
    const Image back = ReadImage(Path("a.exr"), kSRGB, kLoc);
    for (const auto& [name, value] : image.metadata) {
        ASSERT_TRUE(back.metadata.contains(name)) << name;
        EXPECT_EQ(back.metadata.at(name), value) << name;
    }
    EXPECT_EQ(back.ColorSpace(), ColorSpace::Find("rec2020"));
}

TEST_F(ImageIO, MatricesFollowTheRowVectorConventionOfExr) {
    Image image({1, 1}, {"Y"});
    glm::mat4 m(1.f);
    m[3] = {1, 2, 3, 1};
    image.metadata["worldToCamera"] = m;
    WriteImage(image, Path("a.exr"));
    // The attribute's 64 bytes follow its name, its type and its size; a translation is in the last row.
    const std::string bytes = Bytes(Path("a.exr")), head("worldToCamera\0m44f\0\x40\0\0\0", 23);
    const size_t at = bytes.find(head);
    ASSERT_NE(at, std::string::npos);
    float values[16];
    std::memcpy(values, bytes.data() + at + head.size(), sizeof values);
    EXPECT_EQ(values[12], 1);
    EXPECT_EQ(values[13], 2);
    EXPECT_EQ(values[14], 3);
    EXPECT_EQ(values[3], 0);
}

TEST_F(ImageIO, CropWindowIsReadBack) {
    Image image = Gradient({20, 10}, {"R", "G", "B"});
    image.dataWindow = {Int2(5, 7), Int2(25, 17)};
    image.fullResolution = {64, 48};
    WriteImage(image, Path("a.exr"));
    const Image back = ReadImage(Path("a.exr"), kSRGB, kLoc);
    EXPECT_EQ(back.dataWindow, image.dataWindow);
    EXPECT_EQ(back.fullResolution, image.fullResolution);
    EXPECT_EQ(Difference(image, back), 0);
}

TEST_F(ImageIO, WideGamutColoursAreConvertedForPng) {
    Image image({1, 1}, {"R", "G", "B"});
    image.SetColorSpace(ColorSpace::Find("rec2020"));
    const RGB expected(0.2f, 0.5f, 0.4f);
    const RGB rec2020 = image.ColorSpace()->ToRGB(ColorSpace::SRGB().ToXYZ(expected));
    for (int c = 0; c < 3; ++c) image.Set({0, 0}, c, rec2020[c]);
    WriteImage(image, Path("a.png"));
    const Image back = ReadImage(Path("a.png"), kSRGB, kLoc);
    // One 8-bit step of sRGB is at most 2.3/255 in linear values.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(back.Get({0, 0}, c), expected[c], 0.01f);
}

TEST_F(ImageIO, UnknownExtensionListsThoseThatCanBeWritten) {
    const Image image = Gradient({2, 2}, {"Y"});
    for (const char* name : {"a.xyz", "a", "a."}) {
        EXPECT_FALSE(CanWriteImage(Path(name)));
        try {
            WriteImage(image, Path(name));
            ADD_FAILURE() << name;
        } catch (const FileError& e) {
            EXPECT_NE(e.Message().find("exr"), std::string::npos);
            EXPECT_NE(e.Message().find("png"), std::string::npos);
        }
    }
}

TEST_F(ImageIO, MissingFolderIsAFileError) {
    EXPECT_THROW(WriteImage(Gradient({2, 2}, {"Y"}), Path("nowhere/a.exr")), FileError);
    EXPECT_THROW(WriteImage(Gradient({2, 2}, {"Y"}), "/proc/a.exr"), FileError);
    fs::create_directory(Path("folder.exr"));
    EXPECT_THROW(WriteImage(Gradient({2, 2}, {"Y"}), Path("folder.exr")), FileError);
    EXPECT_EQ(NumFiles(), 1u);
}

TEST_F(ImageIO, FullDiskLeavesTheOldImageAndNoTemporaryFile) {
    for (const std::string extension : {"exr", "png", "pfm", "tif", "hdr", "jpg", "bmp", "tga", "ppm"}) {
        const Image small = Gradient({4, 4}, {"R", "G", "B"});
        WriteImage(small, Path("a." + extension));
        const std::string before = Bytes(Path("a." + extension));
        // Noise that does not compress below the limit on file sizes, which acts like a full disk.
        Image large({256, 256}, {"R", "G", "B"});
        uint32_t state = 1;
        for (float& v : large.Pixels()) v = float((state = state * 1664525 + 1013904223) >> 8) * 0x1p-24f;
        {
            const test::FileSizeLimit limit(8192);
            EXPECT_THROW(WriteImage(large, Path("a." + extension)), FileError) << extension;
        }
        EXPECT_TRUE(Bytes(Path("a." + extension)) == before) << extension;
        fs::remove(Path("a." + extension));
        EXPECT_EQ(NumFiles(), 0u) << extension;
    }
}

TEST_F(ImageIO, UnreadableFilesAreFileErrors) {
    EXPECT_EQ(ErrorOf(Path("missing.png")).first, "file");
    EXPECT_EQ(ErrorOf(folder_.string()).first, "file");
    EXPECT_EQ(ErrorOf("/dev/zero").first, "file");
}

TEST_F(ImageIO, TruncatedFilesAreErrors) {
    for (const std::string& extension : WritableExtensions()) {
        const std::string path = Path("a." + extension);
        WriteImage(Gradient({40, 24}, {"R", "G", "B"}), path);
        const std::string bytes = Bytes(path);
        for (const double part : {0.02, 0.3, 0.6}) {
            Write("a." + extension, bytes.substr(0, size_t(part * double(bytes.size()))));
            ExpectDamaged(path);
        }
    }
}

TEST_F(ImageIO, FilesThatAreNoImagesAreErrors) {
    ExpectDamaged(Write("empty.png", ""), "empty");
    ExpectDamaged(Write("text.png", "Texture \"t\" \"spectrum\" \"imagemap\"\n"), "known kind");
    ExpectDamaged(Write("text.exr", std::string(1000, 'x')), "known kind");
    ExpectDamaged(Write("noise.tga", std::string(1000, '\xff')));
    ExpectDamaged(Write("short.tga", "\x01"));
    ExpectDamaged(Write("magic.exr", std::string("\x76\x2f\x31\x01", 4)));
    ExpectDamaged(Write("magic.png", "\x89PNG\r\n\x1a\n"));
    ExpectDamaged(Write("magic.jpg", "\xff\xd8\xff\xe0"));
    ExpectDamaged(Write("magic.hdr", "#?RADIANCE\n"));
    ExpectDamaged(Write("magic.pfm", "PF\n-3 4\n-1.0\n"));
    ExpectDamaged(Write("magic.bmp", "BM"));
    ExpectDamaged(Write("magic.gif", "GIF89a"));
}

TEST_F(ImageIO, EnormousResolutionsAreRefusedBeforeTheyAreAllocated) {
    WriteImage(Gradient({4, 4}, {"R", "G", "B"}), Path("a.png"));
    std::string png = Bytes(Path("a.png"));
    ASSERT_EQ(png.substr(12, 4), "IHDR");
    for (size_t i = 16; i < 24; ++i) png[i] = i % 4 == 0 ? '\x7f' : '\xff';
    ExpectDamaged(Write("a.png", png), "checksum");
    const uLong checksum = crc32(0, reinterpret_cast<const unsigned char*>(png.data()) + 12, 17);
    for (size_t i = 0; i < 4; ++i) png[29 + i] = char(checksum >> (24 - 8 * i));
    ExpectDamaged(Write("a.png", png));
    // 60000 x 60000 keeps within libpng's own limits.
    for (size_t i = 16; i < 24; i += 4) png.replace(i, 4, std::string("\0\0\xea\x60", 4));
    const uLong second = crc32(0, reinterpret_cast<const unsigned char*>(png.data()) + 12, 17);
    for (size_t i = 0; i < 4; ++i) png[29 + i] = char(second >> (24 - 8 * i));
    ExpectDamaged(Write("b.png", png));
    ExpectDamaged(Write("a.pfm", "PF\n2000000000 2000000000\n-1.0\n"));
    ExpectDamaged(Write("b.pfm", "PF\n60000 60000\n-1.0\n"));
    ExpectDamaged(Write("a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n"));
    std::string tga(18, '\0');
    tga[2] = 2;
    tga[12] = tga[13] = tga[14] = tga[15] = '\xff';
    tga[16] = 24;
    ExpectDamaged(Write("a.tga", tga));
    std::string gif("GIF89a\xff\xff\xff\xff\0\0\0,\0\0\0\0\xff\xff\xff\xff\0", 23);
    ExpectDamaged(Write("a.gif", gif));
}

TEST_F(ImageIO, ExrAttributesLargerThanTheFileAreRefused) {
    Image image = Gradient({4, 4}, {"R", "G", "B"});
    image.metadata["note"] = std::string("hello");
    WriteImage(image, Path("a.exr"));
    std::string bytes = Bytes(Path("a.exr"));
    const size_t at = bytes.find(std::string("note\0string\0\x05", 13));
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at + 12, 4, "\xf0\xff\xff\x7f");
    ExpectDamaged(Write("a.exr", bytes), "larger than the file");
}

TEST_F(ImageIO, CorruptedPixelsAreErrorsOrImagesButNeverCrashes) {
    for (const std::string& extension : WritableExtensions()) {
        const std::string path = Path("a." + extension);
        WriteImage(Gradient({24, 16}, {"R", "G", "B"}), path);
        const std::string bytes = Bytes(path);
        uint32_t state = 12345;
        for (int i = 0; i < 40; ++i) {
            std::string broken = bytes;
            for (int k = 0; k < 3; ++k) {
                state = state * 1664525 + 1013904223;
                broken[(state >> 4) % broken.size()] = char(state >> 24);
            }
            Write("a." + extension, broken);
            const auto [kind, message] = ErrorOf(path);
            EXPECT_NE(kind, "file") << message;
        }
    }
}

TEST_F(ImageIO, CacheReadsEachFileOnceForEachEncoding) {
    WriteImage(Gradient({4, 4}, {"R", "G", "B"}), Path("a.png"));
    ImageCache cache;
    const auto first = cache.Get(Path("a.png"), kSRGB, kLoc);
    EXPECT_EQ(cache.Get(Path("a.png"), kSRGB, kLoc), first);
    EXPECT_NE(cache.Get(Path("a.png"), {}, kLoc), first);
    const auto map = cache.GetMipMap({Path("a.png"), kSRGB, WrapMode::Repeat}, kLoc);
    EXPECT_EQ(cache.GetMipMap({Path("a.png"), kSRGB, WrapMode::Repeat}, kLoc), map);
    EXPECT_NE(cache.GetMipMap({Path("a.png"), kSRGB, WrapMode::Clamp}, kLoc), map);
    EXPECT_THROW(cache.Get(Path("b.png"), kSRGB, kLoc), FileError);
    WriteImage(Gradient({4, 4}, {"R", "G", "B"}), Path("b.png"));
    EXPECT_NE(cache.Get(Path("b.png"), kSRGB, kLoc), nullptr);
}

}  // namespace
}  // namespace lacquer::image_io_test
