// Model "metal": brushed metal, scratches along x.
#include <array>

#include "estimate/models/material_model.h"
#include "estimate/models/relief.h"
#include "estimate/models/streams.h"

namespace lacquer::estimate {
namespace {

enum : size_t { Light, Red, Green, Blue, RoughX, RoughY, Fsx, Fsy, Height, Vig };
constexpr uint32_t kModelNumber = 4;

// The published amplitude `fscale` [cm^2] gives an rms height of fscale sqrt(pi fsx fsy / 2) / extent: 0.0354
// fscale at the published extent of 25 cm and the means of fsx and fsy. Below a roughness of 0.03 the
// highlight is narrower than a pixel, and no photograph tells it.
constexpr std::array<ModelParameter, 12> kTable{{
    {"light",
     "cm^2",
     {"intensity of the light", "a white pixel is 1"},
     {999, 300, 100, 2000},
     {1500, 300, 100, 2500}},
    {"r", "", {"red reflectance", "at normal incidence"}, {.4, .2, 0, 1}, {.4, .1, 0, .2}},
    {"g", "", {"green reflectance", "at normal incidence"}, {.4, .2, 0, 1}, {.4, .1, 0, .2}},
    {"b", "", {"blue reflectance", "at normal incidence"}, {.4, .2, 0, 1}, {.4, .1, 0, .2}},
    {"roughx", "", {"roughness along x", "alpha = roughx^2"}, {.1, .1, .03, .8}, {.3, .1, .2, .8}},
    {"roughy", "", {"roughness along y", "alpha = roughy^2"}, {.4, .1, .03, .8}, {.3, .1, .2, .8}},
    {"fsx",
     "cycles/cm",
     "standard deviation of the spectrum of heights along scratches",
     {.05, .05, .001, .2},
     {.01, 2, .001, 1}},
    {"fsy",
     "cycles/cm",
     "standard deviation of the spectrum of heights across scratches",
     {10, 2, .001, 20},
     {10, 3, 1, 500}},
    {"height", "cm", "rms height", {.000354, .000709, .00001, .01}, {.000354, .00354, .00001, .01}},
    {"vig", "cm", "standard deviation of the vignette", {10, 3, 5, 20}, {15, 3, 5, 20}},
    kAxisX,
    kAxisY,
}};

class MetalRun final : public ModelRun {
  public:
    explicit MetalRun(const MapGrid& grid) : grid_(grid), relief_(grid.size, grid.extent) {
        grid_.isPeriodic = true;  // as all sums of waves are
    }
    void SetSeed(uint64_t seed) override {
        relief_.SetPhases(StreamOf(seed, kModelNumber, Component::Phase));
    }
    void Forward(std::span<const double> p, Surface* surface) override {
        surface->reflectance = Reflectance::Metal;
        surface->height.resize(grid_.NumPoints());
        relief_.Forward(p[Height], p[Fsx], p[Fsy], surface->height);
        SlopesOf(grid_, surface->height, &surface->slopeX, &surface->slopeY);
        for (size_t k = 0; k < 3; ++k) surface->albedo[k].assign(1, p[Red + k]);
        surface->roughnessX = p[RoughX];
        surface->roughnessY = p[RoughY];
    }
    void Backward(std::span<const double>, const Surface&, Surface* adjoint,
                  std::span<double> byParameters) override {
        SlopesAdjoint(grid_, adjoint->slopeX, adjoint->slopeY, adjoint->height);
        const SpectralRelief::Adjoint relief = relief_.Backward(adjoint->height);
        byParameters[Height] += relief.rms;
        byParameters[Fsx] += relief.sx;
        byParameters[Fsy] += relief.sy;
        byParameters[RoughX] += adjoint->roughnessX;
        byParameters[RoughY] += adjoint->roughnessY;
        for (size_t k = 0; k < 3; ++k) byParameters[Red + k] += adjoint->albedo[k][0];
    }

  private:
    MapGrid grid_;
    SpectralRelief relief_;
};

class Metal final : public MaterialModel {
  public:
    std::string_view Name() const override { return "metal"; }
    std::span<const ModelParameter> Parameters() const override { return kTable; }
    Reflectance ReflectanceKind() const override { return Reflectance::Metal; }
    std::unique_ptr<ModelRun> MakeRun(const MapGrid& grid, const ModelKinds&,
                                      std::span<const double>) const override {
        return std::make_unique<MetalRun>(grid);
    }
};

}  // namespace

const MaterialModel& MetalModel() {
    static const Metal model;
    return model;
}

}  // namespace lacquer::estimate
