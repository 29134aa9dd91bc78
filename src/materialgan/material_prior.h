// A generator of materials as a prior: what other modules see of it.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>

#include "capture/maps.h"
#include "materialgan/generator_config.h"

namespace lacquer::materialgan {

struct GeneratorFile;

/// The latent codes of one material.
struct Latents {
    std::vector<float> wPlus;               ///< NumColumns() x latentSize
    std::vector<std::vector<float>> noise;  ///< a square for each layer, with the edge of NoiseResolutions()
};

class MaterialPrior {
  public:
    /// Errors: FileError, as in network/generator_file.h: what is no generator, or a damaged one.
    explicit MaterialPrior(const std::string& path);
    ~MaterialPrior();

    const GeneratorConfig& Config() const;
    size_t NumParameters() const;
    bool HasEncoder() const;
    /// What the file says about itself besides its shape.
    const std::map<std::string, std::string>& Notes() const;
    /// Of the generator's weights: which generator latents belong to. Reads all of them.
    uint64_t Fingerprint() const;

    /// Maps of normal numbers.
    /// @param psi  1: as they come; below: nearer to the mean w; 0: the mean w
    /// Errors here and below: FileError if the generator makes numbers that are not finite.
    std::vector<capture::Maps> Sample(int count, double psi, uint64_t seed) const;
    /// The same one by one, for more than fit into memory.
    void VisitSamples(int count, double psi, uint64_t seed,
                      const std::function<void(int, capture::Maps)>& visit) const;
    capture::Maps Decode(const Latents& latents) const;
    /// Of the encoder's distribution the mean. The maps have the generator's resolution.
    Latents Encode(const capture::Maps& maps) const;

    /// Between two materials, both included: latents linearly.
    std::vector<capture::Maps> Morph(const Latents& a, const Latents& b, int steps) const;

    /// For this module.
    const GeneratorFile& File() const { return *file_; }

  private:
    std::unique_ptr<GeneratorFile> file_;
};

/// Linear between the stored values of two maps of one size, normals made unit again.
capture::Maps BlendMaps(const capture::Maps& a, const capture::Maps& b, double share);

/// As a file, with what it needs to be read again, and the prior's fingerprint. Errors: FileError.
void SaveLatents(const Latents& latents, const MaterialPrior& prior, const std::string& path);
/// Errors: FileError, also for those of another generator.
Latents LoadLatents(const std::string& path, const MaterialPrior& prior);

/// Threads of libtorch, for the process; to be called before a prior is asked for anything. Same seeds,
/// threads and machine give the same bits.
void SetTorchThreads(int threads);

/// Whether what was thrown says that memory is out, which libtorch does by exceptions of its own.
bool IsOutOfMemory(const std::exception& error);

}  // namespace lacquer::materialgan
