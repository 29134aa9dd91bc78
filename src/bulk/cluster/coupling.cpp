#include "bulk/cluster/coupling.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bulk/cluster/pair_product.h"
#include "bulk/cluster/pair_tables.h"
#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::bulk {
namespace {

/// Reads a number of each cache line. Products jump about in their tables, which are too many for caches, and
/// mostly wait for them; read from end to end first, they come at the speed of the memory. Prefetch
/// instructions are no substitute: they gain nothing.
void ReadThrough(const double* values, size_t count) {
    constexpr size_t kLine = 8;
    for (size_t i = 0; i < count; i += kLine) (void)*static_cast<const volatile double*>(values + i);
}

}  // namespace

void HelicityWaves::Set(int origin, const Eigen::MatrixX2cd& coefficients) {
    LACQUER_CHECK(coefficients.rows() == 2 * numHarmonics_);
    Lanes* waves = Of(origin);
    for (int i = 0; i < numHarmonics_; ++i)
        for (int column = 0; column < 2; ++column) {
            const Complex magnetic = coefficients(i, column),
                          electric = coefficients(numHarmonics_ + i, column);
            const Complex u = (magnetic + electric) * std::sqrt(0.5),
                          v = (magnetic - electric) * std::sqrt(0.5);
            waves[i][column] = u.real();
            waves[i][2 + column] = v.real();
            waves[i][4 + column] = u.imag();
            waves[i][6 + column] = v.imag();
        }
}

Eigen::MatrixX2cd HelicityWaves::Get(int origin) const {
    Eigen::MatrixX2cd coefficients(2 * numHarmonics_, 2);
    const Lanes* waves = Of(origin);
    for (int i = 0; i < numHarmonics_; ++i)
        for (int column = 0; column < 2; ++column) {
            const Complex u(waves[i][column], waves[i][4 + column]),
                v(waves[i][2 + column], waves[i][6 + column]);
            coefficients(i, column) = (u + v) * std::sqrt(0.5);
            coefficients(numHarmonics_ + i, column) = (u - v) * std::sqrt(0.5);
        }
    return coefficients;
}

Coupling::Coupling(std::span<const Point> centers, int degree, size_t memory)
    : centers_(centers.begin(), centers.end()), degree_(degree) {
    for (int i = 0; i < NumCenters(); ++i)
        for (int j = i + 1; j < NumCenters(); ++j) pairs_.push_back({i, j});
    const size_t batchBytes = TableSize(degree) * kNumLanes * sizeof(double);
    const int64_t numBatches = (int64_t(pairs_.size()) + kNumLanes - 1) / kNumLanes;
    numKeptBatches_ = std::min(numBatches, int64_t(memory / batchBytes));
    kept_.resize(size_t(numKeptBatches_) * batchBytes / sizeof(double));
    ParallelFor(kNumSlices, [&](int64_t slice) {
        PairTableMaker maker{PairTableLayout(degree_)};
        for (int64_t batch = slice; batch < numKeptBatches_; batch += kNumSlices)
            MakeTables(batch, &maker, &kept_[size_t(batch) * batchBytes / sizeof(double)]);
    });
}

size_t Coupling::TableSize(int degree) { return PairTableLayout(degree).Size(); }

double Coupling::NumOperations() const {
    const double L = degree_;
    // Of a pair: two rotations by half matrices and two complex shifts for each order, 16 lanes each.
    const double rotations = 2 * 2 * 16 * (2 * L * (L + 1) * (2 * L + 1) / 6 + L * L + 2 * L);
    const double shifts = 64 * (L * L + 2 * L * (L + 1) * (2 * L + 1) / 6);
    return double(NumPairs()) * (rotations + shifts);
}

void Coupling::MakeTables(int64_t batch, PairTableMaker* maker, double* tables) const {
    Point displacements[kNumLanes];
    for (int64_t lane = 0; lane < kNumLanes; ++lane) {
        // The last batch is filled up with its last pair.
        const Pair& pair = pairs_[size_t(std::min(batch * kNumLanes + lane, int64_t(pairs_.size()) - 1))];
        displacements[lane] = centers_[size_t(pair.to)] - centers_[size_t(pair.from)];
    }
    maker->Make(displacements, tables);
}

void Coupling::ApplySlice(int64_t slice, const HelicityWaves& in, HelicityWaves* out) const {
    const PairTableLayout layout(degree_);
    PairProduct product(layout);
    std::optional<PairTableMaker> maker;  // only where some tables are not kept
    std::vector<double> made;
    const size_t batchSize = layout.Size() * kNumLanes;
    // Neighbouring pairs share the sphere with the smaller index: slices of neighbours.
    const int64_t numBatches = (int64_t(pairs_.size()) + kNumLanes - 1) / kNumLanes;
    const int64_t first = numBatches * slice / kNumSlices, last = numBatches * (slice + 1) / kNumSlices;
    for (int64_t batch = first; batch < last; ++batch) {
        const double* tables;
        if (batch < numKeptBatches_) {
            tables = kept_.data() + size_t(batch) * batchSize;
        } else {
            if (!maker) maker.emplace(layout);
            made.resize(batchSize);
            MakeTables(batch, &*maker, made.data());
            tables = made.data();
        }
        const int64_t end = std::min((batch + 1) * kNumLanes, int64_t(pairs_.size()));
        for (int64_t p = batch * kNumLanes; p < end; ++p) {
            const Pair& pair = pairs_[size_t(p)];
            const double* table = tables + size_t(p - batch * kNumLanes) * layout.Size();
            ReadThrough(table, layout.Size());
            product.Apply(table, in.Of(pair.from), in.Of(pair.to), out->Of(pair.to), out->Of(pair.from));
        }
    }
}

void Coupling::Apply(const HelicityWaves& in, HelicityWaves* out) const {
    std::vector<HelicityWaves> sums(size_t(kNumSlices), HelicityWaves(NumCenters(), degree_));
    ParallelFor(kNumSlices, [&](int64_t slice) { ApplySlice(slice, in, &sums[size_t(slice)]); });
    *out = std::move(sums[0]);
    for (size_t slice = 1; slice < sums.size(); ++slice)
        for (size_t i = 0; i < out->Size(); ++i) out->Data()[i] += sums[slice].Data()[i];
}

}  // namespace lacquer::bulk
