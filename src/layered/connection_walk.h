// The engine of the position-free estimators: two walks through a stack and the connections between them.
//
// Notation of [Guo et al. 2018] and [Guo 2021, app. A.2], with light-side quantities first. A path has the
// vertices z_1 (where light enters) ... z_n (where the camera looks at), joined by segments 1 ... n-1.
// For segment i
//   a_i, alpha_i   the densities with which a walk from the light draws its direction and its flight,
//   b_i, beta_i    those of a walk from the camera.
// Strategy (s, u): the light side makes z_1 ... z_s, the camera side the rest, and the direction of segment s
// is drawn by the light side (u = 0) or by the camera side (u = 1). Its density is
//   p(s, u) = prod_{i<s} a_i alpha_i * (u ? b_s : a_s) * prod_{i>s} b_i beta_i      [Guo 2021] eq. A.6, A.7.
// The balance heuristic weights a sample by p(s, u) over the sum of all strategies that can make its path.
// Divided by the two outer products of strategy s, that sum is
//   a_s v0_s + b_s v1_s  +  b_s beta_s L_s  +  a_s alpha_s C_s,
// where v tells whether a strategy exists, L_s sums those with a shorter light side and C_s those with a
// longer one. Both follow their subpath by a recursion that needs only its newest vertex, and they are linear
// in the one density that is not known before the connection: constant time for each pair.
// All densities of a strategy are multiplied by a factor for each vertex of its light side (Decay() below),
// and the light's walk goes on with that probability: weights still sum to one, and the light side stays
// short. It has no other end: whatever its length, a strategy that has a weight is made.
#pragma once

#include <array>
#include <limits>
#include <new>
#include <type_traits>
#include <vector>

#include "layered/slab_connections.h"
#include "layered/stack.h"

namespace lacquer::layered {

/// Which strategies take part.
enum class Strategies {
    /// The camera walks; light comes in through specular interfaces only, or the first interface is
    /// evaluated.
    Forward,
    /// The light side goes straight in through interfaces, and wherever specular ones send it: next-event
    /// estimation across any number of them, against continuing the walk to the interface where light enters.
    NextEvent,
    /// All pairs of vertices of two walks.
    AllPairs,
};

/// Settings of ConnectionWalk. Estimators choose the first few; the rest are right as they are and exist to
/// be broken by tests.
struct WalkPolicy {
    using ValueType = SampledSpectrum;  ///< what is summed: f as a spectrum, or a float for the density of wi
    static constexpr Strategies kStrategies = Strategies::AllPairs;
    /// Light that scatters in a slab is left out: flights go to the next interface and count by the chance of
    /// getting there.
    static constexpr bool kOnlyUnscattered = false;

    static constexpr bool kCountsVertexBeforeSampling = true;
    static constexpr bool kRouletteInBothWeights = false;
    static constexpr float kThinnestMedium = 0;     ///< optical thickness below which scattering is dropped
    static constexpr float kNearestVertex = 0;      ///< depth next to an interface where vertices are dropped
    static constexpr bool kSpecularPasses = true;   ///< paths go through specular interfaces
    static constexpr bool kConnectsInLanes = true;  ///< where it can be done, several vertices at once
    static constexpr int kMaxLightVertices =
        std::numeric_limits<int>::max();  ///< the light's walk is cut there
};

/// Paths that no slab scatters and that a caller knows better.
struct KnownPaths {
    int vertices = 0;        ///< all of at most so many vertices
    int directVertices = 0;  ///< and those of at most so many that turn once at most: down and up, or through
};

/// Estimates the sum over all paths of two and more vertices between two fixed outer directions. Lives for
/// one estimate, on the stack; allocates only for a light's walk of more than kFirstLightVertices connectable
/// vertices, which hardly ever occurs. Expected cost: one step for each vertex of the camera's walk times the
/// few vertices of the light's.
template <class Policy>
class ConnectionWalk {
  public:
    using ValueType = typename Policy::ValueType;
    static constexpr bool kIsDensity = std::is_same_v<ValueType, float>;
    static constexpr bool kMayHaveLanes = Policy::kConnectsInLanes && !kIsDensity &&
                                          !Policy::kOnlyUnscattered &&
                                          Policy::kStrategies == Strategies::AllPairs;

