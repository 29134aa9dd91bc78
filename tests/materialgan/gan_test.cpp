// The adversarial training: its penalties against finite differences, a few steps, and states.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include <cmath>
#include <filesystem>

#include "materialgan/network/upsampling.h"
#include "materialgan/train.h"
#include "materialgan/training/gan_losses.h"
#include "materialgan/training/gan_trainer.h"

namespace lacquer::materialgan::gan_test {
namespace {

const GeneratorConfig kTiny{
    .resolution = 16, .mapsMax = 12, .mapsBase = 128, .latentSize = 12, .mappingLayers = 2};
constexpr int kBatch = 4;

std::string TemporaryPath(const std::string& name) {
    return (std::filesystem::temp_directory_path() /
            fmt::format("lacquer-gan-test-{}-{}.safetensors", name, ::getpid()))
        .string();
}

bool AreEqual(const TensorMap& a, const TensorMap& b) {
    if (a.size() != b.size()) return false;
    for (const auto& [name, tensor] : a)
        if (!torch::equal(tensor, b.at(name))) return false;
    return true;
}

/// The parameters moved along `direction`.
TensorMap Moved(const TensorMap& parameters, const TensorMap& direction, double distance) {
    TensorMap moved;
    for (const auto& [name, tensor] : parameters)
        moved.emplace(name, tensor.detach() + distance * direction.at(name));
    return moved;
}

TensorMap Direction(const TensorMap& parameters, uint64_t seed) {
    torch::Generator random = SeededGenerator(seed);
    TensorMap direction;
    for (const auto& [name, tensor] : parameters)
        direction.emplace(name, NormalNumbers(tensor.sizes(), random).to(tensor.dtype()));
    return direction;
}

/// The derivative of `loss` along the direction, by its gradients with respect to the parameters.
double Slope(const Tensor& loss, const TensorMap& parameters, const TensorMap& direction) {
    loss.backward();
    double slope = 0;
    for (const auto& [name, tensor] : parameters)
        if (tensor.grad().defined()) slope += (tensor.grad() * direction.at(name)).sum().item<double>();
    return slope;
}

TensorMap DoubleDiscriminator() {
    TensorMap parameters;
    for (const auto& [name, tensor] : RandomDiscriminatorParameters(kTiny, SeededGenerator(1)))
        parameters.emplace(name, tensor.to(torch::kDouble).requires_grad_());
    return parameters;
}

Tensor RealMaps() { return TrainingBatch(kTiny.resolution, kBatch, 3, 0); }

// One group of four, by hand; three are a group as well, and one has no deviation.
TEST(Discriminator, KnowsHowMuchABatchVaries) {
    const Tensor x = torch::tensor({1., 5., 3., 1.}, torch::kDouble).view({4, 1, 1, 1}).expand({-1, 2, 3, 3});
    const Tensor y = AppendMinibatchDeviation(x);
    EXPECT_EQ(y.sizes(), torch::IntArrayRef({4, 3, 3, 3}));
    // The mean is 2.5, the variance (2.25 + 6.25 + 0.25 + 2.25) / 4.
    EXPECT_NEAR(y.select(1, 2).min().item<double>(), std::sqrt(2.75), 1e-6);
    EXPECT_NEAR(y.select(1, 2).max().item<double>(), std::sqrt(2.75), 1e-6);
    const Tensor three = AppendMinibatchDeviation(x.narrow(0, 0, 3));
    EXPECT_EQ(three.size(0), 3);
    EXPECT_NEAR(AppendMinibatchDeviation(x.narrow(0, 0, 1)).select(1, 2).max().item<double>(), 0, 1e-3);
}

/// Largest difference, of the largest value.
double RelativeError(const Tensor& found, const Tensor& wanted) {
    EXPECT_EQ(found.sizes(), wanted.sizes());
    const double largest = wanted.abs().max().item<double>(),
                 difference = (found - wanted).abs().max().item<double>();
    return largest > 0 ? difference / largest : difference;
}

// Against one in another language (make_reference.py), which filters by convolutions: values, derivatives,
// and those of the penalty. Ten layers in single precision; derivatives of derivatives add twice as many.
TEST(Discriminator, IsThatOfThePaper) {
    const SafetensorsFile file(LACQUER_SOURCE_DIR
                               "/tests/materialgan/data/discriminator_reference.safetensors");
    const auto get = [&](const std::string& name) { return ReadTensor(file, name, file.ShapeOf(name)); };
    TensorMap parameters = ReadTensors(file, DiscriminatorTensors(kTiny));
    for (auto& [name, tensor] : parameters) tensor.requires_grad_();
    const Discriminator discriminator(kTiny, parameters);
    const Tensor images = get("check.images").requires_grad_();
    const Tensor judged = discriminator.Judge(images);
    EXPECT_LT(RelativeError(judged, get("check.judged")), 1e-5);
    (judged * get("check.weights")).sum().backward();
    EXPECT_LT(RelativeError(images.grad(), get("gradient.check.images")), 1e-5);
    for (auto& [name, tensor] : parameters) {
        EXPECT_LT(RelativeError(tensor.grad(), get("gradient." + name)), 1e-5) << name;
        tensor.mutable_grad() = Tensor();
    }
    const Tensor penalty = GradientPenalty(discriminator, images);
    EXPECT_LT(RelativeError(penalty, get("check.penalty")), 1e-5);
    penalty.backward();
    for (const auto& [name, tensor] : parameters) {
        if (!file.Has("penalty." + name)) continue;
        EXPECT_LT(RelativeError(tensor.grad(), get("penalty." + name)), 2e-5) << name;
    }
    // Negative control: a batch in which one image is another has other deviations.
    Tensor other = images.detach().clone();
    other[3] = other[2];
    EXPECT_GT(RelativeError(discriminator.Judge(other)[0], judged[0]), 1e-3);
}

// ln(1 + e^x) where it is known.
TEST(GanLosses, AreLogistic) {
    const Tensor zero = torch::zeros({3});
    EXPECT_NEAR(DiscriminatorLoss(zero, zero).item<double>(), 2 * std::log(2.), 1e-6);
    EXPECT_NEAR(GeneratorLoss(zero).item<double>(), std::log(2.), 1e-6);
    const Tensor one = torch::ones({3});
    EXPECT_NEAR(DiscriminatorLoss(one, -2 * one).item<double>(),
                std::log1p(std::exp(-1.)) + std::log1p(std::exp(-2.)), 1e-6);
    EXPECT_NEAR(GeneratorLoss(one).item<double>(), std::log1p(std::exp(-1.)), 1e-6);
}

// Its value against a derivative by finite differences along the gradient, and its own derivative by the
// parameters, which is a second derivative. In double precision a central difference of step h is off by some
// h^2.
TEST(GanLosses, GradientPenaltyIsThatOfFiniteDifferences) {
    ConfigureTorch(1);
    const TensorMap parameters = DoubleDiscriminator();
    const Discriminator discriminator(kTiny, parameters);
    const Tensor real = RealMaps().to(torch::kDouble);
    const double penalty = GradientPenalty(discriminator, real).item<double>();
    // Half of the mean squared length: along the unit gradient of all images the sum changes by its length.
    const Tensor images = real.clone().requires_grad_();
    const Tensor gradient = torch::autograd::grad({discriminator.Judge(images).sum()}, {images})[0].detach();
    const double length = gradient.norm().item<double>(), h = 1e-5;
    const auto sumAt = [&](double distance) {
        return discriminator.Judge(real + distance / length * gradient).sum().item<double>();
    };
    const double found = (sumAt(h) - sumAt(-h)) / (2 * h);
    EXPECT_NEAR(0.5 * found * found / kBatch, penalty, 1e-4 * penalty);

    const TensorMap direction = Direction(parameters, 5);
    const auto penaltyAt = [&](double distance) {
        return GradientPenalty(Discriminator(kTiny, Moved(parameters, direction, distance)), real)
            .item<double>();
    };
    const double slope = Slope(GradientPenalty(discriminator, real), parameters, direction),
                 difference = (penaltyAt(1e-6) - penaltyAt(-1e-6)) / 2e-6;
    EXPECT_GT(std::abs(slope), 1e-3 * penalty);
    EXPECT_NEAR(slope, difference, 1e-4 * std::abs(slope));
}

// The filter of the generator is linear: its derivative along v, by whatever is multiplied to its result, is
// what it makes of v.
TEST(GanLosses, FilterHasDerivativesOfDerivatives) {
    const Tensor x = NormalNumbers({2, 8, 5, 5}, SeededGenerator(1)).requires_grad_(),
                 v = NormalNumbers({2, 8, 5, 5}, SeededGenerator(2)),
                 y = NormalNumbers({2, 2, 8, 8}, SeededGenerator(3)).requires_grad_();
    const Tensor back =
        torch::autograd::grad({(InterleaveAndFilter(x) * y).sum()}, {x}, {}, /*retain_graph=*/true,
                              /*create_graph=*/true)[0];
    const Tensor twice = torch::autograd::grad({(back * v).sum()}, {y})[0];
    EXPECT_LT(RelativeError(twice, InterleaveAndFilter(v)), 1e-6);
}

// Lengths by a derivative along the unit gradient. Their own derivatives only by weights that they are smooth
// in, which are those of the colours: rectifiers make lengths jump. In single precision, central differences
// of sums of 2304 numbers are good to some parts in a thousand.
TEST(GanLosses, PathLengthsAreThoseOfFiniteDifferences) {
    ConfigureTorch(1);
    TensorMap parameters = RandomGeneratorParameters(kTiny, SeededGenerator(1));
    for (auto& [name, tensor] : parameters) tensor.requires_grad_();
    const StyleGenerator generator(kTiny, parameters);
    const Tensor w = generator.Map(NormalNumbers({1, kTiny.latentSize}, SeededGenerator(2)));
    const double length = PathLengths(generator, w, SeededGenerator(3)).item<double>();
    // The same numbers in the same order.
    torch::Generator random = SeededGenerator(3);
    const std::vector<Tensor> noise = generator.RandomNoise(1, random);
    const Tensor y = NormalNumbers({1, 9, 16, 16}, random);
    const auto projected = [&](const Tensor& at) {
        return (generator.Synthesize(generator.Repeat(at), noise) * y).sum();
    };
    const Tensor unit = torch::autograd::grad({projected(w)}, {w})[0] / length;
    const Tensor moved = w.detach();
    constexpr double kStep = 0.003;
    const double found =
        (projected(moved + kStep * unit) - projected(moved - kStep * unit)).item<double>() / (2 * kStep);
    EXPECT_NEAR(found, length, 0.02 * length);

    TensorMap direction = Direction(parameters, 7);
    for (auto& [name, tensor] : direction)
        if (!name.starts_with("synthesis.output")) tensor.zero_();
    const auto lengthAt = [&](double distance) {
        const StyleGenerator other(kTiny, Moved(parameters, direction, distance));
        return PathLengths(other, moved.clone().requires_grad_(), SeededGenerator(3)).item<double>();
    };
    const Tensor sum =
        PathLengths(generator, generator.Map(NormalNumbers({1, kTiny.latentSize}, SeededGenerator(2))),
                    SeededGenerator(3))
            .sum();
    const double slope = Slope(sum, parameters, direction), h = 0.01,
                 difference = (lengthAt(h) - lengthAt(-h)) / (2 * h);
    EXPECT_GT(std::abs(slope), 1e-3 * length);
    EXPECT_NEAR(slope, difference, 0.02 * std::abs(slope));
}

TEST(GanLosses, StylesMix) {
    const StyleGenerator generator(kTiny, RandomGeneratorParameters(kTiny, SeededGenerator(1)));
    constexpr int64_t kMany = 400;
    const Tensor styles = MixedStyles(generator, kMany, SeededGenerator(2));
    EXPECT_EQ(styles.sizes(), torch::IntArrayRef({kMany, kTiny.NumColumns(), kTiny.latentSize}));
    const Tensor changes =
        (styles.narrow(1, 1, kTiny.NumColumns() - 1) - styles.narrow(1, 0, kTiny.NumColumns() - 1))
            .abs()
            .sum(2) > 0;
    const Tensor numChanges = changes.sum(1);
    EXPECT_EQ(numChanges.max().item<int64_t>(), 1);
    // Binomial with 0.9: 360, and five deviations of 6.
    EXPECT_NEAR(double(numChanges.sum().item<int64_t>()), 0.9 * kMany, 30);
    // Every place of the crossover occurs.
    EXPECT_TRUE((changes.sum(0) > 0).all().item<bool>());
}

// A discriminator without an opponent's practice finds noise soon; both losses stay numbers.
TEST(GanTrainer, LossOfTheDiscriminatorFalls) {
    ConfigureTorch(1);
    GanTrainer trainer(kTiny, kBatch, 1);
    double early = 0, late = 0;
    for (int step = 0; step < 60; ++step) {
        const GanLoss loss = trainer.Step();
        EXPECT_TRUE(std::isfinite(loss.generator) && std::isfinite(loss.discriminator));
        EXPECT_GT(loss.gradientPenalty, 0);
        EXPECT_GT(loss.pathLength, 0);
        if (step < 10) early += loss.discriminator;
        if (step >= 50) late += loss.discriminator;
    }
    EXPECT_LT(late, 0.8 * early);
    EXPECT_EQ(trainer.NumImages(), 60 * kBatch);
}

// Stored after nine steps, with both penalties behind and ahead.
TEST(GanTrainer, ResumedIsTheSame) {
    ConfigureTorch(1);
    GanTrainer whole(kTiny, kBatch, 7), first(kTiny, kBatch, 7), other(kTiny, kBatch, 8);
    for (int step = 0; step < 18; ++step) {
        whole.Step();
        other.Step();
        if (step < 9) first.Step();
    }
    const std::string path = TemporaryPath("resume");
    first.Save(path);
    GanTrainer second = GanTrainer::Load(path);
    EXPECT_EQ(second.NumSteps(), 9);
    for (int step = 9; step < 18; ++step) second.Step();
    const GeneratorFile a = whole.Average(32), b = second.Average(32);
    EXPECT_TRUE(AreEqual(a.generator, b.generator));
    EXPECT_TRUE(torch::equal(a.meanW, b.meanW));
    // Moments and discriminators as well: whole states, byte by byte, but for the time that they took.
    const std::string pathA = TemporaryPath("a"), pathB = TemporaryPath("b");
    whole.Save(pathA);
    second.Save(pathB);
    const SafetensorsFile fileA(pathA), fileB(pathB);
    ASSERT_EQ(fileA.Names(), fileB.Names());
    EXPECT_EQ(fileA.Metadata(), fileB.Metadata());
    for (const std::string& name : fileA.Names())
        EXPECT_EQ(fileA.Read(name, fileA.ShapeOf(name)), fileB.Read(name, fileB.ShapeOf(name))) << name;
    // Negative control: another seed gives others.
    EXPECT_FALSE(AreEqual(a.generator, other.Average(32).generator));
    for (const std::string& used : {path, pathA, pathB}) std::filesystem::remove(used);
}

// From options to a file that fits take, and on from its state without being told the objective again.
TEST(Train, GanWritesAGeneratorWithItsStart) {
    TrainOptions options;
    options.objective = TrainingObjective::Gan;
    options.out = TemporaryPath("train");
    options.config = kTiny;
    options.steps = 3;
    options.batch = kBatch;
    options.statisticsMaterials = 32;
    Observer observer;
    std::vector<TrainProgress> seen;
    const auto report = [&](const TrainProgress& p) { seen.push_back(p); };
    EXPECT_TRUE(Train(options, observer, report));
    options.objective = TrainingObjective::Autoencoder;
    options.resume = true;
    options.steps = 5;
    EXPECT_TRUE(Train(options, observer, report));
    EXPECT_EQ(seen.back().step, 5);
    EXPECT_EQ(seen.back().objective, TrainingObjective::Gan);
    const GeneratorFile file = LoadGeneratorFile(options.out);
    EXPECT_FALSE(file.encoder);
    EXPECT_TRUE(file.startLow);
    for (const std::string& path :
         {options.out, TrainingStatePath(options.out), TrainingPreviewPath(options.out)})
        EXPECT_TRUE(std::filesystem::remove(path)) << path;
}

}  // namespace
}  // namespace lacquer::materialgan::gan_test
