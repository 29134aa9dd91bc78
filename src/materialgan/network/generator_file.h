// A generator with what is known of its latents, as a file.
#pragma once

#include <optional>

#include "materialgan/network/encoder.h"
#include "materialgan/network/stylegan.h"

namespace lacquer::materialgan {

struct GeneratorFile {
    GeneratorConfig config;
    TensorMap generator;
    /// Mean and deviation of w over training materials; of a GAN, of mapped normal numbers. latentSize each.
    Tensor meanW, deviationW;
    std::vector<Tensor> noise;         ///< what noise is where nothing is known: 1 x 1 x res x res each
    std::optional<TensorMap> encoder;  ///< of generators that were trained with one
    std::map<std::string, std::string> notes;  ///< source, recipe, ...: metadata that say nothing of shapes
};

/// Deviations that a file lacks are 1 and noise that it lacks is 0.
/// Errors: FileError, for a file that is no generator, or lacks tensors, or has some of wrong shapes or with
/// numbers that are not finite.
GeneratorFile LoadGeneratorFile(const std::string& path);
/// Errors: FileError.
void SaveGeneratorFile(const GeneratorFile& file, const std::string& path, bool half = false);

}  // namespace lacquer::materialgan
