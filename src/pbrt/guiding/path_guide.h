// Path guiding: where in a scene light comes from, learned from paths [Müller et al. 2017; Vorba et al.
// 2019].
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "pbrt/core/vec.h"
#include "pbrt/guiding/directional_tree.h"

namespace lacquer {

/// What a vertex of a path scatters by. Each kind has its own share of learned directions: they are worth
/// most where scattering prefers none.
enum class GuidedKind { Diffuse, Glossy, Volume };
inline constexpr int kNumGuidedKinds = 3;

/// What is guided apart from what else is at the same place: surfaces by the side to which they face most, so
/// that neither two walls of a corner nor the sides of one take part in each other's light; and volumes.
enum class GuidedFacing { RightX, LeftX, UpY, DownY, FrontZ, BackZ, Volume };
inline constexpr int kNumGuidedFacings = 7;
/// @param n  normal, on the side of wo
GuidedFacing FacingOf(Vec3 n);

/// A part of a scene: from where light comes to it, and how much of that its vertices should go by.
class alignas(64) GuideCell {
  public:
    /// @param number  in its PathGuide
    explicit GuideCell(size_t number) : number_(number) { scatteringShare_.fill(1); }

    const DirectionalTree& Directions() const { return directions_; }
    /// Probability of drawing by scattering alone; 1: nothing is gained by what was learned.
    float ScatteringShare(GuidedKind kind) const { return scatteringShare_[size_t(kind)]; }

  private:
    friend class PathGuide;
    /// Shares of scattering among which each cell and kind takes the best one. Less than the first makes
    /// paths of great weight where what was learned is wrong.
    static constexpr std::array<float, 4> kShares{0.2f, 0.35f, 0.6f, 1};
    /// The light that vertices found, and for each share that times the logarithm of how much more densely it
    /// would have drawn the same.
    struct Evidence {
        int64_t light = 0;
        std::array<int64_t, kShares.size()> gains{};
    };

    /// Takes the best shares, and makes a density of the light.
    void EndPass(bool isLast);
    bool IsUsed() const;

    // What every vertex reads comes first, so that it is in one or two lines of a cache.
    std::array<float, kNumGuidedKinds> scatteringShare_;
    DirectionalTree directions_;
    size_t number_;
    std::array<Evidence, kNumGuidedKinds> evidence_;
    int64_t numVertices_ = 0;
    int64_t sumScattered_ = 0;  ///< light that vertices scattered, without that of their light samples
    double meanScattered_ = 0;  ///< of the last pass, a vertex; in units
    bool hasLearned_ = false;
};

/// A mixture of the densities of scattering and of a cell; of scattering alone where there is no cell.
class GuidedDensity {
  public:
    GuidedDensity() = default;
    /// @param cell  outlives it
    GuidedDensity(const GuideCell& cell, GuidedKind kind)
        : cell_(&cell), scatteringShare_(cell.ScatteringShare(kind)), kind_(kind) {}

    explicit operator bool() const { return cell_; }
    const GuideCell& Cell() const { return *cell_; }
    GuidedKind Kind() const { return kind_; }
    float ScatteringShare() const { return scatteringShare_; }
    /// [1/sr], of the cell.
    float Learned(Vec3 wi) const { return cell_->Directions().Pdf(wi); }
    /// [1/sr], of both. @param scattering  [1/sr], a float or a spectrum of them
    template <class Density>
    Density Of(Density scattering, float learned) const {
        return scatteringShare_ * scattering + Density((1 - scatteringShare_) * learned);
    }
    template <class Density>
    Density At(Density scattering, Vec3 wi) const {
        return cell_ ? Of(scattering, scatteringShare_ < 1 ? Learned(wi) : 0.f) : scattering;
    }

