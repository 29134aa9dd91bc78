// Materials "coateddiffuse" and "coatedconductor": a dielectric coat over a base, seen alike from both sides.
// Both:
//
//   "float texture thickness"  0.01  of the coat, whose extinction is 1: it absorbs even at albedo 0
//   "spectrum texture albedo"  0     single-scattering albedo of the coat
//   "float texture g"          0     mean cosine of its scattering
//   "integer maxdepth"         10    events inside after which a path ends
//   "integer nsamples"         1     estimates that one evaluation averages
//   "estimator", "pdf", and the parameters of these: as for "layered"
//   "remaproughness", "distribution": of both interfaces, see roughness.h
//   "bool multiscatter"        false of both interfaces: also light that meets several of their facets
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
//
// "coateddiffuse":
//   "spectrum texture reflectance"  0.5  of the base
//   "float eta" or "spectrum eta"   1.5  index of the coat
//   "roughness", "uroughness", "vroughness": of the coat, see roughness.h
//
// "coatedconductor":
//   "conductor.eta", "conductor.k", or "reflectance": as for "conductor", divided by the index of the coat
//   "float interface.eta" or "spectrum interface.eta"  1.5  index of the coat
//   "interface.roughness", "interface.uroughness", "interface.vroughness": of the coat
//   "conductor.roughness", "conductor.uroughness", "conductor.vroughness": of the base
#include "layered/materials/stack_builder.h"
#include "pbrt/base/constant_texture.h"
#include "pbrt/materials/parts.h"
#include "pbrt/phases/hg.h"

namespace lacquer::layered {
namespace {

/// The slab between the interfaces.
std::unique_ptr<SlabMaterial> MakeCoat(const MaterialArgs& args, const std::string& prefix) {
    const Params& params = args.params;
    TextureLibrary& library = args.textures;
    SlabMaterial::Textures textures;
    textures.eta = IndexOfRefraction::Read(params, prefix + "eta");
    textures.thickness = FloatTextureParam(params, "thickness", 0.01f, library);
    textures.sigma_t =
        library.Own(std::make_unique<SpectrumConstantTexture>(std::make_unique<ConstantSpectrum>(1.f)));
    textures.albedo = SpectrumTextureParam(params, "albedo", SpectrumKind::Albedo, 0, library);
    return std::make_unique<SlabMaterial>(
        std::move(textures), MakeHenyeyGreensteinPhaseModel(FloatTextureParam(params, "g", 0, library)));
}

/// @param prefix  before the names of the coat's index and roughness
std::unique_ptr<Material> MakeCoated(const MaterialArgs& args, const std::string& prefix,
                                     std::unique_ptr<Material> base) {
    auto top = MakeDielectricPart(RoughnessTextures::Read(args.params, args.textures, prefix),
                                  args.params.GetBool("multiscatter", false));
    auto coat = MakeCoat(args, prefix);
    LayeredSettings settings = ReadLayeredSettings(args);
    settings.options.isTwoSided = true;
    // Unlike that of "layered", a maxdepth of 0 leaves the reflection by the coat only.
    settings.options.maxVertices =
        VerticesOfDepth(args.params.GetIntInRange("maxdepth", 10, 0, std::numeric_limits<int>::max()));

    StackEntries entries{StackEntry(top.get(), coat.get()), StackEntry(base.get())};
    std::vector<std::unique_ptr<Material>> parts;
    parts.push_back(std::move(top));
    parts.push_back(std::move(coat));
    parts.push_back(std::move(base));
    auto material =
        std::make_unique<LayeredMaterial>(std::move(entries), std::move(settings), std::move(parts));
    material->ReadBump(args.params, args.textures);
    return material;
}

std::unique_ptr<Material> CreateCoatedDiffuse(const MaterialArgs& args) {
    return MakeCoated(args, "", MakeDiffusePart(args.params, args.textures));
}

std::unique_ptr<Material> CreateCoatedConductor(const MaterialArgs& args) {
    return MakeCoated(args, "interface.", MakeConductorPart(args.params, args.textures, "conductor."));
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "coateddiffuse", CreateCoatedDiffuse, {.isLayered = true});
LACQUER_REGISTER(MaterialKind, "coatedconductor", CreateCoatedConductor, {.isLayered = true});

}  // namespace lacquer::layered