    /// @param context   mode and random numbers; its sides do not matter
    /// @param excluded  paths that count as 0
    ConnectionWalk(const Stack& stack, const BxDFContext& context, int maxVertices, KnownPaths excluded = {})
        : stack_(stack),
          rng_(*context.rng),
          mode_(context.mode),
          maxVertices_(maxVertices),
          excluded_(excluded) {
        for (const StackInterface& interface : stack.interfaces) isAllSpecular_ &= interface.isSpecular;
        for (const Slab& slab : stack.slabs) {
            hasMedium_ |= !IsCertain(slab);
            hasLanes_ |= ConnectsInLanes(slab);
        }
        if (hasLanes_) lanes_.Clear();
    }

    /// @param wo, wi  unit, outside of the stack, z not 0
    ValueType Estimate(Vec3 wo, Vec3 wi) {
        if (stack_.Last() == 0 || maxVertices_ < 2) return ValueType(0);
        if (maxVertices_ <= excluded_.vertices && !hasMedium_) return ValueType(0);
        // Each walk is a part of its own: where the light's ends must not shift the camera's numbers.
        rng_.StartPart();
        WalkFromLight(wi);
        rng_.StartPart();
        ValueType sum(0);
        std::array<Vertex, 2> vertices;
        SetFirst(wo, &vertices[1]);
        for (int t = 1; t < maxVertices_; ++t) {
            Vertex& camera = vertices[size_t(t) % 2];
            if (hasLanes_) StartLane();
            if constexpr (Policy::kCountsVertexBeforeSampling) sum += ConnectTo(camera, t);
            if (!SampleNext(camera, Side::Camera)) break;
            if constexpr (!Policy::kCountsVertexBeforeSampling) sum += ConnectTo(camera, t);
            sum += ConnectFrom(camera, t);
            Vertex* next = new (&vertices[size_t(t + 1) % 2]) Vertex;
            Advance(camera, Side::Camera, next);
            if (IsDropped(*next)) break;
        }
        if constexpr (kMayHaveLanes)
            if (hasLanes_) {
                ConnectLanes();
                sum += lanes_.Sum();
            }
        return sum;
    }

  private:
    enum class Side { Light, Camera };
    static constexpr Side Opposite(Side side) { return side == Side::Light ? Side::Camera : Side::Light; }

    /// Light vertices that have room in the object; those beyond it are on the heap.
    static constexpr int kFirstLightVertices = 160;
    /// From the third vertex on a light's walk goes on with this probability at each vertex that turns or
    /// scatters it, and strategies weigh less by it for each such vertex of their light side: the number of
    /// connections grows with the camera's walk only. In media, where walks are long, connections to the
    /// first vertices suffice. Straight passes through specular interfaces count nothing: a light side that
    /// has to go through many of them must not be cut on its way.
    static constexpr float kSurvivalInMedia = 0.25f, kSurvivalInClear = 0.8f;

    struct Vertex {
        int count = 1;       ///< vertices of the walk, this one included
        int interface = -1;  ///< -1: inside a slab
        int slab = -1;       ///< through which the walk came; where it is if inside
        float x = 0;         ///< depth in the slab, if inside
        Vec3 wPrev{0, 0, 1};
        ValueType beta{1};                ///< of the walk up to here, without this vertex
        bool isReachedForCertain = true;  ///< no flight was drawn for the segment to here
        bool isFirst = true;
        bool isUnscattered = true;  ///< by slabs, up to here
        int reflections = 0;        ///< reflections inside the stack, before this vertex
        // The sum over the strategies that cut this walk shorter is ownTerm + pdfReverse * otherTerm.
        float ownTerm = 0, otherTerm = 0;

        // Set by SampleNext().
        bool hasNext = false, nextIsSpecular = false;
        Vec3 wNext{0, 0, 1};
        ValueType betaNext{0};
        float pdfNext = 0;
        int nextSlab = 0;              ///< that wNext leads into
        float extinctionPerDepth = 0;  ///< of it along wNext
        float shorter = 0;             ///< that sum

        bool IsInside() const { return interface < 0; }
    };

    TransportMode ModeOf(Side side) const { return side == Side::Camera ? mode_ : !mode_; }
    /// What one more vertex of the light side takes from the weight of a strategy. Symmetric in the two
    /// directions, so that both walks find the same.
    float Decay(bool isSpecular, bool isStraight) const {
        if (isSpecular) return isStraight ? 1 : kSurvivalInClear;
        return hasMedium_ ? kSurvivalInMedia : kSurvivalInClear;
    }

