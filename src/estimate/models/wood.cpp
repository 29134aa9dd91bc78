// Model "wood": growth rings of a distorted trunk, cut by a plane [Liu et al. 2016], under a rough dielectric
// interface.
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
    CenterX,
    CenterY,
    CenterZ,
    Ring,
    LatePower,
    LateFraction,
    EarlyRamp,
    LateRamp,
    GrainScale,
    GrainPower,
    WidthScale,
    WidthAmplitude,
    BendScale,
    BendAmplitude,
    CutAngle,
    Rough,
    EarlyRough,
    LateHeight,
    Vig,
    NumParameters
};
constexpr uint32_t kModelNumber = 6;
/// Of fine relief [cm], and the side of the square after which it repeats [cm].
constexpr double kReliefHeight = 0.005, kReliefPeriod = 25;
constexpr double kMinRough = 0.05, kMaxRough = 1;

constexpr std::array<ModelParameter, 25> kTable{{
    {"light",
     "cm^2",
     {"intensity of the light", "a white pixel is 1"},
     {2000, 500, 1, 5000},
     {1500, 500, 1, 2500}},
    {"r", "", "red albedo of early wood", {.4, .3, .01, .95}, {.4, .3, .01, .95}},
    {"g", "", "green albedo of early wood", {.2, .2, .01, .95}, {.2, .2, .01, .95}},
    {"b", "", "blue albedo of early wood", {.1, .1, .01, .95}, {.1, .1, .01, .95}},
    {"center_x", "cm", "horizontal place of the trunk's axis", {0, 5, -50, 50}, {-5, 10, -50, 50}, false},
    {"center_y", "cm", "vertical place of the trunk's axis", {0, 10, -50, 50}, {-5, 10, -50, 50}, false},
    {"center_z", "cm", "place along the trunk", {0, 1, -50, 50}, {0, 10, -50, 50}, false},
    {"ring", "cm", "width of a growth ring", {.5, .2, .1, 1}, {.1, .2, .01, 1}, false},
    {"lw_power",
     "",
     {"exponent of the albedo of late wood", "that of early wood to this power"},
     {2.5, 1, 1.2, 5},
     {2.5, 1, 1.2, 5}},
    {"lw_fraction", "rings", "place where late wood begins to end", {.5, .2, .1, .9}, {.5, .2, .1, .9}},
    {"ew_ramp", "rings", "width of the ramp from early to late wood", {.2, .05, .01, .4}, {.2, .05, .01, .4}},
    {"lw_ramp", "rings", "width of the ramp from late to early wood", {.2, .05, .01, .4}, {.2, .05, .01, .4}},
    {"ssn_scale", "1/cm", "frequency of fine variation of colour", {10, 5, 1, 50}, {10, 5, 1, 50}, false},
    {"ssn_power", "", "strength of fine variation of colour", {.5, .2, .001, 2}, {.5, .2, .001, 2}},
    {"grn_scale",
     "1/cm",
     "frequency at which widths of rings vary",
     {.5, .3, .001, 2},
     {.5, .3, .001, 2},
     false},
    {"grn_amp", "cm", "distance by which rings move", {.5, .3, .001, 2}, {.5, .3, .001, 2}, false},
    {"gdn_scale", "1/cm", "frequency of the trunk's distortion", {.3, .2, .001, 1}, {.3, .2, .001, 1}, false},
    {"gdn_amp", "cm", "amplitude of the trunk's distortion", {.5, .3, .001, 2}, {.5, .3, .001, 2}, false},
    {"cut",
     "degrees",
     "angle between the cut and the trunk's axis",
     {5, 1, -90, 90},
     {5, 10, -90, 90},
     false},
    {"rough", "", {"roughness of late wood", "alpha = rough^2"}, {.3, .1, .1, .8}, {.7, .1, .1, .8}},
    {"ew_rough", "", "roughness that early wood adds", {.1, .05, .01, .3}, {.7, .05, .01, .8}},
    {"lw_height",
     "cm",
     "height of late wood over early wood",
     {.005, .002, .0001, .01},
     {.005, .002, .0001, .01}},
    {"vig", "cm", "standard deviation of the vignette", {15, 2, 1, 20}, {15, 2, 1, 20}},
    kAxisX,
    kAxisY,
}};

