// A tree of lights, walked down by what each half may bring to the point [Conty Estevez and Kulla 2018]. Of a
// few lights each is looked at by itself, which is better, and faster than the tree's steps one by one.
#include "pbrt/core/parallel.h"
#include "pbrt/core/registry.h"
#include "pbrt/lights/light_bounds.h"
#include "pbrt/lights/light_index.h"

namespace lacquer {

namespace {

constexpr uint32_t kNoNode = ~uint32_t(0);

/// A cluster and its place in the tree. The left child follows its parent in the array.
struct alignas(64) Node {
    LightCluster cluster;
    uint32_t parent = kNoNode;
    uint32_t right = kNoNode;  ///< the right child; kNoNode for leaves
    uint32_t light = 0;        ///< of leaves
    /// Of a parent of two leaves that are one flat emitter: the share of the left one. Else 0.
    float pLeft = 0;
    bool IsLeaf() const { return right == kNoNode; }
};
static_assert(sizeof(Node) == 64);

/// Builds the tree top-down.
class Builder {
  public:
    struct Item {
        LightBounds bounds;
        uint32_t light = 0;
    };
    Builder(std::vector<Item> items, float totalPower) : items_(std::move(items)), totalPower_(totalPower) {
        if (items_.empty()) return;
        nodes_.resize(2 * items_.size() - 1);
        Build(0, items_.size(), 0, kNoNode);
    }
    std::vector<Node> TakeNodes() { return std::move(nodes_); }

  private:
    static constexpr int kBuckets = 12;
    static constexpr size_t kOwnTask = 1024;  ///< lights from which both halves are built at the same time
    struct Split {
        int dimension = -1;
        int lastLeft = 0;  ///< last bucket of the left side
    };
    LightBounds Build(size_t begin, size_t end, uint32_t self, uint32_t parent);
    size_t Partition(size_t begin, size_t end);
    Split BestSplit(size_t begin, size_t end, const Bounds3& centers) const;