    void SetFirst(Vec3 w, Vertex* v) const {
        v->interface = stack_.OuterTowards(w);
        v->wPrev = w;
    }

    // ---- Walking --------------------------------------------------------------------------------------

    /// The sides that a walk may draw at a vertex: into the stack, and not out of it. The density of wi is
    /// that of a walk that may leave at any time.
    BxDFContext ContextAt(const Vertex& v, Side side) const {
        BxDFContext context{ModeOf(side), Lobes::BothSides, &rng_};
        if constexpr (!kIsDensity) {
            if (v.isFirst)
                context.sides = Lobes::Transmission;
            else if (v.interface == 0 || v.interface == stack_.Last())
                context.sides = Lobes::Reflection;
        }
        return context;
    }
    bool Leaves(const Vertex& v) const {
        return v.wNext.z > 0 ? v.interface == 0 : v.interface == stack_.Last();
    }
    /// The slab that wNext leads into.
    static int NextSlab(const Vertex& v) {
        return v.IsInside() ? v.slab : v.wNext.z < 0 ? v.interface : v.interface - 1;
    }
    static float DepthIn(const Vertex& v, int slab) {
        return v.IsInside() ? v.x : v.interface == slab ? 0.f : 1.f;
    }

    /// Draws the direction of the next segment. False if the walk ends here.
    bool SampleNext(Vertex& v, Side side) {
        float pdfReverse;
        if (v.IsInside()) {
            const SlabSample s =
                stack_.slabs[size_t(v.slab)].SampleScatter(v.wPrev, SpectrumOf(v.beta), rng_);
            if (s.wi.z == 0) return false;
            v.wNext = s.wi;
            SetBetaNext(v, s.weight, s.pdf, s.pdfReverse, side);
            v.nextIsSpecular = false;
            pdfReverse = s.pdfReverse;
        } else {
            const std::optional<BxDFSample> s =
                stack_.interfaces[size_t(v.interface)].Sample(v.wPrev, ContextAt(v, side));
            if (!s || s->wi.z == 0) return false;
            v.wNext = s->wi;
            if (Leaves(v)) return false;
            if (ModeOf(side) == TransportMode::Radiance) rouletteScale_[size_t(side)] *= Sqr(s->eta);
            SetBetaNext(v, s->weight, s->pdf, s->pdfReverse, side);
            v.nextIsSpecular = s->IsSpecular();
            pdfReverse = s->pdfReverse;
            if (!Policy::kSpecularPasses && v.nextIsSpecular) return false;
        }
        v.nextSlab = NextSlab(v);
        const Slab& slab = stack_.slabs[size_t(v.nextSlab)];
        v.extinctionPerDepth = slab.ExtinctionPerDepth(v.wNext);
        v.shorter = Shorter(v, side, pdfReverse, v.nextIsSpecular, IsStraight(v, v.wNext), IsCertain(slab));
        v.hasNext = SurvivesRoulette(v, side);
        return v.hasNext;
    }

    void SetBetaNext(Vertex& v, SampledSpectrum weight, float pdf, float pdfReverse, Side side) {
        v.pdfNext = pdf;
        if constexpr (!kIsDensity)
            v.betaNext = v.beta * weight;
        else  // the density of the path is that of the camera's walk
            v.betaNext = side == Side::Camera ? v.beta : v.beta * (pdfReverse / pdf);
    }

    static SampledSpectrum SpectrumOf(SampledSpectrum s) { return s; }
    static SampledSpectrum SpectrumOf(float) { return SampledSpectrum(1); }

    bool SurvivesRoulette(Vertex& v, Side side) {
        constexpr int kFirst = 3;  // shorter walks always go on
        constexpr float kLongSurvival = 0.95f;
        const float throughput = rouletteScale_[size_t(side)] * SpectrumOf(v.betaNext).MaxComponent();
        // Nothing left, or nothing that a float can divide by.
        if (!(throughput > std::numeric_limits<float>::min())) return false;
        if (v.count < kFirst) return true;
        // A dark interface should not end a bright walk; in media, weak walks cost more than they bring.
        const float safety = hasMedium_ ? 1.25f : 2.5f;
        float survival = std::min(1.f, safety * throughput);
        if constexpr (kIsDensity) survival = v.nextIsSpecular ? 1 : kLongSurvival;
        if (side == Side::Light) survival *= Decay(v.nextIsSpecular, IsStraight(v, v.wNext));
        if (!(rng_.Uniform() < survival)) return false;
        v.betaNext *= 1 / survival;
        if constexpr (Policy::kRouletteInBothWeights) v.pdfNext *= survival;
        return true;
    }

