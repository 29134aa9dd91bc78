// Pair products: two subpaths, joined by a direction that is drawn from the product of the two lobes at its
// ends [Xia et al. 2020, sec. 4.3 and 5.2]. For paths that no slab scatters.
//
// A path has the inner directions 1 ... n, in the order of light. Strategy m draws directions 1 ... m-1 by a
// walk from the light (densities a), directions n ... m+1 by a walk from the camera (densities b), and
// direction m from the product of the lobes at its two ends (density q, which depends on both neighbours):
//   p_m = prod_{i<m} a_i * q_m * prod_{i>m} b_i.
// The balance heuristic weights a sample by p_m over the sum of all p. Divided by the outer products, that is
//   q_m + b_m L_m + a_m C_m,
// where L_m sums the strategies with a smaller m: with i = m - 1,
//   L_m = (q_i + b_i L_i) / a_i,
// a recursion along the light's walk; C_m is the same from the camera's side.
//
// The paper weights all n strategies, for paths of any length: AllPairStrategies. By default only the middle
// ones take part, whose walks are about as long as each other: two for even n, three for odd n. So for n <= 3
// they are the paper's, and the recursions end after at most two terms however long the path is. For n = 4
// the other two, with one walk of no directions and one of three, have so much noise that the balance
// heuristic does not suppress it: see docs/product-sampling.md. Sums of all strategies are kept at each
// vertex, so that a connection costs the same whatever the length of its walks.
//
// Walks of more than three directions go on by roulette, which no weight knows. Where all strategies take
// part the light's walk ends sooner, and strategies weigh less for each of its vertices, as in
// connection_walk.h: the number of connections grows with the camera's walk only.
//
// A product of Gaussians is positive everywhere, also where the integrand is 0: such samples stay, with the
// value 0, and the weights of all others sum to 1.
#pragma once

#include <limits>
#include <new>
#include <vector>

#include "gaussfit/lobe/lobe.h"
#include "layered/stack.h"

namespace lacquer::layered {

/// Lobe of a surface seen from w, as FindLobe().
bool FindLobeOf(const MicrofacetSurface& surface, bool transmits, Vec3 w, gaussfit::GaussianMixture* lobe);

/// True if the tables have lobes for the surface's alpha and eta, seen from above at normal incidence.
bool HasLobeOf(const MicrofacetSurface& surface, bool transmits);

/// True if the side of w has the larger index. The lobes of light that comes from there end at the critical
/// angle, far from Gaussian.
inline bool IsDenseSide(const MicrofacetSurface& surface, Vec3 w) {
    return w.z > 0 ? surface.eta < 1 : surface.eta > 1;
}

/// From 0 to 1 at the flatter of two outer views: how much of a lobe is cut off there, by half where facets'
/// slopes have the deviation of the cotangent.
float GrazingOf(const MicrofacetSurface& surfaceA, Vec3 a, const MicrofacetSurface& surfaceB, Vec3 b);

/// Settings that are right as they are and exist to be broken by tests.
struct PairPolicy {
    static constexpr int kAllDifferences = 1000;
    static constexpr bool kCountsOthers = true;    ///< other strategies in the weights
    static constexpr bool kCountsJacobian = true;  ///< from slopes to solid angles
    /// Share of the connecting directions that the interface at one of the two ends draws by itself instead,
    /// where lobes are mixtures; and where they are single Gaussians, in the lobes and far from them.
    static constexpr float kOwnSamples = 0.05f, kOwnPerAlpha2 = 0.02f, kOwnSamplesFar = 0.6f,
                           kOwnAtGrazing = 0.03f, kOwnAtGrazingOfMixtures = 0.15f;
    /// Distances of two lobes that are far, in squared standard deviations: of lobes as wide as an alpha of 1
    /// makes them, which are no Gaussians, and of all.
    static constexpr float kFarIfRough2 = 12, kFar2 = 40;
    /// Only the strategy whose walk from the light is so much longer than the other one, or as much as there
    /// are directions, unweighted.
    static constexpr int kOnlyDifference = kAllDifferences;
    static constexpr bool kTakesAllStrategies = false;
    /// Of the light's walk from its fifth vertex on, and in the weight of a strategy for each of its
    /// vertices.
    static constexpr float kLightSurvival = 1;
};
/// All strategies of a path, in place of the middle ones.
struct AllPairStrategies : PairPolicy {
    static constexpr bool kTakesAllStrategies = true;
    static constexpr float kLightSurvival = 0.8f;
};

/// Estimates the sum over all paths of minVertices to maxVertices vertices that no slab scatters. Lives for
/// one estimate; allocates only for walks of more than kFirstVertices vertices, which need maxVertices beyond
/// one pass.
template <class Policy = PairPolicy>
class PairWalk {
  public:
    /// @param context      mode and random numbers; its sides do not matter
    /// @param maxVertices  longer paths count as 0
    /// @param minVertices  shorter paths count as 0
    PairWalk(const Stack& stack, const BxDFContext& context, int maxVertices, int minVertices = 2)
        : stack_(stack), rng_(*context.rng), minVertices_(minVertices), maxVertices_(maxVertices) {
        light_.mode = !context.mode;
        camera_.mode = context.mode;
    }

