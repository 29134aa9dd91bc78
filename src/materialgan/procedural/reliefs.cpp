#include "materialgan/procedural/reliefs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "materialgan/procedural/cells.h"

namespace lacquer::materialgan {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// From 0 to 1 within a few `width` around 0.
double SmoothStep(double x, double width) { return 1 / (1 + std::exp(-x / width)); }

double Fraction(double x) { return x - std::floor(x); }

/// A number in [-1,1] that belongs to two whole ones.
double NumberOf(uint64_t seed, int i, int j) { return 2 * double(UnitFloat(Hash(seed, i, j))) - 1; }

/// visit(x, y, i) with x and y in (0,1) at the middle of texel i.
template <class Visit>
void ForTexels(int size, const Visit& visit) {
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column)
            visit((column + 0.5) / size, (row + 0.5) / size, size_t(row) * size_t(size) + size_t(column));
}

Relief EmptyRelief(int size, Rng& rng) {
    const Field zeros(size_t(size) * size_t(size));
    return {zeros, zeros, FractalNoise(size, UniformIn(rng, 0.5, 1.5), 1, rng)};
}

Relief Patches(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    const Field noise = FractalNoise(size, UniformIn(rng, 1, 2.2), 1, rng);
    const double shift = UniformIn(rng, -0.7, 0.7), width = UniformIn(rng, 0.04, 0.4),
                 height = UniformIn(rng, -2, 2);
    for (size_t i = 0; i < noise.size(); ++i) {
        r.mask[i] = SmoothStep(noise[i] + shift, width);
        r.height[i] = r.mask[i] * height;
    }
    return r;
}

/// Tiles and bricks with joints, each of its own brightness and a little tilted.
Relief Tiles(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    const bool areBricks = rng.Uniform() < 0.5f;
    const int numX = WholeIn(rng, 2, 6), numY = areBricks ? 2 * WholeIn(rng, 1, 3) : WholeIn(rng, 2, 6);
    const double joint = UniformIn(rng, 0.012, 0.035), edge = UniformIn(rng, 0.005, 0.012),
                 height = UniformIn(rng, 0.5, 3), tilt = UniformIn(rng, 0, 1.5),
                 contrast = UniformIn(rng, 0.3, 1.5);
    const uint64_t seed = rng.NextBits();
    ForTexels(size, [&](double x, double y, size_t i) {
        const int row = int(y * numY);
        const double along = x * numX + (areBricks ? 0.5 * (row % 2) : 0.);
        const int column = int(std::floor(along)) % numX;
        const double u = Fraction(along), v = Fraction(y * numY);
        const double distance = std::min(std::min(u, 1 - u) / numX, std::min(v, 1 - v) / numY);
        r.mask[i] = SmoothStep(distance - joint, edge);
        r.height[i] = r.mask[i] * (height + tilt * (NumberOf(seed, row, column) * (u - 0.5) +
                                                    NumberOf(seed + 1, row, column) * (v - 0.5)));
        r.detail[i] = 0.5 * r.detail[i] + contrast * NumberOf(seed + 2, row, column);
    });
    return r;
}

/// Rings of stretched noise, as a board or as planks.
Relief Wood(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    const Field rings = FractalNoise(size, UniformIn(rng, 1.1, 1.8), UniformIn(rng, 3, 10), rng);
    const Field pores = FractalNoise(size, 0.4, UniformIn(rng, 6, 16), rng);
    const double frequency = UniformIn(rng, 1.5, 5), height = UniformIn(rng, 0, 1),
                 sharpness = UniformIn(rng, 0.3, 2), poreShare = UniformIn(rng, 0, 0.4);
    const int planks = rng.Uniform() < 0.4f ? WholeIn(rng, 2, 5) : 0;
    const uint64_t seed = rng.NextBits();
    ForTexels(size, [&](double, double y, size_t i) {
        const int plank = int(y * planks);
        const double wave = std::sin(rings[i] * frequency + (planks > 0 ? 3 * NumberOf(seed, plank, 0) : 0.));
        r.mask[i] = std::clamp(SmoothStep(wave, sharpness) + poreShare * 0.3 * pores[i], 0., 1.);
        r.height[i] = r.mask[i] * height;
        r.detail[i] = 0.5 * r.detail[i] + 0.5 * pores[i];
        if (planks == 0) return;
        const double v = Fraction(y * planks), gap = SmoothStep(std::min(v, 1 - v) / planks - 0.012, 0.004);
        r.height[i] = r.height[i] * gap + 2 * gap;
        r.detail[i] += 1.2 * NumberOf(seed + 1, plank, 0) - 4 * (1 - gap);
    });
    return r;
}