    /// True if flights through a slab end at a boundary whatever happens.
    static bool IsCertain(const Slab& slab) { return Policy::kOnlyUnscattered || !slab.Scatters(); }
    /// Between smooth interfaces all light that counts has been scattered by a slab, and in a thin one hardly
    /// any flight would be: some are made to, at a uniform depth. Those of the light side always with the
    /// same probability, which is part of its densities. Those of the camera side until the walk has been
    /// scattered: behind that it must go on as light does, which may be trapped for a thousand reflections.
    /// The weights leave the share of the camera's walk out, since the other side cannot know what came
    /// before; they sum to one without it.
    float ForcedShareOfLight(const Slab& slab) const {
        constexpr float kThin = 0.1f;  // optical thickness below which it pays
        return isAllSpecular_ && slab.opticalThickness.MaxComponent() < kThin ? 0.25f : 0.f;
    }
    float ForcedShare(const Vertex& v, const Slab& slab, Side side) const {
        if (IsCertain(slab)) return 0;
        const float share = ForcedShareOfLight(slab);
        if (share == 0 || side == Side::Light) return share;
        // The product of 1 - share over all flights is 1/2: no walk gains much weight by not being forced.
        return !kIsDensity && v.isUnscattered ? 1 / Sqr(float(v.count) + 1) : 0.f;
    }
    /// The density with which a walk flies a stretch of `slab`, as the weights have it.
    /// @param room  from the start of the flight to the boundary that it heads for, as a difference of depths
    float PdfOf(const Slab& slab, const Crossing& crossing, bool endsInside, float room, Side side) const {
        if constexpr (Policy::kOnlyUnscattered) return 1;
        const float pdf = crossing.Pdf(endsInside);
        if (!isAllSpecular_ || side == Side::Camera || !slab.Scatters()) return pdf;
        const float share = ForcedShareOfLight(slab);
        return (1 - share) * pdf + (endsInside && share > 0 ? share / room : 0.f);
    }
    static float Room(float x, Vec3 w) { return w.z < 0 ? 1 - x : x; }
    Flight SampleFlight(const Vertex& v, const Slab& slab, float x, float forcedShare) {
        if constexpr (!Policy::kOnlyUnscattered)
            return slab.SampleFlightAt(v.extinctionPerDepth, x, v.wNext, SpectrumOf(v.betaNext), rng_,
                                       forcedShare);
        const bool isDown = v.wNext.z < 0;
        return {false, isDown ? 1.f : 0.f, 1, slab.CrossAt(v.extinctionPerDepth, isDown ? 1 - x : x)};
    }

    /// Flies to the next vertex. In place: a copy would be read before it has arrived in memory.
    /// @param to  as it is after its constructor
    void Advance(const Vertex& v, Side side, Vertex* to) {
        const int k = v.nextSlab;
        const Slab& slab = stack_.slabs[size_t(k)];
        const bool isDown = v.wNext.z < 0;
        const float x = DepthIn(v, k);
        const float forcedShare = ForcedShare(v, slab, side);
        const Flight flight = SampleFlight(v, slab, x, forcedShare);
        // Roulette would end what was forced to scatter as if it had been rare luck.
        if (forcedShare > 0)
            rouletteScale_[size_t(side)] *= flight.pdf / flight.crossing.Pdf(flight.scatters);

        Vertex& next = *to;
        next.count = v.count + 1;
        next.isFirst = false;
        next.slab = k;
        next.interface = flight.scatters ? -1 : isDown ? k + 1 : k;
        next.x = flight.x;
        next.wPrev = -v.wNext;
        next.isReachedForCertain = IsCertain(slab);
        next.isUnscattered = v.isUnscattered && !flight.scatters;
        next.reflections = v.reflections + ReflectsAt(v, v.wNext);
        const float reverse =
                        PdfOf(slab, flight.crossing, v.IsInside(), Room(flight.x, -v.wNext), Opposite(side)),
                    own = PdfOf(slab, flight.crossing, flight.scatters, Room(x, v.wNext), side);
        if constexpr (Policy::kOnlyUnscattered)
            next.beta = v.betaNext * flight.crossing.pdfBoundary;
        else if constexpr (kIsDensity)
            next.beta = side == Side::Camera ? v.betaNext : v.betaNext * (reverse / flight.pdf);
        else
            next.beta = v.betaNext * flight.crossing.transmittance *
                        ((flight.scatters ? 1 / Slab::AbsCos(v.wNext) : 1.f) / flight.pdf);

        // Other ways to make the segment just flown: its direction drawn by this side or by the other one. A
        // walk of vanishing density leaves the weight to them: large, but no quotient of zeros.
        const float otherSamples = OtherSideMaySample(v, side, IsCertain(slab)) ? 1.f : 0.f;
        next.ownTerm = 1 / std::max(own, kSmallestDensity);
        next.otherTerm =
            Finite((otherSamples + reverse * v.shorter) / std::max(v.pdfNext * own, kSmallestDensity));
    }

