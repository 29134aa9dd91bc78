// Which samples of which pixels states hold: what is double among them, and what is missing.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer::cmd {

/// The samples [first, first + least) of all of some pixels. Where a render was stopped amid a pass, some of
/// them have more, up to first + most.
struct StatePart {
    Bounds2i pixels;
    int first = 0, least = 0, most = 0;
};

/// The samples [first, end) of all of some pixels.
struct SampleBox {
    Bounds2i pixels;
    int first = 0, end = 0;
    bool IsEmpty() const { return pixels.IsEmpty() || end <= first; }
    SampleBox Intersect(const SampleBox& o) const {
        return {pixels.Intersect(o.pixels), std::max(first, o.first), std::min(end, o.end)};
    }
};

/// What two parts both hold; empty if they share nothing.
SampleBox SharedSamples(const StatePart& a, const StatePart& b);
/// What no part has of `whole`, in boxes.
std::vector<SampleBox> MissingSamples(const std::vector<StatePart>& parts, const SampleBox& whole);
/// Adds a part to others, with which it becomes one where the two make a box.
void AddPart(StatePart part, std::vector<StatePart>* parts);

/// "samples 8 to 15 of all pixels", "sample 3 of the pixels x 0..31, y 8..15". @param whole  all pixels
std::string SamplesInWords(const SampleBox& box, const Bounds2i& whole);
/// Of some boxes, the first few and how many more.
std::string SamplesInWords(const std::vector<SampleBox>& boxes, const Bounds2i& whole);

}  // namespace lacquer::cmd
