#include "materialx/surfaces.h"

#include <array>

namespace lacquer::materialx {
namespace {

using enum InputKind;

// The names are the same on both sides but for what is geometry.
constexpr SurfaceInput kOpenPBR[] = {
    {"base_weight", "base_weight"},
    {"base_color", "base_color", Color},
    {"base_diffuse_roughness", "base_diffuse_roughness"},
    {"base_metalness", "base_metalness"},
    {"specular_weight", "specular_weight"},
    {"specular_color", "specular_color", Color},
    {"specular_roughness", "specular_roughness"},
    {"specular_roughness_anisotropy", "specular_roughness_anisotropy"},
    {"specular_ior", "specular_ior"},
    {"transmission_weight", "transmission_weight"},
    {"transmission_color", "transmission_color", Color},
    {"transmission_depth", "transmission_depth"},
    {"transmission_scatter", "transmission_scatter", Ignored},
    {"transmission_scatter_anisotropy", "transmission_scatter_anisotropy", Ignored},
    {"transmission_dispersion_scale", "transmission_dispersion_scale"},
    {"transmission_dispersion_abbe_number", "transmission_dispersion_abbe_number"},
    {"subsurface_weight", "subsurface_weight"},
    {"subsurface_color", "subsurface_color", Color},
    {"subsurface_radius", "subsurface_radius", Ignored},
    {"subsurface_radius_scale", "subsurface_radius_scale", Ignored},
    {"subsurface_scatter_anisotropy", "subsurface_scatter_anisotropy"},
    {"fuzz_weight", "fuzz_weight"},
    {"fuzz_color", "fuzz_color", Color},
    {"fuzz_roughness", "fuzz_roughness"},
    {"coat_weight", "coat_weight"},
    {"coat_color", "coat_color", Color},
    {"coat_roughness", "coat_roughness"},
    {"coat_roughness_anisotropy", "coat_roughness_anisotropy"},
    {"coat_ior", "coat_ior"},
    {"coat_darkening", "coat_darkening", Ignored},
    {"thin_film_weight", "thin_film_weight"},
    {"thin_film_thickness", "thin_film_thickness"},
    {"thin_film_ior", "thin_film_ior"},
    {"emission_luminance", "emission_luminance"},
    {"emission_color", "emission_color", Color},
    {"geometry_opacity", "geometry_opacity"},
    {"geometry_thin_walled", "geometry_thin_walled", Bool},
    {"geometry_normal", "normalmap", Normal},
    {"geometry_coat_normal", "coat_normalmap", Normal},
    {"geometry_tangent", "", Ignored},
    {"geometry_coat_tangent", "", Ignored},
};

constexpr float kTurn = 360, kMicrometersPerNanometer = 1e-3f;
// Autodesk's Standard Surface, by what OpenPBR has in its place.
constexpr SurfaceInput kStandardSurface[] = {
    {"base", "base_weight", Float, 1, "1"},
    {"base_color", "base_color", Color},
    {"diffuse_roughness", "base_diffuse_roughness"},
    {"metalness", "base_metalness"},
    {"specular", "specular_weight"},
    {"specular_color", "specular_color", Color},
    {"specular_roughness", "specular_roughness", Float, 1, "0.2"},
    {"specular_IOR", "specular_ior"},
    {"specular_anisotropy", "specular_roughness_anisotropy"},
    {"specular_rotation", "rotation", Float, kTurn},
    {"transmission", "transmission_weight"},
    {"transmission_color", "transmission_color", Color},
    {"transmission_depth", "transmission_depth"},
    {"transmission_scatter", "", Ignored},
    {"transmission_scatter_anisotropy", "", Ignored},
    {"transmission_dispersion", "", Ignored},
    {"transmission_extra_roughness", "", Ignored},
    {"subsurface", "subsurface_weight"},
    {"subsurface_color", "subsurface_color", Color, 1, "1, 1, 1"},
    {"subsurface_radius", "", Ignored},
    {"subsurface_scale", "", Ignored},
    {"subsurface_anisotropy", "subsurface_scatter_anisotropy"},
    {"sheen", "fuzz_weight"},
    {"sheen_color", "fuzz_color", Color},
    {"sheen_roughness", "fuzz_roughness", Float, 1, "0.3"},
    {"coat", "coat_weight"},
    {"coat_color", "coat_color", Color},
    {"coat_roughness", "coat_roughness", Float, 1, "0.1"},
    {"coat_anisotropy", "coat_roughness_anisotropy"},
    {"coat_rotation", "coat_rotation", Float, kTurn},
    {"coat_IOR", "coat_ior", Float, 1, "1.5"},
    {"coat_normal", "coat_normalmap", Normal},
    {"coat_affect_color", "", Ignored},
    {"coat_affect_roughness", "", Ignored},
    {"thin_film_thickness", "thin_film_thickness", FilmInNano, kMicrometersPerNanometer},
    {"thin_film_IOR", "thin_film_ior", Float, 1, "1.5"},
    {"emission", "emission_luminance"},
    {"emission_color", "emission_color", Color},
    {"opacity", "geometry_opacity", Opacity},
    {"thin_walled", "geometry_thin_walled", Bool},
    {"normal", "normalmap", Normal},
    {"tangent", "", Ignored},
};

constexpr std::array kKinds = {SurfaceKind{"open_pbr_surface", kOpenPBR},
                               SurfaceKind{"standard_surface", kStandardSurface}};

}  // namespace

std::span<const SurfaceKind> SurfaceKinds() { return kKinds; }

}  // namespace lacquer::materialx
