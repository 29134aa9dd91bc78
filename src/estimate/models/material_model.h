// The procedural models of materials: parameters and a seed give a surface.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "estimate/models/cells.h"
#include "estimate/models/noise_map.h"
#include "estimate/models/surface.h"
#include "estimate/parameters.h"

namespace lacquer::estimate {

/// What a parameter is, for people.
struct ParameterMeaning {
    /// A noun without an article that stands well in a list of others: "roughness of late wood".
    std::string_view label;
    std::string_view note;  ///< conventions and units: "alpha = rough^2"; may be empty
    constexpr ParameterMeaning(const char* what, const char* convention = "")
        : label(what), note(convention) {}
    std::string Full() const { return std::string(label) + (note.empty() ? "" : "; ") + std::string(note); }
};

/// A parameter of a model, with two published sets of priors [Guo et al. 2020].
struct ModelParameter {
    std::string_view name, unit;
    ParameterMeaning meaning;
    Prior prior;      ///< the default
    Prior demoPrior;  ///< of the set "demo"
    bool smooth = true;
    /// Fixed at `fixedValue` unless asked for.
    bool optional = false;
    double fixedValue = 0;
};

/// Choices between kinds, which no derivative joins.
struct ModelKinds {
    CellKind cells = CellKind::Jittered;
    NoiseKind noise = NoiseKind::Spectral;
};

/// "jittered", "poisson-disc", "stretched"; "spectral", "band-limited", "ridged": in the order of the kinds.
std::span<const std::string_view> CellKindNames();
std::span<const std::string_view> NoiseKindNames();

/// A model on one grid, with what a seed made and what the last Forward() kept for Backward(). Belongs to one
/// thread.
class ModelRun {
  public:
    virtual ~ModelRun() = default;
    /// Makes all that is random: phases, cells, noise, shifts. Before the first Forward().
    virtual void SetSeed(uint64_t seed) = 0;
    /// @param parameters  in natural units, in the order of the model's table
    virtual void Forward(std::span<const double> parameters, Surface* surface) = 0;
    /// Adds to `byParameters` the derivatives of a number, of which `adjoint` has those by what the last
    /// Forward() gave. May change `adjoint`. What the photograph alone reads (light, vignette, place of the
    /// axis) is left alone.
    virtual void Backward(std::span<const double> parameters, const Surface& surface, Surface* adjoint,
                          std::span<double> byParameters) = 0;
};

/// One of the models.
class MaterialModel {
  public:
    virtual ~MaterialModel() = default;
    virtual std::string_view Name() const = 0;
    /// The first four are light and albedo (light, r, g, b); "vig", "axis_x" and "axis_y" are there as well.
    virtual std::span<const ModelParameter> Parameters() const = 0;
    virtual Reflectance ReflectanceKind() const = 0;
    virtual bool HasCells() const { return false; }
    virtual bool HasNoise() const { return false; }
    /// False if its surface cannot repeat: growth rings.
    virtual bool CanTile() const { return true; }
    /// @param parameters  read only if the grid is periodic: whole numbers of cells or texels then fit the
    /// square,
    ///                    as near to what the parameters ask for as can be
    virtual std::unique_ptr<ModelRun> MakeRun(const MapGrid& grid, const ModelKinds& kinds,
                                              std::span<const double> parameters) const = 0;
    /// Place of a name in the table, or -1.
    int Find(std::string_view name) const;
};

/// bump, leather, plaster, metal, flakes, wood.
std::span<const MaterialModel* const> AllModels();
/// Null if there is none.
const MaterialModel* FindModel(std::string_view name);

/// The surface of a seed, on any grid: for maps larger than a photograph, and with isPeriodic for maps that
/// tile.
/// @param parameters  all of the model, in natural units
Surface MakeSurface(const MaterialModel& model, const MapGrid& grid, const ModelKinds& kinds,
                    std::span<const double> parameters, uint64_t seed);

// The models, each in its file.
const MaterialModel& BumpModel();
const MaterialModel& LeatherModel();
const MaterialModel& PlasterModel();
const MaterialModel& MetalModel();
const MaterialModel& FlakesModel();
const MaterialModel& WoodModel();

/// Where the axis of camera and light meets the sample: the last two rows of each table.
constexpr ModelParameter kAxisX{
    "axis_x",      "cm",          {"horizontal place of the camera's axis", "where it meets the sample"},
    {0, 1, -5, 5}, {0, 1, -5, 5}, true,
    true};
constexpr ModelParameter kAxisY{
    "axis_y",      "cm",          {"vertical place of the camera's axis", "where it meets the sample"},
    {0, 1, -5, 5}, {0, 1, -5, 5}, true,
    true};

}  // namespace lacquer::estimate
