#include "capture/card/card.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "capture/card/tags.h"
#include "pbrt/core/check.h"

namespace lacquer::capture {

namespace {

/// Width of lines [units]: 0.1 mm of a card of 17 cm.
constexpr double kHairLine = 0.01;

CardRect RectOf(double x0, double y0, double x1, double y1) { return {{x0, y0}, {x1, y1}}; }

void CheckCardSize(double size) {
    if (!(size >= kMinCardSize && size <= kMaxCardSize))
        throw std::invalid_argument(fmt::format("a card of {} cm cannot be drawn; expected {} to {} cm", size,
                                                kMinCardSize, kMaxCardSize));
}

/// A path of all rectangles: parts of one path have no seams between them, wherever pixels begin.
std::string SvgPath(const std::vector<CardRect>& rects, double mmPerUnit) {
    std::string data;
    for (const CardRect& r : rects) {
        const double x = (r.min.x() + kPageUnits / 2) * mmPerUnit,
                     y = (kPageUnits / 2 - r.max.y()) * mmPerUnit,
                     width = (r.max.x() - r.min.x()) * mmPerUnit,
                     height = (r.max.y() - r.min.y()) * mmPerUnit;
        data += fmt::format("M{:.7g} {:.7g}h{:.7g}v{:.7g}h-{:.7g}z", x, y, width, height, width);
    }
    return "<path d=\"" + data + "\"/>\n";
}

/// @param at  where the text begins, or its middle; units of the card
std::string SvgText(const std::string& text, Eigen::Vector2d at, double height, bool isCentered,
                    double mmPerUnit) {
    return fmt::format("<text x=\"{:.7g}\" y=\"{:.7g}\" font-size=\"{:.4g}\"{}>{}</text>\n",
                       (at.x() + kPageUnits / 2) * mmPerUnit, (kPageUnits / 2 - at.y()) * mmPerUnit,
                       height * mmPerUnit, isCentered ? " text-anchor=\"middle\"" : "", text);
}

void AddCoverage(const CardRect& rect, double scale, Image* image) {
    const int side = image->Resolution().x;
    const double x0 = (rect.min.x() + kPageUnits / 2) * scale, x1 = (rect.max.x() + kPageUnits / 2) * scale,
                 y0 = (kPageUnits / 2 - rect.max.y()) * scale, y1 = (kPageUnits / 2 - rect.min.y()) * scale;
    const auto covered = [](double a, double b, int i) {
        return std::max(0., std::min(b, i + 1.) - std::max(a, double(i)));
    };
    for (int y = int(y0); y < std::min(side, int(std::ceil(y1))); ++y)
        for (int x = int(x0); x < std::min(side, int(std::ceil(x1))); ++x) {
            const double area = covered(x0, x1, x) * covered(y0, y1, y);
            image->Set({x, y}, 0, std::max(0.F, image->Get({x, y}, 0) - float(area)));
        }
}

}  // namespace

Eigen::Vector2d TagCenter(int id) {
    LACQUER_CHECK(id >= 0 && id < kNumTags);
    const double along = 4. * (id % 4) - 8;
    switch (id / 4) {
        case 0:
            return {along, 8};
        case 1:
            return {8, -along};
        case 2:
            return {-along, -8};
        default:
            return {-8, along};
    }
}

Eigen::Vector2d TagCorner(int id, int corner) {
    const double half = kTagUnits / 2;
    return TagCenter(id) +
           Eigen::Vector2d(corner == 1 || corner == 2 ? half : -half, corner >= 2 ? half : -half);
}

std::array<Eigen::Vector2d, 4> TagCorners(int id, double size) {
    std::array<Eigen::Vector2d, 4> corners;
    for (int c = 0; c < 4; ++c) corners[size_t(c)] = TagCorner(id, c) * (size / kUnitsPerSize);
    return corners;
}

std::vector<CardRect> TagRects(int id) {
    const TagCells isBlack = CellsOfTag(id);
    const Eigen::Vector2d topLeft = TagCorner(id, 3);
    const double cell = kTagUnits / kTagCells;
    std::vector<CardRect> rects;
    for (int row = 0; row < kTagCells; ++row)
        for (int begin = 0; begin < kTagCells;) {
            int end = begin;
            while (end < kTagCells && isBlack[size_t(row * kTagCells + end)]) ++end;
            if (end > begin)
                rects.push_back(RectOf(topLeft.x() + cell * begin, topLeft.y() - cell * (row + 1),
                                       topLeft.x() + cell * end, topLeft.y() - cell * row));
            begin = end + 1;
        }
    return rects;
}

double ScaleBarLength(double size) {
    const double longest = 0.65 * size, decade = std::pow(10, std::floor(std::log10(longest)));
    for (const double factor : {5., 2.})
        if (factor * decade <= longest) return factor * decade;
    return decade;
}

std::vector<CardRect> CardMarks(double size) {
    const double w = kWindowUnits / 2, line = kHairLine / 2;
    std::vector<CardRect> marks = {
        RectOf(-w - line, w - line, w + line, w + line), RectOf(-w - line, -w - line, w + line, -w + line),
        RectOf(-w - line, -w - line, -w + line, w + line), RectOf(w - line, -w - line, w + line, w + line)};
    const double half = ScaleBarLength(size) * kUnitsPerSize / size / 2;
    marks.push_back(RectOf(-half, -9.72, half, -9.68));
    marks.push_back(RectOf(-half, -9.9, -half + 0.04, -9.5));  // the length is that between outer edges
    marks.push_back(RectOf(half - 0.04, -9.9, half, -9.5));
    return marks;
}

std::string CardSvg(double size) {
    CheckCardSize(size);
    const double mm = 10 * size / kUnitsPerSize, page = kPageUnits * mm;
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.8g}mm\" height=\"{0:.8g}mm\" "
        "viewBox=\"0 0 {0:.8g} {0:.8g}\" font-family=\"sans-serif\">\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        page);
    for (int id = 0; id < kNumTags; ++id) {
        svg += SvgPath(TagRects(id), mm);
        svg += SvgText(std::to_string(id), TagCenter(id) + Eigen::Vector2d(1.45, -0.15), 0.4, false, mm);
    }
    svg += SvgPath(CardMarks(size), mm);
    svg += SvgText("cut out along the line, and lay the card flat on the sample", {0, 5.4}, 0.4, true, mm);
    svg += SvgText(fmt::format("from outer edge to outer edge of the tags: {:.6g} cm (print at 100 %)", size),
                   {0, 9.6}, 0.4, true, mm);
    svg +=
        SvgText(fmt::format("this bar has {:.6g} cm; if yours has not, the size of the card is {:.6g} times "
                            "what you measure",
                            ScaleBarLength(size), size / ScaleBarLength(size)),
                {0, -10.3}, 0.4, true, mm);
    return svg + "</svg>\n";
}

Image CardImage(double size, int pixelsPerUnit) {
    CheckCardSize(size);
    LACQUER_CHECK(pixelsPerUnit > 0);
    const int side = int(kPageUnits) * pixelsPerUnit;
    Image image({side, side}, {"Y"});
    std::fill(image.Pixels().begin(), image.Pixels().end(), 1.F);
    for (int id = 0; id < kNumTags; ++id)
        for (const CardRect& rect : TagRects(id)) AddCoverage(rect, pixelsPerUnit, &image);
    for (const CardRect& rect : CardMarks(size)) AddCoverage(rect, pixelsPerUnit, &image);
    return image;
}

}  // namespace lacquer::capture
