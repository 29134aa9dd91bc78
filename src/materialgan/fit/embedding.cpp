#include "materialgan/fit/embedding.h"

namespace lacquer::materialgan {
namespace {

constexpr int kMetalIterations = 100;
constexpr double kMetalRate = 0.02;

}  // namespace

LatentDescent EmbedMaps(const StyleGenerator& generator, const Tensor& maps, const LatentTensors& start,
                        const LatentSchedule& schedule, Observer* observer,
                        const std::function<Tensor(const Tensor&)>& toPlus) {
    const LatentObjective objective = [&](const Tensor& made, const LatentTensors&, FitPhase) {
        const Tensor loss = (made - maps).square().mean();
        return PhotoObjective::Value{loss, loss.item<double>()};
    };
    return DescendLatents(generator, start, schedule, objective, observer, toPlus);
}

LatentDescent EmbedSmoothMetal(const GeneratorFile& file, const StyleGenerator& generator,
                               capture::FitCheckpoint* checkpoint, Observer* observer) {
    const Tensor maps = SmoothMetalMaps(file.config.resolution);
    const LatentTensors start = file.encoder ? EncodedLatents(file, maps) : MeanLatents(file);
    const LatentSchedule schedule{.iterations = kMetalIterations,
                                  .strategy = 2,
                                  .rateW = kMetalRate,
                                  .rateNoise = kMetalRate,
                                  .name = "embedding a smooth metal",
                                  .checkpoint = checkpoint};
    return EmbedMaps(generator, maps, start, schedule, observer);
}

bool StoreStartLow(const GeneratorFile& file, const LatentTensors& start) {
    try {
        // A training may have written a better generator meanwhile.
        if (file.path.empty() || FileStamp(file.path) != file.stamp) return false;
        GeneratorFile changed = file;
        changed.startLow = start.Clone();
        SaveGeneratorFile(changed, file.path);
        return true;
    } catch (const FileError&) {
        return false;
    }
}

}  // namespace lacquer::materialgan
