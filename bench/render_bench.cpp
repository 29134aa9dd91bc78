// Times whole renders, and the bare intersection of the same kind of rays, so that the overhead of everything
// else is visible.
//
// usage: render_bench THREADS SPP WIDTHxHEIGHT SCENE [WIDTHxHEIGHT SCENE ...]
//
// One line for each scene: seconds of rendering (parsing and building are not counted), camera samples a
// second, rays a sample, then what the accelerator alone takes for rays recorded from random walks in the
// same scene (nearest hits and shadow rays separately, all threads at once), and the share of the render that
// is thus pure intersection.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"

namespace lacquer {
namespace {

using Clock = std::chrono::steady_clock;
double SecondsSince(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// Rays as a path tracer sends them.
struct RecordedRays {
    std::vector<Ray> nearest;
    std::vector<Ray> shadow;  ///< the segment ends at t = 1
};

/// Walks from the camera with cosine-distributed bounces, recording `count` nearest-hit rays and their shadow
/// rays.
RecordedRays RecordRays(const Scene& scene, Int2 resolution, size_t count, int maxDepth) {
    RecordedRays rays;
    Rng rng(1);
    const SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.5f);
    SurfaceInteraction si;
    RayCounts uncounted;
    while (rays.nearest.size() < count) {
        const CameraSample sample{rng.Uniform2D() * Point2(resolution), rng.Uniform2D(), rng.Uniform()};
        const auto cameraRay = scene.Camera().GenerateRay(sample);
        if (!cameraRay) continue;
        Ray ray = cameraRay->ray;
        for (int depth = 0; depth <= maxDepth; ++depth) {
            rays.nearest.push_back(ray);
            if (!scene.Intersect(ray, Infinity, &si, uncounted)) break;
            if (depth == maxDepth) break;
            const auto& lights = scene.SampledLights();
            if (!lights.empty()) {
                const auto ls = lights[rng.UniformInt(uint32_t(lights.size()))]->SampleLi(
                    LightReference(si), rng.Uniform2D(), lambda);
                if (ls) {
                    const Point3 origin = OffsetRayOrigin(si.p, si.pError, si.n, ls->p - si.p);
                    rays.shadow.push_back({origin, ls->p - origin, si.time});
                }
            }
            const Frame frame = Frame::FromZ(FaceForward(si.n, si.wo));
            ray = SpawnRay(si, frame.FromLocal(SampleCosineHemisphere(rng.Uniform2D())));
        }
    }
    return rays;
}

/// Seconds a ray, with all threads at work; the best of three runs.
template <class Trace>
double SecondsPerRay(const std::vector<Ray>& rays, const Trace& trace) {
    if (rays.empty()) return 0;
    constexpr int64_t kChunk = 4096;
    const int64_t chunks = (int64_t(rays.size()) + kChunk - 1) / kChunk;
    double best = 1e30;
    for (int run = 0; run < 3; ++run) {
        const Clock::time_point start = Clock::now();
        ParallelFor(chunks, [&](int64_t chunk) {
            const size_t end = std::min(rays.size(), size_t((chunk + 1) * kChunk));
            for (size_t i = size_t(chunk * kChunk); i < end; ++i) trace(rays[i]);
        });
        best = std::min(best, SecondsSince(start));
    }
    return best / double(rays.size());
}

void Measure(const std::string& path, Int2 resolution, int spp) {
    Observer silent;
    BuildOptions options;
    options.film.resolution = resolution;
    options.samplesPerPixel = spp;
    const RenderSetup setup = BuildScene(ParseFile(path, &silent), options, &silent);
    RenderOptions render;
    render.endSample = setup.sampler->SamplesPerPixel();
    const RenderStats stats =
        Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, render, silent);

    const RecordedRays rays = RecordRays(*setup.scene, resolution, 2'000'000, 5);
    const Accelerator& accelerator = setup.scene->Accelerator();
    const double nearest = SecondsPerRay(rays.nearest, [&](const Ray& ray) {
        Hit hit;
        accelerator.Intersect(ray, Infinity, &hit);
    });
    const double shadow =
        SecondsPerRay(rays.shadow, [&](const Ray& ray) { accelerator.Occluded(ray, 0.9999f); });
    const double bare = nearest * double(stats.raysTraced) + shadow * double(stats.shadowRays);
    fmt::print(
        "{:24s} {}x{} {} spp: {:6.3f} s  {:5.2f} Msamples/s  {:4.1f} rays/sample | accelerator alone {:5.1f} "
        "+ {:5.1f} Mrays/s "
        "(nearest + shadow), {:6.3f} s = {:2.0f} % of the render\n",
        path.substr(path.rfind('/') + 1), resolution.x, resolution.y, render.endSample, stats.seconds,
        double(stats.cameraRays) / stats.seconds / 1e6,
        double(stats.raysTraced + stats.shadowRays) / double(stats.cameraRays), 1e-6 / nearest,
        shadow > 0 ? 1e-6 / shadow : 0.0, bare, 100 * bare / stats.seconds);
}

}  // namespace
}  // namespace lacquer

int main(int argc, char** argv) {
    if (argc < 5 || argc % 2 == 0) {
        fmt::print(stderr, "usage: render_bench THREADS SPP WIDTHxHEIGHT SCENE [WIDTHxHEIGHT SCENE ...]\n");
        return 1;
    }
    try {
        const lacquer::ThreadLimit threads(std::atoi(argv[1]));
        for (int i = 3; i + 1 < argc; i += 2) {
            int width = 0, height = 0;
            if (std::sscanf(argv[i], "%dx%d", &width, &height) != 2)
                throw std::runtime_error("expected WIDTHxHEIGHT");
            lacquer::Measure(argv[i + 1], {width, height}, std::atoi(argv[2]));
        }
    } catch (const std::exception& e) {
        fmt::print(stderr, "{}\n", e.what());
        return 2;
    }
}
