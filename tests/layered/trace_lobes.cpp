// Computes lobes by brute force: the slabs and interfaces of a stack as media between large rectangles of
// triangles, and paths through them, event by event, at positions in space. Nothing of src/layered is in it.
//
//   trace_lobes STACK PATHS FILE [SEED]     STACK: v1, v2, v3, v4, the validation stacks of [Guo et al. 2018]
#include <fmt/format.h>

#include <cstdlib>

#include "layered/block_lobe.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"
#include "pbrt/integrators/medium_tracking.h"
#include "pbrt/integrators/traced_path.h"
#include "support/scene_parts.h"

namespace lacquer::layered::test {
namespace {

using lacquer::test::BuildText;

// ---- Scenes -------------------------------------------------------------------------------------------

/// A spectrum with the values of red, green and blue where the paths have their wavelengths: see
/// Wavelengths().
std::string Spectrum(const std::string& name, const std::array<double, 3>& rgb) {
    return fmt::format("\"spectrum {}\" [360 {} 470 {} 480 {} 590 {} 600 {} 830 {}] ", name, rgb[0], rgb[0],
                       rgb[1], rgb[1], rgb[2], rgb[2]);
}
/// 401, 518.5, 636 and 753.5 nm: red, green, blue, and blue again.
SampledWavelengths Wavelengths() { return SampledWavelengths::SampleUniform(0.0872f); }

std::string Medium(const std::string& name, double sigma_t, const std::array<double, 3>& albedo,
                   const std::string& phase) {
    std::array<double, 3> sigma_s{}, sigma_a{};
    for (size_t c = 0; c < 3; ++c) {
        sigma_s[c] = sigma_t * albedo[c];
        sigma_a[c] = sigma_t - sigma_s[c];
    }
    return fmt::format("MakeNamedMedium \"{}\" \"string type\" \"homogeneous\" {}{}{}\n", name,
                       Spectrum("sigma_s", sigma_s), Spectrum("sigma_a", sigma_a), phase);
}
std::string Glass(double alphaU, double alphaV, double eta) {
    return fmt::format(
        "Material \"dielectric\" \"float eta\" {} \"float uroughness\" {} \"float vroughness\" {} "
        "\"bool remaproughness\" false \"string distribution\" \"beckmann\"\n",
        eta, alphaU, alphaV);
}
std::string Copper(double alpha) {
    return fmt::format(
        "Material \"conductor\" {}{}\"float roughness\" {} \"bool remaproughness\" false "
        "\"string distribution\" \"beckmann\"\n",
        Spectrum("eta", {0.200438, 0.924033, 1.102212}), Spectrum("k", {3.912949, 2.452848, 2.142188}),
        alpha);
}
/// A rectangle that faces up, so wide that no path sees its end: slabs are 1 thick.
std::string Interface(double z, const std::string& below, const std::string& above,
                      const std::string& material) {
    constexpr double r = 2000;
    return fmt::format(
        "MediumInterface \"{}\" \"{}\"\n{}Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
        "\"point3 P\" [{} {} {} {} {} {} {} {} {} {} {} {}] \"point2 uv\" [0 0 1 0 1 1 0 1]\n",
        below, above, material, -r, -r, z, r, -r, z, r, r, z, -r, r, z);
}

std::string SceneOf(const std::string& stack) {
    const std::array<double, 3> rgb = {0.5, 0.7, 0.95};
    const auto hg = [](double g) { return fmt::format("\"string phase\" \"hg\" \"float g\" {} ", g); };
    const auto fibres = [](const std::string& along) {
        return "\"string phase\" \"fibre\" \"float stddev\" 0.05 \"vector3 orientation\" [" + along + "] ";
    };
    const auto oneSlab = [&](double sigma_t, double g, double alpha) {
        return Medium("m", sigma_t, rgb, hg(g)) + Interface(0, "m", "", Glass(0.05, 0.05, 1.5)) +
               Interface(-1, "", "m", Copper(alpha));
    };
    std::string scene = "Film \"rgb\" Camera \"orthographic\" Integrator \"volpath\" WorldBegin\n";
    if (stack == "v1") return scene + oneSlab(1, 0.5, 0.05);
    if (stack == "v2") return scene + oneSlab(2, 0.9, 0.01);
    if (stack == "v3") return scene + oneSlab(5, 0.95, 0.01);
    if (stack != "v4") throw std::runtime_error("no stack is called " + stack);
    return scene + Medium("m", 1, rgb, fibres("1 1 0")) + Medium("n", 1, {0.5, 0.95, 0.5}, fibres("1 -1 0")) +
           Interface(0, "m", "", Glass(0.05, 0.25, 1.5)) +
           Interface(-1, "n", "m", Glass(0.01, 0.01, 1.2 / 1.5)) + Interface(-2, "", "n", Copper(0.05));
}

// ---- Paths --------------------------------------------------------------------------------------------

/// A path through the scene, with the weight f |cos| / pdf of what it met.
class BruteForcePath {
  public:
    BruteForcePath(const RenderSetup& setup, Vec3 wo, ThreadState& state)
        : scene_(*setup.scene), state_(state), ray_{100.f * wo, -wo, 0} {}

