#include "pbrt/core/sigmoid_fit.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

namespace lacquer {
namespace {

constexpr int kRes = kSigmoidTableRes;

/// The fit works on x = a0 u^2 + a1 u + a2 with u = -1 at the first and 1 at the last wavelength.
using Coefficients = FitVec3;

/// Distance of the quadrature nodes that stand for the wavelengths of the problem [nm].
constexpr double kNodeSpacing = 5;

/// Nodes are handled in groups of this size, so that compilers can vectorise the sums.
constexpr std::size_t kLanes = 4;

/// Residual [CIELAB] at which a fit is done: far below what a table of floats can hold.
constexpr double kTolerance = 1e-5;

/// Evaluations of the model a single fit may use. Only unreachable colours need more than about 8.
constexpr int kMaxEvaluations = 30;

/// Relative decrease of the squared residual below which a step counts as no progress.
constexpr double kMinDecrease = 1e-3;

/// Largest magnitude of a coefficient of x as a polynomial in (u + 1) / 2, i.e. over the unit interval.
/// Unreachable colours would take them to infinity. Floats in nm still resolve x to 1e-3 here. A cap of 200
/// leaves 5 % of the sRGB nodes unreached, nearly all with z < 0.01; this one 0.6 %, all with z < 0.002.
constexpr double kMaxCoefficient = 1000;

/// Largest |x| that a spectrum may exceed at every wavelength, met near black and white: there s is within
/// 6e-6 of 0 or 1. More would only spoil the interpolation between white and the nodes next to it.
constexpr double kMaxSaturation = 200;

/// First level of z to be fitted, 64 / 5: dark enough that each ratio of components is reachable.
constexpr int kFirstLevel = kRes / 5;

/// Wavelengths u and weights such that XYZ = sum_i weight[i] s(u[i]), Y = 1 for s = 1.
struct Quadrature {
    std::vector<double> u;
    std::array<std::vector<double>, 3> weight;
    FitVec3 white{};
    double midNm = 0, halfNm = 1;
};

/// XYZ of a spectrum and its derivatives, jacobian[channel][coefficient].
struct Colour {
    FitVec3 xyz{};
    FitMat3 jacobian{};
};

/// Coefficients, the residual there, target minus current in CIELAB, and d(Lab)/d(coefficient).
struct FitState {
    Coefficients a{};
    FitVec3 residual{};
    FitMat3 jacobian{};
    double error = std::numeric_limits<double>::infinity();  // squared length of the residual
};

double Smoothstep(double t) { return t * t * (3 - 2 * t); }

FitVec3 Multiply(const FitMat3& m, const FitVec3& v) {
    FitVec3 r{};
    for (std::size_t i = 0; i < 3; ++i) r[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    return r;
}

FitVec3 Cross(const FitVec3& a, const FitVec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double Dot(const FitVec3& a, const FitVec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Solves m v = b by Cramer's rule; m is symmetric. Not finite if m is singular.
FitVec3 SolveSymmetric(const FitMat3& m, const FitVec3& b) {
    const FitVec3 c0 = Cross(m[1], m[2]), c1 = Cross(m[2], m[0]), c2 = Cross(m[0], m[1]);
    const double invDet = 1 / Dot(m[0], c0);
    FitVec3 v{};
    for (std::size_t i = 0; i < 3; ++i) v[i] = (b[0] * c0[i] + b[1] * c1[i] + b[2] * c2[i]) * invDet;
    return v;
}

/// Lays out nodes at about kNodeSpacing and gives each sample's weight to the four nodes around it in the
/// proportions of cubic Lagrange interpolation: sums over the samples of any function times a cubic are kept
/// exactly, though there are fewer nodes. The observer and the illuminant are not smoothed by this.
Quadrature MakeQuadrature(const SigmoidFitProblem& problem) {
    const double first = problem.nm.front(), last = problem.nm.back();
    const int numNodes = std::max(4, static_cast<int>(std::lround((last - first) / kNodeSpacing)) + 1);
    const std::size_t padded = (static_cast<std::size_t>(numNodes) + kLanes - 1) / kLanes * kLanes;
    Quadrature q;
    q.midNm = (first + last) / 2;
    q.halfNm = (last - first) / 2;
    q.u.assign(padded, 0.0);
    for (int i = 0; i < numNodes; ++i) q.u[static_cast<std::size_t>(i)] = -1 + 2.0 * i / (numNodes - 1);

    // Scale to Y = 1 for s = 1.
    double luminance = 0;
    for (std::size_t i = 0; i < problem.nm.size(); ++i)
        luminance += problem.observer[i][1] * problem.illuminant[i];
    for (std::size_t c = 0; c < 3; ++c) {
        q.weight[c].assign(padded, 0.0);
        for (std::size_t i = 0; i < problem.nm.size(); ++i) {
            // Find the stencil of four nodes and the position in it.
            const double sample = problem.observer[i][c] * problem.illuminant[i] / luminance;
            const double position = (problem.nm[i] - first) / (last - first) * (numNodes - 1);
            const int base = std::clamp(static_cast<int>(std::floor(position)) - 1, 0, numNodes - 4);
            const double t = position - base;
            const FitVec3 d = {t - 1, t - 2, t - 3};
            const std::array<double, 4> lagrange = {-d[0] * d[1] * d[2] / 6, t * d[1] * d[2] / 2,
                                                    -t * d[0] * d[2] / 2, t * d[0] * d[1] / 6};
            for (std::size_t j = 0; j < 4; ++j)
                q.weight[c][static_cast<std::size_t>(base) + j] += sample * lagrange[j];
            q.white[c] += sample;
        }
    }
    return q;
}

/// Colour of the spectrum of coefficients `a` under the illuminant, with derivatives.
Colour EvaluateColour(const Quadrature& q, const Coefficients& a) {
    // Rows: XYZ; then d(XYZ)/da0, d(XYZ)/da1, d(XYZ)/da2.
    double sum[4][3][kLanes] = {};
    const double* weights[3] = {q.weight[0].data(), q.weight[1].data(), q.weight[2].data()};
    for (std::size_t i = 0; i < q.u.size(); i += kLanes) {
        double term[4][kLanes];
        for (std::size_t l = 0; l < kLanes; ++l) {
            const double u = q.u[i + l];
            const double x = (a[0] * u + a[1]) * u + a[2];
            const double invRoot = 1 / std::sqrt(1 + x * x);
            const double slope = 0.5 * invRoot * invRoot * invRoot;
            term[0][l] = 0.5 + 0.5 * x * invRoot;
            term[1][l] = slope * u * u;
            term[2][l] = slope * u;
            term[3][l] = slope;
        }
        for (std::size_t r = 0; r < 4; ++r)
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t l = 0; l < kLanes; ++l) sum[r][c][l] += weights[c][i + l] * term[r][l];
    }
    Colour colour;
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t l = 0; l < kLanes; ++l) {
            colour.xyz[c] += sum[0][c][l];
            for (std::size_t j = 0; j < 3; ++j) colour.jacobian[c][j] += sum[j + 1][c][l];
        }
    }
    return colour;
}

/// The compression of CIELAB and its derivative: a cube root, continued by a straight line towards 0 and
/// below. `t` is X/Xn, Y/Yn or Z/Zn.   Source: CIE 15:2004 sec. 8.2.1.1
std::array<double, 2> LabCompress(double t) {
    constexpr double kDelta = 6.0 / 29;
    if (t > kDelta * kDelta * kDelta) {
        const double root = std::cbrt(t);
        return {root, 1 / (3 * root * root)};
    }
    return {t / (3 * kDelta * kDelta) + 4.0 / 29, 1 / (3 * kDelta * kDelta)};
}

FitVec3 LabFromCompressed(const FitVec3& f) {
    return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

FitVec3 LabFromXyz(const FitVec3& xyz, const FitVec3& white) {
    FitVec3 f{};
    for (std::size_t c = 0; c < 3; ++c) f[c] = LabCompress(xyz[c] / white[c])[0];
    return LabFromCompressed(f);
}

FitState EvaluateState(const Quadrature& q, const FitVec3& targetLab, const Coefficients& a) {
    const Colour colour = EvaluateColour(q, a);
    // Carry value and derivatives through the compression.
    FitVec3 f{};
    FitMat3 df{};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto [value, slope] = LabCompress(colour.xyz[c] / q.white[c]);
        f[c] = value;
        for (std::size_t j = 0; j < 3; ++j) df[c][j] = slope / q.white[c] * colour.jacobian[c][j];
    }
    FitState state;
    state.a = a;
    const FitVec3 lab = LabFromCompressed(f);
    for (std::size_t j = 0; j < 3; ++j) {
        state.jacobian[0][j] = 116 * df[1][j];
        state.jacobian[1][j] = 500 * (df[0][j] - df[1][j]);
        state.jacobian[2][j] = 200 * (df[1][j] - df[2][j]);
        state.residual[j] = targetLab[j] - lab[j];
    }
    state.error = Dot(state.residual, state.residual);
    return state;
}

/// Smallest |x| over the range of wavelengths; 0 if x changes its sign there.
double SmallestMagnitude(const Coefficients& a) {
    const double atFirst = a[0] - a[1] + a[2], atLast = a[0] + a[1] + a[2];
    double low = std::min(atFirst, atLast), high = std::max(atFirst, atLast);
    // Take the vertex, u = -a1 / (2 a0), into account if it is inside.
    if (std::abs(a[1]) < std::abs(2 * a[0])) {
        const double vertex = a[2] - a[1] * a[1] / (4 * a[0]);
        low = std::min(low, vertex);
        high = std::max(high, vertex);
    }
    return std::max({0.0, low, -high});
}

/// Scales the coefficients so that they respect kMaxCoefficient and kMaxSaturation. Scaling keeps the
/// wavelengths of s = 1/2.
Coefficients Capped(const Coefficients& a) {
    const double largest =
        std::max({std::abs(4 * a[0]), std::abs(2 * a[1] - 4 * a[0]), std::abs(a[0] - a[1] + a[2])});
    const double excess = std::max(largest / kMaxCoefficient, SmallestMagnitude(a) / kMaxSaturation);
    if (excess <= 1) return a;
    return {a[0] / excess, a[1] / excess, a[2] / excess};
}

/// One step from `state` with the diagonal of the normal equations raised by the fraction `damping`
/// (0: Gauss-Newton), capped.
Coefficients Step(const FitState& state, double damping) {
    FitMat3 normal{};
    FitVec3 gradient{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t r = 0; r < 3; ++r) normal[i][j] += state.jacobian[r][i] * state.jacobian[r][j];
            gradient[i] += state.jacobian[j][i] * state.residual[j];
        }
        normal[i][i] *= 1 + damping;
    }
    const FitVec3 delta = SolveSymmetric(normal, gradient);
    return Capped({state.a[0] + delta[0], state.a[1] + delta[1], state.a[2] + delta[2]});
}

