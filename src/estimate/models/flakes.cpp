// Model "flakes": tilted metallic flakes in a diffuse base under a smooth top.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "estimate/models/material_model.h"
#include "estimate/models/streams.h"

namespace lacquer::estimate {
namespace {

enum : size_t {
    Light,
    Red,
    Green,
    Blue,
    TopF0,
    TopRough,
    FlakeRed,
    FlakeGreen,
    FlakeBlue,
    FlakeRough,
    FlakeNdf,
    Frequency,
    Vig,
    GlowWeight,
    GlowF0,
    GlowRough
};
constexpr uint32_t kModelNumber = 5;
/// Of the torus that a seed fills, in flakes.
constexpr int kPeriod = 128;

// The published `scale` is the part of a map of some 16,000 flakes that fills an extent of 25 cm: 5.06 scale
// flakes per cm. The glow of [Guo et al. 2020] is there if its weight is free, or fixed at more than 0.
constexpr std::array<ModelParameter, 18> kTable{{
    {"light",
     "cm^2",
     {"intensity of the light", "a white pixel is 1"},
     {150, 50, 10, 300},
     {999, 300, 10, 2000}},
    {"r", "", "red diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"g", "", "green diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"b", "", "blue diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"topf0",
     "",
     {"reflectance of the top", "at normal incidence"},
     {.04, .005, .03, .05},
     {.04, .005, .03, .05}},
    {"toprough", "", {"roughness of the top", "alpha = toprough^2"}, {.1, .05, .01, .2}, {.1, .05, .01, .2}},
    {"fr", "", {"red reflectance of flakes", "at normal incidence"}, {.3, .1, 0, 1}, {.1, .1, 0, 1}},
    {"fg", "", {"green reflectance of flakes", "at normal incidence"}, {.3, .1, 0, 1}, {.1, .1, 0, 1}},
    {"fb", "", {"blue reflectance of flakes", "at normal incidence"}, {.3, .1, 0, 1}, {.1, .1, 0, 1}},
    {"flakerough",
     "",
     {"roughness of one flake", "alpha = flakerough^2"},
     {.3, .2, .01, .8},
     {.1, .2, .01, .8}},
    {"flakendf",
     "",
     {"roughness of the distribution of the normals of flakes", "alpha = flakendf^2"},
     {.3, .2, .01, .8},
     {.3, .2, .01, .8}},
    {"frequency",
     "flakes/cm",
     "number of flakes along a line",
     {4.05, 1.01, .506, 5.06},
     {5.01, .506, .506, 5.06},
     false},
    {"vig", "cm", "standard deviation of the vignette", {10, 3, 5, 20}, {15, 3, 5, 20}},
    {"glow_weight",
     "",
     {"weight of the glow", "0 unless it is free"},
     {.3, .2, 0, 1},
     {.3, .2, 0, 1},
     true,
     true},
    {"glow_f0",
     "",
     {"reflectance of the glow", "at normal incidence"},
     {.1, .05, 0, .5},
     {.1, .05, 0, .5},
     true,
     true,
     .1},
    {"glow_rough",
     "",
     {"roughness of the glow", "alpha = glow_rough^2"},
     {.4, .1, .1, .8},
     {.4, .1, .1, .8},
     true,
     true,
     .4},
    kAxisX,
    kAxisY,
}};

class FlakesRun final : public ModelRun {
  public:
    FlakesRun(const MapGrid& grid, const ModelKinds& kinds, std::span<const double> parameters)
        : grid_(grid),
          stretchX_(Cells::StretchX(kinds.cells)),
          stretchY_(Cells::StretchY(kinds.cells)),
          cells_(kinds.cells, PeriodOf(grid, stretchX_, parameters), PeriodOf(grid, stretchY_, parameters)),
          flake_(grid.NumPoints()) {}

    void SetSeed(uint64_t seed) override {
        cells_.SetSeed(StreamOf(seed, kModelNumber, Component::Cells));
        const uint64_t shift = StreamOf(seed, kModelNumber, Component::Shift);
        shiftX_ = kPeriod * UnitAt(shift, 0, 0);
        shiftY_ = kPeriod * UnitAt(shift, 0, 1);
        hasPattern_ = false;
        const uint64_t stream = StreamOf(seed, kModelNumber, Component::Flakes);
        slopes_.resize(size_t(cells_.NumSites()));
        for (size_t i = 0; i < slopes_.size(); ++i) {
            // Slopes of the Beckmann distribution with alpha = 1.
            const double t = std::sqrt(-std::log1p(-UnitAt(stream, int32_t(i), 0)));
            const double phi = 2 * std::numbers::pi * UnitAt(stream, int32_t(i), 1);
            slopes_[i] = {t * std::cos(phi), t * std::sin(phi)};
        }
    }

