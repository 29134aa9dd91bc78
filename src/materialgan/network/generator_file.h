// A generator with what is known of its latents, as a file.
#pragma once

#include <optional>

#include "materialgan/network/encoder.h"
#include "materialgan/network/stylegan.h"

namespace lacquer::materialgan {

/// The latents of one material.
struct LatentTensors {
    Tensor wPlus;               ///< 1 x NumColumns() x latentSize
    std::vector<Tensor> noise;  ///< 1 x 1 x res x res each

    LatentTensors Clone() const;
};

struct GeneratorFile {
    std::string path;   ///< where it was read; empty for one that was just trained
    std::string stamp;  ///< FileStamp() then
    GeneratorConfig config;
    TensorMap generator;
    /// Mean and deviation of w over training materials; of a GAN, of mapped normal numbers. latentSize each.
    Tensor meanW, deviationW;
    std::vector<Tensor> noise;         ///< what noise is where nothing is known: 1 x 1 x res x res each
    std::optional<TensorMap> encoder;  ///< of generators that were trained with one
    /// A smooth metal, which fits start with where there is no encoder ("start.low.w", "start.low.noise0",
    /// ...).
    std::optional<LatentTensors> startLow;
    std::map<std::string, std::string> notes;  ///< source, recipe, ...: metadata that say nothing of shapes
};

/// Deviations that a file lacks are 1 and noise that it lacks is 0; encoder and start need not be there.
/// Errors: FileError, for a file that is no generator, or lacks tensors, or has some of wrong shapes, with
/// numbers that are not finite, or with deviations that are not above 0.
GeneratorFile LoadGeneratorFile(const std::string& path);
/// Size and time of a file as text, to know it again; empty if it is not there.
std::string FileStamp(const std::string& path);
/// Errors: FileError.
void SaveGeneratorFile(const GeneratorFile& file, const std::string& path, bool half = false);

/// Maps as the file's generator has synthesised them, 1 x 9 x R x R, within their ranges.
/// Errors: FileError if some are not finite: weights, each of them finite, can be too large.
capture::Maps MadeMaps(const GeneratorFile& file, const Tensor& synthesized);

}  // namespace lacquer::materialgan
