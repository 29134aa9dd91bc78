// Averages over realisations of a cluster, and what they are taken for.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bulk/cluster/far_field.h"

namespace lacquer::bulk {

/// Which average of the scattered light is meant.
enum class AverageMode {
    Aggregate,  ///< clusters are the scatterers, far apart: the mean intensity
    Medium,  ///< a cluster is a probe of a homogeneous medium: the intensity without that of the mean field,
             ///< which is refraction and diffraction by the shape of the probe
    Chapter  ///< the intensity of the mean field alone; does not conserve energy
};

/// What one realisation gave, for light along z, averaged over both polarisations. k^2 C.
struct RealizationScattering {
    double numParticles = 0;
    double extinction = 0, absorption = 0, scattering = 0;
    std::vector<AzimuthalMeans> angles;
};

/// Means with their standard errors.
struct ScatteringAverage {
    struct Value {
        double mean = 0, error = 0;
    };
    /// k^2 C for each particle. `scattering` is that of the mode.
    Value extinction, absorption, scattering, g;
    std::vector<double> intensity;       ///< S_11 for each particle at each angle, of the mode
    std::vector<double> intensityError;  ///< of each angle
    /// S_12, S_22, S_33, S_34, S_44 over S_11 of the mean intensity (not for AverageMode::Chapter).
    std::vector<std::array<double, 5>> mueller;
};

/// Sums over realisations, in groups whose differences tell the error (the jackknife). The order in which
/// realisations are added is part of the result's bits.
class ScatteringSums {
  public:
    /// @param numAngles  n + 1 with n even: the angles are j pi / n
    explicit ScatteringSums(int numAngles);
    void Add(const RealizationScattering& realization);
    int NumRealizations() const { return numRealizations_; }
    double MeanParticles() const;
    /// At least two realisations for AverageMode::Medium and Chapter: the square of a mean is estimated
    /// without bias from pairs of them.
    ScatteringAverage Average(AverageMode mode) const;
    /// All that was added, for SetState() of sums over as many angles, which then go on to the same bits.
    std::vector<double> State() const;
    size_t StateSize() const;
    /// @param state  StateSize() numbers
    void SetState(std::span<const double> state);

  private:
    static constexpr int kNumGroups = 24;
    struct Angle {
        std::array<double, 6> mueller{};  ///< S_11, S_12, S_22, S_33, S_34, S_44
        std::array<Complex, 4> amplitude{};
        double amplitudeSquares = 0;  ///< sum of |F_ij|^2 over realisations, each of one realisation's mean
    };
    static constexpr size_t kNumbersOfAngle = 15;
    struct Sums {
        double count = 0, numParticles = 0, extinction = 0, absorption = 0, scattering = 0;
        std::vector<Angle> angles;
        void Add(const Sums& other, double sign);
    };
    /// Extinction, absorption, scattering, g, and then intensities, all for each particle.
    std::vector<double> Evaluate(const Sums& sums, AverageMode mode) const;

    int numRealizations_ = 0;
    std::vector<double> weights_;  ///< of the quadrature over angles
    std::vector<Sums> groups_;
};

/// Weights of the integral over the cosine with nodes theta_j = j pi / n, j = 0 ... n, n even: exact for
/// polynomials of degree n [Clenshaw and Curtis 1960].
std::vector<double> ClenshawCurtisWeights(int n);

}  // namespace lacquer::bulk
