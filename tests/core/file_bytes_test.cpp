#include "pbrt/core/file_bytes.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <thread>

namespace lacquer::test::file_bytes_test {
namespace {

namespace fs = std::filesystem;

const FileLoc kLoc{"scene.pbrt", 7, 3};

class FileBytesTest : public testing::Test {
  protected:
    void SetUp() override {
        folder_ =
            fs::path(testing::TempDir()) / (std::string("lacquer_file_bytes_") +
                                            testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string Write(const std::string& bytes) const {
        std::ofstream(Path("file"), std::ios::binary) << bytes;
        return Path("file");
    }
    std::string Path(const std::string& name) const { return (folder_ / name).string(); }
    fs::path folder_;
};

std::string Zipped(const std::string& bytes) {
    z_stream stream{};
    deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, 15 + 16, 9, Z_DEFAULT_STRATEGY);
    std::string zipped(deflateBound(&stream, uLong(bytes.size())), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = uInt(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(zipped.data());
    stream.avail_out = uInt(zipped.size());
    deflate(&stream, Z_FINISH);
    zipped.resize(stream.total_out);
    deflateEnd(&stream);
    return zipped;
}

/// What is wrong, with the kind of the error before it.
std::string ProblemOf(const std::string& path, const ReadLimits& limits) {
    try {
        ReadFileBytes(path, kLoc, limits);
    } catch (const FileError& e) {
        EXPECT_EQ(e.Loc().line, kLoc.line);
        EXPECT_EQ(e.Path(), path);
        return "file: " + e.Problem();
    } catch (const SceneError& e) {
        EXPECT_EQ(e.Loc().line, kLoc.line);
        return "scene: " + e.Message();
    }
    return "";
}

TEST_F(FileBytesTest, PlainAndZippedFilesGiveTheSameBytes) {
    std::string bytes("\0x\xff", 3);
    for (int i = 0; i < 50000; ++i) bytes += std::to_string(i * 7919);
    const FileBytes plain = ReadFileBytes(Write(bytes), kLoc, {bytes.size()});
    EXPECT_EQ(plain.View(), bytes);
    EXPECT_FALSE(plain.wasZipped);
    const FileBytes zipped = ReadFileBytes(Write(Zipped(bytes)), kLoc, {bytes.size()});
    EXPECT_EQ(zipped.View(), bytes);
    EXPECT_TRUE(zipped.wasZipped);
    EXPECT_EQ(ReadFileBytes(Write(Zipped("ab") + Zipped("") + Zipped("cd")), kLoc, {100}).View(), "abcd");
    EXPECT_EQ(ReadFileBytes(Write(""), kLoc, {100}).View(), "");
    EXPECT_EQ(ReadFileBytes(Write(Zipped("")), kLoc, {100}).View(), "");
}

TEST_F(FileBytesTest, OneByteBeyondTheLimitIsTooMuch) {
    std::string bytes;
    for (int i = 0; i < 30000; ++i) bytes += std::to_string(i * 7919);
    EXPECT_EQ(ProblemOf(Write(bytes), {bytes.size() - 1, true, "; do less"}),
              "file: the file is larger than " + std::to_string(bytes.size() - 1) +
                  " bytes, the most that is read; do less");
    EXPECT_EQ(ProblemOf(Write(Zipped(bytes)), {bytes.size() - 1}),
              "file: the file is larger than " + std::to_string(bytes.size() - 1) +
                  " bytes when unzipped, the most that is read");
    EXPECT_EQ(ProblemOf("/dev/zero", {1000000, false}),
              "file: the file is larger than 1000000 bytes, the most that is read");
}

// 64 members of 8 MB are 512 MB out of 0.5 MB; 256 MB are read.
TEST_F(FileBytesTest, WhatSwellsALotIsCutOffLongBeforeTheLimit) {
    const std::string member = Zipped(std::string(8 << 20, ' '));
    std::string bomb;
    for (int i = 0; i < 64; ++i) bomb += member;
    EXPECT_EQ(ProblemOf(Write(bomb), {size_t(1) << 40}),
              "file: the file is larger than 268435456 bytes when unzipped, the most that is read");
}

TEST_F(FileBytesTest, OnlyFilesThatCannotBeReadAreFileErrors) {
    EXPECT_EQ(ProblemOf(Path("missing"), {100}), "file: cannot be opened: No such file or directory");
    EXPECT_EQ(ProblemOf(folder_.string(), {100}), "file: is a folder, not a regular file");
    EXPECT_EQ(ProblemOf(folder_.string(), {100, false}), "file: is a folder, not a regular file");
    EXPECT_EQ(ProblemOf("/dev/zero", {100}), "file: is not a regular file");
    std::string bytes;
    for (int i = 0; i < 3000; ++i) bytes += std::to_string(i * 7919);
    const std::string zipped = Zipped(bytes);
    for (const std::string& damaged :
         {zipped.substr(0, zipped.size() / 2), std::string("\x1f\x8b rubbish"), zipped + "rubbish"}) {
        const std::string path = Write(damaged);
        EXPECT_EQ(
            ProblemOf(path, {1 << 20}).rfind("scene: " + path + ": the gzip data is damaged or cut off", 0),
            0u);
    }
}

TEST_F(FileBytesTest, TheFirstBytesAreReadAsTheyAre) {
    const std::string zipped = Zipped("0123456789"), path = Write(zipped);
    EXPECT_EQ(ReadFirstBytes(path, kLoc, 4), zipped.substr(0, 4));
    EXPECT_EQ(ReadFirstBytes(path, kLoc, size_t(1) << 60), zipped);
    EXPECT_EQ(ReadFirstBytes(path, kLoc, 0), "");
    EXPECT_THROW(ReadFirstBytes(Path("missing"), kLoc, 4), FileError);
    EXPECT_THROW(ReadFirstBytes("/dev/zero", kLoc, 4), FileError);
    EXPECT_THROW(ReadFirstBytes(folder_.string(), kLoc, 4), FileError);
}

// The first would hang if it waited for a writer.
TEST_F(FileBytesTest, PipesAreReadOnlyOnRequest) {
    const std::string pipe = Path("pipe");
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_EQ(ProblemOf(pipe, {100}), "file: is not a regular file");
    std::string bytes;
    for (int i = 0; i < 50000; ++i) bytes += std::to_string(i);
    std::thread writer([&] { std::ofstream(pipe, std::ios::binary) << bytes; });
    EXPECT_EQ(ReadFileBytes(pipe, kLoc, {size_t(1) << 20, false}).View(), bytes);
    writer.join();
}

}  // namespace
}  // namespace lacquer::test::file_bytes_test
