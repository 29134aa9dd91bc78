#include "materialgan/material_prior.h"

#include <fmt/format.h>

#include <cmath>

#include "materialgan/fit/latent_codes.h"
#include "pbrt/core/check.h"
#include "pbrt/core/hash_bytes.h"

namespace lacquer::materialgan {
namespace {

constexpr const char* kLatentsFormat = "lacquer-latents";
constexpr const char* kGeneratorKey = "generator";

capture::Maps MapsOf(const GeneratorFile& file, const LatentTensors& latents) {
    const torch::NoGradGuard noGradients;
    const StyleGenerator generator(file.config, file.generator);
    return MadeMaps(file, generator.Synthesize(latents.wPlus, latents.noise));
}

std::string FingerprintText(const MaterialPrior& prior) {
    return fmt::format("{:016x}", prior.Fingerprint());
}

std::string LatentNoiseName(size_t layer) { return fmt::format("noise{}", layer); }

}  // namespace

MaterialPrior::MaterialPrior(const std::string& path)
    : file_(std::make_unique<GeneratorFile>(LoadGeneratorFile(path))) {}
MaterialPrior::~MaterialPrior() = default;

const GeneratorConfig& MaterialPrior::Config() const { return file_->config; }
bool MaterialPrior::HasEncoder() const { return file_->encoder.has_value(); }
const std::map<std::string, std::string>& MaterialPrior::Notes() const { return file_->notes; }

size_t MaterialPrior::NumParameters() const {
    int64_t count = 0;
    for (const auto& [name, tensor] : file_->generator) count += tensor.numel();
    return size_t(count);
}

uint64_t MaterialPrior::Fingerprint() const {
    uint64_t hash = 0;
    for (const auto& [name, tensor] : file_->generator) {
        const Tensor values = tensor.contiguous();
        hash = Hash(hash, HashOfBytes(name),
                    HashOfBytes({static_cast<const char*>(values.data_ptr()), size_t(values.nbytes())}));
    }
    return hash;
}

std::vector<capture::Maps> MaterialPrior::Sample(int count, double psi, uint64_t seed) const {
    std::vector<capture::Maps> samples;
    VisitSamples(count, psi, seed, [&](int, capture::Maps maps) { samples.push_back(std::move(maps)); });
    return samples;
}

void MaterialPrior::VisitSamples(int count, double psi, uint64_t seed,
                                 const std::function<void(int, capture::Maps)>& visit) const {
    const torch::NoGradGuard noGradients;
    const GeneratorConfig& config = file_->config;
    const StyleGenerator generator(config, file_->generator);
    torch::Generator random = SeededGenerator(seed);
    for (int i = 0; i < count; ++i) {
        const Tensor z = NormalNumbers({1, config.latentSize}, random);
        const Tensor w = file_->meanW + psi * (generator.Map(z) - file_->meanW);
        const std::vector<Tensor> noise = generator.RandomNoise(1, random);
        visit(i, MadeMaps(*file_, generator.Synthesize(generator.Repeat(w), noise)));
    }
}

capture::Maps MaterialPrior::Decode(const Latents& latents) const {
    return MapsOf(*file_, ToTensors(latents, file_->config));
}

Latents MaterialPrior::Encode(const capture::Maps& maps) const {
    LACQUER_CHECK(maps.size == file_->config.resolution);
    return FromTensors(EncodedLatents(*file_, ToTensor(maps).unsqueeze(0)));
}

std::vector<capture::Maps> MaterialPrior::Morph(const Latents& a, const Latents& b, int steps) const {
    LACQUER_CHECK(steps >= 2);
    const LatentTensors from = ToTensors(a, file_->config), to = ToTensors(b, file_->config);
    std::vector<capture::Maps> maps;
    for (int step = 0; step < steps; ++step) {
        const double share = double(step) / (steps - 1);
        LatentTensors between{torch::lerp(from.wPlus, to.wPlus, share), {}};
        for (size_t i = 0; i < from.noise.size(); ++i)
            between.noise.push_back(torch::lerp(from.noise[i], to.noise[i], share));
        maps.push_back(MapsOf(*file_, between));
    }
    return maps;
}

capture::Maps BlendMaps(const capture::Maps& a, const capture::Maps& b, double share) {
    LACQUER_CHECK(a.size == b.size);
    capture::Maps blend(a.size);
    for (size_t i = 0; i < a.values.size(); ++i)
        blend.values[i] = (1 - share) * a.values[i] + share * b.values[i];
    // Of unit normals the sum, made unit again.
    const auto zOf = [](const capture::Maps& maps, size_t i) {
        const double x = maps.Channel(capture::kNormal)[i], y = maps.Channel(capture::kNormal + 1)[i];
        return std::sqrt(std::max(0., 1 - x * x - y * y));
    };
    const auto x = blend.Channel(capture::kNormal), y = blend.Channel(capture::kNormal + 1);
    for (size_t i = 0; i < blend.NumTexels(); ++i) {
        const double z = (1 - share) * zOf(a, i) + share * zOf(b, i);
        const double length = std::sqrt(x[i] * x[i] + y[i] * y[i] + z * z);
        if (length < 1e-6) continue;
        x[i] /= length;
        y[i] /= length;
    }
    return blend;
}

void SaveLatents(const Latents& latents, const MaterialPrior& prior, const std::string& path) {
    const GeneratorConfig& config = prior.Config();
    const auto columns = size_t(config.NumColumns()), size = size_t(config.latentSize);
    std::vector<NamedTensor> tensors = {{"wPlus", {1, columns, size}, latents.wPlus}};
    const std::vector<int> resolutions = config.NoiseResolutions();
    for (size_t i = 0; i < resolutions.size(); ++i) {
        const auto res = size_t(resolutions[i]);
        tensors.push_back({LatentNoiseName(i), {1, 1, res, res}, latents.noise[i]});
    }
    WriteSafetensors(path, tensors, {{"format", kLatentsFormat}, {kGeneratorKey, FingerprintText(prior)}});
}

Latents LoadLatents(const std::string& path, const MaterialPrior& prior) {
    const SafetensorsFile file(path);
    // Shapes first: what is no file of latents is told by them.
    const GeneratorConfig& config = prior.Config();
    const auto columns = size_t(config.NumColumns()), size = size_t(config.latentSize);
    Latents latents{file.Read("wPlus", std::array<size_t, 3>{1, columns, size}), {}};
    const std::vector<int> resolutions = config.NoiseResolutions();
    for (size_t i = 0; i < resolutions.size(); ++i) {
        const auto res = size_t(resolutions[i]);
        latents.noise.push_back(file.Read(LatentNoiseName(i), std::array<size_t, 4>{1, 1, res, res}));
    }
    const auto owner = file.Metadata().find(kGeneratorKey);
    if (owner != file.Metadata().end() && owner->second != FingerprintText(prior))
        throw FileError(path, "has latents of another generator; a generator reads its own alone");
    return latents;
}

void SetTorchThreads(int threads) { ConfigureTorch(threads); }

bool IsOutOfMemory(const std::exception& error) {
    if (dynamic_cast<const std::bad_alloc*>(&error)) return true;
    // The allocator of processors has no type of exception for it.
    return dynamic_cast<const c10::Error*>(&error) &&
           std::string_view(error.what()).find("DefaultCPUAllocator") != std::string_view::npos;
}

}  // namespace lacquer::materialgan
