// Material "slab": matter between two interfaces of a "layered" material.
//
//   "float eta" or "spectrum eta"  1.5        index of refraction, relative to the vacuum
//   "float texture thickness"      1          in the unit of 1/sigma_t; >= 0
//   "spectrum texture sigma_t"     0          extinction per unit of thickness
//   "spectrum texture albedo"      0          single-scattering albedo, in [0, 1]
//   "float texture rotation"       0          rotates the phase function about the normal [degrees]
//   "string phase"                 isotropic  and its parameters: see pbrt/phases
//   "string bulk"                  -          a file of "lacquer bulk" that has sigma_t [1/mm], albedo and
//                                             the phase function; thickness is in mm then
#include "layered/materials/slab.h"

#include <fmt/format.h>

#include "pbrt/base/constant_texture.h"
#include "pbrt/phases/bulk.h"
#include "pbrt/phases/phase_params.h"

namespace lacquer::layered {
namespace {

/// Deeper slabs are as black as this one, and products with it stay finite.
constexpr float kMaxOpticalThickness = 1e6f;

}  // namespace

Slab SlabMaterial::MakeSlab(const TextureContext& context, SampledWavelengths& lambda, const Frame& frame,
                            Arena& arena) const {
    const float thickness = std::max(0.f, textures_.thickness->Evaluate(context));
    if (!(thickness > 0)) return {};
    const SampledSpectrum opticalThickness =
        Clamp(textures_.sigma_t->Evaluate(context, lambda) * thickness, 0, kMaxOpticalThickness);
    if (!opticalThickness) return {};
    const SampledSpectrum albedo = Clamp(textures_.albedo->Evaluate(context, lambda), 0, 1);
    // An oriented medium absorbs by direction even where it does not scatter.
    const bool needsPhase = albedo || phase_->IsOriented();
    if (phase_->HasChromaticExtinction()) lambda.TerminateSecondary();
    return {opticalThickness, albedo, needsPhase ? phase_->Make({frame, lambda, &context}, arena) : nullptr};
}

bool SlabMaterial::NeedsFootprint() const {
    return !textures_.thickness->Constant() || !textures_.sigma_t->IsConstant() ||
           !textures_.albedo->IsConstant() || !phase_->IsConstant();
}

namespace {

/// A phase function that a texture turns about the stack's normal.
class RotatedPhaseModel final : public PhaseModel {
  public:
    /// @param rotation  [degrees]; not null
    RotatedPhaseModel(std::unique_ptr<PhaseModel> model, const FloatTexture* rotation)
        : model_(std::move(model)), rotation_(rotation) {}

    const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const override {
        const float angle = rotation_->Evaluate(*context.textures) * (Pi / 180);
        if (!std::isfinite(angle)) return model_->Make(context, arena);
        const float s = std::sin(angle), c = std::cos(angle);
        const Frame turned = Nested(context.frame, {{c, s, 0}, {-s, c, 0}, {0, 0, 1}});
        return model_->Make({turned, context.lambda, context.textures}, arena);
    }
    bool IsOriented() const override { return model_->IsOriented(); }
    bool IsChromatic() const override { return model_->IsChromatic(); }
    bool HasChromaticExtinction() const override { return model_->HasChromaticExtinction(); }
    bool IsConstant() const override { return rotation_->Constant() && model_->IsConstant(); }
    int NumParts() const override { return model_->NumParts(); }

  private:
    std::unique_ptr<PhaseModel> model_;
    const FloatTexture* rotation_;
};

/// A slab, to those who read the parameters of its phase function.
class SlabOwner final : public PhaseOwner {
  public:
    explicit SlabOwner(const MaterialArgs& args) : args_(args) {}
    const char* Kind() const override { return "slab"; }
    const char* KindOfMany() const override { return "slabs"; }
    TextureLibrary* Textures() const override { return &args_.textures; }
    const PhaseModel* Find(const Params& params, const std::string& name) const override {
        const auto it = args_.named.find(name);
        if (it == args_.named.end()) {
            std::vector<std::string> slabs;
            for (const auto& [known, material] : args_.named)
                if (dynamic_cast<const SlabMaterial*>(material)) slabs.push_back(known);
            params.Fail("phases", fmt::format("no slab named \"{}\" stands before this one{}", Excerpt(name),
                                              DidYouMean(name, slabs)));
        }
        if (it->second->IsPlaceholder()) return nullptr;
        const auto* slab = dynamic_cast<const SlabMaterial*>(it->second);
        if (!slab)
            params.Fail(
                "phases",
                fmt::format("\"{}\" is no slab; expected one, whose phase function is mixed", Excerpt(name)));
        return &slab->Phase();
    }

