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
    constexpr int kDartsPerSite = 60;
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

void NearestSites::AddBucket(int i, int j) {
    const int column = Wrap(column_ + i, cells_.periodX_), row = Wrap(row_ + j, cells_.periodY_);
    const size_t bucket = size_t(row * cells_.periodX_ + column);
    for (int site = cells_.firstSite_[bucket]; site < cells_.firstSite_[bucket + 1]; ++site) {
        x_[size_t(count_)] = i + double(cells_.sites_[size_t(site)].x);
        y_[size_t(count_)] = j + double(cells_.sites_[size_t(site)].y);
        site_[size_t(count_++)] = site;
    }
}

void NearestSites::GatherNear(double floorX, double floorY) {
    const auto wrapped = [](double v, int period) {
        return Wrap(int(v - period * std::floor(v / period)), period);
    };
    floorX_ = floorX;
    floorY_ = floorY;
    column_ = wrapped(floorX, cells_.periodX_);
    row_ = wrapped(floorY, cells_.periodY_);
    count_ = 0;
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) AddBucket(i, j);
    numNear_ = count_;
}

void NearestSites::GatherFar() {
    if (count_ > numNear_) return;
    for (int j = -2; j <= 2; ++j)
        for (int i = -2; i <= 2; ++i)
            if (std::max(std::abs(i), std::abs(j)) == 2) AddBucket(i, j);
}

/// The two nearest of the candidates: squared distances and numbers.
struct NearestSites::Pair {
    double first = 1e30, second = 1e30;
    size_t firstIndex = 0, secondIndex = 0;
};

NearestSites::Pair NearestSites::FindAmong(int count, double fx, double fy) const {
    std::array<double, kMaxCandidates> squared;
    for (size_t k = 0; k < size_t(count); ++k) {
        const double dx = x_[k] - fx, dy = y_[k] - fy;
        squared[k] = dx * dx + dy * dy;
    }
    // Without branches, which would be mispredicted.
    Pair p;
    for (size_t k = 0; k < size_t(count); ++k) {
        const double d = squared[k];
        const bool isFirst = d < p.first, isSecond = d < p.second;
        p.secondIndex = isFirst ? p.firstIndex : isSecond ? k : p.secondIndex;
        p.second = isFirst ? p.first : isSecond ? d : p.second;
        p.firstIndex = isFirst ? k : p.firstIndex;
        p.first = isFirst ? d : p.first;
    }
    return p;
}

NearestSites::Nearest NearestSites::At(double x, double y) {
    const double floorX = std::floor(x), floorY = std::floor(y), fx = x - floorX, fy = y - floorY;
    if (floorX != floorX_ || floorY != floorY_) GatherNear(floorX, floorY);
    Pair p = FindAmong(numNear_, fx, fy);
    // Sites that were not seen yet are at least so far away.
    const double margin = 1 + std::min(std::min(fx, 1 - fx), std::min(fy, 1 - fy));
    if (p.second > margin * margin) {
        GatherFar();
        p = FindAmong(count_, fx, fy);
    }
    const double f1 = std::sqrt(p.first), f2 = std::sqrt(p.second);
    const double inverse1 = f1 > 0 ? 1 / f1 : 0, inverse2 = f2 > 0 ? 1 / f2 : 0;
    return {site_[p.firstIndex],
            f1,
            f2,
            (fx - x_[p.firstIndex]) * inverse1,
            (fy - y_[p.firstIndex]) * inverse1,
            (fx - x_[p.secondIndex]) * inverse2,
            (fy - y_[p.secondIndex]) * inverse2};
}

}  // namespace lacquer::estimate
