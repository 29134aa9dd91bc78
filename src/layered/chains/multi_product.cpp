#include "layered/chains/multi_product.h"

#include "layered/chains/pair_walk.h"

namespace lacquer {

bool FindLobeFamily(const ChainEvent& event, float t, float side, LobeFamily* family) {
    // At normal incidence itself the plane of incidence is not known, and close to it the fits have a cusp.
    constexpr float kStep = 0.004f, kLowest = 0.06f, kHighest = 0.9998f;
    const float c = std::clamp(1 / std::sqrt(1 + t), kLowest + kStep, kHighest);
    const std::array<float, 2> cosines = {c, c - kStep};
    std::array<float, 2> squares{}, kappa{}, across{}, difference{};
    for (size_t i = 0; i < 2; ++i) {
        squares[i] = (1 - cosines[i]) * (1 + cosines[i]) / Sqr(cosines[i]);
        const float slope = std::sqrt(squares[i]);
        GaussianMixture lobe;
        if (!FindLobeOf(event.surface, event.transmits, DirectionOfSlope({slope, 0}, side), &lobe) ||
            lobe.count != 1)
            return false;
        const Gaussian2& g = lobe.parts[0];
        kappa[i] = g.meanX / slope;
        across[i] = g.yy;
        difference[i] = (g.xx - g.yy) / squares[i];
    }
    const auto jet = [&](const std::array<float, 2>& values) {
        return LobeFamily::Jet{values[0], (values[1] - values[0]) / (squares[1] - squares[0])};
    };
    *family = {jet(kappa), jet(across), jet(difference)};
    return family->V.value > 0 && family->V.value + family->W.value * t > 0;
}

// ---- The Gaussian over four coordinates -------------------------------------------------------------------

bool Gaussian4::Set(const Vector& mean, const Matrix& precision) {
    mean_ = mean;
    for (size_t j = 0; j < 4; ++j) {
        for (size_t i = j; i < 4; ++i) {
            float sum = precision[i][j];
            for (size_t k = 0; k < j; ++k) sum -= lower_[i][k] * lower_[j][k];
            if (i > j) {
                lower_[i][j] = sum / lower_[j][j];
            } else {
                // What is left of a pivot after cancellation must be more than rounding.
                if (!(sum > 1e-5f * precision[j][j])) return false;
                lower_[j][j] = std::sqrt(sum);
            }
        }
    }
    return true;
}

namespace {

/// Solves L' x = b.
Gaussian4::Vector SolveUpper(const Gaussian4::Matrix& lower, Gaussian4::Vector b) {
    for (size_t i = 4; i-- > 0;) {
        for (size_t k = i + 1; k < 4; ++k) b[i] -= lower[k][i] * b[k];
        b[i] /= lower[i][i];
    }
    return b;
}

}  // namespace

Gaussian4::Vector Gaussian4::Solve(const Vector& b) const {
    Vector y = b;
    for (size_t i = 0; i < 4; ++i) {
        for (size_t k = 0; k < i; ++k) y[i] -= lower_[i][k] * y[k];
        y[i] /= lower_[i][i];
    }
    return SolveUpper(lower_, y);
}

float Gaussian4::FromStandard(const Vector& normal, Vector* slopes) const {
    const Vector offset = SolveUpper(lower_, normal);
    float square = 0, volume = Inv2Pi * Inv2Pi;
    for (size_t i = 0; i < 4; ++i) {
        (*slopes)[i] = mean_[i] + offset[i];
        square += normal[i] * normal[i];
        volume *= lower_[i][i];
    }
    return volume * std::exp(-0.5f * square);
}

// ---- The middle event ----------------------------------------------------------------------------------

namespace {

/// Gradient of the middle event's exponent and normalisation
///   F = (log V + log(V + W t))/2 - (V d.d + W e^2)/2,   d = b - kappa a,   e = a.d,   t = a.a.
struct Gradient {
    Point2 a, b;
};
Gradient GradientOf(const LobeFamily& f, Point2 a, Point2 b) {
    const auto& [k, k1] = f.kappa;
    const auto& [v, v1] = f.V;
    const auto& [w, w1] = f.W;
    const Point2 d = b - k * a;
    const float t = glm::dot(a, a), e = glm::dot(a, d);
    // The precision in the plane of incidence.
    const float u = v + w * t, u1 = v1 + w1 * t + w;
    return {(v1 / v + u1 / u - v1 * glm::dot(d, d) - w1 * e * e) * a + v * (k * d + 2 * k1 * e * a) -
                w * e * (d - (k + 2 * k1 * t) * a),
            -v * d - w * e * a};
}

/// Adds scale * x x' to the 2x2 block (row, row) of a matrix.
void AddSquare(Gaussian4::Matrix& m, size_t row, float scale, Point2 x) {
    m[row][row] += scale * x.x * x.x;
    m[row][row + 1] += scale * x.x * x.y;
    m[row + 1][row] += scale * x.x * x.y;
    m[row + 1][row + 1] += scale * x.y * x.y;
}
/// Adds scale * x x' to the blocks (a, b) and (b, a).
void AddMixed(Gaussian4::Matrix& m, float scale, Point2 x) {
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) {
            m[size_t(i)][size_t(2 + j)] += scale * x[i] * x[j];
            m[size_t(2 + j)][size_t(i)] += scale * x[i] * x[j];
        }
    }
}

