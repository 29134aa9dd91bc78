// Scattering of oriented ensembles on its grid of directions: integrals, and making it reciprocal.
#pragma once

#include <span>
#include <vector>

#include "pbrt/scattering/bulk_table.h"

namespace lacquer {

/// Nodes of incident and scattered directions of an OrientedBulkTable. Between nodes what is scattered,
/// sigma_s p, is linear in both cosines and in the azimuth, and so are sigma_s and sigma_a in the cosine.
class OrientedGrid {
  public:
    /// @param angles       [degrees], an odd number, symmetric about 90: 0 first, 180 last
    /// @param numAzimuths  at least 2
    OrientedGrid(std::span<const double> angles, int numAzimuths);
    explicit OrientedGrid(const OrientedBulkTable& table) : OrientedGrid(table.angles, table.numAzimuths) {}

    size_t NumAngles() const { return weights_.size(); }
    size_t NumIncidences() const { return weights_.size() / 2 + 1; }
    size_t NumAzimuths() const { return numAzimuths_; }
    /// Numbers of one wavelength.
    size_t Size() const { return NumIncidences() * NumAngles() * numAzimuths_; }
    /// Of an incidence, an angle and the first azimuth.
    size_t Index(size_t incidence, size_t angle) const {
        return (incidence * NumAngles() + angle) * numAzimuths_;
    }
    /// The incidence and angle of the same pair of directions, exchanged and reversed.
    std::pair<size_t, size_t> Reciprocal(size_t incidence, size_t angle) const {
        const size_t last = NumAngles() - 1;
        if (angle < NumIncidences()) return {angle, incidence};
        return {last - angle, last - incidence};
    }

    /// Integrals, exact for what is linear between nodes. Over the azimuth, all of the circle:
    template <class Number>
    double OverAzimuth(const Number* values) const {
        double sum = -0.5 * (double(values[0]) + double(values[numAzimuths_ - 1]));
        for (size_t k = 0; k < numAzimuths_; ++k) sum += double(values[k]);
        return 2 * sum * azimuthStep_;
    }
    /// Over all scattered directions, for an incidence of one wavelength.
    template <class Number>
    double OverSphere(std::span<const Number> values, size_t incidence) const {
        double sum = 0;
        for (size_t j = 0; j < NumAngles(); ++j)
            sum += weights_[j] * OverAzimuth(&values[Index(incidence, j)]);
        return sum;
    }
    /// Mean over all incident directions.
    double MeanOverIncidences(std::span<const double> values) const;
    /// Of the cosine between nodes, about angle j.
    double Weight(size_t j) const { return weights_[j]; }

  private:
    size_t numAzimuths_;
    double azimuthStep_;
    std::vector<double> weights_;
};

/// Makes what an ensemble of finitely many realisations scatters reciprocal, by the mean of each pair of
/// entries, and independent of the azimuth at the poles; and scales it, symmetrically in both directions, so
/// that its integrals are `sigmaS` of each incidence.
/// @param scattered  sigma_s p of one wavelength; not negative
/// @param sigmaS     positive; in the same unit
/// @return  the integral of what changed over that of all, mean over incidences
double MakeReciprocal(const OrientedGrid& grid, std::span<const double> sigmaS, std::span<double> scattered);

}  // namespace lacquer
