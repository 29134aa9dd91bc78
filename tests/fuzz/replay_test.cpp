// Every seed of the fuzz targets, and every input that once broke a reader, is read or refused as it should
// be.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "fuzz/fuzz_target.h"
#include "pbrt/core/error.h"

namespace lacquer::fuzz {
namespace {

namespace fs = std::filesystem;
using Targets = Registry<FuzzTargetKind>;

std::vector<fs::path> SeedsOf(const std::string& target) {
    std::vector<fs::path> seeds;
    for (const auto& entry :
         fs::directory_iterator(fs::path(LACQUER_SOURCE_DIR) / "tests/fuzz/seeds" / target))
        seeds.push_back(entry.path());
    std::sort(seeds.begin(), seeds.end());
    return seeds;
}

std::string BytesOf(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

class FuzzSeeds : public testing::TestWithParam<std::string> {};

// A target whose seeds are all refused would begin with nothing.
TEST_P(FuzzSeeds, AreReadOrRefusedAndSomeAreRead) {
    int accepted = 0;
    for (const fs::path& seed : SeedsOf(GetParam())) {
        SCOPED_TRACE(seed.string());
        EXPECT_NO_THROW(accepted += Accepts(Targets::Find(GetParam()), BytesOf(seed)));
    }
    EXPECT_GT(accepted, 0);
}

INSTANTIATE_TEST_SUITE_P(All, FuzzSeeds, testing::ValuesIn(Targets::Names()),
                         [](const auto& test) { return test.param; });

TEST(FuzzTargets, ErrorsOfUsersAreRightAndOthersAreNot) {
    EXPECT_TRUE(Accepts([](std::string_view) {}, ""));
    EXPECT_FALSE(Accepts([](std::string_view) { throw FileError("file", "problem"); }, ""));
    EXPECT_FALSE(Accepts([](std::string_view) { throw SceneError({}, "problem"); }, ""));
    EXPECT_THROW(Accepts([](std::string_view) { throw std::runtime_error("problem"); }, ""),
                 std::runtime_error);
    EXPECT_THROW(Accepts([](std::string_view) { Require(false, "claim"); }, ""), std::logic_error);
}

TEST(FuzzTargets, FilesHaveTheBytesOfTheInput) {
    const std::string bytes("a\0b\n", 4);
    EXPECT_EQ(BytesOf(InputFile(bytes).Path()), bytes);
}

}  // namespace
}  // namespace lacquer::fuzz