    bool IsDropped(const Vertex& v) const {
        if (!v.IsInside()) return false;
        if (Policy::kThinnestMedium > 0 &&
            stack_.slabs[size_t(v.slab)].opticalThickness.MaxComponent() < Policy::kThinnestMedium)
            return true;
        return std::min(v.x, 1 - v.x) < Policy::kNearestVertex;
    }

    /// Densities below this one count as this one, and quotients of densities above the largest float as
    /// that: zero times infinity would be no number.
    static constexpr float kSmallestDensity = std::numeric_limits<float>::min();
    static float Finite(float quotient) { return std::min(quotient, std::numeric_limits<float>::max()); }

    const Vertex& LightVertex(int i) const {
        if (i >= kFirstLightVertices) return moreLight_[size_t(i - kFirstLightVertices)];
        return *std::launder(reinterpret_cast<const Vertex*>(&lightStorage_[size_t(i) * sizeof(Vertex)]));
    }
    /// Makes a vertex behind the kept ones.
    Vertex* PlaceLightVertex() {
        if (numLight_ < kFirstLightVertices)
            return new (&lightStorage_[size_t(numLight_) * sizeof(Vertex)]) Vertex;
        moreLight_.resize(size_t(numLight_ - kFirstLightVertices));
        return &moreLight_.emplace_back();
    }
    /// Flies from the last vertex to the next one, which takes its place if it is not kept.
    Vertex* AdvanceLight(Vertex* v, bool isKept) {
        if (isKept && numLight_ < kFirstLightVertices) {
            Vertex* next = PlaceLightVertex();
            Advance(*v, Side::Light, next);
            return next;
        }
        const Vertex last = *v;
        Vertex* next = PlaceLightVertex();
        Advance(last, Side::Light, next);
        return next;
    }
    void WalkFromLight(Vec3 wi) {
        Vertex* v = PlaceLightVertex();
        SetFirst(wi, v);
        while (true) {
            bool goesOn = MayGoOn(*v) && SampleNext(*v, Side::Light);
            if constexpr (Policy::kStrategies == Strategies::NextEvent)
                v->hasNext = goesOn = goesOn && (v->nextIsSpecular || IsStraight(*v, v->wNext));
            if constexpr (Policy::kStrategies == Strategies::Forward)
                v->hasNext = goesOn = goesOn && v->nextIsSpecular;
            const bool isKept = CanBeConnected(*v);
            if (isKept) ++numLight_;
            if (!goesOn) break;
            v = AdvanceLight(v, isKept);
            if (IsDropped(*v)) break;
            if constexpr (Policy::kStrategies == Strategies::NextEvent)
                if (v->IsInside()) break;
        }
    }
    bool MayGoOn(const Vertex& light) const {
        if (light.count >= std::min(maxVertices_, Policy::kMaxLightVertices)) return false;
        return Policy::kStrategies != Strategies::Forward || HasSpecularAt(light);
    }
    /// False where every connection is 0: a specular vertex, whose segment leads through a clear slab to
    /// another one. There are many of them where a stack has many interfaces that are not there.
    bool CanBeConnected(const Vertex& light) const {
        if (!IsSpecularAt(light)) return true;
        if (!light.hasNext) return false;
        const int k = light.nextSlab;
        return !IsCertain(stack_.slabs[size_t(k)]) ||
               !stack_.interfaces[size_t(light.wNext.z < 0 ? k + 1 : k)].isSpecular;
    }

