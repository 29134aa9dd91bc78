// Files of named tensors, written and read, and damaged ones.
#include "pbrt/image/safetensors.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>

namespace lacquer::safetensors_test {
namespace {

class File {
  public:
    File()
        : path((std::filesystem::temp_directory_path() /
                fmt::format("lacquer-{}-{}.safetensors",
                            testing::UnitTest::GetInstance()->current_test_info()->name(), ::getpid()))
                   .string()) {}
    ~File() { std::filesystem::remove(path); }
    /// A header and zeros behind it.
    void Write(const std::string& header, size_t numBytes) const {
        const uint64_t length = header.size();
        std::ofstream out(path, std::ios::binary);
        out.write(reinterpret_cast<const char*>(&length), sizeof length);
        out << header << std::string(numBytes, '\0');
    }
    std::string MessageOf(const std::string& name, const std::vector<size_t>& shape) const {
        try {
            SafetensorsFile(path).Read(name, shape);
        } catch (const FileError& e) {
            return e.Problem();
        }
        return "none";
    }
    const std::string path;
};

TEST(Safetensors, ComeBackAsTheyWere) {
    const File file;
    const std::vector<NamedTensor> tensors = {
        {"matrix", {2, 3}, {1, -2, 3.5f, 4, 5, 6e-3f}}, {"none", {0, 4}, {}}, {"number", {}, {7}}};
    WriteSafetensors(file.path, tensors, {{"format", "test"}});
    const SafetensorsFile read(file.path);
    EXPECT_EQ(read.Names(), (std::vector<std::string>{"matrix", "none", "number"}));
    EXPECT_EQ(read.Metadata().at("format"), "test");
    for (const NamedTensor& tensor : tensors) {
        EXPECT_EQ(read.ShapeOf(tensor.name), tensor.shape);
        EXPECT_EQ(read.Read(tensor.name, tensor.shape), tensor.values);
    }
    EXPECT_FALSE(read.Has("other"));
}

TEST(Safetensors, HalvesRoundToElevenBits) {
    const File file;
    WriteSafetensors(file.path, {{{"x", {3}, {1, 0.1f, -1000.3f}}}}, {}, /*half=*/true);
    const std::array<size_t, 1> shape{3};
    const std::vector<float> values = SafetensorsFile(file.path).Read("x", shape);
    EXPECT_EQ(values[0], 1);
    EXPECT_NEAR(values[1], 0.1f, 0.1f / 2048);
    EXPECT_NEAR(values[2], -1000.3f, 1000.3f / 2048);
}

TEST(Safetensors, SaysWhatIsWrong) {
    const File file;
    file.Write(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]},)"
               R"("b":{"dtype":"F32","shape":[2],"data_offsets":[4,12]}})",
               12);
    EXPECT_EQ(file.MessageOf("a", {2}), "has tensors \"a\" and \"b\" in the same bytes");
    file.Write(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]}})", 4);
    EXPECT_EQ(file.MessageOf("a", {2}), "has tensor \"a\" in bytes 0 to 8 of 4");
    file.Write(R"({"a":{"dtype":"F32","shape":[3],"data_offsets":[0,8]}})", 8);
    EXPECT_EQ(file.MessageOf("a", {3}), "has 8 bytes of tensor \"a\" of shape 3 and type F32");
    EXPECT_EQ(file.MessageOf("a", {2}), "has tensor \"a\" of shape 3, and 2 is needed");
    EXPECT_EQ(file.MessageOf("b", {2}), "has no tensor \"b\"");
    file.Write(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[8,0]}})", 8);
    EXPECT_EQ(file.MessageOf("a", {2}), "has tensor \"a\" in bytes 8 to 0 of 8");
    file.Write(R"({"a":{"dtype":"F32","shape":[-2],"data_offsets":[0,8]}})", 8);
    EXPECT_EQ(file.MessageOf("a", {2}),
              "says of tensor \"a\" not what one needs: dtype, shape and data_offsets");
    file.Write("{\"a\"", 8);
    EXPECT_EQ(file.MessageOf("a", {2}), "is no file of tensors (safetensors): its header is not JSON");
    file.Write(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]},)"
               R"("a":{"dtype":"F32","shape":[2],"data_offsets":[8,16]}})",
               16);
    EXPECT_EQ(file.MessageOf("a", {2}), "has tensor \"a\" twice");
    file.Write(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]}})", 13);
    EXPECT_EQ(file.MessageOf("a", {2}), "has 5 bytes behind its tensors, which end at 8");
}

// A header of a few megabytes may ask for gigabytes, or be quoted in the message.
TEST(Safetensors, HeadersAreNoLargerInMemoryThanTheyNeedToBe) {
    const File file;
    file.Write(std::string(1 << 20, '['), 0);
    EXPECT_EQ(file.MessageOf("a", {}),
              "is no file of tensors (safetensors): its header is nested too deeply");
    std::string ones = "1";
    for (int i = 1; i < 100000; ++i) ones += ",1";
    file.Write(fmt::format(R"({{"a":{{"dtype":"F32","shape":[{}],"data_offsets":[0,4]}}}})", ones), 4);
    EXPECT_EQ(file.MessageOf("a", {}), "has tensor \"a\" of 100000 dimensions, and the limit is 16");
}

// Sizes whose product wraps around to the number of bytes that are there.
TEST(Safetensors, HugeShapesDoNotWrapAround) {
    const File file;
    const size_t huge = size_t(1) << 62;
    file.Write(fmt::format(R"({{"a":{{"dtype":"F32","shape":[{},4],"data_offsets":[0,0]}}}})", huge), 0);
    EXPECT_TRUE(file.MessageOf("a", {huge, 4}).starts_with("has 0 bytes of tensor \"a\""));
}

TEST(Safetensors, NumbersMustBeFinite) {
    const File file;
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        WriteSafetensors(file.path, {{{"weight", {2}, {1, bad}}}}, {});
        EXPECT_EQ(file.MessageOf("weight", {2}), "has tensor \"weight\" with numbers that are not finite");
    }
}

}  // namespace
}  // namespace lacquer::safetensors_test
