// Integrator "mlt": Metropolis light transport in primary sample space [Kelemen et al. 2002], multiplexed
// [Hachisuka et al. 2014]. Markov chains visit paths of a number of scattering events each in proportion to
// what they bring to the image; which of the strategies of bidirectional path tracing makes a path is one of
// the numbers that mutate. It pays where light comes along few paths that are hard to find: through a gap, or
// by a caustic that is seen in a mirror. The samples per pixel are mutations; `Sampler` has no say.
//
//   "integer maxdepth"              5       scattering events of a path after which it ends, up to 1000
//   "integer bootstrapsamples"      100000  independent paths for each number of scattering events, from
//   which
//                                           the brightness of the image follows, and where chains start
//   "integer chains"                1000    Markov chains
//   "integer mutationsperpixel"     100     mutations of all chains together, over the number of pixels
//   "float largestepprobability"    0.3     of a mutation that draws all numbers anew
//   "float sigma"                   0.01    standard deviation by which other mutations move each number
//   "bool regularize"               false   widens narrow lobes after the first diffuse or glossy event of a
//                                           path
#include <fmt/format.h>

#include <atomic>

#include "pbrt/core/error.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/progress.h"
#include "pbrt/film/estimate_xyz.h"
#include "pbrt/integrators/bidirectional.h"
#include "pbrt/integrators/film_sample.h"
#include "pbrt/integrators/primary_samples.h"
#include "pbrt/integrators/substitutes.h"

namespace lacquer {
namespace {

constexpr int kMaxDepth = 1000, kMaxChains = 1 << 20, kMaxMutations = 1 << 24;
/// Each takes twelve bytes.
constexpr int64_t kMaxStartPaths = int64_t(1) << 26;
/// Paths that one thread makes at a time.
constexpr int64_t kStartBlock = 256;
constexpr int64_t kMutationsBetweenLooks = 16;
/// Less light than this counts as none: weights are its reciprocal.
constexpr float kMinContribution = 1e-30f;

enum Stream { kCameraStream, kLightStream, kConnectionStream };
/// Tell random numbers of different use from each other.
enum Purpose { kStartPath = 4, kStartChoice, kMutations };

int MutationsPerPixel(const Params& params) {
    return params.GetIntInRange("mutationsperpixel", 100, 1, kMaxMutations);
}

struct MltSettings {
    explicit MltSettings(const Params& params)
        : maxDepth(params.GetIntInRange("maxdepth", 5, 0, kMaxDepth)),
          startPaths(params.GetIntInRange("bootstrapsamples", 100000, 1, 1 << 30)),
          chains(params.GetIntInRange("chains", 1000, 1, kMaxChains)),
          steps{params.GetFloatInRange("largestepprobability", 0.3f, 0, 1),
                params.GetFloatInRange("sigma", 0.01f, 0, 1)} {
        MutationsPerPixel(params);
        if (NumStartPaths() > kMaxStartPaths)
            params.Fail("bootstrapsamples",
                        fmt::format("{} bootstrapsamples for each of {} numbers of scattering events are {} "
                                    "paths; at most {} are allowed",
                                    startPaths, maxDepth + 1, NumStartPaths(), kMaxStartPaths));
    }
    int64_t NumStartPaths() const { return int64_t(startPaths) * (maxDepth + 1); }