/// The tables that a seed fills with numbers in [0,1).
struct Tables {
    PeriodicTable1 widths{100};
    PeriodicTable2 grain{100};
    PeriodicTable3 bend{20};

    void SetSeed(uint64_t seed) {
        Rng widthsRng(StreamOf(seed, kModelNumber, Component::RingWidths));
        for (double& v : widths.values) v = UnitDouble(&widthsRng);
        Rng grainRng(StreamOf(seed, kModelNumber, Component::Grain));
        for (double& v : grain.values) v = UnitDouble(&grainRng);
        Rng bendRng(StreamOf(seed, kModelNumber, Component::Distortion));
        for (auto& pair : bend.values)
            for (double& v : pair) v = UnitDouble(&bendRng);
    }
};

/// A point of the surface, from the plane to the parts of a ring, with what the way back needs.
struct RingPoint {
    double y = 0;
    std::array<double, 3> place{};  ///< in the trunk, before it is distorted
    PeriodicTable3::Sample bend{};
    double x1 = 0, y1 = 0, radius = 0;  ///< after, and the distance from the axis
    PeriodicTable1::Sample width{};
    double position = 0;             ///< in rings; its fraction is the place in the ring
    double rising = 0, falling = 0;  ///< the two ramps of late wood
    double late = 0;                 ///< 0 early, 1 late wood
    PeriodicTable2::Sample grain{};

    double Exponent(std::span<const double> p) const { return 1 + p[GrainPower] * grain.value; }
};

struct Cut {
    double sine, cosine;
    explicit Cut(double degrees)
        : sine(std::sin(degrees * std::numbers::pi / 180)),
          cosine(std::cos(degrees * std::numbers::pi / 180)) {}
};

RingPoint RingPointAt(double x, double y, const Cut& cut, std::span<const double> p, const Tables& tables) {
    RingPoint point;
    point.y = y;
    point.place = {x + p[CenterX], -y * cut.sine + p[CenterY], -y * cut.cosine + p[CenterZ]};
    const double bendScale = p[BendScale];
    point.bend =
        tables.bend.At(bendScale * point.place[0], bendScale * point.place[1], bendScale * point.place[2]);
    point.x1 = point.place[0] + p[BendAmplitude] * point.bend.value[0];
    point.y1 = point.place[1] + p[BendAmplitude] * point.bend.value[1];
    // Not 0 at the axis itself, where the derivative has no direction.
    point.radius = std::sqrt(point.x1 * point.x1 + point.y1 * point.y1 + 1e-8);
    point.width = tables.widths.At(p[WidthScale] * point.radius);
    point.position = (point.radius + p[WidthAmplitude] * point.width.value) / p[Ring];
    const double u = point.position - std::floor(point.position);
    point.rising = u / p[EarlyRamp];
    point.falling = (p[LateFraction] - u) / p[LateRamp] + 1;
    point.late = std::clamp(std::min(point.rising, point.falling), 0., 1.);
    point.grain = tables.grain.At(p[GrainScale] * point.x1, p[GrainScale] * point.y1);
    return point;
}

/// Derivatives by what a point gives.
struct RingPointAdjoint {
    double late = 0, exponent = 0;
};

