// Which samples of which pixels of a render have been given out, and which have come in.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "mpi/messenger.h"
#include "pbrt/core/vec.h"

namespace lacquer::cmd {

/// A part of a render: samples [first, end) of all of some pixels.
struct RenderUnit {
    Bounds2i pixels;
    int first = 0, end = 0;
    int64_t Samples() const { return int64_t(pixels.Area()) * (end - first); }
};

/// Where units of work come from. The image is cut into boxes of pixels. Units of a box are given out one
/// range of samples after another, and their results count in this order, whichever way they come in: so
/// each pixel has at any time the first of its samples without a gap, and the state is one that any render
/// can go on from. What comes in too early waits.
class UnitLedger {
  public:
    /// @param taken  samples of each pixel that are there already, counted from `first`: rows from the top
    /// @param side   of a box
    UnitLedger(const Bounds2i& pixels, const std::vector<int>& taken, int first, int end, int side);

    /// The next unit, of about so many samples, of a box with the fewest samples. Nothing once all are given
    /// out, or until some of those that are out have come in.
    std::optional<RenderUnit> Next(int64_t samples);

    /// A result, and what can be added of it and of those that waited, in this order.
    struct Result {
        RenderUnit unit;
        mpi::Bytes state;
    };
    std::vector<Result> ComeIn(Result result);

    /// Samples that nobody has been given yet.
    int64_t Left() const { return left_; }
    bool IsDone() const { return missing_ == 0; }
    /// Bytes of results that came in too early.
    size_t WaitingBytes() const { return waitingBytes_; }

  private:
    struct Box {
        Bounds2i pixels;
        int given = 0, added = 0;             ///< ends of samples
        std::vector<RenderUnit> uneven = {};  ///< to be given out before others
        size_t numUneven = 0;                 ///< that have not come in
        std::map<int, Result> waiting = {};   ///< by the first sample
    };
    void AddBox(const Bounds2i& pixels, const std::vector<int>& taken);
    /// The box that a unit is of.
    size_t BoxOf(const RenderUnit& unit) const;

    Bounds2i pixels_;
    int first_, end_, side_, columns_;
    std::vector<Box> boxes_;                 ///< rows from the top
    std::vector<size_t> unevenBoxes_;        ///< with units in `uneven`
    std::set<std::pair<int, size_t>> open_;  ///< given samples, and number, of boxes with more to give
    int64_t left_ = 0, missing_ = 0;         ///< samples not given out; not come in
    size_t waitingBytes_ = 0;
};

/// Boxes of pixels that each have one number of samples, as few as halving finds. Appends to `units` those
/// that have fewer than `end`, up to there. @param taken  of the pixels of `whole`, rows from the top
void LevelUnits(const Bounds2i& pixels, const Bounds2i& whole, const std::vector<int>& taken, int first,
                int end, std::vector<RenderUnit>* units);

/// Side of the boxes of a render. @param bytes  that a pixel's sums take
int BoxSide(const Bounds2i& pixels, int ranks, size_t bytes);

}  // namespace lacquer::cmd
