#include "compare/tone_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lacquer::compare {
namespace {

struct NamedToneMap {
    const char* name;
    ToneMap map;
};
constexpr std::array kNamedToneMaps{
    NamedToneMap{"none", ToneMap::None}, NamedToneMap{"clamp", ToneMap::Clamp},
    NamedToneMap{"reinhard", ToneMap::Reinhard}, NamedToneMap{"aces", ToneMap::Aces}};

/// Into [0,1]; NaN stays NaN.
float Unit(float v) { return std::isnan(v) ? v : std::clamp(v, 0.f, 1.f); }

float Reinhard(float v, float luminance, float white) {
    if (std::isnan(v) || std::isnan(luminance)) return v + luminance;
    const float L = std::max(luminance, 0.f);
    const float highlights = white > 0 ? 1 + L / (white * white) : 1;
    return std::isinf(v) ? Unit(v) : Unit(std::max(v, 0.f) * highlights / (1 + L));
}

}  // namespace

std::vector<std::string> ToneMapNames() {
    std::vector<std::string> names;
    for (const NamedToneMap& entry : kNamedToneMaps) names.emplace_back(entry.name);
    return names;
}

std::optional<ToneMap> ParseToneMap(const std::string& name) {
    for (const NamedToneMap& entry : kNamedToneMaps)
        if (name == entry.name) return entry.map;
    return {};
}

float AcesCurve::Evaluate(float x) {
    if (std::isnan(x)) return x;
    // Beyond this the squares overflow, and the curve has long been at 1.
    if (x > 1e15f) return 1;
    x = std::max(x, 0.f);
    return std::min(1.f, (k0 * x + k1) * x / ((k3 * x + k4) * x + k5));
}

double AcesCurve::Inverse(double y) {
    // The positive root of (k0 - y k3) x^2 + (k1 - y k4) x - y k5.
    const double a = double(k0) - y * double(k3), b = double(k1) - y * double(k4), c = -y * double(k5);
    return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

RGB Apply(ToneMap map, RGB rgb, float luminance, float white) {
    for (int c = 0; c < 3; ++c) {
        if (map == ToneMap::Clamp) rgb[c] = Unit(rgb[c]);
        if (map == ToneMap::Reinhard) rgb[c] = Reinhard(rgb[c], luminance, white);
        if (map == ToneMap::Aces) rgb[c] = AcesCurve::Evaluate(rgb[c]);
    }
    return rgb;
}

}  // namespace lacquer::compare
