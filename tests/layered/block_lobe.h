// A lobe as means over blocks of the projected hemisphere, to compare one way of computing it with another by
// its shape. Knows no test framework: trace_lobes writes such lobes.
#pragma once

#include <array>
#include <string>

#include "pbrt/core/sampled_spectrum.h"
#include "pbrt/core/vec.h"

namespace lacquer::layered::test {

/// f |cos theta_i| of the directions wi = (u, v, sqrt(1 - u^2 - v^2)) above a stack, in the lanes 0, 1 and 2.
/// Columns of blocks run with u and rows against v, from -1 to 1; a block's mean takes the square, and f is 0
/// outside of the disk.
struct BlockLobe {
    static constexpr int kSide = 16, kBlocks = kSide * kSide, kChannels = 3;
    using Channels = std::array<double, kChannels>;

    std::array<Channels, kBlocks> means{}, variances{};  ///< variances of the means

    /// Integral over the square: of f cos^2 theta_i over the solid angle.
    double Integral(int c) const;
    /// Standard error of Integral(), blocks taken as independent.
    double IntegralError(int c) const;
};

/// A lobe from random directions.
class BlockLobeSums {
  public:
    void AddNothing() { ++count_; }
    /// @param value  f |cos theta_i| / pdf of a direction above, or the weight of a sample
    void Add(Vec3 wi, SampledSpectrum value);
    /// Adds the sums of another one.
    void Merge(const BlockLobeSums& other);
    BlockLobe Lobe() const;

  private:
    double count_ = 0;
    std::array<BlockLobe::Channels, BlockLobe::kBlocks> sums_{}, squares_{};
};

/// Text: comments of "#", then for each block a line of three means and their standard errors.
void WriteLobe(const std::string& file, const BlockLobe& lobe, const std::string& comment);
/// Errors: std::runtime_error.
BlockLobe ReadLobe(const std::string& file);

/// Towards the light of all lobes of files: from u < 0 at this angle.
inline Vec3 FromTheLeft(float sinTheta) { return {-sinTheta, 0, std::sqrt(1 - sinTheta * sinTheta)}; }

}  // namespace lacquer::layered::test
