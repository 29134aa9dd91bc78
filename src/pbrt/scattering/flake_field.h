// Flakes strewn over a plane, found by counting and stored nowhere.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "pbrt/core/rng.h"

namespace lacquer {

/// A flake. Lengths are in tiles of the field.
struct Flake {
    Vec2 offset{0};  ///< of its centre from that of the window in which it was found
    /// Where its normal stands in the distribution of normals: the share of the normals that are less steep,
    /// and the azimuth in turns. Both uniform in [0,1).
    float radial = 0, turn = 0;
    uint64_t bits = 0;  ///< random bits of its own, for whatever else differs from flake to flake
};

/// A part of the plane: an ellipse. Lengths are in tiles of the field.
class FlakeWindow {
  public:
    /// @param x, y          the centre
    /// @param axisA, axisB  half axes, perpendicular to each other and not 0
    FlakeWindow(double x, double y, Vec2 axisA, Vec2 axisB)
        : x_(x),
          y_(y),
          toDiscA_(axisA / Dot(axisA, axisA)),
          toDiscB_(axisB / Dot(axisB, axisB)),
          extent_(std::sqrt(axisA.x * axisA.x + axisB.x * axisB.x),
                  std::sqrt(axisA.y * axisA.y + axisB.y * axisB.y)) {}
    double X() const { return x_; }
    double Y() const { return y_; }
    /// Half of the sides of the box around it.
    Vec2 Extent() const { return extent_; }
    /// @param offset  from the centre
    bool Contains(Vec2 offset) const { return Sqr(Dot(offset, toDiscA_)) + Sqr(Dot(offset, toDiscB_)) < 1; }

  private:
    double x_, y_;
    Vec2 toDiscA_, toDiscB_, extent_;
};

/// A box of normals, as Flake has them.
struct FlakeNormals {
    float radialLow = 0, radialHigh = 1;
    float turn = 0.5f, halfTurn = 1;  ///< the middle and half of the width of the azimuths; they wrap around

    /// True if azimuths in [low, high] within [0,1] may belong to it.
    bool OverlapsTurns(float low, float high) const {
        const float middle = 0.5f * (low + high), distance = std::abs(middle - turn);
        return std::min(distance, 1 - distance) <= halfTurn + 0.5f * (high - low);
    }
};

/// Infinitely many flakes, independent of each other and uniform in position and normal (both of which have
/// two dimensions). The plane is cut into square tiles; how many flakes a tile has follows from a hash, and
/// so does how many of them lie in each half of the tile, of the normals, and so on in turn: a tree in four
/// dimensions that is made where it is looked at [Jakob et al. 2014, sec. 5]. A flake is where it is whoever
/// looks at it, at whatever scale. The halves share n flakes by n fair coins, the bits of hashes, which is
/// exact. (Jakob et al. approximate the counts of large nodes.)
///
/// Cost of a query: some 10 ns for each node visited; those are the ones that the window and the normals
/// touch, down to a few flakes each. No memory.
class FlakeField {
  public:
    /// The mean number of flakes in a tile: half of as many coins. Independent flakes would vary by the root
    /// of the mean, these vary by 1/sqrt(2) of that from tile to tile, and as independent ones do in small
    /// parts of a tile.
    static constexpr int kMeanPerTile = 256;

    explicit FlakeField(uint64_t seed) : seed_(seed) {}

    /// Calls visit(flake) for each flake in the window whose normal is in the box.
    template <class Visit>
    void ForEach(const FlakeWindow& window, const FlakeNormals& normals, Visit&& visit) const;
    /// How many flakes the window has.
    int Count(const FlakeWindow& window) const;
    /// The flake of an index in [0, Count(window)).
    Flake Pick(const FlakeWindow& window, int index) const;

  private:
    static constexpr int kLeafFlakes = 3;
    static constexpr int kMaxDepth = 64;  ///< nodes as small as floats can tell, whatever they hold

    /// A box in four dimensions: x, radial, y, turn, halved in this order.
    struct Node {
        uint64_t key;
        int count, depth;
        std::array<float, 4> low;  ///< x and y from the centre of the window

        float Extent(int axis) const {
            return std::bit_cast<float>(uint32_t(127 - (depth + 3 - axis) / 4) << 23);  // 2^-halvings
        }
        bool IsLeaf() const { return count <= kLeafFlakes || depth >= kMaxDepth; }
    };

