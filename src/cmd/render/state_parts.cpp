#include "cmd/render/state_parts.h"

#include <fmt/format.h>

#include <optional>

namespace lacquer::cmd {
namespace {

SampleBox SurelyIn(const StatePart& part) { return {part.pixels, part.first, part.first + part.least}; }
SampleBox MaybeIn(const StatePart& part) { return {part.pixels, part.first, part.first + part.most}; }

/// What is left of `box` without `hole`, which lies in it: before and behind its samples, then above, below,
/// left and right of its pixels.
void Subtract(const SampleBox& box, const SampleBox& hole, std::vector<SampleBox>* rest) {
    const auto add = [&](const SampleBox& b) {
        if (!b.IsEmpty()) rest->push_back(b);
    };
    const Int2 b0 = box.pixels.min, b1 = box.pixels.max, h0 = hole.pixels.min, h1 = hole.pixels.max;
    add({box.pixels, box.first, hole.first});
    add({box.pixels, hole.end, box.end});
    add({{b0, {b1.x, h0.y}}, hole.first, hole.end});
    add({{{b0.x, h1.y}, b1}, hole.first, hole.end});
    add({{{b0.x, h0.y}, {h0.x, h1.y}}, hole.first, hole.end});
    add({{{h1.x, h0.y}, {b1.x, h1.y}}, hole.first, hole.end});
}

/// Of two parts with the same samples, the pixels of both where these are a rectangle, `a` left or above.
std::optional<Bounds2i> JoinedPixels(const Bounds2i& a, const Bounds2i& b) {
    const bool isBeside = a.min.y == b.min.y && a.max.y == b.max.y && a.max.x == b.min.x;
    const bool isAbove = a.min.x == b.min.x && a.max.x == b.max.x && a.max.y == b.min.y;
    if (!isBeside && !isAbove) return {};
    return Bounds2i{a.min, b.max};
}

std::optional<StatePart> Joined(const StatePart& a, const StatePart& b) {
    if (a.least != a.most || b.least != b.most) return {};
    if (a.pixels == b.pixels && a.first + a.least == b.first)
        return StatePart{a.pixels, a.first, a.least + b.least, a.least + b.least};
    if (a.first != b.first || a.least != b.least) return {};
    if (const auto pixels = JoinedPixels(a.pixels, b.pixels))
        return StatePart{*pixels, a.first, a.least, a.least};
    return {};
}

}  // namespace

SampleBox SharedSamples(const StatePart& a, const StatePart& b) { return MaybeIn(a).Intersect(MaybeIn(b)); }

std::vector<SampleBox> MissingSamples(const std::vector<StatePart>& parts, const SampleBox& whole) {
    std::vector<SampleBox> missing = {whole};
    for (const StatePart& part : parts) {
        std::vector<SampleBox> rest;
        for (const SampleBox& box : missing) {
            const SampleBox hole = box.Intersect(SurelyIn(part));
            if (hole.IsEmpty())
                rest.push_back(box);
            else
                Subtract(box, hole, &rest);
        }
        missing = std::move(rest);
    }
    return missing;
}

void AddPart(StatePart part, std::vector<StatePart>* parts) {
    for (size_t i = 0; i < parts->size(); ++i) {
        std::optional<StatePart> joined = Joined((*parts)[i], part);
        if (!joined) joined = Joined(part, (*parts)[i]);
        if (!joined) continue;
        // What it has become may fit to one that it did not fit to before.
        part = *joined;
        parts->erase(parts->begin() + ptrdiff_t(i));
        AddPart(part, parts);
        return;
    }
    parts->push_back(part);
}

std::string SamplesInWords(const SampleBox& box, const Bounds2i& whole) {
    const std::string samples = box.end - box.first == 1
                                    ? fmt::format("sample {}", box.first)
                                    : fmt::format("samples {} to {}", box.first, box.end - 1);
    if (box.pixels == whole) return samples + " of all pixels";
    return fmt::format("{} of the pixels x {}..{}, y {}..{}", samples, box.pixels.min.x, box.pixels.max.x - 1,
                       box.pixels.min.y, box.pixels.max.y - 1);
}

std::string SamplesInWords(const std::vector<SampleBox>& boxes, const Bounds2i& whole) {
    constexpr size_t kShown = 3;
    std::string text;
    for (size_t i = 0; i < std::min(boxes.size(), kShown); ++i)
        text += (i > 0 ? "; " : "") + SamplesInWords(boxes[i], whole);
    if (boxes.size() > kShown) text += fmt::format("; and {} more", boxes.size() - kShown);
    return text;
}

}  // namespace lacquer::cmd
