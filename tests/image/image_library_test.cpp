// OpenImageIO comes into a process by the first image file that needs it. What is asked of a process without
// it, a child process does: others of these tests may have run before.
#include "pbrt/image/image_library.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <latch>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "pbrt/core/error.h"
#include "pbrt/image/image.h"
#include "pbrt/image/tile_cache.h"

namespace lacquer::image_library_test {
namespace {

namespace fs = std::filesystem;

const FileLoc kLoc{"scene.pbrt", 7, 3};

/// Whether the process has this shared object in its memory.
bool HasLoaded(const std::string& name) {
    std::ifstream maps("/proc/self/maps");
    const std::string all{std::istreambuf_iterator<char>(maps), {}};
    return all.find(name) != std::string::npos;
}

bool HasOpenImageIO() { return HasLoaded("libOpenImageIO.so") && HasLoaded("liblacquer_openimageio.so"); }

class ImageLibraryDeathTest : public testing::Test {
  protected:
    void SetUp() override {
        // A child is a new process, which runs the test up to the statement that is to end it.
        GTEST_FLAG_SET(death_test_style, "threadsafe");
        folder_ = fs::temp_directory_path() / (std::string("lacquer-image-library-") +
                                               testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::create_directories(folder_);
    }
    void TearDown() override {
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
    }
    std::string Path(const std::string& name) const { return (folder_ / name).string(); }
    /// A PFM file, for which no library is needed.
    std::string WritePfm() const {
        Image image({3, 2}, {"Y"});
        image.Pixels() = {1, 2, 3, 4, 5, 6};
        WriteImage(image, Path("a.pfm"));
        return Path("a.pfm");
    }
    fs::path folder_;
};

/// Ends a child, with what does not hold.
void Claim(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "not so: %s\n", what);
    std::exit(1);
}

void DoWithoutTheLibrary(const std::string& folder, const std::string& pfm) {
    Claim(!HasLoaded("libOpenImageIO"), "a process starts without it");
    Claim(
        CanWriteImage("a.pfm") && CanWriteImage("a.exr") && CanWriteImage("a.png") && !CanWriteImage("a.xyz"),
        "PFM, EXR and PNG can be written, and no XYZ");
    Image image({2, 1}, {"Y"});
    image.Pixels() = {1.5f, -2};
    WriteImage(image, folder + "/a.exr");
    Claim(ReadImage(folder + "/a.exr", {}, kLoc).Pixels() == image.Pixels(), "EXR is written and read");
    WriteImage(image, folder + "/a.png");
    Claim(ReadImage(folder + "/a.png", {}, kLoc).Resolution() == image.Resolution(),
          "PNG is written and read");
    std::ofstream(folder + "/text.png") << "no image";
    for (const std::string name : {"/missing.png", "/text.png"}) {
        bool failed = false;
        try {
            ReadImage(folder + name, {}, kLoc);
        } catch (const std::runtime_error&) {
            failed = true;
        }
        Claim(failed, "what is no image is not read");
    }
    TileCache tiles;
    tiles.SetLimit(1 << 20);
    Claim(!tiles.Open(folder + "/missing.tx", "description") && tiles.Failure().empty(),
          "no file has no tiles");
    Claim(!HasLoaded("libOpenImageIO") && !HasLoaded("liblacquer_openimageio"), "nothing of this loads it");
    Claim(ReadImage(pfm, {}, kLoc).Pixels() == std::vector<float>({1, 2, 3, 4, 5, 6}), "an image is read");
    Claim(HasOpenImageIO(), "that loads it");
    std::exit(0);
}

TEST_F(ImageLibraryDeathTest, IsLoadedByTheFirstImageThatIsReadAndByNothingBefore) {
    const std::string pfm = WritePfm();
    EXPECT_EXIT(DoWithoutTheLibrary(folder_.string(), pfm), testing::ExitedWithCode(0), "");
}

void ReadFromManyThreads(const std::string& pfm) {
    Claim(!HasLoaded("libOpenImageIO"), "a process starts without it");
    constexpr int kNumThreads = 16;
    std::latch start(kNumThreads);
    std::vector<Image> images(kNumThreads);
    std::vector<const ImageLibrary*> libraries(kNumThreads);
    std::vector<std::thread> threads;
    for (size_t i = 0; i < kNumThreads; ++i)
        threads.emplace_back([&, i] {
            start.arrive_and_wait();
            // Half of them by one way, half by another.
            if (i % 2 == 0) libraries[i] = &LoadImageLibrary();
            images[i] = ReadImage(pfm, {}, kLoc);
            libraries[i] = &LoadImageLibrary();
        });
    for (std::thread& thread : threads) thread.join();
    for (const ImageLibrary* library : libraries) Claim(library == libraries[0], "there is one library");
    for (const Image& image : images)
        Claim(image.Pixels() == std::vector<float>({1, 2, 3, 4, 5, 6}), "all read the image");
    std::exit(0);
}

TEST_F(ImageLibraryDeathTest, SeveralThreadsMayBeTheFirst) {
    const std::string pfm = WritePfm();
    EXPECT_EXIT(ReadFromManyThreads(pfm), testing::ExitedWithCode(0), "");
}

void ClaimWhatDoesNotHold() {
    Claim(HasLoaded("libNothingOfThisName.so"), "a library of no such name is there");
    std::exit(0);
}

TEST_F(ImageLibraryDeathTest, NegativeControlOfClaims) {
    EXPECT_EXIT(ClaimWhatDoesNotHold(), testing::ExitedWithCode(1), "not so: a library of no such name");
}

TEST(ImageLibrary, ErrorsOfTheModuleAreCaughtOutside) {
    const ImageLibrary& library = LoadImageLibrary();
    const std::string path = fs::temp_directory_path() / "lacquer-image-library.exr";
    std::ofstream(path) << "no image";
    try {
        library.Open("openexr", path);
        ADD_FAILURE() << "a text was opened as OpenEXR";
    } catch (const std::runtime_error& e) {
        EXPECT_STRNE(e.what(), "");
    }
    fs::remove(path);
    EXPECT_EQ(library.Open("no format", path), nullptr);
    EXPECT_THROW(library.LimitsOf("no-extension"), std::runtime_error);
    EXPECT_FALSE(library.Writes("open"));  // a part of a name
    EXPECT_TRUE(library.Writes("openexr"));
}

TEST(ImageLibrary, NoModuleOfAnotherVersionIsTaken) {
    LoadImageLibrary();
    void* const module = dlopen("liblacquer_openimageio.so", RTLD_NOW | RTLD_NOLOAD);
    ASSERT_NE(module, nullptr);
    const auto make = reinterpret_cast<decltype(&LacquerOpenImageIO)>(dlsym(module, "LacquerOpenImageIO"));
    ASSERT_NE(make, nullptr);
    EXPECT_EQ(make(ImageLibrary::kVersion), &LoadImageLibrary());
    EXPECT_EQ(make(ImageLibrary::kVersion + 1), nullptr);
    dlclose(module);
}

}  // namespace
}  // namespace lacquer::image_library_test
