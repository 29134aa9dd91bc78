// The generator against a straightforward one in another language (make_reference.py).
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include "materialgan/network/stylegan.h"
#include "materialgan/network/upsampling.h"

namespace lacquer::materialgan::generator_test {
namespace {

class Reference {
  public:
    Reference() : file_(LACQUER_SOURCE_DIR "/tests/materialgan/data/generator_reference.safetensors") {
        config = GeneratorConfig::FromMetadata(file_.Metadata(), file_.Path());
        parameters = ReadTensors(file_, GeneratorTensors(config));
        for (auto& [name, tensor] : parameters) tensor.requires_grad_();
        for (int i = 0; i < config.NumLayers(); ++i)
            noise.push_back(Get(fmt::format("check.noise{}", i)).requires_grad_());
    }
    Tensor Get(const std::string& name) const { return ReadTensor(file_, name, file_.ShapeOf(name)); }

    GeneratorConfig config;
    TensorMap parameters;
    std::vector<Tensor> noise;

  private:
    SafetensorsFile file_;
};

/// Largest difference, of the largest value.
double RelativeError(const Tensor& found, const Tensor& wanted) {
    EXPECT_EQ(found.sizes(), wanted.sizes());
    return ((found - wanted).abs().max() / wanted.abs().max()).item<double>();
}

/// Sums of up to 9 * 12 products in single precision, eight layers of them: some 100 roundings of 6e-8.
constexpr double kSinglePrecision = 1e-5;

TEST(StyleGenerator, GivesWhatThePaperSays) {
    const Reference reference;
    const StyleGenerator generator(reference.config, reference.parameters);
    EXPECT_LT(RelativeError(generator.Map(reference.Get("check.z")), reference.Get("check.w")),
              kSinglePrecision);
    const Tensor wPlus = reference.Get("check.wPlus"), wanted = reference.Get("check.image");
    EXPECT_LT(RelativeError(generator.Synthesize(wPlus, reference.noise), wanted), kSinglePrecision);
    // Negative control: another column of w+ for the last colours is found.
    Tensor wrong = wPlus.clone();
    wrong.select(1, reference.config.NumLayers()).mul_(1.01);
    EXPECT_GT(RelativeError(generator.Synthesize(wrong, reference.noise), wanted), 100 * kSinglePrecision);
}

TEST(StyleGenerator, GradientsAreThoseOfThePaper) {
    const Reference reference;
    const StyleGenerator generator(reference.config, reference.parameters);
    const Tensor z = reference.Get("check.z").requires_grad_(),
                 wPlus = reference.Get("check.wPlus").requires_grad_();
    const Tensor image = generator.Synthesize(wPlus, reference.noise);
    ((image * reference.Get("check.weights")).sum() + generator.Map(z).square().sum()).backward();
    EXPECT_LT(RelativeError(z.grad(), reference.Get("gradient.check.z")), kSinglePrecision);
    EXPECT_LT(RelativeError(wPlus.grad(), reference.Get("gradient.check.wPlus")), kSinglePrecision);
    for (size_t i = 0; i < reference.noise.size(); ++i)
        EXPECT_LT(
            RelativeError(reference.noise[i].grad(), reference.Get(fmt::format("gradient.check.noise{}", i))),
            kSinglePrecision);
    for (const auto& [name, tensor] : reference.parameters)
        EXPECT_LT(RelativeError(tensor.grad(), reference.Get("gradient." + name)), kSinglePrecision) << name;
}

TEST(StyleGenerator, KeptKernelsChangeNothing) {
    const Reference reference;
    StyleGenerator generator(reference.config, reference.parameters);
    const Tensor wPlus = reference.Get("check.wPlus");
    const Tensor before = generator.Synthesize(wPlus, reference.noise);
    generator.KeepKernels();
    EXPECT_TRUE(torch::equal(generator.Synthesize(wPlus, reference.noise), before));
}

// With noise for one image, or the same for each.
TEST(StyleGenerator, NoiseMayBeShared) {
    const Reference reference;
    const StyleGenerator generator(reference.config, reference.parameters);
    const Tensor wPlus = reference.Get("check.wPlus");
    std::vector<Tensor> one, two;
    for (const Tensor& map : generator.RandomNoise(1, SeededGenerator(1))) {
        one.push_back(map);
        two.push_back(map.expand({2, -1, -1, -1}));
    }
    EXPECT_LT(RelativeError(generator.Synthesize(wPlus, one), generator.Synthesize(wPlus, two)), 1e-6);
}

TEST(GeneratorConfig, HasTheShapeOfThePublishedNetwork) {
    const GeneratorConfig config{.resolution = 256,
                                 .mapsMax = 512,
                                 .mapsBase = 32768,
                                 .latentSize = 512,
                                 .mappingLayers = 8,
                                 .lrMultiplier = 0.01};
    EXPECT_EQ(config.NumLayers(), 13);
    EXPECT_EQ(config.NumColumns(), 14);
    EXPECT_EQ(config.NumFeatureMaps(64), 512);
    EXPECT_EQ(config.NumFeatureMaps(256), 128);
    size_t parameters = 0;
    for (const TensorSpec& spec : GeneratorTensors(config)) {
        size_t count = 1;
        for (const size_t n : spec.shape) count *= n;
        parameters += count;
    }
    EXPECT_NEAR(double(parameters), 30.0e6, 0.1e6);
    EXPECT_EQ(GeneratorConfig::FromMetadata(config.ToMetadata(), "x"), config);
}

TEST(GeneratorConfig, WrongMetadataAreNamed) {
    const auto message = [](const std::string& key, const std::string& value) -> std::string {
        auto metadata = GeneratorConfig().ToMetadata();
        if (value.empty())
            metadata.erase(key);
        else
            metadata[key] = value;
        try {
            GeneratorConfig::FromMetadata(metadata, "f");
        } catch (const FileError& e) {
            return e.Message();
        }
        return "none";
    };
    EXPECT_EQ(message("format", "other"),
              "f: is no generator: its format is \"other\", and \"lacquer-stylegan2\" is needed");
    EXPECT_EQ(message("wDim", ""), "f: does not say \"wDim\"");
    EXPECT_EQ(message("wDim", "1e9"), "f: says \"wDim\" is \"1e9\", and a number from 1 to 4096 is needed");
    EXPECT_EQ(message("wDim", "nan"), "f: says \"wDim\" is \"nan\", and a number from 1 to 4096 is needed");
    EXPECT_EQ(message("wDim", "2.5"), "f: says \"wDim\" is 2.5, and a whole number is needed");
    EXPECT_EQ(message("resolution", "48"), "f: has resolution 48, which is no power of two");
}

}  // namespace
}  // namespace lacquer::materialgan::generator_test