    /// Sets the outer directions: unit, outside of the stack, z not 0. False if there are no such paths, or
    /// if pair products cannot make them all: if an interface that they reach has no lobes, or the tables do
    /// not reach its alpha, its eta or the outer direction. False, too, where both outer sides are the denser
    /// ones: products are no better than other strategies there. So it is far off the lobes of mixtures,
    /// where any one event may turn the light. The answer depends on nothing that is drawn.
    bool Set(Vec3 wo, Vec3 wi) {
        const bool isReflection = SameHemisphere(wo, wi);
        const int last = stack_.Last(), shortest = isReflection ? 3 : last + 1;
        if (last < 1 || maxVertices_ < shortest) return false;
        light_.exit = stack_.OuterTowards(wo);
        camera_.exit = stack_.OuterTowards(wi);
        if (!Start(light_, wi) || !Start(camera_, wo)) return false;
        if (IsDenseSide(light_.At(0).surface, wi) && IsDenseSide(camera_.At(0).surface, wo)) return false;
        grazing_ = GrazingOf(light_.At(0).surface, wi, camera_.At(0).surface, wo);
        if (IsFarOffTheLobe(isReflection)) return false;
        // Interfaces that paths can reach and come back from.
        const int depth = isReflection ? std::min(last, (maxVertices_ - 1) / 2) : last;
        for (int k = 1; k <= depth; ++k) {
            const int at = light_.At(0).interface == 0 ? k : last - k;
            if (at != light_.exit && !HasLobes(at, k < depth)) return false;
            if (k < depth && at != light_.exit) meetsLowerIndex_ |= HasLowerIndexBelow(at, wi);
        }
        return true;
    }
    /// After Set().
    SampledSpectrum Estimate() {
        Walk(light_);
        Walk(camera_);
        SampledSpectrum sum(0);
        for (int s = 0; s < light_.count; ++s) {
            const int shortest = std::max(minVertices_ - 2 - s, Policy::kTakesAllStrategies ? 0 : s - 2),
                      longest = std::min(maxVertices_ - 2 - s, camera_.count - 1);
            for (int t = std::max(0, shortest); t <= longest; ++t)
                if (std::min(s, t) >= ShortestWalk(s + t)) sum += Connect(s, t);
        }
        return sum;
    }

  private:
    struct Vertex {
        int interface = 0;
        MicrofacetSurface surface{};
        Vec3 wPrev{0, 0, 1};
        SampledSpectrum beta{1};  ///< of the walk up to here, without this vertex
        // Lobes seen from wPrev, by whether light passes; made when first wanted.
        std::array<gaussfit::GaussianMixture, 2> lobes;
        std::array<bool, 2> hasLobe{};
        // Once the walk goes on:
        Vec3 wNext{0, 0, 1};
        float pdfNext = 0, pdfReverse = 0;
        /// Shorter() behind this vertex, made when first wanted.
        float shorter = 0;
        bool hasShorter = false;
    };
    /// Vertices of a walk that have room in the object; those beyond it are on the heap.
    static constexpr int kFirstVertices = 8;
    struct Subpath {
        TransportMode mode = TransportMode::Radiance;
        int exit = 0;  ///< the interface where its light leaves
        int count = 0;
        /// Takes the solid-angle compression of radiance out of roulette.
        float rouletteScale = 1;
        // Raw memory: few vertices are made, and setting up all would cost as much as a look-up.
        alignas(Vertex) std::array<std::byte, kFirstVertices * sizeof(Vertex)> storage;
        std::vector<Vertex> more;

        Vertex& At(int i) {
            if (i >= kFirstVertices) return more[size_t(i - kFirstVertices)];
            return *std::launder(reinterpret_cast<Vertex*>(&storage[size_t(i) * sizeof(Vertex)]));
        }
        /// Makes the next vertex; it does not count yet. References to others may end.
        Vertex& New() {
            if (count >= kFirstVertices) return more.emplace_back();
            return *new (&storage[size_t(count) * sizeof(Vertex)]) Vertex;
        }
    };

