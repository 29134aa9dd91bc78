// Products of the linear system of bulk scattering, beside what the machine's arithmetic and memory could do.
#include <benchmark/benchmark.h>

#include "bulk/cluster/coupling.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::bulk {
namespace {

using benchmark::Counter;

void SetRate(benchmark::State& state, const char* name, double perIteration) {
    state.counters[name] = Counter(perIteration * 1e-9, Counter::kIsIterationInvariantRate);
}

// Multiplications and additions of eight numbers that stay in registers, enough of them at once to hide their
// latency: the peak.
void MultiplyAdd(benchmark::State& state) {
    constexpr int kChains = 12, kSteps = 1000;
    Lanes sums[kChains];
    for (int i = 0; i < kChains; ++i) sums[i] = Lanes{} + i;
    Lanes factor = Lanes{} + 0.999, term = Lanes{} + 0.001;
    benchmark::DoNotOptimize(factor);
    benchmark::DoNotOptimize(term);
    for (auto _ : state) {
        (void)_;
        for (int step = 0; step < kSteps; ++step)
            for (Lanes& sum : sums) sum = sum * factor + term;
        benchmark::DoNotOptimize(sums);
    }
    SetRate(state, "Gflop/s", 2. * kNumLanes * kChains * kSteps);
}
BENCHMARK(MultiplyAdd);

// Reads more than caches hold, as products read their tables.
void ReadMemory(benchmark::State& state) {
    const std::vector<Lanes> values(size_t(256) << 20 >> 6, Lanes{} + 1);
    for (auto _ : state) {
        (void)_;
        Lanes sums[4] = {};
        for (size_t i = 0; i + 4 <= values.size(); i += 4)
            for (size_t k = 0; k < 4; ++k) sums[k] += values[i + k];
        benchmark::DoNotOptimize(sums);
    }
    SetRate(state, "GB/s", double(values.size() * sizeof(Lanes)));
}
BENCHMARK(ReadMemory)->Unit(benchmark::kMillisecond);

/// @param state  ranges: degree, spheres on an edge of a cube
void Product(benchmark::State& state) {
    const ThreadLimit oneThread(1);
    const int degree = int(state.range(0)), edge = int(state.range(1));
    std::vector<Point> centers;
    for (int i = 0; i < edge * edge * edge; ++i)
        centers.push_back((degree + 1.) *
                          Eigen::Vector3i(i % edge, i / edge % edge, i / (edge * edge)).cast<double>());
    const Coupling coupling(centers, degree, size_t(4) << 30);
    HelicityWaves in(int(centers.size()), degree), out = in;
    Rng rng(1);
    for (size_t i = 0; i < in.Size(); ++i)
        for (int lane = 0; lane < kNumLanes; ++lane) in.Data()[i][lane] = double(rng.Uniform()) - 0.5;
    for (auto _ : state) {
        (void)_;
        coupling.Apply(in, &out);
        benchmark::DoNotOptimize(out.Data());
    }
    SetRate(state, "Gflop/s", coupling.NumOperations());
    SetRate(state, "GB/s",
            double(coupling.NumPairs()) * double(Coupling::TableSize(degree) * sizeof(double)));
}
// Two pairs of ranges for each degree: tables in a cache, and in memory.
BENCHMARK(Product)
    ->Unit(benchmark::kMicrosecond)
    ->ArgNames({"degree", "edge"})
    ->ArgsProduct({{4, 8, 13, 20}, {2, 4}});

}  // namespace
}  // namespace lacquer::bulk

BENCHMARK_MAIN();
