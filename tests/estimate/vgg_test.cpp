// The network's summaries with small random weights, and files of tensors that are not as they should be.
#include "estimate/summary/vgg.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "estimate/gradient_check.h"
#include "pbrt/core/error.h"
#include "pbrt/image/half.h"

namespace lacquer::estimate::vgg_test {
namespace {

constexpr std::array<size_t, 5> kChannels{4, 5, 6, 7, 8};
constexpr int kConvolutions[] = {0, 2, 5, 7, 10, 12, 14, 16, 19, 21, 23, 25, 28, 30, 32, 34};
constexpr int kLastOfBlock[] = {2, 7, 16, 25, 34};

std::string TemporaryPath(const std::string& name) { return testing::TempDir() + "lacquer_" + name; }

void WriteFile(const std::string& path, const std::string& header, const std::string& numbers) {
    std::ofstream out(path, std::ios::binary);
    const uint64_t length = header.size();
    out.write(reinterpret_cast<const char*>(&length), sizeof length);
    out << header << numbers;
}

/// A file with random weights of the small network. @param change  of its header
std::string WriteNetwork(const std::string& name, bool isHalf,
                         const std::function<void(std::string*)>& change = {}) {
    std::string header = "{\"__metadata__\":{\"format\":\"pt\"}", numbers;
    const auto add = [&](const std::string& tensor, const std::vector<size_t>& shape, uint64_t seed,
                         double scale) {
        size_t count = 1;
        std::string text;
        for (const size_t n : shape) {
            count *= n;
            text += fmt::format("{}{}", text.empty() ? "" : ",", n);
        }
        const size_t begin = numbers.size();
        for (const double v : RandomNumbers(count, seed, -scale, scale)) {
            const float f = HalfToFloat(FloatToHalf(float(v)));
            const uint16_t half = FloatToHalf(f);
            if (isHalf)
                numbers.append(reinterpret_cast<const char*>(&half), 2);
            else
                numbers.append(reinterpret_cast<const char*>(&f), 4);
        }
        header += fmt::format(",\"{}\":{{\"dtype\":\"{}\",\"shape\":[{}],\"data_offsets\":[{},{}]}}", tensor,
                              isHalf ? "F16" : "F32", text, begin, numbers.size());
    };
    size_t in = 3, block = 0;
    for (const int index : kConvolutions) {
        const size_t out = kChannels[block];
        add(fmt::format("features.{}.weight", index), {out, in, 3, 3}, uint64_t(index), 0.6);
        add(fmt::format("features.{}.bias", index), {out}, uint64_t(index) + 100, 0.2);
        in = out;
        block += index == kLastOfBlock[block];
    }
    header += "}";
    if (change) change(&header);
    const std::string path = TemporaryPath(name);
    WriteFile(path, header, numbers);
    return path;
}

void Replace(std::string* text, const std::string& from, const std::string& to) {
    const size_t at = text->find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text->replace(at, from.size(), to);
}

std::string MessageOf(const std::string& path) {
    try {
        VggWeights::Read(path, kChannels);
    } catch (const FileError& e) {
        return e.Problem();
    }
    return "";
}

TEST(Vgg, GradientIsThatOfDifferences) {
    const MapGrid grid{64, 16, false};
    SummarySet set({"vgg"}, grid, VggWeights::Read(WriteNetwork("vgg", false), kChannels));
    ASSERT_EQ(set.Size(), 200u);
    PlanarImage image(grid.size);
    image.values = RandomNumbers(image.values.size(), 2, 0, 1);
    const auto weights = RandomNumbers(set.Size(), 8, -1, 1);
    const auto f = [&](std::span<const double> x) {
        PlanarImage moved(grid.size);
        moved.values.assign(x.begin(), x.end());
        std::vector<double> values(set.Size());
        set.Forward(moved, values);
        return Dot(values, weights);
    };
    f(image.values);
    auto gradient = set.Backward(weights).values;
    // Rectifiers have kinks: steps that meet few, and rounding of 1e-15 over them.
    EXPECT_LT(GradientError(f, image.values, gradient, 1e-7, 3), 1e-5);
    for (double& g : gradient) g *= 1.001;
    EXPECT_GT(GradientError(f, image.values, gradient, 1e-7, 3), 1e-4);
}

// The first convolution of a single bright pixel is its filter, turned by half a turn, and zeros are beyond
// the border.
TEST(Vgg, WeightsStandWhereTheyShould) {
    const auto weights = VggWeights::Read(WriteNetwork("vgg", false), kChannels);
    ASSERT_EQ(weights->layers.size(), 16u);
    // Tensor [out 2, in 1, row 0, column 2] of the first layer.
    const auto raw = RandomNumbers(4 * 3 * 9, 0, -0.6, 0.6);
    EXPECT_EQ(weights->layers[0].weights(2, 2 * 3 + 1),
              double(HalfToFloat(FloatToHalf(float(raw[(2 * 3 + 1) * 9 + 2])))));
    EXPECT_EQ(weights->layers[15].weights.rows(), 8);
    EXPECT_EQ(weights->layers[15].weights.cols(), 72);
}

TEST(Vgg, HalfPrecisionGivesTheSameWeights) {
    const auto single = VggWeights::Read(WriteNetwork("vgg", false), kChannels);
    const auto half = VggWeights::Read(WriteNetwork("vgg_half", true), kChannels);
    for (size_t i = 0; i < 16; ++i) EXPECT_EQ(single->layers[i].weights, half->layers[i].weights);
}

TEST(Vgg, BadFilesAreNamed) {
    EXPECT_EQ(
        MessageOf(WriteNetwork(
            "bad", false, [](std::string* h) { Replace(h, "features.21.weight", "features.22.weight"); })),
        "has no tensor \"features.21.weight\"");
    EXPECT_EQ(
        MessageOf(WriteNetwork("bad", false, [](std::string* h) { Replace(h, "[4,3,3,3]", "[4,3,3,1]"); })),
        "has tensor \"features.0.weight\" of shape 4 x 3 x 3 x 1, and 4 x 3 x 3 x 3 is needed");
    EXPECT_EQ(MessageOf(WriteNetwork("bad", false, [](std::string* h) { Replace(h, "F32", "I64"); })),
              "has tensor \"features.0.weight\" of type I64; known are F32 and F16");
    EXPECT_EQ(
        MessageOf(WriteNetwork("bad", false, [](std::string* h) { Replace(h, "\"shape\"", "\"shepe\""); })),
        "says of tensor \"features.0.weight\" not what one needs: dtype, shape and data_offsets");
    EXPECT_EQ(
        MessageOf(WriteNetwork("bad", false, [](std::string* h) { Replace(h, "[0,432]", "[0,999999999]"); })),
        "has tensor \"features.0.weight\" in bytes 0 to 999999999 of 23736");
    EXPECT_EQ(MessageOf(WriteNetwork("bad", false, [](std::string* h) { Replace(h, "{", "["); })),
              "is no file of tensors (safetensors): its header is not JSON");
    const std::string path = TemporaryPath("bad");
    std::ofstream(path, std::ios::binary) << "short";
    EXPECT_EQ(MessageOf(path), "is too short for a file of tensors (safetensors)");
    std::ofstream(path, std::ios::binary) << std::string("\0\x10\0\0\0\0\0\0{}", 10);
    EXPECT_EQ(MessageOf(path), "is cut off: its header has 4096 bytes, and 2 are there");
    std::ofstream(path, std::ios::binary) << "\x89PNG\r\n\x1a\n, and more";
    EXPECT_TRUE(MessageOf(path).starts_with("is no file of tensors (safetensors): its header would have "));
    EXPECT_THROW(VggWeights::Read(TemporaryPath("nowhere")), FileError);
}

TEST(Vgg, NeedsItsWeights) {
    try {
        SummarySet({"vgg"}, {64, 16, false});
        FAIL();
    } catch (const std::invalid_argument& e) {
        EXPECT_STREQ(e.what(), "summaries \"vgg\" need a file of weights");
    }
}

}  // namespace
}  // namespace lacquer::estimate::vgg_test
