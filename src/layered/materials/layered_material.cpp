#include "layered/materials/layered_material.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "layered/lambertian/lambertian_base.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/core/check.h"

namespace lacquer::layered {

namespace {

bool VariesOver(const StackEntry& entry) {
    const auto needs = [](const Material* m) { return m && m->NeedsFootprint(); };
    return needs(entry.interface) || needs(entry.slab) ||
           std::any_of(entry.aroundInterface.begin(), entry.aroundInterface.end(), needs) ||
           std::any_of(entry.aroundSlab.begin(), entry.aroundSlab.end(), needs);
}

/// The frame inside of nested stacks, in that of the outermost one.
Frame FrameInside(const std::vector<const Material*>& around, const TextureContext& context) {
    Frame frame;
    for (const Material* material : around) frame = Nested(frame, material->BumpedFrame(context));
    return frame;
}

/// Reflects nothing and lets everything pass.
BxDF* MakeNothing(Arena& arena) { return arena.New<DielectricBxDF<TrowbridgeReitz>>(Alphas(0, 0), 1.f); }

}  // namespace

LayeredMaterial::LayeredMaterial(StackEntries entries, LayeredSettings settings,
                                 std::vector<std::unique_ptr<Material>> parts)
    : entries_(std::move(entries)),
      settings_(std::move(settings)),
      parts_(std::move(parts)),
      needsFootprint_(std::any_of(entries_.begin(), entries_.end(), VariesOver)) {
    LACQUER_CHECK(!entries_.empty() && entries_.size() <= kMaxStackInterfaces);
    LACQUER_CHECK(settings_.options.estimator && settings_.options.pdf);
    topCurves_ = MakeTopCurves();
}

bool LayeredMaterial::NeedsFootprint() const { return HasBump() || needsFootprint_; }

bool LayeredMaterial::Transmits() const {
    const Material* last = entries_.back().interface;
    return !last || last->Transmits();
}

std::string LayeredMaterial::WhyNoVertices() const {
    if (!settings_.estimator->IsLobes()) return {};
    std::vector<std::string> others = Registry<LayeredEstimatorKind>::Names();
    std::erase_if(others, [](const std::string& name) {
        return Registry<LayeredEstimatorKind>::TraitsOf(name).isApproximate;
    });
    return fmt::format("an approximate estimator knows no paths within a stack; estimators that do: {}",
                       fmt::join(others, ", "));
}

BoundaryMedia LayeredMaterial::MediaAround(size_t i, float etaAbove, SampledWavelengths& lambda) const {
    const StackEntry& entry = entries_[i];
    if (entry.slab) return {etaAbove, entry.slab->Eta(lambda)};
    if (i + 1 < entries_.size()) return {etaAbove, std::nullopt};
    // A single interface without any word about what lies below has the index of its material.
    if (entries_.size() == 1) return {etaAbove, settings_.etaBelow};
    return {etaAbove, settings_.etaBelow.value_or(1)};
}

std::optional<CoatCurves> LayeredMaterial::MakeTopCurves() const {
    const StackEntry& top = entries_.front();
    if (entries_.size() != 2 || !top.boundary || top.interface->NeedsFootprint()) return std::nullopt;
    // At no point and for any light: where it is another boundary after all, these curves are not asked.
    Arena arena;
    SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.5f);
    const TextureContext context;
    const BxDF* const bxdf = top.boundary->MakeBoundary(context, lambda, arena, MediaAround(0, 1, lambda));
    if (!bxdf) return std::nullopt;
    const StackInterface interface(bxdf);
    LambertianBase coat;
    // Of smooth boundaries the curves are closed forms but for R.
    if (!FindCoat(interface, &coat) || coat.alpha == 0) return std::nullopt;
    const bool isConstantSlab = top.slab && !top.slab->NeedsFootprint();
    const Slab slab = isConstantSlab ? top.slab->MakeSlab(context, lambda, Frame(), arena) : Slab();
    return CoatCurves(coat.model, coat.alpha, coat.eta, slab.opticalThickness[0]);
}

StackInterface LayeredMaterial::MakeStackInterface(const StackEntry& entry, BxDF* bxdf,
                                                   const TextureContext& context) const {
    const bool isBumped = entry.interface && entry.interface->HasBump();
    if (!isBumped && entry.aroundInterface.empty()) return StackInterface(bxdf);
    Frame frame = FrameInside(entry.aroundInterface, context);
    if (isBumped) frame = Nested(frame, entry.interface->BumpedFrame(context));
    return {bxdf, frame};
}

BxDF* LayeredMaterial::MakeBxDF(const TextureContext& context, SampledWavelengths& lambda,
                                Arena& arena) const {
    const bool hasOneWavelength = lambda.SecondaryTerminated();
    BxDF* bxdf = MakeLayers(context, lambda, arena);
    // An index that disperses has ended all wavelengths but the first. Layers above it are still those of the
    // ended ones, which would choose directions and flights without counting in the end.
    if (!hasOneWavelength && lambda.SecondaryTerminated()) bxdf = MakeLayers(context, lambda, arena);
    return bxdf;
}

BxDF* LayeredMaterial::MakeLayers(const TextureContext& context, SampledWavelengths& lambda,
                                  Arena& arena) const {
    const size_t count = entries_.size();
    const std::span<BxDF*> bxdfs = arena.NewArray<BxDF*>(count);
    const std::span<StackInterface> interfaces = arena.NewArray<StackInterface>(count);
    const std::span<Slab> slabs = arena.NewArray<Slab>(count - 1);

    float etaAbove = 1, eta = 1;
    for (size_t i = 0; i < count; ++i) {
        const StackEntry& entry = entries_[i];
        const BoundaryMedia media = MediaAround(i, etaAbove, lambda);
        float across = 1;
        if (entry.boundary) {
            across = entry.boundary->EtaAcross(lambda, media);
            bxdfs[i] = entry.boundary->MakeBoundary(context, lambda, arena, media);
        } else if (entry.interface) {
            bxdfs[i] = entry.interface->MakeBxDF(context, lambda, arena);
        }
        if (!bxdfs[i]) bxdfs[i] = MakeNothing(arena);
        interfaces[i] = MakeStackInterface(entry, bxdfs[i], context);
        if (entry.slab)
            slabs[i] = entry.slab->MakeSlab(context, lambda, FrameInside(entry.aroundSlab, context), arena);
        // The index below the whole is what the refractions amount to: f and eta must agree.
        eta = IndexOfRefraction::Limited(eta * across);
        etaAbove = IndexOfRefraction::Limited(media.etaBelow.value_or(etaAbove * across));
    }
    Stack stack;
    stack.slabs = slabs;
    stack.eta = eta;
    stack.topCurves = topCurves_ ? &*topCurves_ : nullptr;
    return arena.New<LayeredBxDF>(stack, interfaces, bxdfs, settings_.options);
}

}  // namespace lacquer::layered
