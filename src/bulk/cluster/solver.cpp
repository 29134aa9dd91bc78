// The linear system: GMRES on both columns in step, and a dense solver.
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "bulk/cluster/cluster.h"
#include "bulk/waves/translation.h"
#include "pbrt/core/check.h"

namespace lacquer::bulk {
namespace {

/// A complex number for each column.
struct PerColumn {
    Complex of[2];
};

/// x^H y.
PerColumn ColumnProducts(const HelicityWaves& x, const HelicityWaves& y) {
    HalfLanes real{}, imaginary{};
    for (size_t i = 0; i < x.Size(); ++i) {
        const Lanes &a = x.Data()[i], &b = y.Data()[i];
        real += Low(a) * Low(b) + High(a) * High(b);
        imaginary += Low(a) * High(b) - High(a) * Low(b);
    }
    return {
        {{real[0] + real[2], imaginary[0] + imaginary[2]}, {real[1] + real[3], imaginary[1] + imaginary[3]}}};
}

double Norm(const HelicityWaves& x, int column) { return std::sqrt(ColumnProducts(x, x).of[column].real()); }

/// y += a x.
void AddScaled(const PerColumn& a, const HelicityWaves& x, HelicityWaves* y) {
    const double r0 = a.of[0].real(), r1 = a.of[1].real(), i0 = a.of[0].imag(), i1 = a.of[1].imag();
    const HalfLanes real = {r0, r1, r0, r1}, imaginary = {i0, i1, i0, i1};
    for (size_t i = 0; i < x.Size(); ++i) {
        const HalfLanes re = Low(x.Data()[i]), im = High(x.Data()[i]);
        y->Data()[i] += Join(real * re - imaginary * im, real * im + imaginary * re);
    }
}

/// x *= 1/s column by column; a column of norm 0 becomes 0.
void Normalize(const double norms[2], HelicityWaves* x) {
    const double s0 = norms[0] > 0 ? 1 / norms[0] : 0, s1 = norms[1] > 0 ? 1 / norms[1] : 0;
    const Lanes scale = {s0, s1, s0, s1, s0, s1, s0, s1};
    for (size_t i = 0; i < x->Size(); ++i) x->Data()[i] *= scale;
}

/// Least squares of one column's Hessenberg matrix by Givens rotations, a column of it at a time.
class HessenbergLeastSquares {
  public:
    HessenbergLeastSquares(int size, double norm)
        : r_(Eigen::MatrixXcd::Zero(size, size)), rhs_(Eigen::VectorXcd::Zero(size + 1)) {
        rhs_[0] = norm;
    }
    /// @param h  entries 0 ... k of column k; @param below  entry k + 1, real and >= 0
    void AddColumn(int k, const Eigen::VectorXcd& h, double below) {
        Eigen::VectorXcd column = h;
        for (int i = 0; i < k; ++i) {
            const Complex upper = column[i];
            column[i] = std::conj(cosines_[size_t(i)]) * upper + sines_[size_t(i)] * column[i + 1];
            column[i + 1] = cosines_[size_t(i)] * column[i + 1] - sines_[size_t(i)] * upper;
        }
        const double length = std::hypot(std::abs(column[k]), below);
        const Complex cosine = length > 0 ? column[k] / length : 1.;
        const double sine = length > 0 ? below / length : 0;
        cosines_.push_back(cosine);
        sines_.push_back(sine);
        column[k] = length;
        r_.col(k).head(k + 1) = column.head(k + 1);
        rhs_[k + 1] = -sine * rhs_[k];
        rhs_[k] *= std::conj(cosine);
        size_ = k + 1;
    }
    double Residual() const { return std::abs(rhs_[size_]); }
    Eigen::VectorXcd Solution() const {
        Eigen::VectorXcd y = Eigen::VectorXcd::Zero(size_);
        for (int i = size_ - 1; i >= 0; --i) {
            Complex sum = rhs_[i];
            for (int j = i + 1; j < size_; ++j) sum -= r_(i, j) * y[j];
            y[i] = r_(i, i) != 0. ? sum / r_(i, i) : 0.;
        }
        return y;
    }