    std::vector<Item> items_;
    std::vector<Node> nodes_;
    float totalPower_;
};

/// Bucket of a centre along one dimension of the box of all centres.
int BucketOf(Point3 center, const Bounds3& centers, int dimension, int count) {
    const float low = centers.min[dimension], extent = centers.max[dimension] - low;
    const float t = (center[dimension] - low) / extent;
    return int(std::min(std::max(0.f, t * float(count)), float(count - 1)));
}

/// Two flat emitters of nearly the same box, in one plane, that face the same way, as the triangles of a
/// rectangle do: their importances are nearly in the proportion of their powers everywhere.
bool AreOneFlatEmitter(const LightBounds& a, const LightBounds& b) {
    const bool faceAlike = a.cosTheta_o >= 1 && b.cosTheta_o >= 1 && a.twoSided == b.twoSided &&
                           a.cosTheta_e == b.cosTheta_e && Dot(a.axis, b.axis) > 1 - 1e-6f;
    const float size = Length(a.bounds.Diagonal());
    const Vec3 low = b.bounds.min - a.bounds.min, high = b.bounds.max - a.bounds.max;
    return faceAlike && MaxComponent(Abs(low)) < 0.05f * size && MaxComponent(Abs(high)) < 0.05f * size &&
           std::abs(Dot(low + high, a.axis)) < 1e-3f * size;
}

Builder::Split Builder::BestSplit(size_t begin, size_t end, const Bounds3& centers) const {
    Split best;
    float bestCost = Infinity;
    const Vec3 diagonal = centers.Diagonal();
    for (int dimension = 0; dimension < 3; ++dimension) {
        if (!(diagonal[dimension] > 0)) continue;
        // Sum up the lights of each bucket, then the buckets from the right and from the left.
        LightBounds buckets[kBuckets], right[kBuckets];
        for (size_t i = begin; i < end; ++i) {
            const LightBounds& b = items_[i].bounds;
            LightBounds& bucket = buckets[BucketOf(b.bounds.Center(), centers, dimension, kBuckets)];
            bucket = bucket.power > 0 ? Union(bucket, b) : b;
        }
        LightBounds sum;
        for (int k = kBuckets - 1; k > 0; --k) {
            if (buckets[k].power > 0) sum = sum.power > 0 ? Union(buckets[k], sum) : buckets[k];
            right[k] = sum;
        }
        // Thin boxes are cut along their length [Conty Estevez and Kulla 2018, eq. 2].
        const float regularity = MaxComponent(diagonal) / diagonal[dimension];
        sum = LightBounds();
        for (int k = 0; k + 1 < kBuckets; ++k) {
            if (buckets[k].power > 0) sum = sum.power > 0 ? Union(sum, buckets[k]) : buckets[k];
            if (!(sum.power > 0) || !(right[k + 1].power > 0)) continue;
            const float cost = regularity * (ClusterCost(sum) + ClusterCost(right[k + 1]));
            if (cost < bestCost) {
                bestCost = cost;
                best = {dimension, k};
            }
        }
    }
    return best;
}

size_t Builder::Partition(size_t begin, size_t end) {
    Bounds3 centers;
    for (size_t i = begin; i < end; ++i) centers = centers.Union(Bounds3(items_[i].bounds.bounds.Center()));
    const Split split = BestSplit(begin, end, centers);
    const size_t half = (begin + end) / 2;
    if (split.dimension < 0) return half;
    const auto middle = std::partition(
        items_.begin() + std::ptrdiff_t(begin), items_.begin() + std::ptrdiff_t(end), [&](const Item& item) {
            return BucketOf(item.bounds.bounds.Center(), centers, split.dimension, kBuckets) <=
                   split.lastLeft;
        });
    const size_t at = size_t(middle - items_.begin());
    return at == begin || at == end ? half : at;
}

/// Builds the nodes of some lights, which have the places from `self` on: two for each light but the last.
LightBounds Builder::Build(size_t begin, size_t end, uint32_t self, uint32_t parent) {
    LightBounds bounds = items_[begin].bounds;
    if (end - begin == 1) {
        nodes_[self].light = items_[begin].light;
    } else {
        const size_t middle = Partition(begin, end);
        const auto rightChild = self + uint32_t(2 * (middle - begin));
        LightBounds left, right;
        const auto buildLeft = [&] { left = Build(begin, middle, self + 1, self); };
        const auto buildRight = [&] { right = Build(middle, end, rightChild, self); };
        if (end - begin >= kOwnTask) {
            ParallelInvoke(buildLeft, buildRight);
        } else {
            buildLeft();
            buildRight();
        }
        nodes_[self].right = rightChild;
        bounds = Union(left, right);
        if (end - begin == 2 && AreOneFlatEmitter(left, right))
            nodes_[self].pLeft = left.power / (left.power + right.power);
    }
    nodes_[self].cluster = LightCluster(bounds, totalPower_);
    nodes_[self].parent = parent;
    return bounds;
}

/// Nodes that stand for the whole tree: leaves, and parents of two that are one flat emitter.
class FewNodes {
  public:
    FewNodes() = default;
    /// Empty if there are more than lanes, or no choice.
    explicit FewNodes(const std::vector<Node>& nodes) {
        for (uint32_t n = 0; n < uint32_t(nodes.size()); ++n) {
            const uint32_t parent = nodes[n].parent;
            const bool isOfPair = parent != kNoNode && nodes[parent].pLeft != 0;
            if (isOfPair || (!nodes[n].IsLeaf() && nodes[n].pLeft == 0)) continue;
            if (count_ == LightClusterLanes::kLanes) {
                count_ = 0;
                return;
            }
            clusters_.Set(count_, nodes[n].cluster);
            nodes_[size_t(count_++)] = n;
        }
    }
    bool IsEmpty() const { return count_ < 2; }