    int maxDepth, startPaths, chains;
    PrimarySamples::Steps steps;
};

/// What a path brings to the image.
struct MltPath {
    FilmLight light;
    SampledWavelengths lambda;
    float contribution = 0;  ///< to which the density of the chains is proportional
};

/// What the chains follow: the sum of the three responses of the eye. With luminance alone, dispersed light
/// of short wavelengths, which carry one wavelength and nearly no luminance, would come as few paths of huge
/// weight: at 400 nm the eye's blue response is 170 times as large.
float ContributionOf(SampledSpectrum L, const SampledWavelengths& lambda) {
    const XYZ xyz = EstimateXYZ(L, lambda);
    const float sum = xyz.x + xyz.y + xyz.z;
    return sum >= kMinContribution && std::isfinite(sum) ? sum : 0.f;
}

/// Paths of an image from primary samples.
class MltPaths {
  public:
    MltPaths(const Camera& camera, const BidirectionalStrategies& strategies, const Film& film,
             const Jitter& jitter)
        : camera_(camera), strategies_(strategies), film_(film), jitter_(jitter) {
        const auto [first, last] = film.SplatRange();
        corner_ = first;
        size_ = glm::max(last - first, Vec2(0));
        const Vec2 resolution(film.Resolution());
        partOfImage_ = size_.x * size_.y / (resolution.x * resolution.y);
    }

    /// @param depth  scattering events
    MltPath Make(int depth, PrimarySamples& samples, ThreadState& state) const {
        state.rng = Rng(samples.PathSeed());
        state.dimensions = {};
        samples.StartStream(kCameraStream);
        // The camera itself is drawn for a vertex of a path from a light only where something scatters.
        const int numStrategies = depth == 0 ? 1 : depth + 2;
        const int s = std::min(int(samples.Get1D() * float(numStrategies)), numStrategies - 1);
        MltPath path;
        path.light = LightOf(size_t(s), size_t(depth + 2 - s), samples, &path.lambda, state);
        path.light.L *= float(numStrategies);
        state.arena.Reset();
        if (!path.light.L) return path;
        if (path.light.L.IsValid())
            path.contribution = ContributionOf(path.light.L, path.lambda);
        else
            ++state.badSamples;
        return path;
    }

  private:
    CameraSample SampleCamera(PrimarySamples& samples) const {
        const Point2 u = samples.Get2D();
        CameraSample sample;
        sample.pFilm = corner_ + u * size_;
        sample.time = samples.Get1D();
        sample.pLens = samples.Get2D();
        if (!jitter_.pixels) {
            sample.pFilm = glm::floor(sample.pFilm) + Point2(0.5f);
            sample.time = 0.5f;
            sample.pLens = Point2(0.5f);
        }
        return sample;
    }

    /// By one strategy, without the probability with which it was chosen.
    FilmLight LightOf(size_t s, size_t t, PrimarySamples& samples, SampledWavelengths* lambda,
                      ThreadState& state) const {
        const float uLambda = samples.Get1D();
        *lambda = film_.SampleWavelengths(jitter_.wavelengths ? uLambda : 0.5f);
        const CameraSample sample = SampleCamera(samples);
        const std::optional<CameraRay> ray = camera_.GenerateRay(sample);
        if (!ray) return {};
        Subpath cameraPath(state.arena), lightPath(state.arena);
        if (t > 1) {
            strategies_.TraceCameraPath(cameraPath, t, *ray, *lambda, samples, state);
            if (s == 0)
                return {sample.pFilm,
                        Found(lightPath, cameraPath, t, *lambda) * (ray->weight * partOfImage_)};
            if (cameraPath.Size() != t || !IsConnectible(cameraPath[t - 1])) return {};
        }
        if (s > 1) {
            samples.StartStream(kLightStream);
            state.rng = Rng(Hash(samples.PathSeed(), kLightStream));
            strategies_.TraceLightPath(lightPath, s, ray->ray.time, *lambda, samples, state);
            if (lightPath.Size() != s || !IsConnectible(lightPath[s - 1])) return {};
        }
        samples.StartStream(kConnectionStream);
        state.rng = Rng(Hash(samples.PathSeed(), kConnectionStream));
        if (t == 1)
            return strategies_.CameraLight(lightPath, cameraPath, s, *lambda, samples, state)
                .value_or(FilmLight{});
        const SampledSpectrum L =
            s == 1 ? strategies_.DirectLight(lightPath, cameraPath, t, *lambda, samples, state)
                   : strategies_.Connect(lightPath, cameraPath, s, t, *lambda, state);
        return {sample.pFilm, L * (ray->weight * partOfImage_)};
    }
    /// What a path from the camera meets by itself at the end of its last edge, and along it.
    SampledSpectrum Found(const Subpath& lightPath, const Subpath& cameraPath, size_t t,
                          const SampledWavelengths& lambda) const {
        SampledSpectrum L(0);
        if (cameraPath.Size() + 1 >= t) L += BidirectionalStrategies::Glow(cameraPath, t);
        if (cameraPath.Size() == t) L += strategies_.Emission(lightPath, cameraPath, t, lambda);
        return L;
    }