    void Forward(std::span<const double> p, Surface* surface) override {
        if (!hasPattern_ || frequency_ != p[Frequency]) MakePattern(p[Frequency]);
        surface->reflectance = Reflectance::Flakes;
        surface->slopeX.resize(grid_.NumPoints());
        surface->slopeY.resize(grid_.NumPoints());
        const double alpha = p[FlakeNdf] * p[FlakeNdf];
        for (size_t i = 0; i < grid_.NumPoints(); ++i) {
            surface->slopeX[i] = alpha * slopes_[size_t(flake_[i])][0];
            surface->slopeY[i] = alpha * slopes_[size_t(flake_[i])][1];
        }
        surface->topF0 = p[TopF0];
        surface->topRoughness = p[TopRough];
        surface->flakeRoughness = p[FlakeRough];
        surface->glowWeight = p[GlowWeight];
        surface->glowF0 = p[GlowF0];
        surface->glowRoughness = p[GlowRough];
        for (size_t k = 0; k < 3; ++k) {
            surface->albedo[k].assign(1, p[Red + k]);
            surface->flakeF0[k] = p[FlakeRed + k];
        }
    }

    void Backward(std::span<const double> p, const Surface&, Surface* adjoint,
                  std::span<double> byParameters) override {
        double byAlpha = 0;
        for (size_t i = 0; i < grid_.NumPoints(); ++i) {
            const auto& slope = slopes_[size_t(flake_[i])];
            byAlpha += adjoint->slopeX[i] * slope[0] + adjoint->slopeY[i] * slope[1];
        }
        byParameters[FlakeNdf] += byAlpha * 2 * p[FlakeNdf];
        byParameters[TopF0] += adjoint->topF0;
        byParameters[TopRough] += adjoint->topRoughness;
        byParameters[FlakeRough] += adjoint->flakeRoughness;
        byParameters[GlowWeight] += adjoint->glowWeight;
        byParameters[GlowF0] += adjoint->glowF0;
        byParameters[GlowRough] += adjoint->glowRoughness;
        for (size_t k = 0; k < 3; ++k) {
            byParameters[Red + k] += adjoint->albedo[k][0];
            byParameters[FlakeRed + k] += adjoint->flakeF0[k];
        }
    }

  private:
    static int PeriodOf(const MapGrid& grid, double stretch, std::span<const double> parameters) {
        if (!grid.isPeriodic) return kPeriod;
        return std::max(5, int(std::lround(grid.extent * parameters[Frequency] * stretch)));
    }

    /// Which flake is where. Flakes are flat, and their edges have no width: almost everywhere nothing
    /// changes with a small change of the frequency.
    void MakePattern(double frequency) {
        hasPattern_ = true;
        frequency_ = frequency;
        const bool fits = grid_.isPeriodic;
        const double perX = fits ? cells_.PeriodX() / grid_.extent : frequency * stretchX_;
        const double perY = fits ? cells_.PeriodY() / grid_.extent : frequency * stretchY_;
        NearestSites sites(cells_);
        for (int row = 0; row < grid_.size; ++row)
            for (int column = 0; column < grid_.size; ++column)
                flake_[size_t(row) * size_t(grid_.size) + size_t(column)] =
                    sites.At(grid_.X(column) * perX + shiftX_, grid_.Y(row) * perY + shiftY_).site;
    }

    MapGrid grid_;
    double stretchX_, stretchY_;
    Cells cells_;
    std::vector<int> flake_;
    std::vector<std::array<double, 2>> slopes_;
    double shiftX_ = 0, shiftY_ = 0;
    bool hasPattern_ = false;  ///< of this seed, at frequency_
    double frequency_ = 0;
};

class Flakes final : public MaterialModel {
  public:
    std::string_view Name() const override { return "flakes"; }
    std::span<const ModelParameter> Parameters() const override { return kTable; }
    Reflectance ReflectanceKind() const override { return Reflectance::Flakes; }
    bool HasCells() const override { return true; }
    std::unique_ptr<ModelRun> MakeRun(const MapGrid& grid, const ModelKinds& kinds,
                                      std::span<const double> parameters) const override {
        return std::make_unique<FlakesRun>(grid, kinds, parameters);
    }
};

}  // namespace

const MaterialModel& FlakesModel() {
    static const Flakes model;
    return model;
}

}  // namespace lacquer::estimate
