#include "pbrt/integrators/photon_pass.h"

#include <fmt/format.h>

#include <atomic>

#include "pbrt/core/error.h"
#include "pbrt/core/parallel.h"

namespace lacquer {
namespace {

constexpr int64_t kPathsOfBlock = 2048;
/// 4 GiB, and as much again while they are sorted.
constexpr int64_t kMaxPhotons = (int64_t(4) << 30) / int64_t(sizeof(Photon));
/// Tells the numbers of photons from those of camera samples, and those of iterations from both.
constexpr int kPhotonStream = 4, kIterationStream = 5;

/// Dimensions of photons: the first ones are those of one Halton sequence through all iterations, which is
/// even within each of them and over all; then come random numbers.
class PhotonNumbers final : public Sampler {
  public:
    using Tables = std::vector<RadicalInverse>;
    static Tables MakeTables(int seed) {
        constexpr int kDimensions = 24;
        Tables tables;
        for (const int prime : FirstPrimes(kDimensions))
            tables.emplace_back(prime, true, Hash(seed, kPhotonStream));
        return tables;
    }

    explicit PhotonNumbers(const Tables& tables) : tables_(tables) {}
    void StartPhoton(uint64_t index, Rng rng) {
        index_ = index & ((uint64_t(1) << RadicalInverse::kIndexBits) - 1);
        dimension_ = 0;
        rng_ = rng;
    }
    int SamplesPerPixel() const override { return 1; }
    void StartPixelSample(Int2, int) override {}
    float Get1D() override {
        return dimension_ < tables_.size() ? tables_[dimension_++](index_) : rng_.Uniform();
    }
    Point2 Get2D() override {
        const float x = Get1D();
        return {x, Get1D()};
    }
    std::unique_ptr<Sampler> Clone() const override { return std::make_unique<PhotonNumbers>(*this); }

