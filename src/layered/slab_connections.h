// Connections of two walks at vertices inside slabs, eight at a time. It is what ConnectionWalk does one by
// one, for the phase function of Henyey and Greenstein: there a connection is arithmetic without branches.
// The vertices of the camera's walk wait until there are eight, or until it has ended, and then each vertex
// of the light's walk is joined to all of them. Lanes are full that way: the light's walk is too short to
// fill them, and eight of its vertices against one of the camera's takes longer than to go one by one.
#pragma once

#include <array>
#include <limits>

#include "layered/stack.h"

namespace lacquer::layered {

/// A direction that one side has drawn, which may lead to a vertex inside a slab. Notation and weights are
/// those of connection_walk.h. @tparam Float, Int  numbers, or lanes of them
template <class Float, class Int>
struct DrawnDirection {
    Float wx, wy, wz;
    Float start;         ///< depth in the slab that it leads into
    Float startsInside;  ///< 1: at a vertex in that slab; 0: at a boundary
    Float extinction;    ///< per depth, which is 1 / |cos|
    Float pdf;           ///< of the direction
    Float otherSamples;  ///< 1 if the other side may have drawn it, else 0
    Float shorter;       ///< the sum over the strategies that cut this side shorter
    Int slab, count;     ///< slab; vertices of the walk
    std::array<Float, kNumWavelengths> beta;
};

/// A vertex inside a slab that a direction of the other side may lead to.
template <class Float, class Int>
struct InsideVertex {
    Float wx, wy, wz;  ///< where the walk came from
    Float x;           ///< depth
    /// The sum over the strategies that cut this side shorter is ownTerm + pdf * otherTerm, pdf being that of
    /// the phase function.
    Float ownTerm, otherTerm;
    Int slab, count;
    std::array<Float, kNumWavelengths> beta;
};

/// Vertices of a camera's walk, one in each lane, and the sum of the light that connections to them find.
class SlabConnections {
  public:
    static constexpr size_t kLanes = 8;
    /// One number for each lane.
    struct alignas(4 * kLanes) Floats : std::array<float, kLanes> {};
    struct alignas(4 * kLanes) Ints : std::array<int, kLanes> {};
    using Direction = DrawnDirection<float, int>;
    using Vertex = InsideVertex<float, int>;

    /// True if vertices in such a slab can be connected here.
    static bool Knows(const Slab& slab) { return slab.Scatters() && slab.GetHenyeyGreenstein(); }

    /// Sets up, to be called before anything else: some walks need nothing of this, and none of its time.
    void Clear() {
        // No sum may come from what memory held before.
        drawn_ = {};
        inside_ = {};
        sum_ = {};
        Restart();
    }
    bool IsFull() const { return numLanes_ == kLanes; }
    /// Empties all lanes.
    void Restart() {
        numLanes_ = 0;
        drawn_.slab.fill(-1);  // where no vertex is
        inside_.slab.fill(-1);
    }
    /// Begins the lane of the next vertex of the camera's walk; some lane must be empty.
    void StartLane() { ++numLanes_; }
    /// What is in that lane: a direction that leads into a slab, a vertex in one, both, or nothing.
    void SetDirection(const Direction& d) {
        const size_t lane = numLanes_ - 1;
        drawn_.wx[lane] = d.wx;
        drawn_.wy[lane] = d.wy;
        drawn_.wz[lane] = d.wz;
        drawn_.start[lane] = d.start;
        drawn_.startsInside[lane] = d.startsInside;
        drawn_.extinction[lane] = d.extinction;
        drawn_.pdf[lane] = d.pdf;
        drawn_.otherSamples[lane] = d.otherSamples;
        drawn_.shorter[lane] = d.shorter;
        drawn_.slab[lane] = d.slab;
        drawn_.count[lane] = d.count;
        for (size_t c = 0; c < kNumWavelengths; ++c) drawn_.beta[c][lane] = d.beta[c];
    }
    void SetVertex(const Vertex& v) {
        const size_t lane = numLanes_ - 1;
        inside_.wx[lane] = v.wx;
        inside_.wy[lane] = v.wy;
        inside_.wz[lane] = v.wz;
        inside_.x[lane] = v.x;
        inside_.ownTerm[lane] = v.ownTerm;
        inside_.otherTerm[lane] = v.otherTerm;
        inside_.slab[lane] = v.slab;
        inside_.count[lane] = v.count;
        for (size_t c = 0; c < kNumWavelengths; ++c) inside_.beta[c][lane] = v.beta[c];
    }

    /// Adds strategies (s, 1): the camera's directions, to a vertex of the light's in `slab`. One of the two
    /// throughputs has the slab's Scattering() in it.
    /// @param slab         a known one
    /// @param maxVertices  of a path
    void ConnectTo(const Vertex& light, const Slab& slab, int maxVertices);
    /// Adds strategies (s, 0): a direction of the light's, into `slab`, to the camera's vertices there.
    void ConnectFrom(const Direction& light, const Slab& slab, int maxVertices);
    SampledSpectrum Sum() const {
        SampledSpectrum sum;
        for (size_t c = 0; c < kNumWavelengths; ++c) {
            const Floats& x = sum_[c];
            sum.Set(int(c), ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7])));
        }
        return sum;
    }

  private:
    DrawnDirection<Floats, Ints> drawn_;
    InsideVertex<Floats, Ints> inside_;
    std::array<Floats, kNumWavelengths> sum_;
    size_t numLanes_;
};

}  // namespace lacquer::layered
