// Model "leather": rounded cells with creases between them and fine noise, under a rough dielectric
// interface.
#include <algorithm>
#include <array>
#include <cmath>

#include "estimate/models/material_model.h"
#include "estimate/models/streams.h"
#include "estimate/powers.h"

namespace lacquer::estimate {
namespace {

enum : size_t { Light, Red, Green, Blue, Rough, RoughVar, Height, Power, Frequency, Vig, NoiseScale };
constexpr uint32_t kModelNumber = 2;
/// Of the torus that a seed fills, in cells, and of its noise, in texels for each cell.
constexpr int kPeriod = 64, kTexelsPerCell = NoiseMap::kTexels / kPeriod;
/// Creases are as wide as F2 - F1 stays below this, in mean spacings.
constexpr double kCreaseWidth = 0.6;

// The published `scale` is the part of a map of some 4000 cells that fills an extent of 25 cm: 2.53 scale
// cells per cm.
constexpr std::array<ModelParameter, 13> kTable{{
    {"light",
     "cm^2",
     {"intensity of the light", "a white pixel is 1"},
     {999, 500, 1, 2500},
     {1500, 100, 1, 2500}},
    {"r", "", "red diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"g", "", "green diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"b", "", "blue diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"rough", "", {"roughness of cells", "alpha = rough^2"}, {.2, .2, .1, .8}, {.5, .3, .2, .8}},
    {"rough_var", "", "roughness that creases add", {.2, .1, .001, .4}, {.2, .3, .001, .4}},
    {"height", "cm", "height of cells over creases", {.2, .1, .001, .5}, {1, .3, .001, 2}},
    {"power", "", "exponent of the profile of creases", {1.5, .2, 1, 2}, {.5, .3, .05, 2}},
    {"frequency",
     "cells/cm",
     "number of cells along a line",
     {.506, .506, .0253, 2.53},
     {1.265, .759, .253, 2.53},
     false},
    {"vig", "cm", "standard deviation of the vignette", {10, 3, 5, 20}, {15, 3, 5, 20}},
    {"noise_scale",
     "cm",
     "height of fine noise",
     {.005, .005, .001, .025},
     {.01, .1, .001, .025},
     true,
     true,
     .005},
    kAxisX,
    kAxisY,
}};

/// bases^exponent, 0 where a base is 0.
void Powers(const Field& bases, double exponent, Field* powers) {
    constexpr double kLeast = 1e-300;  // whose logarithm is finite
    powers->resize(bases.size());
    ForEachPower(
        bases.size(), exponent, [&](size_t i) { return std::max(bases[i], kLeast); },
        [&](size_t i, double power) { (*powers)[i] = bases[i] > 0 ? power : 0; });
}

class LeatherRun final : public ModelRun {
  public:
    LeatherRun(const MapGrid& grid, const ModelKinds& kinds, std::span<const double> parameters)
        : grid_(grid),
          stretchX_(Cells::StretchX(kinds.cells)),
          stretchY_(Cells::StretchY(kinds.cells)),
          cells_(kinds.cells, PeriodOf(grid, stretchX_, parameters), PeriodOf(grid, stretchY_, parameters)),
          noise_(kinds.noise, kTexelsPerCell * PeriodOf(grid, 1, parameters)) {
        for (Field* field : {&crease_, &creaseByFrequency_, &noiseValue_, &noiseByFrequency_})
            field->resize(grid.NumPoints());
    }

    void SetSeed(uint64_t seed) override {
        cells_.SetSeed(StreamOf(seed, kModelNumber, Component::Cells));
        noise_.SetSeed(StreamOf(seed, kModelNumber, Component::Noise));
        const uint64_t shift = StreamOf(seed, kModelNumber, Component::Shift);
        shiftX_ = kPeriod * UnitAt(shift, 0, 0);
        shiftY_ = kPeriod * UnitAt(shift, 0, 1);
        hasPattern_ = false;
    }

    void Forward(std::span<const double> p, Surface* surface) override {
        if (!hasPattern_ || frequency_ != p[Frequency]) MakePattern(p[Frequency]);
        const size_t count = grid_.NumPoints();
        surface->reflectance = Reflectance::Dielectric;
        surface->height.resize(count);
        surface->roughness.resize(count);
        Powers(crease_, p[Power], &profile_);
        for (size_t i = 0; i < count; ++i) {
            surface->height[i] = (1 - profile_[i]) * p[Height] + (2 * noiseValue_[i] - 1) * p[NoiseScale];
            surface->roughness[i] = std::clamp(p[Rough] + p[RoughVar] * crease_[i], kMinRough, kMaxRough);
        }
        SlopesOf(grid_, surface->height, &surface->slopeX, &surface->slopeY);
        for (size_t k = 0; k < 3; ++k) surface->albedo[k].assign(1, p[Red + k]);
    }

    void Backward(std::span<const double> p, const Surface&, Surface* adjoint,
                  std::span<double> byParameters) override {
        SlopesAdjoint(grid_, adjoint->slopeX, adjoint->slopeY, adjoint->height);
        double rough = 0, roughVar = 0, height = 0, power = 0, frequency = 0, noiseScale = 0;
        for (size_t i = 0; i < grid_.NumPoints(); ++i) {
            const double c = crease_[i], byHeight = adjoint->height[i];
            const double toPower = c > 0 ? std::pow(c, p[Power]) : 0;
            height += byHeight * (1 - toPower);
            noiseScale += byHeight * (2 * noiseValue_[i] - 1);
            frequency += byHeight * 2 * p[NoiseScale] * noiseByFrequency_[i];
            const double r = p[Rough] + p[RoughVar] * c;
            const double byRough = r > kMinRough && r < kMaxRough ? adjoint->roughness[i] : 0;
            rough += byRough;
            roughVar += byRough * c;
            if (c <= 0) continue;
            power -= byHeight * p[Height] * toPower * std::log(c);
            const double byCrease = byRough * p[RoughVar] - byHeight * p[Height] * p[Power] * toPower / c;
            frequency += byCrease * creaseByFrequency_[i];
        }
        byParameters[Rough] += rough;
        byParameters[RoughVar] += roughVar;
        byParameters[Height] += height;
        byParameters[Power] += power;
        byParameters[NoiseScale] += noiseScale;
        if (!grid_.isPeriodic) byParameters[Frequency] += frequency;
        for (size_t k = 0; k < 3; ++k) byParameters[Red + k] += adjoint->albedo[k][0];
    }

  private:
    static constexpr double kMinRough = 0.1, kMaxRough = 0.8;

    static int PeriodOf(const MapGrid& grid, double stretch, std::span<const double> parameters) {
        if (!grid.isPeriodic) return kPeriod;
        return std::max(5, int(std::lround(grid.extent * parameters[Frequency] * stretch)));
    }

    /// Creases and noise where they come to lie at a frequency, and how they change with it.
    void MakePattern(double frequency) {
        hasPattern_ = true;
        frequency_ = frequency;
        const bool fits = grid_.isPeriodic;
        const double perX = fits ? cells_.PeriodX() / grid_.extent : frequency * stretchX_;
        const double perY = fits ? cells_.PeriodY() / grid_.extent : frequency * stretchY_;
        const double perTexel = fits ? noise_.Texels() / grid_.extent : kTexelsPerCell * frequency;
        NearestSites sites(cells_);
        for (int row = 0; row < grid_.size; ++row)
            for (int column = 0; column < grid_.size; ++column) {
                const size_t i = size_t(row) * size_t(grid_.size) + size_t(column);
                const double x = grid_.X(column), y = grid_.Y(row);
                const NearestSites::Nearest near = sites.At(x * perX + shiftX_, y * perY + shiftY_);
                const double gap = (near.f2 - near.f1) / kCreaseWidth;
                crease_[i] = gap < 1 ? 1 - gap : 0;
                const double gapByFrequency =
                    ((near.f2ByX - near.f1ByX) * x * stretchX_ + (near.f2ByY - near.f1ByY) * y * stretchY_) /
                    kCreaseWidth;
                creaseByFrequency_[i] = gap < 1 ? -gapByFrequency : 0;
                const auto noise = noise_.At(x * perTexel + kTexelsPerCell * shiftX_,
                                             y * perTexel + kTexelsPerCell * shiftY_);
                noiseValue_[i] = noise.value;
                noiseByFrequency_[i] = kTexelsPerCell * (noise.byU * x + noise.byV * y);
            }
    }

    MapGrid grid_;
    double stretchX_, stretchY_;
    Cells cells_;
    NoiseMap noise_;
    double shiftX_ = 0, shiftY_ = 0;
    bool hasPattern_ = false;  ///< of this seed, at frequency_
    double frequency_ = 0;
    Field crease_, profile_, creaseByFrequency_, noiseValue_, noiseByFrequency_;
};

class Leather final : public MaterialModel {
  public:
    std::string_view Name() const override { return "leather"; }
    std::span<const ModelParameter> Parameters() const override { return kTable; }
    Reflectance ReflectanceKind() const override { return Reflectance::Dielectric; }
    bool HasCells() const override { return true; }
    bool HasNoise() const override { return true; }
    std::unique_ptr<ModelRun> MakeRun(const MapGrid& grid, const ModelKinds& kinds,
                                      std::span<const double> parameters) const override {
        return std::make_unique<LeatherRun>(grid, kinds, parameters);
    }
};

}  // namespace

const MaterialModel& LeatherModel() {
    static const Leather model;
    return model;
}

}  // namespace lacquer::estimate