  private:
    const Tables& tables_;
    size_t dimension_ = 0;
    uint64_t index_ = 0;
    Rng rng_;
};

/// Numbers in [0,1) for an iteration as a whole, even over iterations.
float NumberOf(int iteration, int base, int seed) {
    return OwenRadicalInverse(base, uint64_t(iteration), Hash(seed, kIterationStream, base));
}

/// Wavelengths come in steps of 1/kNumWavelengths: where in a step, and with which of them first. Multiples
/// of 2^-20, so that steps are exact.
float WavelengthNumber(int iteration, int seed) {
    const float inStep = std::floor(NumberOf(iteration, 2, seed) * 0x1p17f) * 0x1p-17f;
    const float step = std::floor(NumberOf(iteration, 3, seed) * kNumWavelengths);
    return (step + inStep) / kNumWavelengths;
}

/// Number of the same wavelengths with another one first: the one `steps` behind.
float RotateWavelengths(float u, int steps) {
    u += float(steps) / kNumWavelengths;
    return u >= 1 ? u - 1 : u;
}
/// Values at wavelengths that were rotated by so many steps, in their order before.
SampledSpectrum RotateBack(SampledSpectrum s, int steps) {
    return MakeLanes<SampledSpectrum::Lanes>(
        [&](int i) { return s[(i + kNumWavelengths - steps) % kNumWavelengths]; });
}

/// The flux of a path that arrives at a surface as it is; f asks for that through the shading normal's plane.
SampledSpectrum FluxThrough(const PathVertex& v) {
    const float area = AbsDot(v.si.wo, v.si.shading.n) / AbsDot(v.si.wo, v.si.n);
    return OverMeanPdf(v.beta * area, v.pdfs, v.isAlone);
}

}  // namespace

float RadiusScale(int iteration) {
    // r(n)^2 / r(1)^2 is the product of (i + alpha) / (i + 1) over i < n, gamma(n + alpha) / gamma(n + 1) but
    // for a constant; for large n that is (n + alpha / 2)^(alpha - 1) to a relative error of 1 / n^2.
    constexpr int kMaxFactors = 4096;
    const int n = iteration + 1, factors = std::min(n, kMaxFactors);
    double square = 1;
    for (int i = 1; i < factors; ++i) square *= (i + kRadiusAlpha) / (i + 1);
    square *= std::pow((n + kRadiusAlpha / 2) / (factors + kRadiusAlpha / 2), kRadiusAlpha - 1);
    return float(std::sqrt(square));
}

/// What all paths of an iteration have in common.
struct PhotonTracer::Iteration {
    const Film& film;
    int seed, index;
    float uLambda, time;
    bool rotates;  ///< the first wavelength is another one from path to path
};

PhotonTracer::PhotonTracer(const IntegratorArgs& args, int maxDepth)
    : scene_(args.scene),
      loc_(args.params.Loc()),
      maxDepth_(maxDepth),
      count_(args.params.GetIntInRange("photonsperiteration", -1, -1, 1 << 26)),
      radius_(args.params.GetFloatInRange("radius", 1, 1e-18f, 1e18f)),
      surroundings_(args),
      emitters_(args.scene) {
    if (args.params.Has("seed")) seed_ = args.params.GetInt("seed", 0);
    // Of the whole image: its parts have the same photons.
    if (count_ <= 0) count_ = int64_t(scene_.Resolution().x) * scene_.Resolution().y;
}

std::unique_ptr<const PhotonPass> PhotonTracer::Trace(const SharedSampleArgs& args) const {
    const int seed = seed_.value_or(args.seed);
    const float uTime = args.drawsTime ? NumberOf(args.index, 5, seed) : 0.5f;
    const Camera& camera = scene_.Camera();
    const Iteration it{.film = args.film,
                       .seed = seed,
                       .index = args.index,
                       .uLambda = args.drawsWavelengths ? WavelengthNumber(args.index, seed) : 0.5f,
                       .time = Lerp(uTime, camera.ShutterOpen(), camera.ShutterClose()),
                       .rotates = args.drawsWavelengths};

    // Blocks of paths, each with a place of its own for its photons.
    const PhotonNumbers::Tables tables = PhotonNumbers::MakeTables(seed);
    const int64_t numBlocks = maxDepth_ > 1 ? (count_ + kPathsOfBlock - 1) / kPathsOfBlock : 0;
    std::vector<std::vector<Photon>> blocks(static_cast<size_t>(numBlocks));
    std::atomic<int64_t> numPhotons = 0;
    ParallelFor(numBlocks, [&](int64_t b) {
        if (args.isStopped()) return;
        ThreadState& state = args.state();
        PhotonNumbers numbers(tables);
        std::vector<Photon>& photons = blocks[size_t(b)];
        for (int64_t i = b * kPathsOfBlock; i < std::min(count_, (b + 1) * kPathsOfBlock); ++i) {
            state.rng = Rng(Hash(seed, it.index, i, kPhotonStream));
            numbers.StartPhoton(uint64_t(it.index) * uint64_t(count_) + uint64_t(i),
                                Rng(Hash(seed, it.index, i, kPhotonStream, 1)));
            TracePath(it, i, numbers, state, &photons);
            state.arena.Reset();
        }
        if ((numPhotons += int64_t(photons.size())) > kMaxPhotons)
            throw SceneError(loc_,
                             fmt::format("the photons of {} paths from the lights take more than {} GiB; "
                                         "ask for fewer by \"integer photonsperiteration\"",
                                         count_, kMaxPhotons * int64_t(sizeof(Photon)) >> 30));
    });
    return std::make_unique<PhotonPass>(PhotonMap(std::move(blocks), radius_ * RadiusScale(it.index)),
                                        it.film.SampleWavelengths(it.uLambda), uTime);
}

void PhotonTracer::TracePath(const Iteration& it, int64_t number, Sampler& numbers, ThreadState& state,
                             std::vector<Photon>* photons) const {
    state.dimensions = BxDFDimensions();
    // What a dispersive event follows differs from path to path: together they have all of the wavelengths.
    const int steps = it.rotates ? int(Hash(it.seed, it.index, number) % kNumWavelengths) : 0;
    const SampledWavelengths lambda = it.film.SampleWavelengths(RotateWavelengths(it.uLambda, steps));
    const std::optional<LightStart> start = StartAtLight(emitters_, it.time, lambda, numbers);
    if (!start) return;

    SubpathEdge edge = start->edge;
    const float emitted = edge.Carried();
    PathVertex v;
    bool isHidden = start->vertex.light->IsDelta();
    TracedPath path = TracedPath::FromLight(surroundings_, state);
    while (path.Depth() < maxDepth_) {
        const Arrival arrival = FollowEdge(&edge, &path, nullptr, &v, lambda, numbers, state);
        if (arrival == Arrival::Passes) continue;
        if (arrival != Arrival::AtVertex) return;
        if (path.Depth() == 1 && !IsLit(start->vertex, v.si, lambda)) return;
        const bool isSurface = v.kind == PathVertex::Kind::Surface;
        // Light that comes straight from the lights is left to next-event estimation.
        if (isSurface && path.Depth() > 1 && IsNonSpecular(v.bsdf.Flags()))
            photons->push_back(
                {RotateBack(FluxThrough(v) / float(count_), steps), v.si.p, v.si.wo, isHidden});
        if (path.Depth() == maxDepth_) return;
        if (!ScatterLight(&v, &edge, numbers, state)) return;
        isHidden &= v.isDelta;

        // Russian roulette on what is left of the light.
        const float survival = edge.Carried() / emitted;
        if (survival < 1) {
            if (numbers.Get1D() >= survival) return;
            edge.beta /= survival;
        }
    }
}

}  // namespace lacquer
