// Material "slab": matter between two interfaces of a "layered" material.
//   eta          float or spectrum   1.5        index of refraction, relative to the vacuum
//   thickness    float texture       1          in the unit of 1/sigma_t; >= 0
//   sigma_t      spectrum texture    0          extinction per unit of thickness
//   albedo       spectrum texture    0          single-scattering albedo, in [0,1]
//   rotation     float texture       0          turns the phase function about the normal [degrees]
//   phase        string              isotropic  what directions light scatters into, with
//     "isotropic"
//     "hg"       g            float texture     0        mean cosine, in [-1,1]
//     "vmf"      kappa        float texture     1        concentration >= 0
//     "table"    table        float[n]          required values at equal steps of the cosine from -1 to 1
//     "mixture"  phases       string[n]         required earlier slabs, whose phase functions are mixed
//                weights      float[n]          equal    of extinction
//     "sggx"     orientation  vector3           0 0 1    of fibres, or normal of sheets; x is the tangent
//                orientationmap  string         -        or an image of it, 2c-1, as a normal map
//                roughness    float texture     0.1      in [0,1]; 1: flakes of all directions
//                flakes       string            fibre    or surface
//     "fibre"    orientation, orientationmap as above
//                stddev       float texture     0.1      of the cosine between flakes' normals and fibre, > 0
#include "layered/materials/slab.h"

#include <fmt/format.h>

namespace lacquer::layered {
namespace {

/// Deeper slabs are as black as this one, and products with it stay finite.
constexpr float kMaxOpticalThickness = 1e6f;

}  // namespace

Slab SlabMaterial::MakeSlab(const TextureContext& context, const SampledWavelengths& lambda,
                            const Frame& frame, Arena& arena) const {
    const float thickness = std::max(0.f, textures_.thickness->Evaluate(context));
    if (!(thickness > 0)) return {};
    const SampledSpectrum opticalThickness =
        Clamp(textures_.sigma_t->Evaluate(context, lambda) * thickness, 0, kMaxOpticalThickness);
    if (!opticalThickness) return {};
    const SampledSpectrum albedo = Clamp(textures_.albedo->Evaluate(context, lambda), 0, 1);
    // An oriented medium absorbs by direction even where it does not scatter.
    const bool needsPhase = albedo || phase_->IsOriented();
    return {opticalThickness, albedo, needsPhase ? MakePhase(context, frame, arena) : nullptr};
}

const PhaseFunction* SlabMaterial::MakePhase(const TextureContext& context, const Frame& frame,
                                             Arena& arena) const {
    if (!textures_.rotation || !phase_->IsOriented()) return phase_->Make(context, frame, arena);
    const float angle = textures_.rotation->Evaluate(context) * (Pi / 180);
    if (!std::isfinite(angle)) return phase_->Make(context, frame, arena);
    const float s = std::sin(angle), c = std::cos(angle);
    return phase_->Make(context, Nested(frame, {{c, s, 0}, {-s, c, 0}, {0, 0, 1}}), arena);
}

bool SlabMaterial::NeedsFootprint() const {
    const auto varies = [](const FloatTexture* texture) { return texture && !texture->Constant(); };
    return varies(textures_.thickness) || varies(textures_.rotation) || !textures_.sigma_t->IsConstant() ||
           !textures_.albedo->IsConstant() || !phase_->IsConstant();
}

namespace {

std::unique_ptr<Material> CreateSlab(const MaterialArgs& args) {
    const Params& params = args.params;
    TextureLibrary& library = args.textures;
    SlabMaterial::Textures textures;
    textures.eta = IndexOfRefraction::Read(params);
    textures.thickness = FloatTextureParam(params, "thickness", 1, library);
    if (const float t = textures.thickness->Constant().value_or(0); t < 0)
        params.Fail("thickness",
                    fmt::format("\"thickness\" of slab \"{}\" is {}; expected one that is not negative",
                                args.name, t));
    textures.sigma_t = SpectrumTextureParam(params, "sigma_t", SpectrumKind::Unbounded, 0, library);
    textures.albedo = SpectrumTextureParam(params, "albedo", SpectrumKind::Albedo, 0, library);
    // RGB values are checked by what reads them; samples and named spectra may be anything.
    if (!params.GetTextureName("albedo"))
        if (const auto albedo = params.GetSpectrum("albedo", SpectrumKind::Albedo);
            albedo && albedo->MaxValue() > 1.0001f)
            params.Fail("albedo",
                        fmt::format("\"albedo\" of slab \"{}\" reaches {}; expected values in [0, 1]",
                                    args.name, albedo->MaxValue()));
    textures.rotation = OptionalFloatTextureParam(params, "rotation", library);
    return std::make_unique<SlabMaterial>(std::move(textures), ReadSlabPhase(args));
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "slab", CreateSlab);

}  // namespace lacquer::layered
