// Logarithms of reflectances as smooth functions of the parameters, learnt from noisy simulations.
#pragma once

#include <vector>

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// The leading principal components of all values together, each a quadratic polynomial and a Gaussian
/// process of the parameters [Higdon et al. 2008]. Simulations at other points average the noise of each one
/// out, so what is left of it is far below the error of a single simulation, and is known: Errors().
class LobeEmulator {
  public:
    struct Options {
        Eigen::Index maxComponents = 16;
        Eigen::Index maxTuningRuns = 110;  ///< by which length scales are chosen
        /// Values of one simulation err together, as channels of one path do: errors of components are then
        /// at least those of independent values, and as large as their scatter says.
        bool errsTogether = false;
    };
    /// @param points  coordinates: a column for each simulation
    /// @param values  logarithms: a row for each simulation
    /// @param errors  their standard errors, likewise; zero where simulations are exact
    /// Errors: CheckError for fewer than 2 d + 6 simulations.
    LobeEmulator(const Matrix& points, const Matrix& values, const Matrix& errors, const Options& options);
    LobeEmulator(const Matrix& points, const Matrix& values, const Matrix& errors)
        : LobeEmulator(points, values, errors, Options()) {}

    Eigen::Index NumValues() const { return center_.size(); }
    Eigen::Index NumComponents() const { return components_.cols(); }
    /// Coefficients of the components at a point.
    /// @param derivatives  by its coordinates, a row for each component; null: not wanted
    Vector Coefficients(const Vector& point, Matrix* derivatives) const;
    /// All values of given coefficients.
    Vector Values(const Vector& coefficients) const { return center_ + components_ * coefficients; }
    Vector Predict(const Vector& point) const { return Values(Coefficients(point, nullptr)); }
    /// A column for each component: what the values change by.
    const Matrix& Components() const { return components_; }
    /// Variances of the coefficients: of what few and noisy simulations leave open at a point.
    Vector Variances(const Vector& point) const;
    /// Of the coefficients of one simulation, by its own errors.
    const Vector& NoiseVariances() const { return noise_; }
    /// For each value the variance that no component has, beyond the noise of simulations.
    const Vector& Remainder() const { return remainder_; }

  private:
    struct Process {
        double variance = 0, nugget = 1;  ///< of the function, and of noise in units of it
        Vector weights;                   ///< of the kernels at the simulations
        Matrix inverse;                   ///< of kernel + nugget
        Vector trend;
    };
    void FindComponents(const Matrix& values, const Matrix& errors, Eigen::Index maxComponents);
    void FitTrend();
    void TuneLengths(Eigen::Index maxRuns);
    void FitProcesses();
    Vector Kernels(const Vector& standardized) const;
    /// 1, coordinates, and with many simulations their products.
    Vector TrendTerms(const Vector& standardized) const;
    Matrix TrendDesign() const;  ///< of the simulations: a row for each
    Vector TrendDerivative(const Vector& standardized, Eigen::Index i) const;
    Vector Standardized(const Vector& point) const { return (point - origin_).cwiseProduct(inverseScale_); }

    Vector origin_, inverseScale_;
    Matrix points_;  ///< standardized
    bool isQuadratic_ = false, errsTogether_ = false;
    Vector center_, remainder_;
    Vector noise_;                      ///< variances of the simulations' coefficients by their own errors
    Matrix components_, coefficients_;  ///< of the simulations: a row for each
    Matrix trendGram_;                  ///< inverse
    Vector lengths_;
    std::vector<Process> processes_;
};

}  // namespace lacquer::estimate
