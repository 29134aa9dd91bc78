// A density over directions that is learned from samples.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

/// A quadtree over all directions, mapped to a square that keeps areas, and piecewise constant in its leaves
/// [Müller et al. 2017, sec. 3.1]. While it is sampled, threads may add what they find; Rebuild() makes that
/// the density. Sums are integers: the result does not depend on the order in which they were added.
class DirectionalTree {
  public:
    /// All directions alike.
    DirectionalTree();

    /// [1/sr], of what Sample() draws.
    float Pdf(Vec3 w) const { return leaves_[Find(w)].pdf; }
    struct Direction {
        Vec3 w;     ///< unit
        float pdf;  ///< [1/sr]
    };
    Direction Sample(Point2 u) const;

    /// By any thread, unless one is in Rebuild(). @param amount  not negative
    void Add(Vec3 w, int64_t amount) {
        std::atomic_ref(sums_[Find(w)]).fetch_add(amount, std::memory_order_relaxed);
    }
    /// The density becomes proportional to what was added to each leaf, if anything was; leaves with more
    /// than a fiftieth of it are divided and those with less are joined. Half of the sums stays: what is
    /// added from now on, after better densities, counts for more.
    void Rebuild();

    size_t NumLeaves() const { return leaves_.size() - 1; }

  private:
    /// A child is a node, or with this bit a leaf.
    static constexpr uint16_t kLeaf = 0x8000;
    /// The quadrants of a square: x and y above the middle add 1 and 2 to a number.
    using Node = std::array<uint16_t, 4>;
    /// Squares of single floats tell directions apart that far: what is drawn in a leaf must be found in it.
    static constexpr int kMaxDepth = 12;
    /// Trees are many more than caches hold, so a leaf has in one place what a draw needs of it.
    struct Leaf {
        float pdf = 0;     ///< [1/sr]
        float before = 0;  ///< probability of all leaves before it
        /// In units of 2^-kMaxDepth.
        std::array<uint16_t, 2> corner{};
        uint16_t side = 0;
    };
    struct Builder;

    size_t Find(Vec3 w) const;
    size_t IndexOf(float u, size_t from) const;
    /// Once all leaves are there.
    void EndLeaves();

    std::vector<Leaf> leaves_;   ///< and one more, for the end of the last one
    std::vector<Node> nodes_;    ///< first the root
    std::vector<int64_t> sums_;  ///< of leaves

    /// What has each square of a grid as fine as the tree is at this depth, so that most steps of Find() are
    /// one: children.
    static constexpr int kGridDepth = 4, kGridSide = 1 << kGridDepth;
    std::array<uint16_t, kGridSide * kGridSide> grid_{};
    /// The first leaf that can be drawn by each part of the numbers below 1, from which few steps are left.
    static constexpr int kParts = 64;
    std::array<uint16_t, kParts> firstOf_{};
};

}  // namespace lacquer
