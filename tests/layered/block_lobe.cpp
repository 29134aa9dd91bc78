#include "layered/block_lobe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "pbrt/core/math.h"

namespace lacquer::layered::test {

namespace {

constexpr double kArea = 4. / BlockLobe::kBlocks;  // of a block

int Column(float u) {
    return std::clamp(int((u + 1) / 2 * float(BlockLobe::kSide)), 0, BlockLobe::kSide - 1);
}

}  // namespace

double BlockLobe::Integral(int c) const {
    double sum = 0;
    for (const Channels& m : means) sum += m[size_t(c)];
    return sum * kArea;
}
double BlockLobe::IntegralError(int c) const {
    double sum = 0;
    for (const Channels& v : variances) sum += v[size_t(c)];
    return std::sqrt(sum) * kArea;
}

void BlockLobeSums::Add(Vec3 wi, SampledSpectrum value) {
    ++count_;
    // A block's mean is an integral over the disk: dA = |cos theta_i| d(solid angle).
    const double toMean = double(std::abs(wi.z)) / kArea;
    const auto block = size_t(Column(-wi.y) * BlockLobe::kSide + Column(wi.x));
    for (size_t c = 0; c < BlockLobe::kChannels; ++c) {
        const double v = double(value[int(c)]) * toMean;
        sums_[block][c] += v;
        squares_[block][c] += v * v;
    }
}

void BlockLobeSums::Merge(const BlockLobeSums& other) {
    count_ += other.count_;
    for (size_t b = 0; b < sums_.size(); ++b)
        for (size_t c = 0; c < BlockLobe::kChannels; ++c) {
            sums_[b][c] += other.sums_[b][c];
            squares_[b][c] += other.squares_[b][c];
        }
}

BlockLobe BlockLobeSums::Lobe() const {
    BlockLobe lobe;
    for (size_t b = 0; b < sums_.size(); ++b)
        for (size_t c = 0; c < BlockLobe::kChannels; ++c) {
            const double mean = sums_[b][c] / count_;
            lobe.means[b][c] = mean;
            lobe.variances[b][c] = std::max(0., squares_[b][c] / count_ - Sqr(mean)) / count_;
        }
    return lobe;
}

void WriteLobe(const std::string& file, const BlockLobe& lobe, const std::string& comment) {
    std::ofstream out(file);
    out << comment;
    for (size_t b = 0; b < lobe.means.size(); ++b) {
        for (const double mean : lobe.means[b]) out << fmt::format("{:.5g} ", mean);
        for (const double variance : lobe.variances[b]) out << fmt::format(" {:.2g}", std::sqrt(variance));
        out << '\n';
    }
    if (!out.flush()) throw std::runtime_error(file + " cannot be written");
}

BlockLobe ReadLobe(const std::string& file) {
    std::ifstream in(file);
    BlockLobe lobe;
    size_t block = 0;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with('#')) continue;
        if (block == lobe.means.size()) throw std::runtime_error(file + " has too many lines");
        std::istringstream numbers(line);
        for (double& mean : lobe.means[block]) numbers >> mean;
        for (double& variance : lobe.variances[block])
            if (numbers >> variance) variance *= variance;
        if (!numbers) throw std::runtime_error(file + ": six numbers expected: " + line);
        ++block;
    }
    if (block != lobe.means.size()) throw std::runtime_error(file + " is missing or too short");
    return lobe;
}

}  // namespace lacquer::layered::test
