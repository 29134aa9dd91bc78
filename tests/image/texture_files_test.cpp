#include "pbrt/image/texture_files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <bit>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "pbrt/core/file_bytes.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/progress.h"
#include "pbrt/core/rng.h"
#include "pbrt/image/image_cache.h"
#include "support/file_size_limit.h"
#include "support/statistics.h"

namespace lacquer::texture_files_test {
namespace {

namespace fs = std::filesystem;
using namespace test;

/// Counts what library code tells.
class Listener : public Observer {
  public:
    void Begin(const std::string& name, int64_t, const std::string&) override { begun.push_back(name); }
    void Warn(const std::string& message) override { warnings.push_back(message); }
    std::vector<std::string> begun, warnings;
};

class TextureFilesTest : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::path(testing::TempDir()) / FullTestName();
        fs::remove_all(folder_);
        fs::create_directories(folder_ / "tmp");
    }
    void TearDown() override { fs::remove_all(folder_); }

    /// Memory for no array at all: everything is read from tiles.
    TextureMemory OnDisk() const { return {4, (folder_ / "cache").string(), (folder_ / "tmp").string()}; }
    std::string Path(const std::string& name) const { return (folder_ / name).string(); }

    /// Random values in [0, 1), some of them with an alpha of 1.
    static Image Random(Int2 resolution, std::vector<std::string> channels) {
        Image image(resolution, std::move(channels));
        Rng rng(SeedOf(FullTestName()));
        for (float& v : image.Pixels()) v = rng.Uniform();
        return image;
    }

    static size_t FilesIn(const fs::path& folder) {
        if (!fs::exists(folder)) return 0;
        return size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }

    /// Fails unless both pyramids give the same bits: all texels, and all filters at random footprints.
    static void ExpectSame(const MipMap& a, const MipMap& b, const std::string& what) {
        ASSERT_EQ(a.NumLevels(), b.NumLevels()) << what;
        ASSERT_EQ(a.NumChannels(), b.NumChannels()) << what;
        EXPECT_EQ(&a.ColorSpace(), &b.ColorSpace()) << what;
        for (int level = 0; level < a.NumLevels(); ++level) {
            ASSERT_EQ(a.Resolution(level), b.Resolution(level)) << what;
            for (int y = 0; y < a.Resolution(level).y; ++y)
                for (int x = 0; x < a.Resolution(level).x; ++x)
                    for (int c = 0; c < a.NumChannels(); ++c)
                        ASSERT_EQ(a.Texel(level, {x, y}, c), b.Texel(level, {x, y}, c))
                            << what << " level " << level << " at " << x << ", " << y;
        }
        Rng rng(SeedOf(FullTestName() + what));
        for (int i = 0; i < 400; ++i) {
            TextureFootprint f;
            f.st = (i % 8 == 0 ? 3000.f : 3.f) * rng.Uniform2D() - Vec2(1);
            const float scale = std::exp2(-9 * rng.Uniform());
            f.dstdx = scale * (rng.Uniform2D() - Vec2(0.5f));
            f.dstdy = scale * (rng.Uniform2D() - Vec2(0.5f));
            for (const TextureFilter filter : {TextureFilter::Point, TextureFilter::Bilinear,
                                               TextureFilter::Trilinear, TextureFilter::EWA}) {
                ASSERT_EQ(a.FilterRGB(f, filter, 8), b.FilterRGB(f, filter, 8)) << what;
                ASSERT_EQ(a.FilterFloat(f, filter, 8), b.FilterFloat(f, filter, 8)) << what;
            }
        }
    }

    fs::path folder_;
    Listener listener_;
};

constexpr ColorEncoding kSRGB{ColorEncoding::Kind::SRGB, 1};

