// Files of states: whole or refused, and never the good one lost.
#include "pbrt/film/state_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "pbrt/core/error.h"
#include "pbrt/core/rng.h"
#include "support/file_size_limit.h"
#include "support/statistics.h"

namespace lacquer::state_file_test {
namespace {

namespace fs = std::filesystem;

/// Arrays of every kind, some longer than a block, with random contents.
struct Arrays {
    explicit Arrays(uint64_t seed, size_t size = 70000) : sums(size), counts(size / 2), ids(50, 9) {
        Rng rng(seed);
        for (size_t i = 0; i < size; ++i) sums.Add(i, double(rng.Uniform()) - 0.3);
        for (int& count : counts) count = int(rng.UniformInt(1000));
        for (int i = 0; i < 300; ++i) ids.Add(rng.UniformInt(50), int(rng.UniformInt(9)));
    }
    std::vector<StateArray> State() { return {{"sums", &sums}, {"counts", &counts}, {"ids", &ids}}; }
    ExactSums sums;
    std::vector<int> counts;
    IdCounts ids;
};

/// Those of Arrays, and of no others: 50 pixels.
const Bounds2i kPixels{{3, 4}, {13, 9}};
std::string AddAll(const std::vector<StoredArray>& stored, const std::vector<StateArray>& to) {
    return AddState(stored, to, kPixels, kPixels);
}

class StateFiles : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::path(testing::TempDir()) / test::FullTestName();
        fs::remove_all(folder_);
        fs::create_directories(folder_);
        path_ = (folder_ / "a.state").string();
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string Bytes() const {
        std::ifstream in(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    void Put(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }
    /// Empty if the file is taken for a state.
    std::string WhyRefused() const {
        try {
            ReadStateFile(path_);
            return "";
        } catch (const FileError& e) {
            return e.what();
        }
    }
    size_t NumFiles() const { return size_t(std::distance(fs::directory_iterator(folder_), {})); }

    fs::path folder_;
    std::string path_;
};

/// States have gigabytes, and who merges or describes many reads all headers first.
TEST_F(StateFiles, HeadersAreReadWithoutTheRest) {
    Arrays in(1);
    WriteStateFile(path_, "header", in.State());
    const std::string whole = Bytes(), magic = "lacquer-state 2\n";
    const size_t end = magic.size() + sizeof(uint64_t) + 6 + sizeof(uint64_t);  // length, text, checksum
    Put(whole.substr(0, end));
    EXPECT_EQ(ReadStateHeader(path_), "header");
    EXPECT_NE(WhyRefused(), "");
    // Controls: a byte less, a header that has changed, a length that is a lie, and what is no state.
    std::string changed = whole, endless = whole;
    changed[end - 10] ^= 1;
    endless[magic.size() + 6] = '\x7f';
    for (const std::string& bytes : {whole.substr(0, end - 1), changed, endless, whole.substr(0, 20),
                                     std::string("Film"), std::string()}) {
        Put(bytes);
        EXPECT_THROW(ReadStateHeader(path_), FileError);
    }
}

TEST_F(StateFiles, AreKnownByTheirBeginning) {
    Put("lacquer-state 9\n");
    EXPECT_TRUE(IsStateFile(path_));
    for (const char* other : {"", "lacquer-stat", "lacquer-stats 1\n"}) {
        Put(other);
        EXPECT_FALSE(IsStateFile(path_)) << other;
    }
    EXPECT_FALSE(IsStateFile(folder_.string()));
    EXPECT_FALSE(IsStateFile(path_ + ".none"));
}

TEST_F(StateFiles, GiveBackWhatWasPutIn) {
    Arrays in(1), out(2, 70000), empty(3, 70000);
    WriteStateFile(path_, "{\"header\": 1}", in.State());
    const StateFile file = ReadStateFile(path_);
    EXPECT_EQ(file.header, "{\"header\": 1}");
    EXPECT_EQ(ReadStateHeader(path_), "{\"header\": 1}");
    out.sums = ExactSums(70000);
    out.counts.assign(out.counts.size(), 0);
    out.ids = IdCounts(50, 9);
    ASSERT_EQ(AddAll(file.arrays, out.State()), "");
    for (size_t i = 0; i < in.sums.Size(); ++i) ASSERT_EQ(in.sums[i], out.sums[i]);
    EXPECT_EQ(in.counts, out.counts);
    EXPECT_EQ(in.ids.Flat(), out.ids.Flat());
    EXPECT_NE(in.ids.Flat(), empty.ids.Flat());
    EXPECT_EQ(NumFiles(), 1u);
}

/// Two parts of the pixels, in either order, are the whole; each goes to its place.
TEST_F(StateFiles, PartsOfThePixelsAreAddedInTheirPlaces) {
    const Bounds2i whole{{0, 0}, {4, 3}}, left{{0, 0}, {1, 3}}, right{{1, 0}, {4, 3}};
    std::vector<int> counts(24);
    ExactSums sums(36);
    IdCounts ids(12, 40);
    const std::vector<StateArray> to = {{"counts", &counts}, {"sums", &sums}, {"ids", &ids}};
    for (const Bounds2i& part : {right, left}) {
        std::vector<StoredArray> stored(3);
        ExactSums partSums(size_t(part.Area()) * 3);
        std::vector<int> partCounts, flat;
        for (int y = part.min.y; y < part.max.y; ++y)
            for (int x = part.min.x; x < part.max.x; ++x) {
                const int name = 10 * y + x;
                partSums.Add(size_t(partCounts.size()) / 2 * 3 + 2, double(name));
                partCounts.insert(partCounts.end(), {name, -name});
                flat.insert(flat.end(), {1, name, 5});
            }
        stored[0] = {"counts", partCounts};
        stored[1] = {"sums", partSums};
        stored[2] = {"ids", FlatIds{flat}};
        ASSERT_EQ(AddState(stored, to, part, whole), "");
        EXPECT_NE(AddState(stored, to, whole, whole), "") << "fewer pixels than that";
    }
    for (int i = 0; i < 12; ++i) {
        const int name = 10 * (i / 4) + i % 4;
        EXPECT_EQ(counts[size_t(2 * i)], name);
        EXPECT_EQ(counts[size_t(2 * i + 1)], -name);
        EXPECT_EQ(sums[size_t(3 * i + 2)], double(name));
        EXPECT_EQ(sums[size_t(3 * i + 1)], 0.0);
        ASSERT_EQ(ids.Ranked(size_t(i)).size(), 1u);
        EXPECT_EQ(ids.Ranked(size_t(i))[0].id, name);
    }
}

TEST_F(StateFiles, RefuseWhatDoesNotFit) {
    Arrays in(1), smaller(1, 60000);
    WriteStateFile(path_, "", in.State());
    const std::vector<StoredArray> stored = ReadStateFile(path_).arrays;
    EXPECT_NE(AddAll(stored, smaller.State()), "");
    std::vector<StateArray> renamed = in.State();
    renamed[1].name = "other";
    EXPECT_NE(AddAll(stored, renamed), "");
    std::vector<StateArray> fewer = in.State();
    fewer.pop_back();
    EXPECT_NE(AddAll(stored, fewer), "");
    IdCounts fewIds(50, 3);
    std::vector<StateArray> unknownIds = in.State();
    unknownIds[2].values = &fewIds;
    EXPECT_NE(AddAll(stored, unknownIds), "");
}

TEST_F(StateFiles, EveryTruncationIsSeen) {
    Arrays in(1);
    WriteStateFile(path_, "{}", in.State());
    const std::string whole = Bytes();
    for (int tenth = 0; tenth < 10; ++tenth) {
        Put(whole.substr(0, whole.size() * size_t(tenth) / 10));
        EXPECT_NE(WhyRefused(), "") << tenth;
    }
    Put(whole.substr(0, whole.size() - 1));
    EXPECT_NE(WhyRefused(), "");
    Put(whole + "x");
    EXPECT_NE(WhyRefused(), "");
    Put(whole);
    EXPECT_EQ(WhyRefused(), "");
}

/// Of every flipped bit; lengths that would take too much memory included.
TEST_F(StateFiles, EveryFlippedBitIsSeen) {
    Arrays in(1, 300);
    WriteStateFile(path_, "{}", in.State());
    const std::string whole = Bytes();
    ASSERT_LT(whole.size(), 20000u);
    Rng rng(test::SeedOf(test::FullTestName()));
    for (size_t i = 0; i < whole.size(); i += i < 200 ? 1 : 7) {
        std::string flipped = whole;
        flipped[i] = char(flipped[i] ^ (1 << rng.UniformInt(8)));
        Put(flipped);
        ASSERT_NE(WhyRefused(), "") << i;
    }
}

TEST_F(StateFiles, KeepThePreviousOne) {
    Arrays first(1, 100), second(2, 100);
    WriteStateFile(path_, "first", first.State());
    WriteStateFile(path_, "second", second.State());
    EXPECT_EQ(ReadStateHeader(path_), "second");
    EXPECT_EQ(ReadStateHeader(PreviousState(path_)), "first");
    Put("lacquer-state 2\ndamaged");
    EXPECT_NE(WhyRefused().find(PreviousState(path_)), std::string::npos) << WhyRefused();
    EXPECT_EQ(NumFiles(), 2u);
}

/// A full disk, and a folder that is gone: what was there stays.
TEST_F(StateFiles, WhatCannotBeWrittenLeavesWhatWasThere) {
    Arrays in(1, 100);
    WriteStateFile(path_, "good", in.State());
    {
        const test::FileSizeLimit limit(1000);
        EXPECT_THROW(WriteStateFile(path_, "bad", in.State()), FileError);
    }
    EXPECT_EQ(ReadStateHeader(path_), "good");
    EXPECT_EQ(NumFiles(), 1u);
    EXPECT_THROW(WriteStateFile((folder_ / "none" / "b.state").string(), "bad", in.State()), FileError);
}

}  // namespace
}  // namespace lacquer::state_file_test
