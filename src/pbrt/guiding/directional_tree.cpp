#include "pbrt/guiding/directional_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pbrt/core/math.h"

namespace lacquer {
namespace {

/// A quadrant with a larger part of all is divided [Müller et al. 2017, sec. 3.2].
constexpr double kMaxLeafShare = 0.02;
/// Of the sums, after a density was made of them.
constexpr double kKept = 0.5;

}  // namespace

/// Makes a tree of the sums in another.
struct DirectionalTree::Builder {
    const DirectionalTree& old;
    DirectionalTree made;
    double total = 0;
    double before = 0;  ///< share of the leaves that are made

    double SumOf(uint16_t child) const {
        if (child & kLeaf) return double(old.sums_[child & ~kLeaf]);
        double sum = 0;
        for (const uint16_t below : old.nodes_[child]) sum += SumOf(below);
        return sum;
    }

    /// @param from  node or leaf of the old tree that has the square    @param sum  within the square
    uint16_t Build(uint16_t from, double sum, Int2 corner, int depth) {
        if (depth > 0 && (sum <= kMaxLeafShare * total || depth == kMaxDepth))
            return AddLeaf(sum, corner, depth);
        const size_t node = made.nodes_.size();
        made.nodes_.emplace_back();
        const int half = 1 << (kMaxDepth - depth) >> 1;
        for (size_t q = 0; q < 4; ++q) {
            const uint16_t below = from & kLeaf ? from : old.nodes_[from][q];
            const double part = from & kLeaf ? sum / 4 : SumOf(below);
            const uint16_t child =
                Build(below, part, corner + half * Int2(int(q & 1), int(q >> 1)), depth + 1);
            made.nodes_[node][q] = child;
        }
        return uint16_t(node);
    }
    uint16_t AddLeaf(double sum, Int2 corner, int depth) {
        const double share = sum / total;
        const uint16_t leaf = uint16_t(made.leaves_.size());
        made.leaves_.push_back({float(std::ldexp(share / (4 * double(Pi)), 2 * depth)),
                                float(before),
                                {uint16_t(corner.x), uint16_t(corner.y)},
                                uint16_t(1 << (kMaxDepth - depth))});
        made.sums_.push_back(int64_t(kKept * sum));
        before += share;
        return leaf | kLeaf;
    }
};

DirectionalTree::DirectionalTree() : nodes_{{kLeaf, kLeaf | 1, kLeaf | 2, kLeaf | 3}}, sums_(4) {
    constexpr uint16_t kHalf = 1 << (kMaxDepth - 1);
    for (int q = 0; q < 4; ++q)
        leaves_.push_back(
            {1 / (4 * Pi), float(q) / 4, {uint16_t(q & 1 ? kHalf : 0), uint16_t(q & 2 ? kHalf : 0)}, kHalf});
    EndLeaves();
}

void DirectionalTree::EndLeaves() {
    leaves_.push_back({.before = 1});
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
    while (u >= leaves_[from + 1].before) ++from;
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
    const float width = leaves_[index + 1].before - leaf.before;
    const float within = std::min((u.x - leaf.before) / width, OneMinusEpsilon);
    constexpr float kUnit = 1.f / (1 << kMaxDepth);
    return {EqualAreaSquareToSphere(
                kUnit * (Point2(leaf.corner[0], leaf.corner[1]) + float(leaf.side) * Point2(within, u.y))),
            leaf.pdf};
}

void DirectionalTree::Rebuild() {
    Builder builder{*this, {}, double(std::accumulate(sums_.begin(), sums_.end(), int64_t(0)))};
    if (!(builder.total > 0)) return;
    DirectionalTree& made = builder.made;
    made.nodes_.clear();
    made.leaves_.clear();
    made.sums_.clear();
    builder.Build(0, builder.total, Int2(0), 0);
    made.EndLeaves();
    made.nodes_.shrink_to_fit();
    made.leaves_.shrink_to_fit();
    made.sums_.shrink_to_fit();
    *this = std::move(made);
}

}  // namespace lacquer