/// Takes Gauss-Newton steps, damped once one fails to improve, until the target is met or nothing helps.
FitState Fit(const Quadrature& q, const FitVec3& targetLab, const Coefficients& start) {
    constexpr double kFirstDamping = 1e-3, kMinDamping = 1e-6, kMaxDamping = 1e4;
    FitState best = EvaluateState(q, targetLab, start);
    double damping = 0;
    for (int i = 1; i < kMaxEvaluations && best.error > kTolerance * kTolerance; ++i) {
        const FitState next = EvaluateState(q, targetLab, Step(best, damping));
        if (next.error < best.error) {  // false for NaN
            const bool stalled = next.error > (1 - kMinDecrease) * best.error;
            best = next;
            if (stalled) break;
            damping = damping > kMinDamping ? damping / 10 : 0;
        } else {
            damping = std::max(kFirstDamping, damping * 10);
            if (damping > kMaxDamping) break;
        }
    }
    return best;
}

/// Coefficients over u to coefficients over the wavelength in nm.
FitVec3 CoefficientsInNm(const Quadrature& q, const Coefficients& a) {
    const double s = 1 / q.halfNm, m = q.midNm;
    return {a[0] * s * s, a[1] * s - 2 * a[0] * m * s * s, (a[0] * m * s - a[1]) * m * s + a[2]};
}

