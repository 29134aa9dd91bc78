#include "support/bxdf_checks.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <thread>

#include "pbrt/core/sampling.h"

namespace lacquer::test {
namespace {

using testing::AssertionFailure;
using testing::AssertionResult;
using testing::AssertionSuccess;

constexpr Lobes kSides[] = {Lobes::BothSides, Lobes::Reflection, Lobes::Transmission};

std::string Text(Vec3 w) { return fmt::format("({:.9g}, {:.9g}, {:.9g})", w.x, w.y, w.z); }
std::string Text(SampledSpectrum s) { return fmt::format("[{:.9g} {:.9g} {:.9g} {:.9g}]", s[0], s[1], s[2], s[3]); }

BxDFRandom Draw(Rng& rng) {
    const float lobe = rng.Uniform();
    return {lobe, rng.Uniform2D()};
}

bool IsFine(float x) { return x >= 0 && x <= std::numeric_limits<float>::max(); }

double RelativeError(double a, double b) {
    return a == b ? 0 : std::abs(a - b) / std::max(std::abs(a), std::abs(b));
}
double RelativeError(SampledSpectrum a, SampledSpectrum b) {
    double worst = 0;
    for (int i = 0; i < kNumWavelengths; ++i) worst = std::max(worst, RelativeError(double(a[i]), double(b[i])));
    return worst;
}

Lobes SideOf(Vec3 wo, Vec3 wi) { return SameHemisphere(wo, wi) ? Lobes::Reflection : Lobes::Transmission; }

std::vector<Vec3> DegenerateDirections(Vec3 wo) {
    std::vector<Vec3> directions = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {0.6f, -0.8f, 0}, wo, -wo,
                                    {-wo.x, -wo.y, wo.z}, {wo.x, wo.y, -wo.z}};
    for (const float z : {1e-3f, 1e-7f, 1e-20f})
        for (const float sign : {1.f, -1.f})
            for (const Vec2 xy : {Vec2(1, 0), Vec2(-0.8f, 0.6f)}) directions.push_back({xy.x, xy.y, sign * z});
    return directions;
}

}  // namespace

AssertionResult IsFiniteEverywhere(const BxDFSetup& s) {
    Rng rng(SeedOf("C1"));
    for (const Lobes sides : kSides) {
        const BxDFContext context{s.mode, sides, &rng};
        const std::vector<Vec3> special = DegenerateDirections(s.wo);
        std::vector<std::pair<Vec3, Vec3>> pairs;
        for (const Vec3 wi : special) {
            pairs.emplace_back(s.wo, wi);
            for (const Vec3 wo : special) pairs.emplace_back(wo, wi);
        }
        for (int i = 0; i < 1000; ++i) pairs.emplace_back(s.wo, SampleUniformSphere(rng.Uniform2D()));
        for (const auto& [wo, wi] : pairs) {
            const BxDFValue v = s.bxdf.Evaluate(wo, wi, context);
            if (!v.f.IsValid() || !IsFine(v.pdf))
                return AssertionFailure() << "f " << Text(v.f) << " pdf " << v.pdf << " at " << Text(wo) << Text(wi);
            if ((wo.z == 0 || wi.z == 0) && (v.f || v.pdf != 0))
                return AssertionFailure() << "not zero in the surface: " << Text(wo) << Text(wi);
        }
        // Sample at the corners, along the edges, and inside.
        std::vector<BxDFRandom> draws;
        for (const float l : {0.f, 0.5f, OneMinusEpsilon})
            for (const float x : {0.f, 0x1p-24f, 0.5f, OneMinusEpsilon})
                for (const float y : {0.f, 0x1p-24f, 0.5f, OneMinusEpsilon}) draws.push_back({l, {x, y}});
        for (int i = 0; i < 500; ++i) draws.push_back(Draw(rng));
        for (const BxDFRandom& u : draws)
            for (const Vec3 wo : special) {
                const auto sample = s.bxdf.Sample(wo, u, context);
                if (!sample) continue;
                if (!sample->weight.IsValid() || !IsFine(sample->pdf) || sample->pdf == 0 || !IsFine(sample->eta) ||
                    sample->eta == 0 || std::abs(Length(sample->wi) - 1) > 1e-5f || sample->wi.z == 0)
                    return AssertionFailure() << "sample " << Text(sample->wi) << " weight " << Text(sample->weight) << " pdf "
                                              << sample->pdf << " eta " << sample->eta << " from " << Text(wo);
            }
    }
    return AssertionSuccess();
}

