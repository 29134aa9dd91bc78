#include "estimate/scene/scene_photograph.h"

#include <fmt/format.h>

#include <cmath>

#include "estimate/layered/lobe_data.h"
#include "estimate/random.h"
#include "pbrt/core/progress.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"

namespace lacquer::estimate {

namespace {

/// Renders of one simulation, which its error is found from.
constexpr int kPhotographParts = 4;

}  // namespace

ImageBlocks BlocksOf(Int2 resolution, int blocks) {
    const int longer = std::max(resolution.x, resolution.y);
    const auto along = [&](int side) {
        return std::max(1, int(std::lround(double(blocks) * side / longer)));
    };
    return {{along(resolution.x), along(resolution.y)}};
}

Vector ImageBlocks::MeansOf(const Image& image) const {
    const Int2 size = image.Resolution();
    Vector sums = Vector::Zero(Eigen::Index(3) * count.x * count.y), pixels = sums;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const Eigen::Index block =
                Eigen::Index(y) * count.y / size.y * count.x + Eigen::Index(x) * count.x / size.x;
            for (int c = 0; c < 3; ++c) {
                sums[3 * block + c] += double(image.Get({x, y}, c));
                pixels[3 * block + c] += 1;
            }
        }
    return sums.cwiseQuotient(pixels.cwiseMax(1));
}

ScenePhotograph::ScenePhotograph(const SceneParameters& parameters, const Image& photograph,
                                 const std::string& path, const Options& options)
    : parameters_(parameters), options_(options) {
    const RenderSetup setup = BuildScene(parameters_.With(parameters_.Start()), {}, nullptr);
    const Int2 film = setup.film->Resolution(), size = photograph.Resolution();
    if (std::abs(double(size.x) * film.y - double(size.y) * film.x) > 0.02 * double(size.x) * film.y)
        throw SceneError(
            {path}, fmt::format("is {} x {} pixels; expected the ratio of the scene's film, {} x {}", size.x,
                                size.y, film.x, film.y));
    blocks_ = BlocksOf(film, options.blocks);
    if (size.x < blocks_.count.x || size.y < blocks_.count.y)
        throw SceneError({path}, fmt::format("is {} x {} pixels; expected at least {} x {}", size.x, size.y,
                                             blocks_.count.x, blocks_.count.y));
    resolution_ = {blocks_.count.x * options.pixelsOfBlock, blocks_.count.y * options.pixelsOfBlock};
    const Vector all = blocks_.MeansOf(photograph);
    if (!all.allFinite()) throw SceneError({path}, "has pixels that are not finite");
    const double least = 10 * kFloorOfPeak * all.maxCoeff();
    for (Eigen::Index i = 0; i < all.size(); ++i)
        if (all[i] > 0 && all[i] > least) used_.push_back(i);
    observed_ = all(used_);
    for (const char* prefix : {"", "error of "})
        for (const Eigen::Index i : used_)
            names_.push_back(fmt::format("{}{} of block {}, {}", prefix, "rgb"[i % 3],
                                         i / 3 % blocks_.count.x + 1, i / 3 / blocks_.count.x + 1));
}

Vector ScenePhotograph::Render(const SceneDescription& scene, uint64_t seed) const {
    BuildOptions build;
    build.film.resolution = resolution_;
    build.samplesPerPixel = options_.samples / kPhotographParts;
    build.given.Set(&SceneOptions::seed, int(seed >> 34));
    const RenderSetup setup = BuildScene(scene, build, nullptr);
    RenderOptions render;
    render.endSample = setup.sampler->SamplesPerPixel();
    render.seed = setup.generatorSeed;
    Observer nobody;
    lacquer::Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, render, nobody);
    return blocks_.MeansOf(*setup.film->Develop())(used_);
}

Vector ScenePhotograph::Simulate(const Vector& x, uint64_t seed) const {
    SceneDescription scene = parameters_.With(x);
    // The pixels are far coarser than the photograph's: its filter would blur blocks into each other.
    scene.filter.type = "box";
    scene.filter.parameters.clear();
    const auto m = Eigen::Index(used_.size());
    Vector sum = Vector::Zero(m), squares = Vector::Zero(m);
    for (int part = 0; part < kPhotographParts; ++part) {
        const Vector values = Render(scene, Hash(seed, part));
        sum += values;
        squares += values.cwiseAbs2();
    }
    const Vector mean = sum / kPhotographParts;
    const auto exposure = parameters_.Exposure();
    const double gain = exposure ? x[Eigen::Index(*exposure)] : 1;
    Vector result(2 * m);
    result << gain * mean.cwiseMax(0),
        gain * ((squares / kPhotographParts - mean.cwiseAbs2()).cwiseMax(0) / (kPhotographParts - 1))
                   .cwiseSqrt();
    return result;
}

}  // namespace lacquer::estimate