/// Fits the colours of one l and y, i.e. 64 columns along z, into the table.
class SliceFitter {
  public:
    SliceFitter(const SigmoidFitProblem& problem, const Quadrature& q, SigmoidTable* table, int l, int j)
        : problem_(problem), q_(q), table_(table), l_(static_cast<std::size_t>(l)), j_(j) {}

    void Run() {
        Coefficients start = {0, 0, 0};
        for (int i = kRes - 1; i >= 0; --i) {
            // Go down and up from the first level, which follows its neighbour in x.
            start = FitNode(i, kFirstLevel, start);
            Coefficients a = start;
            for (int k = kFirstLevel + 1; k < kRes; ++k) a = FitNode(i, k, a);
            a = start;
            for (int k = kFirstLevel - 1; k >= 0; --k) a = FitNode(i, k, a);
        }
    }

    double MaxResidual() const { return maxResidual_; }
    int NumUnreached() const { return numUnreached_; }

  private:
    Coefficients FitNode(int i, int k, const Coefficients& start) {
        // Find the target and fit it.
        const double z = SigmoidTableZNode(k);
        FitVec3 rgb{};
        rgb[l_] = z;
        rgb[(l_ + 1) % 3] = z * i / (kRes - 1);
        rgb[(l_ + 2) % 3] = z * j_ / (kRes - 1);
        const FitVec3 target = LabFromXyz(Multiply(problem_.xyzFromRgb, rgb), q_.white);
        const FitState fit = Fit(q_, target, start);

        // Record coefficients and quality.
        const FitVec3 c = CoefficientsInNm(q_, fit.a);
        const std::size_t res = kRes;
        const std::size_t node =
            ((l_ * res + static_cast<std::size_t>(k)) * res + static_cast<std::size_t>(j_)) * res +
            static_cast<std::size_t>(i);
        for (std::size_t n = 0; n < 3; ++n) table_->coefficients[node * 3 + n] = static_cast<float>(c[n]);
        const double residual = std::sqrt(fit.error);
        maxResidual_ = std::max(maxResidual_, residual);
        if (k > 0 && residual > kSigmoidResidualReached) ++numUnreached_;
        return fit.a;
    }

