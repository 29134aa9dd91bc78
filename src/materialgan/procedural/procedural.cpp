#include "materialgan/procedural/procedural.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lacquer::materialgan {
namespace {

using Triple = std::array<double, 3>;

/// One homogeneous material; all values as stored, from 0 to 1, that is, to the power 1/2.2.
struct Substance {
    Triple albedo{}, specular{};
    double roughness = 0;
};

Substance Metal(Rng& rng) {
    // Silver, gold, copper and titanium, roughly, and more or less tarnished.
    constexpr Triple kTints[] = {{0.95, 0.93, 0.9}, {1, 0.78, 0.5}, {0.97, 0.7, 0.6}, {0.75, 0.75, 0.8}};
    Substance s;
    s.albedo.fill(UniformIn(rng, 0.03, 0.2));
    s.specular = kTints[WholeIn(rng, 0, 3)];
    const double tarnish = UniformIn(rng, 0.6, 1);
    for (double& c : s.specular) c *= tarnish;
    s.roughness = UniformIn(rng, 0.3, 0.7);
    return s;
}

Substance Dielectric(Rng& rng) {
    Substance s;
    const double value = UniformIn(rng, 0.1, 0.95),
                 saturation = UniformIn(rng, 0, 1) * UniformIn(rng, 0.2, 1);
    for (double& c : s.albedo) c = value * (1 - saturation * double(rng.Uniform()));
    // 0.02 to 0.08 as linear values.
    s.specular.fill(UniformIn(rng, 0.17, 0.32));
    s.roughness = UniformIn(rng, 0.25, 0.9);
    return s;
}

Substance RandomSubstance(Rng& rng) { return rng.Uniform() < 0.2f ? Metal(rng) : Dielectric(rng); }

/// A second one that often resembles the first: another stain or wear of it.
Substance Companion(const Substance& first, Rng& rng) {
    Substance second = RandomSubstance(rng);
    const float kind = rng.Uniform();
    if (kind < 0.5f) {
        second.specular = first.specular;
        second.roughness = std::clamp(first.roughness + UniformIn(rng, -0.2, 0.2), 0.25, 0.95);
    }
    if (kind < 0.25f) {
        const double scale = UniformIn(rng, 0.5, 1.4);
        for (size_t c = 0; c < 3; ++c)
            second.albedo[c] = std::min(1., scale * first.albedo[c] * UniformIn(rng, 0.9, 1.1));
    }
    return second;
}

double Lerp64(double a, double b, double t) { return a + (b - a) * t; }

/// Numbers in [0,1] as maps store them.
double Stored(double value) { return 2 * std::clamp(value, 0., 1.) - 1; }

/// Slopes of periodic heights by differences, per texel. Rows go down, y goes up.
std::array<double, 2> SlopesAt(const Field& h, size_t size, size_t row, size_t column) {
    const auto at = [&](size_t r, size_t c) { return h[(r % size) * size + c % size]; };
    return {0.5 * (at(row, column + 1) - at(row, column + size - 1)),
            0.5 * (at(row + size - 1, column) - at(row + 1, column))};
}

void SetNormals(const Relief& relief, double detailHeight, double strength, capture::Maps* maps) {
    const auto size = size_t(maps->size);
    const auto nx = maps->Channel(capture::kNormal), ny = maps->Channel(capture::kNormal + 1);
    // Heights are meant for texels of 1/32 of the edge; details are as steep at any resolution.
    const double scale = double(size) / 32;
    for (size_t row = 0; row < size; ++row)
        for (size_t column = 0; column < size; ++column) {
            const auto coarse = SlopesAt(relief.height, size, row, column),
                       fine = SlopesAt(relief.detail, size, row, column);
            const double dx = strength * (scale * coarse[0] + detailHeight * fine[0]),
                         dy = strength * (scale * coarse[1] + detailHeight * fine[1]);
            const double length = std::sqrt(dx * dx + dy * dy + 1);
            nx[row * size + column] = -dx / length;
            ny[row * size + column] = -dy / length;
        }
}

/// Red, green and blue of albedo and specular albedo in another order.
void ExchangeColours(Rng& rng, capture::Maps* maps) {
    const int turn = WholeIn(rng, 0, 2);
    const bool mirror = rng.Uniform() < 0.5f;
    const capture::Maps before = *maps;
    for (const size_t first : {capture::kAlbedo, capture::kSpecular})
        for (size_t c = 0; c < 3; ++c) {
            const size_t from = ((mirror ? 2 - c : c) + size_t(turn)) % 3;
            std::ranges::copy(before.Channel(first + from), maps->Channel(first + c).begin());
        }
}

}  // namespace

