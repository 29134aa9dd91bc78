// particles.json, what "lacquer bulk" reads. docs/bulk.md describes it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bulk/table/oriented_computation.h"

namespace lacquer::bulk {

/// What such a file asks for.
struct ParticlesInput {
    BulkSettings settings;
    /// Particles of balls of several sizes, growing, for the extrapolation in 1/R; empty: one ball of
    /// settings.ensemble.count.
    std::vector<int> sizes;
    /// Of an ensemble that keeps its axis, z: a table by directions. Empty: of an isotropic medium.
    std::optional<OrientedSettings> oriented;
    std::string json;  ///< the text without its blanks, for the table's "made"
    FileLoc placeOfArrangement;
};

/// What a command line says instead of the file.
struct ParticlesOverrides {
    std::vector<double> wavelengths;  ///< [nm]; empty: those of the file
    std::optional<uint64_t> seed;
};

/// Limits of what is solved.
inline constexpr double kMaxSizeParameter = 200;  ///< of a particle in a cluster
inline constexpr double kMaxUnknowns = 2e6;       ///< of a realisation
inline constexpr double kMaxBallSize = 1000;      ///< radius of a cluster times k
inline constexpr int kMaxWavelengths = 1000;

/// Reads a file, zipped or not, of at most 64 MB.
/// Errors: FileError if it cannot be read; SceneError with line and column for what makes no sense or is
/// beyond the limits above.
ParticlesInput ReadParticles(const std::string& path, const ParticlesOverrides& overrides = {});

/// begin, begin + step, ... to `end` at most. Empty unless 1 <= begin <= end <= 1e6, step >= 0.001, and there
/// are at most kMaxWavelengths of them.
std::vector<double> EvenWavelengths(double begin, double end, double step);

}  // namespace lacquer::bulk