  private:
    const MaterialArgs& args_;
};

/// The model, turned by `"rotation"`.
std::unique_ptr<PhaseModel> WithRotation(const MaterialArgs& args, std::unique_ptr<PhaseModel> model) {
    const FloatTexture* rotation = OptionalFloatTextureParam(args.params, "rotation", args.textures);
    if (!rotation || !model->IsOriented()) return model;
    return std::make_unique<RotatedPhaseModel>(std::move(model), rotation);
}

/// `"sigma_t"` and `"albedo"`.
void ReadScattering(const MaterialArgs& args, SlabMaterial::Textures& textures) {
    const Params& params = args.params;
    textures.sigma_t = SpectrumTextureParam(params, "sigma_t", SpectrumKind::Unbounded, 0, args.textures);
    textures.albedo = SpectrumTextureParam(params, "albedo", SpectrumKind::Albedo, 0, args.textures);
    // RGB values are checked by what reads them; samples and named spectra may be anything.
    if (!params.GetTextureName("albedo"))
        if (const auto albedo = params.GetSpectrum("albedo", SpectrumKind::Albedo);
            albedo && albedo->MaxValue() > 1.0001f)
            params.Fail("albedo",
                        fmt::format("\"albedo\" of slab \"{}\" reaches {}; expected values in [0, 1]",
                                    args.name, albedo->MaxValue()));
}

/// The file's, with a warning if its particles were computed in another matter than the slab's.
void TakeScattering(const MaterialArgs& args, const BulkPhaseModel& bulk, SlabMaterial::Textures& textures,
                    std::vector<Diagnostic>& warnings) {
    const auto own = [&](DenselySampledSpectrum spectrum) {
        return args.textures.Own(std::make_unique<SpectrumConstantTexture>(
            std::make_unique<DenselySampledSpectrum>(std::move(spectrum))));
    };
    textures.sigma_t = own(bulk.SigmaT());
    textures.albedo = own(bulk.Albedo());
    warnings.assign(bulk.Warnings().begin(), bulk.Warnings().end());
    constexpr double kMaxDifference = 0.01;
    constexpr float kGreen = 550;
    SampledWavelengths green = SampledWavelengths::SampleUniform(0, kGreen, kGreen);
    const double eta = double(textures.eta.At(green));
    if (std::abs(eta - bulk.HostIndex()) > kMaxDifference)
        warnings.push_back({Diagnostic::Severity::Warning, args.params.LocOf("eta"),
                            fmt::format("the index of this slab is {:.4g}, but \"bulk\" is of particles in "
                                        "matter of index {:.4g}; they scatter as they would there",
                                        eta, bulk.HostIndex())});
}

std::unique_ptr<Material> CreateSlab(const MaterialArgs& args) {
    const Params& params = args.params;
    SlabMaterial::Textures textures;
    textures.eta = IndexOfRefraction::Read(params);
    textures.thickness = FloatTextureParam(params, "thickness", 1, args.textures);
    if (const float t = textures.thickness->Constant().value_or(0); t < 0)
        params.Fail("thickness",
                    fmt::format("\"thickness\" of slab \"{}\" is {}; expected one that is not negative",
                                args.name, t));
    std::vector<Diagnostic> warnings;
    const SlabOwner owner(args);
    std::unique_ptr<PhaseModel> phase = ReadPhaseModel({params, owner}, "isotropic");
    if (const auto* bulk = BulkPhaseModel::Of(*phase))
        TakeScattering(args, *bulk, textures, warnings);
    else
        ReadScattering(args, textures);
    return std::make_unique<SlabMaterial>(std::move(textures), WithRotation(args, std::move(phase)),
                                          std::move(warnings));
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "slab", CreateSlab);

}  // namespace lacquer::layered