  private:
    Eigen::MatrixXcd r_;
    Eigen::VectorXcd rhs_;
    std::vector<Complex> cosines_;
    std::vector<double> sines_;
    int size_ = 0;
};

}  // namespace

ClusterSolver::ClusterSolver(const Cluster& cluster, size_t memory)
    : cluster_(cluster), coupling_(cluster.Centers(), cluster.Degree(), memory) {}

void ClusterSolver::ApplyT(const HelicityWaves& in, HelicityWaves* out) const {
    for (int i = 0; i < cluster_.NumSpheres(); ++i)
        for (int n = 1; n <= cluster_.Degree(); ++n) {
            const Complex magnetic = cluster_.TMagnetic(i)[size_t(n - 1)];
            const Complex electric = cluster_.TElectric(i)[size_t(n - 1)];
            // In u and v: half the sum keeps helicities, half the difference changes them.
            const Complex keep = 0.5 * (magnetic + electric), flip = 0.5 * (magnetic - electric);
            for (int k = HarmonicIndex(n, -n); k <= HarmonicIndex(n, n); ++k) {
                const HalfLanes re = Low(in.Of(i)[k]), im = High(in.Of(i)[k]);
                const HalfLanes swappedRe = SwapPairs(re), swappedIm = SwapPairs(im);
                out->Of(i)[k] = Join(
                    keep.real() * re - keep.imag() * im + flip.real() * swappedRe - flip.imag() * swappedIm,
                    keep.real() * im + keep.imag() * re + flip.real() * swappedIm + flip.imag() * swappedRe);
            }
        }
}

ScatteredWaves ClusterSolver::Solve(const HelicityWaves& incident, const SolverOptions& options) const {
    const int numSpheres = cluster_.NumSpheres(), degree = cluster_.Degree();
    ScatteredWaves result;
    HelicityWaves rhs(numSpheres, degree), residual, work(numSpheres, degree);
    ApplyT(incident, &rhs);
    result.coefficients = HelicityWaves(numSpheres, degree);
    residual = rhs;
    const double norms[2] = {Norm(rhs, 0), Norm(rhs, 1)};
    std::vector<HelicityWaves> basis;
    result.coupled = HelicityWaves(numSpheres, degree);
    const auto relative = [&](const double r[2]) {  // infinite for what is no number
        if (!std::isfinite(r[0] + r[1] + norms[0] + norms[1])) return std::numeric_limits<double>::infinity();
        return std::max(norms[0] > 0 ? r[0] / norms[0] : 0, norms[1] > 0 ? r[1] / norms[1] : 0);
    };
    const auto multiply = [&](const HelicityWaves& x, HelicityWaves* y) {  // y = (1 - T H) x
        coupling_.Apply(x, &result.coupled);
        ++result.numProducts;
        ApplyT(result.coupled, &work);
        *y = x;
        AddScaled({{-1., -1.}}, work, y);
    };
    while (true) {
        const double start[2] = {Norm(residual, 0), Norm(residual, 1)};
        result.residual = relative(start);
        result.hasConverged = result.residual <= options.residual;
        if (result.hasConverged || result.numProducts >= options.maxProducts ||
            !std::isfinite(result.residual))
            break;
        // One cycle of Arnoldi's process for both columns.
        basis.assign(1, residual);
        Normalize(start, &basis[0]);
        HessenbergLeastSquares squares[2] = {{options.restart, start[0]}, {options.restart, start[1]}};
        for (int k = 0; k < options.restart && result.numProducts < options.maxProducts; ++k) {
            HelicityWaves next;
            multiply(basis[size_t(k)], &next);
            Eigen::VectorXcd h[2] = {Eigen::VectorXcd(k + 1), Eigen::VectorXcd(k + 1)};
            for (int i = 0; i <= k; ++i) {
                const PerColumn dot = ColumnProducts(basis[size_t(i)], next);
                h[0][i] = dot.of[0];
                h[1][i] = dot.of[1];
                AddScaled({{-dot.of[0], -dot.of[1]}}, basis[size_t(i)], &next);
            }
            const double below[2] = {Norm(next, 0), Norm(next, 1)};
            Normalize(below, &next);
            basis.push_back(std::move(next));
            double left[2];
            for (int column = 0; column < 2; ++column) {
                squares[column].AddColumn(k, h[column], below[column]);
                left[column] = squares[column].Residual();
            }
            if (relative(left) <= 0.9 * options.residual) break;
        }
        const Eigen::VectorXcd y[2] = {squares[0].Solution(), squares[1].Solution()};
        for (int i = 0; i < y[0].size(); ++i)
            AddScaled({{y[0][i], y[1][i]}}, basis[size_t(i)], &result.coefficients);
        multiply(result.coefficients, &residual);
        for (size_t i = 0; i < residual.Size(); ++i) residual.Data()[i] = rhs.Data()[i] - residual.Data()[i];
    }
    return result;
}

struct DenseClusterSolver::Factors {
    Eigen::PartialPivLU<Eigen::MatrixXcd> lu;
};

DenseClusterSolver::DenseClusterSolver(const Cluster& cluster) : cluster_(cluster) {
    const int rows = 2 * NumHarmonics(cluster.Degree()), degree = cluster.Degree();
    Eigen::MatrixXcd matrix = Eigen::MatrixXcd::Identity(NumUnknowns(cluster), NumUnknowns(cluster));
    for (int i = 0; i < cluster.NumSpheres(); ++i)
        for (int j = 0; j < cluster.NumSpheres(); ++j) {
            if (i == j) continue;
            const Point d = cluster.At(i).center - cluster.At(j).center;
            matrix.block(i * rows, j * rows, rows, rows) =
                (-DiagonalOfT(i)).asDiagonal() * Translation(d, degree, degree).Matrix();
        }
    factors_ = std::make_unique<Factors>(Factors{Eigen::PartialPivLU<Eigen::MatrixXcd>(matrix)});
}

DenseClusterSolver::~DenseClusterSolver() = default;

Eigen::VectorXcd DenseClusterSolver::DiagonalOfT(int sphere) const {
    const int size = NumHarmonics(cluster_.Degree());
    Eigen::VectorXcd t(2 * size);
    for (int n = 1; n <= cluster_.Degree(); ++n) {
        t.segment(HarmonicIndex(n, -n), 2 * n + 1).setConstant(cluster_.TMagnetic(sphere)[size_t(n - 1)]);
        t.segment(size + HarmonicIndex(n, -n), 2 * n + 1)
            .setConstant(cluster_.TElectric(sphere)[size_t(n - 1)]);
    }
    return t;
}

Eigen::MatrixXcd DenseClusterSolver::Solve(const Eigen::MatrixXcd& incident) const {
    Eigen::MatrixXcd rhs(incident.rows(), incident.cols());
    const int rows = 2 * NumHarmonics(cluster_.Degree());
    for (int i = 0; i < cluster_.NumSpheres(); ++i)
        rhs.middleRows(i * rows, rows) = DiagonalOfT(i).asDiagonal() * incident.middleRows(i * rows, rows);
    return factors_->lu.solve(rhs);
}

}  // namespace lacquer::bulk
