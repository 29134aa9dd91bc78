#include "layered/openpbr/openpbr_parameters.h"

#include <fmt/format.h>

#include "pbrt/scattering/fresnel.h"

namespace lacquer::layered {
namespace {

enum Number : size_t {
    kBaseWeight,
    kBaseDiffuseRoughness,
    kBaseMetalness,
    kSpecularWeight,
    kSpecularRoughness,
    kSpecularAnisotropy,
    kSpecularIor,
    kTransmissionWeight,
    kTransmissionDepth,
    kDispersionScale,
    kAbbeNumber,
    kSubsurfaceWeight,
    kSubsurfaceAnisotropy,
    kFuzzWeight,
    kFuzzRoughness,
    kCoatWeight,
    kCoatRoughness,
    kCoatAnisotropy,
    kCoatIor,
    kThinFilmWeight,
    kThinFilmThickness,
    kThinFilmIor,
    kOpacity,
};
struct NumberParameter {
    const char* name;
    float value, low, high;
};
constexpr float kMaxNumber = 1e6f;
// Defaults and limits of the specification; indices are kept from 1e-3, which no medium has.
constexpr NumberParameter kNumberParameters[] = {
    {"base_weight", 1, 0, 1},
    {"base_diffuse_roughness", 0, 0, 1},
    {"base_metalness", 0, 0, 1},
    {"specular_weight", 1, 0, kMaxNumber},
    {"specular_roughness", 0.3f, 0, 1},
    {"specular_roughness_anisotropy", 0, 0, 1},
    {"specular_ior", 1.5f, 1e-3f, 1e3f},
    {"transmission_weight", 0, 0, 1},
    {"transmission_depth", 0, 0, kMaxNumber},
    {"transmission_dispersion_scale", 0, 0, 1},
    {"transmission_dispersion_abbe_number", 20, 1, kMaxNumber},
    {"subsurface_weight", 0, 0, 1},
    {"subsurface_scatter_anisotropy", 0, -0.99f, 0.99f},
    {"fuzz_weight", 0, 0, 1},
    {"fuzz_roughness", 0.5f, 0, 1},
    {"coat_weight", 0, 0, 1},
    {"coat_roughness", 0, 0, 1},
    {"coat_roughness_anisotropy", 0, 0, 1},
    {"coat_ior", 1.6f, 1e-3f, 1e3f},
    {"thin_film_weight", 0, 0, 1},
    {"thin_film_thickness", 0.5f, 0, 100},
    {"thin_film_ior", 1.4f, 1e-3f, 1e3f},
    {"geometry_opacity", 1, 0, 1},
};

enum Color : size_t {
    kBaseColor,
    kSpecularColor,
    kTransmissionColor,
    kSubsurfaceColor,
    kFuzzColor,
    kCoatColor
};
struct ColorParameter {
    const char* name;
    float value;
};
constexpr ColorParameter kColorParameters[] = {
    {"base_color", 0.8f},       {"specular_color", 1}, {"transmission_color", 1},
    {"subsurface_color", 0.8f}, {"fuzz_color", 1},     {"coat_color", 1},
};

const FloatTexture* Read(const NumberParameter& p, const Params& params, TextureLibrary& textures) {
    const FloatTexture* texture = FloatTextureParam(params, p.name, p.value, textures);
    const std::optional<float> value = texture->Constant();
    if (value && !(*value >= p.low && *value <= p.high))
        params.Fail(p.name, fmt::format("\"{}\" is {}; expected a number from {} to {}", p.name, *value,
                                        p.low, p.high));
    return texture;
}

float InsideReflectance(float ior, float weight) {
    return DiffuseReflectance(WeightedIndex(ior, weight)).fromBelow;
}

}  // namespace

float WeightedIndex(float eta, float weight) {
    const float amplitude = std::abs(eta - 1) / (eta + 1) * std::sqrt(weight);
    const float epsilon = std::copysign(std::min(amplitude, 0.999f), eta - 1);
    return (1 + epsilon) / (1 - epsilon);
}

OpenPBRTextures OpenPBRTextures::Read(const Params& params, TextureLibrary& textures) {
    static_assert(std::size(kNumberParameters) == kNumbers && std::size(kColorParameters) == kColors);
    OpenPBRTextures t;
    for (size_t i = 0; i < kNumbers; ++i)
        t.numbers_[i] = layered::Read(kNumberParameters[i], params, textures);
    for (size_t i = 0; i < kColors; ++i)
        t.colors_[i] = SpectrumTextureParam(params, kColorParameters[i].name, SpectrumKind::Albedo,
                                            kColorParameters[i].value, textures);
    const std::optional<float> ior = t.numbers_[kSpecularIor]->Constant(),
                               weight = t.numbers_[kSpecularWeight]->Constant();
    if (ior && weight) t.insideReflectance_ = InsideReflectance(*ior, *weight);
    return t;
}

OpenPBRPoint OpenPBRTextures::At(const TextureContext& context, const SampledWavelengths& lambda) const {
    const auto n = [&](Number i) {
        const NumberParameter& p = kNumberParameters[i];
        const float x = numbers_[i]->Evaluate(context);
        return x >= p.low ? std::min(x, p.high) : p.low;  // NaN is the lower end
    };
    const auto c = [&](Color i) { return Clamp(colors_[i]->Evaluate(context, lambda), 0, 1); };
    OpenPBRPoint p;
    p.base = {n(kBaseWeight), n(kBaseDiffuseRoughness), n(kBaseMetalness), c(kBaseColor)};
    p.specular = {
        n(kSpecularWeight),
        n(kSpecularRoughness),
        n(kSpecularAnisotropy),
        n(kSpecularIor),
        c(kSpecularColor),
        insideReflectance_ ? *insideReflectance_ : InsideReflectance(n(kSpecularIor), n(kSpecularWeight))};
    p.transmission = {n(kTransmissionWeight), n(kTransmissionDepth), n(kDispersionScale), n(kAbbeNumber),
                      c(kTransmissionColor)};
    p.subsurface = {n(kSubsurfaceWeight), n(kSubsurfaceAnisotropy), c(kSubsurfaceColor)};
    p.fuzz = {n(kFuzzWeight), n(kFuzzRoughness), c(kFuzzColor)};
    p.coat = {n(kCoatWeight), n(kCoatRoughness), n(kCoatAnisotropy), n(kCoatIor), c(kCoatColor)};
    p.thinFilm = {n(kThinFilmWeight), n(kThinFilmThickness), n(kThinFilmIor)};
    p.opacity = n(kOpacity);
    return p;
}

OpenPBRTextures::Weights OpenPBRTextures::WeightsAt(const TextureContext& context) const {
    const auto w = [&](Number i) { return numbers_[i]->Evaluate(context); };
    return {w(kBaseMetalness), w(kTransmissionWeight), w(kSubsurfaceWeight), w(kCoatWeight),
            w(kFuzzWeight),    w(kThinFilmWeight),     w(kOpacity)};
}

bool OpenPBRTextures::IsConstant() const {
    return std::all_of(numbers_.begin(), numbers_.end(),
                       [](const FloatTexture* t) { return t->Constant(); }) &&
           std::all_of(colors_.begin(), colors_.end(),
                       [](const SpectrumTexture* t) { return t->IsConstant(); });
}

bool OpenPBRTextures::MayTransmit() const {
    return numbers_[kTransmissionWeight]->Constant() != 0.f || numbers_[kOpacity]->Constant() != 1.f;
}

std::optional<float> OpenPBRTextures::ConstantOpacity() const { return numbers_[kOpacity]->Constant(); }

bool OpenPBRTextures::HasCoatOrFuzz() const {
    return numbers_[kCoatWeight]->Constant() != 0.f || numbers_[kFuzzWeight]->Constant() != 0.f;
}

}  // namespace lacquer::layered
