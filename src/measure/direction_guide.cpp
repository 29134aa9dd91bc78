#include "measure/direction_guide.h"

#include <algorithm>

#include "pbrt/core/check.h"
#include "pbrt/core/sampling.h"

namespace lacquer::measure {

namespace {

constexpr double kUniformShare = 0.1;
constexpr int kMaxDepth = 16;
/// A node with more of the points than this part of them is divided.
constexpr double kLeafShare = 1.0 / 4096;

}  // namespace

DirectionGuide::DirectionGuide(std::span<const Vec3> directions, bool upper, bool lower) {
    LACQUER_CHECK(upper || lower);
    std::vector<Point2> points[2];
    for (const Vec3 w : directions)
        if (w.z != 0 && (w.z > 0 ? upper : lower))
            points[w.z > 0 ? 0 : 1].push_back(InvertUniformDiskConcentric({w.x, w.y}));
    const size_t total = points[0].size() + points[1].size();
    uniform_ = total > 0 ? kUniformShare : 1;
    const int leafSize = std::max(12, int(double(total) * kLeafShare));
    for (const int side : {0, 1}) {
        if (!(side == 0 ? upper : lower)) continue;
        ++numSides_;
        roots_[side] = int(nodes_.size());
        nodes_.emplace_back();
        const size_t firstLeaf = leaves_.size();
        Split(roots_[side], points[side], std::max<size_t>(1, total), leafSize);
        leafSide_.resize(leaves_.size(), side);
        LACQUER_CHECK(leaves_.size() > firstLeaf);
    }
}

void DirectionGuide::Split(int index, std::span<Point2> points, size_t total, int leafSize) {
    const int depth = nodes_[size_t(index)].depth;
    const Point2 corner = nodes_[size_t(index)].corner;
    if (int(points.size()) <= leafSize || depth == kMaxDepth) {
        const double probability = double(points.size()) / double(total);
        nodes_[size_t(index)].density = std::ldexp(probability, 2 * depth);
        nodes_[size_t(index)].leaf = int(leaves_.size());
        leaves_.push_back(index);
        leafEnd_.push_back((leafEnd_.empty() ? 0 : leafEnd_.back()) + probability);
        return;
    }
    const float half = std::ldexp(1.f, -depth - 1);
    const int first = int(nodes_.size());
    nodes_[size_t(index)].firstChild = first;
    for (int child = 0; child < 4; ++child) {
        Node node;
        node.depth = depth + 1;
        node.corner = corner + half * Point2(float(child & 1), float(child >> 1));
        nodes_.push_back(node);
    }
    auto begin = points.begin();
    for (int child = 0; child < 4; ++child) {
        const auto end = std::partition(begin, points.end(), [&](Point2 p) {
            return (p.x >= corner.x + half) == bool(child & 1) &&
                   (p.y >= corner.y + half) == bool(child >> 1);
        });
        Split(first + child, {begin, end}, total, leafSize);
        begin = end;
    }
}

const DirectionGuide::Node& DirectionGuide::LeafAt(int root, Point2 p) const {
    const Node* node = &nodes_[size_t(root)];
    while (node->firstChild >= 0) {
        const float half = std::ldexp(1.f, -node->depth - 1);
        const int child = (p.x >= node->corner.x + half ? 1 : 0) + (p.y >= node->corner.y + half ? 2 : 0);
        node = &nodes_[size_t(node->firstChild + child)];
    }
    return *node;
}

DirectionGuide::Draw DirectionGuide::Sample(glm::dvec4 u) const {
    // u.x decides between the two densities, u.y on the side or the leaf, the others within.
    int side = 0;
    Point2 p(glm::min(glm::dvec2(u.z, u.w), 1 - 0x1p-24));
    if (u.x < uniform_) {
        side = roots_[0] < 0 || (numSides_ == 2 && u.y < 0.5) ? 1 : 0;
    } else {
        const auto it = std::upper_bound(leafEnd_.begin(), leafEnd_.end(), u.y * leafEnd_.back());
        const size_t leaf = std::min(size_t(it - leafEnd_.begin()), leaves_.size() - 1);
        const Node& node = nodes_[size_t(leaves_[leaf])];
        side = leafSide_[leaf];
        p = node.corner + std::ldexp(1.f, -node.depth) * p;
    }
    const Point2 d = SampleUniformDiskConcentric(p);
    // The rim, where z vanishes, counts as the nearest direction that leaves the surface.
    const float z = std::sqrt(std::max(1e-12f, 1 - d.x * d.x - d.y * d.y));
    const Vec3 w = Normalize(Vec3(d.x, d.y, side == 0 ? z : -z));
    const double guided = LeafAt(roots_[side], p).density;
    return {w, uniform_ / numSides_ + (1 - uniform_) * guided};
}

double DirectionGuide::DiskDensity(Vec3 w) const {
    const int root = roots_[w.z > 0 ? 0 : 1];
    if (root < 0 || w.z == 0) return 0;
    const Node& leaf = LeafAt(root, InvertUniformDiskConcentric({w.x, w.y}));
    return uniform_ / numSides_ + (1 - uniform_) * leaf.density;
}

}  // namespace lacquer::measure
