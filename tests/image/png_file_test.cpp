// PNG files against OpenImageIO's reader and writer of them.
#include "pbrt/image/png_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "image/png_bytes.h"
#include "pbrt/core/rng.h"
#include "pbrt/image/image.h"

namespace lacquer::png_file_test {
namespace {

using namespace png_bytes;

namespace fs = std::filesystem;

class PngFile : public testing::Test {
  protected:
    void SetUp() override {
        path_ = fs::temp_directory_path() /
                (std::string("lacquer-png-") + testing::UnitTest::GetInstance()->current_test_info()->name() +
                 ".png");
    }
    void TearDown() override { fs::remove(path_); }
    template <class Bytes>
    void Write(const Bytes& bytes) const {
        std::ofstream(path_, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    }
    std::string File() const {
        std::ifstream file(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    fs::path path_;
};

/// Random pixels whose rows have all five filters.
std::string RandomRows(Png png, int bitsPerPixel, Rng* rng) {
    std::string rows(NumRowBytes(png.width, png.height, bitsPerPixel, png.interlace), '\0');
    for (char& c : rows) c = char(rng->Uniform() * 256);
    // Filters are at the starts of rows, which are found by asking how many bytes fewer rows have.
    Png part = png;
    if (!png.interlace)
        for (part.height = 0; part.height < png.height; ++part.height) {
            char& filter = rows[NumRowBytes(part.width, part.height, bitsPerPixel, false)];
            filter = char(part.height % 5);
        }
    return rows;
}

template <class Value>
std::vector<Value> ValuesOf(ImageReader& reader) {
    const ImageContents& contents = reader.Contents();
    std::vector<Value> values(contents.channels.size() * size_t(contents.resolution.x) *
                              size_t(contents.resolution.y));
    reader.Read(contents.type, values.data());
    return values;
}

/// Both readers see the same image.
void ExpectSame(ImageReader& mine, ImageReader& other) {
    const ImageContents &a = mine.Contents(), &b = other.Contents();
    EXPECT_EQ(a.resolution, b.resolution);
    EXPECT_EQ(a.origin, b.origin);
    EXPECT_EQ(a.fullOrigin, b.fullOrigin);
    EXPECT_EQ(a.fullResolution, b.fullResolution);
    EXPECT_EQ(a.tileRows, b.tileRows);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.channels, b.channels);
    EXPECT_TRUE(b.channelTypes.empty());
    ASSERT_EQ(a.type, b.type);
    if (a.type == ValueType::UInt16)
        EXPECT_EQ(ValuesOf<uint16_t>(mine), ValuesOf<uint16_t>(other));
    else
        EXPECT_EQ(ValuesOf<uint8_t>(mine), ValuesOf<uint8_t>(other));
}

struct Kind {
    char bits, type;
    int bitsPerPixel;
    std::string transparent = {};  // data of tRNS
};

std::vector<Kind> AllKinds() {
    std::vector<Kind> kinds;
    for (const char bits : {'\1', '\2', '\4', '\10', '\20'}) kinds.push_back({bits, 0, bits});
    for (const char bits : {'\1', '\2', '\4', '\10'}) {
        kinds.push_back({bits, 3, bits});
        kinds.push_back({bits, 3, bits, {'\0', '\x80'}});
    }
    for (const char bits : {'\10', '\20'}) {
        kinds.push_back({bits, 2, 3 * bits});
        kinds.push_back({bits, 4, 2 * bits});
        kinds.push_back({bits, 6, 4 * bits});
        kinds.push_back({bits, 0, bits, {'\0', '\7'}});
        kinds.push_back({bits, 2, 3 * bits, {'\0', '\1', '\0', '\2', '\0', '\3'}});
    }
    return kinds;
}

TEST_F(PngFile, OfAllKindsAreReadAsOpenImageIODoes) {
    Rng rng(11);
    for (const Kind& kind : AllKinds())
        for (const uint32_t width : {1u, 3u, 9u, 21u})
            for (const char interlace : {'\0', '\1'}) {
                Png png{width, 13, kind.bits, kind.type};
                png.interlace = interlace;
                if (kind.type == 3)
                    for (int i = 0; i < 3 << kind.bits; ++i) png.palette += char(rng.Uniform() * 256);
                png.rows = RandomRows(png, kind.bitsPerPixel, &rng);
                if (interlace)  // any byte may be a filter there: all bytes are valid ones
                    for (char& c : png.rows) c = char((unsigned char)(c) % 5);
                const std::string trns = kind.transparent.empty() ? "" : Chunk("tRNS", kind.transparent);
                Write(png.File(trns + Chunk("IDAT", Zipped(png.rows))));
                SCOPED_TRACE(testing::Message()
                             << "type " << int(kind.type) << ", " << int(kind.bits) << " bits, " << width
                             << " wide, " << (interlace ? "interlaced" : "rows"));
                const auto mine = OpenPng(path_);
                ASSERT_TRUE(mine);
                ExpectSame(*mine, *LoadImageLibrary().Open("png", path_));
            }
}

/// Rows of a file, as many at a time, and some left out.
TEST_F(PngFile, RowsAreThoseOfTheWhole) {
    Rng rng(3);
    for (const char interlace : {'\0', '\1'}) {
        Png png{9, 50, 8, 2};
        png.interlace = interlace;
        png.rows = RandomRows(png, 24, &rng);
        if (interlace)
            for (char& c : png.rows) c = char((unsigned char)(c) % 5);
        Write(png.File());
        const std::vector<uint8_t> whole = ValuesOf<uint8_t>(*OpenPng(path_));
        const auto reader = OpenPng(path_);
        std::vector<uint8_t> some(27 * 16);
        for (const int begin : {0, 32, 48}) {
            const int end = std::min(begin + 16, 50);
            reader->ReadRows(begin, end, ValueType::UInt8, some.data());
            EXPECT_TRUE(std::equal(whole.begin() + 27 * begin, whole.begin() + 27 * end, some.begin()))
                << begin;
        }
    }
}

TEST_F(PngFile, GammaAndProfilesChangeNoValue) {
    Png png;
    png.rows = std::string(30, '\0');
    for (size_t i = 0; i < png.rows.size(); ++i) png.rows[i] = char(i % 10 == 0 ? 0 : 8 * i);
    Write(png.File());
    const std::vector<uint8_t> plain = ValuesOf<uint8_t>(*OpenPng(path_));
    Write(png.File(
        Chunk("gAMA", Number(100000)) + Chunk("iCCP", std::string("p\0\0", 3) + Zipped("no profile")) +
        Chunk("bKGD", std::string(6, '\1')) + Chunk("sBIT", "\5\6\5") + Chunk("IDAT", Zipped(png.rows))));
    EXPECT_EQ(ValuesOf<uint8_t>(*OpenPng(path_)), plain);
}

TEST_F(PngFile, NotesOfCamerasAreForOpenImageIO) {
    Png png;
    png.rows = std::string(30, '\0');
    const std::string pixels = Chunk("IDAT", Zipped(png.rows));
    const std::string exif("II*\0\x08\0\0\0\0\0\0\0\0\0", 14);
    Write(png.File(Chunk("eXIf", exif) + pixels));
    EXPECT_FALSE(OpenPng(path_));
    Write(png.File(Chunk("iTXt", std::string("XML:com.adobe.xmp\0\0\0\0\0<x/>", 26)) + pixels));
    EXPECT_FALSE(OpenPng(path_));
    Write(png.File(Chunk("tEXt", std::string("exif\0no", 7)) + pixels));
    EXPECT_TRUE(OpenPng(path_));
    EXPECT_NO_THROW(ReadImage(path_, {}, {}));
}

std::map<std::string, MetadataValue> Attributes(const ImageContents& contents) {
    return {contents.attributes.begin(), contents.attributes.end()};
}

ImageContents Contents() {
    ImageContents contents;
    contents.resolution = {5, 3};
    contents.type = ValueType::UInt8;
    contents.channels = {"R", "G", "B", "A"};
    contents.attributes = {{"Artist", std::string("A. N. Other")},
                           {"ImageDescription", std::string("a ball, f\xc3\xbcr alle")},
                           {"Software", std::string("Lacquer")},
                           {"scene", std::string()},
                           {"samplesPerPixel", 16}};
    return contents;
}

TEST_F(PngFile, IsReadByOpenImageIOAsItIsReadHere) {
    Rng rng(5);
    for (size_t numChannels = 1; numChannels <= 4; ++numChannels) {
        ImageContents contents = Contents();
        contents.channels.resize(numChannels);
        std::vector<uint8_t> values(numChannels * 15);
        for (uint8_t& v : values) v = uint8_t(rng.Uniform() * 256);
        Write(EncodePng(contents, values.data()));
        const auto mine = OpenPng(path_), theirs = LoadImageLibrary().Open("png", path_);
        ExpectSame(*mine, *theirs);
        EXPECT_EQ(ValuesOf<uint8_t>(*OpenPng(path_)), values);
        std::map<std::string, MetadataValue> expected = Attributes(contents);
        expected.erase("samplesPerPixel");  // no text
        EXPECT_TRUE(Attributes(mine->Contents()) == expected);
        for (const auto& [name, value] : expected)
            EXPECT_TRUE(Attributes(theirs->Contents())[name] == value) << name;
    }
}

TEST_F(PngFile, HasWhatOpenImageIOWrites) {
    ImageContents contents = Contents();
    contents.attributes.emplace_back("DateTime", std::string("2020:02:03 04:05:06"));
    std::vector<uint8_t> values(4 * 15);
    for (size_t i = 0; i < values.size(); ++i) values[i] = uint8_t(4 * i);
    Write(LoadImageLibrary().Encode(contents, values.data(), "png", path_));
    const auto mine = OpenPng(path_);
    ExpectSame(*mine, *LoadImageLibrary().Open("png", path_));
    for (const auto& [name, value] : Attributes(contents))
        if (name != "samplesPerPixel") {
            EXPECT_TRUE(Attributes(mine->Contents())[name] == value) << name;
        }
}

TEST_F(PngFile, KeepsWhereACropIs) {
    ImageContents contents = Contents();
    contents.origin = {7, 11};
    std::vector<uint8_t> values(4 * 15);
    Write(EncodePng(contents, values.data()));
    EXPECT_EQ(OpenPng(path_)->Contents().origin, Int2(7, 11));
    ExpectSame(*OpenPng(path_), *LoadImageLibrary().Open("png", path_));
}

// Nothing is printed, nothing is left open, and what libpng says comes back.
TEST_F(PngFile, WhatIsWrongIsTold) {
    Png png{40, 40, 8, 2};
    Rng rng(1);
    png.rows = RandomRows(png, 24, &rng);
    const std::string file = png.File();
    testing::internal::CaptureStderr();
    constexpr size_t kEnd = 16;  // the last chunk, and a checksum, which libpng asks for with the next chunk
    for (size_t length = 8; length < file.size() - kEnd; length += 97) {
        Write(file.substr(0, length));
        EXPECT_THROW(ValuesOf<uint8_t>(*OpenPng(path_)), std::runtime_error) << length;
    }
    EXPECT_THROW(OpenPng((path_ / "missing").string()), std::runtime_error);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    Write(file);
    const auto reader = OpenPng(path_);
    std::vector<float> floats(40 * 40 * 3);
    EXPECT_THROW(reader->Read(ValueType::Float, floats.data()), std::invalid_argument);
    ImageContents contents = Contents();
    contents.channels = {"a", "b", "c", "d", "e"};
    EXPECT_THROW(EncodePng(contents, nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace lacquer::png_file_test
