#include "pbrt/guiding/path_guide.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lacquer {
namespace {

/// Light is summed in 2^-24 of its mean in the first pass, and counts for 2^15 of that at most: sums of 2^24
/// vertices fit, and what is less does not matter to an image.
constexpr double kUnitsOfMean = 0x1p24, kMaxLight = 0x1p39;
/// Of a logarithm of quotients of densities.
constexpr float kMaxGain = 10;
/// Mean logarithm by which a mixture must be denser than scattering alone where the light is: less is not
/// worth the time.
constexpr double kMinGain = 0.05;
/// Vertices of a pass that a cell may have, times the root of the pass's length over that of the first
/// [Müller et al. 2017, sec. 3.2, with other numbers]. docs/performance.md has what others gave.
constexpr double kVerticesOfCell = 500;
constexpr int kMaxDivisions = 48;
/// Of some 100 leaves of 32 bytes, and a kilobyte more: about 70 MB.
constexpr size_t kMaxCells = 1 << 14;
/// Share of scattering where something was learned for the first time.
constexpr float kFirstShare = 0.5f;

void AddTo(std::atomic_ref<int64_t> sum, int64_t amount) { sum.fetch_add(amount, std::memory_order_relaxed); }

}  // namespace

GuidedFacing FacingOf(Vec3 n) {
    const Vec3 a = glm::abs(n);
    const int axis = a.x > a.y ? (a.x > a.z ? 0 : 2) : (a.y > a.z ? 1 : 2);
    return GuidedFacing(2 * axis + int(n[axis] < 0));
}

void GuideCell::EndPass(bool isLast) {
    directions_.Rebuild();
    for (size_t kind = 0; kind < scatteringShare_.size(); ++kind) {
        const Evidence& e = evidence_[kind];
        if (e.light > 0 && hasLearned_) {
            const auto best = std::max_element(e.gains.begin(), e.gains.end());
            const double gain = double(*best - e.gains.back()) * double(kMaxGain);
            const bool isWorthIt = gain > kMinGain * double(e.light);
            scatteringShare_[kind] = isWorthIt ? kShares[size_t(best - e.gains.begin())] : 1;
        } else if (isLast) {
            scatteringShare_[kind] = 1;
        } else if (!hasLearned_) {
            scatteringShare_[kind] = kFirstShare;
        }
    }
    meanScattered_ = numVertices_ > 0 ? double(sumScattered_) / double(numVertices_) : 0;
    sumScattered_ = 0;
    hasLearned_ = true;
    evidence_ = {};
}

bool GuideCell::IsUsed() const {
    return std::any_of(scatteringShare_.begin(), scatteringShare_.end(),
                       [](float share) { return share < 1; });
}

PathGuide::PathGuide(const Bounds3& bounds) : nodes_(kNumGuidedFacings) {
    for (Node& node : nodes_) {
        node.first = ~int(cells_.size());
        cells_.emplace_back(cells_.size());
    }
    const Vec3 size = bounds.IsEmpty() ? Vec3(0) : bounds.Diagonal();
    const float side = std::max({size.x, size.y, size.z});
    corner_ = bounds.IsEmpty() ? Point3(0) : bounds.Center() - Vec3(side / 2);
    scale_ = side > 0 && std::isfinite(side) ? 1 / side : 0;
    MakeGrid();
}

GuidedDensity PathGuide::At(Point3 p, GuidedFacing facing, GuidedKind kind) const {
    if (!isUsed_) return {};
    Vec3 x = float(kGridSide) * glm::clamp((p - corner_) * scale_, 0.f, OneMinusEpsilon);
    const glm::ivec3 box = glm::clamp(glm::ivec3(x), 0, kGridSide - 1);
    x -= Vec3(box);
    int node = grid_[size_t(facing)][size_t((box.z * kGridSide + box.y) * kGridSide + box.x)];
    for (int axis = 0; node >= 0; axis = axis == 2 ? 0 : axis + 1) {
        const bool upper = x[axis] >= 0.5f;
        x[axis] = 2 * x[axis] - float(upper);
        node = nodes_[size_t(node + int(upper))].first;
    }
    const GuideCell& cell = cells_[size_t(~node)];
    if (!isLearning_ && cell.ScatteringShare(kind) == 1) return {};
    return {cell, kind};
}

int64_t PathGuide::Units(double light) const {
    return light > 0 ? int64_t(std::min(light * perUnit_, kMaxLight)) : 0;
}

