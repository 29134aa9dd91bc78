// How particles stand to each other: pair distribution and structure factor, measured and by Percus and
// Yevick.
#pragma once

#include <span>
#include <vector>

#include "bulk/conventions.h"

namespace lacquer::bulk {

/// S(q) of hard spheres of one radius [Percus and Yevick 1958; Wertheim 1963].
/// @param volumeFraction  below 1; @param qDiameter  q times the diameter
double PercusYevickStructureFactor(double volumeFraction, double qDiameter);

/// g(r) of the same spheres at a distance over their diameter: 0 below 1, then 1 + (h - c)(r), which is
/// continuous and so the integral of a function of S(q) that falls with the fourth power. To 1e-3; a
/// millisecond.
double PercusYevickPairDistribution(double volumeFraction, double distance);

/// S(q) and g(r) of realisations, without what the shape of their region does.
class StructureSums {
  public:
    /// @param wavenumbers  q, any unit; @param binWidth, numBins  of g(r), in the inverse of that unit
    StructureSums(std::vector<double> wavenumbers, double binWidth, int numBins);
    void Add(std::span<const Point> centers);
    const std::vector<double>& Wavenumbers() const { return wavenumbers_; }
    /// (<|rho_q|^2> - |<rho_q>|^2) / <N>, rho_q = sum of e^{iq.r}, averaged over directions of q: the
    /// fluctuations alone.
    std::vector<double> StructureFactor() const;
    /// Pairs at a distance over those of independent points in a ball of this radius.
    std::vector<double> PairDistribution(double radius) const;
    double BinWidth() const { return binWidth_; }

  private:
    std::vector<double> wavenumbers_, squares_, means_, meanSquares_;
    double binWidth_, numPairs_ = 0;
    std::vector<double> pairs_;
    int64_t numPoints_ = 0;
    int numRealizations_ = 0;
};

}  // namespace lacquer::bulk
