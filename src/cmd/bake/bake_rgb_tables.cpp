/// Bakes the tables that turn RGB colours into spectra; the build runs it once.
///
///     bake_rgb_tables <data directory> <output file>
///
/// Reads observer/cie1931.txt (rows: nm x y z), illuminants/stdillum-D65.txt and
/// illuminants/illum-acesD60.txt (rows: nm value) below the data directory; '#' starts a comment. Writes the
/// file that pbrt/core/sigmoid_fit.h describes, first under a temporary name. Exit status: 0 success, 1 wrong
/// usage, 3 a file cannot be read or written.

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pbrt/core/sigmoid_fit.h"

namespace lacquer {
namespace {

namespace fs = std::filesystem;

constexpr int kExitUsage = 1;
constexpr int kExitFile = 3;

/// Colours are sums over these wavelengths, 1 nm apart, as in the renderer.
constexpr int kFirstNm = 360;
constexpr int kLastNm = 830;

/// A file cannot be read, understood or written; the message names it.
class BakeError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Columns of numbers: rows[i][0] is the wavelength [nm], ascending.
using Rows = std::vector<std::vector<double>>;

struct ColourSpaceSpec {
    const char* name;
    std::array<std::array<double, 2>, 3> primaries;  // xy of R, G, B
    const char* illuminant;                          // file name without extension
};

/// In the order of the output file.
constexpr std::array<ColourSpaceSpec, 4> kColourSpaces = {{
    // IEC 61966-2-1
    {"sRGB", {{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}}}, "stdillum-D65"},
    // SMPTE EG 432-1, with the white of the display variant
    {"DCI-P3", {{{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}}}, "stdillum-D65"},
    // ITU-R BT.2020
    {"Rec2020", {{{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}}}, "stdillum-D65"},
    // SMPTE ST 2065-1
    {"ACES2065-1", {{{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.077}}}, "illum-acesD60"},
}};

/// Reads rows of `numColumns` numbers.   Errors: BakeError with file and line.
Rows ReadRows(const fs::path& path, std::size_t numColumns) {
    std::ifstream in(path);
    if (!in) throw BakeError(path.string() + ": cannot be opened");
    Rows rows;
    std::string line;
    for (int lineNumber = 1; std::getline(in, line); ++lineNumber) {
        // Take what stands before a comment.
        std::istringstream text(line.substr(0, line.find('#')));
        std::vector<double> row;
        for (double value = 0; text >> value;) row.push_back(value);
        if (row.empty() && text.eof()) continue;

        const std::string where = path.string() + ":" + std::to_string(lineNumber) + ": ";
        if (row.size() != numColumns || !text.eof())
            throw BakeError(where + "expected " + std::to_string(numColumns) + " numbers");
        if (!rows.empty() && row[0] <= rows.back()[0]) throw BakeError(where + "wavelengths must ascend");
        rows.push_back(std::move(row));
    }
    if (in.bad()) throw BakeError(path.string() + ": cannot be read");
    if (rows.empty()) throw BakeError(path.string() + ": holds no data");
    return rows;
}

/// Value of one column at a wavelength [nm]: linear between rows, constant beyond the first and the last.
double Interpolate(const Rows& rows, std::size_t column, double nm) {
    const auto upper = std::lower_bound(rows.begin(), rows.end(), nm,
                                        [](const std::vector<double>& row, double x) { return row[0] < x; });
    if (upper == rows.begin()) return rows.front()[column];
    if (upper == rows.end()) return rows.back()[column];
    const std::vector<double>&a = *(upper - 1), &b = *upper;
    const double t = (nm - a[0]) / (b[0] - a[0]);
    return a[column] + t * (b[column] - a[column]);
}

/// Observer and wavelengths at 1 nm.
struct Observer {
    std::vector<double> nm;
    std::vector<FitVec3> xyz;
};

Observer ReadObserver(const fs::path& path) {
    const Rows rows = ReadRows(path, 4);
    Observer observer;
    for (int nm = kFirstNm; nm <= kLastNm; ++nm) {
        observer.nm.push_back(nm);
        observer.xyz.push_back(
            {Interpolate(rows, 1, nm), Interpolate(rows, 2, nm), Interpolate(rows, 3, nm)});
    }
    return observer;
}

/// Chromaticity xy of an illuminant given at the observer's wavelengths.
std::array<double, 2> Chromaticity(const Observer& observer, std::span<const double> illuminant) {
    FitVec3 sum{};
    for (std::size_t i = 0; i < illuminant.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) sum[c] += observer.xyz[i][c] * illuminant[i];
    const double total = sum[0] + sum[1] + sum[2];
    return {sum[0] / total, sum[1] / total};
}

SigmoidTable Bake(const ColourSpaceSpec& space, const Observer& observer, const fs::path& dataDir) {
    const Rows rows = ReadRows(dataDir / "illuminants" / (std::string(space.illuminant) + ".txt"), 2);
    std::vector<double> illuminant;
    for (const double nm : observer.nm) illuminant.push_back(Interpolate(rows, 1, nm));
    const SigmoidFitProblem problem = {observer.nm, observer.xyz, illuminant,
                                       XyzFromRgbMatrix(space.primaries, Chromaticity(observer, illuminant))};
    const unsigned numCores = std::thread::hardware_concurrency();
    return FitSigmoidTable(problem, std::max(1, static_cast<int>(numCores)));
}

/// Appends 32-bit floats in little-endian order, whatever the machine's.
void AppendFloats(std::span<const float> values, std::vector<char>* bytes) {
    for (const float value : values) {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        for (int shift = 0; shift < 32; shift += 8)
            bytes->push_back(static_cast<char>((bits >> shift) & 0xffu));
    }
}

/// Writes under a temporary name and renames, so that an interrupted build leaves no half file.
void WriteFile(const fs::path& path, std::span<const char> bytes) {
    const fs::path temporary = path.string() + ".part";
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    std::error_code error;
    if (out) fs::rename(temporary, path, error);
    if (!out || error) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw BakeError(path.string() + ": cannot be written");
    }
}

void Run(const fs::path& dataDir, const fs::path& output) {
    const auto start = std::chrono::steady_clock::now();
    const Observer observer = ReadObserver(dataDir / "observer" / "cie1931.txt");
    std::vector<char> bytes;
    bytes.reserve(kColourSpaces.size() * (kSigmoidTableRes + kSigmoidTableSize) * sizeof(float));
    std::string report;
    for (const ColourSpaceSpec& space : kColourSpaces) {
        const SigmoidTable table = Bake(space, observer, dataDir);
        AppendFloats(table.zNodes, &bytes);
        AppendFloats(table.coefficients, &bytes);
        std::array<char, 160> text{};
        std::snprintf(text.data(), text.size(), "; %s %.2g (%d nodes above %.1g)", space.name,
                      table.maxResidual, table.numUnreached, kSigmoidResidualReached);
        report += text.data();
    }
    WriteFile(output, bytes);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::fprintf(stderr, "RGB tables: %.1f s; largest CIELAB residuals%s\n", seconds.count(), report.c_str());
}

}  // namespace
}  // namespace lacquer

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fputs("usage: bake_rgb_tables <data directory> <output file>\n", stderr);
        return lacquer::kExitUsage;
    }
    try {
        lacquer::Run(argv[1], argv[2]);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "bake_rgb_tables: %s\n", e.what());
        return lacquer::kExitFile;
    }
    return 0;
}