    // ---- Strategies -----------------------------------------------------------------------------------

    /// True if light goes through an interface between wPrev and w.
    static bool IsStraight(const Vertex& v, Vec3 w) { return !v.IsInside() && v.wPrev.z * w.z < 0; }

    /// v1_s (older vertex z_s of the light side), or v0 (older vertex of the camera side): may the segment
    /// that leaves v have been drawn by the other side?
    bool OtherSideMaySample(const Vertex& v, Side side, bool isNextCertain) const {
        if (v.nextIsSpecular) return false;
        return side == Side::Camera || CameraMaySample(v, isNextCertain);
    }
    /// v1_s of a light vertex z_s. Between segments that are flown for certain, strategy (s, 1) makes the
    /// same samples as (s - 1, 0) and is left out: 2n - 2 strategies become n.
    bool CameraMaySample(const Vertex& v, bool isNextCertain) const {
        if (v.isFirst) return true;
        if constexpr (Policy::kStrategies != Strategies::AllPairs) return false;
        return !(v.isReachedForCertain && isNextCertain);
    }

    /// The sum over the strategies that cut the walk of v before v, once the density of drawing wPrev from
    /// the other side is known: L_s and C_s above.
    float Shorter(const Vertex& v, Side side, float pdfReverse, bool isSpecular, bool isStraight,
                  bool isNextCertain) const {
        if (v.isFirst || Policy::kStrategies == Strategies::Forward) return 0;
        const float decay = Decay(isSpecular, isStraight);
        if (side == Side::Light)
            return Finite(((isSpecular ? 0.f : v.ownTerm) + pdfReverse * v.otherTerm) / decay);
        if constexpr (Policy::kStrategies == Strategies::NextEvent)
            return isStraight || isSpecular ? Finite(pdfReverse * v.otherTerm * decay) : 0.f;
        const bool ownSamples = !isSpecular && !(v.isReachedForCertain && isNextCertain);
        return Finite(((ownSamples ? v.ownTerm : 0.f) + pdfReverse * v.otherTerm) * decay);
    }

    // ---- Connecting -----------------------------------------------------------------------------------

    /// Scattering at a vertex towards a direction that the other side drew.
    BxDFValue ScatterAt(const Vertex& v, Vec3 w, Side side) const {
        if (v.IsInside()) return stack_.slabs[size_t(v.slab)].Scatter(v.wPrev, w);
        return stack_.interfaces[size_t(v.interface)].Evaluate(v.wPrev, w, ContextAt(v, side));
    }
    bool IsSpecularAt(const Vertex& v) const {
        return !v.IsInside() && stack_.interfaces[size_t(v.interface)].isSpecular;
    }

    bool HasSpecularAt(const Vertex& v) const {
        return !v.IsInside() && stack_.interfaces[size_t(v.interface)].hasSpecular;
    }

    static bool ReflectsAt(const Vertex& v, Vec3 w) { return v.wPrev.z * w.z > 0; }
    /// @param w  of the segment between the two, away from the light's vertex
    bool IsExcluded(const Vertex& light, int s, const Vertex& camera, int t, Vec3 w) const {
        if (s + t > std::max(excluded_.vertices, excluded_.directVertices)) return false;
        if (!light.isUnscattered || !camera.isUnscattered) return false;
        if (s + t <= excluded_.vertices) return true;
        return s + t <= excluded_.directVertices &&
               light.reflections + ReflectsAt(light, w) + camera.reflections + ReflectsAt(camera, -w) <= 1;
    }

    /// The segment from `from` along its wNext, if it ends at `to`.
    struct Segment {
        bool exists = false, isCertain = false;
        const Slab* slab = nullptr;
        float start = 0, end = 0;  ///< depths
    };
    Segment SegmentBetween(const Vertex& from, const Vertex& to) const {
        const int k = from.nextSlab;
        const bool isDown = from.wNext.z < 0;
        if (to.IsInside() ? to.slab != k : to.interface != (isDown ? k + 1 : k)) return {};
        const float start = DepthIn(from, k), end = DepthIn(to, k), dx = end - start;
        if (!(isDown ? dx > 0 : dx < 0)) return {};
        const Slab& slab = stack_.slabs[size_t(k)];
        return {true, IsCertain(slab), &slab, start, end};
    }

