#include "compare/box.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace lacquer::compare {
namespace {

using Corners = std::array<double, 4>;  // x0, x1, y0, y1

[[noreturn]] void NoBox(const std::string& text, const std::string& problem) {
    throw std::invalid_argument(fmt::format("box \"{}\": {}", text, problem));
}

std::optional<double> ParseNumber(std::string text) {
    const size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
    if (first == std::string::npos) return {};
    text = text.substr(first, last - first + 1);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return {};
    return number;
}

/// Exactly four numbers with commas between them.
std::optional<Corners> ParseCorners(const std::string& text) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == ',')
            parts.emplace_back();
        else
            parts.back() += c;
    }
    Corners corners;
    if (parts.size() != corners.size()) return {};
    for (size_t i = 0; i < corners.size(); ++i) {
        const std::optional<double> number = ParseNumber(parts[i]);
        if (!number) return {};
        corners[i] = *number;
    }
    return corners;
}

bool AreFractions(const Corners& corners) {
    return std::all_of(corners.begin(), corners.end(), [](double v) { return v >= 0 && v <= 1; });
}

/// Nearest pixel edge; far outside is as good as just outside, and can be held by an int.
int Edge(double value, int size) { return int(std::lround(std::clamp(value, -1.0, double(size) + 1))); }

Bounds2i Scaled(Corners c, Int2 resolution) {
    return {{Edge(c[0] * resolution.x, resolution.x), Edge(c[2] * resolution.y, resolution.y)},
            {Edge(c[1] * resolution.x, resolution.x), Edge(c[3] * resolution.y, resolution.y)}};
}

Bounds2i Counted(Corners c, Int2 resolution) {
    return {{Edge(c[0], resolution.x), Edge(c[2], resolution.y)},
            {Edge(c[1], resolution.x), Edge(c[3], resolution.y)}};
}

}  // namespace

Box ParseBox(const std::string& text, Int2 resolution) {
    // A name may hold colons; the numbers cannot.
    const size_t colon = text.rfind(':');
    Box box;
    box.name = colon == std::string::npos ? "box" : text.substr(0, colon);
    const std::string numbers = colon == std::string::npos ? text : text.substr(colon + 1);
    const std::optional<Corners> corners = ParseCorners(numbers);
    if (box.name.empty() || !corners)
        NoBox(text, "expected NAME:x0,x1,y0,y1, in fractions of the image or in pixels");
    if (!AreFractions(*corners))
        for (const double corner : *corners)
            if (corner != std::floor(corner))
                NoBox(text, "expected either four fractions from 0 to 1 or four whole numbers of pixels");
    box.pixels = AreFractions(*corners) ? Scaled(*corners, resolution) : Counted(*corners, resolution);
    if (box.pixels.IsEmpty())
        NoBox(text, "holds no pixel; the order is x0,x1,y0,y1, and x1 and y1 are not included");
    const Bounds2i inside = box.pixels.Intersect({{0, 0}, resolution});
    if (inside.IsEmpty())
        NoBox(text, fmt::format("lies outside of the image of {} x {} pixels", resolution.x, resolution.y));
    box.pixels = inside;
    return box;
}

std::vector<Box> BoxesOfScene(const std::string& path, Int2 resolution) {
    std::ifstream file(path);
    return BoxesOfScene(file, resolution);
}

std::vector<Box> BoxesOfScene(std::istream& scene, Int2 resolution) {
    std::vector<Box> boxes;
    std::string line;
    while (std::getline(scene, line)) {
        const size_t first = line.find_first_not_of(" \t\r");
        if (first == std::string::npos) continue;
        if (line[first] != '#') break;  // the first directive
        std::istringstream words(line.substr(first + 1));
        std::string keyword, rest;
        Box box;
        Corners c{};
        if (!(words >> keyword >> box.name >> c[0] >> c[1] >> c[2] >> c[3]) || keyword != "box") continue;
        if (words >> rest || !AreFractions(c)) continue;
        box.pixels = Scaled(c, resolution);
        if (!box.pixels.IsEmpty()) boxes.push_back(box);
    }
    return boxes;
}

Box WholeImage(Int2 resolution) { return {"all", {{0, 0}, resolution}}; }

}  // namespace lacquer::compare
