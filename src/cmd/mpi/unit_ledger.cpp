#include "cmd/mpi/unit_ledger.h"

#include <algorithm>

#include "pbrt/core/check.h"

namespace lacquer::cmd {
namespace {

/// Sides of boxes, and the bytes of the sums of one.
constexpr int kMaxSide = 128, kMinSide = 32;
constexpr size_t kMaxBoxBytes = size_t(16) << 20;
/// Samplers compute so many samples of a pixel at once.
constexpr int kBlock = 8;
/// Bytes of results that may wait: then nothing is given out but what they wait for.
constexpr size_t kMaxWaiting = size_t(1) << 30;

/// Least and largest number of samples among some pixels.
std::pair<int, int> SpanOf(const Bounds2i& pixels, const Bounds2i& whole, const std::vector<int>& taken) {
    std::pair<int, int> span{taken[size_t(pixels.min.y - whole.min.y) * size_t(whole.Width()) +
                                   size_t(pixels.min.x - whole.min.x)],
                             0};
    for (int y = pixels.min.y; y < pixels.max.y; ++y)
        for (int x = pixels.min.x; x < pixels.max.x; ++x) {
            const int count =
                taken[size_t(y - whole.min.y) * size_t(whole.Width()) + size_t(x - whole.min.x)];
            span = {std::min(span.first, count), std::max(span.second, count)};
        }
    return span;
}

}  // namespace

void LevelUnits(const Bounds2i& pixels, const Bounds2i& whole, const std::vector<int>& taken, int first,
                int end, std::vector<RenderUnit>* units) {
    const auto [least, most] = SpanOf(pixels, whole, taken);
    if (least == most) {
        if (first + least < end) units->push_back({pixels, first + least, end});
        return;
    }
    Bounds2i a = pixels, b = pixels;
    const int axis = pixels.Width() > pixels.Height() ? 0 : 1;
    a.max[axis] = b.min[axis] = (pixels.min[axis] + pixels.max[axis]) / 2;
    LevelUnits(a, whole, taken, first, end, units);
    LevelUnits(b, whole, taken, first, end, units);
}

int BoxSide(const Bounds2i& pixels, int ranks, size_t bytes) {
    const auto fits = [&](int side) {
        const int64_t boxes =
            int64_t((pixels.Width() + side - 1) / side) * ((pixels.Height() + side - 1) / side);
        return boxes >= 4 * int64_t(ranks) && size_t(side) * size_t(side) * bytes <= kMaxBoxBytes;
    };
    int side = kMaxSide;
    while (side > kMinSide && !fits(side)) side /= 2;
    return side;
}

UnitLedger::UnitLedger(const Bounds2i& pixels, const std::vector<int>& taken, int first, int end, int side)
    : pixels_(pixels), first_(first), end_(end), side_(side), columns_((pixels.Width() + side - 1) / side) {
    for (int y = pixels.min.y; y < pixels.max.y; y += side)
        for (int x = pixels.min.x; x < pixels.max.x; x += side)
            AddBox(Bounds2i{{x, y}, {x + side, y + side}}.Intersect(pixels), taken);
}

void UnitLedger::AddBox(const Bounds2i& pixels, const std::vector<int>& taken) {
    const int most = std::min(first_ + SpanOf(pixels, pixels_, taken).second, end_);
    Box box{pixels, most, most};
    LevelUnits(pixels, pixels_, taken, first_, most, &box.uneven);
    box.numUneven = box.uneven.size();
    left_ += RenderUnit{pixels, most, end_}.Samples();
    for (const RenderUnit& unit : box.uneven) left_ += unit.Samples();
    missing_ = left_;
    if (!box.uneven.empty())
        unevenBoxes_.push_back(boxes_.size());
    else if (most < end_)
        open_.emplace(most, boxes_.size());
    boxes_.push_back(std::move(box));
}

std::optional<RenderUnit> UnitLedger::Next(int64_t samples) {
    if (!unevenBoxes_.empty()) {
        Box& box = boxes_[unevenBoxes_.back()];
        const RenderUnit unit = box.uneven.back();
        box.uneven.pop_back();
        if (box.uneven.empty()) unevenBoxes_.pop_back();
        left_ -= unit.Samples();
        return unit;
    }
    if (open_.empty()) return {};
    const auto [given, number] = *open_.begin();
    Box& box = boxes_[number];
    if (waitingBytes_ > kMaxWaiting && given > box.added) return {};
    open_.erase(open_.begin());
    // As passes of a render do: the whole image is there soon, and boxes differ little.
    const int taken = given - first_, most = taken == 0 ? kBlock : 3 * taken;
    int64_t end = given + std::clamp<int64_t>(samples / box.pixels.Area(), 1, most);
    if (end - given >= kBlock) end -= (end - first_) % kBlock;
    box.given = int(std::min<int64_t>(end, end_));
    if (box.given < end_) open_.emplace(box.given, number);
    const RenderUnit unit{box.pixels, given, box.given};
    left_ -= unit.Samples();
    return unit;
}

size_t UnitLedger::BoxOf(const RenderUnit& unit) const {
    const Int2 place = (unit.pixels.min - pixels_.min) / side_;
    return size_t(place.y) * size_t(columns_) + size_t(place.x);
}

std::vector<UnitLedger::Result> UnitLedger::ComeIn(Result result) {
    std::vector<Result> ready;
    const size_t number = BoxOf(result.unit);
    Box& box = boxes_[number];
    missing_ -= result.unit.Samples();
    if (box.numUneven > 0) {
        // While a box is uneven nothing else of it is given out.
        ready.push_back(std::move(result));
        if (--box.numUneven == 0 && box.given < end_) open_.emplace(box.given, number);
        return ready;
    }
    waitingBytes_ += result.state.size();
    const int first = result.unit.first;
    LACQUER_CHECK(box.waiting.emplace(first, std::move(result)).second);
    for (auto next = box.waiting.find(box.added); next != box.waiting.end();
         next = box.waiting.find(box.added)) {
        box.added = next->second.unit.end;
        waitingBytes_ -= next->second.state.size();
        ready.push_back(std::move(next->second));
        box.waiting.erase(next);
    }
    return ready;
}

}  // namespace lacquer::cmd
