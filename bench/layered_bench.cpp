// Time, noise, and time times noise of one evaluation, for the estimators and densities of layered materials.
//
// usage: layered_bench [--seconds S] [--estimators A,B,...] [STACK...]
// Prints one line for each stack and estimator:
//   ns        CPU time of one evaluation, one thread
//   noise     relative variance of one evaluation of f, the geometric mean over pairs of directions: half of
//             them drawn from the material (where its lobes are), half independent and cosine-weighted
//   ns*noise  what a rendering pays for a given quality; the smaller the better
//   heap      allocations in all timed evaluations; any makes the exit status 1
// and one for each density. The figures of one run may be compared with each other; directions and random
// numbers are the same in every run.
#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <sstream>

#include "cpu_time.h"
#include "layered/stack_cases.h"
#include "pbrt/core/sampling.h"

namespace {

std::atomic<long> allocations{0};

}  // namespace

// Every allocation of the program is counted.
void* operator new(size_t size) {
    ++allocations;
    if (void* memory = std::malloc(size)) return memory;
    throw std::bad_alloc();
}
void* operator new(size_t size, std::align_val_t alignment) {
    ++allocations;
    const auto unit = size_t(alignment);
    if (void* memory = std::aligned_alloc(unit, (size + unit - 1) / unit * unit)) return memory;
    throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, size_t, std::align_val_t) noexcept { std::free(memory); }

