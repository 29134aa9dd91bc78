/// Bakes the tables of dielectric coats over diffuse bases; the build runs it once.
///
///     bake_coat_tables <output file>
///
/// Writes the file that layered/lambertian/coat_grid.h describes, first under a temporary name. The numbers
/// do not depend on how many threads there are. Exit status: 0 success, 1 wrong usage, 3 the file cannot be
/// written.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "layered/lambertian/coat_grid.h"
#include "layered/lambertian/coat_quadrature.h"

namespace lacquer::layered {
namespace {

namespace fs = std::filesystem;
using Grid = layered::CoatGrid;

constexpr int kExitUsage = 1;
constexpr int kExitFile = 3;

/// Grazing light stands for that along the surface, where some paths have no mean.
constexpr double kMinCos = 1e-8;

/// Node k of n along an axis.
double Coordinate(int k, int n) { return double(k) / (n - 1); }
double CosNode(int k, int n) { return std::max(kMinCos, Grid::CosAt(Coordinate(k, n))); }

/// m of all nodes from the attenuated values: those of node 0 are not attenuated and have the mean instead.
void WritePaths(std::span<const double> taus, std::span<const double> values, double meanPath, float* out) {
    out[0] = float(meanPath);
    for (size_t k = 1; k < taus.size(); ++k) out[k] = float(std::log(values[0] / values[k]) / taus[k]);
}

template <int kCount>
std::array<double, kCount> TauNodes(double (*tauAt)(double)) {
    std::array<double, kCount> taus;
    for (int k = 0; k < kCount; ++k) taus[size_t(k)] = tauAt(Coordinate(k, kCount));
    return taus;
}

/// All that depends on one alpha: the rows of the three tables of a model.
void BakeAlpha(MicrofacetModel model, int row, float* tables) {
    const auto entryTaus = TauNodes<Grid::kEntryPaths>(Grid::EntryTauAt);
    const auto returnTaus = TauNodes<Grid::kReturnPaths>(Grid::ReturnTauAt);
    std::array<double, Grid::kEntryPaths> entered;
    std::array<double, Grid::kReturnPaths> returned;
    for (int j = 0; j < Grid::kEta; ++j) {
        const layered::CoatSurface surface{model, Grid::AlphaAt(Coordinate(row, Grid::kAlpha)),
                                           Grid::EtaAt(Coordinate(j, Grid::kEta))};
        const int at = row * Grid::kEta + j;
        for (int k = 0; k < Grid::kCos; ++k) {
            const layered::CoatEntry entry =
                layered::IntegrateEntry(surface, CosNode(k, Grid::kCos), entryTaus, entered);
            float* out = tables + size_t(at * Grid::kCos + k) * Grid::kEntryChannels;
            out[0] = float(entered[0]);
            WritePaths(entryTaus, entered, entry.meanPath, out + 1);
            float* density = tables + Grid::kEntryFloats + Grid::kReturnFloats +
                             size_t(at * Grid::kDensityChannels * Grid::kCos + k);
            density[0] = float(entry.probabilityIn);
            density[Grid::kCos] = float(entry.densityOut);
        }
        const layered::CoatReturn back = layered::IntegrateReturn(surface, returnTaus, returned);
        float* out = tables + Grid::kEntryFloats + size_t(at) * Grid::kReturnChannels;
        out[0] = float(returned[0]);
        WritePaths(returnTaus, returned, back.meanPath, out + 1);
        out[Grid::kReturnChannels - 1] = float(back.probabilityBack);
    }
}

std::vector<float> Bake() {
    std::vector<float> tables(Grid::kModels * Grid::kModelFloats);
    // Each row is a task of its own: who computes it does not matter.
    std::atomic<int> next = 0;
    const auto work = [&] {
        for (int task; (task = next++) < Grid::kModels * Grid::kAlpha;) {
            const int model = task / Grid::kAlpha;
            BakeAlpha(model == 0 ? MicrofacetModel::TrowbridgeReitz : MicrofacetModel::Beckmann,
                      task % Grid::kAlpha, tables.data() + size_t(model) * Grid::kModelFloats);
        }
    };
    std::vector<std::thread> threads;
    for (unsigned i = 1; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
        threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
    return tables;
}

/// Writes little-endian floats, under a temporary name until they are complete.
void WriteFile(const fs::path& path, std::span<const float> values) {
    std::vector<char> bytes;
    bytes.reserve(values.size() * sizeof(float));
    for (const float value : values) {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        for (int shift = 0; shift < 32; shift += 8) bytes.push_back(char((bits >> shift) & 0xffu));
    }
    const fs::path temporary = path.string() + ".part";
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), std::streamsize(bytes.size()));
    out.close();
    std::error_code error;
    if (out) fs::rename(temporary, path, error);
    if (!out || error) throw std::runtime_error(path.string() + ": cannot be written");
}

void Run(const fs::path& output) {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<float> tables = Bake();
    if (!std::all_of(tables.begin(), tables.end(), [](float x) { return std::isfinite(x); }))
        throw std::runtime_error("a coat has values that are not finite");
    WriteFile(output, tables);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::fprintf(stderr, "coat tables: %.1f s, %.1f MB\n", seconds.count(), double(tables.size()) * 4e-6);
}

}  // namespace
}  // namespace lacquer::layered

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("usage: bake_coat_tables <output file>\n", stderr);
        return lacquer::layered::kExitUsage;
    }
    try {
        lacquer::layered::Run(argv[1]);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "bake_coat_tables: %s\n", e.what());
        return lacquer::layered::kExitFile;
    }
    return 0;
}