    const Camera& camera_;
    const BidirectionalStrategies& strategies_;
    const Film& film_;
    Jitter jitter_;
    Point2 corner_;
    Vec2 size_;
    float partOfImage_;  ///< from which camera rays are drawn, where the whole image is 1
};

class MltChains final : public MarkovChains {
  public:
    MltChains(const MltSettings& settings, const MltPaths& paths, int seed)
        : settings_(settings), paths_(paths), seed_(seed) {}

    int64_t NumStartPaths() const override { return settings_.NumStartPaths(); }

    bool Start(const ChainWork& work, Observer& observer) override {
        const std::vector<float> contributions = Bootstrap(work);
        if (contributions.empty()) return false;
        std::vector<double> sums;
        sums.reserve(contributions.size());
        double sum = 0;
        for (const float contribution : contributions) sums.push_back(sum += double(contribution));
        // The sum over all numbers of scattering events of the means.
        scale_ = float(sum / settings_.startPaths);
        if (sum > 0)
            StartChains(sums, work);
        else
            observer.Warn(fmt::format(
                "none of the {} paths before the first mutation found light: the image is black; more "
                "\"bootstrapsamples\" may find some",
                NumStartPaths()));
        return true;
    }

    int64_t Run(int64_t mutations, const ChainWork& work) override {
        if (chains_.empty()) {
            work.advance(mutations - done_);
            return done_ = mutations;
        }
        std::atomic<int64_t> done = done_;
        ParallelFor(settings_.chains, [&](int64_t i) {
            ThreadState& state = work.state();
            Chain& chain = chains_[size_t(i)];
            const int64_t end = ShareOf(i, mutations);
            while (chain.mutations < end && !work.shouldStop()) {
                const int64_t count = std::min(kMutationsBetweenLooks, end - chain.mutations);
                for (int64_t k = 0; k < count; ++k) Mutate(&chain, state);
                done += count;
                work.advance(count);
            }
        });
        return done_ = done;
    }

  private:
    struct Chain {
        int depth;
        PrimarySampleChain<MltPath> steps;
        int64_t mutations = 0;
    };

    /// Of all mutations, that of one chain.
    int64_t ShareOf(int64_t chain, int64_t mutations) const {
        const int64_t each = mutations / settings_.chains, rest = mutations % settings_.chains;
        return each + (chain + 1) * rest / settings_.chains - chain * rest / settings_.chains;
    }
    MltPath MakeStart(int64_t i, PrimarySamples& samples, const ChainWork& work) const {
        samples.StartChain(Hash(seed_, kStartPath, i));
        return paths_.Make(int(i / settings_.startPaths), samples, work.state());
    }

    /// Contributions of the first paths; empty if it was stopped.
    std::vector<float> Bootstrap(const ChainWork& work) const {
        std::vector<float> contributions(static_cast<size_t>(NumStartPaths()));
        std::atomic<bool> stopped = false;
        ParallelFor((NumStartPaths() + kStartBlock - 1) / kStartBlock, [&](int64_t block) {
            if (stopped || work.shouldStop()) {
                stopped = true;
                return;
            }
            const int64_t begin = block * kStartBlock, end = std::min(begin + kStartBlock, NumStartPaths());
            PrimarySamples samples(settings_.steps);
            for (int64_t i = begin; i < end; ++i)
                contributions[size_t(i)] = MakeStart(i, samples, work).contribution;
            work.advance(end - begin);
        });
        if (stopped) contributions.clear();
        return contributions;
    }

