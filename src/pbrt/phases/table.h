// Phase function "table": numbers over the scattering angle, and over the wavelength.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pbrt/base/phase_function.h"

namespace lacquer {

/// A function of the cosine c of the scattering angle from numbers: made once with a material, shared by its
/// hits.
struct PhaseTable {
    /// @param samples  at least 2, at equal steps of c from -1 (straight back) to 1 (straight on), linear
    ///                 between; in any unit. What is negative or not finite counts as 0; if nothing is left,
    ///                 the table is isotropic.
    explicit PhaseTable(std::span<const float> samples);

    std::vector<float> values;  ///< p [1/sr]
    std::vector<float> cdf;     ///< probability of a cosine below that of the sample, 0 ... 1
};

/// Reads a PhaseTable, which must outlive it. Symmetric, weight 1.
class TabulatedPhase final : public PhaseFunction {
  public:
    explicit TabulatedPhase(const PhaseTable& table) : TabulatedPhase(table.values, table.cdf) {}
    /// The two arrays of a PhaseTable.
    TabulatedPhase(std::span<const float> values, std::span<const float> cdf);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;

  private:
    std::span<const float> values_, cdf_;
};

/// The numbers of a table as a scene or a file gives them.
struct PhaseNumbers {
    std::vector<float> wavelengths;  ///< increasing [nm]; empty: one row, the same at all
    std::vector<float> angles;       ///< increasing, from 0 (straight on) to 180 [degrees]
    std::vector<float> values;       ///< for each wavelength a row of one value per angle, in any unit

    size_t NumRows() const { return std::max<size_t>(wavelengths.size(), 1); }
    std::span<const float> Row(size_t i) const {
        return std::span(values).subspan(i * angles.size(), angles.size());
    }
};

/// "99 % of the light is scattered between 0 and 1e-06 degrees, ..." if a hundredth of a row or more is in a
/// peak that directions of floats do not resolve, so that a part of it would be lost; else empty. The
/// narrowest peak is 1e-4 degrees wide straight on, and 0.23 degrees straight back.
std::string WhyTooNarrow(const PhaseNumbers& numbers);

/// A function of the scattering angle at any nodes (so a forward peak has as many as it needs), for one or
/// more wavelengths. Linear in the cosine between angles; linear between wavelengths, and constant beyond
/// the first and the last. Every row integrates to 1.
class SpectralPhaseTable {
  public:
    /// @param numbers  at least 2 angles. Values that are negative or not finite count as 0; a row where
    ///                 nothing is left is isotropic.
    explicit SpectralPhaseTable(const PhaseNumbers& numbers);

    bool IsChromatic() const { return wavelengths_.size() > 1; }

    /// The place of a wavelength: row and row + 1 are mixed, the latter with the weight.
    struct Place {
        int row = 0;
        float weight = 0;
    };
    Place PlaceOf(float lambda) const;

    /// An interval between nodes, and where in it.
    struct Node {
        size_t index = 0;
        float x = 0;  ///< in [0, 1]
    };
    /// @param oneMinusCos  in [0, 2], but for rounding
    Node Find(float oneMinusCos) const;
    /// p [1/sr].
    float Value(const Place& at, const Node& node) const {
        const float low = RowValue(at.row, node);
        return at.weight > 0 ? Lerp(at.weight, low, RowValue(at.row + 1, node)) : low;
    }
    /// 1 - cos of an angle drawn from a row. @param u  in [0, 1)
    float SampleRow(int row, float u) const;

  private:
    float RowValue(int row, const Node& node) const {
        const float* values = &values_[size_t(row) * nodes_.size() + node.index];
        return Lerp(node.x, values[0], values[1]);
    }

    std::vector<float> wavelengths_;
    std::vector<float> nodes_;         ///< 1 - cos: exact straight on, where lobes are narrow
    std::vector<float> values_, cdf_;  ///< row by row; the cdf from straight on
    /// For equal steps of sin(angle / 2) the last node at or before: where Find() begins.
    std::vector<uint32_t> guide_;
};

/// Reads a SpectralPhaseTable, which must outlive it, at the wavelengths of a path. Symmetric, weight 1.
class SpectralTabulatedPhase final : public PhaseFunction {
  public:
    SpectralTabulatedPhase(const SpectralPhaseTable& table, const SampledWavelengths& lambda);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;
    bool IsChromatic() const override { return table_.IsChromatic(); }
    SpectralPhaseValue EvaluateSpectral(Vec3 wo, Vec3 wi) const override;
    Vec3 SampleAt(int wavelength, Vec3 wo, Rng& rng) const override;

  private:
    const SpectralPhaseTable& table_;
    std::array<SpectralPhaseTable::Place, kNumWavelengths> places_;
};

}  // namespace lacquer