TEST_F(TextureFilesTest, TilesGiveTheBitsOfArrays) {
    struct Case {
        Int2 resolution;
        std::vector<std::string> channels;
        const char* extension;
        bool half;
    };
    // Below and above one tile, powers of two and not, all formats of texels.
    const Case cases[] = {
        {{128, 64}, {"R", "G", "B"}, "png", false},
        {{100, 150}, {"R", "G", "B", "A"}, "png", false},
        {{70, 200}, {"Y"}, "png", false},
        {{130, 67}, {"R", "G", "B"}, "exr", true},
        {{90, 40}, {"R", "G", "B", "A"}, "exr", false},
        {{3, 2}, {"R", "G", "B"}, "png", false},
        {{1, 65}, {"R", "G", "B"}, "exr", false},
        {{96, 96}, {"R", "G", "B"}, "jpg", false},
    };
    for (const Case& c : cases)
        for (const WrapMode wrap :
             {WrapMode::Repeat, WrapMode::Clamp, WrapMode::Black, WrapMode::OctahedralSphere}) {
            const std::string path = Path(std::string("image.") + c.extension);
            WriteImage(Random(c.resolution, c.channels), path, c.half);
            TextureFiles inMemory({}, nullptr), onDisk(OnDisk(), &listener_);
            const MipMap array = inMemory.Load({path, kSRGB, wrap}, {}),
                         tiled = onDisk.Load({path, kSRGB, wrap}, {});
            EXPECT_GT(array.Bytes(), 0u);
            EXPECT_EQ(tiled.Bytes(), 0u);
            ExpectSame(array, tiled,
                       fmt::format("{} x {} {} channels {} {}", c.resolution.x, c.resolution.y,
                                   c.channels.size(), c.extension, int(wrap)));
            EXPECT_FALSE(onDisk.Tiles().HasFailed()) << onDisk.Tiles().Failure();
        }
}

TEST_F(TextureFilesTest, GreyImagesTakeOneChannelAndOpaqueOnesNoAlpha) {
    Image image = Random({80, 80}, {"R", "G", "B", "A"});
    for (size_t i = 0; i < image.Pixels().size(); i += 4) image.Pixels()[i + 3] = 1;
    WriteImage(image, Path("opaque.exr"));
    for (size_t i = 0; i < image.Pixels().size(); i += 4)
        image.Pixels()[i + 1] = image.Pixels()[i + 2] = image.Pixels()[i];
    WriteImage(image, Path("grey.exr"));
    TextureFiles files(OnDisk(), nullptr);
    EXPECT_EQ(files.Load({Path("opaque.exr"), {}, WrapMode::Repeat}, {}).NumChannels(), 3);
    EXPECT_EQ(files.Load({Path("grey.exr"), {}, WrapMode::Repeat}, {}).NumChannels(), 1);
}

TEST_F(TextureFilesTest, ImagesThatFitStayArraysAndLeaveNothingOnDisk) {
    WriteImage(Random({64, 64}, {"R", "G", "B"}), Path("a.png"));
    // 64 x 64 x 3 bytes and a third: eight times as much is just enough.
    const size_t bytes = 3 * (64 * 64 + 32 * 32 + 16 * 16 + 8 * 8 + 4 * 4 + 2 * 2 + 1);
    TextureMemory memory = OnDisk();
    memory.bytes = 8 * bytes;
    {
        TextureFiles files(memory, &listener_);
        // Three quarters of the memory hold six such pyramids; there is no limit on how often they are asked
        // for.
        for (int i = 0; i < 6; ++i)
            EXPECT_EQ(files.Load({Path("a.png"), kSRGB, WrapMode::Repeat}, {}).Bytes(), bytes) << i;
        EXPECT_EQ(FilesIn(folder_ / "cache"), 0u);
        EXPECT_EQ(files.Load({Path("a.png"), kSRGB, WrapMode::Repeat}, {}).Bytes(), 0u);
    }
    memory.bytes -= 8;
    EXPECT_EQ(TextureFiles(memory, nullptr).Load({Path("a.png"), kSRGB, WrapMode::Repeat}, {}).Bytes(), 0u);
    EXPECT_EQ(FilesIn(folder_ / "cache"), 1u);
}

TEST_F(TextureFilesTest, LaterRendersFindTheFileUntilTheImageChanges) {
    const std::string path = Path("a.exr");
    WriteImage(Random({65, 80}, {"R", "G", "B"}), path);
    const auto load = [&] {
        TextureFiles files(OnDisk(), &listener_);
        return files.Load({path, {}, WrapMode::Repeat}, {}, &listener_)
            .FilterRGB({{0.3f, 0.4f}}, TextureFilter::Bilinear, 8);
    };
    const RGB first = load();
    EXPECT_EQ(listener_.begun, std::vector<std::string>{"Preparing a.exr"});
    EXPECT_EQ(load(), first);
    EXPECT_EQ(listener_.begun.size(), 1u);

    // Other contents of the same size, and with the same time: tools can set that back.
    const auto time = fs::last_write_time(path);
    Image other = Random({65, 80}, {"R", "G", "B"});
    for (float& v : other.Pixels()) v = 1 - v;
    WriteImage(other, path);
    fs::last_write_time(path, time);
    EXPECT_NE(load(), first);
    EXPECT_EQ(listener_.begun.size(), 2u);
    // The old file was replaced, not left behind.
    EXPECT_EQ(FilesIn(folder_ / "cache"), 1u);

    // Another use has a file of its own.
    TextureFiles files(OnDisk(), &listener_);
    files.Load({path, {}, WrapMode::Clamp}, {});
    EXPECT_EQ(FilesIn(folder_ / "cache"), 2u);
}

