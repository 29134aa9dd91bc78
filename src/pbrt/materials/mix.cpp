// Material "mix": at each hit one of two materials, chosen at random.
//
//   "string materials" [2]  required  earlier named materials, not interfaces
//   "float texture amount"  0.5       probability of the second one
//   "string normalmap"      -         has no effect
#include <fmt/format.h>

#include "pbrt/base/emitting_material.h"
#include "pbrt/base/material.h"
#include "pbrt/base/stack_boundary.h"
#include "pbrt/base/warnings.h"

namespace lacquer {
namespace {

class MixMaterial final : public Material, public NoStackBoundary, public HasWarnings {
  public:
    /// What follows from the parts is stored: a mix may name another one twice, and that one the next, so
    /// that asking the parts each time would take a time exponential in the depth.
    MixMaterial(const Material* first, const Material* second, const FloatTexture* amount, uint64_t seed,
                std::vector<Diagnostic> warnings)
        : first_(first),
          second_(second),
          amount_(amount),
          seed_(seed),
          hasSubsurface_(first->HasSubsurface() || second->HasSubsurface()),
          transmits_(first->Transmits() || second->Transmits()),
          needsFootprint_(!amount->Constant() || first->NeedsFootprint() || second->NeedsFootprint()),
          warnings_(std::move(warnings)) {}

    const Material* Choose(const TextureContext& context, Vec3 wo) const override {
        // A loop: mixes may be nested deeper than a thread's stack reaches.
        const Part* drawn = &Draw(context, wo);
        while (drawn->mix) drawn = &drawn->mix->Draw(context, wo);
        return drawn->material->Choose(context, wo);
    }
    /// Renderers ask Choose() first, which knows the direction; without one the draw is by position alone.
    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        return Choose(context, Vec3(0))->MakeBxDF(context, lambda, arena);
    }
    bool HasSubsurface() const override { return hasSubsurface_; }
    bool Transmits() const override { return transmits_; }
    std::string WhyNoStackBoundary() const override {
        return "is a mixture; expected one material: mix whole layered materials instead";
    }
    bool NeedsFootprint() const override { return needsFootprint_; }
    std::span<const Diagnostic> Warnings() const override { return warnings_; }

  private:
    struct Part {
        explicit Part(const Material* named)
            : material(named), mix(dynamic_cast<const MixMaterial*>(named)) {}
        const Material* material;
        const MixMaterial* mix;  ///< the same, where it is a mix
    };

    const Part& Draw(const TextureContext& context, Vec3 wo) const {
        const float amount = amount_->Evaluate(context);
        // A mix of mixes draws anew: the seed differs between mixtures.
        const float u = UnitFloat(Hash(Hash(context.p, wo), seed_));
        return u < amount ? second_ : first_;
    }

    Part first_, second_;
    const FloatTexture* amount_;
    uint64_t seed_;
    bool hasSubsurface_, transmits_, needsFootprint_;
    std::vector<Diagnostic> warnings_;
};

const Material* FindNamed(const MaterialArgs& args, const std::string& name) {
    const auto it = args.named.find(name);
    if (it == args.named.end()) {
        std::vector<std::string> names;
        for (const auto& [known, material] : args.named) names.push_back(known);
        args.params.Fail("materials", fmt::format("no material named \"{}\" stands before this mix{}", name,
                                                  DidYouMean(name, names)));
    }
    if (it->second->IsInvisible())
        args.params.Fail("materials",
                         fmt::format("\"{}\" is an interface material; expected one that scatters", name));
    if (const std::string why = it->second->WhyNotASurface(); !why.empty())
        args.params.Fail("materials", fmt::format("\"{}\" {}", name, why));
    return it->second;
}

uint64_t HashName(const std::string& name) {
    uint64_t hash = 0;
    for (const char c : name) hash = Hash(hash, c);
    return hash;
}

std::unique_ptr<Material> CreateMix(const MaterialArgs& args) {
    const std::vector<std::string> names = args.params.GetStrings("materials");
    if (names.size() != 2)
        args.params.Fail(
            "materials",
            fmt::format("\"materials\" has {} names; expected those of two named materials", names.size()));
    const FloatTexture* amount = FloatTextureParam(args.params, "amount", 0.5f, args.textures);
    // The format allows it on every material; those of the two materials count.
    args.params.Ignore("string", "normalmap");
    std::array<const Material*, 2> parts{};
    std::vector<Diagnostic> warnings;
    for (size_t i = 0; i < parts.size(); ++i) {
        parts[i] = FindNamed(args, names[i]);
        // A part that is a mix has warned of its own parts.
        const auto* emitting = dynamic_cast<const EmittingMaterial*>(parts[i]);
        if (emitting && emitting->EmissionParams())
            warnings.push_back({Diagnostic::Severity::Warning,
                                args.params.LocOf("materials"),
                                fmt::format("the emission of \"{}\" is left out: mixtures emit nothing; an "
                                            "AreaLightSource before the shape makes a light of it",
                                            names[i]),
                                {}});
    }
    return std::make_unique<MixMaterial>(parts[0], parts[1], amount,
                                         Hash(HashName(names[0]), HashName(names[1])), std::move(warnings));
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "mix", CreateMix);

}  // namespace lacquer