/// From late wood and grain back to the parameters of the geometry.
void BackwardRings(const RingPoint& point, const Cut& cut, std::span<const double> p,
                   const RingPointAdjoint& by, std::span<double> out) {
    double byPosition = 0;
    const double ramp = std::min(point.rising, point.falling);
    if (ramp > 0 && ramp < 1) {
        if (point.rising < point.falling) {
            byPosition = by.late / p[EarlyRamp];
            out[EarlyRamp] -= by.late * point.rising / p[EarlyRamp];
        } else {
            byPosition = -by.late / p[LateRamp];
            out[LateFraction] += by.late / p[LateRamp];
            out[LateRamp] -= by.late * (point.falling - 1) / p[LateRamp];
        }
    }
    // Position in rings: (radius + amplitude width(scale radius)) / ring.
    out[Ring] -= byPosition * point.position / p[Ring];
    const double byMoved = byPosition / p[Ring], amplitude = p[WidthAmplitude];
    out[WidthAmplitude] += byMoved * point.width.value;
    out[WidthScale] += byMoved * amplitude * point.width.byU * point.radius;
    const double byRadius = byMoved * (1 + amplitude * point.width.byU * p[WidthScale]);
    // Grain.
    out[GrainPower] += by.exponent * point.grain.value;
    const double byGrain = by.exponent * p[GrainPower];
    out[GrainScale] += byGrain * (point.grain.byU * point.x1 + point.grain.byV * point.y1);
    const double byX = byRadius * point.x1 / point.radius + byGrain * point.grain.byU * p[GrainScale];
    const double byY = byRadius * point.y1 / point.radius + byGrain * point.grain.byV * p[GrainScale];
    // Distortion.
    out[BendAmplitude] += byX * point.bend.value[0] + byY * point.bend.value[1];
    std::array<double, 3> byPlace{byX, byY, 0};
    for (size_t k = 0; k < 3; ++k) {
        const double byArgument = p[BendAmplitude] * (byX * point.bend.by[0][k] + byY * point.bend.by[1][k]);
        out[BendScale] += byArgument * point.place[k];
        byPlace[k] += byArgument * p[BendScale];
    }
    for (size_t k = 0; k < 3; ++k) out[CenterX + k] += byPlace[k];
    out[CutAngle] +=
        (byPlace[1] * -point.y * cut.cosine + byPlace[2] * point.y * cut.sine) * std::numbers::pi / 180;
}

class WoodRun final : public ModelRun {
  public:
    WoodRun(const MapGrid& grid, const ModelKinds& kinds)
        : grid_(grid), noise_(kinds.noise, NoiseMap::kTexels), relief_(grid.NumPoints()) {
        grid_.isPeriodic = false;
    }

    void SetSeed(uint64_t seed) override {
        tables_.SetSeed(seed);
        noise_.SetSeed(StreamOf(seed, kModelNumber, Component::Noise));
        const uint64_t shift = StreamOf(seed, kModelNumber, Component::Shift);
        const double u0 = NoiseMap::kTexels * UnitAt(shift, 0, 0),
                     v0 = NoiseMap::kTexels * UnitAt(shift, 0, 1);
        const double perTexel = NoiseMap::kTexels / kReliefPeriod;
        for (int row = 0; row < grid_.size; ++row)
            for (int column = 0; column < grid_.size; ++column)
                relief_[size_t(row) * size_t(grid_.size) + size_t(column)] =
                    kReliefHeight *
                    noise_.At(grid_.X(column) * perTexel + u0, grid_.Y(row) * perTexel + v0).value;
    }

    void Forward(std::span<const double> p, Surface* surface) override {
        const size_t count = grid_.NumPoints();
        surface->reflectance = Reflectance::Dielectric;
        surface->height.resize(count);
        surface->roughness.resize(count);
        for (Field& field : surface->albedo) field.resize(count);
        const Cut cut(p[CutAngle]);
        const Colors colors(p);
        for (int row = 0; row < grid_.size; ++row)
            for (int column = 0; column < grid_.size; ++column) {
                const size_t i = size_t(row) * size_t(grid_.size) + size_t(column);
                const RingPoint point = RingPointAt(grid_.X(column), grid_.Y(row), cut, p, tables_);
                surface->height[i] = p[LateHeight] * point.late + relief_[i];
                surface->roughness[i] =
                    std::clamp(p[Rough] + p[EarlyRough] * (1 - point.late), kMinRough, kMaxRough);
                const double exponent = point.Exponent(p);
                for (size_t k = 0; k < 3; ++k)
                    surface->albedo[k][i] = std::pow(colors.Mix(k, point.late), exponent);
            }
        SlopesOf(grid_, surface->height, &surface->slopeX, &surface->slopeY);
    }