void PathGuide::Learn(const GuidedPath& path, float found) {
    for (size_t i = 0; i < path.size(); ++i) {
        const GuidedVertex& vertex = path[i];
        const double after = double(found) - vertex.found;
        if (perUnit_ == 0) LearnUnit(after / vertex.throughput);
        GuideCell& cell = CellOf(vertex);
        AddTo(std::atomic_ref(cell.numVertices_), 1);
        if (perUnit_ == 0) continue;
        AddTo(std::atomic_ref(cell.sumScattered_), Units(after / vertex.throughputBefore));
        double light = after;
        if (i + 1 < path.size()) {
            const GuidedVertex& next = path[i + 1];
            const double beyond = CellOf(next).meanScattered_ / perUnit_;
            light = next.found - vertex.found + next.throughputBefore * beyond;
        }
        LearnVertex(vertex, light, &cell);
    }
}

void PathGuide::LearnUnit(double incident) {
    if (incident > 0 && std::isfinite(incident))
        AddTo(std::atomic_ref(magnitudes_[size_t(std::clamp(std::ilogb(incident) + 128, 0, 255))]), 1);
}

void PathGuide::LearnVertex(const GuidedVertex& vertex, double light, GuideCell* cell) const {
    const float pdf = vertex.density.Of(vertex.scattering, vertex.learned);
    if (!(pdf > 0)) return;
    if (!vertex.isSpecular)
        cell->directions_.Add(vertex.wi,
                              Units(light / vertex.throughput * double(vertex.cosine) / double(pdf)));
    LearnShare(vertex, pdf, Units(light / vertex.throughputBefore), cell);
}

void PathGuide::LearnShare(const GuidedVertex& vertex, float pdf, int64_t scattered, GuideCell* cell) const {
    // The share of least divergence from the light that is scattered [Müller 2019, sec. 10.4], of few shares
    // and by sums in place of steps that follow from each other.
    GuideCell::Evidence& evidence = cell->evidence_[size_t(vertex.density.Kind())];
    AddTo(std::atomic_ref(evidence.light), scattered);
    for (size_t i = 0; i < GuideCell::kShares.size(); ++i) {
        const float share = GuideCell::kShares[i];
        const float other = share * vertex.scattering + (1 - share) * vertex.learned;
        const float gain = std::clamp(std::log(other / pdf), -kMaxGain, kMaxGain);
        AddTo(std::atomic_ref(evidence.gains[i]), int64_t(double(scattered) * double(gain / kMaxGain)));
    }
}

void PathGuide::SetUnit() {
    double sum = 0, count = 0;
    for (size_t i = 0; i < magnitudes_.size(); ++i) {
        sum += double(magnitudes_[i]) * std::ldexp(1.5, int(i) - 128);
        count += double(magnitudes_[i]);
    }
    if (count > 0) perUnit_ = kUnitsOfMean * count / sum;
}

void PathGuide::EndPass(bool isLast) {
    if (perUnit_ == 0) {
        SetUnit();
    } else {
        for (GuideCell& cell : cells_) cell.EndPass(isLast);
    }
    const double most = kVerticesOfCell * std::sqrt(std::ldexp(1., std::max(pass_ - 1, 0)));
    ++pass_;
    if (!isLast)
        for (int root = 0; root < kNumGuidedFacings; ++root) Divide(root, 0, most);
    MakeGrid();
    isLearning_ = !isLast;
    isUsed_ = isLearning_ ||
              std::any_of(cells_.begin(), cells_.end(), [](const GuideCell& c) { return c.IsUsed(); });
}

void PathGuide::MakeGrid() {
    for (size_t facing = 0; facing < grid_.size(); ++facing)
        for (int i = 0; i < kGridSide * kGridSide * kGridSide; ++i) {
            const std::array<int, 3> box{i % kGridSide, i / kGridSide % kGridSide, i / Sqr(kGridSide)};
            int node = nodes_[facing].first;
            for (int level = 0; level < 3 * kGridDepth && node >= 0; ++level) {
                const int bit = box[size_t(level % 3)] >> (kGridDepth - 1 - level / 3) & 1;
                node = nodes_[size_t(node + bit)].first;
            }
            grid_[facing][size_t(i)] = node;
        }
}

void PathGuide::Divide(int node, int depth, double most, double vertices) {
    int first = nodes_[size_t(node)].first;
    if (first < 0) {
        GuideCell& cell = cells_[size_t(~first)];
        if (vertices < 0) vertices = double(cell.numVertices_);
        cell.numVertices_ = 0;
        if (vertices <= most || depth == kMaxDivisions || cells_.size() == kMaxCells) return;
        const int upper = ~int(cells_.size());
        GuideCell half = cell;
        half.number_ = cells_.size();
        cells_.push_back(std::move(half));
        const int lower = std::exchange(first, int(nodes_.size()));
        nodes_.push_back({lower});
        nodes_.push_back({upper});
        nodes_[size_t(node)].first = first;
        vertices /= 2;
    }
    Divide(first, depth + 1, most, vertices);
    Divide(first + 1, depth + 1, most, vertices);
}

}  // namespace lacquer