TEST_F(TextureFilesTest, DamagedPreparedFilesAreMadeAnew) {
    const std::string path = Path("a.png");
    WriteImage(Random({66, 20}, {"R", "G", "B"}), path);  // two tiles: it is prepared 500 times
    const auto load = [&] {
        TextureFiles files(OnDisk(), &listener_);
        return files.Load({path, kSRGB, WrapMode::Repeat}, {}, &listener_)
            .FilterRGB({{0.3f, 0.4f}}, TextureFilter::Bilinear, 8);
    };
    const RGB first = load();
    const fs::path prepared = fs::directory_iterator(folder_ / "cache")->path();
    const auto size = fs::file_size(prepared);
    for (const uintmax_t length :
         {uintmax_t(0), uintmax_t(7), uintmax_t(300), size / 2, size - 1, size + 1}) {
        fs::resize_file(prepared, length);
        EXPECT_EQ(load(), first) << length;
        EXPECT_EQ(fs::file_size(prepared), size);
    }
    // Any bit of the head may end the process in a library, as at byte 199. The other bytes are texels.
    const std::string good = std::string(ReadFileBytes(prepared.string(), {}, {.maxBytes = 1 << 20}).View());
    for (size_t at = 0; at < 4096; at += at < 400 ? 1 : 37) {
        std::string damaged = good;
        damaged[at] = char(damaged[at] ^ (1 << at % 8));
        std::ofstream(prepared, std::ios::binary) << damaged;
        ASSERT_EQ(load(), first) << at;
        ASSERT_EQ(std::string(ReadFileBytes(prepared.string(), {}, {.maxBytes = 1 << 20}).View()), good)
            << at;
    }
    listener_.begun.clear();
    std::ofstream(prepared, std::ios::binary) << std::string_view("II*\0 no texture", 15);
    EXPECT_EQ(load(), first);
    EXPECT_EQ(listener_.begun.size(), 1u);
}

TEST_F(TextureFilesTest, AnUnwritableCacheCostsAWarning) {
    std::ofstream(Path("cache")) << "a file where the folder should be";
    WriteImage(Random({65, 80}, {"R", "G", "B"}), Path("a.exr"));
    {
        TextureFiles files(OnDisk(), &listener_);
        EXPECT_EQ(files.Load({Path("a.exr"), {}, WrapMode::Repeat}, {}).Bytes(), 0u);
        ASSERT_EQ(listener_.warnings.size(), 1u);
        EXPECT_NE(listener_.warnings[0].find("prepared textures cannot be kept in"), std::string::npos);
        EXPECT_EQ(FilesIn(folder_ / "tmp"), 1u);
    }
    EXPECT_EQ(FilesIn(folder_ / "tmp"), 0u);
    TextureMemory nowhere = OnDisk();
    nowhere.temporaryFolder = Path("cache");
    TextureFiles files(nowhere, &listener_);
    EXPECT_THROW(files.Load({Path("a.exr"), {}, WrapMode::Repeat}, {}), FileError);
}

TEST_F(TextureFilesTest, ADiskWithoutRoomIsAnErrorThatSaysWhatToDo) {
    struct Zeros : PyramidSource {
        std::vector<float> row = std::vector<float>(256, 0.f);
        Int2 Resolution() const override { return {256, 256}; }
        int NumChannels() const override { return 1; }
        const float* Row(int) override { return row.data(); }
        float EdgeValue(Int2, int) const override { return 0; }
        float Lowest() const override { return 0; }
    } zeros;
    const FileSizeLimit limit(100000);
    EXPECT_THROW(WriteTiledFile(Path("full"), TiledLayout({256, 256}, {}, "x"), zeros, WrapMode::Repeat),
                 FileError);
    EXPECT_FALSE(fs::exists(Path("full")));
}

