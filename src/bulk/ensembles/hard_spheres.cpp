#include "bulk/ensembles/hard_spheres.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace lacquer::bulk {

double Domain::Volume() const {
    return kind == Kind::Ball ? 4 * std::numbers::pi / 3 * size * size * size : size * size * size;
}

Point Domain::Displacement(const Point& a, const Point& b) const {
    Point d = b - a;
    if (kind == Kind::PeriodicBox) d -= size * (d / size).array().round().matrix();
    return d;
}

Point Domain::Wrap(const Point& p) const {
    return kind == Kind::PeriodicBox ? Point(p - size * (p / size).array().round().matrix()) : p;
}

Point Domain::RandomPoint(Random& random) const {
    return kind == Kind::Ball ? random.InBall(size) : random.InCube(-size / 2, size / 2);
}

HardSpheres::HardSpheres(const Domain& domain, std::vector<double> radii, double separation)
    : domain_(domain), radii_(std::move(radii)), separation_(separation) {
    const double largest = radii_.empty() ? 1 : *std::max_element(radii_.begin(), radii_.end());
    const double side = domain.kind == Domain::Kind::Ball ? 2 * domain.size : domain.size;
    constexpr int kMaxCells = 64;
    cellsPerSide_ = std::clamp(int(side / (2 * separation * largest)), 1, kMaxCells);
    cellSize_ = side / cellsPerSide_;
    cells_.resize(size_t(cellsPerSide_) * size_t(cellsPerSide_) * size_t(cellsPerSide_));
}

int HardSpheres::CellOf(const Point& p) const {
    int cell = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double half = 0.5 * cellSize_ * cellsPerSide_;
        cell = cell * cellsPerSide_ + std::clamp(int((p[axis] + half) / cellSize_), 0, cellsPerSide_ - 1);
    }
    return cell;
}

/// visit(i) for all spheres in the cell of p and in those about it, until it returns false.
template <class Visitor>
void HardSpheres::VisitNeighbors(const Point& p, const Visitor& visit) const {
    const int cell = CellOf(p), n = cellsPerSide_;
    const int at[3] = {cell / (n * n), cell / n % n, cell % n};
    const bool isPeriodic = domain_.kind == Domain::Kind::PeriodicBox;
    // With fewer than three cells a side, each neighbour once.
    const auto first = [&](int i) { return isPeriodic ? (n < 3 ? 0 : i - 1) : std::max(0, i - 1); };
    const auto last = [&](int i) { return isPeriodic ? (n < 3 ? n - 1 : i + 1) : std::min(n - 1, i + 1); };
    const auto wrap = [&](int i) { return size_t((i + n) % n); };
    const size_t side = size_t(n);
    for (int a = first(at[0]); a <= last(at[0]); ++a)
        for (int b = first(at[1]); b <= last(at[1]); ++b)
            for (int c = first(at[2]); c <= last(at[2]); ++c)
                for (const int i : cells_[(wrap(a) * side + wrap(b)) * side + wrap(c)])
                    if (!visit(size_t(i))) return;
}

bool HardSpheres::IsFree(const Point& center, size_t sphere) const {
    if (!domain_.Contains(center, Radius(sphere))) return false;
    bool isFree = true;
    VisitNeighbors(center, [&](size_t i) {
        const double reach = separation_ * (Radius(i) + Radius(sphere));
        isFree = i == sphere || domain_.Displacement(center, centers_[i]).squaredNorm() >= reach * reach;
        return isFree;
    });
    return isFree;
}

void HardSpheres::Insert(size_t sphere, const Point& center) {
    centers_.push_back(center);
    cells_[size_t(CellOf(center))].push_back(int(sphere));
}

void HardSpheres::MoveTo(size_t sphere, const Point& center) {
    const int from = CellOf(centers_[sphere]), to = CellOf(center);
    if (from != to) {
        std::vector<int>& cell = cells_[size_t(from)];
        cell.erase(std::find(cell.begin(), cell.end(), int(sphere)));
        cells_[size_t(to)].push_back(int(sphere));
    }
    centers_[sphere] = center;
}

bool HardSpheres::AddAt(const Point& center) {
    const size_t next = centers_.size();
    if (next >= radii_.size() || !IsFree(center, next)) return false;
    Insert(next, center);
    return true;
}

bool HardSpheres::AddAll(Random& random, int maxTries) {
    while (centers_.size() < radii_.size()) {
        int tries = 0;
        while (!AddAt(domain_.RandomPoint(random)))
            if (++tries >= maxTries) return false;
    }
    return true;
}

bool HardSpheres::AddAllByGrowth(Random& random) {
    double volume = 0;
    for (const double r : radii_) volume += 4 * std::numbers::pi / 3 * r * r * r;
    volume *= separation_ * separation_ * separation_;
    constexpr double kEasyFraction = 0.2, kSequentialFraction = 0.32, kLargestFraction = 0.66;
    constexpr int kMaxSweeps = 20000;
    const double fraction = volume / domain_.Volume();
    if (fraction > kLargestFraction) return false;
    // Random sequential addition ends at 0.38.
    if (fraction < kSequentialFraction && AddAll(random)) return true;
    centers_.clear();
    for (std::vector<int>& cell : cells_) cell.clear();
    scale_ = std::min(1., std::cbrt(kEasyFraction / fraction));
    if (!AddAll(random)) return false;
    double step = 0.2 * cellSize_;
    for (int sweep = 0; scale_ < 1; ++sweep) {
        if (sweep >= kMaxSweeps) return false;
        const int accepted = Sweep(random, step);
        // About half of the moves shall succeed.
        step = std::clamp(step * (2 * accepted > Count() ? 1.1 : 0.9), 1e-6 * cellSize_, 0.5 * cellSize_);
        scale_ = std::min(1., LargestScale());
    }
    return true;
}

int HardSpheres::Sweep(Random& random, double step) {
    int accepted = 0;
    for (size_t i = 0; i < centers_.size(); ++i) {
        const Point center = domain_.Wrap(centers_[i] + random.InCube(-step, step));
        if (!IsFree(center, i)) continue;
        MoveTo(i, center);
        ++accepted;
    }
    return accepted;
}

void HardSpheres::Move(Random& random, int perSphere) {
    double step = 0.3 * cellSize_;
    int64_t accepted = 0;
    constexpr int kMaxSweeps = 100000;
    for (int sweep = 0; sweep < kMaxSweeps && accepted < int64_t(perSphere) * Count(); ++sweep) {
        const int now = Sweep(random, step);
        accepted += now;
        step = std::clamp(step * (2 * now > Count() ? 1.1 : 0.9), 1e-6 * cellSize_, 0.5 * cellSize_);
    }
}

double HardSpheres::LargestScale() const {
    double scale = 1;
    for (size_t i = 0; i < centers_.size(); ++i) {
        if (domain_.kind == Domain::Kind::Ball)
            scale = std::min(scale, (domain_.size - centers_[i].norm()) / radii_[i]);
        VisitNeighbors(centers_[i], [&](size_t j) {
            if (j > i)
                scale = std::min(scale, domain_.Displacement(centers_[i], centers_[j]).norm() /
                                            (separation_ * (radii_[i] + radii_[j])));
            return true;
        });
    }
    return scale < 1 ? scale * (1 - 1e-12) : 1;  // not touching, by rounding
}

}  // namespace lacquer::bulk
