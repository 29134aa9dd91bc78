#include "pbrt/film/cryptomatte.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>

namespace lacquer::cryptomatte_test {
namespace {

float IdAsFloat(std::string_view name) { return std::bit_cast<float>(CryptomatteId(name)); }

/// Public test vectors of the hash, all lengths modulo 4 among them.
TEST(MurmurHash3, HasThePublishedValues) {
    EXPECT_EQ(MurmurHash3(""), 0u);
    EXPECT_EQ(MurmurHash3("test"), 0xba6bd213u);
    EXPECT_EQ(MurmurHash3("Hello, world!"), 0xc0363e43u);
    EXPECT_EQ(MurmurHash3("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
    EXPECT_EQ(MurmurHash3("abc"), 0xb3dd93fau);
}

/// The values of the specification's own tests (Psyop/Cryptomatte, nuke/cryptomatte_utilities_tests.py), and
/// of an object in Gaffer's.
TEST(Cryptomatte, IdsAreThoseOfOtherPrograms) {
    EXPECT_EQ(IdAsFloat("hello"), 6.0705627102400005616e-17f);
    EXPECT_EQ(IdAsFloat("\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0"),
              -1.3192631212399999468e-25f);
    EXPECT_EQ(IdAsFloat("m\xc3\xa4"
                        "dchen"),
              6.2361298211599995797e+25f);
    EXPECT_EQ(CryptomatteId("/GAFFERBOT/C_torso_GRP/C_head_GRP/C_head_CPT/C_head001_REN"), 4226998693u);
    EXPECT_EQ(CryptomattePrefix("crypto_object"), "cryptomatte/f834d0a/");
}

/// The exponent is neither 0 nor 255, and nothing else changes.
TEST(Cryptomatte, IdsAreNormalNumbers) {
    int changed = 0;
    for (int i = 0; i < 20000; ++i) {
        const std::string name = "object" + std::to_string(i);
        const uint32_t hash = MurmurHash3(name), id = CryptomatteId(name);
        EXPECT_TRUE(std::isnormal(std::bit_cast<float>(id))) << name;
        if (hash == id) continue;
        ++changed;
        EXPECT_FALSE(std::isnormal(std::bit_cast<float>(hash))) << name;
        EXPECT_EQ(hash ^ id, 1u << 23) << name;
    }
    EXPECT_NEAR(changed, 20000 * 2 / 256, 6 * std::sqrt(20000 * 2 / 256.));
}

TEST(Cryptomatte, ManifestsAreJSON) {
    const std::vector<std::string> names = {"hello", "a \"b\"\n\\", "bad \xff"};
    EXPECT_EQ(CryptomatteManifest(names), "{\"hello\":\"248bfa47\",\"a \\\"b\\\"\\n\\\\\":\"" +
                                              fmt::format("{:08x}", CryptomatteId(names[1])) +
                                              "\",\"bad \xef\xbf\xbd\":\"" +
                                              fmt::format("{:08x}", CryptomatteId(names[2])) + "\"}");
    EXPECT_EQ(CryptomatteManifest({}), "{}");
}

TEST(Cryptomatte, RanksAreIdsAndCoverages) {
    const CryptomatteLayer layer("CryptoObject", {"hello", "cup"}, 4);
    EXPECT_EQ(layer.Channels(),
              (std::vector<std::string>{"CryptoObject00.r", "CryptoObject00.g", "CryptoObject00.b",
                                        "CryptoObject00.a", "CryptoObject01.r", "CryptoObject01.g",
                                        "CryptoObject01.b", "CryptoObject01.a"}));
    std::vector<float> values(8, 9.f);
    layer.Develop(std::vector<IdCount>{{1, 5}, {0, 2}}, 8, values.data());
    EXPECT_EQ(values, (std::vector<float>{IdAsFloat("cup"), 0.625f, IdAsFloat("hello"), 0.25f, 0, 0, 0, 0}));
    Metadata metadata;
    layer.AddMetadata(&metadata);
    EXPECT_EQ(metadata.size(), 4u);
    const std::string prefix = CryptomattePrefix("CryptoObject");
    EXPECT_EQ(std::get<std::string>(metadata.at(prefix + "name")), "CryptoObject");
    EXPECT_EQ(std::get<std::string>(metadata.at(prefix + "hash")), "MurmurHash3_32");
    EXPECT_EQ(std::get<std::string>(metadata.at(prefix + "conversion")), "uint32_to_float32");
}

TEST(IdCounts, RanksByCountThenById) {
    IdCounts counts(2, 10);
    for (const int id : {7, 3, 7, 9, 3, 1, 7}) counts.Add(1, id);
    const std::vector<IdCount> ranked = counts.Ranked(1);
    ASSERT_EQ(ranked.size(), 4u);
    const std::vector<std::pair<int, uint32_t>> expected = {{7, 3}, {3, 2}, {1, 1}, {9, 1}};
    for (size_t i = 0; i < 4; ++i) EXPECT_EQ(std::pair(ranked[i].id, ranked[i].count), expected[i]);
    EXPECT_TRUE(counts.Ranked(0).empty());
}

TEST(IdCounts, CountsAllExactlyInAnyOrder) {
    IdCounts rising(1, 40), falling(1, 40);
    for (int round = 0; round < 3; ++round)
        for (int id = 0; id < 40; ++id) {
            rising.Add(0, id, id == 33 ? 2 : 1);
            falling.Add(0, 39 - id, id == 6 ? 2 : 1);
        }
    const std::vector<IdCount> ranked = rising.Ranked(0), other = falling.Ranked(0);
    ASSERT_EQ(ranked.size(), 40u);
    ASSERT_EQ(other.size(), 40u);
    for (size_t i = 0; i < 40; ++i) {
        EXPECT_EQ(ranked[i].id, i == 0 ? 33 : i <= 33 ? int(i) - 1 : int(i));
        EXPECT_EQ(ranked[i].count, i == 0 ? 6u : 3u);
        EXPECT_EQ(std::pair(ranked[i].id, ranked[i].count), std::pair(other[i].id, other[i].count));
    }
}

}  // namespace
}  // namespace lacquer::cryptomatte_test
