// The stroke font: from its text to polylines.
#include <fmt/format.h>

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "pbrt/core/embedded.h"
#include "plot/canvas.h"

namespace lacquer {
extern const EmbeddedFile kPlotFiles[];
}

namespace lacquer::plot {

namespace {

/// Polyline along an arc of an ellipse. Angles in degrees.
std::vector<Vec2> ArcPoints(Vec2 center, Vec2 radii, float from, float to) {
    constexpr float kDegreesPerStep = 12;
    const int steps = std::max(2, int(std::ceil(std::abs(to - from) / kDegreesPerStep)));
    std::vector<Vec2> points;
    for (int i = 0; i <= steps; ++i) {
        const float angle = Radians(Lerp(float(i) / float(steps), from, to));
        points.push_back(center + radii * Vec2(std::cos(angle), std::sin(angle)));
    }
    return points;
}

std::vector<Vec2> StrokePoints(char kind, const std::vector<float>& v) {
    if (kind == 'A' && v.size() == 6) return ArcPoints({v[0], v[1]}, {v[2], v[3]}, v[4], v[5]);
    std::vector<Vec2> points;
    if (kind == 'L' && v.size() % 2 == 0)
        for (size_t i = 0; i < v.size(); i += 2) points.push_back({v[i], v[i + 1]});
    return points;
}

char32_t CharacterOf(const std::string& name) {
    if (name == "space") return U' ';
    if (name == "hash") return U'#';
    const std::u32string characters = DecodeUtf8(name);
    return characters.size() == 1 ? characters[0] : U'\0';
}

}  // namespace

std::u32string DecodeUtf8(std::string_view text) {
    std::u32string result;
    for (size_t i = 0; i < text.size();) {
        const auto first = static_cast<unsigned char>(text[i]);
        const size_t length = first < 0x80 ? 1 : first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
        char32_t c = length == 1 ? first : length == 0 ? 0xfffd : first & (0x7fu >> length);
        bool valid = length > 0 && first < 0xf5 && i + length <= text.size();
        for (size_t k = 1; valid && k < length; ++k) {
            const auto byte = static_cast<unsigned char>(text[i + k]);
            valid = (byte & 0xc0) == 0x80;
            c = c << 6 | (byte & 0x3fu);
        }
        result += valid ? c : U'\xfffd';
        i += valid ? length : 1;
    }
    return result;
}

StrokeFont::StrokeFont(std::string_view text) {
    missing_ = {4.2f, {{{0.6f, 0}, {0.6f, 7}, {3.6f, 7}, {3.6f, 0}, {0.6f, 0}}}};
    std::istringstream lines{std::string(text)};
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line.starts_with("# ") || line == "#") continue;
        std::istringstream words(line);
        std::string name, word;
        Glyph glyph;
        words >> name >> glyph.advance;
        const char32_t character = CharacterOf(name);
        bool valid = character != U'\0' && !words.fail();
        char kind = 0;
        std::vector<float> numbers;
        const auto finishStroke = [&] {
            if (kind == 0) return;
            glyph.strokes.push_back(StrokePoints(kind, numbers));
            valid = valid && glyph.strokes.back().size() >= 2;
            numbers.clear();
        };
        while (words >> word) {
            if (word == "L" || word == "A") {
                finishStroke();
                kind = word[0];
            } else {
                numbers.push_back(std::strtof(word.c_str(), nullptr));
            }
        }
        finishStroke();
        if (!valid) throw std::logic_error(fmt::format("the font does not understand \"{}\"", line));
        glyphs_[character] = std::move(glyph);
    }
}

const StrokeFont& StrokeFont::Plain() {
    static const StrokeFont font(
        std::string_view(kPlotFiles[0].begin, size_t(kPlotFiles[0].end - kPlotFiles[0].begin)));
    return font;
}

const StrokeFont::Glyph& StrokeFont::Find(char32_t c) const {
    const auto it = glyphs_.find(c);
    return it == glyphs_.end() ? missing_ : it->second;
}

}  // namespace lacquer::plot