    /// Strategies (s, 0) for all s: directions of the light side, evaluated at the camera's vertex, now or
    /// when its lane is.
    ValueType ConnectTo(const Vertex& camera, int t) {
        ValueType sum(0);
        if (IsSpecularAt(camera)) return sum;
        if (PutInLane(camera)) return sum;
        for (int i = 0; i < numLight_; ++i) {
            const Vertex& light = LightVertex(i);
            if (light.count + t > maxVertices_) break;
            if (light.hasNext && !IsExcluded(light, light.count, camera, t, light.wNext))
                sum += Connect<Side::Light>(light, camera);
        }
        return sum;
    }
    /// Strategies (s, 1): the direction of the camera side, evaluated at the light's vertices; likewise.
    ValueType ConnectFrom(const Vertex& camera, int t) {
        ValueType sum(0);
        const bool isCertain = IsCertain(stack_.slabs[size_t(camera.nextSlab)]);
        const bool isInLane = PutDirectionInLane(camera);
        for (int i = 0; i < numLight_; ++i) {
            const Vertex& light = LightVertex(i);
            if (light.count + t > maxVertices_) break;
            if (isInLane && light.IsInside()) continue;
            if constexpr (Policy::kStrategies != Strategies::AllPairs)
                if (!light.isFirst) break;
            if (!IsSpecularAt(light) && CameraMaySample(light, isCertain) &&
                !IsExcluded(light, light.count, camera, t, -camera.wNext))
                sum += Connect<Side::Camera>(camera, light);
        }
        return sum;
    }

    /// One path: `from` has drawn its next direction, and it is evaluated at `to`, a vertex of the other
    /// side. The weight is written down in the head of this file, for u = 0; with the sides exchanged it is
    /// the same for u = 1.
    template <Side kSamplingSide>
    ValueType Connect(const Vertex& from, const Vertex& to) const {
        constexpr Side kOther = Opposite(kSamplingSide);
        const Segment segment = SegmentBetween(from, to);
        if (!segment.exists) return ValueType(0);
        const Vec3 w = -from.wNext;
        const BxDFValue scattering = ScatterAt(to, w, kOther);
        if (!(scattering.pdf > 0) && !scattering.f) return ValueType(0);
        // Last, since many connections have come to nothing before it.
        const Crossing crossing =
            segment.slab->CrossAt(from.extinctionPerDepth, std::abs(segment.end - segment.start));

        float weight = 1;
        if constexpr (Policy::kStrategies != Strategies::Forward) {
            const float own = from.pdfNext, other = scattering.pdf;
            const float otherSamples =
                OtherSideMaySample(from, kSamplingSide, segment.isCertain) ? other : 0.f;
            const float ofFlight = PdfOf(*segment.slab, crossing, to.IsInside(),
                                         Room(segment.start, from.wNext), kSamplingSide),
                        ofReverse =
                            PdfOf(*segment.slab, crossing, from.IsInside(), Room(segment.end, w), kOther);
            const float others =
                otherSamples + other * ofReverse * from.shorter +
                own * ofFlight *
                    Shorter(to, kOther, scattering.pdfReverse, false, IsStraight(to, w), segment.isCertain);
            weight = own / (own + others);
        }
        if constexpr (kIsDensity) {
            // Direction and flight as the camera's walk draws them.
            const float density = kSamplingSide == Side::Light
                                      ? scattering.pdf * crossing.Pdf(from.IsInside())
                                      : scattering.pdfReverse * crossing.Pdf(to.IsInside());
            return weight * from.betaNext * density * to.beta;
        } else {
            return from.betaNext * scattering.f * crossing.transmittance * to.beta *
                   (to.IsInside() ? weight / Slab::AbsCos(w) : weight);
        }
    }

    // ---- Connecting in lanes --------------------------------------------------------------------------

