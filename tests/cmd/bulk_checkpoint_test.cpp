#include "cmd/bulk/checkpoint.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <limits>

#include "pbrt/core/error.h"
#include "support/bulk_tables.h"

namespace lacquer::test::bulk_checkpoint_test {
namespace {

using namespace cmd;

std::string ProblemOf(const std::string& path, const std::string& problem = "these particles") {
    try {
        ReadCheckpoint(path, problem);
    } catch (const FileError& error) {
        return error.Problem();
    }
    return "none";
}

TEST(Checkpoint, GivesTheSameBitsBack) {
    const std::string path = WriteFile("a.part", "");
    const BulkStates states{{1.5, -0., 5e-324, std::numeric_limits<double>::infinity()}, {}, {0.1}};
    WriteCheckpoint(path, "these particles", states);
    const BulkStates read = ReadCheckpoint(path, "these particles");
    EXPECT_EQ(read, states);
    EXPECT_TRUE(std::signbit(read[0][1]));
}

TEST(Checkpoint, RefusesOtherProblemsAndDamagedFiles) {
    const std::string path = WriteFile("a.part", "");
    WriteCheckpoint(path, "these particles", {{1, 2, 3}, {4}});
    EXPECT_EQ(ProblemOf(path), "none");
    EXPECT_NE(ProblemOf(path, "these particleS").find("is of other particles"), std::string::npos);
    std::ifstream in(path, std::ios::binary);
    const std::string whole(std::istreambuf_iterator<char>(in), {});
    // Each bit flipped, each shorter file; beyond the first line that says what it is.
    const size_t head = whole.find('\n') + 1;
    for (size_t i = 0; i < whole.size(); ++i) {
        std::string broken = whole;
        broken[i] = char(broken[i] ^ (1 << i % 8));
        EXPECT_EQ(ProblemOf(WriteFile("flipped", broken)),
                  i < head ? "is no checkpoint of lacquer bulk" : "this checkpoint is damaged")
            << i;
        EXPECT_EQ(ProblemOf(WriteFile("short", whole.substr(0, i))),
                  i < head ? "is no checkpoint of lacquer bulk" : "this checkpoint is damaged")
            << i;
    }
}

}  // namespace
}  // namespace lacquer::test::bulk_checkpoint_test