AssertionResult KeepsToItsLobes(const BxDFSetup& s) {
    Rng rng(SeedOf("C2"));
    const Lobes flags = s.bxdf.Flags();
    for (const Lobes sides : kSides) {
        const BxDFContext context{s.mode, sides, &rng};
        const auto isAllowed = [&](Lobes side) { return Any(flags, side) && Any(sides, side); };
        for (int i = 0; i < 2000; ++i) {
            const auto sample = s.bxdf.Sample(s.wo, Draw(rng), context);
            if (sample) {
                const unsigned lobe = unsigned(sample->lobe);
                const bool oneSide = std::popcount(lobe & unsigned(Lobes::BothSides)) == 1;
                const bool oneKind = std::popcount(lobe & ~unsigned(Lobes::BothSides)) == 1;
                if (!oneSide || !oneKind || (lobe & ~unsigned(flags)))
                    return AssertionFailure() << "sampled lobe " << lobe << ", flags " << unsigned(flags);
                if (!Any(sample->lobe, sides) || !Any(sample->lobe, SideOf(s.wo, sample->wi)))
                    return AssertionFailure() << "sample on the wrong side: " << Text(sample->wi) << " lobe " << lobe;
                if (sample->IsReflection() && sample->eta != 1) return AssertionFailure() << "reflection with eta";
            }
            const bool follow = sample && i % 2 == 0;
            const Vec3 wi = follow ? Normalize(sample->wi) : SampleUniformSphere(rng.Uniform2D());
            const BxDFValue v = s.bxdf.Evaluate(s.wo, wi, context);
            if ((v.f || v.pdf != 0) && (!isAllowed(SideOf(s.wo, wi)) || !IsNonSpecular(flags)))
                return AssertionFailure() << "not zero outside of its lobes: " << Text(wi) << " flags " << unsigned(flags);
        }
    }
    return AssertionSuccess();
}

AssertionResult RecordIsConsistent(const BxDFSetup& s) {
    Rng rng(SeedOf("C5"));
    for (const Lobes sides : kSides) {
        const BxDFContext context{s.mode, sides, &rng};
        for (int i = 0; i < 1000; ++i) {
            const auto sample = s.bxdf.Sample(s.wo, Draw(rng), context);
            if (!sample || !sample->pdfExact) continue;
            if (sample->IsSpecular()) {
                if (sample->pdf > 1) return AssertionFailure() << "probability of a lobe " << sample->pdf;
                continue;
            }
            const BxDFValue v = s.bxdf.Evaluate(s.wo, sample->wi, context);
            if (RelativeError(double(v.pdf), double(sample->pdf)) > s.tolerance)
                return AssertionFailure() << "sample's pdf " << sample->pdf << ", Evaluate's " << v.pdf << " at " << Text(sample->wi);
            const SampledSpectrum a = sample->weight * sample->pdf, b = v.f * AbsCosTheta(sample->wi);
            if (RelativeError(a, b) > s.tolerance)
                return AssertionFailure() << "weight*pdf " << Text(a) << ", f|cos| " << Text(b) << " at " << Text(sample->wi);
        }
    }
    return AssertionSuccess();
}