TEST_F(TextureFilesTest, ImagesReadAheadAreThoseThatAreAskedFor) {
    std::vector<TextureImage> images;
    for (int i = 0; i < 9; ++i) {
        images.push_back({Path(fmt::format("{}.exr", i)), {}, i % 2 ? WrapMode::Repeat : WrapMode::Black});
        WriteImage(Random({40 + i, 70}, {"R", "G", "B"}), images.back().path);
    }
    images.push_back(images[3]);  // two textures of one image
    const TextureImage wrong{Path("wrong.exr"), {}, WrapMode::Repeat};
    std::ofstream(wrong.path) << "no image";
    const ThreadLimit threads(4);
    for (const TextureMemory& memory : {TextureMemory{}, OnDisk()}) {
        ImageCache alone(memory, nullptr), ahead(memory, &listener_);
        std::vector<TextureImage> all = images;
        all.insert(all.begin() + 5, wrong);
        listener_.begun.clear();
        ahead.ReadAhead(all);
        EXPECT_EQ(listener_.begun, std::vector<std::string>{"Reading textures"});
        for (const TextureImage& image : images) alone.GetMipMap(image, {});
        // They are there: their files can go.
        for (size_t i = 0; i < 9; ++i) fs::rename(images[i].path, images[i].path + ".away");
        for (const TextureImage& image : images)
            ExpectSame(*alone.GetMipMap(image, {}), *ahead.GetMipMap(image, {}), image.path);
        ImageCache late(TextureMemory{}, nullptr);
        EXPECT_THROW(late.GetMipMap(images[0], {}), FileError);
        for (size_t i = 0; i < 9; ++i) fs::rename(images[i].path + ".away", images[i].path);
        // What is wrong is told to whoever asks, as often as that is.
        for (int i = 0; i < 2; ++i) EXPECT_THROW(ahead.GetMipMap(wrong, {}), SceneError);
    }
}

TEST_F(TextureFilesTest, MistakesInImagesAreThoseOfArrays) {
    Image image = Random({70, 70}, {"R", "G", "B"});
    image.Set({69, 69}, 2, std::numeric_limits<float>::quiet_NaN());
    WriteImage(image, Path("nan.exr"));
    WriteImage(Random({70, 70}, {"R", "Z"}), Path("rz.exr"));
    WriteImage(Random({70, 70}, {"R", "G", "B"}), Path("short.png"));
    fs::resize_file(Path("short.png"), fs::file_size(Path("short.png")) - 1000);
    TextureFiles inMemory({}, nullptr), onDisk(OnDisk(), nullptr);
    const auto message = [&](TextureFiles& files, const char* name) -> std::string {
        try {
            files.Load({Path(name), kSRGB, WrapMode::Repeat}, {"scene.pbrt", 3, 4});
        } catch (const std::exception& e) {
            return e.what();
        }
        return "";
    };
    for (const char* name : {"nan.exr", "rz.exr", "short.png", "none.png"}) {
        EXPECT_NE(message(onDisk, name), "");
        EXPECT_EQ(message(onDisk, name), message(inMemory, name));
    }
    EXPECT_EQ(FilesIn(folder_ / "cache"), 0u);
}

TEST_F(TextureFilesTest, AFileThatGoesBadDuringARenderIsNoticed) {
    WriteImage(Random({512, 512}, {"R", "G", "B"}), Path("a.exr"));
    TextureFiles files(OnDisk(), nullptr);
    const MipMap map = files.Load({Path("a.exr"), {}, WrapMode::Repeat}, {});
    EXPECT_NO_THROW(files.CheckTiles());
    map.Texel(0, {3, 3}, 0);
    const fs::path prepared = fs::directory_iterator(folder_ / "cache")->path();
    fs::resize_file(prepared, fs::file_size(prepared) / 4);
    EXPECT_FALSE(files.Tiles().HasFailed());
    float last = 1;
    for (int i = 0; i < 512; ++i) last = map.Texel(0, {i, i}, 0);
    EXPECT_EQ(last, 0);
    EXPECT_TRUE(files.Tiles().HasFailed());
    EXPECT_THROW(files.CheckTiles(), FileError);
}

TEST_F(TextureFilesTest, AFileRemovedDuringARenderStaysReadable) {
    WriteImage(Random({512, 512}, {"R", "G", "B"}), Path("a.exr"));
    TextureFiles inMemory({}, nullptr), files(OnDisk(), nullptr);
    const MipMap array = inMemory.Load({Path("a.exr"), {}, WrapMode::Repeat}, {});
    const MipMap map = files.Load({Path("a.exr"), {}, WrapMode::Repeat}, {});
    fs::remove_all(folder_ / "cache");
    fs::remove(Path("a.exr"));
    for (int i = 0; i < 512; ++i) EXPECT_EQ(map.Texel(0, {i, 511 - i}, 1), array.Texel(0, {i, 511 - i}, 1));
    EXPECT_FALSE(files.Tiles().HasFailed()) << files.Tiles().Failure();
}

}  // namespace
}  // namespace lacquer::texture_files_test
