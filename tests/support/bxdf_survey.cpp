// Quadrature over the sphere, and the checks that share a set of samples; see bxdf_checks.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pbrt/core/sampling.h"
#include "support/bxdf_checks.h"

namespace lacquer::test {
namespace {

/// Adaptive integration over cells in (cos theta, phi).
class SphereQuadrature {
  public:
    /// @param error  by which two levels may differ in a part    @param numSamples  drawn to find the points
    SphereQuadrature(const BxDFSetup& setup, double error, int numSamples, uint64_t seed)
        : setup_(setup),
          error_(error),
          numSamples_(numSamples),
          rng_(seed),
          context_{setup.mode, Lobes::BothSides, &rng_} {}

    struct Rect {
        double cos0, cos1, phi0, phi1;
        Rect Half(bool alongCos, bool upper) const {
            Rect r = *this;
            double &low = alongCos ? r.cos0 : r.phi0, &high = alongCos ? r.cos1 : r.phi1;
            (upper ? low : high) = 0.5 * (low + high);
            return r;
        }
    };
    struct Sums {
        double pdf = 0, x = 0, y = 0, z = 0, reflected = 0;
        bool alongCos = false;  ///< the pdf varies more along cos theta than along phi
        void Add(const Sums& b) {
            pdf += b.pdf;
            x += b.x;
            y += b.y;
            z += b.z;
            reflected += b.reflected;
        }
    };

    static Vec3 Direction(double c, double phi) {
        const double sine = std::sqrt((1 - c) * (1 + c));
        return {float(sine * std::cos(phi)), float(sine * std::sin(phi)), float(c)};
    }
    BxDFValue Value(double c, double phi) {
        return setup_.bxdf.Evaluate(setup_.wo, Direction(c, phi), context_);
    }

    /// Gauss's rule of 2 x 2 points.
    Sums Rule(const Rect& r) {
        constexpr double kNode = 0.57735026918962576451;
        Sums sums;
        double values[2][2];
        const double weight = 0.25 * (r.cos1 - r.cos0) * (r.phi1 - r.phi0);
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j < 2; ++j) {
                const double c = 0.5 * (r.cos0 + r.cos1 + (i ? kNode : -kNode) * (r.cos1 - r.cos0));
                const double phi = 0.5 * (r.phi0 + r.phi1 + (j ? kNode : -kNode) * (r.phi1 - r.phi0));
                const Vec3 wi = Direction(c, phi);
                const BxDFValue v = Value(c, phi);
                const double p = double(v.pdf) * weight;
                values[i][j] = p;
                sums.Add({p, p * double(wi.x), p * double(wi.y), p * double(wi.z),
                          double(v.f.Average()) * std::abs(c) * c * c * weight});
            }
        const double alongCos = std::abs(values[0][0] - values[1][0]) + std::abs(values[0][1] - values[1][1]);
        const double alongPhi = std::abs(values[0][0] - values[0][1]) + std::abs(values[1][0] - values[1][1]);
        // Where the rule sees nothing, halve the longer side (the length along phi has a factor of the sine).
        const double sine = std::sqrt(std::max(0., 1 - r.cos1 * r.cos0));
        const bool isHigher = r.cos1 - r.cos0 > sine * sine * (r.phi1 - r.phi0);
        sums.alongCos = alongCos == alongPhi ? isHigher : alongCos > alongPhi;
        return sums;
    }

    /// True if the density is zero at some corners of r only, or zero at all of them and not within (or the
    /// other way).
    bool IsCut(const Rect& r, bool isPositiveInside) {
        int numPositive = 0;
        for (const double c : {r.cos0, r.cos1})
            for (const double phi : {r.phi0, r.phi1}) numPositive += Value(c, phi).pdf > 0;
        return numPositive != (isPositiveInside ? 4 : 0);
    }

