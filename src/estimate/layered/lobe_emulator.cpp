#include "estimate/layered/lobe_emulator.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

#include "estimate/random.h"
#include "pbrt/core/check.h"

namespace lacquer::estimate {

namespace {

/// Nuggets that are tried: from almost exact functions to nearly nothing but noise.
std::vector<double> Nuggets() {
    std::vector<double> nuggets;
    for (double nugget = 1e-7; nugget < 200; nugget *= std::sqrt(10.)) nuggets.push_back(nugget);
    return nuggets;
}

Matrix KernelMatrix(const Matrix& points, const Vector& lengths) {
    const Matrix scaled = lengths.cwiseInverse().asDiagonal() * points;
    const Vector squares = scaled.colwise().squaredNorm();
    Matrix distances = -2 * scaled.transpose() * scaled;
    distances.colwise() += squares;
    distances.rowwise() += squares.transpose();
    return (-0.5 * distances.array().max(0)).exp();
}

/// The noise that simulations are known to have.
struct KnownNoise {
    double variance = 0;   ///< 0: they are exact
    bool isLeast = false;  ///< it may be more
    /// Of the function, for a nugget, where `best` is the best one for it.
    double FunctionVariance(double nugget, double best) const {
        if (!(variance > 0)) return best;
        return isLeast ? std::max(best, variance / nugget) : variance / nugget;
    }
};

/// The best nugget of one component, by the likelihood.
struct NuggetFit {
    double nugget = 1, logLikelihood = -std::numeric_limits<double>::infinity();
};
NuggetFit BestNugget(const Vector& eigenvalues, const Vector& rotated, const KnownNoise& noise) {
    NuggetFit best;
    const auto count = double(rotated.size());
    for (const double nugget : Nuggets()) {
        const Eigen::ArrayXd scales = eigenvalues.array().max(0) + nugget;
        const double squares = (rotated.array().square() / scales).sum();
        const double variance = noise.FunctionVariance(nugget, squares / count + 1e-300);
        const double value = -0.5 * (count * std::log(variance) + scales.log().sum() + squares / variance);
        if (value > best.logLikelihood) best = {nugget, value};
    }
    return best;
}

/// Leading right singular vectors by a random sketch [Halko et al. 2011], from the largest down.
Matrix LeadingDirections(const Matrix& z, Eigen::Index count, Vector* singularValues) {
    const Eigen::Index size = std::min({count + 8, z.cols(), z.rows()});
    Matrix sketch(z.cols(), size);
    Random random(uint64_t(7), uint64_t(z.cols()));
    for (double& number : sketch.reshaped()) number = random.Normal();
    for (int i = 0; i < 4; ++i) {
        const Matrix image = z.transpose() * (z * sketch);
        sketch = Eigen::HouseholderQR<Matrix>(image).householderQ() * Matrix::Identity(z.cols(), size);
    }
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen((z * sketch).transpose() * (z * sketch));
    const Eigen::Index kept = std::min(count, size);
    *singularValues = eigen.eigenvalues().reverse().head(kept).cwiseMax(0).cwiseSqrt();
    return sketch * eigen.eigenvectors().rowwise().reverse().leftCols(kept);
}

}  // namespace

LobeEmulator::LobeEmulator(const Matrix& points, const Matrix& values, const Matrix& errors,
                           const Options& options) {
    errsTogether_ = options.errsTogether;
    const Eigen::Index d = points.rows(), n = points.cols();
    LACQUER_CHECK(n >= 2 * d + 6 && values.rows() == n && errors.rows() == n);
    origin_ = points.rowwise().mean();
    const Vector sds = ((points.colwise() - origin_).rowwise().squaredNorm() / double(n)).cwiseSqrt();
    inverseScale_ = sds.cwiseMax(1e-12).cwiseInverse();
    points_ = inverseScale_.asDiagonal() * (points.colwise() - origin_);
    isQuadratic_ = n >= 3 * (d + 1) * (d + 2) / 2 + 10;
    FindComponents(values, errors, options.maxComponents);
    FitTrend();
    TuneLengths(options.maxTuningRuns);
    FitProcesses();
}

void LobeEmulator::FindComponents(const Matrix& values, const Matrix& errors, Eigen::Index maxComponents) {
    constexpr double kTypicalNoise = 0.03;  // of measurements: what is noisier than this counts less
    const auto n = double(values.rows()), m = double(values.cols());
    center_ = values.colwise().mean();
    const Vector noise = errors.colwise().squaredNorm() / n;
    const Vector weights = (noise.array() + kTypicalNoise * kTypicalNoise).rsqrt();
    const Matrix z = (values.rowwise() - center_.transpose()) * weights.asDiagonal();
    // First what follows the parameters: a regression hides the noise, so that small changes are seen.
    const Matrix design = TrendDesign();
    const Matrix fitted = design * design.colPivHouseholderQr().solve(z);
    Vector singularValues;
    const Matrix ofTrend = LeadingDirections(
        fitted, std::min({maxComponents * 3 / 4, z.cols(), design.cols() - 1}), &singularValues);
    Eigen::Index count = 0;
    while (count < singularValues.size() && singularValues[count] > 1e-5 * singularValues[0]) ++count;
    Matrix directions = ofTrend.leftCols(std::max<Eigen::Index>(1, count));
    // Then what no quadratic polynomial has. Noise alone has components as large as the threshold.
    const double noiseLevel = noise.cwiseProduct(weights.cwiseAbs2()).mean();
    const double threshold = std::max(noiseLevel * (1 + std::sqrt(m / n)) * (1 + std::sqrt(m / n)),
                                      1e-9 * singularValues[0] * singularValues[0] / n);
    const Matrix ofRest =
        LeadingDirections(z - z * directions * directions.transpose(),
                          std::min(maxComponents, z.cols()) - directions.cols(), &singularValues);
    for (count = 0;
         count < singularValues.size() && singularValues[count] * singularValues[count] / n > threshold;)
        ++count;
    directions =
        (Matrix(z.cols(), directions.cols() + count) << directions, ofRest.leftCols(count)).finished();
    noise_ = directions.cwiseAbs2().transpose() * noise.cwiseProduct(weights.cwiseAbs2());
    coefficients_ = z * directions;
    components_ = weights.cwiseInverse().asDiagonal() * directions;
    const Matrix rest = z - coefficients_ * directions.transpose();
    remainder_ = (rest.colwise().squaredNorm().transpose() / n).cwiseQuotient(weights.cwiseAbs2());
    // Variances of n numbers are right within a part sqrt(2 / n): what lies within two of these is noise.
    remainder_ = (remainder_ - (1 + 2 * std::sqrt(2 / n)) * noise).cwiseMax(0);
}

Vector LobeEmulator::TrendTerms(const Vector& t) const {
    const Eigen::Index d = t.size();
    Vector terms(isQuadratic_ ? (d + 1) * (d + 2) / 2 : d + 1);
    terms[0] = 1;
    terms.segment(1, d) = t;
    Eigen::Index next = d + 1;
    for (Eigen::Index a = 0; isQuadratic_ && a < d; ++a)
        for (Eigen::Index b = a; b < d; ++b) terms[next++] = t[a] * t[b];
    return terms;
}

Vector LobeEmulator::TrendDerivative(const Vector& t, Eigen::Index i) const {
    const Eigen::Index d = t.size();
    Vector terms = Vector::Zero(isQuadratic_ ? (d + 1) * (d + 2) / 2 : d + 1);
    terms[1 + i] = 1;
    Eigen::Index next = d + 1;
    for (Eigen::Index a = 0; isQuadratic_ && a < d; ++a)
        for (Eigen::Index b = a; b < d; ++b) terms[next++] = (a == i ? t[b] : 0) + (b == i ? t[a] : 0);
    return terms;
}

Matrix LobeEmulator::TrendDesign() const {
    Matrix design(points_.cols(), TrendTerms(points_.col(0)).size());
    for (Eigen::Index i = 0; i < points_.cols(); ++i) design.row(i) = TrendTerms(points_.col(i));
    return design;
}

void LobeEmulator::FitTrend() {
    const Eigen::Index n = points_.cols();
    const Matrix design = TrendDesign();
    Matrix gram = design.transpose() * design;
    gram.diagonal().array() += 1e-9 * double(n);
    trendGram_ = gram.ldlt().solve(Matrix::Identity(gram.rows(), gram.cols()));
    const Matrix trends = trendGram_ * (design.transpose() * coefficients_);
    processes_.resize(size_t(coefficients_.cols()));
    for (size_t k = 0; k < processes_.size(); ++k) processes_[k].trend = trends.col(Eigen::Index(k));
    coefficients_ -= design * trends;  // what is left to the processes
}

void LobeEmulator::TuneLengths(Eigen::Index maxRuns) {
    const Eigen::Index n = points_.cols(), used = std::min(n, maxRuns), d = points_.rows();
    std::vector<Eigen::Index> some;
    for (Eigen::Index i = 0; i < used; ++i) some.push_back((2 * i + 1) * n / (2 * used));
    const Matrix points = points_(Eigen::all, some), values = coefficients_(some, Eigen::all);
    const auto judge = [&](const Vector& lengths, bool keeps) {
        const Eigen::SelfAdjointEigenSolver<Matrix> eigen(KernelMatrix(points, lengths));
        const Matrix rotated = eigen.eigenvectors().transpose() * values;
        double sum = 0;
        for (Eigen::Index k = 0; k < values.cols(); ++k) {
            const NuggetFit fit = BestNugget(eigen.eigenvalues(), rotated.col(k), {noise_[k], errsTogether_});
            sum += fit.logLikelihood;
            if (keeps) processes_[size_t(k)].nugget = fit.nugget;
        }
        return sum;
    };
    lengths_ = Vector::Constant(d, 2);
    double best = judge(lengths_, false);
    for (const double factor : {2., 1.5})
        for (Eigen::Index i = 0; i < d; ++i)
            for (const double change : {factor, 1 / factor}) {
                bool isBetter = false;
                for (;;) {
                    Vector tried = lengths_;
                    tried[i] *= change;
                    if (tried[i] < 0.3 || tried[i] > 12) break;
                    const double value = judge(tried, false);
                    if (value <= best) break;
                    best = value;
                    lengths_ = tried;
                    isBetter = true;
                }
                if (isBetter) break;
            }
    judge(lengths_, true);
}

void LobeEmulator::FitProcesses() {
    const Matrix kernel = KernelMatrix(points_, lengths_);
    const Eigen::Index n = kernel.rows();
    for (size_t k = 0; k < processes_.size(); ++k) {
        Process& process = processes_[k];
        const Matrix noisy = kernel + process.nugget * Matrix::Identity(n, n);
        const Eigen::LLT<Matrix> factor(noisy);
        const auto values = coefficients_.col(Eigen::Index(k));
        process.weights = factor.solve(values);
        process.variance = KnownNoise{noise_[Eigen::Index(k)], errsTogether_}.FunctionVariance(
            process.nugget, values.dot(process.weights) / double(n));
        process.inverse = factor.solve(Matrix::Identity(n, n));
    }
}

Vector LobeEmulator::Kernels(const Vector& t) const {
    const Matrix differences = lengths_.cwiseInverse().asDiagonal() * (points_.colwise() - t);
    return (-0.5 * differences.colwise().squaredNorm().array()).exp().matrix().transpose();
}

Vector LobeEmulator::Coefficients(const Vector& point, Matrix* derivatives) const {
    const Vector t = Standardized(point), kernels = Kernels(t), terms = TrendTerms(t);
    const Eigen::Index d = t.size();
    Vector values(NumComponents());
    if (derivatives) derivatives->resize(NumComponents(), d);
    Matrix slopes(d, kernels.size());
    if (derivatives)
        slopes = (lengths_.cwiseAbs2().cwiseInverse().asDiagonal() * (points_.colwise() - t)) *
                 kernels.asDiagonal();
    for (Eigen::Index k = 0; k < values.size(); ++k) {
        const Process& process = processes_[size_t(k)];
        values[k] = kernels.dot(process.weights) + terms.dot(process.trend);
        if (derivatives) derivatives->row(k) = slopes * process.weights;
    }
    for (Eigen::Index i = 0; derivatives && i < d; ++i) {
        const Vector slope = TrendDerivative(t, i);
        for (Eigen::Index k = 0; k < values.size(); ++k)
            (*derivatives)(k, i) =
                ((*derivatives)(k, i) + slope.dot(processes_[size_t(k)].trend)) * inverseScale_[i];
    }
    return values;
}

Vector LobeEmulator::Variances(const Vector& point) const {
    const Vector t = Standardized(point), kernels = Kernels(t), terms = TrendTerms(t);
    const double leverage = terms.dot(trendGram_ * terms);
    Vector variances(NumComponents());
    for (Eigen::Index k = 0; k < variances.size(); ++k) {
        const Process& process = processes_[size_t(k)];
        const double ofProcess = std::max(0., 1 - kernels.dot(process.inverse * kernels));
        variances[k] = process.variance * (ofProcess + process.nugget * leverage);
    }
    return variances;
}

}  // namespace lacquer::estimate
