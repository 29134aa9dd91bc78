// Ensembles of particles: which there are, how they are arranged, and random realisations.
#pragma once

#include <string>
#include <vector>

#include "bulk/ensembles/radius_distribution.h"

namespace lacquer::bulk {

/// Particles of one kind, all lengths in one unit.
struct Species {
    std::string name;
    RadiusDistribution radius = RadiusDistribution::Constant(1);
    double volumeFraction = 0;  ///< of all space
};

/// One particle of a realisation.
struct Particle {
    Point center;
    double radius = 0;
    int species = 0;
};

enum class Arrangement {
    Uniform,  ///< a given number of hard spheres in equilibrium in a ball
    Cut,      ///< those hard spheres in a much larger periodic box whose centres are in a ball: their number
              ///< fluctuates
    PoissonDisc,  ///< in a ball, farther apart than they must be, by random sequential addition
    Clumped,      ///< in a ball, children about parents
    Gaussian,     ///< normal about the origin with a deviation for each axis, cut at three
    List          ///< given ones
};

struct EnsembleSettings {
    std::vector<Species> species;
    Arrangement arrangement = Arrangement::Cut;
    int count = 100;                      ///< mean number of particles
    double minDistance = 1.5;             ///< PoissonDisc: over the sum of two radii
    int children = 5;                     ///< Clumped: mean number about a parent
    double spread = 2;                    ///< Clumped: deviation of children over the mean radius
    Eigen::Vector3d deviations{1, 1, 1};  ///< Gaussian
    std::vector<Particle> particles;      ///< List
    bool isOriented = false;              ///< z is an axis: see Ensemble::Realize()
    int movesPerSphere = 50;              ///< accepted moves before hard spheres count as equilibrated
};

/// Of all species together.
double VolumeFractionOf(const EnsembleSettings& settings);

/// Draws realisations. Immutable.
class Ensemble {
  public:
    explicit Ensemble(EnsembleSettings settings);
    const EnsembleSettings& Settings() const { return settings_; }
    /// The ball in which the particles are at the given volume fraction: whole ones, their centres for
    /// Arrangement::Cut. 0 for Gaussian and List, which have none.
    double BallRadius() const { return ballRadius_; }
    /// Particles in a unit of volume.
    double NumberDensity() const { return numberDensity_; }
    /// Mean share of species i in the number of particles.
    double NumberShare(int i) const { return shares_[size_t(i)]; }
    /// About the origin; depends on both numbers only. List and Gaussian are turned at random as a whole; of
    /// an oriented ensemble all are, but about z only, and as often upside down as not. Throws SceneError if
    /// there is no room for the particles.
    std::vector<Particle> Realize(uint64_t seed, uint64_t realization) const;

  private:
    std::vector<Particle> Arrange(Random& random) const;
    std::vector<Particle> SampleParticles(int count, Random& random) const;
    std::vector<Particle> InBall(Random& random) const;
    std::vector<Particle> CutFromBox(Random& random) const;
    std::vector<Particle> AboutParents(Random& random) const;
    std::vector<Particle> AboutOrigin(Random& random) const;

    EnsembleSettings settings_;
    std::vector<double> shares_;
    double numberDensity_ = 0, ballRadius_ = 0;
};

}  // namespace lacquer::bulk
