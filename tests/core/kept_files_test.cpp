// Files that are kept from scene to scene: read once, again when they change, dropped when nobody asks.
#include "pbrt/core/kept_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "support/statistics.h"

namespace lacquer::kept_files_test {
namespace {

namespace fs = std::filesystem;

class Kept : public testing::Test {
  protected:
    void SetUp() override {
        path_ = (fs::path(testing::TempDir()) / test::FullTestName()).string();
        Put("one");
    }
    void TearDown() override { fs::remove(path_); }
    /// With a time of its own, though clocks of file systems are slow.
    void Put(const std::string& text) {
        std::ofstream(path_) << text;
        fs::last_write_time(path_, fs::file_time_type::clock::now() + std::chrono::seconds(++puts_));
    }
    std::string Get(const std::string& key = "a") {
        return *files_.Get(key, path_, [&] {
            ++reads_;
            std::string text;
            std::ifstream(path_) >> text;
            if (text == "bad") throw std::runtime_error(text);
            return text;
        });
    }

    std::string path_;
    int reads_ = 0, puts_ = 0;
    std::vector<std::string> forgotten_;
    KeptFiles<std::string, std::string> files_{[this](const std::string& s) { forgotten_.push_back(s); }};
};

TEST_F(Kept, AreReadOnce) {
    for (int scene = 0; scene < 3; ++scene) {
        EXPECT_EQ(Get(), "one");
        EXPECT_EQ(Get(), "one");
        files_.DropUnused();
        files_.BeginScene();
    }
    EXPECT_EQ(reads_, 1);
    EXPECT_TRUE(forgotten_.empty());
}

TEST_F(Kept, AreReadAgainByTheNextSceneOnceTheyChange) {
    EXPECT_EQ(Get(), "one");
    Put("two");
    EXPECT_EQ(Get(), "one") << "one scene has one version of a file";
    files_.BeginScene();
    EXPECT_EQ(Get(), "two");
    EXPECT_EQ(reads_, 2);
    EXPECT_EQ(forgotten_, std::vector<std::string>{"one"});
}

TEST_F(Kept, AreDroppedWhenASceneDoesNotAsk) {
    Get("a");
    Get("b");
    files_.BeginScene();
    Get("b");
    files_.DropUnused();
    EXPECT_EQ(forgotten_.size(), 1u);
    EXPECT_EQ(reads_, 2);
    files_.BeginScene();
    Get("a");
    EXPECT_EQ(reads_, 3);
}

TEST_F(Kept, AreTriedAgainAfterAnError) {
    Put("bad");
    EXPECT_THROW(Get(), std::runtime_error);
    Put("good");
    EXPECT_EQ(Get(), "good");
    files_.BeginScene();
    files_.DropUnused();
    EXPECT_EQ(forgotten_, std::vector<std::string>{"good"});
}

}  // namespace
}  // namespace lacquer::kept_files_test
