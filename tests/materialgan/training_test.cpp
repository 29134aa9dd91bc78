// Training of the autoencoder whose decoder is the generator.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include <filesystem>

#include "materialgan/train.h"
#include "materialgan/training/trainer.h"
#include "pbrt/core/clock.h"

namespace lacquer::materialgan::training_test {
namespace {

const GeneratorConfig kSmall{
    .resolution = 32, .mapsMax = 24, .mapsBase = 384, .latentSize = 24, .mappingLayers = 2};

std::string TemporaryPath(const std::string& name) {
    return (std::filesystem::temp_directory_path() /
            fmt::format("lacquer-training-test-{}-{}.safetensors", name, ::getpid()))
        .string();
}

bool AreEqual(const TensorMap& a, const TensorMap& b) {
    if (a.size() != b.size()) return false;
    for (const auto& [name, tensor] : a)
        if (!torch::equal(tensor, b.at(name))) return false;
    return true;
}

// Of the loss, which is over random materials and noise, in the mean over a quarter of the steps each.
TEST(Trainer, LossFalls) {
    ConfigureTorch(1);
    Trainer trainer(kSmall, 8, 1);
    double early = 0, late = 0;
    for (int step = 0; step < 60; ++step) {
        const LadderLoss loss = trainer.Step(step / 60.);
        if (step < 15) early += loss.rmse;
        if (step >= 45) late += loss.rmse;
    }
    EXPECT_LT(late, 0.5 * early);
}

// What was stored after three steps and loaded goes on as if nothing had been.
TEST(Trainer, ResumedIsTheSame) {
    ConfigureTorch(1);
    Trainer whole(kSmall, 4, 7), first(kSmall, 4, 7);
    for (int step = 0; step < 6; ++step) {
        whole.Step(step / 6.);
        if (step < 3) first.Step(step / 6.);
    }
    const std::string path = TemporaryPath("resume");
    first.Save(path);
    Trainer second = Trainer::Load(path);
    std::filesystem::remove(path);
    EXPECT_EQ(second.NumSteps(), 3);
    for (int step = 3; step < 6; ++step) second.Step(step / 6.);
    const GeneratorFile a = whole.Average(32), b = second.Average(32);
    EXPECT_TRUE(AreEqual(a.generator, b.generator));
    EXPECT_TRUE(AreEqual(*a.encoder, *b.encoder));
    EXPECT_TRUE(torch::equal(a.meanW, b.meanW));
    // Negative control: another seed gives others.
    Trainer other(kSmall, 4, 8);
    for (int step = 0; step < 6; ++step) other.Step(step / 6.);
    EXPECT_FALSE(AreEqual(a.generator, other.Average(32).generator));
}

}  // namespace
}  // namespace lacquer::materialgan::training_test