    /// Draws one, and makes a fresh number of u. False if none of them shines here.
    bool Sample(const LightReference& ref, float* u, uint32_t* node, float* pmf) const {
        const LaneFloats shares = Shares(ref);
        const float total = SumOf(shares);
        if (!(total > 0)) return false;
        const float place = *u * total;
        float below = 0;
        int chosen = 0;
        for (int k = 0; k < count_; ++k) {
            if (!(shares[k] > 0)) continue;
            chosen = k;
            if (place < below + shares[k]) break;
            below += shares[k];
        }
        const float own = shares[chosen];
        *u = std::clamp((place - below) / own, 0.f, OneMinusEpsilon);
        *node = nodes_[size_t(chosen)];
        *pmf *= own / total;
        return true;
    }
    /// Of drawing the k-th.
    float Pmf(const LightReference& ref, int k) const {
        const LaneFloats shares = Shares(ref);
        return shares[k] > 0 ? shares[k] / SumOf(shares) : 0.f;
    }
    /// Which one a node is; -1 if it is none.
    int Find(uint32_t node) const {
        for (int k = 0; k < count_; ++k)
            if (nodes_[size_t(k)] == node) return k;
        return -1;
    }

  private:
    /// By importance, and a part of the draws evenly to all that shine here: importance knows nothing of
    /// lobes and shadows. docs/performance.md has what that gives.
    LaneFloats Shares(const LightReference& ref) const {
        constexpr float kEven = 0.3f;  // over those by importance
        const LaneFloats importance = Importance(clusters_, ref);
        float numShining = 0;
        for (int k = 0; k < count_; ++k) numShining += importance[k] > 0 ? 1.f : 0.f;
        const LaneFloats even = LaneFloats{} + kEven * SumOf(importance) / std::max(numShining, 1.f);
        return (importance > 0.f) ? importance + even : importance;
    }
    /// One after the other: what Sample() adds up to.
    float SumOf(LaneFloats importance) const {
        float sum = 0;
        for (int k = 0; k < count_; ++k) sum += importance[k];
        return sum;
    }

    LightClusterLanes clusters_;
    std::array<uint32_t, LightClusterLanes::kLanes> nodes_{};
    int count_ = 0;
};

class BvhLightSampler final : public LightSampler {
  public:
    explicit BvhLightSampler(std::vector<const Light*> lights);
    std::optional<SampledLight> Sample(const LightReference& ref, float u) const override;
    float Pmf(const LightReference& ref, const Light* light) const override;