/// Leather, cobblestones, cracked mud.
Relief Cells(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    const CellMap cells = MakeCells(size, WholeIn(rng, 8, 60), rng);
    const double joint = UniformIn(rng, 0.015, 0.06), edge = UniformIn(rng, 0.008, 0.02),
                 height = UniformIn(rng, 0.5, 3), dome = UniformIn(rng, 0, 1),
                 contrast = UniformIn(rng, 0, 1);
    const uint64_t seed = rng.NextBits();
    for (size_t i = 0; i < r.mask.size(); ++i) {
        const double distance = cells.second[i] - cells.first[i];
        r.mask[i] = SmoothStep(distance - joint, edge);
        r.height[i] = height * (r.mask[i] + dome * std::min(1., distance / 0.15));
        r.detail[i] = (1 - contrast) * r.detail[i] + contrast * NumberOf(seed, cells.index[i], 0);
    }
    return r;
}

/// Plain weave, twill and satin: the threads' number decides which of two lies on top.
Relief Weave(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    struct Pattern {
        int period, over, step;
    };
    constexpr Pattern kPatterns[] = {{2, 1, 1}, {3, 1, 1}, {4, 2, 1}, {5, 1, 2}};
    const Pattern pattern = kPatterns[WholeIn(rng, 0, 3)];
    const int threads =
        pattern.period * WholeIn(rng, 1, std::max(1, std::min(16, size / 4) / pattern.period));
    const double height = UniformIn(rng, 0.3, 1.5) * 8 / threads, gap = UniformIn(rng, 0, 0.4);
    ForTexels(size, [&](double x, double y, size_t i) {
        const int column = int(x * threads), row = int(y * threads);
        const bool isWarp = (column + pattern.step * row) % pattern.period < pattern.over;
        const double across = Fraction((isWarp ? x : y) * threads) - 0.5,
                     along = Fraction((isWarp ? y : x) * threads) - 0.5;
        const double profile =
            std::cos(std::numbers::pi * across) * (0.7 + 0.3 * std::cos(kTurn / 2 * along));
        r.mask[i] = isWarp ? 1 : 0;
        r.height[i] = height * profile;
        r.detail[i] = 0.5 * r.detail[i] - gap * 4 * (1 - profile);
    });
    return r;
}

/// Brushed or scratched: lines that wrap around.
Relief Scratches(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    const double brushing = UniformIn(rng, 0, 0.5);
    const Field brushed = FractalNoise(size, 0.5, UniformIn(rng, 8, 30), rng);
    const int count = WholeIn(rng, 0, 40);
    const double depth = UniformIn(rng, 0.1, 0.6);
    for (int line = 0; line < count; ++line) {
        double x = double(rng.Uniform()), y = double(rng.Uniform());
        const double angle = kTurn * double(rng.Uniform()), bend = UniformIn(rng, -2, 2);
        const int steps = int(size * UniformIn(rng, 0.2, 1.5));
        for (int step = 0; step < steps; ++step) {
            const double direction = angle + bend * step / size;
            x = Fraction(x + std::cos(direction) / size);
            y = Fraction(y + std::sin(direction) / size);
            r.mask[size_t(y * size) * size_t(size) + size_t(x * size)] = 1;
        }
    }
    for (size_t i = 0; i < r.mask.size(); ++i) {
        r.height[i] = -depth * r.mask[i] + 0.3 * brushing * brushed[i];
        r.detail[i] = 0.5 * r.detail[i] + 2 * brushing * brushed[i];
        r.mask[i] *= 0.8;
    }
    return r;
}

