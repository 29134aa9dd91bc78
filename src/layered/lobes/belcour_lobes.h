// A stack as a few lobes: the atomic operators and the adding-doubling of [Belcour 2018].
#pragma once

#include <array>

#include "layered/stack.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {

/// What a stack does to the light along wo, apart from what the first interface reflects: for each deeper one
/// a lobe of its energy and spread, one for what passes, and a cosine lobe for what diffuse layers reflect.
/// The mean direction of all is that of smooth interfaces. An approximation: see docs/layered.md.
///
/// Energies, means and spreads follow the atomic operators and the adding-doubling of [Belcour 2018].
/// What differs: reflectances of single interfaces are those of their own facets, with what these shadow;
/// spreads of Beckmann's facets add as those of Gaussian slopes; refracted spreads are those of half vectors
/// (slopes/facet_map.h). Normal maps and anisotropy are left out, but for the mean roughness.
class BelcourLobes {
  public:
    /// A lobe as one rough mirror that is seen from outside; on the other side of the stack its image.
    struct Lobe {
        SampledSpectrum energy;  ///< its part of the light along wo
        float alpha;             ///< 0: specular
        bool isTransmitted;
    };

    /// @param rng  for interfaces whose BxDF draws; else unused
    BelcourLobes(const Stack& stack, Vec3 wo, Rng* rng);

    /// f - f0 of lobes that are not specular [1/sr], without the cosine of wi.
    SampledSpectrum Evaluate(Vec3 wi, TransportMode mode) const;
    /// The density of SampleDirection() [1/sr].
    float Pdf(Vec3 wi) const;
    /// Draws a direction by the energies of the lobes, cosine lobes on both sides where light may leave with
    /// a small share included. Empty where the lobe has no light. Specular lobes are left out.
    std::optional<Vec3> SampleDirection(float lobe, Point2 u) const;

    /// The parts of the light along wo that leave, means over the wavelengths: reflected by the first
    /// interface, and in rough lobes.
    float EnergyOfFirst() const { return first_.Average(); }
    float EnergyOfRough() const { return rough_; }
    /// Index on the other side over index on wo's.
    float Eta() const { return eta_; }
    SampledSpectrum SpecularEnergy(bool isTransmitted) const;
    std::span<const Lobe> Lobes() const { return {lobes_.data(), size_t(numLobes_)}; }

  private:
    friend class LayerAdder;
    void Add(const Lobe& lobe);
    void Finish();
    /// wi as the lobe of a mirror on wo's side has it; false where that has none.
    bool ToMirror(Vec3 wi, Vec3* mirrored) const;
    MicrofacetTerms TermsOf(float alpha, Vec3 mirrored) const;
    Vec3 SampleMirrored(float alpha, Point2 u) const;
    /// Of the cosine lobe on one side.
    float CosineShare(bool isTransmitted) const;

    static constexpr int kMaxLobes = 12;
    Vec3 wo_;       ///< above the first interface
    bool isAbove_;  ///< so it was
    bool transmits_ = false;
    MicrofacetModel model_ = MicrofacetModel::Beckmann;
    float eta_;  ///< index on the other side of the stack over index on this side
    std::array<Lobe, kMaxLobes> lobes_;
    std::array<float, kMaxLobes> normalisation_;  ///< what shadowing leaves of a lobe
    int numLobes_ = 0;
    SampledSpectrum first_{0}, diffuse_{0}, diffuseBelow_{0};
    float rough_ = 0;
    float scattered_ = 0;  ///< by slabs, out of all lobes: not in Evaluate()
};

}  // namespace lacquer::layered