    /// Directions that the shorter of two walks has at least, of `sum` directions of both.
    static int ShortestWalk(int sum) { return Policy::kTakesAllStrategies ? 0 : (sum - 1) / 2; }

    /// Like those of ConnectionWalk: into the stack and not out of it.
    BxDFContext ContextAt(Subpath& path, int i) const {
        const int at = path.At(i).interface;
        const Lobes sides = i == 0                           ? Lobes::Transmission
                            : at == 0 || at == stack_.Last() ? Lobes::Reflection
                                                             : Lobes::BothSides;
        return {path.mode, sides, &rng_};
    }
    const StackInterface& InterfaceOf(const Vertex& v) const {
        return stack_.interfaces[size_t(v.interface)];
    }

    // ---- Walking ------------------------------------------------------------------------------------------

    /// Makes the first vertex. False if it has no lobe.
    bool Start(Subpath& path, Vec3 w) const {
        Vertex& first = path.New();
        first.interface = stack_.OuterTowards(w);
        first.wPrev = w;
        first.hasLobe[1] = true;
        path.count = 1;
        const auto facets = InterfaceOf(first).IsotropicFacets();
        if (!facets) return false;
        first.surface = *facets;
        return FindLobeOf(first.surface, true, w, &first.lobes[1]);
    }
    /// Where directions are drawn, normal incidence tells whether the tables reach alpha and eta.
    bool HasLobes(int interface, bool transmits) const {
        const auto facets = stack_.interfaces[size_t(interface)].IsotropicFacets();
        return facets && HasLobeOf(*facets, transmits);
    }

    void Walk(Subpath& path) {
        const int directions = maxVertices_ - 2, longest = directions - ShortestWalk(directions);
        while (path.count <= longest && Extend(path)) ++path.count;
    }

    /// Makes the next vertex. False if the walk ends, or if that would be too far from where it should leave.
    bool Extend(Subpath& path) {
        Vertex& v = path.At(path.count - 1);
        const auto sample = InterfaceOf(v).Sample(v.wPrev, ContextAt(path, path.count - 1));
        if (!sample || sample->wi.z == 0) return false;
        v.wNext = sample->wi;
        v.pdfNext = sample->pdf;
        v.pdfReverse = sample->pdfReverse;
        const bool isDown = v.wNext.z < 0;
        const int at = v.interface + (isDown ? 1 : -1);
        if (path.count + 1 + VerticesToExit(path, at) > maxVertices_) return false;
        const Slab& slab = stack_.slabs[size_t(isDown ? v.interface : at)];
        SampledSpectrum beta = v.beta * sample->weight * slab.Cross(v.wNext, 1).transmittance;
        if (path.mode == TransportMode::Radiance) path.rouletteScale *= Sqr(sample->eta);
        if (!SurvivesRoulette(path, &beta)) return false;

        const Vec3 wPrev = -v.wNext;
        Vertex& next = path.New();
        next.interface = at;
        next.surface = InterfaceOf(next).IsotropicFacets().value();  // Set() has seen all
        next.wPrev = wPrev;
        next.beta = beta;
        return true;
    }
    bool SurvivesRoulette(const Subpath& path, SampledSpectrum* beta) const {
        constexpr int kFirst = 4;  // walks of fewer vertices always go on
        constexpr float kSafety = 2.5f;
        if (path.count < kFirst) return true;
        const float throughput = path.rouletteScale * beta->MaxComponent();
        if (!(throughput > std::numeric_limits<float>::min())) return false;
        const float survival =
            std::min(1.f, kSafety * throughput) * (&path == &light_ ? Policy::kLightSurvival : 1.f);
        if (!(rng_.Uniform() < survival)) return false;
        *beta *= 1 / survival;
        return true;
    }
    static int VerticesToExit(const Subpath& path, int at) {
        return at == path.exit ? 2 : std::abs(at - path.exit);
    }

    // ---- Lobes --------------------------------------------------------------------------------------------