    /// Halves r until two levels agree and few of `points` (cos theta, phi) are left inside.
    Sums Refine(const Rect& r, const Sums& rule, std::span<std::pair<double, double>> points, int depth,
                bool cut) {
        // Rounding in narrow lobes keeps small parts from agreeing better than to the row's tolerance.
        const double tolerance = error_ + (depth > 12 ? 0.3 * setup_.tolerance : 1e-5) * rule.pdf;
        constexpr size_t kFew = 8;
        const Rect lower = r.Half(rule.alongCos, false), upper = r.Half(rule.alongCos, true);
        Sums a = Rule(lower), b = Rule(upper);
        // An edge of the density cuts the rectangle: the rules may agree and both miss it.
        const bool isCut = cut && depth < 10 && IsCut(r, a.pdf + b.pdf > 0);
        // So may they where a ridge or a peak runs between their nodes; then more samples fall here than they
        // say.
        const bool missesPeak = (a.pdf + b.pdf) * numSamples_ < 0.3 * double(points.size());
        const auto agreesWithRule = [&](const Sums& c, const Sums& d) {
            return std::abs(c.pdf + d.pdf - rule.pdf) < tolerance &&
                   std::abs(c.reflected + d.reflected - rule.reflected) < tolerance;
        };
        bool agrees = !isCut && !missesPeak && agreesWithRule(a, b);
        // Halves along one axis say nothing of the other one.
        if (agrees && std::max(rule.pdf, rule.reflected) > tolerance)
            agrees = agreesWithRule(Rule(r.Half(!rule.alongCos, false)), Rule(r.Half(!rule.alongCos, true)));
        if ((!agrees && depth < 24) || (points.size() > kFew && depth < 44)) {
            const auto middle = std::partition(points.begin(), points.end(), [&](const auto& p) {
                return rule.alongCos ? p.first < lower.cos1 : p.second < lower.phi1;
            });
            const size_t numLower = size_t(middle - points.begin());
            a = Refine(lower, a, points.first(numLower), depth + 1, isCut);
            b = Refine(upper, b, points.subspan(numLower), depth + 1, isCut);
        }
        a.Add(b);
        return a;
    }

  private:
    const BxDFSetup& setup_;
    double error_, numSamples_;
    Rng rng_;
    BxDFContext context_;
};

size_t CellOf(double c, double phi, int numCos, int numPhi) {
    const int i = std::clamp(int((c + 1) * 0.5 * numCos), 0, numCos - 1);
    const int j = std::clamp(int(phi / (2 * M_PI) * numPhi), 0, numPhi - 1);
    return size_t(i) * size_t(numPhi) + size_t(j);
}

double PhiOf(Vec3 w) {
    const double phi = double(std::atan2(w.y, w.x));
    return phi < 0 ? phi + 2 * M_PI : phi;
}

}  // namespace

SphereIntegrals Integrate(const BxDFSetup& s, uint64_t seed, double error) {
    constexpr int kNumSamples = 40000;
    constexpr int kNumCos = SphereIntegrals::kNumCos, kNumPhi = SphereIntegrals::kNumPhi;
    // See where the samples fall. The angle from the pole is taken from the sine where the cosine is too
    // coarse.
    std::vector<std::vector<std::pair<double, double>>> points(size_t{kNumCos} * kNumPhi);
    Rng rng(seed);
    const BxDFContext context{s.mode, Lobes::BothSides, &rng};
    for (int i = 0; i < kNumSamples; ++i) {
        const auto sample = s.bxdf.Sample(s.wo, Draw(rng), context);
        if (!sample || sample->IsSpecular()) continue;
        const double sine = std::hypot(double(sample->wi.x), double(sample->wi.y));
        const double c = std::copysign(
            sine < 0.5 ? std::sqrt(1 - sine * sine) : std::abs(double(sample->wi.z)), double(sample->wi.z));
        const double phi = PhiOf(sample->wi);
        points[CellOf(c, phi, kNumCos, kNumPhi)].emplace_back(c, phi);
    }

    // Integrate cell by cell.
    SphereQuadrature quadrature(s, error, kNumSamples, Hash(seed, 1));
    SphereIntegrals integrals;
    integrals.error = error;
    integrals.pdf.resize(points.size());
    double x = 0, y = 0, z = 0;
    for (int i = 0; i < kNumCos; ++i)
        for (int j = 0; j < kNumPhi; ++j) {
            const size_t cell = size_t(i) * kNumPhi + size_t(j);
            const SphereQuadrature::Rect rect{-1 + 2. * i / kNumCos, -1 + 2. * (i + 1) / kNumCos,
                                              2 * M_PI * j / kNumPhi, 2 * M_PI * (j + 1) / kNumPhi};
            SphereQuadrature::Sums sums = quadrature.Rule(rect);
            const bool isCut = quadrature.IsCut(rect, sums.pdf > 0);
            const bool isEmpty = sums.pdf == 0 && sums.reflected == 0 && points[cell].empty() && !isCut;
            if (!isEmpty && !s.stochastic) sums = quadrature.Refine(rect, sums, points[cell], 0, isCut);
            integrals.pdf[cell] = sums.pdf;
            integrals.total += sums.pdf;
            integrals.reflected += sums.reflected;
            x += sums.x;
            y += sums.y;
            z += sums.z;
        }
    integrals.moment = {float(x), float(y), float(z)};
    return integrals;
}

