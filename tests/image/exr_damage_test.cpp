#include "pbrt/image/exr_damage.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "pbrt/image/exr_file.h"

namespace lacquer::exr_damage_test {
namespace {

std::string Word(uint32_t value) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) bytes += char((value >> (8 * i)) & 0xff);
    return bytes;
}
std::string Text(const std::string& text) { return text + '\0'; }
std::string Attribute(const std::string& type, const std::string& value, int claimedMore = 0) {
    return Text("a") + Text(type) + Word(uint32_t(int(value.size()) + claimedMore)) + value;
}

class ExrDamage : public testing::Test {
  protected:
    void TearDown() override { std::filesystem::remove(path_); }
    /// What is found in a file with one header of these attributes.
    std::string Of(const std::string& attributes) { return OfFile(Start(0) + attributes + Text("")); }
    std::string OfFile(const std::string& bytes) {
        std::ofstream(path_, std::ios::binary) << bytes;
        return ExrHeaderDamage(path_);
    }
    static std::string Start(uint32_t flags) { return "v/1\1" + Word(2 | flags); }

    const std::string path_ = testing::TempDir() + "lacquer_exr_damage_" +
                              testing::UnitTest::GetInstance()->current_test_info()->name() + ".exr";
};

const std::string kPadding(200, 'x');

TEST_F(ExrDamage, ValuesEndWhereTheHeaderSaysAndNowhereElse) {
    const std::string channel = Text("R") + std::string(16, '\0');
    const std::string values[][2] = {
        {"box2i", std::string(16, 'v')},
        {"chromaticities", std::string(32, 'v')},
        {"compression", "v"},
        {"float", "vvvv"},
        {"m44d", std::string(128, 'v')},
        {"tiledesc", std::string(9, 'v')},
        {"v3d", std::string(24, 'v')},
        {"chlist", channel + channel + Text("")},
        {"preview", Word(3) + Word(2) + std::string(24, 'v')},
        {"floatvector", std::string(12, 'v')},
        {"stringvector", Word(3) + "abc" + Word(0) + Word(2) + "de"},
    };
    for (const auto& [type, value] : values) {
        EXPECT_EQ(Of(Attribute(type, value)), "") << type;
        for (const int more : {-1, 1, 5}) {
            const std::string damage = Of(Attribute(type, value, more) + Attribute("string", kPadding));
            EXPECT_EQ(damage,
                      "attribute \"a\" of type \"" + type + "\" does not end where the EXR header says")
                << more;
        }
    }
    // What may be of any length.
    for (const char* type : {"string", "bytes", "nobody knows", "idmanifest"})
        for (const size_t size : {0u, 1u, 77u}) EXPECT_EQ(Of(Attribute(type, std::string(size, 'v'))), "");
}

TEST_F(ExrDamage, NothingClaimsMoreThanTheFileOrMuchMemory) {
    EXPECT_EQ(Of(Attribute("string", "abc", 1000)), "an attribute of the EXR header is larger than the file");
    const std::string wide = Word(0x7f7f7f7f) + Word(0x7f7f7f7f) + kPadding;
    EXPECT_NE(Of(Attribute("preview", wide)), "");
    EXPECT_NE(Of(Attribute("stringvector", Word(0x7f7f7f7f) + kPadding)), "");
    const std::string longest(255, 'n');
    EXPECT_EQ(Of(Text(longest) + Text(longest) + Word(1) + "v"), "");
    EXPECT_EQ(Of(Text(longest + "n") + Text("int") + Word(4) + "vvvv"), "the EXR header ends too early");
}

TEST_F(ExrDamage, HeadersAreReadToTheLast) {
    constexpr uint32_t kMultipart = 0x1000;
    const std::string sound = Attribute("int", "vvvv") + Text("");
    const std::string damaged = Attribute("int", "vvvv", 4) + kPadding + Text("");
    EXPECT_EQ(OfFile(Start(kMultipart) + sound + sound + Text("")), "");
    EXPECT_NE(OfFile(Start(kMultipart) + sound + damaged + Text("")), "");
    // A second header of a file that says it has one is none.
    EXPECT_EQ(OfFile(Start(0) + sound + damaged), "");
    for (const std::string& start : {std::string(), Start(0), Start(0) + "a", Start(kMultipart) + sound})
        EXPECT_EQ(OfFile(start), "the EXR header ends too early") << start.size();
}

TEST_F(ExrDamage, FilesOfTheLibraryAreSound) {
    ImageContents contents;
    contents.resolution = contents.fullResolution = {3, 2};
    contents.channels = {"R", "G", "B", "layer.Z"};
    contents.type = ValueType::Float;
    contents.attributes = {{"one", 1},
                           {"two", 2.f},
                           {"text", std::string(300, 't')},
                           {"chromaticities", std::vector<float>(8, 0.3f)},
                           {"pair", std::vector<float>{1, 2}},
                           {"many", std::vector<float>(100, 1)},
                           {"matrix", glm::mat4(1)}};
    const std::vector<float> values(24, 0.5f);
    const std::vector<unsigned char> bytes = EncodeExr(contents, values.data());
    EXPECT_EQ(OfFile(std::string(bytes.begin(), bytes.end())), "");
}

}  // namespace
}  // namespace lacquer::exr_damage_test