/// A rough coat, its hollows in the second material.
Relief Plaster(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    const Field noise = FractalNoise(size, UniformIn(rng, 1, 1.8), 1, rng);
    const double height = UniformIn(rng, 0.3, 2), ridge = UniformIn(rng, 0, 1), mix = UniformIn(rng, 0, 1);
    for (size_t i = 0; i < noise.size(); ++i) {
        r.height[i] = height * ((1 - ridge) * noise[i] - ridge * std::abs(noise[i]));
        r.mask[i] = mix * SmoothStep(noise[i], 0.6);
        r.detail[i] = 0.6 * r.detail[i] + 0.5 * noise[i];
    }
    return r;
}

/// Grains of both materials: granite, terrazzo.
Relief Speckles(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    const CellMap cells = MakeCells(size, WholeIn(rng, 30, std::max(40, size * size / 24)), rng);
    const double share = UniformIn(rng, 0.1, 0.6), contrast = UniformIn(rng, 0.2, 1),
                 height = UniformIn(rng, -0.3, 0.3);
    const uint64_t seed = rng.NextBits();
    for (size_t i = 0; i < r.mask.size(); ++i) {
        r.mask[i] = 0.5 + 0.5 * NumberOf(seed, cells.index[i], 0) < share ? 1 : 0;
        r.height[i] = height * r.mask[i];
        r.detail[i] = (1 - contrast) * r.detail[i] + 1.5 * contrast * NumberOf(seed, cells.index[i], 1);
    }
    return r;
}

/// Corrugated, ribbed or printed stripes, a little wavy.
Relief Ribs(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    const Field noise = FractalNoise(size, 2, 1, rng);
    const int count = WholeIn(rng, 2, std::min(16, size / 4));
    const double waviness = UniformIn(rng, 0, 0.08) * count / 4, sharpness = UniformIn(rng, 0.05, 1),
                 height = UniformIn(rng, -2.5, 2.5) * 4 / count, shift = UniformIn(rng, -0.5, 0.5);
    ForTexels(size, [&](double, double y, size_t i) {
        const double wave = std::sin(kTurn * (y * count + waviness * noise[i]));
        r.mask[i] = SmoothStep(wave + shift, sharpness);
        r.height[i] = height * wave;
    });
    return r;
}

Relief Dots(int size, Rng& rng) {
    Relief r = EmptyRelief(size, rng);
    const int count = WholeIn(rng, 2, 5);
    const double radius = UniformIn(rng, 0.2, 0.4), height = UniformIn(rng, -2, 2);
    ForTexels(size, [&](double x, double y, size_t i) {
        const double distance = std::hypot(Fraction(x * count) - 0.5, Fraction(y * count) - 0.5);
        r.mask[i] = SmoothStep(radius - distance, 0.04);
        r.height[i] = r.mask[i] * height;
    });
    return r;
}

struct FamilyEntry {
    const char* name;
    Relief (*make)(int size, Rng& rng);
};
constexpr FamilyEntry kFamilies[kNumFamilies] = {{"patches", Patches}, {"tiles", Tiles},
                                                 {"wood", Wood},       {"cells", Cells},
                                                 {"weave", Weave},     {"scratches", Scratches},
                                                 {"plaster", Plaster}, {"speckles", Speckles},
                                                 {"ribs", Ribs},       {"dots", Dots}};

}  // namespace

const char* FamilyName(Family family) { return kFamilies[size_t(family)].name; }

Relief MakeRelief(Family family, int size, Rng& rng) { return kFamilies[size_t(family)].make(size, rng); }

}  // namespace lacquer::materialgan
