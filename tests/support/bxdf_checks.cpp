#include "support/bxdf_checks.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <thread>

#include "pbrt/core/sampling.h"

namespace lacquer::test {
namespace {

using testing::AssertionFailure;
using testing::AssertionResult;
using testing::AssertionSuccess;

constexpr Lobes kSides[] = {Lobes::BothSides, Lobes::Reflection, Lobes::Transmission};

std::string Text(Vec3 w) { return fmt::format("({:.9g}, {:.9g}, {:.9g})", w.x, w.y, w.z); }
std::string Text(SampledSpectrum s) {
    return fmt::format("[{:.9g} {:.9g} {:.9g} {:.9g}]", s[0], s[1], s[2], s[3]);
}

bool IsFine(float x) { return x >= 0 && x <= std::numeric_limits<float>::max(); }

double RelativeError(double a, double b) {
    return a == b ? 0 : std::abs(a - b) / std::max(std::abs(a), std::abs(b));
}
double RelativeError(SampledSpectrum a, SampledSpectrum b) {
    double worst = 0;
    for (int i = 0; i < kNumWavelengths; ++i)
        worst = std::max(worst, RelativeError(double(a[i]), double(b[i])));
    return worst;
}

Lobes SideOf(Vec3 wo, Vec3 wi) { return SameHemisphere(wo, wi) ? Lobes::Reflection : Lobes::Transmission; }

std::vector<Vec3> DegenerateDirections(Vec3 wo) {
    std::vector<Vec3> directions = {{0, 0, 1},  {0, 0, -1},           {1, 0, 0},
                                    {0, -1, 0}, {0.6f, -0.8f, 0},     wo,
                                    -wo,        {-wo.x, -wo.y, wo.z}, {wo.x, wo.y, -wo.z}};
    for (const float z : {1e-3f, 1e-7f, 1e-20f})
        for (const float sign : {1.f, -1.f})
            for (const Vec2 xy : {Vec2(1, 0), Vec2(-0.8f, 0.6f)})
                directions.push_back({xy.x, xy.y, sign * z});
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
                return AssertionFailure()
                       << "f " << Text(v.f) << " pdf " << v.pdf << " at " << Text(wo) << Text(wi);
            if ((wo.z == 0 || wi.z == 0) && (v.f || v.pdf != 0))
                return AssertionFailure() << "not zero in the surface: " << Text(wo) << Text(wi);
        }
        // Sample at the corners, along the edges, and inside.
        std::vector<BxDFRandom> draws;
        for (const float l : {0.f, 0.5f, OneMinusEpsilon})
            for (const float x : {0.f, 0x1p-24f, 0.5f, OneMinusEpsilon})
                for (const float y : {0.f, 0x1p-24f, 0.5f, OneMinusEpsilon}) draws.push_back({l, {x, y}});
        for (int i = 0; i < 500; ++i) draws.push_back(Draw(rng));
        BxDFContext withoutPdf = context;
        withoutPdf.needsSamplePdf = false;
        for (const BxDFRandom& u : draws)
            for (const Vec3 wo : special)
                for (const BxDFContext& asked : {context, withoutPdf}) {
                    const auto sample = s.bxdf.Sample(wo, u, asked);
                    if (!sample) continue;
                    if (!sample->weight.IsValid() || !IsFine(sample->pdf) ||
                        (sample->pdfExact && sample->pdf == 0) || !IsFine(sample->eta) || sample->eta == 0 ||
                        std::abs(Length(sample->wi) - 1) > 1e-5f || sample->wi.z == 0)
                        return AssertionFailure()
                               << "sample " << Text(sample->wi) << " weight " << Text(sample->weight)
                               << " pdf " << sample->pdf << " eta " << sample->eta << " from " << Text(wo);
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
                    return AssertionFailure()
                           << "sample on the wrong side: " << Text(sample->wi) << " lobe " << lobe;
                if (sample->IsReflection() && sample->eta != 1)
                    return AssertionFailure() << "reflection with eta";
            }
            const bool follow = sample && i % 2 == 0;
            const Vec3 wi = follow ? Normalize(sample->wi) : SampleUniformSphere(rng.Uniform2D());
            const BxDFValue v = s.bxdf.Evaluate(s.wo, wi, context);
            if ((v.f || v.pdf != 0) && (!isAllowed(SideOf(s.wo, wi)) || !IsNonSpecular(flags)))
                return AssertionFailure()
                       << "not zero outside of its lobes: " << Text(wi) << " flags " << unsigned(flags);
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
                if (!(sample->pdfReverse > 0)) return AssertionFailure() << "no way back";
                continue;
            }
            const BxDFValue v = s.bxdf.Evaluate(s.wo, sample->wi, context);
            if (RelativeError(double(v.pdf), double(sample->pdf)) > s.tolerance)
                return AssertionFailure() << "sample's pdf " << sample->pdf << ", Evaluate's " << v.pdf
                                          << " at " << Text(sample->wi);
            // The way back: of the record, of the value, and asked for itself.
            const float back = s.bxdf.Pdf(sample->wi, s.wo, context);
            if (!s.takesMoreNumbers &&
                (RelativeError(double(v.pdfReverse), double(sample->pdfReverse)) > s.tolerance ||
                 RelativeError(double(back), double(sample->pdfReverse)) > std::max(1e-3, 100 * s.tolerance)))
                return AssertionFailure()
                       << "density of the way back: sample " << sample->pdfReverse << ", Evaluate "
                       << v.pdfReverse << ", exchanged " << back << " at " << Text(sample->wi);
            const SampledSpectrum a = sample->weight * sample->pdf, b = v.f * AbsCosTheta(sample->wi);
            if (RelativeError(a, b) > s.tolerance)
                return AssertionFailure()
                       << "weight*pdf " << Text(a) << ", f|cos| " << Text(b) << " at " << Text(sample->wi);
        }
    }
    return AssertionSuccess();
}