Gaussian4::Matrix Precisions(const Gaussian2& a, const Gaussian2& b) {
    Gaussian4::Matrix m{};
    m[0] = {a.xx, a.xy, 0, 0};
    m[1] = {a.xy, a.yy, 0, 0};
    m[2] = {0, 0, b.xx, b.xy};
    m[3] = {0, 0, b.xy, b.yy};
    return m;
}

/// Adds J' P J, J being the derivative of b - kappa a.
void AddLinearized(const LobeFamily& f, Point2 a, Gaussian4::Matrix& m) {
    // In the plane of incidence and across it J and P are diagonal.
    const float t = glm::dot(a, a), length = std::sqrt(t);
    const Point2 along = length > 0 ? a / length : Point2(1, 0), across(-along.y, along.x);
    const auto add = [&m](Point2 axis, float precision, float j) {
        AddSquare(m, 0, precision * j * j, axis);
        AddSquare(m, 2, precision, axis);
        AddMixed(m, precision * j, axis);
    };
    add(along, f.V.value + f.W.value * t, -(f.kappa.value + 2 * f.kappa.first * t));
    add(across, f.V.value, -f.kappa.value);
}

/// Standard deviation of the slope behind an event for facets of small slopes: those turn a reflection by
/// twice their own slope, a refraction by the part that Snell's law leaves.
/// @param eta  index on the side of the direction that is given over index on the other side; 0: reflection
float Spread(const ChainEvent& event, float eta) {
    constexpr float kSqrtHalf = 0.70710678f;
    return kSqrtHalf * event.surface.alphaX * (eta == 0 ? 2 : std::abs(1 - eta));
}

/// True where the product is far from Gaussian: weights have heavy tails, and pair products are better. Over
/// the spread of the ends' lobes the middle one's mean bends by about its square, which must be small
/// compared with the middle one's own spread. The bound was measured, see docs/product-sampling.md; with the
/// index 1.5 it refuses alphas below 0.06 under 0.3 and below 0.17 under 0.5.
bool BendsTooMuch(const Chain& chain) {
    constexpr float kLargest = 0.06f;
    const auto& [first, middle, last] = chain.events;
    // In units of the slope b; a middle refraction turns slopes of a into it by the quotient of the indices.
    const float outer = std::max(Spread(first, first.eta) * middle.eta, Spread(last, 1 / last.eta));
    return Sqr(outer) > kLargest * Spread(middle, middle.transmits ? middle.eta : 0);
}

}  // namespace

bool MultiProduct::Set(const Chain& chain) {
    if (chain.numEvents != 3 || BendsTooMuch(chain)) return false;
    for (const ChainEvent& event : chain.events)
        if (!event.IsIsotropic()) return false;
    if (IsDenseSide(chain.events[0].surface, chain.wi) || IsDenseSide(chain.events[2].surface, chain.wo))
        return false;
    // The ends' lobes; their means are where the middle one is expanded.
    GaussianMixture lobeA, lobeB;
    if (!FindLobeOf(chain.events[0].surface, true, chain.wi, &lobeA) || lobeA.count != 1) return false;
    if (!FindLobeOf(chain.events[2].surface, true, chain.wo, &lobeB) || lobeB.count != 1) return false;
    const Gaussian2 &gA = lobeA.parts[0], &gB = lobeB.parts[0];
    const Point2 a(gA.meanX, gA.meanY), b(gB.meanX, gB.meanY);
    LobeFamily middle;
    if (!FindLobeFamily(chain.events[1], glm::dot(a, a), -chain.signs[0], &middle)) return false;

    // The sum of the three exponents about (a, b), where those of the ends have no slope.
    Gaussian4::Matrix precision = Precisions(gA, gB);
    AddLinearized(middle, a, precision);
    if (!gaussian_.Set({}, precision)) return false;
    const Gradient gradient = GradientOf(middle, a, b);
    const Gaussian4::Vector step = gaussian_.Solve({gradient.a.x, gradient.a.y, gradient.b.x, gradient.b.y});
    gaussian_.SetMean({a.x + step[0], a.y + step[1], b.x + step[2], b.y + step[3]});
    chain_ = &chain;
    return true;
}

SampledSpectrum MultiProduct::Estimate(TransportMode mode, Rng& rng) const {
    const auto normals = [&rng] { return Gaussian2{}.Draw(rng.Uniform2D()); };
    const Point2 n0 = normals(), n1 = normals();
    Gaussian4::Vector slopes;
    const float pdfSlopes = gaussian_.FromStandard({n0.x, n0.y, n1.x, n1.y}, &slopes);
    const ChainDirections inner = {DirectionOfSlope({slopes[0], slopes[1]}, chain_->signs[0]),
                                   DirectionOfSlope({slopes[2], slopes[3]}, chain_->signs[1])};
    const float pdf = pdfSlopes * SlopePerSolidAngle(inner[0]) * SlopePerSolidAngle(inner[1]);
    return ChainValue(*chain_, inner, mode) / pdf;
}

bool MultiProductApplies(const Stack& stack, Vec3 wo, Vec3 wi) {
    Chain chain;
    return FindChain(stack, wo, wi, 3, &chain) && MultiProduct().Set(chain);
}

}  // namespace lacquer
