#include "materialgan/train.h"

#include <filesystem>
#include <limits>

#include "materialgan/fit/embedding.h"
#include "materialgan/network/contact_sheet.h"
#include "materialgan/training/gan_trainer.h"
#include "materialgan/training/trainer.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/rng.h"
#include "pbrt/image/image.h"

namespace lacquer::materialgan {
namespace {

namespace fs = std::filesystem;

constexpr int kNumPreviews = 8;
constexpr double kMaxStepRatio = 20;

std::string Beside(const std::string& out, const std::string& extension) {
    fs::path path = out;
    if (path.extension() == ".safetensors") path.replace_extension();
    return path.string() + extension;
}

/// Training materials, what becomes of them, if there is an encoder, and what the generator makes of random
/// numbers: a row each.
void WritePreview(const GeneratorFile& file, uint64_t seed, const std::string& path) {
    const torch::NoGradGuard noGradients;
    const StyleGenerator generator(file.config, file.generator);
    std::vector<Tensor> rows = {
        TrainingBatch(file.config.resolution, kNumPreviews, Hash(seed, uint64_t(6)), 0)};
    if (file.encoder) {
        const Encoding e = MapEncoder(file.config, *file.encoder).Encode(rows[0]);
        rows.push_back(ClampMaps(generator.Synthesize(generator.Repeat(generator.Map(e.zMean)), e.noiseMean),
                                 file.config));
    }
    torch::Generator random = SeededGenerator(seed);
    const Tensor z = NormalNumbers({kNumPreviews, file.config.latentSize}, random);
    rows.push_back(ClampMaps(
        generator.Synthesize(generator.Repeat(generator.Map(z)), generator.RandomNoise(kNumPreviews, random)),
        file.config));
    WriteImage(ContactSheet(rows), path);
}

LadderLoss StepOf(Trainer& trainer, double fraction) { return trainer.Step(fraction); }
GanLoss StepOf(GanTrainer& trainer, double) { return trainer.Step(); }

void Add(const LadderLoss& loss, TrainProgress* sum) {
    sum->objective = TrainingObjective::Autoencoder;
    sum->reconstruction += loss.reconstruction;
    sum->klZ += loss.klZ;
    sum->klNoise += loss.klNoise;
    sum->rmse += loss.rmse;
}
void Add(const GanLoss& loss, TrainProgress* sum) {
    sum->objective = TrainingObjective::Gan;
    sum->generatorLoss += loss.generator;
    sum->discriminatorLoss += loss.discriminator;
    sum->pathLength += loss.pathLength;
}

/// @tparam AnyTrainer  Trainer or GanTrainer
template <class AnyTrainer>
class TrainingRun {
  public:
    TrainingRun(const TrainOptions& options, Observer& observer,
                const std::function<void(const TrainProgress&)>& report)
        : options_(options),
          observer_(observer),
          report_(report),
          trainer_(options.resume ? AnyTrainer::Load(TrainingStatePath(options.out))
                                  : AnyTrainer(options.config, options.batch, options.seed)) {}

    bool Run() {
        Clock::time_point saved = Clock::now(), shown = saved, reported = saved;
        while (Fraction() < 1 && !observer_.ShouldStop()) {
            const Clock::time_point start = Clock::now();
            Add(StepOf(trainer_, Fraction()), &sum_);
            ++count_;
            AddTime(SecondsSince(start));
            if (SecondsSince(saved) >= options_.checkpointSeconds) {
                trainer_.Save(TrainingStatePath(options_.out));
                saved = Clock::now();
            }
            if (SecondsSince(shown) >= options_.previewSeconds) {
                Publish(options_.statisticsMaterials / 4);
                shown = Clock::now();
            }
            if (SecondsSince(reported) < 1) continue;
            Report();
            reported = Clock::now();
        }
        Report();
        trainer_.Save(TrainingStatePath(options_.out));
        Publish(options_.statisticsMaterials);
        if (Fraction() < 1) return false;
        PublishStart();
        return true;
    }

  private:
    double Fraction() const {
        if (options_.steps > 0) return double(trainer_.NumSteps()) / double(options_.steps);
        return trainer_.seconds / (3600 * options_.hours);
    }

    /// A step that takes many times as long as others was suspended, and the time is not work.
    void AddTime(double stepSeconds) {
        shortestStep_ = std::min(shortestStep_, stepSeconds);
        trainer_.seconds += std::min(stepSeconds, kMaxStepRatio * shortestStep_);
    }

    void Publish(int numMaterials) const {
        const GeneratorFile file = trainer_.Average(numMaterials);
        SaveGeneratorFile(file, options_.out);
        WritePreview(file, trainer_.Seed(), TrainingPreviewPath(options_.out));
    }

    /// At the end of all, the published generator gets what fits start with.
    void PublishStart() {
        const GeneratorFile file = LoadGeneratorFile(options_.out);
        StyleGenerator generator(file.config, file.generator);
        generator.KeepKernels();
        const LatentDescent metal = EmbedSmoothMetal(file, generator, nullptr, &observer_);
        if (metal.end == capture::FitResult::End::Finished) StoreStartLow(file, metal.latents);
    }

    void Report() {
        if (count_ == 0) return;
        for (double* mean : {&sum_.reconstruction, &sum_.klZ, &sum_.klNoise, &sum_.rmse, &sum_.generatorLoss,
                             &sum_.discriminatorLoss, &sum_.pathLength})
            *mean /= count_;
        sum_.step = trainer_.NumSteps();
        sum_.images = trainer_.NumImages();
        sum_.fraction = std::min(1., Fraction());
        sum_.seconds = trainer_.seconds;
        report_(sum_);
        sum_ = {};
        count_ = 0;
    }

    const TrainOptions& options_;
    Observer& observer_;
    const std::function<void(const TrainProgress&)>& report_;
    AnyTrainer trainer_;
    TrainProgress sum_;
    int count_ = 0;
    double shortestStep_ = std::numeric_limits<double>::infinity();
};

/// What the options say, or the state.
TrainingObjective ObjectiveOf(const TrainOptions& options) {
    if (!options.resume) return options.objective;
    const SafetensorsFile file(TrainingStatePath(options.out));
    const auto training = file.Metadata().find("training");
    const bool isGan = training != file.Metadata().end() && training->second == kGanTrainingFormat;
    return isGan ? TrainingObjective::Gan : TrainingObjective::Autoencoder;
}

}  // namespace

std::string TrainingStatePath(const std::string& out) { return Beside(out, ".training.safetensors"); }
std::string TrainingPreviewPath(const std::string& out) { return Beside(out, ".preview.png"); }

bool Train(const TrainOptions& options, Observer& observer,
           const std::function<void(const TrainProgress&)>& report) {
    ConfigureTorch(options.threads);
    if (ObjectiveOf(options) == TrainingObjective::Gan)
        return TrainingRun<GanTrainer>(options, observer, report).Run();
    return TrainingRun<Trainer>(options, observer, report).Run();
}

}  // namespace lacquer::materialgan
