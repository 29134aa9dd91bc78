// Far fields of a whole cluster, from its waves about one origin.
#pragma once

#include <span>
#include <vector>

#include "bulk/cluster/cluster.h"
#include "bulk/conventions.h"

namespace lacquer::bulk {

/// Outgoing coefficients about the origin, 2 NumHarmonics(degree) rows and a column for each incident
/// polarisation.
struct OneOriginWaves {
    int degree = 1;
    Eigen::MatrixX2cd coefficients;

    /// k^2 C_sca, by orthogonality exactly the integral of S_11 over all directions.
    CrossSection Scattering() const { return coefficients.colwise().squaredNorm().transpose().array(); }
    /// The integral of S_11 times the cosine between n and s over all directions s: g k^2 C_sca for light
    /// along n. Exact, as Scattering() is.
    CrossSection Asymmetry(Direction n) const;
    /// F(s), rows theta^ and phi^ of s, columns as the coefficients'.
    Eigen::Matrix2cd Amplitude(Direction s) const;
};
/// Degree that holds the far field of a cluster to 12 digits.
/// @param radius  of a ball about the origin that holds its spheres; @param degree  of its expansions
int FarFieldDegree(double radius, int degree);
int FarFieldDegree(const Cluster& cluster);
/// @param degree  as of FarFieldDegree(); O(N degree L^2)
OneOriginWaves AboutOrigin(const Cluster& cluster, const HelicityWaves& scattered, int degree);
/// The same for several solutions, which share the translations.
std::vector<OneOriginWaves> AboutOrigin(const Cluster& cluster, std::span<const HelicityWaves> scattered,
                                        int degree);

/// Vector harmonics at phi = 0 for fixed polar angles, to be used for many clusters.
class AzimuthalHarmonics {
  public:
    AzimuthalHarmonics(int degree, std::span<const double> thetas);
    int Degree() const { return degree_; }
    int NumAngles() const { return int(fields_.size()); }
    /// As FarField() at angle i.
    const Eigen::Matrix2Xcd& At(int i) const { return fields_[size_t(i)]; }

  private:
    int degree_;
    std::vector<Eigen::Matrix2Xcd> fields_;
};

/// For light along +z: the amplitude matrix in the basis of the scattering plane (incident and scattered
/// fields in it and perpendicular to it) and its products, averaged over the azimuth of the scattering plane,
/// exactly.
struct AzimuthalMeans {
    Eigen::Matrix2cd amplitude;  ///< mean of F
    /// Means of elements of the Mueller matrix of scattering [Bohren and Huffman 1983, eq. 3.16], in units in
    /// which the integral of S_11 is k^2 C_sca. Of S_12 and S_21, and of S_34 and -S_43, which are equal for
    /// isotropic ensembles with a mirror plane, the half sums.
    double s11 = 0, s12 = 0, s22 = 0, s33 = 0, s34 = 0, s44 = 0;
};
/// At each angle of `harmonics`, which may have a larger degree than the waves.
/// @param waves  of incident light along +z with polarisations x and y
std::vector<AzimuthalMeans> AzimuthalMeansOf(const OneOriginWaves& waves,
                                             const AzimuthalHarmonics& harmonics);

/// Equal steps of the azimuth from 0 to pi.
class EvenAzimuths {
  public:
    /// @param degree  of waves; @param count  of nodes, at least 2
    EvenAzimuths(int degree, int count);
    int Count() const { return int(cosines_.cols()); }
    int Degree() const { return int(cosines_.rows()) - 1; }
    /// cos(m phi_k) and sin(m phi_k) in row m and column k.
    const Eigen::MatrixXd& Cosines() const { return cosines_; }
    const Eigen::MatrixXd& Sines() const { return sines_; }

  private:
    Eigen::MatrixXd cosines_, sines_;
};

/// S_11 for unpolarised light, at angle i of `harmonics` and at all azimuths: the mean over phi and -phi.
/// @param waves  of incident light along any direction at the azimuth 0
Eigen::VectorXd IntensityAround(const OneOriginWaves& waves, const AzimuthalHarmonics& harmonics, int i,
                                const EvenAzimuths& azimuths);

}  // namespace lacquer::bulk