capture::Maps ProceduralMaterial(Family family, int size, uint64_t seed) {
    Rng rng(Hash(seed, int(family), uint64_t(0x6d617073)));
    Relief relief = MakeRelief(family, size, rng);
    // One in eight is printed on something flat.
    if (rng.Uniform() < 0.125f) std::ranges::fill(relief.height, 0.);
    const Substance a = RandomSubstance(rng), b = Companion(a, rng);
    const double shading = UniformIn(rng, 0, 0.15), wear = UniformIn(rng, -0.06, 0.06);
    capture::Maps maps(size);
    for (size_t i = 0; i < maps.NumTexels(); ++i) {
        const double m = relief.mask[i], shade = std::max(0., 1 + shading * relief.detail[i]);
        for (size_t c = 0; c < 3; ++c) {
            maps.Channel(capture::kAlbedo + c)[i] = Stored(Lerp64(a.albedo[c], b.albedo[c], m) * shade);
            maps.Channel(capture::kSpecular + c)[i] =
                Stored(Lerp64(a.specular[c], b.specular[c], m) * (1 + 0.3 * (shade - 1)));
        }
        const double roughness = Lerp64(a.roughness, b.roughness, m) + wear * relief.detail[i];
        maps.Channel(capture::kRoughness)[i] = Stored(std::clamp(roughness, 0.2, 0.97));
    }
    const double detailHeight = UniformIn(rng, 0, 0.4), strength = UniformIn(rng, 0.2, 1);
    SetNormals(relief, detailHeight, strength, &maps);
    return maps;
}

capture::Maps TrainingMaterial(int size, uint64_t seed) {
    Rng rng(Hash(seed, uint64_t(0x747261696e)));
    const auto family = Family(WholeIn(rng, 0, kNumTrainedFamilies - 1));
    capture::Maps maps = ProceduralMaterial(family, size, rng.NextBits());
    for (int turns = WholeIn(rng, 0, 3); turns > 0; --turns) maps = QuarterTurn(maps);
    const int down = WholeIn(rng, 0, size - 1), right = WholeIn(rng, 0, size - 1);
    maps = Shift(maps, down, right);
    ExchangeColours(rng, &maps);
    return maps;
}

capture::Maps QuarterTurn(const capture::Maps& maps) {
    capture::Maps turned(maps.size);
    const auto n = size_t(maps.size);
    for (size_t c = 0; c < capture::kNumChannels; ++c)
        for (size_t row = 0; row < n; ++row)
            for (size_t column = 0; column < n; ++column)
                turned.Channel(c)[row * n + column] = maps.Channel(c)[column * n + (n - 1 - row)];
    const auto x = turned.Channel(capture::kNormal), y = turned.Channel(capture::kNormal + 1);
    for (size_t i = 0; i < n * n; ++i) {
        std::swap(x[i], y[i]);
        x[i] = -x[i];
    }
    return turned;
}

capture::Maps Shift(const capture::Maps& maps, int down, int right) {
    capture::Maps shifted(maps.size);
    const auto n = size_t(maps.size), addRow = size_t(down), addColumn = size_t(right);
    for (size_t c = 0; c < capture::kNumChannels; ++c)
        for (size_t row = 0; row < n; ++row)
            for (size_t column = 0; column < n; ++column)
                shifted.Channel(c)[((row + addRow) % n) * n + (column + addColumn) % n] =
                    maps.Channel(c)[row * n + column];
    return shifted;
}

}  // namespace lacquer::materialgan