  private:
    const GuideCell* cell_ = nullptr;
    float scatteringShare_ = 1;
    GuidedKind kind_ = GuidedKind::Diffuse;
};

/// A direction that was drawn at a vertex, and what the path had come to then.
struct GuidedVertex {
    Vec3 wi;
    float cosine = 1;  ///< between wi and the normal of a surface
    GuidedDensity density;
    float scattering = 0;  ///< density of drawing wi by scattering [1/sr]; for specular lobes not 0
    float learned = 0;     ///< by the cell [1/sr]; 0 for specular lobes
    bool isSpecular = false;
    /// Throughput before it was drawn and after that, and light found before: means over the wavelengths.
    double throughputBefore = 0, throughput = 0, found = 0;
};

/// The vertices of a path, as long as it is followed; of long ones the first.
class GuidedPath {
  public:
    void Add(const GuidedVertex& vertex) {
        if (size_ < vertices_.size()) vertices_[size_++] = vertex;
    }
    size_t size() const { return size_; }
    const GuidedVertex& operator[](size_t i) const { return vertices_[i]; }

  private:
    std::array<GuidedVertex, 32> vertices_;
    size_t size_ = 0;
};

/// Cells of a scene, each with a density of directions. They are learned in passes of growing length: within
/// one, paths use what the passes before have learned, and add what they find by themselves. What comes of it
/// depends on the paths alone, not on threads.
///
/// The light that a vertex is said to receive is what the path finds at the next vertex, and beyond that what
/// vertices near the next one have found on average: much less noise than what one path finds in all [Dahm
/// and Keller 2017]. It counts with the cosine.
class PathGuide {
  public:
    /// @param bounds  of all surfaces
    explicit PathGuide(const Bounds3& bounds);

    bool IsLearning() const { return isLearning_; }
    /// Between passes: paths use what was learned, but add nothing to it, until it goes on.
    void SetLearning(bool isLearning) { isLearning_ = isLearning; }
    /// What a vertex draws by. Empty where the cell has nothing to say, but for a pass that learns.
    GuidedDensity At(Point3 p, GuidedFacing facing, GuidedKind kind) const;
    /// By any thread, of a pass that learns. @param found  light of the whole path, mean over the wavelengths
    void Learn(const GuidedPath& path, float found);
    /// Between passes. @param isLast  what was learned is used from now on, and stays as it is
    void EndPass(bool isLast);

    size_t NumCells() const { return cells_.size(); }
    /// False after the last pass if no cell has anything to say.
    bool IsUsed() const { return isUsed_; }

  private:
    /// A box of the scene: divided in the middle, or a cell.
    struct Node {
        int first = 0;  ///< of two nodes, the lower half first; or ~ the number of a cell
    };

    GuideCell& CellOf(const GuidedVertex& vertex) { return cells_[vertex.density.Cell().number_]; }
    int64_t Units(double light) const;
    void LearnUnit(double incident);
    void LearnVertex(const GuidedVertex& vertex, double light, GuideCell* cell) const;
    void LearnShare(const GuidedVertex& vertex, float pdf, int64_t scattered, GuideCell* cell) const;
    void SetUnit();
    /// Divides what has more than `most` vertices. @param vertices  of the node; negative: its cell knows
    void Divide(int node, int depth, double most, double vertices = -1);

    /// For At(): what is reached in each box of a grid, as Node has it.
    void MakeGrid();
    static constexpr int kGridDepth = 3, kGridSide = 1 << kGridDepth;
    std::array<std::array<int, kGridSide * kGridSide * kGridSide>, kNumGuidedFacings> grid_;

    Point3 corner_;
    float scale_;              ///< from lengths of the scene to parts of its cube
    std::vector<Node> nodes_;  ///< first the root of each facing
    std::vector<GuideCell> cells_;
    bool isLearning_ = true, isUsed_ = true;
    int pass_ = 0;
    double perUnit_ = 0;                     ///< units of the sums in light; 0: not known yet
    std::array<int64_t, 256> magnitudes_{};  ///< vertices by the binary exponent of the light they found
};

}  // namespace lacquer
