#include "capture/card/tags.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "capture/card/card.h"
#include "capture/card/tag_edges.h"
#include "pbrt/core/check.h"
#include "pbrt/image/operations.h"

namespace lacquer::capture {

namespace {

using Family = std::unique_ptr<apriltag_family_t, decltype(&tag36h11_destroy)>;

Family MakeFamily() { return {tag36h11_create(), tag36h11_destroy}; }

/// The library's detector with its family, one for each thread that detects.
class TagDetector {
  public:
    explicit TagDetector(Int2 resolution)
        : family_(MakeFamily()), detector_(apriltag_detector_create(), apriltag_detector_destroy) {
        // One wrong bit is mended. For two the library makes a table of 30 MB each time, and sees more false
        // tags.
        apriltag_detector_add_family_bits(detector_.get(), family_.get(), 1);
        detector_->nthreads = 1;
        // Quads are looked for in a smaller image if there are more pixels than that needs; edges are looked
        // for in the whole one afterwards.
        const int longest = std::max(resolution.x, resolution.y);
        detector_->quad_decimate = longest > 5000 ? 4 : longest > 2500 ? 2 : 1;
    }

    std::vector<DetectedTag> Detect(image_u8_t* bytes) const {
        zarray_t* found = apriltag_detector_detect(detector_.get(), bytes);
        std::vector<DetectedTag> tags;
        for (int i = 0; i < zarray_size(found); ++i) {
            apriltag_detection_t* detection = nullptr;
            zarray_get(found, i, &detection);
            DetectedTag& tag = tags.emplace_back();
            tag.id = detection->id;
            for (size_t c = 0; c < 4; ++c) tag.corners[c] = {detection->p[c][0], detection->p[c][1]};
        }
        apriltag_detections_destroy(found);
        return tags;
    }

  private:
    Family family_;  // the detector looks into it, and is destroyed first
    std::unique_ptr<apriltag_detector_t, decltype(&apriltag_detector_destroy)> detector_;
};

/// Bytes for the detector: square roots, so that tags far from the flash have contrast, of values up to one
/// that a hundredth of the pixels exceeds, lest a highlight makes all else black.
std::vector<uint8_t> BytesOf(const Image& grey) {
    std::vector<float> sorted = grey.Pixels();
    const auto high = sorted.begin() + std::ptrdiff_t(sorted.size() - 1 - sorted.size() / 100);
    std::nth_element(sorted.begin(), high, sorted.end());
    const float scale = *high > 0 ? 1 / *high : 0;
    std::vector<uint8_t> bytes;
    bytes.reserve(sorted.size());
    for (const float v : grey.Pixels())
        bytes.push_back(uint8_t(std::lround(255 * std::sqrt(std::clamp(v * scale, 0.F, 1.F)))));
    return bytes;
}

}  // namespace

TagCells CellsOfTag(int id) {
    const Family family = MakeFamily();
    LACQUER_CHECK(id >= 0 && id < int(family->ncodes));
    LACQUER_CHECK(family->width_at_border == kTagCells);
    TagCells cells;
    cells.fill(true);  // as the border is; the first bit is the highest one
    for (uint32_t i = 0; i < family->nbits; ++i)
        if (family->codes[id] >> (family->nbits - 1 - i) & 1)
            cells[size_t(family->bit_y[i]) * kTagCells + family->bit_x[i]] = false;
    return cells;
}

std::vector<int> TagDetection::Missing() const {
    std::vector<int> missing;
    for (int id = 0; id < kNumTags; ++id) {
        const bool isOne =
            std::any_of(tags.begin(), tags.end(), [&](const DetectedTag& t) { return t.id == id; });
        if (!isOne && std::find(twice.begin(), twice.end(), id) == twice.end()) missing.push_back(id);
    }
    return missing;
}

Image GreyOf(const Image& image) {
    const std::vector<int> colors = ColorChannels(image);
    const Int2 size = image.Resolution();
    Image grey(size, {"Y"});
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            float sum = 0;
            for (const int c : colors) sum += image.Get({x, y}, c);
            grey.Set({x, y}, 0, sum / float(colors.size()));
        }
    return grey;
}

TagDetection DetectTags(const Image& grey) {
    LACQUER_CHECK(grey.NumChannels() == 1);
    const Int2 size = grey.Resolution();
    TagDetection result;
    if (std::min(size.x, size.y) < 2 * kTagCells) return result;
    std::vector<uint8_t> bytes = BytesOf(grey);
    image_u8_t image = {.width = size.x, .height = size.y, .stride = size.x, .buf = bytes.data()};
    std::map<int, std::vector<DetectedTag>> byId;
    for (DetectedTag& tag : TagDetector(size).Detect(&image)) byId[tag.id].push_back(tag);
    for (auto& [id, tags] : byId) {
        if (id >= kNumTags)
            result.unknown.push_back(id);
        else if (tags.size() > 1)
            result.twice.push_back(id);
        else {
            RefineCorners(grey, kTagCells, &tags[0].corners);
            result.tags.push_back(tags[0]);
        }
    }
    return result;
}

}  // namespace lacquer::capture