namespace lacquer {
namespace {

using namespace layered::test;
using bench::CpuSeconds;

/// The configurations whose cost is watched: a rough coat over rough metal, clear and with a medium of
/// optical thickness 1 and 20; a diffuse base; a sheet; three interfaces.
std::vector<StackCase> BenchStacks() {
    const SampledSpectrum albedo = Lanes(0.5f, 0.7f, 0.95f, 0.95f);
    const auto coat = [](float alpha, MicrofacetModel model) { return Dielectric(alpha, 1.5f, model); };
    const auto medium = [&](float thickness) { return Medium(SampledSpectrum(thickness), albedo, HG(0.5f)); };
    std::vector<StackCase> rows;
    const auto add = [&](const char* name, std::vector<Layer> layers) {
        StackCase row;
        row.name = name;
        row.layers = std::move(layers);
        rows.push_back(std::move(row));
    };
    add("clear_beckmann", {coat(0.3f, kBeckmann), Metal(0.1f, kBeckmann)});
    add("clear_ggx", {coat(0.3f, kGGX), Metal(0.1f)});
    add("medium_1_beckmann", {coat(0.05f, kBeckmann), medium(1), Metal(0.05f, kBeckmann)});
    add("medium_1_ggx", {coat(0.05f, kGGX), medium(1), Metal(0.05f)});
    add("medium_1_rougher", {coat(0.3f, kBeckmann), medium(1), Metal(0.1f, kBeckmann)});
    add("medium_20_beckmann", {coat(0.05f, kBeckmann), medium(20), Metal(0.05f, kBeckmann)});
    add("medium_20_ggx", {coat(0.3f, kGGX), medium(20), Metal(0.1f)});
    add("medium_20_white", {coat(0.3f, kGGX), Medium(20, 1, HG(0.5f)), Diffuse(1)});
    add("diffuse_base", {coat(0.3f, kGGX), Diffuse(0.5f)});
    add("sheet", {coat(0.3f, kGGX), medium(1), Dielectric(0.2f, 1 / 1.5f)});
    add("three_interfaces", {coat(0.2f, kGGX), Dielectric(0.1f, 1.2f), medium(1), Metal(0.2f)});
    return rows;
}

struct DirectionPair {
    Vec3 wo, wi;
};

std::vector<DirectionPair> DirectionsFor(const layered::LayeredBxDF& bxdf) {
    constexpr size_t kPairs = 32;
    std::vector<DirectionPair> pairs;
    Rng rng(Hash(7));
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
    while (pairs.size() < kPairs) {
        const Vec3 wo = SampleCosineHemisphere(rng.Uniform2D());
        Vec3 wi = SampleCosineHemisphere(rng.Uniform2D());
        if (pairs.size() % 2) {
            const float lobe = rng.Uniform();
            const auto sample = bxdf.Sample(wo, {lobe, rng.Uniform2D()}, context);
            if (!sample || sample->IsSpecular()) continue;
            wi = sample->wi;
        }
        pairs.push_back({wo, wi});
    }
    return pairs;
}

struct Cost {
    double seconds = 0;  ///< of one evaluation
    double noise = 0;    ///< relative variance
    long heap = 0;
};

/// @param evaluate  (pair, context) -> one estimate
template <class Evaluate>
Cost Measure(const std::vector<DirectionPair>& pairs, double seconds, const Evaluate& evaluate) {
    Cost cost;
    double logNoise = 0;
    int noisy = 0;
    for (size_t i = 0; i < pairs.size(); ++i) {
        Rng rng(Hash(i));
        const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
        // Tables that are read at their first use are no part of an evaluation.
        if (i == 0) evaluate(pairs[i], context);
        double sum = 0, squares = 0;
        int64_t n = 0;
        const long heapBefore = allocations;
        const double start = CpuSeconds();
        double now = start;
        while (now - start < seconds / double(pairs.size())) {
            for (int k = 0; k < 256; ++k, ++n) {
                const double x = evaluate(pairs[i], context);
                sum += x;
                squares += x * x;
            }
            now = CpuSeconds();
        }
        cost.seconds += (now - start) / double(n) / double(pairs.size());
        cost.heap += allocations - heapBefore;
        const double mean = sum / double(n), variance = squares / double(n) - mean * mean;
        if (mean > 0 && variance > 1e-9 * mean * mean) {
            logNoise += std::log(variance / (mean * mean));
            ++noisy;
        }
    }
    cost.noise = noisy > 0 ? std::exp(logNoise / noisy) : 0;
    return cost;
}

bool anyHeap = false;

void Print(const std::string& stack, const std::string& what, const Cost& cost) {
    anyHeap |= cost.heap > 0;
    fmt::print("{:<20} {:<16} {:>9.0f} {:>10.3f} {:>12.0f} {:>6}\n", stack, what, cost.seconds * 1e9,
               cost.noise, cost.seconds * 1e9 * cost.noise, cost.heap);
    std::fflush(stdout);
}

void Run(const StackCase& row, const std::vector<std::string>& estimators, double seconds) {
    Arena arena;
    layered::LayeredOptions options;
    options.estimator = FindEstimator("bidirectional");
    options.pdf = FindPdf("approximate");
    const layered::LayeredBxDF& bxdf = *row.MakeBxDF(arena, options);
    const layered::Stack& stack = bxdf.GetStack();
    const std::vector<DirectionPair> pairs = DirectionsFor(bxdf);
    for (const std::string& name : estimators) {
        const layered::LayeredEstimator* estimator = FindEstimator(name);
        Print(
            row.name, name, Measure(pairs, seconds, [&](const DirectionPair& p, const BxDFContext& c) {
                return double(estimator->Evaluate(stack, p.wo, p.wi, c, layered::kMaxPathVertices).Average());
            }));
    }
    for (const std::string& name : Registry<layered::LayeredPdfKind>::Names()) {
        const layered::LayeredPdf* pdf = FindPdf(name);
        Print(row.name, "pdf " + name,
              Measure(pairs, seconds, [&](const DirectionPair& p, const BxDFContext& c) {
                  return double(pdf->Evaluate(stack, p.wo, p.wi, c, layered::kMaxPathVertices));
              }));
    }
    Print(row.name, "Sample", Measure(pairs, seconds, [&](const DirectionPair& p, const BxDFContext& c) {
              const float lobe = c.rng->Uniform();
              const auto sample = bxdf.Sample(p.wo, {lobe, c.rng->Uniform2D()}, c);
              return sample ? double(sample->weight.Average()) : 0;
          }));
}

int Main(int argc, char** argv) {
    double seconds = 0.5;
    std::vector<std::string> estimators = Registry<layered::LayeredEstimatorKind>::Names(), stacks;
    std::erase(estimators, "auto");
    for (int i = 1; i < argc; ++i) {
        if (!std::strcmp(argv[i], "--seconds") && i + 1 < argc) {
            seconds = std::atof(argv[++i]);
        } else if (!std::strcmp(argv[i], "--estimators") && i + 1 < argc) {
            estimators.clear();
            std::istringstream list(argv[++i]);
            for (std::string name; std::getline(list, name, ',');) estimators.push_back(name);
        } else {
            stacks.emplace_back(argv[i]);
        }
    }
    for (const std::string& name : estimators)
        if (!Registry<layered::LayeredEstimatorKind>::Find(name)) {
            fmt::print(stderr, "layered_bench: no estimator \"{}\"\n", name);
            return 1;
        }
    fmt::print("{:<20} {:<16} {:>9} {:>10} {:>12} {:>6}\n", "stack", "estimator", "ns", "noise", "ns*noise",
               "heap");
    for (const StackCase& row : BenchStacks())
        if (stacks.empty() || std::find(stacks.begin(), stacks.end(), row.name) != stacks.end())
            Run(row, estimators, seconds);
    return anyHeap ? 1 : 0;
}

}  // namespace
}  // namespace lacquer

int main(int argc, char** argv) { return lacquer::Main(argc, argv); }
