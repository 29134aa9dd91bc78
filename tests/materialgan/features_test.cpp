// Features of VGG-19 against PyTorch's modules (make_reference.py), and what a fit makes of features.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include "materialgan/fit/fit_target.h"
#include "materialgan/fit/vgg_features.h"

namespace lacquer::materialgan::features_test {
namespace {

constexpr const char* kVggReference = LACQUER_SOURCE_DIR "/tests/materialgan/data/vgg_reference.safetensors";
constexpr std::array<size_t, 5> kFewChannels{4, 5, 6, 7, 8};
constexpr int64_t kReferenceChannels[] = {4, 4, 6, 7}, kReferenceSizes[] = {16, 16, 4, 2};

Tensor Get(const SafetensorsFile& file, const std::string& name) {
    return ReadTensor(file, name, file.ShapeOf(name));
}

/// Largest difference, of the largest value.
double RelativeError(const Tensor& found, const Tensor& wanted) {
    EXPECT_EQ(found.sizes(), wanted.sizes());
    return ((found - wanted).abs().max() / wanted.abs().max()).item<double>();
}

// Ten layers of up to 63 products in single precision: some 100 roundings of 6e-8.
TEST(VggFeatures, AreThoseOfTheNetworkAndSoAreTheirGradients) {
    const SafetensorsFile reference(kVggReference);
    const VggFeatures features(kVggReference, kFewChannels);
    const Tensor images = Get(reference, "check.images").requires_grad_();
    const std::vector<Tensor> found = features(images);
    ASSERT_EQ(found.size(), 4u);
    Tensor sum = torch::zeros({});
    for (size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].size(1), kReferenceChannels[i]);
        EXPECT_EQ(found[i].size(2), kReferenceSizes[i]);
        EXPECT_LT(RelativeError(found[i], Get(reference, fmt::format("check.features{}", i))), 1e-5) << i;
        sum = sum + (found[i] * Get(reference, fmt::format("check.weights{}", i))).sum();
    }
    sum.backward();
    EXPECT_LT(RelativeError(images.grad(), Get(reference, "gradient.check.images")), 1e-5);
    // Negative control: colours in another order are found.
    EXPECT_GT(RelativeError(features(images.flip(1))[3], Get(reference, "check.features3")), 1e-3);
}

TEST(VggFeatures, WrongFilesAreNamed) {
    const auto message = [](const std::string& path, const std::array<size_t, 5>& channels) -> std::string {
        try {
            const VggFeatures features(path, channels);
        } catch (const FileError& e) {
            return e.Problem();
        }
        return "none";
    };
    EXPECT_EQ(message(kVggReference, kVggChannels),
              "has tensor \"features.0.weight\" of shape 4 x 3 x 3 x 3, and 64 x 3 x 3 x 3 is needed");
    EXPECT_EQ(
        message(LACQUER_SOURCE_DIR "/tests/materialgan/data/generator_reference.safetensors", kFewChannels),
        "has no tensor \"features.0.weight\"");
}

TEST(SetFeatures, KnowsNamesAndTakesTheRestForFiles) {
    LatentFitOptions options;
    SetFeatures("steerable", &options);
    EXPECT_EQ(options.features, FitFeatures::Steerable);
    SetFeatures("vgg.safetensors", &options);
    EXPECT_EQ(options.features, FitFeatures::Vgg);
    EXPECT_EQ(options.featuresFile, "vgg.safetensors");
    SetFeatures("none", &options);
    EXPECT_EQ(options.features, FitFeatures::None);
    EXPECT_EQ(options.featuresFile, "");
}

// [Guo et al. 2020b], eq. 4: for w+ the weights are 1, 1, 4, 8 of their sum, for noise 8, 8, 2, 1, squared
// with the differences, and the mean is over all features.
TEST(PhotoObjective, WeighsLevelsOfFeaturesByWhatMoves) {
    FitInput input;
    input.views.size = 10;
    input.views.views.push_back({"", {0, 0, 16}, {0, 0, 16}, false});
    input.images.emplace_back(16);
    for (double& value : input.images[0].values) value = 0.3;
    const FitTarget target = TargetOf(input, false);
    const VggFeatures features(kVggReference, kFewChannels);
    const PhotoObjective pixels(target, {}, 1, 0), both(target, features, 1, 0.1);
    const Tensor maps = ToTensor(capture::ConstantMaps(16)).unsqueeze(0);
    const std::vector<Tensor> found = features(RenderEncoded(maps, target.views)[0]),
                              wanted = features(target.images);
    constexpr double kW[] = {1 / 14., 1 / 14., 4 / 14., 8 / 14.},
                     kNoise[] = {8 / 19., 8 / 19., 2 / 19., 1 / 19.};
    double ofW = 0, ofNoise = 0;
    int64_t count = 0;
    for (size_t i = 0; i < 4; ++i) {
        const double squares = (found[i] - wanted[i]).square().sum().item<double>();
        ofW += kW[i] * kW[i] * squares;
        ofNoise += kNoise[i] * kNoise[i] * squares;
        count += found[i].numel();
    }
    const double base = pixels.Evaluate(maps, FitPhase::W).loss.item<double>();
    EXPECT_GT(ofW, 0);
    EXPECT_NEAR(both.Evaluate(maps, FitPhase::W).loss.item<double>(), base + 0.1 * ofW / double(count),
                1e-6 * base);
    EXPECT_NEAR(both.Evaluate(maps, FitPhase::Noise).loss.item<double>(),
                base + 0.1 * ofNoise / double(count), 1e-6 * base);
}

}  // namespace
}  // namespace lacquer::materialgan::features_test
