// Small parts of the renderer, by themselves: loading a large mesh, samplers, spectra, colour conversion,
// films.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "pbrt/base/sampler.h"
#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/core/color_space.h"
#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"

namespace lacquer {
namespace {

/// A wavy square of 2 n^2 triangles as a binary PLY file, removed at the end.
class WavyPly {
  public:
    explicit WavyPly(int n) : path_(std::filesystem::temp_directory_path() / fmt::format("wavy-{}.ply", n)) {
        std::ofstream out(path_, std::ios::binary);
        const int vertices = (n + 1) * (n + 1), triangles = 2 * n * n;
        out << "ply\nformat binary_little_endian 1.0\nelement vertex " << vertices
            << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << triangles
            << "\nproperty list uchar int vertex_indices\nend_header\n";
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j) {
                const float x = float(i) / float(n), y = float(j) / float(n);
                const float p[3] = {x, y, 0.02f * std::sin(40 * x) * std::sin(37 * y)};
                out.write(reinterpret_cast<const char*>(p), sizeof(p));
            }
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const int a = i * (n + 1) + j, b = a + 1, c = a + n + 1, d = c + 1;
                for (const auto& t : {std::array{a, b, c}, std::array{b, d, c}}) {
                    out.put(3);
                    out.write(reinterpret_cast<const char*>(t.data()), sizeof(t));
                }
            }
    }
    ~WavyPly() { std::filesystem::remove(path_); }
    std::string Path() const { return path_.string(); }
    int64_t Bytes() const { return int64_t(std::filesystem::file_size(path_)); }

  private:
    std::filesystem::path path_;
};

// Reading the file into a mesh alone; the figure is the speed over the file's bytes.
void LoadPly(benchmark::State& state) {
    const WavyPly ply(707);
    Observer silent;
    const std::string text =
        fmt::format("WorldBegin\nShape \"plymesh\" \"string filename\" \"{}\"\n", ply.Path());
    BuildOptions options;
    options.film.resolution = Int2(8, 8);
    double loadOnly = 0, bytesPerTriangle = 0;
    for (auto _ : state) {
        (void)_;
        SceneDescription description = ParseText(text, "bench", "", &silent);
        const Params params = MakeParams(description.shapes[0], "shape", FileResolver());
        const auto start = std::chrono::steady_clock::now();
        struct NoTextures final : TextureLibrary {
            const FloatTexture* Float(const std::string&, const FileLoc&) override { return nullptr; }
            const SpectrumTexture* Spectrum(const std::string&, SpectrumKind, const FileLoc&) override {
                return nullptr;
            }
            const FloatTexture* Own(std::unique_ptr<FloatTexture>) override { return nullptr; }
            const SpectrumTexture* Own(std::unique_ptr<SpectrumTexture>) override { return nullptr; }
            ImageCache& Images() override { throw std::logic_error("no images here"); }
        } textures;
        auto shapes = Registry<ShapeKind>::Find("plymesh")({params, Transform(), false, textures, &silent});
        benchmark::DoNotOptimize(shapes);
        loadOnly = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        state.SetIterationTime(loadOnly);
    }
    const RenderSetup setup = BuildScene(ParseText(text, "bench", "", &silent), options, &silent);
    bytesPerTriangle = double(setup.scene->GeometryBytes() + setup.scene->Accelerator().MemoryBytes()) /
                       double(setup.scene->NumPrimitives());
    state.SetBytesProcessed(state.iterations() * ply.Bytes());
    state.counters["triangles"] = double(setup.scene->NumPrimitives());
    state.counters["bytes/triangle with BVH"] = bytesPerTriangle;
}
BENCHMARK(LoadPly)->UseManualTime()->Unit(benchmark::kMillisecond);