  private:
    std::vector<const Light*> lights_;
    LightIndex index_;
    std::vector<uint32_t> leaves_;   // of each light: its node, kNoNode for those without extent or power
    std::vector<uint32_t> distant_;  // lights without extent
    std::vector<Node> nodes_;
    FewNodes few_;
    float pDistant_ = 0;  // probability of each distant light; the tree has the rest
};

BvhLightSampler::BvhLightSampler(std::vector<const Light*> lights)
    : lights_(std::move(lights)), index_(lights_), leaves_(lights_.size(), kNoNode) {
    // Lights that never shine stay out; powers are bounded so that sums of them are finite.
    std::vector<Builder::Item> items(lights_.size());
    std::vector<unsigned char> hasExtent(lights_.size());
    ParallelFor(int64_t(lights_.size()), [&](int64_t k) {
        const auto i = size_t(k);
        const std::optional<LightBounds> bounds = lights_[i]->Bounds();
        hasExtent[i] = bounds.has_value();
        items[i] = {bounds.value_or(LightBounds()), uint32_t(i)};
        items[i].bounds.power = std::min(bounds ? bounds->power : lights_[i]->Power(), 1e25f);
    });
    std::erase_if(items, [](const Builder::Item& item) { return !(item.bounds.power > 0); });
    for (const Builder::Item& item : items)
        if (!hasExtent[item.light]) distant_.push_back(item.light);
    std::erase_if(items, [&](const Builder::Item& item) { return !hasExtent[item.light]; });
    double total = 0;
    for (const Builder::Item& item : items) total += double(item.bounds.power);
    nodes_ = Builder(std::move(items), float(total)).TakeNodes();
    few_ = FewNodes(nodes_);
    for (size_t n = 0; n < nodes_.size(); ++n)
        if (nodes_[n].IsLeaf()) leaves_[nodes_[n].light] = uint32_t(n);
    const size_t choices = distant_.size() + (nodes_.empty() ? 0 : 1);
    if (choices > 0) pDistant_ = 1 / float(choices);
}

std::optional<SampledLight> BvhLightSampler::Sample(const LightReference& ref, float u) const {
    // Choose a distant light or the tree, and make a fresh number of what is left of u.
    float pmf = 1;
    if (!distant_.empty()) {
        const float scaled = u / pDistant_;
        const size_t i = size_t(scaled);
        if (nodes_.empty())
            return SampledLight{lights_[distant_[std::min(i, distant_.size() - 1)]], pDistant_};
        if (i < distant_.size()) return SampledLight{lights_[distant_[i]], pDistant_};
        pmf = pDistant_;
        u = std::min(scaled - float(distant_.size()), OneMinusEpsilon);
    }
    if (nodes_.empty()) return std::nullopt;

    // Walk down to a leaf.
    uint32_t n = 0;
    if (!few_.IsEmpty() && !few_.Sample(ref, &u, &n, &pmf)) return std::nullopt;
    while (!nodes_[n].IsLeaf()) {
        const uint32_t left = n + 1, right = nodes_[n].right;
        float pLeft = nodes_[n].pLeft, pRight = 1 - pLeft;
        if (pLeft == 0) {
            const float a = Importance(nodes_[left].cluster, ref);
            const float b = Importance(nodes_[right].cluster, ref);
            if (!(a + b > 0)) return std::nullopt;
            pLeft = a / (a + b);
            pRight = b / (a + b);
        }
        if (u < pLeft) {
            u = std::min(u / pLeft, OneMinusEpsilon);
            pmf *= pLeft;
            n = left;
        } else {
            u = std::min((u - pLeft) / (1 - pLeft), OneMinusEpsilon);
            pmf *= pRight;
            n = right;
        }
    }
    if (!(pmf > 0)) return std::nullopt;
    return SampledLight{lights_[nodes_[n].light], pmf};
}

float BvhLightSampler::Pmf(const LightReference& ref, const Light* light) const {
    const uint32_t i = index_.Find(light);
    if (i == LightIndex::kNone) return 0;
    uint32_t n = leaves_[i];
    if (n == kNoNode) return light->Bounds() || !(light->Power() > 0) ? 0.f : pDistant_;

    // Climb from the leaf: at each node the share of this child against its sibling.
    float pmf = distant_.empty() ? 1.f : pDistant_;
    for (uint32_t parent; (parent = nodes_[n].parent) != kNoNode; n = parent) {
        if (const int k = few_.IsEmpty() ? -1 : few_.Find(n); k >= 0) return pmf * few_.Pmf(ref, k);
        const uint32_t left = parent + 1;
        if (const float pLeft = nodes_[parent].pLeft; pLeft != 0) {
            pmf *= n == left ? pLeft : 1 - pLeft;
            continue;
        }
        const uint32_t sibling = n == left ? nodes_[parent].right : left;
        const float own = Importance(nodes_[n].cluster, ref);
        if (!(own > 0)) return 0;
        pmf *= own / (own + Importance(nodes_[sibling].cluster, ref));
    }
    return pmf;
}

std::unique_ptr<LightSampler> CreateBvhSampler(std::span<const Light* const> lights) {
    return std::make_unique<BvhLightSampler>(SampledLights(lights));
}

}  // namespace

LACQUER_REGISTER(LightSamplerKind, "bvh", CreateBvhSampler);

}  // namespace lacquer
