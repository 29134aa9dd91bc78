// Coordinates in which what is observed changes evenly.
#pragma once

#include <vector>

#include "estimate/parameters.h"

namespace lacquer::estimate {

/// Emulators take parameters as they are where their range is narrow, and logarithms of those that span more
/// than a decade; of a factor (Parameter::productWith) the logarithm of its product.
class LobeCoordinates {
  public:
    /// @param space  its first `count` parameters; outlives the object
    LobeCoordinates(const ParameterSpace& space, Eigen::Index count);
    Eigen::Index Size() const { return Eigen::Index(isLogarithm_.size()); }
    /// @param x  natural units, of these parameters at least
    Vector FromNatural(const Vector& x) const;
    /// d/dx of a function of the coordinates, from its derivatives by them.
    Vector GradientByNatural(const Vector& x, const Vector& byCoordinates) const;

  private:
    std::vector<bool> isLogarithm_;
    std::vector<Eigen::Index> scales_;  ///< what a factor is multiplied by; -1: it is none
};

}  // namespace lacquer::estimate
