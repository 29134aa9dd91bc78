#include "pbrt/guiding/directional_tree.h"

#include <algorithm>
#include <numeric>

#include "pbrt/core/math.h"

namespace lacquer {
namespace {

/// A quadrant with a larger part of all is divided [Müller et al. 2017, sec. 3.2].
constexpr double kMaxLeafShare = 0.02;
/// Squares of single floats tell directions apart that far: what is drawn in a leaf must be found in it.
constexpr int kMaxDepth = 12;
/// Of the sums, after a density was made of them.
constexpr double kKept = 0.5;

}  // namespace

/// Makes a tree of the sums in another.
struct DirectionalTree::Builder {
    const DirectionalTree& old;
    DirectionalTree made;
    double total = 0;

    double SumOf(uint16_t child) const {
        if (child & kLeaf) return double(old.sums_[child & ~kLeaf]);
        double sum = 0;
        for (const uint16_t below : old.nodes_[child]) sum += SumOf(below);
        return sum;
    }

    /// @param from  node or leaf of the old tree that has the square    @param sum  within the square
    uint16_t Build(uint16_t from, double sum, Point2 corner, float side, int depth) {
        if (depth > 0 && (sum <= kMaxLeafShare * total || depth == kMaxDepth))
            return AddLeaf(sum, corner, side);
        const size_t node = made.nodes_.size();
        made.nodes_.emplace_back();
        const float half = side / 2;
        for (size_t q = 0; q < 4; ++q) {
            const uint16_t below = from & kLeaf ? from : old.nodes_[from][q];
            const double part = from & kLeaf ? sum / 4 : SumOf(below);
            const uint16_t child =
                Build(below, part, corner + half * Point2(float(q & 1), float(q >> 1)), half, depth + 1);
            made.nodes_[node][q] = child;
        }
        return uint16_t(node);
    }
    uint16_t AddLeaf(double sum, Point2 corner, float side) {
        const double share = sum / total;
        const uint16_t leaf = uint16_t(made.leaves_.size());
        made.leaves_.push_back({float(share / (4 * double(Pi) * double(side) * double(side))), corner, side});
        made.cumulative_.push_back(float(share));
        made.sums_.push_back(int64_t(kKept * sum));
        return leaf | kLeaf;
    }
};

DirectionalTree::DirectionalTree()
    : nodes_{{kLeaf, kLeaf | 1, kLeaf | 2, kLeaf | 3}}, cumulative_{0.25f, 0.5f, 0.75f, 1}, sums_(4) {
    for (int q = 0; q < 4; ++q)
        leaves_.push_back({float(1 / (4 * Pi)), 0.5f * Point2(float(q & 1), float(q >> 1)), 0.5f});
    MakeShortcuts();
}

void DirectionalTree::MakeShortcuts() {
    for (int y = 0; y < kGridSide; ++y)
        for (int x = 0; x < kGridSide; ++x) {
            uint16_t child = 0;
            for (int bit = kGridDepth - 1; bit >= 0 && !(child & kLeaf); --bit)
                child = nodes_[child][size_t((x >> bit & 1) + 2 * (y >> bit & 1))];
            grid_[size_t(y * kGridSide + x)] = child;
        }
    for (size_t k = 0; k < kParts; ++k) firstOf_[k] = uint16_t(IndexOf(float(k) / kParts, 0));
}

/// The leaf that a number draws. @param from  at most that
size_t DirectionalTree::IndexOf(float u, size_t from) const {
    while (from + 1 < cumulative_.size() && !(u < cumulative_[from])) ++from;
    return from;
}

size_t DirectionalTree::Find(Vec3 w) const {
    Point2 p = float(kGridSide) * EqualAreaSphereToSquare(w);
    const Int2 square = glm::clamp(Int2(p), 0, kGridSide - 1);
    p -= Point2(square);
    uint16_t child = grid_[size_t(square.y * kGridSide + square.x)];
    while (!(child & kLeaf)) {
        const bool right = p.x >= 0.5f, upper = p.y >= 0.5f;
        p = 2.f * p - Point2(right, upper);
        child = nodes_[child][size_t(right) + 2 * size_t(upper)];
    }
    return child & ~kLeaf;
}

DirectionalTree::Direction DirectionalTree::Sample(Point2 u) const {
    const size_t index = IndexOf(u.x, firstOf_[size_t(std::min(int(u.x * kParts), kParts - 1))]);
    const Leaf& leaf = leaves_[index];
    const float before = index == 0 ? 0 : cumulative_[index - 1];
    const float within = std::min((u.x - before) / (cumulative_[index] - before), OneMinusEpsilon);
    return {EqualAreaSquareToSphere(leaf.corner + leaf.side * Point2(within, u.y)), leaf.pdf};
}

void DirectionalTree::Rebuild() {
    Builder builder{*this, {}, double(std::accumulate(sums_.begin(), sums_.end(), int64_t(0)))};
    if (!(builder.total > 0)) return;
    DirectionalTree& made = builder.made;
    made.nodes_.clear();
    made.leaves_.clear();
    made.cumulative_.clear();
    made.sums_.clear();
    builder.Build(0, builder.total, Point2(0), 1, 0);
    made.nodes_.shrink_to_fit();
    made.leaves_.shrink_to_fit();
    made.cumulative_.shrink_to_fit();
    made.sums_.shrink_to_fit();
    std::partial_sum(made.cumulative_.begin(), made.cumulative_.end(), made.cumulative_.begin());
    made.MakeShortcuts();
    *this = std::move(made);
}

}  // namespace lacquer
