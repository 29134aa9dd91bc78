#include "estimate/models/cells.h"

#include <algorithm>
#include <cmath>

#include "estimate/models/streams.h"
#include "pbrt/core/check.h"

namespace lacquer::estimate {
namespace {

int Wrap(int i, int period) {
    if (i < 0) return i + period;
    return i >= period ? i - period : i;
}

}  // namespace

double Cells::StretchX(CellKind kind) { return kind == CellKind::Stretched ? 1 / std::sqrt(1.6) : 1; }

Cells::Cells(CellKind kind, int periodX, int periodY) : kind_(kind), periodX_(periodX), periodY_(periodY) {
    LACQUER_CHECK(std::min(periodX, periodY) >= 5);
}

void Cells::SetSeed(uint64_t stream) {
    const size_t buckets = size_t(periodX_) * size_t(periodY_);
    sites_.clear();
    firstSite_.resize(buckets + 1);
    if (kind_ == CellKind::PoissonDisc) {
        PlacePoissonDisc(stream);
        return;
    }
    Rng rng(stream);
    for (size_t i = 0; i < buckets; ++i) {
        firstSite_[i] = int(i);
        const float x = 0.9f * rng.Uniform(), y = 0.9f * rng.Uniform();
        sites_.push_back({x, y});
    }
    firstSite_[buckets] = int(buckets);
}

// Darts until as many hit as the mean density asks for: at 0.8 mean spacings this is 92 % of what fits on
// average, and few maps need the limit on darts.
void Cells::PlacePoissonDisc(uint64_t stream) {
    constexpr double kRadius = 0.8;
    constexpr int kDartsPerSite = 60, kMaxInBucket = 4;
    const int buckets = periodX_ * periodY_;
    std::vector<Site> found(size_t(buckets) * kMaxInBucket);
    std::vector<int> counts(size_t(buckets), 0);
    Rng rng(stream);
    int hits = 0;
    for (int dart = 0; dart < kDartsPerSite * buckets && hits < buckets; ++dart) {
        const double x = periodX_ * UnitDouble(&rng), y = periodY_ * UnitDouble(&rng);
        const int column = int(x), row = int(y);
        const Site site{float(x - column), float(y - row)};
        bool isFree = true;
        for (int dj = -1; dj <= 1 && isFree; ++dj)
            for (int di = -1; di <= 1 && isFree; ++di) {
                const int bucket = Wrap(row + dj, periodY_) * periodX_ + Wrap(column + di, periodX_);
                for (int k = 0; k < counts[size_t(bucket)]; ++k) {
                    const Site& other = found[size_t(bucket * kMaxInBucket + k)];
                    const double dx = di + double(other.x - site.x), dy = dj + double(other.y - site.y);
                    isFree = isFree && dx * dx + dy * dy >= kRadius * kRadius;
                }
            }
        const size_t bucket = size_t(row * periodX_ + column);
        if (!isFree || counts[bucket] == kMaxInBucket) continue;
        found[bucket * kMaxInBucket + size_t(counts[bucket]++)] = site;
        ++hits;
    }
    for (size_t bucket = 0; bucket < size_t(buckets); ++bucket) {
        firstSite_[bucket] = int(sites_.size());
        for (int k = 0; k < counts[bucket]; ++k) sites_.push_back(found[bucket * kMaxInBucket + size_t(k)]);
    }
    firstSite_[size_t(buckets)] = int(sites_.size());
}

std::vector<std::array<double, 2>> Cells::SitePositions() const {
    std::vector<std::array<double, 2>> positions;
    for (int row = 0; row < periodY_; ++row)
        for (int column = 0; column < periodX_; ++column) {
            const size_t bucket = size_t(row * periodX_ + column);
            for (int i = firstSite_[bucket]; i < firstSite_[bucket + 1]; ++i)
                positions.push_back(
                    {column + double(sites_[size_t(i)].x), row + double(sites_[size_t(i)].y)});
        }
    return positions;
}

/// The two nearest sites so far: squared distances, and where they are from here.
struct Cells::Search {
    double nearest = 1e30, second = 1e30, dx1 = 0, dy1 = 0, dx2 = 0, dy2 = 0;
    int site = 0;
};

/// @param dx, dy  from the point to the bucket's corner
inline void Cells::Visit(int column, int row, double dx, double dy, Search* search) const {
    const size_t bucket = size_t(row * periodX_ + column);
    for (int i = firstSite_[bucket]; i < firstSite_[bucket + 1]; ++i) {
        const double x = dx + double(sites_[size_t(i)].x), y = dy + double(sites_[size_t(i)].y);
        const double d2 = x * x + y * y;
        if (d2 >= search->second) continue;
        if (d2 < search->nearest) {
            *search = {d2, search->nearest, x, y, search->dx1, search->dy1, i};
        } else {
            search->second = d2;
            search->dx2 = x;
            search->dy2 = y;
        }
    }
}

Cells::Nearest Cells::NearestTo(double x, double y) const {
    const double floorX = std::floor(x), floorY = std::floor(y), fx = x - floorX, fy = y - floorY;
    const auto wrapped = [](double v, int period) {
        return Wrap(int(v - period * std::floor(v / period)), period);
    };
    const int column = wrapped(floorX, periodX_), row = wrapped(floorY, periodY_);
    Search search;
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
            Visit(Wrap(column + i, periodX_), Wrap(row + j, periodY_), i - fx, j - fy, &search);
    // Sites that were not seen yet are at least so far away.
    const double margin = 1 + std::min(std::min(fx, 1 - fx), std::min(fy, 1 - fy));
    if (search.second > margin * margin)
        for (int j = -2; j <= 2; ++j)
            for (int i = -2; i <= 2; ++i)
                if (std::max(std::abs(i), std::abs(j)) == 2)
                    Visit(Wrap(column + i, periodX_), Wrap(row + j, periodY_), i - fx, j - fy, &search);
    const double f1 = std::sqrt(search.nearest), f2 = std::sqrt(search.second);
    const double inverse1 = f1 > 0 ? 1 / f1 : 0, inverse2 = f2 > 0 ? 1 / f2 : 0;
    return {
        search.site,           f1, f2, -search.dx1 * inverse1, -search.dy1 * inverse1, -search.dx2 * inverse2,
        -search.dy2 * inverse2};
}

}  // namespace lacquer::estimate