AssertionResult HasAdjoint(const BxDFSetup& s) {
    if (s.isOneWay) return AssertionSuccess();
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
            const double rounding = s.tolerance * std::abs(forward.Mean());
            if (std::abs(forward.Mean() - backward.Mean()) > 6 * sigma + rounding)
                return AssertionFailure()
                       << forward.Mean() << " forward, " << backward.Mean() << " backward, sigma " << sigma;
            continue;
        }
        const SampledSpectrum forward = s.bxdf.Evaluate(s.wo, wi, context).f;
        const SampledSpectrum backward = s.bxdf.Evaluate(wi, s.wo, adjoint).f;
        const double error = RelativeError(forward, backward);
        numRough += error > s.tolerance;
        // Where facets are seen edge-on, cosines near 1e-2 and less have lost digits.
        const double floor = 1e-3 / double(Max(forward, backward).MaxComponent());
        if (error > 100 * s.tolerance * std::max(1., floor) || numRough > numPairs / 4)
            return AssertionFailure()
                   << Text(forward) << " forward, " << Text(backward) << " backward at " << Text(wi);
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
    return std::hypot(dx[1] * dy[2] - dx[2] * dy[1], dx[2] * dy[0] - dx[0] * dy[2],
                      dx[0] * dy[1] - dx[1] * dy[0]);
}

}  // namespace

AssertionResult JacobianIsPdf(const BxDFSetup& s) {
    if (s.stochastic || s.takesMoreNumbers || s.takesThreeNumbers) return AssertionSuccess();
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
                    return AssertionFailure()
                           << "1/area " << 1 / area << ", pdf " << sample->pdf << " at " << Text(sample->wi);
                break;
            }
        }
        if (compared < tried / 2)
            return AssertionFailure() << "only " << compared << " of " << tried << " could be compared";
    }
    return AssertionSuccess();
}

AssertionResult IsReproducible(const BxDFSetup& s) {
    constexpr int kQueries = 500;
    using Answer = std::array<uint32_t, 16>;  // the bits of numbers
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
            answers[size_t(i)] = std::bit_cast<Answer>(std::array<float, 16>{
                v.f[0], v.f[1], v.f[2], v.f[3], v.pdf, sample.wi.x, sample.wi.y, sample.wi.z,
                sample.weight[0], sample.weight[1], sample.weight[2], sample.weight[3], sample.pdf,
                sample.eta, float(unsigned(sample.lobe)), float(sample.pdfExact)});
        }
        return answers;
    };
    std::vector<Answer> results[3] = {askAll(false), {}, {}};
    std::thread first([&] { results[1] = askAll(false); }), second([&] { results[2] = askAll(true); });
    first.join();
    second.join();
    for (const int other : {1, 2})
        if (results[0] != results[other])
            return AssertionFailure() << (other == 1 ? "another thread differs" : "another order differs");
    return AssertionSuccess();
}

AssertionResult SamplesAlikeWithoutPdf(const BxDFSetup& s) {
    constexpr int kDraws = 600;
    // Densities are those of directions as they were rounded. Their half vectors are off by 1e-7, which is
    // 1e-3 of the narrowest lobes; and next to the surface, where shadowing goes to 0, by more.
    constexpr double kTolerance = 1e-3, kDegenerateTolerance = 1e-2;
    Rng rng(SeedOf("C11"));
    const std::vector<Vec3> special = DegenerateDirections(s.wo);
    int numLost = 0;
    for (int i = 0; i < 3 * kDraws; ++i) {
        // Some draws from each degenerate direction, all others from wo.
        const bool isDegenerate = size_t(i) / 5 < special.size();
        const Vec3 wo = isDegenerate ? special[size_t(i) / 5] : s.wo;
        const BxDFRandom u = Draw(rng);
        Rng own(rng.NextBits()), same = own;
        BxDFContext context{s.mode, kSides[i % 3], &own};
        context.allowsRejection = i % 2 == 1;
        const auto with = s.bxdf.Sample(wo, u, context);
        context.rng = &same;
        context.needsSamplePdf = false;
        const auto without = s.bxdf.Sample(wo, u, context);
        const auto failure = [&] { return AssertionFailure() << "wo " << Text(wo) << " draw " << i << ": "; };
        if (without && (!without->weight.IsValid() || without->wi.z == 0))
            return failure() << Text(without->wi) << " weight " << Text(without->weight);
        if (!with || !without) {
            numLost += with.has_value() != without.has_value();
            continue;
        }
        if (with->wi != without->wi || with->lobe != without->lobe || with->eta != without->eta)
            return failure() << Text(with->wi) << " becomes " << Text(without->wi);
        if (!(RelativeError(with->weight, without->weight) <
              (isDegenerate ? kDegenerateTolerance : kTolerance)))
            return failure() << "weight " << Text(with->weight) << " becomes " << Text(without->weight);
        if (with->IsSpecular() && (with->pdf != without->pdf || with->pdfReverse != without->pdfReverse))
            return failure() << "a specular lobe's probability is lost";
    }
    if (numLost > 3 * kDraws / 200) return AssertionFailure() << numLost << " draws are lost";
    return AssertionSuccess();
}

}  // namespace lacquer::test
