// The phase function of an oriented ensemble, with its extinction and albedo by direction.
#pragma once

#include <array>
#include <vector>

#include "pbrt/base/phase_function.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer {

/// The numbers of an OrientedBulkTable for rendering. What is scattered, S = sigma_s p, is linear in both
/// cosines, the azimuth and the wavelength (constant beyond the first and the last), so S is symmetric and
/// drawn exactly; sigma_s(n) is its integral, p the quotient.
class OrientedPhaseTable {
  public:
    /// @param table  with its phase functions
    explicit OrientedPhaseTable(const OrientedBulkTable& table);

    bool IsChromatic() const { return wavelengths_.size() > 1; }
    /// The mean of sigma_t over all directions [1/mm].
    float MeanExtinction(float lambda) const;
    /// The largest of all directions and wavelengths.
    float LargestAlbedo() const { return largestAlbedo_; }

    /// The place of a wavelength: row and row + 1 are mixed, the latter with the weight.
    struct Place {
        size_t row = 0;
        float weight = 0;
        bool operator==(const Place&) const = default;
    };
    Place PlaceOf(float lambda) const;
    /// An interval between nodes, and where in it.
    struct Node {
        size_t index = 0;
        float x = 0;  ///< in [0, 1]
    };
    /// The interval of incidences that |z| is in. @param w  unit, in the frame of the axis
    Node FindIncidence(Vec3 w) const;
    // Linear between incidences and wavelengths.
    float Scattering(const Place& at, const Node& incidence) const {
        return Mixed(scattering_, at, incidence);
    }
    float Extinction(const Place& at, const Node& incidence) const {
        return Mixed(extinction_, at, incidence);
    }
    float MeanExtinction(const Place& at) const;

    /// Where a pair of directions lies.
    struct Pair {
        Node incidence, angle, azimuth;
    };
    /// @param n, s  of flight before and after, unit, in the frame of the axis
    Pair Find(Vec3 n, Vec3 s) const;
    /// S(n, s).
    float Value(const Place& at, const Pair& pair) const;
    /// s in proportion to S(n, s).
    Vec3 Sample(const Place& at, Vec3 n, Rng& rng) const;

  private:
    float Mixed(const std::vector<float>& values, const Place& at, const Node& incidence) const;
    const float* Azimuths(size_t row, size_t incidence, size_t angle) const {
        return &values_[((row * NumIncidences() + incidence) * numAngles_ + angle) * numAzimuths_];
    }
    size_t NumIncidences() const { return nodes_.size(); }
    Node SampleAngle(size_t row, size_t incidence, float u) const;
    float SampleAzimuth(const float* values, float u) const;

    std::vector<float> wavelengths_;
    std::vector<float> nodes_;  ///< 1 - cos of the incidences
    size_t numAngles_, numAzimuths_;
    // Row by row:
    std::vector<float> values_;                   ///< S
    std::vector<float> overAzimuth_, cdf_;        ///< for each incidence over the angles
    std::vector<float> scattering_, extinction_;  ///< for each incidence
    std::vector<float> meanExtinction_;
    float largestAlbedo_ = 0;
};

/// Reads an OrientedPhaseTable, which must outlive it, at the wavelengths of a path. Reciprocal, weight 1.
class OrientedPhase final : public PhaseFunction {
  public:
    /// @param axis  any length; z if it has none
    OrientedPhase(const OrientedPhaseTable& table, Vec3 axis, const SampledWavelengths& lambda);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;
    bool IsChromatic() const override { return isChromatic_; }
    SpectralPhaseValue EvaluateSpectral(Vec3 wo, Vec3 wi) const override;
    Vec3 SampleAt(int wavelength, Vec3 wo, Rng& rng) const override;
    /// Over the mean of all directions.
    float Extinction(Vec3 w) const override;
    /// Over LargestAlbedo().
    float Albedo(Vec3 w) const override;
    bool HasDirectionalExtinction() const override { return true; }
    bool HasDirectionalAlbedo() const override { return true; }
    DirectionalFactors FactorsAlong(Vec3 w, const SampledWavelengths& lambda) const override;

  private:
    using Places = std::array<OrientedPhaseTable::Place, kNumWavelengths>;
    float ExtinctionAt(const OrientedPhaseTable::Place& at, const OrientedPhaseTable::Node& node) const;
    float AlbedoAt(const OrientedPhaseTable::Place& at, const OrientedPhaseTable::Node& node) const;
    PhaseValue ValueAt(const OrientedPhaseTable::Place& at, const OrientedPhaseTable::Pair& pair,
                       const OrientedPhaseTable::Node& reverse) const;

    const OrientedPhaseTable& table_;
    Frame frame_;  ///< z is the axis
    Places places_;
    bool isChromatic_ = false;
};

}  // namespace lacquer
