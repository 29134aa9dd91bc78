// A stack of textures: what all layered materials are.
#pragma once

#include "layered/lambertian/coat_tables.h"
#include "layered/layered_bxdf.h"
#include "layered/materials/slab.h"
#include "pbrt/base/stack_boundary.h"

namespace lacquer::layered {

/// An interface of a stack and the slab below it.
struct StackEntry {
    const Material* interface = nullptr;  ///< null: nothing is there, light goes straight on
    /// The role of `interface` where it depends on the media around it; null: it is the same everywhere.
    const StackBoundary* boundary = nullptr;
    const SlabMaterial* slab = nullptr;  ///< null: empty; always null for the last entry
    /// The nested stacks with frames of their own (a normal map, a rotation) that hold the interface and the
    /// slab, outermost first.
    std::vector<const Material*> aroundInterface, aroundSlab;

    StackEntry() = default;
    /// Nothing around either.
    explicit StackEntry(const Material* interfaceMaterial, const SlabMaterial* slabBelow = nullptr)
        : interface(interfaceMaterial),
          boundary(dynamic_cast<const StackBoundary*>(interfaceMaterial)),
          slab(slabBelow) {}
};
using StackEntries = std::vector<StackEntry>;

/// Longer stacks are scene errors: all of it is made anew at each hit.
inline constexpr size_t kMaxStackInterfaces = 64;

struct LayeredSettings {
    std::unique_ptr<const LayeredEstimator> estimator;
    std::unique_ptr<const LayeredPdf> pdf;
    LayeredOptions options;         ///< refers to the two above
    std::optional<float> etaBelow;  ///< index below the last interface over index above the first
};

/// Makes a LayeredBxDF at each hit. The index above the first interface is 1, those between follow from the
/// slabs; where nothing lies between two interfaces, it is what the upper one lets light into.
class LayeredMaterial final : public Material {
  public:
    /// @param entries  at least one, at most kMaxStackInterfaces
    /// @param parts    materials among the entries that have no other owner
    LayeredMaterial(StackEntries entries, LayeredSettings settings,
                    std::vector<std::unique_ptr<Material>> parts = {});

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override;
    bool NeedsFootprint() const override;
    bool Transmits() const override;
    std::string WhyNoVertices() const override;
    /// What a stack that this one is nested in takes over: nothing but the layers.
    const StackEntries& Entries() const { return entries_; }

  private:
    BxDF* MakeLayers(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const;
    BoundaryMedia MediaAround(size_t i, float etaAbove, SampledWavelengths& lambda) const;
    /// Of the first interface, where it is the same everywhere and the tables know it.
    std::optional<CoatCurves> MakeTopCurves() const;
    StackInterface MakeStackInterface(const StackEntry& entry, BxDF* bxdf,
                                      const TextureContext& context) const;

    StackEntries entries_;
    LayeredSettings settings_;
    std::vector<std::unique_ptr<Material>> parts_;
    bool needsFootprint_;
    std::optional<CoatCurves> topCurves_;
};

}  // namespace lacquer::layered