AssertionResult HasAdjoint(const BxDFSetup& s) {
    Rng rng(SeedOf("C6"));
    const BxDFContext context{s.mode, Lobes::BothSides, &rng}, adjoint{!s.mode, Lobes::BothSides, &rng};
    const int numPairs = s.stochastic ? 10 : 1000;
    int numRough = 0;
    for (int i = 0; i < numPairs; ++i) {
        const auto sample = s.bxdf.Sample(s.wo, Draw(rng), context);
        const bool follow = sample && i % 4 != 0;
        const Vec3 wi = follow ? sample->wi : SampleUniformSphere(rng.Uniform2D());
        if (s.stochastic) {
            RunningMean forward, backward;
            for (int k = 0; k < 4000; ++k) {
                forward.Add(double(s.bxdf.Evaluate(s.wo, wi, context).f.Average()));
                backward.Add(double(s.bxdf.Evaluate(wi, s.wo, adjoint).f.Average()));
            }
            const double sigma = std::hypot(forward.StandardError(), backward.StandardError());
            if (std::abs(forward.Mean() - backward.Mean()) > 6 * sigma)
                return AssertionFailure() << forward.Mean() << " forward, " << backward.Mean() << " backward, sigma " << sigma;
            continue;
        }
        const SampledSpectrum forward = s.bxdf.Evaluate(s.wo, wi, context).f;
        const SampledSpectrum backward = s.bxdf.Evaluate(wi, s.wo, adjoint).f;
        const double error = RelativeError(forward, backward);
        numRough += error > s.tolerance;
        // Where facets are seen edge-on, cosines near 1e-2 and less have lost digits.
        const double floor = 1e-3 / double(Max(forward, backward).MaxComponent());
        if (error > 100 * s.tolerance * std::max(1., floor) || numRough > numPairs / 4)
            return AssertionFailure() << Text(forward) << " forward, " << Text(backward) << " backward at " << Text(wi);
    }
    return AssertionSuccess();
}

namespace {

/// Area on the sphere for a unit square around u.direction, by differences over 2h; negative if a draw fails.
double AreaOf(const BxDFSetup& s, BxDFRandom u, const BxDFContext& context, float h) {
    double corner[4][3];
    const Point2 offsets[] = {{h, 0}, {-h, 0}, {0, h}, {0, -h}};
    for (int i = 0; i < 4; ++i) {
        const auto sample = s.bxdf.Sample(s.wo, {u.lobe, u.direction + offsets[i]}, context);
        if (!sample || sample->IsSpecular()) return -1;
        for (int k = 0; k < 3; ++k) corner[i][k] = double(sample->wi[k]);
    }
    double dx[3], dy[3];
    for (int k = 0; k < 3; ++k) {
        dx[k] = (corner[0][k] - corner[1][k]) / double(2 * h);
        dy[k] = (corner[2][k] - corner[3][k]) / double(2 * h);
    }
    return std::hypot(dx[1] * dy[2] - dx[2] * dy[1], dx[2] * dy[0] - dx[0] * dy[2], dx[0] * dy[1] - dx[1] * dy[0]);
}

}  // namespace

AssertionResult JacobianIsPdf(const BxDFSetup& s) {
    if (s.stochastic) return AssertionSuccess();
    Rng rng(SeedOf("C9"));
    for (const Lobes sides : {Lobes::Reflection, Lobes::Transmission}) {
        const BxDFContext context{s.mode, sides, &rng};
        int tried = 0, compared = 0;
        for (int i = 0; i < 400; ++i) {
            const BxDFRandom u{0.5f, Point2(0.04f, 0.04f) + 0.92f * rng.Uniform2D()};
            const auto sample = s.bxdf.Sample(s.wo, u, context);
            if (!sample || sample->IsSpecular() || !sample->pdfExact) continue;
            ++tried;
            // The longest step that resolves the map has the least rounding.
            for (const float h : {0.02f, 0.01f, 0.005f, 0.0025f}) {
                const double wide = AreaOf(s, u, context, h), narrow = AreaOf(s, u, context, h / 2);
                if (wide < 0 || narrow < 0 || RelativeError(wide, narrow) > 0.01) continue;
                const double area = (4 * narrow - wide) / 3;
                ++compared;
                if (RelativeError(1 / area, double(sample->pdf)) > 0.025 + 10 * s.tolerance)
                    return AssertionFailure() << "1/area " << 1 / area << ", pdf " << sample->pdf << " at " << Text(sample->wi);
                break;
            }
        }
        if (compared < tried / 2) return AssertionFailure() << "only " << compared << " of " << tried << " could be compared";
    }
    return AssertionSuccess();
}