    /// The lobe of a surface seen from w, on the side of z = `side`. Beyond the tables a wide one: any
    /// density will do, and the other factor of the product knows where light goes.
    static gaussfit::GaussianMixture LobeOf(const MicrofacetSurface& surface, Vec3 w, float side) {
        gaussfit::GaussianMixture lobe;
        if (!FindLobeOf(surface, w.z * side < 0, w, &lobe)) lobe = gaussfit::GaussianMixture(Gaussian2{});
        return lobe;
    }
    static const gaussfit::GaussianMixture& LobeAt(Vertex& v, float side) {
        const size_t transmits = v.wPrev.z * side < 0;
        if (!v.hasLobe[transmits]) {
            v.lobes[transmits] = LobeOf(v.surface, v.wPrev, side);
            v.hasLobe[transmits] = true;
        }
        return v.lobes[transmits];
    }

    // ---- Strategies ---------------------------------------------------------------------------------------

    /// What a connecting direction is drawn from.
    struct Connection {
        gaussfit::GaussianMixtureProduct product;  ///< over its slope
        float ownShare;                            ///< of directions that the interfaces draw themselves
    };
    /// Gaussians fall off faster than lobes do: faster than those that take a mixture, faster than those near
    /// total reflection, where an inner boundary leads into a thinner medium, and than all of them far from
    /// their means or at grazing views. Weights would have no bound without the interfaces' own draws. In the
    /// lobes of smooth interfaces such draws would be most of the noise: there they are few.
    Connection ConnectionOf(const MicrofacetSurface& surfaceA, const gaussfit::GaussianMixture& lobeA,
                            const MicrofacetSurface& surfaceB, const gaussfit::GaussianMixture& lobeB) const {
        Connection connection{gaussfit::Multiply(lobeA, lobeB), 0};
        const float alpha2 = Sqr(std::min(surfaceA.alphaX, surfaceB.alphaX));
        const float distance2 = gaussfit::LeastDistance2(lobeA, lobeB);
        const bool isMixture = connection.product.count > 1;
        const float bend2 = (isMixture ? 1 : alpha2) * Sqr(distance2 / Policy::kFarIfRough2) +
                            Sqr(Sqr(distance2 / Policy::kFar2));
        const float near =
            isMixture || meetsLowerIndex_ ? Policy::kOwnSamples : Policy::kOwnPerAlpha2 * alpha2;
        const float grazing =
            (isMixture ? Policy::kOwnAtGrazingOfMixtures : Policy::kOwnAtGrazing) * grazing_;
        connection.ownShare = near + grazing + Policy::kOwnSamplesFar * bend2 / (1 + bend2);
        return connection;
    }
    /// Judged by the shortest path, of two events or of three with a reflection in the middle.
    bool IsFarOffTheLobe(bool isReflection) {
        constexpr float kFarthest2 = 15;  // measured
        const gaussfit::GaussianMixture &light = light_.At(0).lobes[1], &camera = camera_.At(0).lobes[1];
        if (light.count == 1 && camera.count == 1) return false;
        if (!isReflection) return stack_.Last() == 1 && gaussfit::LeastDistance2(light, camera) > kFarthest2;
        const auto middle =
            stack_.interfaces[size_t(light_.At(0).interface == 0 ? 1 : stack_.Last() - 1)].IsotropicFacets();
        if (!middle) return false;
        // A facet turns a slope to its negative and by twice its own.
        const float variance = 2 * Sqr(middle->alphaX);
        gaussfit::GaussianMixture mirrored = camera;
        for (int i = 0; i < mirrored.count; ++i) {
            Gaussian2& part = mirrored.parts[size_t(i)];
            part.mean = -part.mean;
            part.precision = (part.precision.Inverse() + Symmetric2{variance, 0, variance}).Inverse();
        }
        return gaussfit::LeastDistance2(light, mirrored) > kFarthest2;
    }
    /// True if light that comes in from the side of `w` finds a thinner medium behind an interface.
    bool HasLowerIndexBelow(int interface, Vec3 w) const {
        const auto facets = stack_.interfaces[size_t(interface)].IsotropicFacets();
        return facets && IsDenseSide(*facets, w);
    }
    /// Density of a connecting direction [1/sr]. @param pdfA, pdfB  of the interfaces at the two ends
    static float ConnectionPdf(const Connection& connection, Vec3 w, float pdfA, float pdfB) {
        const float jacobian = Policy::kCountsJacobian ? SlopePerSolidAngle(w) : 1, own = connection.ownShare;
        return (1 - own) * connection.product.Pdf(SlopeOf(w)) * jacobian + 0.5f * own * (pdfA + pdfB);
    }
    /// The direction from vertex s of the light's walk to vertex t of the camera's; z = 0 if the draw fails.
    Vec3 SampleConnection(const Connection& connection, int s, int t, float side) {
        const float own = connection.ownShare, u = rng_.Uniform();
        if (u >= own) return DirectionOf(connection.product.Sample(rng_.Uniform2D()), side);
        const bool isFromLight = 2 * u < own;
        const Vertex& v = isFromLight ? light_.At(s) : camera_.At(t);
        const auto sample =
            InterfaceOf(v).Sample(v.wPrev, isFromLight ? ContextAt(light_, s) : ContextAt(camera_, t));
        if (!sample) return Vec3(0);
        const Vec3 w = isFromLight ? sample->wi : -sample->wi;
        return w.z * side > 0 ? w : Vec3(0);
    }

