// How large particles are.
#pragma once

#include <vector>

#include "bulk/ensembles/random.h"

namespace lacquer::bulk {

/// A distribution of radii by number, in any unit of length.
class RadiusDistribution {
  public:
    struct Node {
        double radius, weight;  ///< weights add up to 1
    };

    static RadiusDistribution Constant(double radius);
    /// Cut at 3 deviations and at a thousandth of the mean.
    static RadiusDistribution Normal(double mean, double deviation);
    /// ln r is normal about ln(median) with deviation `sigma`; cut at 3 sigma.
    static RadiusDistribution LogNormal(double median, double sigma);
    /// These radii with these numbers of particles, in any unit.
    static RadiusDistribution Table(std::vector<Node> nodes);

    double Sample(Random& random) const;
    /// The distribution for integrals over it: Simpson's rule where it is continuous.
    const std::vector<Node>& Nodes() const { return nodes_; }
    /// Mean of r^power.
    double Moment(int power) const;
    double MeanVolume() const;
    double Largest() const;

  private:
    enum class Kind { Discrete, Normal, LogNormal };
    RadiusDistribution() = default;  // of given nodes
    RadiusDistribution(Kind kind, double center, double deviation);
    double RadiusAt(double z) const;

    Kind kind_ = Kind::Discrete;
    double center_ = 0, deviation_ = 0, lowestZ_ = 0;
    std::vector<Node> nodes_;
};

}  // namespace lacquer::bulk