    /// False if the path is absorbed, or goes where nothing of the scene is but not up.
    bool Follow() {
        for (;;) {
            SurfaceInteraction si;
            const bool hit = scene_.Intersect(ray_, Infinity, &si, state_.rays);
            const float tMax = hit ? Dot(si.p - ray_.o, ray_.d) : kMaxRayDistance;
            // Paths that slip past the rectangles in a medium end here too.
            if (medium_ && ScatterBefore(tMax)) {
                if (!SurvivesRoulette()) return false;
                continue;
            }
            if (!hit) return ray_.d.z > 0;
            if (!ScatterAt(si) || !SurvivesRoulette()) return false;
        }
    }
    Vec3 Direction() const { return ray_.d; }
    SampledSpectrum Weight() const { return beta_; }

  private:
    /// True if the medium scatters the path before tMax. Extinctions are the same at all wavelengths.
    bool ScatterBefore(float tMax) {
        bool scattered = false;
        TrackCollisions(*medium_, ray_, tMax, state_.rng.Uniform(), state_.rng, lambda_,
                        [&](const MajorantCollision& at) {
                            beta_ *= at.medium.sigma_s / at.sigmaMaj;
                            const PhaseSample sample =
                                medium_->Phase(lambda_, state_.arena).Sample(-ray_.d, state_.rng);
                            beta_ *= sample.weight;
                            ray_ = {at.p, sample.wi, 0};
                            scattered = true;
                            return false;
                        });
        return scattered;
    }
    bool ScatterAt(SurfaceInteraction& si) {
        BxDF* const bxdf = si.material->MakeBxDF(TextureContext(si), lambda_, state_.arena);
        const Frame frame = Frame::FromZX(si.shading.n, si.shading.dpdu);
        const BxDFContext context{.rng = &state_.rng};
        const float lobe = state_.rng.Uniform();
        const auto s = bxdf->Sample(frame.ToLocal(si.wo), {lobe, state_.rng.Uniform2D()}, context);
        if (!s) return false;
        beta_ *= s->weight;
        const Vec3 wi = frame.FromLocal(s->wi);
        medium_ = si.MediumToward(wi, medium_);
        ray_ = SpawnRay(si, wi);
        return true;
    }
    bool SurvivesRoulette() {
        const float survival = std::min(1.f, 4 * beta_.MaxComponent());
        if (!(state_.rng.Uniform() < survival)) return false;
        beta_ *= 1 / survival;
        return true;
    }

    const Scene& scene_;
    ThreadState& state_;
    Ray ray_;
    const lacquer::Medium* medium_ = nullptr;
    SampledWavelengths lambda_ = Wavelengths();
    SampledSpectrum beta_{1};
};

int Run(int argc, char** argv) {
    if (argc < 4) {
        fmt::print(stderr, "usage: trace_lobes STACK PATHS FILE [SEED]\n");
        return 1;
    }
    const RenderSetup setup = BuildText(SceneOf(argv[1]));
    const int64_t count = int64_t(std::atof(argv[2])), perPart = 1 << 16;
    const uint64_t seed = argc > 4 ? std::strtoull(argv[4], nullptr, 10) : 1;
    std::vector<BlockLobeSums> parts(size_t((count + perPart - 1) / perPart));
    ParallelFor(int64_t(parts.size()), [&](int64_t part) {
        BlockLobeSums& sums = parts[size_t(part)];
        ThreadState state;
        for (int64_t i = 0; i < perPart; ++i) {
            state.rng = Rng(Hash(seed, part, i));
            state.arena.Reset();
            BruteForcePath path(setup, FromTheLeft(std::sqrt(0.5f)), state);
            if (path.Follow())
                sums.Add(path.Direction(), path.Weight());
            else
                sums.AddNothing();
        }
    });
    BlockLobeSums all;
    for (const BlockLobeSums& sums : parts) all.Merge(sums);
    WriteLobe(argv[3], all.Lobe(),
              fmt::format(
                  "# f |cos theta_i| of the stack {} by {:.3g} paths between triangles (trace_lobes): means "
                  "over blocks\n# of the projected hemisphere, red, green, blue, and their standard errors. "
                  "See block_lobe.h.\n",
                  argv[1], double(count)));
    return 0;
}

}  // namespace
}  // namespace lacquer::layered::test

int main(int argc, char** argv) {
    try {
        return lacquer::layered::test::Run(argc, argv);
    } catch (const std::exception& e) {
        fmt::print(stderr, "trace_lobes: {}\n", e.what());
        return 1;
    }
}