    /// L_m or C_m: the strategies that end a walk earlier.
    /// @param i           the vertex where it ends
    /// @param wNext       the direction that comes after it
    /// @param pdfReverse  density of drawing the direction before it from the other side
    /// @param terms       how many strategies
    float Shorter(Subpath& path, int i, Vec3 wNext, float pdfReverse, int terms) const {
        if (terms == 0 || !Policy::kCountsOthers) return 0;
        const Vertex& v = path.At(i);
        Vertex& before = path.At(i - 1);
        const Connection connection = ConnectionOf(before.surface, LobeAt(before, before.wNext.z), v.surface,
                                                   LobeOf(v.surface, wNext, v.wPrev.z));
        float sum = ConnectionPdf(connection, before.wNext, before.pdfNext, pdfReverse);
        if (terms > 1) sum += pdfReverse * ShorterBehind(path, i - 1, terms - 1);
        // What a strategy weighs more than the one whose light side has a vertex more.
        constexpr float kPerVertex = Policy::kLightSurvival;
        const float weight = &path == &light_ ? 1 / kPerVertex : kPerVertex;
        // A walk of vanishing density: the other strategies take over.
        return std::min(sum * weight / before.pdfNext, std::numeric_limits<float>::max());
    }
    /// Shorter() at a vertex whose walk goes on. Each vertex is asked for the same number of strategies: 1,
    /// or all that there are.
    float ShorterBehind(Subpath& path, int i, int terms) const {
        Vertex& v = path.At(i);
        if (!v.hasShorter) {
            v.shorter = Shorter(path, i, v.wNext, v.pdfReverse, terms);
            v.hasShorter = true;
        }
        return v.shorter;
    }

    /// The strategy that joins vertex s of the light's walk with vertex t of the camera's.
    SampledSpectrum Connect(int s, int t) {
        constexpr bool kAlone = Policy::kOnlyDifference != Policy::kAllDifferences;
        if (kAlone && s - t != std::clamp(Policy::kOnlyDifference, -s - t, s + t)) return SampledSpectrum(0);
        Vertex &light = light_.At(s), &camera = camera_.At(t);
        if (std::abs(light.interface - camera.interface) != 1) return SampledSpectrum(0);
        const float side = camera.interface > light.interface ? -1.f : 1.f;
        const Connection connection =
            ConnectionOf(light.surface, LobeAt(light, side), camera.surface, LobeAt(camera, -side));
        const Vec3 w = SampleConnection(connection, s, t, side);
        if (w.z == 0) return SampledSpectrum(0);

        const BxDFValue atLight = InterfaceOf(light).Evaluate(light.wPrev, w, ContextAt(light_, s));
        if (!atLight.f) return SampledSpectrum(0);
        const BxDFValue atCamera = InterfaceOf(camera).Evaluate(camera.wPrev, -w, ContextAt(camera_, t));
        if (!atCamera.f) return SampledSpectrum(0);
        float pdf = ConnectionPdf(connection, w, atLight.pdf, atCamera.pdf);
        if (!kAlone) {
            const int shortest = ShortestWalk(s + t);
            pdf += atCamera.pdf * Shorter(light_, s, w, atLight.pdfReverse, s - shortest) +
                   atLight.pdf * Shorter(camera_, t, -w, atCamera.pdfReverse, t - shortest);
        }
        const Slab& slab = stack_.slabs[size_t(std::min(light.interface, camera.interface))];
        return light.beta * atLight.f * slab.Cross(w, 1).transmittance * atCamera.f * camera.beta *
               (std::abs(w.z) / pdf);
    }

    const Stack& stack_;
    Rng& rng_;
    int minVertices_, maxVertices_;
    bool meetsLowerIndex_ = false;
    float grazing_ = 0;  ///< from 0 to 1 at the flattest view
    Subpath light_, camera_;
};

}  // namespace lacquer::layered
