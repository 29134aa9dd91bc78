#include "bulk/cluster/cluster.h"

#include <algorithm>
#include <numeric>

#include "bulk/waves/harmonics.h"
#include "bulk/waves/regular_translation.h"
#include "pbrt/core/check.h"

namespace lacquer::bulk {
namespace {

std::vector<int> DegreesOf(const std::vector<Sphere>& spheres, int extraDegree) {
    std::vector<int> degrees;
    for (const Sphere& sphere : spheres) degrees.push_back(MieDegree(sphere.Radius()) + extraDegree);
    return degrees;
}

}  // namespace

bool Sphere::IsLossless() const {
    return std::all_of(layers.begin(), layers.end(),
                       [](const SphereLayer& layer) { return layer.index.imag() == 0; });
}

Sphere MakeSphere(const Point& center, double x, Complex m) { return {center, {{x, m}}}; }

Cluster::Cluster(const std::vector<Sphere>& spheres, int extraDegree)
    : Cluster(spheres, DegreesOf(spheres, extraDegree)) {}

Cluster Cluster::WithDegree(std::vector<Sphere> spheres, int degree) {
    const std::vector<int> degrees(spheres.size(), degree);
    return Cluster(std::move(spheres), degrees);
}

Cluster::Cluster(std::vector<Sphere> spheres, std::span<const int> degrees) : spheres_(std::move(spheres)) {
    LACQUER_CHECK(!spheres_.empty() && spheres_.size() == degrees.size());
    degree_ = *std::max_element(degrees.begin(), degrees.end());
    for (size_t i = 0; i < spheres_.size(); ++i) {
        const MieCoefficients mie = MieOfLayers(spheres_[i].layers, degrees[i]);
        std::vector<Complex> magnetic(size_t(degree_), 0.), electric(size_t(degree_), 0.);
        for (size_t n = 0; n < mie.a.size(); ++n) {
            magnetic[n] = -mie.b[n];
            electric[n] = -mie.a[n];
        }
        magnetic_.push_back(std::move(magnetic));
        electric_.push_back(std::move(electric));
    }
}

std::vector<Point> Cluster::Centers() const {
    std::vector<Point> centers;
    for (const Sphere& sphere : spheres_) centers.push_back(sphere.center);
    return centers;
}

double Cluster::Radius() const {
    double radius = 0;
    for (const Sphere& sphere : spheres_) radius = std::max(radius, sphere.center.norm() + sphere.Radius());
    return radius;
}

HelicityWaves IncidentWaves(const Cluster& cluster, Direction n) {
    const Eigen::MatrixX2cd wave = PlaneWave(cluster.Degree(), n);
    const Point direction = n.Vector();
    HelicityWaves waves(cluster.NumSpheres(), cluster.Degree());
    for (int i = 0; i < cluster.NumSpheres(); ++i)
        waves.Set(i, std::polar(1., direction.dot(cluster.At(i).center)) * wave);
    return waves;
}

CrossSection ExtinctionOf(const Cluster& cluster, const HelicityWaves& scattered,
                          const HelicityWaves& incident, int sphere) {
    // Lane by lane: the real part of c.a* is the product of the real parts plus that of the imaginary ones.
    Lanes sum{};
    for (int i = 0; i < NumHarmonics(cluster.Degree()); ++i)
        sum += scattered.Of(sphere)[i] * incident.Of(sphere)[i];
    return {-(sum[0] + sum[2] + sum[4] + sum[6]), -(sum[1] + sum[3] + sum[5] + sum[7])};
}

CrossSection ExtinctionOf(const Cluster& cluster, const HelicityWaves& scattered,
                          const HelicityWaves& incident) {
    CrossSection sum(0, 0);
    for (int i = 0; i < cluster.NumSpheres(); ++i) sum += ExtinctionOf(cluster, scattered, incident, i);
    return sum;
}

namespace {

/// Sum of |c|^2 weight(t) over the coefficients of a sphere, t being their entries of T.
template <class Weight>
CrossSection WeightedSquares(const Cluster& cluster, const HelicityWaves& scattered, int sphere,
                             const Weight& weight) {
    const Eigen::MatrixX2cd c = scattered.Get(sphere);
    const int size = NumHarmonics(cluster.Degree());
    CrossSection sum(0, 0);
    for (int n = 1; n <= cluster.Degree(); ++n) {
        const Complex magnetic = cluster.TMagnetic(sphere)[size_t(n - 1)];
        const Complex electric = cluster.TElectric(sphere)[size_t(n - 1)];
        const int first = HarmonicIndex(n, -n), count = 2 * n + 1;
        // Degrees that a sphere does not scatter have no coefficients.
        constexpr double kNothing = 1e-140;
        for (int column = 0; column < 2; ++column) {
            if (std::abs(magnetic) > kNothing)
                sum[column] += weight(magnetic) * c.col(column).segment(first, count).squaredNorm();
            if (std::abs(electric) > kNothing)
                sum[column] += weight(electric) * c.col(column).segment(size + first, count).squaredNorm();
        }
    }
    return sum;
}

}  // namespace

CrossSection ExtinctionOfSolved(const Cluster& cluster, const ScatteredWaves& scattered) {
    // -Re c^H (c/t - H c).
    CrossSection sum = -ExtinctionOf(cluster, scattered.coefficients, scattered.coupled);
    for (int i = 0; i < cluster.NumSpheres(); ++i)
        sum += WeightedSquares(cluster, scattered.coefficients, i,
                               [&](Complex t) { return cluster.At(i).IsLossless() ? 1. : -(1. / t).real(); });
    return sum;
}

CrossSection AbsorptionOf(const Cluster& cluster, const HelicityWaves& scattered, int sphere) {
    if (cluster.At(sphere).IsLossless()) return {0, 0};
    // |e|^2 (-Re t - |t|^2) with e = c/t.
    return WeightedSquares(cluster, scattered, sphere, [](Complex t) { return -(1. / t).real() - 1; });
}

CrossSection AbsorptionOf(const Cluster& cluster, const HelicityWaves& scattered) {
    CrossSection sum(0, 0);
    for (int i = 0; i < cluster.NumSpheres(); ++i) sum += AbsorptionOf(cluster, scattered, i);
    return sum;
}

CrossSection ScatteringByPairs(const Cluster& cluster, const HelicityWaves& scattered) {
    CrossSection sum(0, 0);
    const RegularTranslation translation(cluster.Degree(), cluster.Degree(), 2 * cluster.Radius());
    for (int i = 0; i < cluster.NumSpheres(); ++i) {
        const Eigen::MatrixX2cd c = scattered.Get(i);
        Eigen::MatrixXcd others = Eigen::MatrixXcd::Zero(c.rows(), 2);
        for (int j = i + 1; j < cluster.NumSpheres(); ++j)
            others += translation.Apply(cluster.At(i).center - cluster.At(j).center, scattered.Get(j));
        for (int column = 0; column < 2; ++column)
            sum[column] += c.col(column).squaredNorm() + 2 * c.col(column).dot(others.col(column)).real();
    }
    return sum;
}

}  // namespace lacquer::bulk