    static int CountHeads(uint64_t key, int coins);
    static Flake FlakeOf(const Node& leaf, int index);
    /// The halves of a node.
    static void Split(const Node& node, Node* lower, Node* upper);
    static bool IsNear(const Node& node, const FlakeWindow& window) {
        const Vec2 extent = window.Extent();
        return node.low[0] < extent.x && node.low[0] + node.Extent(0) > -extent.x && node.low[2] < extent.y &&
               node.low[2] + node.Extent(2) > -extent.y;
    }
    static bool IsWithin(const Node& node, const FlakeWindow& window) {
        const float x0 = node.low[0], y0 = node.low[2], x1 = x0 + node.Extent(0), y1 = y0 + node.Extent(2);
        return window.Contains({x0, y0}) && window.Contains({x1, y0}) && window.Contains({x0, y1}) &&
               window.Contains({x1, y1});
    }
    static bool Overlaps(const Node& node, const FlakeNormals& normals) {
        return node.low[1] <= normals.radialHigh && node.low[1] + node.Extent(1) >= normals.radialLow &&
               normals.OverlapsTurns(node.low[3], node.low[3] + node.Extent(3));
    }
    /// Goes down the trees of the tiles that the window touches. take(node) says whether the node's halves
    /// are to be visited.
    template <class Take>
    void Descend(const FlakeWindow& window, Take&& take) const;

    uint64_t seed_;
};

// The binomial distribution of fair coins is that of the ones among random bits.
inline int FlakeField::CountHeads(uint64_t key, int coins) {
    int heads = 0;
    for (; coins > 64; coins -= 64) heads += std::popcount(MixBits(key += 0x9e3779b97f4a7c15ull));
    const uint64_t bits = MixBits(key + 0x9e3779b97f4a7c15ull);
    return heads + (coins > 0 ? std::popcount(bits >> (64 - coins)) : 0);
}

inline void FlakeField::Split(const Node& node, Node* lower, Node* upper) {
    const int axis = node.depth % 4;
    const int heads = CountHeads(node.key, node.count);
    *lower = {MixBits(node.key ^ 0xd1b54a32d192ed03ull), heads, node.depth + 1, node.low};
    *upper = {MixBits(node.key ^ 0x8cb92ba72f3d8dd7ull), node.count - heads, node.depth + 1, node.low};
    upper->low[size_t(axis)] += upper->Extent(axis);
}

inline Flake FlakeField::FlakeOf(const Node& leaf, int index) {
    const uint64_t a = MixBits(leaf.key + uint64_t(index + 1) * 0x9e3779b97f4a7c15ull),
                   b = MixBits(a ^ leaf.key);
    const auto lower = [](uint64_t bits) { return float((bits >> 16) & 0xffffff) * 0x1p-24f; };
    return {.offset = {leaf.low[0] + leaf.Extent(0) * UnitFloat(a), leaf.low[2] + leaf.Extent(2) * lower(a)},
            .radial = std::min(leaf.low[1] + leaf.Extent(1) * UnitFloat(b), 0x1.fffffep-1f),
            .turn = leaf.low[3] + leaf.Extent(3) * lower(b),
            .bits = MixBits(b)};
}

template <class Take>
void FlakeField::Descend(const FlakeWindow& window, Take&& take) const {
    const Vec2 extent = window.Extent();
    const double firstX = std::floor(window.X() - double(extent.x)),
                 firstY = std::floor(window.Y() - double(extent.y));
    for (double y = firstY; y < window.Y() + double(extent.y); ++y)
        for (double x = firstX; x < window.X() + double(extent.x); ++x) {
            const uint64_t key = Hash(seed_, x, y);
            // Each halving adds at most one node that waits.
            std::array<Node, kMaxDepth + 2> waiting;
            waiting[0] = {key,
                          CountHeads(~key, 2 * kMeanPerTile),
                          0,
                          {float(x - window.X()), 0, float(y - window.Y()), 0}};
            for (size_t size = 1; size > 0;) {
                const Node node = waiting[--size];
                if (node.count == 0 || !IsNear(node, window) || !take(node)) continue;
                Split(node, &waiting[size + 1], &waiting[size]);  // the lower half is next
                size += 2;
            }
        }
}

template <class Visit>
void FlakeField::ForEach(const FlakeWindow& window, const FlakeNormals& normals, Visit&& visit) const {
    Descend(window, [&](const Node& node) {
        if (!Overlaps(node, normals)) return false;
        if (!node.IsLeaf()) return true;
        for (int i = 0; i < node.count; ++i)
            if (const Flake flake = FlakeOf(node, i); window.Contains(flake.offset)) visit(flake);
        return false;
    });
}

}  // namespace lacquer
