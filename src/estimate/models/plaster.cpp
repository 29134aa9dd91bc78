// Model "plaster": noise that is cut off above, under a rough dielectric interface.
#include <algorithm>
#include <array>
#include <cmath>

#include "estimate/models/material_model.h"
#include "estimate/models/streams.h"

namespace lacquer::estimate {
namespace {

enum : size_t { Light, Red, Green, Blue, Rough, RoughVar, Height, Slope, Frequency, Vig };
constexpr uint32_t kModelNumber = 3;

// The published `scale` is the part of a map that fills an extent of 25 cm: 0.04 scale maps per cm.
constexpr std::array<ModelParameter, 12> kTable{{
    {"light",
     "cm^2",
     {"intensity of the light", "a white pixel is 1"},
     {999, 300, 100, 2500},
     {999, 300, 100, 2500}},
    {"r", "", "red diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"g", "", "green diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"b", "", "blue diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"rough", "", {"mean roughness", "alpha = rough^2"}, {.3, .2, .1, .8}, {.8, .2, .1, .8}},
    {"rough_var", "", "roughness that high places lack", {.2, .1, .001, .4}, {.2, .1, .001, .4}},
    {"height", "cm", "height at which the relief is cut off", {.2, .1, .001, .5}, {.2, .1, .001, .5}},
    {"slope", "", "contrast of the relief before it is cut off", {2, 1, 1, 4}, {2, 1, 1, 4}},
    {"frequency",
     "1/cm",
     {"lowest frequency of the noise", "512 texels"},
     {.02, .012, .0004, .04},
     {.02, .004, .0004, .04},
     false},
    {"vig", "cm", "standard deviation of the vignette", {10, 3, 5, 20}, {10, 3, 5, 20}},
    kAxisX,
    kAxisY,
}};

class PlasterRun final : public ModelRun {
  public:
    PlasterRun(const MapGrid& grid, const ModelKinds& kinds, std::span<const double> parameters)
        : grid_(grid),
          noise_(kinds.noise, TexelsOf(grid, parameters)),
          value_(grid.NumPoints()),
          byFrequency_(grid.NumPoints()) {}

    void SetSeed(uint64_t seed) override {
        noise_.SetSeed(StreamOf(seed, kModelNumber, Component::Noise));
        const uint64_t shift = StreamOf(seed, kModelNumber, Component::Shift);
        shiftX_ = NoiseMap::kTexels * UnitAt(shift, 0, 0);
        shiftY_ = NoiseMap::kTexels * UnitAt(shift, 0, 1);
        hasPattern_ = false;
    }

    void Forward(std::span<const double> p, Surface* surface) override {
        if (!hasPattern_ || frequency_ != p[Frequency]) MakePattern(p[Frequency]);
        const size_t count = grid_.NumPoints();
        surface->reflectance = Reflectance::Dielectric;
        surface->height.resize(count);
        surface->roughness.resize(count);
        for (size_t i = 0; i < count; ++i) {
            surface->height[i] = p[Height] * std::min(1., p[Slope] * value_[i]);
            surface->roughness[i] =
                std::clamp(p[Rough] + p[RoughVar] * (1 - 2 * value_[i]), kMinRough, kMaxRough);
        }
        SlopesOf(grid_, surface->height, &surface->slopeX, &surface->slopeY);
        for (size_t k = 0; k < 3; ++k) surface->albedo[k].assign(1, p[Red + k]);
    }

    void Backward(std::span<const double> p, const Surface&, Surface* adjoint,
                  std::span<double> byParameters) override {
        SlopesAdjoint(grid_, adjoint->slopeX, adjoint->slopeY, adjoint->height);
        double rough = 0, roughVar = 0, height = 0, slope = 0, frequency = 0;
        for (size_t i = 0; i < grid_.NumPoints(); ++i) {
            const double v = value_[i], byHeight = adjoint->height[i];
            const double r = p[Rough] + p[RoughVar] * (1 - 2 * v);
            const double byRough = r > kMinRough && r < kMaxRough ? adjoint->roughness[i] : 0;
            rough += byRough;
            roughVar += byRough * (1 - 2 * v);
            double byValue = -2 * p[RoughVar] * byRough;
            height += byHeight * std::min(1., p[Slope] * v);
            if (p[Slope] * v < 1) {
                slope += byHeight * p[Height] * v;
                byValue += byHeight * p[Height] * p[Slope];
            }
            frequency += byValue * byFrequency_[i];
        }
        byParameters[Rough] += rough;
        byParameters[RoughVar] += roughVar;
        byParameters[Height] += height;
        byParameters[Slope] += slope;
        if (!grid_.isPeriodic) byParameters[Frequency] += frequency;
        for (size_t k = 0; k < 3; ++k) byParameters[Red + k] += adjoint->albedo[k][0];
    }

  private:
    static constexpr double kMinRough = 0.1, kMaxRough = 0.8;

    static int TexelsOf(const MapGrid& grid, std::span<const double> parameters) {
        if (!grid.isPeriodic) return NoiseMap::kTexels;
        return std::max(8, int(std::lround(grid.extent * parameters[Frequency] * NoiseMap::kTexels)));
    }

    /// Noise where it comes to lie at a frequency, and how it changes with that.
    void MakePattern(double frequency) {
        hasPattern_ = true;
        frequency_ = frequency;
        const double perTexel =
            grid_.isPeriodic ? noise_.Texels() / grid_.extent : NoiseMap::kTexels * frequency;
        for (int row = 0; row < grid_.size; ++row)
            for (int column = 0; column < grid_.size; ++column) {
                const size_t i = size_t(row) * size_t(grid_.size) + size_t(column);
                const double x = grid_.X(column), y = grid_.Y(row);
                const auto noise = noise_.At(x * perTexel + shiftX_, y * perTexel + shiftY_);
                value_[i] = noise.value;
                byFrequency_[i] = NoiseMap::kTexels * (noise.byU * x + noise.byV * y);
            }
    }

    MapGrid grid_;
    NoiseMap noise_;
    double shiftX_ = 0, shiftY_ = 0;
    bool hasPattern_ = false;  ///< of this seed, at frequency_
    double frequency_ = 0;
    Field value_, byFrequency_;
};

class Plaster final : public MaterialModel {
  public:
    std::string_view Name() const override { return "plaster"; }
    std::span<const ModelParameter> Parameters() const override { return kTable; }
    Reflectance ReflectanceKind() const override { return Reflectance::Dielectric; }
    bool HasNoise() const override { return true; }
    std::unique_ptr<ModelRun> MakeRun(const MapGrid& grid, const ModelKinds& kinds,
                                      std::span<const double> parameters) const override {
        return std::make_unique<PlasterRun>(grid, kinds, parameters);
    }
};

}  // namespace

const MaterialModel& PlasterModel() {
    static const Plaster model;
    return model;
}

}  // namespace lacquer::estimate
