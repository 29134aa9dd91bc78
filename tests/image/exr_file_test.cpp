// OpenEXR files against OpenImageIO's reader and writer of them.
#include "pbrt/image/exr_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "image/image_reader_checks.h"
#include "pbrt/core/rng.h"

namespace lacquer::exr_file_test {
namespace {

class ExrFile : public ImageFileTest {
  protected:
    ExrFile() : ImageFileTest("exr") {}
};

/// Windows that begin elsewhere, channels of both types in no order, and attributes of every type.
ImageContents Contents() {
    ImageContents contents;
    contents.resolution = {37, 131};  // not a whole number of packed blocks
    contents.origin = {-5, 7};
    contents.fullResolution = {60, 150};
    contents.channels = {"R", "G", "B", "A", "Z", "id", "Albedo.R", "Albedo.G", "Albedo.B", "Ns.X"};
    contents.type = ValueType::Half;
    for (const std::string& name : contents.channels)
        contents.channelTypes.push_back(name == "Z" || name == "id" ? ValueType::Float : ValueType::Half);
    glm::mat4 matrix(1);
    matrix[1][3] = 0.5f;
    matrix[3][0] = -2;
    contents.attributes = {
        {"samplesPerPixel", 16},
        {"renderTimeSeconds", 1.25f},
        {"scene", std::string("a \"scene\" of many characters, \xc3\xa9")},
        {"worldToCamera", matrix},
        {"wiDegrees", std::vector<float>{10, 20}},
        {"corner", std::vector<float>{1, 2, 3}},
        {"samples", std::vector<float>{1, 2, 3, 4, 5}},
        {"chromaticities", std::vector<float>{.64f, .33f, .3f, .6f, .15f, .06f, .31f, .33f}},
        {"DateTime", std::string("2020:02:02 02:02:02")},
        {"a name that is longer than thirty-one characters", 3}};
    return contents;
}

std::vector<float> RandomValues(const ImageContents& contents) {
    Rng rng(7);
    std::vector<float> values(contents.channels.size() * size_t(contents.resolution.x) *
                              size_t(contents.resolution.y));
    for (float& v : values) v = std::ldexp(rng.Uniform() - 0.5f, int(rng.Uniform() * 50) - 30);
    // What rounds to even, denormal halves, the largest one, and what is not finite.
    const float special[] = {0.f,      -0.f,       1 + 0x1p-11f, 1 + 0x3p-11f,
                             0x1p-24f, 0x1.8p-25f, 65504,        std::numeric_limits<float>::infinity()};
    std::copy(std::begin(special), std::end(special), values.begin());
    return values;
}

/// Those that OpenImageIO adds of its own are left out.
std::map<std::string, MetadataValue> Attributes(const ImageContents& contents) {
    std::map<std::string, MetadataValue> attributes(contents.attributes.begin(), contents.attributes.end());
    std::erase_if(attributes, [](const auto& entry) { return entry.first.starts_with("oiio:"); });
    return attributes;
}

/// Both readers see the same file.
void ExpectSame(ImageReader& mine, ImageReader& other) {
    const ImageContents &a = mine.Contents(), &b = other.Contents();
    ExpectSameLayout(a, b);
    EXPECT_TRUE(Attributes(a) == Attributes(b));
    std::vector<float> valuesA(a.channels.size() * size_t(a.resolution.x) * size_t(a.resolution.y)),
        valuesB = valuesA;
    mine.Read(ValueType::Float, valuesA.data());
    other.Read(ValueType::Float, valuesB.data());
    EXPECT_EQ(std::memcmp(valuesA.data(), valuesB.data(), sizeof(float) * valuesA.size()), 0);
}

TEST_F(ExrFile, IsReadByOpenImageIOAsItIsReadHere) {
    const ImageContents contents = Contents();
    const std::vector<float> values = RandomValues(contents);
    Write(EncodeExr(contents, values.data()));
    ExpectSame(*OpenExr(path_), *LoadImageLibrary().Open("openexr", path_));
}

TEST_F(ExrFile, HasWhatOpenImageIOWrites) {
    ImageContents contents = Contents();
    contents.attributes.emplace_back("compression", std::string("piz"));
    const std::vector<float> values = RandomValues(contents);
    Write(LoadImageLibrary().Encode(contents, values.data(), "exr", path_));
    const std::unique_ptr<ImageReader> theirs = OpenExr(path_);
    ExpectSame(*theirs, *LoadImageLibrary().Open("openexr", path_));
    std::vector<float> expected(values.size()), found(values.size());
    theirs->Read(ValueType::Float, expected.data());
    const std::map<std::string, MetadataValue> attributes = Attributes(theirs->Contents());

    Write(EncodeExr(contents, values.data()));
    const std::unique_ptr<ImageReader> ours = OpenExr(path_);
    ours->Read(ValueType::Float, found.data());
    EXPECT_EQ(std::memcmp(expected.data(), found.data(), sizeof(float) * found.size()), 0);
    EXPECT_TRUE(Attributes(ours->Contents()) == attributes);
    EXPECT_EQ(ours->Contents().channels, theirs->Contents().channels);
}

TEST_F(ExrFile, RowsAreThoseOfTheWhole) {
    const ImageContents contents = Contents();
    const std::vector<float> values = RandomValues(contents);
    Write(EncodeExr(contents, values.data()));
    const size_t row = contents.channels.size() * size_t(contents.resolution.x);
    std::vector<float> whole(values.size()), some(row * 16);
    OpenExr(path_)->Read(ValueType::Float, whole.data());
    const std::unique_ptr<ImageReader> reader = OpenExr(path_);
    for (int begin = 0; begin < contents.resolution.y; begin += 16) {
        const int end = std::min(begin + 16, contents.resolution.y);
        reader->ReadRows(begin, end, ValueType::Float, some.data());
        ASSERT_EQ(std::memcmp(some.data(), whole.data() + row * size_t(begin),
                              sizeof(float) * row * size_t(end - begin)),
                  0)
            << begin;
    }
}

TEST_F(ExrFile, PacksWithoutLossAndIsTheSameForTheSameImage) {
    ImageContents contents = Contents();
    contents.attributes = {{"compression", std::string("b44")},
                           {"channels", std::string("no list of channels")},
                           {"oiio:ColorSpace", std::string("Linear")}};
    const std::vector<float> values = RandomValues(contents);
    Write(EncodeExr(contents, values.data()));
    const std::map<std::string, MetadataValue> attributes = Attributes(OpenExr(path_)->Contents());
    EXPECT_TRUE(attributes.at("compression") == MetadataValue(std::string("zip")));
    EXPECT_EQ(attributes.size(), 4u);  // and the window of the screen, and the shape of pixels
    EXPECT_EQ(EncodeExr(contents, values.data()), EncodeExr(contents, values.data()));
}

TEST_F(ExrFile, IsRefusedIfItIsCutOrATextOrOfOtherValues) {
    const ImageContents contents = Contents();
    const std::vector<float> values = RandomValues(contents);
    const std::vector<unsigned char> bytes = EncodeExr(contents, values.data());
    std::vector<float> found(values.size());
    for (const size_t size : {size_t(0), size_t(3), size_t(200), bytes.size() / 2, bytes.size() - 1}) {
        Write(std::vector<unsigned char>(bytes.begin(), bytes.begin() + std::ptrdiff_t(size)));
        EXPECT_THROW(OpenExr(path_)->Read(ValueType::Float, found.data()), std::exception) << size;
    }
    std::ofstream(path_) << "no image, but a text";
    EXPECT_THROW(OpenExr(path_), std::exception);
    Write(bytes);
    EXPECT_THROW(OpenExr(path_)->Read(ValueType::Half, found.data()), std::logic_error);
    EXPECT_THROW(OpenExr(path_.string() + ".none"), std::exception);
}

}  // namespace
}  // namespace lacquer::exr_file_test