Survey TakeSurvey(const BxDFSetup& s, const SphereIntegrals& integrals, int numSamples, uint64_t seed) {
    constexpr int kNumCos = SphereIntegrals::kNumCos, kNumPhi = SphereIntegrals::kNumPhi;
    constexpr int kCoarse = 8;  // fine cells along each side of a coarse one
    constexpr int kCoarseCos = kNumCos / kCoarse, kCoarsePhi = kNumPhi / kCoarse;
    // The bounds on what is not noise: convergence of the quadrature, rounding.
    constexpr double kRounding = 1e-5;
    const double bias = 10 * integrals.error + 0.2 * s.tolerance;

    Rng rng(seed);
    const BxDFContext context{s.mode, Lobes::BothSides, &rng};
    std::vector<double> counts(integrals.pdf.size());
    RunningMean success, reflected, moments[3], albedo[kNumWavelengths];
    bool isExact = !s.stochastic;
    for (int n = 0; n < numSamples; ++n) {
        const auto sample = s.bxdf.Sample(s.wo, Draw(rng), context);
        const bool counted = sample && !sample->IsSpecular();
        if (counted) isExact = isExact && sample->pdfExact;
        const Vec3 wi = counted ? sample->wi : Vec3(0);
        if (counted) ++counts[CellOf(double(wi.z), PhiOf(wi), kNumCos, kNumPhi)];
        success.Add(counted);
        for (int k = 0; k < 3; ++k) moments[k].Add(double(wi[k]));
        reflected.Add(counted ? double(sample->weight.Average() * wi.z * wi.z) : 0);
        // Energy: radiance comes out of refraction divided by eta^2.
        const bool scaled = sample && sample->IsTransmission() && s.mode == TransportMode::Radiance;
        const float scale = scaled ? sample->eta * sample->eta : 1;
        for (int k = 0; k < kNumWavelengths; ++k)
            albedo[k].Add(sample ? double(sample->weight[k] * scale) : 0);
    }

    Survey survey;
    // C7, at each wavelength.
    std::vector<Outcome> bounds;
    for (const RunningMean& a : albedo) {
        bounds.push_back(ZTest(a, 1, kRounding, "albedo"));
        if (!s.lossless && a.Mean() < 1) bounds.back().pValue = 1;
    }
    survey.albedo = WorstOf(bounds);

    // C8; a stochastic Evaluate() is averaged over uniform directions.
    RunningMean uniform;
    if (s.stochastic)
        for (int n = 0; n < numSamples; ++n) {
            const Vec3 wi = SampleUniformSphere(rng.Uniform2D());
            const float f = s.bxdf.Evaluate(s.wo, wi, context).f.Average();
            uniform.Add(double(f * AbsCosTheta(wi) * wi.z * wi.z / PdfUniformSphere()));
        }
    const double expected = s.stochastic ? uniform.Mean() : integrals.reflected;
    survey.reflected = ZTest(reflected, expected, bias + 5 * uniform.StandardError(), "scattered z^2");
    if (!isExact) return survey;

    // C3; draws that fail are judged by C4.
    std::vector<double> expectedCounts = integrals.pdf;
    for (double& e : expectedCounts) e *= numSamples;
    survey.fineGrid = ChiSquareTest(counts, expectedCounts);
    std::vector<double> coarseCounts(size_t{kCoarseCos} * kCoarsePhi), coarseExpected(coarseCounts.size());
    for (size_t i = 0; i < integrals.pdf.size(); ++i) {
        const size_t cell = i / kNumPhi / kCoarse * kCoarsePhi + i % kNumPhi / kCoarse;
        coarseCounts[cell] += counts[i];
        coarseExpected[cell] += expectedCounts[i];
    }
    survey.coarseGrid = ChiSquareTest(coarseCounts, coarseExpected);
    const char* names[] = {"mean x", "mean y", "mean z"};
    std::vector<Outcome> means;
    for (int k = 0; k < 3; ++k)
        means.push_back(ZTest(moments[k], double(integrals.moment[k]), bias, names[k]));
    survey.moments = WorstOf(means);

    // C4. Where hardly any draw fails the sample's own variance is no guide: the expected one is.
    const double p = std::clamp(integrals.total, 0., 1.),
                 deviation = std::abs(success.Mean() - integrals.total) - bias;
    const double sigma = std::max(success.StandardError(), std::sqrt((p * (1 - p) + 1e-9) / numSamples));
    survey.normalization = {deviation > 0 ? NormalTwoSided(deviation / sigma) : 1,
                            fmt::format("{:.7g} of the draws succeed, the pdf integrates to {:.7g}",
                                        success.Mean(), integrals.total)};
    return survey;
}

double ConformanceAlpha() {
    const auto numSetups = BxDFCases().size() * OutgoingDirections().size() * std::size(kTransportModes);
    return SidakAlpha(1e-3, static_cast<int>(numSetups) * kOutcomesPerSurvey);
}

}  // namespace lacquer::test
