// Maps of noise that a seed makes, periodic.
#pragma once

#include "estimate/fourier/fft.h"
#include "estimate/models/periodic_tables.h"

namespace lacquer::estimate {

enum class NoiseKind {
    Spectral,     ///< amplitude k^-1.6, k the frequency in cycles over 512 texels
    BandLimited,  ///< amplitude k^-1.0 for k from 4 to 64
    Ridged        ///< 1 - |spectral noise|: sharp crests
};
constexpr int kNumNoiseKinds = 3;

/// Square map of values in [0,1] with mean 0.37 and standard deviation 0.16 before they are clamped. Lengths
/// count in texels: a map of other than 512 texels is a larger or smaller part of the same noise.
class NoiseMap {
  public:
    static constexpr int kTexels = 512;

    NoiseMap(NoiseKind kind, int texels);
    void SetSeed(uint64_t stream);

    int Texels() const { return size_; }
    /// Rows of texels.
    std::span<const double> Values() const { return table_.values; }

    /// Texel (i, j) is at u = j, v = i. Any finite u, v.
    PeriodicTable2::Sample At(double u, double v) const { return table_.At(u, v); }

  private:
    NoiseKind kind_;
    int size_;
    Fft2 fft_;
    ComplexGrid half_;
    std::vector<double> amplitudes_;  ///< in the layout of half_
    PeriodicTable2 table_;
    double sd_;  ///< of the values: that of the spectrum over that of 512 texels
};

}  // namespace lacquer::estimate
