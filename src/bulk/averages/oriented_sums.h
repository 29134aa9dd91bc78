// Averages over realisations of an oriented ensemble, for light along several directions.
#pragma once

#include <span>
#include <vector>

#include "bulk/averages/realization.h"
#include "bulk/averages/scattering_sums.h"
#include "pbrt/core/progress.h"

namespace lacquer::bulk {

/// Directions of incident and scattered light, and what is needed to compute fields there. Angles are to z,
/// at even steps; incidences are those up to 90 degrees, at the azimuth 0.
///
/// Tables are linear between the directions of scattered light, in the cosine and the azimuth. Where these
/// are too far apart for the lobes of such fields, intensities are computed at more, and a direction has the
/// mean with the weight of its linear function: a lobe is then as wide as the steps, but has the light that
/// it has.
class OrientedDirections {
  public:
    /// @param numIncidences, numAzimuths  at least 2; @param degree  of far fields
    OrientedDirections(int numIncidences, int numAzimuths, int degree);
    int NumIncidences() const { return int(incidences_.size()); }
    int NumAngles() const { return 2 * NumIncidences() - 1; }
    int NumAzimuths() const { return numAzimuths_; }
    int Degree() const { return harmonics_.Degree(); }
    double Incidence(int i) const { return incidences_[size_t(i)]; }  ///< angle [radians]
    /// S_11 at each angle and azimuth in turn: the mean over the azimuth and its negative.
    std::vector<double> IntensityOf(const OneOriginWaves& waves) const;

  private:
    int numAzimuths_, refinement_;
    std::vector<double> incidences_;
    AzimuthalHarmonics harmonics_;
    EvenAzimuths azimuths_;
    /// Shares of finer angles and azimuths (columns) in the coarse ones (rows).
    Eigen::MatrixXd angleShares_, azimuthShares_;
};

/// What one realisation gave, means over both polarisations. k^2 C. It has converged if it has for all
/// incidences; its energy error is the largest.
struct OrientedRealization final : Solution {
    struct Incidence {
        double extinction = 0, absorption = 0, scattering = 0;
        OneOriginWaves waves;
        std::vector<double> intensity;  ///< OrientedDirections::IntensityOf()
    };
    double numParticles = 0;
    std::vector<Incidence> incidences;
    bool wasStopped = false;  ///< by the observer: incidences are missing
};
/// @param spheres   about the origin, lengths times k; none scatter nothing
/// @param observer  or null; advances by a unit for each incidence, and may stop between them
OrientedRealization SolveOriented(std::vector<Sphere> spheres, const RealizationSettings& settings,
                                  const OrientedDirections& directions, Observer* observer = nullptr);

/// For each incidence, for each particle. `scattering`, `asymmetry` and `intensity` are those of the mode.
struct OrientedAverage {
    struct Incidence {
        double extinction = 0, absorption = 0, scattering = 0;
        double asymmetry = 0;           ///< g times the scattering
        std::vector<double> intensity;  ///< empty in CrossSections()
    };
    std::vector<Incidence> incidences;
};

/// Sums over realisations. The mean field of AverageMode::Medium is that in fixed directions. In groups,
/// whose differences tell the error (the jackknife); the order in which realisations are added is part of the
/// result's bits.
class OrientedSums {
  public:
    static constexpr int kNumGroups = 6;

    explicit OrientedSums(const OrientedDirections& directions);
    void Add(const OrientedRealization& realization);
    int NumRealizations() const { return numRealizations_; }
    /// At least two realisations for AverageMode::Medium and Chapter.
    OrientedAverage Average(AverageMode mode) const;
    /// Without one group of realisations each, in turn; empty for fewer than kNumGroups + 2 realisations.
    std::vector<OrientedAverage> AveragesWithoutGroups(AverageMode mode) const;
    /// The same without intensities, which take most of the time.
    OrientedAverage CrossSections(AverageMode mode) const;
    std::vector<OrientedAverage> CrossSectionsWithoutGroups(AverageMode mode) const;
    /// All that was added, for SetState() of sums over the same directions, which then go on to the same
    /// bits.
    std::vector<double> State() const;
    size_t StateSize() const;
    /// @param state  StateSize() numbers
    void SetState(std::span<const double> state);

  private:
    enum class Part { CrossSections, All };
    struct Incidence {
        double extinction = 0, absorption = 0, scattering = 0, asymmetry = 0;
        Eigen::MatrixX2cd coefficients;
        std::vector<double> intensity;
    };
    struct Sums {
        double count = 0, numParticles = 0;
        std::vector<Incidence> incidences;
        void Add(const Sums& other);
    };
    Sums Nothing() const;
    OrientedAverage Evaluate(const Sums& sums, AverageMode mode, Part part) const;
    std::vector<OrientedAverage> EvaluateWithoutGroups(AverageMode mode, Part part) const;
    Sums SumWithout(int group) const;

    const OrientedDirections* directions_;
    int numRealizations_ = 0;
    std::vector<Sums> groups_{size_t(kNumGroups)};
};

}  // namespace lacquer::bulk