    /// True if connections at vertices inside a slab wait until several can be made at once. They never make
    /// excluded paths, which no slab scatters.
    bool ConnectsInLanes(const Slab& slab) const {
        return kMayHaveLanes && SlabConnections::Knows(slab) && ForcedShareOfLight(slab) == 0;
    }
    void StartLane() {
        if (lanes_.IsFull()) ConnectLanes();
        lanes_.StartLane();
    }
    /// Puts the camera's vertex into its lane. False if it must be connected at once.
    bool PutInLane(const Vertex& camera) {
        if constexpr (kMayHaveLanes) {
            if (!camera.IsInside() || !ConnectsInLanes(stack_.slabs[size_t(camera.slab)])) return false;
            lanes_.SetVertex(InsideVertexOf(camera, Side::Camera, SampledSpectrum(1)));
            return true;
        }
        return false;
    }
    /// The same with the direction drawn there, which may lead to light vertices inside.
    bool PutDirectionInLane(const Vertex& camera) {
        if constexpr (kMayHaveLanes) {
            if (!ConnectsInLanes(stack_.slabs[size_t(camera.nextSlab)])) return false;
            lanes_.SetDirection(DirectionOf(camera, Side::Camera, SampledSpectrum(1)));
            return true;
        }
        return false;
    }
    /// Connects the camera's vertices in the lanes to all of the light's, and empties the lanes.
    void ConnectLanes() {
        for (int i = 0; i < numLight_; ++i) {
            const Vertex& light = LightVertex(i);
            if (light.hasNext) {
                const Slab& slab = stack_.slabs[size_t(light.nextSlab)];
                if (ConnectsInLanes(slab))
                    lanes_.ConnectFrom(DirectionOf(light, Side::Light, slab.Scattering()), slab,
                                       maxVertices_);
            }
            if (light.IsInside()) {
                const Slab& slab = stack_.slabs[size_t(light.slab)];
                if (ConnectsInLanes(slab))
                    lanes_.ConnectTo(InsideVertexOf(light, Side::Light, slab.Scattering()), slab,
                                     maxVertices_);
            }
        }
        lanes_.Restart();
    }
    /// @param factor  of the throughput
    SlabConnections::Direction DirectionOf(const Vertex& v, Side side, SampledSpectrum factor) const {
        return {.wx = v.wNext.x,
                .wy = v.wNext.y,
                .wz = v.wNext.z,
                .start = DepthIn(v, v.nextSlab),
                .startsInside = v.IsInside() ? 1.f : 0.f,
                .extinction = v.extinctionPerDepth,
                .pdf = v.pdfNext,
                .otherSamples = OtherSideMaySample(v, side, false) ? 1.f : 0.f,
                .shorter = v.shorter,
                .slab = v.nextSlab,
                .count = v.count,
                .beta = ToArray(v.betaNext * factor)};
    }
    SlabConnections::Vertex InsideVertexOf(const Vertex& v, Side side, SampledSpectrum factor) const {
        // As Shorter() has it for such a vertex.
        const float decay = side == Side::Light ? 1 / kSurvivalInMedia : kSurvivalInMedia;
        return {.wx = v.wPrev.x,
                .wy = v.wPrev.y,
                .wz = v.wPrev.z,
                .x = v.x,
                .ownTerm = v.ownTerm * decay,
                .otherTerm = v.otherTerm * decay,
                .slab = v.slab,
                .count = v.count,
                .beta = ToArray(v.beta * factor)};
    }
    static std::array<float, kNumWavelengths> ToArray(SampledSpectrum s) {
        return std::bit_cast<std::array<float, kNumWavelengths>>(s.Raw());
    }

    const Stack& stack_;
    Rng& rng_;
    TransportMode mode_;
    int maxVertices_;
    KnownPaths excluded_;
    bool hasMedium_ = false, isAllSpecular_ = true;
    bool hasLanes_ = false;  ///< for some slab
    SlabConnections lanes_;  ///< in use if so
    /// Takes out of roulette what is no loss: the solid-angle compression of radiance, and flights that were
    /// forced to scatter.
    std::array<float, 2> rouletteScale_{1, 1};
    int numLight_ = 0;  ///< kept vertices of the light's walk
    // Raw memory: a walk makes few of them, and setting up all would cost as much as a short estimate.
    alignas(Vertex) std::array<std::byte, kFirstLightVertices * sizeof(Vertex)> lightStorage_;
    std::vector<Vertex> moreLight_;  ///< those that have no room there
};

}  // namespace lacquer::layered
