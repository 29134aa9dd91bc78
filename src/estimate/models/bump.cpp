// Model "bump": a diffuse surface with random bumps under a rough dielectric interface.
#include <array>

#include "estimate/models/material_model.h"
#include "estimate/models/relief.h"
#include "estimate/models/streams.h"

namespace lacquer::estimate {
namespace {

enum : size_t { Light, Red, Green, Blue, Rough, Fsigma, Height, Vig };
constexpr uint32_t kModelNumber = 1;

// The published amplitude `fscale` [cm^2] gives an rms height of fscale sqrt(pi / 2) fsigma / extent: the
// prior of `height` is that of fscale at the published extent of 25 cm and the mean of fsigma.
constexpr std::array<ModelParameter, 10> kTable{{
    {"light",
     "cm^2",
     {"intensity of the light", "a white pixel is 1"},
     {999, 400, 1, 2500},
     {1500, 400, 1, 2500}},
    {"r", "", "red diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"g", "", "green diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"b", "", "blue diffuse albedo", {.4, .3, 0, 1}, {.4, .3, 0, 1}},
    {"rough", "", {"roughness", "alpha = rough^2"}, {.2, .1, .01, .5}, {.4, .1, .2, .6}},
    {"fsigma",
     "cycles/cm",
     "standard deviation of the spectrum of heights",
     {1, .5, .02, 2},
     {5, 2, .02, 10}},
    {"height", "cm", "rms height", {.02507, .01003, .0001, .1}, {.02507, .02507, .0001, .1}},
    {"vig", "cm", "standard deviation of the vignette", {10, 3, 5, 20}, {15, 3, 5, 20}},
    kAxisX,
    kAxisY,
}};

class BumpRun final : public ModelRun {
  public:
    explicit BumpRun(const MapGrid& grid) : grid_(grid), relief_(grid.size, grid.extent) {
        grid_.isPeriodic = true;  // as all sums of waves are
    }
    void SetSeed(uint64_t seed) override {
        relief_.SetPhases(StreamOf(seed, kModelNumber, Component::Phase));
    }
    void Forward(std::span<const double> p, Surface* surface) override {
        surface->reflectance = Reflectance::Dielectric;
        surface->height.resize(grid_.NumPoints());
        relief_.Forward(p[Height], p[Fsigma], p[Fsigma], surface->height);
        SlopesOf(grid_, surface->height, &surface->slopeX, &surface->slopeY);
        for (size_t k = 0; k < 3; ++k) surface->albedo[k].assign(1, p[Red + k]);
        surface->roughness.assign(1, p[Rough]);
    }
    void Backward(std::span<const double>, const Surface&, Surface* adjoint,
                  std::span<double> byParameters) override {
        SlopesAdjoint(grid_, adjoint->slopeX, adjoint->slopeY, adjoint->height);
        const SpectralRelief::Adjoint relief = relief_.Backward(adjoint->height);
        byParameters[Height] += relief.rms;
        byParameters[Fsigma] += relief.sx + relief.sy;
        byParameters[Rough] += adjoint->roughness[0];
        for (size_t k = 0; k < 3; ++k) byParameters[Red + k] += adjoint->albedo[k][0];
    }

  private:
    MapGrid grid_;
    SpectralRelief relief_;
};

class Bump final : public MaterialModel {
  public:
    std::string_view Name() const override { return "bump"; }
    std::span<const ModelParameter> Parameters() const override { return kTable; }
    Reflectance ReflectanceKind() const override { return Reflectance::Dielectric; }
    std::unique_ptr<ModelRun> MakeRun(const MapGrid& grid, const ModelKinds&,
                                      std::span<const double>) const override {
        return std::make_unique<BumpRun>(grid);
    }
};

}  // namespace

const MaterialModel& BumpModel() {
    static const Bump model;
    return model;
}

}  // namespace lacquer::estimate