    /// Each at one of the first paths, in proportion to their contributions. So chains are at no time nearer
    /// to these paths than they should be: there is no bias to wait for [Veach 1997, ch. 11].
    ///
    /// Their starts are spread evenly over the paths, which are in the order of their scattering events:
    /// each number of these gets its share of the chains.
    void StartChains(const std::vector<double>& sums, const ChainWork& work) {
        const double offset = double(Rng(Hash(seed_, kStartChoice)).Uniform());
        std::vector<std::optional<Chain>> started(static_cast<size_t>(settings_.chains));
        ParallelFor(settings_.chains, [&](int64_t c) {
            double u = double(c) / settings_.chains + offset;
            u = (u - std::floor(u)) * sums.back();
            const auto at = std::upper_bound(sums.begin(), sums.end(), u);
            const int64_t i =
                std::min(at, std::lower_bound(sums.begin(), sums.end(), sums.back())) - sums.begin();
            PrimarySamples samples(settings_.steps);
            const MltPath path = MakeStart(i, samples, work);
            samples.Reseed(Hash(seed_, kMutations, c));
            started[size_t(c)] = Chain{int(i / settings_.startPaths), {std::move(samples), path}};
        });
        chains_.reserve(started.size());
        for (std::optional<Chain>& chain : started) chains_.push_back(std::move(*chain));
    }

    void Mutate(Chain* chain, ThreadState& state) const {
        chain->steps.Mutate(
            [&](PrimarySamples& samples) { return paths_.Make(chain->depth, samples, state); },
            [&](const MltPath& path, float weight) {
                if (!state.film->AddSplat(path.light.p, path.light.L * (weight * scale_), path.lambda))
                    ++state.badSamples;
            });
        ++chain->mutations;
    }

    const MltSettings& settings_;
    MltPaths paths_;
    int seed_;
    float scale_ = 0;  ///< mean contribution of independent paths
    std::vector<Chain> chains_;
    int64_t done_ = 0;
};

class MltIntegrator final : public Integrator {
  public:
    explicit MltIntegrator(const IntegratorArgs& args)
        : scene_(args.scene),
          settings_(args.params),
          surroundings_(args),
          strategies_(args, args.params.GetBool("regularize", false), false) {
        RequireImportance(args);
    }
    bool MakesSplats() const override { return true; }
    bool RendersMedia() const override { return true; }
    bool UsesChains() const override { return true; }
    std::unique_ptr<MarkovChains> MakeChains(const Film& film, int seed,
                                             const Jitter& jitter) const override {
        return std::make_unique<MltChains>(settings_, MltPaths(scene_.Camera(), strategies_, film, jitter),
                                           seed);
    }

    /// What the camera ray meets is for the auxiliary outputs alone.
    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        RecordFirstHit(surroundings_, cameraRay, lambda, sampler, state);
        return SampledSpectrum(0);
    }

  private:
    const Scene& scene_;
    MltSettings settings_;
    PathSurroundings surroundings_;
    BidirectionalStrategies strategies_;
};

std::unique_ptr<Integrator> CreateMlt(const IntegratorArgs& args) {
    if (const std::string why = WhyNoLightPaths(args.scene); !why.empty()) {
        for (const char* name : {"bootstrapsamples", "chains", "mutationsperpixel"})
            args.params.Ignore("integer", name);
        for (const char* name : {"largestepprobability", "sigma"}) args.params.Ignore("float", name);
        return VolPathInstead(args, "integrator \"mlt\" " + why);
    }
    return std::make_unique<MltIntegrator>(args);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "mlt", CreateMlt,
                 {.makesSplats = true, .mutationsPerPixel = MutationsPerPixel});

}  // namespace lacquer