// One dimension of a sampler at 64 samples a pixel.
void SamplerGet(benchmark::State& state, const char* name) {
    const Params params("sampler", {}, {}, &ColorSpace::SRGB());
    const auto sampler = Registry<SamplerKind>::Find(name)({params, Int2(512, 512), 64, 0});
    float sum = 0;
    int index = 0;
    for (auto _ : state) {
        (void)_;
        sampler->StartPixelSample({index / 64 % 512, 7}, index % 64);
        ++index;
        for (int d = 0; d < 16; ++d) {
            const Point2 u = sampler->Get2D();
            sum += sampler->Get1D() + u.x + u.y;
        }
    }
    benchmark::DoNotOptimize(sum);
    state.SetItemsProcessed(state.iterations() * 32);
}
BENCHMARK_CAPTURE(SamplerGet, independent, "independent");
BENCHMARK_CAPTURE(SamplerGet, stratified, "stratified");
BENCHMARK_CAPTURE(SamplerGet, halton, "halton");
BENCHMARK_CAPTURE(SamplerGet, sobol, "sobol");
BENCHMARK_CAPTURE(SamplerGet, paddedsobol, "paddedsobol");
BENCHMARK_CAPTURE(SamplerGet, zsobol, "zsobol");

void SampleWavelengths(benchmark::State& state) {
    Rng rng(1);
    for (auto _ : state) {
        (void)_;
        benchmark::DoNotOptimize(SampledWavelengths::SampleVisible(rng.Uniform()));
    }
}
BENCHMARK(SampleWavelengths);

void SampleRGBTexel(benchmark::State& state) {
    Rng rng(1);
    const SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.3f);
    for (auto _ : state) {
        (void)_;
        const RGB rgb(rng.Uniform(), rng.Uniform(), rng.Uniform());
        benchmark::DoNotOptimize(SampleRGB(ColorSpace::SRGB(), rgb, SpectrumKind::Albedo, lambda));
    }
}
BENCHMARK(SampleRGBTexel);

// Evaluate() of a rough boundary, without a film on it and with one.
template <class Boundary>
void EvaluateBoundary(benchmark::State& state, const Boundary& boundary) {
    Rng rng(1);
    std::vector<std::pair<Vec3, Vec3>> pairs(1024);
    for (auto& [wo, wi] : pairs) {
        wo = SampleCosineHemisphere(rng.Uniform2D());
        const auto sample = boundary.Sample(wo, {rng.Uniform(), rng.Uniform2D()}, {.rng = &rng});
        wi = sample ? sample->wi : wo;
    }
    size_t i = 0;
    for (auto _ : state) {
        (void)_;
        const auto& [wo, wi] = pairs[i++ % pairs.size()];
        benchmark::DoNotOptimize(boundary.Evaluate(wo, wi, {.rng = &rng}));
    }
}
const Alphas kRough(0.2f, 0.2f);
const SampledSpectrum kMetalEta(0.25f), kMetalK(3.5f);
/// Of a clear film, and of one that absorbs.
ThinFilm FilmOf(float k) {
    return {400, SampledSpectrum(1.33f), SampledSpectrum(k), SampledWavelengths::SampleVisible(0.3f).Lambda(),
            1};
}
BENCHMARK_CAPTURE(EvaluateBoundary, glass, DielectricBxDF<TrowbridgeReitz>(kRough, 1.5f));
BENCHMARK_CAPTURE(EvaluateBoundary, glass_film,
                  FilmedDielectricBxDF<TrowbridgeReitz>(kRough, FilmedDielectric(1.5f, FilmOf(0))));
BENCHMARK_CAPTURE(EvaluateBoundary, glass_absorbing_film,
                  FilmedDielectricBxDF<TrowbridgeReitz>(kRough, FilmedDielectric(1.5f, FilmOf(0.1f))));
BENCHMARK_CAPTURE(EvaluateBoundary, metal, ConductorBxDF<TrowbridgeReitz>(kRough, kMetalEta, kMetalK));
BENCHMARK_CAPTURE(EvaluateBoundary, metal_film,
                  FilmedConductorBxDF<TrowbridgeReitz>(kRough, FilmedMetal(kMetalEta, kMetalK, FilmOf(0))));
BENCHMARK_CAPTURE(EvaluateBoundary, metal_absorbing_film,
                  FilmedConductorBxDF<TrowbridgeReitz>(kRough,
                                                       FilmedMetal(kMetalEta, kMetalK, FilmOf(0.1f))));

}  // namespace
}  // namespace lacquer

BENCHMARK_MAIN();
