#include "pbrt/image/exr_damage.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatVectorAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfIDManifestAttribute.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPreviewImage.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <array>
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
    for (const char* type : {"string", "bytes", "nobody knows"})
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

/// A header with attributes of all types that the library writes for those who name them.
Imf::Header HeaderOfAllTypes() {
    Imf::Header header(4, 4);
    header.channels().insert("R", Imf::Channel(Imf::FLOAT));
    header.setPreviewImage(Imf::PreviewImage(3, 2));
    header.setTileDescription(Imf::TileDescription());
    Imf::addChromaticities(header, Imf::Chromaticities());
    Imf::addEnvmap(header, Imf::ENVMAP_CUBE);
    Imf::addKeyCode(header, Imf::KeyCode());
    Imf::addTimeCode(header, Imf::TimeCode());
    Imf::addFramesPerSecond(header, Imf::Rational(25, 1));
    Imf::addMultiView(header, {"left", "", "right"});
    Imf::addDeepImageState(header, Imf::DIS_TIDY);
    header.insert("box2f", Imf::Box2fAttribute());
    header.insert("double", Imf::DoubleAttribute(1));
    header.insert("floats", Imf::FloatVectorAttribute({1, 2, 3}));
    header.insert("int", Imf::IntAttribute(1));
    header.insert("m33d", Imf::M33dAttribute());
    header.insert("m33f", Imf::M33fAttribute());
    header.insert("m44d", Imf::M44dAttribute());
    header.insert("m44f", Imf::M44fAttribute());
    header.insert("string", Imf::StringAttribute("text"));
    header.insert("v2d", Imf::V2dAttribute());
    header.insert("v2i", Imf::V2iAttribute());
    header.insert("v3d", Imf::V3dAttribute());
    header.insert("v3f", Imf::V3fAttribute());
    header.insert("v3i", Imf::V3iAttribute());
    return header;
}
void WriteGray(const std::string& path, const Imf::Header& header) {
    std::array<float, 16> pixels{};
    Imf::FrameBuffer frame;
    frame.insert("R", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(pixels.data()), sizeof(float),
                                 4 * sizeof(float)));
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(4);
}

TEST_F(ExrDamage, AllTypesOfTheLibraryEndWhereTheirHeaderSays) {
    WriteGray(path_, HeaderOfAllTypes());
    EXPECT_EQ(ExrHeaderDamage(path_), "");
}

// The library's reader takes the first four letters of the next attribute's name for a part of the manifest.
TEST_F(ExrDamage, ManifestsAreRefusedForTheLibraryReadsTooMuch) {
    Imf::IDManifest manifest;
    Imf::IDManifest::ChannelGroupManifest& group = manifest.add("R");
    group.setComponents({"name"});
    group.insert(7, std::vector<std::string>{"seven"});
    Imf::Header header = HeaderOfAllTypes();
    Imf::addIDManifest(header, Imf::CompressedIDManifest(manifest));
    WriteGray(path_, header);
    EXPECT_EQ(
        ExrHeaderDamage(path_),
        "attribute \"idManifest\" is an ID manifest, of which OpenEXR reads four bytes too many; without it "
        "the file can be read");
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