    void Backward(std::span<const double> p, const Surface& surface, Surface* adjoint,
                  std::span<double> byParameters) override {
        SlopesAdjoint(grid_, adjoint->slopeX, adjoint->slopeY, adjoint->height);
        const Cut cut(p[CutAngle]);
        const Colors colors(p);
        std::array<double, NumParameters> sums{};
        const size_t n = size_t(grid_.size);
        for (size_t i = 0; i < n * n; ++i) {
            // Made again rather than kept: 200 bytes for each point.
            const RingPoint point = RingPointAt(grid_.X(int(i % n)), grid_.Y(int(i / n)), cut, p, tables_);
            RingPointAdjoint by = BackwardColors(i, point, colors, p, surface, *adjoint, &sums);
            by.late += adjoint->height[i] * p[LateHeight];
            sums[LateHeight] += adjoint->height[i] * point.late;
            const double r = p[Rough] + p[EarlyRough] * (1 - point.late);
            if (r > kMinRough && r < kMaxRough) {
                sums[Rough] += adjoint->roughness[i];
                sums[EarlyRough] += adjoint->roughness[i] * (1 - point.late);
                by.late -= adjoint->roughness[i] * p[EarlyRough];
            }
            BackwardRings(point, cut, p, by, sums);
        }
        for (size_t k = 0; k < NumParameters; ++k) byParameters[k] += sums[k];
    }

  private:
    /// Albedos of early and late wood.
    struct Colors {
        std::array<double, 3> early{}, late{};
        explicit Colors(std::span<const double> p) {
            for (size_t k = 0; k < 3; ++k) {
                early[k] = p[Red + k];
                late[k] = std::pow(early[k], p[LatePower]);
            }
        }
        double Mix(size_t k, double part) const { return early[k] + part * (late[k] - early[k]); }
    };

    static RingPointAdjoint BackwardColors(size_t i, const RingPoint& point, const Colors& colors,
                                           std::span<const double> p, const Surface& surface,
                                           const Surface& adjoint, std::array<double, NumParameters>* sums) {
        const double exponent = point.Exponent(p);
        RingPointAdjoint by;
        for (size_t k = 0; k < 3; ++k) {
            const double mix = colors.Mix(k, point.late);
            const double byColor = adjoint.albedo[k][i] * surface.albedo[k][i];
            by.exponent += byColor * std::log(mix);
            const double byMix = byColor * exponent / mix;
            by.late += byMix * (colors.late[k] - colors.early[k]);
            (*sums)[Red + k] +=
                byMix * (1 - point.late + point.late * p[LatePower] * colors.late[k] / colors.early[k]);
            (*sums)[LatePower] += byMix * point.late * colors.late[k] * std::log(colors.early[k]);
        }
        return by;
    }

    MapGrid grid_;
    NoiseMap noise_;
    Tables tables_;
    Field relief_;
};

class Wood final : public MaterialModel {
  public:
    std::string_view Name() const override { return "wood"; }
    std::span<const ModelParameter> Parameters() const override { return kTable; }
    Reflectance ReflectanceKind() const override { return Reflectance::Dielectric; }
    bool HasNoise() const override { return true; }
    bool CanTile() const override { return false; }
    std::unique_ptr<ModelRun> MakeRun(const MapGrid& grid, const ModelKinds& kinds,
                                      std::span<const double>) const override {
        return std::make_unique<WoodRun>(grid, kinds);
    }
};

}  // namespace

const MaterialModel& WoodModel() {
    static const Wood model;
    return model;
}

}  // namespace lacquer::estimate
