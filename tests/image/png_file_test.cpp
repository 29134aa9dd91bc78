// PNG files against OpenImageIO's reader and writer of them.
#include "pbrt/image/png_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "image/image_reader_checks.h"
#include "image/png_bytes.h"
#include "pbrt/core/rng.h"
#include "pbrt/image/image.h"

namespace lacquer::png_file_test {
namespace {

using namespace png_bytes;

namespace fs = std::filesystem;

class PngFile : public ImageFileTest {
  protected:
    PngFile() : ImageFileTest("png") {}
};

std::string FileOf(const Png& png, const std::string& before) {
    return png.File(before + Chunk("IDAT", Zipped(png.rows)));
}

char RandomByte(Rng* rng) { return char(int(rng->Uniform() * 256)); }

/// Random pixels whose rows have all five filters.
std::string RandomRows(Png png, int bitsPerPixel, Rng* rng) {
    std::string rows(NumRowBytes(png.width, png.height, bitsPerPixel, png.interlace), '\0');
    for (char& c : rows) c = RandomByte(rng);
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
    ExpectSameLayout(a, b);
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
                    for (int i = 0; i < 3 << kind.bits; ++i) png.palette += RandomByte(&rng);
                png.rows = RandomRows(png, kind.bitsPerPixel, &rng);
                if (interlace)  // any byte may be a filter there: all bytes are valid ones
                    for (char& c : png.rows) c = char((unsigned char)(c) % 5);
                const std::string trns = kind.transparent.empty() ? "" : Chunk("tRNS", kind.transparent);
                Write(FileOf(png, trns));
                SCOPED_TRACE(testing::Message()
                             << "type " << int(kind.type) << ", " << int(kind.bits) << " bits, " << width
                             << " wide, " << (interlace ? "interlaced" : "rows"));
                const auto mine = OpenPng(path_);
                ASSERT_TRUE(mine);
                ExpectSame(*mine, *LoadImageLibrary().Open("png", path_));
            }
}

/// Rows without filters, some of whose pixels are of the colour that is transparent, and some of its
/// neighbours.
TEST_F(PngFile, OneColourIsTransparentAsInOpenImageIO) {
    struct Case {
        char bits, type;
        std::string colour, row;  // of tRNS, and three pixels of which the second has it
    };
    const std::string wide("\0\1\0\2\0\3", 6);
    for (const Case& c :
         {Case{1, 0, std::string("\0\1", 2), "\x40"}, Case{2, 0, std::string("\0\2", 2), "\x24"},
          Case{4, 0, std::string("\0\7", 2), std::string("\x67\x80", 2)},
          Case{8, 0, std::string("\0\7", 2), "\6\7\10"}, Case{16, 0, std::string("\1\7", 2), "\1\6\1\7\2\7"},
          Case{8, 2, wide, "\1\2\4\1\2\3\1\3\3"},
          Case{16, 2, wide, wide.substr(0, 5) + "\4" + wide + wide.substr(0, 5) + "\2"}}) {
        Png png{3, 2, c.bits, c.type};
        for (int row = 0; row < 2; ++row) png.rows += std::string(1, '\0') + c.row;
        Write(FileOf(png, Chunk("tRNS", c.colour)));
        SCOPED_TRACE(testing::Message() << int(c.type) << " " << int(c.bits));
        const auto mine = OpenPng(path_);
        ASSERT_TRUE(mine->Contents().channels.back() == "A");
        ExpectSame(*mine, *LoadImageLibrary().Open("png", path_));
        if (mine->Contents().type == ValueType::UInt8) {
            const std::vector<uint8_t> values = ValuesOf<uint8_t>(*OpenPng(path_));
            const size_t n = mine->Contents().channels.size();
            EXPECT_EQ(values[n - 1], 255);
            EXPECT_EQ(values[2 * n - 1], 0);
            EXPECT_EQ(values[3 * n - 1], 255);
        }
    }
}

TEST_F(PngFile, IndicesBeyondThePaletteAreAsInOpenImageIO) {
    Png png{4, 2, 8, 3};
    png.palette = "abcdef";
    png.rows = std::string("\0\0\1\2\xff\0\3\1\0\7", 10);
    Write(png.File());
    ExpectSame(*OpenPng(path_), *LoadImageLibrary().Open("png", path_));
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
    Write(FileOf(png, Chunk("gAMA", Number(100000)) +
                          Chunk("iCCP", std::string("p\0\0", 3) + Zipped("no profile")) +
                          Chunk("bKGD", std::string(6, '\1')) + Chunk("sBIT", "\5\6\5")));
    EXPECT_EQ(ValuesOf<uint8_t>(*OpenPng(path_)), plain);
    ExpectSame(*OpenPng(path_), *LoadImageLibrary().Open("png", path_));
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
    Write(png.File(Chunk("iTXt", std::string("xml:COM.adobe.xmp\0\0\0\0\0<x/>", 26)) + pixels));
    EXPECT_FALSE(OpenPng(path_));
    Write(png.File(Chunk("tEXt", std::string("Raw profile type exif\0x", 23)) + pixels));
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
        for (uint8_t& v : values) v = uint8_t(RandomByte(&rng));
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

// What says how another file is stored, or in what space its values were, is not true of this one.
TEST_F(PngFile, HasNotesOfItsOwnOnly) {
    std::string tooLong;
    tooLong.resize(9000000, 'x');
    ImageContents contents = Contents();
    contents.attributes = {{"oiio:ColorSpace", std::string("linear")},
                           {"compression", std::string("zip")},
                           {"planarconfig", std::string("contig")},
                           {"", std::string("nameless")},
                           {"\1 ", std::string("blank")},
                           {"long", tooLong},
                           {std::string(200, 'k'), std::string("v")},
                           {"ResolutionUnit", std::string("cm")},
                           {"XResolution", 50.f},
                           {"YResolution", 25.f},
                           {"DateTime", std::string("1999:12:31 23:59:60")}};
    std::vector<uint8_t> values(4 * 15);
    const std::vector<unsigned char> bytes = EncodePng(contents, values.data());
    EXPECT_EQ(EncodePng(contents, values.data()), bytes);
    Write(bytes);
    const std::map<std::string, MetadataValue> expected = {{std::string(79, 'k'), std::string("v")},
                                                           {"ResolutionUnit", std::string("inch")},
                                                           {"XResolution", 127.f},
                                                           {"YResolution", 63.5f},
                                                           {"PixelAspectRatio", 0.5f},
                                                           {"DateTime", std::string("1999:12:31 23:59:60")}};
    EXPECT_TRUE(Attributes(OpenPng(path_)->Contents()) == expected);
    EXPECT_NO_THROW(ReadImage(path_, {}, {}));
    std::map<std::string, MetadataValue> theirs =
        Attributes(LoadImageLibrary().Open("png", path_)->Contents());
    std::erase_if(theirs, [](const auto& entry) { return entry.first.starts_with("oiio:"); });
    EXPECT_TRUE(theirs == expected);
    for (const std::string date : {"no date", "2020:13:01 00:00:00", "2020:-1:01 00:00:00"}) {
        contents.attributes = {{"DateTime", date}};
        Write(EncodePng(contents, values.data()));
        EXPECT_TRUE(OpenPng(path_)->Contents().attributes.empty()) << date;
    }
}

TEST_F(PngFile, NamelessTextsAreLeftOut) {
    Png png;
    png.rows = std::string(30, '\0');
    Write(FileOf(png, Chunk("tEXt", std::string("\0abc", 4)) + Chunk("tEXt", std::string("k\0v", 3))));
    const std::map<std::string, MetadataValue> expected = {{"k", std::string("v")}};
    EXPECT_TRUE(Attributes(OpenPng(path_)->Contents()) == expected);
}

// Texts that unpack to more than the file lets expect: the first ones are kept, as far as they are not long.
TEST_F(PngFile, TextsTakeBoundedMemory) {
    Png png;
    png.rows = std::string(30, '\0');
    std::string texts;
    for (int i = 0; i < 200; ++i)
        texts += Chunk("zTXt",
                       "k" + std::to_string(i) + std::string("\0\0", 2) + Zipped(std::string(1000000, 'x')));
    texts += Chunk("zTXt", std::string("long\0\0", 6) + Zipped(std::string(7000000, 'x')));
    Write(FileOf(png, texts));
    const auto reader = OpenPng(path_);
    EXPECT_GT(reader->Contents().attributes.size(), 10u);
    EXPECT_LT(reader->Contents().attributes.size(), 40u);
    EXPECT_EQ(ValuesOf<uint8_t>(*reader), std::vector<uint8_t>(27));
}

size_t NumOpenFiles() {
    return size_t(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

TEST_F(PngFile, KeepsWhereACropIs) {
    ImageContents contents = Contents();
    contents.origin = {7, -11};
    std::vector<uint8_t> values(4 * 15);
    Write(EncodePng(contents, values.data()));
    EXPECT_EQ(OpenPng(path_)->Contents().origin, Int2(7, -11));
    ExpectSame(*OpenPng(path_), *LoadImageLibrary().Open("png", path_));
}

// Nothing is printed, nothing is left open, and what libpng says comes back.
TEST_F(PngFile, WhatIsWrongIsTold) {
    Png png{40, 40, 8, 2};
    Rng rng(1);
    png.rows = RandomRows(png, 24, &rng);
    const std::string file = png.File();
    testing::internal::CaptureStderr();
    const size_t numOpen = NumOpenFiles();
    constexpr size_t kEnd = 16;  // the last chunk, and a checksum, which libpng asks for with the next chunk
    for (size_t length = 8; length < file.size() - kEnd; length += 97) {
        Write(file.substr(0, length));
        EXPECT_THROW(ValuesOf<uint8_t>(*OpenPng(path_)), std::runtime_error) << length;
    }
    EXPECT_THROW(OpenPng((path_ / "missing").string()), std::runtime_error);
    EXPECT_EQ(NumOpenFiles(), numOpen);
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
