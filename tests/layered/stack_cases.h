// The stacks that the truth tests examine, and small words to write such stacks down. Knows no test
// framework: benchmarks use the same table.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "layered/layered_bxdf.h"
#include "pbrt/core/arena.h"
#include "pbrt/scattering/microfacet.h"
#include "support/lanes.h"

namespace lacquer::layered::test {

using lacquer::test::Lanes;

/// Builds one stack, from the outside in; interfaces that follow each other get an empty slab between them.
class StackBuilder {
  public:
    explicit StackBuilder(Arena& arena) : arena_(arena) {}
    Arena& Memory() { return arena_; }

    /// @param eta  index below the interface over index above it
    void AddInterface(BxDF* bxdf, float eta = 1);
    void AddSlab(const Slab& slab);
    /// The frame of the next interface: its normal in the stack's frame, and a turn of the tangent about it
    /// [degrees]. The tangent is the stack's x, projected.
    void TurnNext(Vec3 normal, float deg);

    /// Lives in the arena.
    Stack Build() const;
    const LayeredBxDF* BuildBxDF(const LayeredOptions& options) const;

  private:
    struct Arrays {
        std::span<StackInterface> interfaces;
        std::span<BxDF*> bxdfs;
        std::span<Slab> slabs;
    };
    Arrays ToArena() const;

    Arena& arena_;
    std::vector<StackInterface> interfaces_;
    std::vector<BxDF*> bxdfs_;
    std::vector<Slab> slabs_;
    Frame frame_;
    bool isTurned_ = false;
    float eta_ = 1;
};

/// One entry of a stack: an interface or a slab.
using Layer = std::function<void(StackBuilder&)>;
/// Makes a phase function in an arena.
using PhaseMaker = std::function<const PhaseFunction*(Arena&)>;

constexpr auto kGGX = MicrofacetModel::TrowbridgeReitz;
constexpr auto kBeckmann = MicrofacetModel::Beckmann;

// Interfaces. `eta`: index below over index above; alphas of 0 are smooth.
Layer Dielectric(float alpha, float eta, MicrofacetModel model = kGGX);
Layer Dielectric(Alphas alphas, float eta, MicrofacetModel model = kGGX);
/// Copper-like: different at each wavelength.
Layer Metal(float alpha, MicrofacetModel model = kGGX);
Layer Metal(Alphas alphas, MicrofacetModel model = kGGX);
/// Copper as [Guo et al. 2018] have it: lanes are red, green, blue, blue, and its index is relative to air
/// whatever lies above it.
Layer Copper(float alpha, MicrofacetModel model = kGGX);
/// Reflects everything: R = 1 at all angles.
Layer Mirror(float alpha, MicrofacetModel model = kGGX);
/// The same, never smooth, with the light that meets several of their facets.
Layer RescatteringDielectric(Alphas alphas, float eta, MicrofacetModel model = kGGX);
Layer RescatteringMetal(Alphas alphas, MicrofacetModel model = kGGX);
Layer RescatteringMirror(Alphas alphas, MicrofacetModel model = kGGX);
Layer Diffuse(SampledSpectrum reflectance);
Layer Diffuse(float reflectance);
Layer DiffuseSheet(float reflectance, float transmittance);
Layer ThinPane(float eta);
/// Some copper-like flakes, or clear plates: light is reflected by facets and goes straight on between them.
Layer Flakes(float alpha, bool areClear = false);
/// The interface that is not there.
Layer Nothing();
/// An interface that lets nothing through and reflects nothing.
Layer Black();
/// The interface with its normal perturbed to `normal` (any length).
Layer Tilted(Vec3 normal, const Layer& interface);
/// The interface rotated about its normal.
Layer Rotated(float deg, const Layer& interface);
/// Both.
Layer Turned(Vec3 normal, float deg, const Layer& interface);

// Slabs. An optical thickness is sigma_t times thickness.
Layer Medium(SampledSpectrum opticalThickness, SampledSpectrum albedo, const PhaseMaker& phase);
Layer Medium(float opticalThickness, float albedo, const PhaseMaker& phase);
/// Absorbs only.
Layer Absorber(SampledSpectrum opticalThickness);
Layer Absorber(float opticalThickness);

// Phase functions.
PhaseMaker Isotropic();
PhaseMaker HG(float g);
PhaseMaker VMF(float kappa);
/// A table with a rainbow at 140 degrees and a forward peak.
PhaseMaker Rainbow();
/// From forward to backward over the wavelengths.
PhaseMaker SpectralRainbow();
PhaseMaker SggxFibres(Vec3 orientation, float roughness);
PhaseMaker SggxSheets(Vec3 orientation, float roughness);
/// An oriented ensemble that absorbs along its axis and scatters across it.
PhaseMaker OrientedEnsemble(Vec3 orientation);
PhaseMaker Fibres(Vec3 orientation, float stddev);
/// Parts with their weights.
PhaseMaker Mixture(float weightA, const PhaseMaker& a, float weightB, const PhaseMaker& b);

/// A row of the table. Names have letters, digits and underscores only.
struct StackCase {
    std::string name;
    std::vector<Layer> layers;
    bool isSmall = false;     ///< also in the fast subset
    bool isLossless = false;  ///< all light leaves, whatever its direction
    bool isSmooth = false;    ///< all interfaces are specular

    Stack Build(Arena& arena) const;
    /// The same as a BxDF that is not two-sided.
    const LayeredBxDF* MakeBxDF(Arena& arena, const LayeredOptions& options) const;
};

/// All rows. A new kind of interface or slab adds a line to the table in stack_cases.cpp.
const std::vector<StackCase>& StackCases();
/// The row of this name; it must exist.
const StackCase& FindStackCase(const std::string& name);

/// One of the registered estimators as a material makes it whose parameters are the defaults;
/// "multiproduct:5" has 5 `productevents`, "pairproduct:all:9" has the `pairstrategies` "all" and 9
/// `pairevents`. Lives as long as the program. Errors: SceneError for what the estimator does not take.
const LayeredEstimator* FindEstimator(const std::string& name);
const LayeredPdf* FindPdf(const std::string& name);
/// The names of all that have the same expectation.
std::vector<std::string> UnbiasedEstimators();

/// True if light can come out below.
bool Transmits(const Stack& stack);
/// True if optical thicknesses, albedos or interfaces may differ over wavelengths; judged by the slabs.
bool IsSpectral(const Stack& stack);

}  // namespace lacquer::layered::test
