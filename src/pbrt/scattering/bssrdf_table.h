// How light that enters a half space of a scattering medium comes out again, as a function of the distance.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "pbrt/scattering/catmull_rom.h"

namespace lacquer {

/// First and second moment of the dielectric reflectance, the integrals of Fr(c) c and Fr(c) c^2 over the
/// cosine c in [0,1], as polynomials in eta [d'Eon and Irving 2011]. A beam that arrives in a medium has
/// eta = index on the other side over index on its own side.
float FresnelMoment1(float eta);
float FresnelMoment2(float eta);

/// Radiant exitance at distance r of a beam that enters a half space at normal incidence, in units of the
/// beam's power, at a boundary with index eta; per unit of area. Extinction is sigma_a + sigma_s > 0, all in
/// the same unit of length as r. Light that scattered once, and light that scattered more often, by photon
/// beam diffusion [Habel et al. 2013] with 100 equal steps of probability along the beam.
/// @param g  mean cosine, |g| < 1 or sigma_a > 0
double BeamDiffusionSingle(double sigma_s, double sigma_a, double g, double eta, double r);
double BeamDiffusionMultiple(double sigma_s, double sigma_a, double g, double eta, double r);

/// The profile of a half space for all albedos and distances. Distances are in mean free paths ("optical"):
/// the extinction is 1. The values are 2 pi r times the profile, whose integral over r is the effective
/// albedo. The nodes are those of pbrt-v4, so that both interpolate alike. Cost of one: about 30 ms, 30 kB.
/// Immutable.
class BssrdfTable {
  public:
    static constexpr int kNumAlbedos = 100, kNumRadii = 64;
    /// Forward scattering beyond this is indistinguishable from none.
    static constexpr float kMaxG = 0.99f;

    /// @param g    mean cosine of the phase function, limited to [-kMaxG, kMaxG]
    /// @param eta  index inside over index outside, > 0
    BssrdfTable(float g, float eta);
    /// The table of these two numbers, made once as long as somebody holds it. Thread-safe.
    static std::shared_ptr<const BssrdfTable> Shared(float g, float eta);

    std::span<const float> Albedos() const { return albedos_; }
    std::span<const float> Radii() const { return radii_; }
    /// At each albedo of Albedos(): the share of the light let in that comes out again, as diffusion has it:
    /// it may exceed 1.
    std::span<const float> EffectiveAlbedos() const { return effectiveAlbedos_; }
    /// Single-scattering albedo with which that share comes out; within [0,1].
    float InvertEffectiveAlbedo(float share) const;

  private:
    friend class BssrdfSlice;
    size_t At(int albedo, int radius) const { return size_t(albedo) * kNumRadii + size_t(radius); }

    std::array<float, kNumAlbedos> albedos_, effectiveAlbedos_;
    std::array<float, kNumRadii> radii_;
    std::vector<float> profile_, cdf_;  // [albedo][radius]
};

/// The table at one albedo. A plain value; the table must outlive it. Where diffusion lets out more than came
/// in, which is near albedo 1 (by 2 % at index 1.33 and g = 0, more for smaller indices and negative g), the
/// profile is scaled down to let out all; pbrt-v4 makes light there.
class BssrdfSlice {
  public:
    BssrdfSlice() = default;
    /// @param albedo  clamped to [0,1]
    BssrdfSlice(const BssrdfTable& table, float albedo);

    float EffectiveAlbedo() const { return effectiveAlbedo_; }
    /// Radiant exitance per unit of power that was let in, at optical distance r >= 0; 0 beyond the table.
    float Profile(float r) const;
    /// An optical distance, density 2 pi r Profile(r) / EffectiveAlbedo(). 0 if nothing comes out.
    float SampleRadius(float u) const;

  private:
    const BssrdfTable* table_ = nullptr;
    SplineWeights weights_{};
    float effectiveAlbedo_ = 0, scale_ = 1;
};

}  // namespace lacquer
