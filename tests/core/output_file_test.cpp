// Files come into being whole or not at all, and nowhere else than where they should.
#include "pbrt/core/output_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "pbrt/core/error.h"
#include "support/file_size_limit.h"
#include "support/statistics.h"

namespace lacquer::output_file_test {
namespace {

namespace fs = std::filesystem;

class OutputFiles : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::path(testing::TempDir()) / test::FullTestName();
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string Path(const std::string& name) const { return (folder_ / name).string(); }
    std::string Text(const std::string& name) const {
        std::ifstream in(Path(name), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    void Put(const std::string& name, const std::string& text) const { std::ofstream(Path(name)) << text; }
    size_t NumFiles() const {
        return size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
    }
    static void Write(const std::string& path, std::string_view text) {
        OutputFile file(path);
        file.Write(text);
        file.Finish();
    }

    fs::path folder_;
};

TEST_F(OutputFiles, AreThereOnceTheyAreFinished) {
    OutputFile file(Path("a"));
    file.Write("one ");
    EXPECT_EQ(NumFiles(), 0u);
    file.Write("two");
    file.Sync();
    EXPECT_EQ(NumFiles(), 0u);
    file.Finish();
    EXPECT_EQ(Text("a"), "one two");
    EXPECT_EQ(NumFiles(), 1u);
}

TEST_F(OutputFiles, ReplaceWhatWasThereAtOnce) {
    Put("a", "old");
    {
        OutputFile file(Path("a"));
        file.Write("new");
        EXPECT_EQ(Text("a"), "old");
        file.Finish();
    }
    EXPECT_EQ(Text("a"), "new");
    // Two of one name: the last one that is finished counts.
    OutputFile first(Path("b")), second(Path("b"));
    first.Write("first");
    second.Write("second");
    second.Finish();
    first.Finish();
    EXPECT_EQ(Text("b"), "first");
    EXPECT_EQ(NumFiles(), 2u);
}

TEST_F(OutputFiles, LeaveNothingUnlessTheyAreFinished) {
    Put("a", "old");
    {
        OutputFile file(Path("a")), other(Path("b"));
        file.Write("new");
        other.Write("new");
    }
    EXPECT_EQ(Text("a"), "old");
    EXPECT_EQ(NumFiles(), 1u);
}

/// A kill leaves nothing: where the file system can, the file has no name until the end.
TEST_F(OutputFiles, LeaveNothingAfterAKill) {
    Put("a", "old");
    const pid_t child = fork();
    if (child == 0) {
        OutputFile file(Path("a"));
        file.Write(std::string(1 << 20, 'x'));
        raise(SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    EXPECT_EQ(Text("a"), "old");
    EXPECT_EQ(NumFiles(), 1u);
}

TEST_F(OutputFiles, FollowLinks) {
    fs::create_directory(folder_ / "elsewhere");
    Put("elsewhere/real", "old");
    fs::create_symlink("elsewhere/real", Path("a"));
    fs::create_symlink("a", Path("b"));
    Write(Path("b"), "new");
    EXPECT_TRUE(fs::is_symlink(Path("a")) && fs::is_symlink(Path("b")));
    EXPECT_EQ(Text("elsewhere/real"), "new");
    // Also to what is not there yet, and around in a circle.
    fs::create_symlink("elsewhere/none", Path("c"));
    Write(Path("c"), "made");
    EXPECT_EQ(Text("elsewhere/none"), "made");
    fs::create_symlink("round", Path("round"));
    EXPECT_THROW(Write(Path("round"), "?"), FileError);
}

TEST_F(OutputFiles, PipesAndDevicesTakeTheBytes) {
    Write("/dev/null", "gone");
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_THROW(Write("/dev/full", "no room"), FileError);
    ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
    std::string read;
    std::thread reader([&] { read = Text("pipe"); });
    Write(Path("pipe"), "through");
    reader.join();
    EXPECT_EQ(read, "through");
    EXPECT_TRUE(fs::is_fifo(Path("pipe")));
}

TEST_F(OutputFiles, ThatFindNoRoomLeaveWhatWasThere) {
    Put("a", "old");
    {
        const test::FileSizeLimit limit(1000);
        OutputFile file(Path("a"));
        file.Write(std::string(900, 'x'));
        EXPECT_THROW(file.Write(std::string(200, 'x')), FileError);
        EXPECT_THROW(OutputFile(Path("b")).Reserve(2000), FileError);
        EXPECT_NO_THROW(OutputFile(Path("c")).Reserve(500));
    }
    EXPECT_EQ(Text("a"), "old");
    EXPECT_EQ(NumFiles(), 1u);
}

TEST_F(OutputFiles, CanBeWrittenInAnyOrder) {
    const std::vector<unsigned char> a = {1, 2, 3}, b = {4, 5};
    OutputFile file(Path("a"));
    file.Reserve(5);
    file.WriteAt(3, b);
    file.WriteAt(0, a);
    file.Finish();
    EXPECT_EQ(Text("a"), "\1\2\3\4\5");
}

TEST_F(OutputFiles, NameTheFileInErrors) {
    for (const std::string& path : {Path("none/a"), folder_.string(), std::string("/proc/a")}) try {
            Write(path, "?");
            ADD_FAILURE() << path;
        } catch (const FileError& e) {
            EXPECT_EQ(e.Path(), path);
        }
}

TEST_F(OutputFiles, HaveTheUsualPermissions) {
    const mode_t mask = umask(027);
    Write(Path("a"), "?");
    umask(mask);
    struct stat status;
    ASSERT_EQ(stat(Path("a").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0640u);
}

}  // namespace
}  // namespace lacquer::output_file_test
