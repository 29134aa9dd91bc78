// A cluster of spheres and the light that it scatters: the superposition T-matrix.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "bulk/cluster/coupling.h"
#include "bulk/conventions.h"
#include "bulk/mie/mie.h"

namespace lacquer::bulk {

/// A sphere at its place.
struct Sphere {
    Point center{0, 0, 0};            ///< times k
    std::vector<SphereLayer> layers;  ///< from the core outwards; one for a homogeneous sphere

    double Radius() const { return layers.back().x; }
    bool IsLossless() const;
};
Sphere MakeSphere(const Point& center, double x, Complex m);

/// Spheres with what each of them alone does to waves. Expansions of all have one degree; the T-matrix of a
/// sphere with a smaller degree of its own has zeros above it.
class Cluster {
  public:
    /// @param spheres      at least one; they may touch but not overlap
    /// @param extraDegree  on top of MieDegree() of each sphere: about 2 in dense media, 6 where spheres
    /// touch
    explicit Cluster(const std::vector<Sphere>& spheres, int extraDegree = 0);
    /// The same degree for all.
    static Cluster WithDegree(std::vector<Sphere> spheres, int degree);

    int NumSpheres() const { return int(spheres_.size()); }
    int Degree() const { return degree_; }
    const Sphere& At(int i) const { return spheres_[size_t(i)]; }
    std::vector<Point> Centers() const;
    /// Diagonal of the T-matrix of sphere i: factors of M_nm and of N_nm, n = 1 ... Degree() at index n - 1.
    const std::vector<Complex>& TMagnetic(int i) const { return magnetic_[size_t(i)]; }
    const std::vector<Complex>& TElectric(int i) const { return electric_[size_t(i)]; }
    /// Of a ball about the origin that holds all spheres.
    double Radius() const;

  private:
    Cluster(std::vector<Sphere> spheres, std::span<const int> degrees);

    std::vector<Sphere> spheres_;
    int degree_ = 1;
    std::vector<std::vector<Complex>> magnetic_, electric_;
};

/// Two plane waves along one direction, of unit amplitude along theta^ (column 0) and phi^ (column 1), about
/// the centres of all spheres.
HelicityWaves IncidentWaves(const Cluster& cluster, Direction n);

/// k^2 C of the two columns.
using CrossSection = Eigen::Array2d;

/// c_i - T_i sum_{j != i} H_ij c_j = T_i a_i, solved for both columns together.
struct ScatteredWaves {
    HelicityWaves coefficients;
    HelicityWaves coupled;  ///< H c: what the waves of all others are about each centre
    int numProducts = 0;
    double residual = 0;  ///< |T a - (1 - T H) c| / |T a|, the larger one of both columns
    bool hasConverged = false;
};

struct SolverOptions {
    double residual = 1e-4;  ///< relative; 1e-4 for tables, 1e-10 for tests
    int maxProducts = 500;
    int restart = 60;
};

/// The linear system of a cluster. Thread-safe after construction.
class ClusterSolver {
  public:
    /// @param memory  bytes for tables of pairs
    explicit ClusterSolver(const Cluster& cluster, size_t memory = size_t(2) << 30);
    /// By GMRES with restarts [Saad and Schultz 1986].
    ScatteredWaves Solve(const HelicityWaves& incident, const SolverOptions& options = {}) const;
    const Coupling& GetCoupling() const { return coupling_; }
    /// T times waves.
    void ApplyT(const HelicityWaves& in, HelicityWaves* out) const;

  private:
    const Cluster& cluster_;
    Coupling coupling_;
};

/// The dense matrix 1 - T H, factored: for small clusters and many directions. O((N L^2)^3) time, 32 (N
/// L^2)^2 bytes.
class DenseClusterSolver {
  public:
    explicit DenseClusterSolver(const Cluster& cluster);
    /// @param incident  2 NumHarmonics rows for each sphere, one sphere after the other
    Eigen::MatrixXcd Solve(const Eigen::MatrixXcd& incident) const;
    ~DenseClusterSolver();
    static int NumUnknowns(const Cluster& cluster) {
        return cluster.NumSpheres() * 2 * NumHarmonics(cluster.Degree());
    }

  private:
    struct Factors;
    Eigen::VectorXcd DiagonalOfT(int sphere) const;

    const Cluster& cluster_;
    std::unique_ptr<const Factors> factors_;
};

/// k^2 C_ext by the optical theorem, -Re c.a*; of one sphere: its own term.
CrossSection ExtinctionOf(const Cluster& cluster, const HelicityWaves& scattered,
                          const HelicityWaves& incident, int sphere);
CrossSection ExtinctionOf(const Cluster& cluster, const HelicityWaves& scattered,
                          const HelicityWaves& incident);
/// The same for the incident waves that `scattered` solves exactly, T^-1 c - H c, whatever its residual:
/// energy is then conserved to rounding, C_ext = C_abs + C_sca.
CrossSection ExtinctionOfSolved(const Cluster& cluster, const ScatteredWaves& scattered);
/// k^2 C_abs from the fields that excite the spheres; 0 for lossless ones.
CrossSection AbsorptionOf(const Cluster& cluster, const HelicityWaves& scattered, int sphere);
CrossSection AbsorptionOf(const Cluster& cluster, const HelicityWaves& scattered);
/// k^2 C_sca as a sum over pairs of spheres, by regular translations. O(N^2 L^3): slower than a product.
CrossSection ScatteringByPairs(const Cluster& cluster, const HelicityWaves& scattered);

}  // namespace lacquer::bulk