    const SigmoidFitProblem& problem_;
    const Quadrature& q_;
    SigmoidTable* table_;
    std::size_t l_;
    int j_;
    double maxResidual_ = 0;
    int numUnreached_ = 0;
};

}  // namespace

double SigmoidTableZNode(int k) { return Smoothstep(Smoothstep(static_cast<double>(k) / (kRes - 1))); }

double EvaluateSigmoid(const FitVec3& c, double nm) {
    const double x = (c[0] * nm + c[1]) * nm + c[2];
    return 0.5 + 0.5 * x / std::sqrt(1 + x * x);
}

FitMat3 XyzFromRgbMatrix(const std::array<std::array<double, 2>, 3>& primaries,
                         const std::array<double, 2>& white) {
    // Primaries and white at x + y + z = 1.
    std::array<FitVec3, 3> p{};
    for (std::size_t i = 0; i < 3; ++i)
        p[i] = {primaries[i][0], primaries[i][1], 1 - primaries[i][0] - primaries[i][1]};
    const FitVec3 w = {white[0] / white[1], 1, (1 - white[0] - white[1]) / white[1]};

    // Find how much of each primary makes the white, by Cramer's rule.
    const double invDet = 1 / Dot(p[0], Cross(p[1], p[2]));
    FitMat3 m{};
    for (std::size_t i = 0; i < 3; ++i) {
        const double amount = Dot(w, Cross(p[(i + 1) % 3], p[(i + 2) % 3])) * invDet;
        for (std::size_t c = 0; c < 3; ++c) m[c][i] = amount * p[i][c];
    }
    return m;
}

SigmoidTable FitSigmoidTable(const SigmoidFitProblem& problem, int numThreads) {
    const Quadrature q = MakeQuadrature(problem);
    SigmoidTable table;
    table.coefficients.resize(kSigmoidTableSize);
    for (int k = 0; k < kRes; ++k)
        table.zNodes[static_cast<std::size_t>(k)] = static_cast<float>(SigmoidTableZNode(k));

    // Fit the slices, each by one thread and into its own part of the table.
    std::vector<SliceFitter> slices;
    for (int l = 0; l < 3; ++l)
        for (int j = 0; j < kRes; ++j) slices.emplace_back(problem, q, &table, l, j);
    std::atomic<std::size_t> nextSlice{0};
    const auto work = [&slices, &nextSlice] {
        for (std::size_t i = nextSlice++; i < slices.size(); i = nextSlice++) slices[i].Run();
    };
    {
        std::vector<std::jthread> threads;
        for (int i = 1; i < numThreads; ++i) threads.emplace_back(work);
        work();
    }
    for (const SliceFitter& slice : slices) {
        table.maxResidual = std::max(table.maxResidual, slice.MaxResidual());
        table.numUnreached += slice.NumUnreached();
    }
    return table;
}

}  // namespace lacquer