AssertionResult IsReproducible(const BxDFSetup& s) {
    constexpr int kQueries = 500;
    struct Answer {
        float numbers[16];
    };
    // All queries in one order or the other; each answer goes to its own place.
    const auto askAll = [&](bool backwards) {
        std::vector<Answer> answers(kQueries);
        for (int k = 0; k < kQueries; ++k) {
            const int i = backwards ? kQueries - 1 - k : k;
            Rng rng(Hash(SeedOf("C10"), i));
            const BxDFContext context{s.mode, Lobes::BothSides, &rng};
            const BxDFRandom u = Draw(rng);
            const Vec3 wi = SampleUniformSphere(rng.Uniform2D());
            const BxDFValue v = s.bxdf.Evaluate(s.wo, wi, context);
            const BxDFSample sample = s.bxdf.Sample(s.wo, u, context).value_or(BxDFSample{});
            answers[size_t(i)] = {{v.f[0], v.f[1], v.f[2], v.f[3], v.pdf, sample.wi.x, sample.wi.y, sample.wi.z,
                                   sample.weight[0], sample.weight[1], sample.weight[2], sample.weight[3], sample.pdf,
                                   sample.eta, float(unsigned(sample.lobe)), float(sample.pdfExact)}};
        }
        return answers;
    };
    std::vector<Answer> results[3] = {askAll(false), {}, {}};
    std::thread first([&] { results[1] = askAll(false); }), second([&] { results[2] = askAll(true); });
    first.join();
    second.join();
    for (const int other : {1, 2})
        if (std::memcmp(results[0].data(), results[other].data(), kQueries * sizeof(Answer)) != 0)
            return AssertionFailure() << (other == 1 ? "another thread differs" : "another order differs");
    return AssertionSuccess();
}

namespace {

/// Adaptive integration over cells in (cos theta, phi).
class SphereQuadrature {
  public:
    /// @param error  by which two levels may differ in a part    @param numSamples  drawn to find the points
    SphereQuadrature(const BxDFSetup& setup, double error, int numSamples, uint64_t seed)
        : setup_(setup), error_(error), numSamples_(numSamples), rng_(seed), context_{setup.mode, Lobes::BothSides, &rng_} {}

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

    /// True if the density is zero at some corners of r only, or zero at all of them and not within (or the other way).
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
        // So may they where a ridge or a peak runs between their nodes; then more samples fall here than they say.
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
    // See where the samples fall. The angle from the pole is taken from the sine where the cosine is too coarse.
    std::vector<std::vector<std::pair<double, double>>> points(size_t{kNumCos} * kNumPhi);
    Rng rng(seed);
    const BxDFContext context{s.mode, Lobes::BothSides, &rng};
    for (int i = 0; i < kNumSamples; ++i) {
        const auto sample = s.bxdf.Sample(s.wo, Draw(rng), context);
        if (!sample || sample->IsSpecular()) continue;
        const double sine = std::hypot(double(sample->wi.x), double(sample->wi.y));
        const double c = std::copysign(sine < 0.5 ? std::sqrt(1 - sine * sine) : std::abs(double(sample->wi.z)),
                                       double(sample->wi.z));
        const double phi = PhiOf(sample->wi);
        points[CellOf(c, phi, kNumCos, kNumPhi)].emplace_back(c, phi);
    }

    // Integrate cell by cell.
    SphereQuadrature quadrature(s, error, kNumSamples, Hash(seed, 1));
    SphereIntegrals integrals;
    integrals.pdf.resize(points.size());
    double x = 0, y = 0, z = 0;
    for (int i = 0; i < kNumCos; ++i)
        for (int j = 0; j < kNumPhi; ++j) {
            const size_t cell = size_t(i) * kNumPhi + size_t(j);
            const SphereQuadrature::Rect rect{-1 + 2. * i / kNumCos, -1 + 2. * (i + 1) / kNumCos, 2 * M_PI * j / kNumPhi,
                                              2 * M_PI * (j + 1) / kNumPhi};
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
    const double bias = 5e-5 + 0.2 * s.tolerance;

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
        for (int k = 0; k < kNumWavelengths; ++k) albedo[k].Add(sample ? double(sample->weight[k] * scale) : 0);
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
    for (int k = 0; k < 3; ++k) means.push_back(ZTest(moments[k], double(integrals.moment[k]), bias, names[k]));
    survey.moments = WorstOf(means);

    // C4.
    survey.normalization = ZTest(success, integrals.total, bias, "fraction of draws that succeed");
    return survey;
}

}  // namespace lacquer::test
