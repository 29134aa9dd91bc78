// What dielectric coats transmit and reflect, from tables that the build computes.
#pragma once

#include <array>

#include "layered/lambertian/coat_grid.h"
#include "pbrt/base/bxdf.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {

/// Light that comes in at one angle.
struct CoatTransmittance {
    float clear;  ///< t without a slab [1]
    /// t = clear exp(-tau m), and m for any tau follows from these.
    std::array<float, CoatGrid::kEntryPaths> paths;
};

/// The tables at one boundary: functions of the cosine alone. Of coats that are the same everywhere a
/// material keeps them, since most of the time of a query goes into the roughness, the index and the slab.
class CoatCurves {
  public:
    /// For a boundary that Coat::IsKnown(). 2 KB, 10 us.
    /// @param tau  optical thickness of the slab; of others some things are computed at each query
    CoatCurves(MicrofacetModel model, float alpha, float eta, float tau);
    bool AreOf(MicrofacetModel model, float alpha, float eta) const {
        return model == model_ && alpha == alpha_ && eta == eta_;
    }

  private:
    friend class Coat;

    MicrofacetModel model_;
    float alpha_, eta_, tau_;
    float reflectance_;                                     ///< R of this slab
    std::array<float, CoatGrid::kEntryPaths> pathWeights_;  ///< of the entry paths, for m of this slab
    // As in the file: see CoatGrid.
    std::array<std::array<float, CoatGrid::kEntryChannels>, CoatGrid::kCos> entry_;
    std::array<float, CoatGrid::kReturnChannels> back_;
    std::array<std::array<float, CoatGrid::kCos>, CoatGrid::kDensityChannels> density_;
};

/// One isotropic dielectric boundary, smooth or rough. Cheap to make; a value type for one query.
///
/// Errors of the cubic interpolation, the largest of 80,000 random coats: of t, 3e-4 for cosTheta > 0.1 and
/// 6e-4 from 0.01 on (below, 2e-2 over absorbing slabs); of R, 6e-5. See docs/product-sampling.md.
class Coat {
  public:
    /// True if the tables know a boundary: alpha 0 (smooth) or in [kSmoothAlpha, 1], eta in [1.05, 2.5].
    /// @param eta  index below over index above
    static bool IsKnown(float alpha, float eta) {
        return alpha >= 0 && alpha <= 1 && eta >= CoatGrid::kMinEta && eta <= CoatGrid::kMaxEta;
    }
    /// For a known boundary above a slab of optical thickness tau.
    /// @param curves  of this boundary, if there are any; the results are the same without, but for rounding
    Coat(MicrofacetModel model, float alpha, float eta, SampledSpectrum tau,
         const CoatCurves* curves = nullptr);

    /// t(w): the share of the light along w that gets to the lower side of the slab,
    ///   t(w) = int f*(w, u) exp(-tau/|cos u|) |cos u| eta^2 du.   cosTheta in (0,1]
    CoatTransmittance Transmittance(float cosTheta) const;
    /// t(w) t(w') for two directions.
    SampledSpectrum Product(const CoatTransmittance& a, const CoatTransmittance& b) const;
    /// R: the share of light with a cosine lobe, from the lower side of the slab, that comes back to it.
    SampledSpectrum Reflectance() const { return reflectance_; }

    // The same of walks by LayeredBxDF::Sample(), without their weights.
    /// The probability of getting below the coat.
    float ProbabilityIn(float cosTheta) const;
    /// The density with which light that has a cosine lobe below leaves at this angle [1/sr].
    float PdfOut(float cosTheta) const;
    /// The probability of light that has a cosine lobe below to come down again.
    float ProbabilityBack() const { return probabilityBack_; }

  private:
    friend class CoatCurves;

    /// Four nodes of one axis and their weights, by Lagrange.
    struct Stencil {
        int first = 0;
        std::array<float, 4> weights{};
        Stencil() = default;
        Stencil(float coordinate, int count);
    };
    /// The tables around one boundary.
    struct Surroundings {
        const float* tables = nullptr;  ///< of the model
        Stencil alpha, eta;
        Surroundings() = default;
        Surroundings(MicrofacetModel model, float alphaAt, float etaAt);
        /// At the boundary, of numbers that follow each other in each of the rows for the nodes.
        /// @param first     in the first row
        /// @param distance  from a row to the next
        template <class Vector>
        Vector At(size_t first, size_t distance) const;
        /// All of the table "back".
        std::array<float, CoatGrid::kReturnChannels> Back() const;
    };
    float DensityAt(float cosTheta, size_t channel) const;
    /// R for one optical thickness. @param back  R without a slab, and the mean paths
    static float ReflectanceAt(float tau, const float* back);
    static std::array<float, CoatGrid::kEntryPaths> PathWeightsAt(float tau);
    void SetReflectance(const float* back);

    const CoatCurves* curves_;   ///< null: none
    Surroundings surroundings_;  ///< empty where there are curves
    float alpha_, eta_;
    SampledSpectrum tau_, reflectance_;
    float probabilityBack_;
    bool isClear_, isGray_, curvesHaveTau_ = false;
};

}  // namespace lacquer::layered
