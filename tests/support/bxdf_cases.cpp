#include "support/bxdf_cases.h"

#include "layered/stack_cases.h"
#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/bxdfs/diffuse.h"
#include "pbrt/bxdfs/diffuse_transmission.h"
#include "pbrt/bxdfs/flakes.h"
#include "pbrt/bxdfs/forced_diffuse.h"
#include "pbrt/bxdfs/hair.h"
#include "pbrt/bxdfs/multiscatter_conductor.h"
#include "pbrt/bxdfs/multiscatter_dielectric.h"
#include "pbrt/bxdfs/rough_diffuse.h"
#include "pbrt/bxdfs/svbrdf.h"
#include "pbrt/core/sampling.h"
#include "support/lanes.h"
#include "support/material_bxdf.h"

namespace lacquer::test {
namespace {

using GGX = TrowbridgeReitz;

// Rounding of a half vector moves it by a few ulps of 1; the lobe changes by that over alpha.
double ToleranceOf(float alphaX, float alphaY) { return 2e-5 + 2e-6 / double(std::min(alphaX, alphaY)); }

BxDFCase Lossless(BxDFCase row) {
    row.lossless = true;
    return row;
}
template <class T, class... Args>
BxDFCase Case(const char* name, Args... args) {
    return {.name = name,
            .make = [=](const SampledWavelengths&, Arena& arena) { return arena.New<T>(args...); }};
}
template <class T, class... Args>
BxDFCase Lossless(const char* name, Args... args) {
    return Lossless(Case<T>(name, args...));
}
/// What a material of scene text makes.
BxDFCase OfMaterial(const char* name, const char* material) {
    return {.name = name,
            .make = [made = MaterialFromText(material)](const SampledWavelengths& lambda, Arena& arena) {
                return made.MakeBxDF(lambda, arena);
            }};
}
SampledSpectrum CopperEta() { return Lanes(1.2f, 1.1f, 0.4f, 0.2f); }
SampledSpectrum CopperK() { return Lanes(2.3f, 2.5f, 2.9f, 4.1f); }
BareMetal CopperLike() { return {CopperEta(), CopperK()}; }
/// Copper-like metal, different at each wavelength.
template <class Distribution>
BxDFCase Metal(const char* name, float alphaX, float alphaY) {
    BxDFCase row = Case<ConductorBxDF<Distribution>>(name, Alphas(alphaX, alphaY), CopperLike());
    row.tolerance = ToleranceOf(alphaX, alphaY);
    return row;
}
template <class Distribution>
BxDFCase Glass(const char* name, float alphaX, float alphaY, float eta) {
    BxDFCase row = Case<DielectricBxDF<Distribution>>(name, Alphas(alphaX, alphaY), eta);
    // Near eta = 1 the half vector of refraction is a small difference of directions.
    row.tolerance = ToleranceOf(alphaX, alphaY) / double(std::min(1.f, 2 * std::abs(eta - 1)));
    return row;
}
/// A film of soap or, with k, of a stain, at wavelengths from violet to red.
ThinFilm Film(float thickness, float k) {
    return {thickness, SampledSpectrum(1.33f), SampledSpectrum(k), Lanes(430, 500, 560, 640), 1};
}
template <class Distribution>
BxDFCase FilmedGlass(const char* name, float alpha, float eta, const ThinFilm& film) {
    BxDFCase row =
        Case<FilmedDielectricBxDF<Distribution>>(name, Alphas(alpha, alpha), FilmedDielectric(eta, film));
    row.tolerance = Glass<Distribution>(name, alpha, alpha, eta).tolerance;
    return row;
}
BxDFCase Hair(const char* name, const HairBxDF::Parameters& parameters) {
    BxDFCase row = Case<HairBxDF>(name, parameters);
    row.lossless = !parameters.sigma_a;
    row.takesThreeNumbers = row.isOneWay = true;
    row.numSamples = 100000;
    // Rounded angles, and what remains of a sine near the poles, over the width of the lobes.
    row.tolerance = 2e-5 + 1e-5 / double(std::min(parameters.beta_m, parameters.beta_n));
    return row;
}
BxDFCase Stochastic(BxDFCase row) {
    row.stochastic = true;
    row.numSamples = 100000;
    return row;
}

/// A row of the table of stacks.
BxDFCase Layered(const char* stack, const char* estimator, const char* pdf = "approximate") {
    const auto make = [=](const SampledWavelengths&, Arena& arena) -> const BxDF* {
        layered::LayeredOptions options;
        options.estimator = layered::test::FindEstimator(estimator);
        options.pdf = layered::test::FindPdf(pdf);
        return layered::test::FindStackCase(stack).MakeBxDF(arena, options);
    };
    const std::string prefix = pdf == std::string("belcour") ? "layered_by_lobes_" : "layered_";
    return Stochastic({.name = prefix + stack, .make = make});
}

/// The option "forcediffuse" over a rough metal.
BxDFCase ForcedDiffuse() {
    const auto make = [](const SampledWavelengths&, Arena& arena) -> const BxDF* {
        return arena.New<ForcedDiffuseBxDF>(arena.New<ConductorBxDF<GGX>>(Alphas(0.3f, 0.6f), CopperLike()));
    };
    return Stochastic({.name = "forced_diffuse_metal", .make = make});
}

/// A diffuse base under a coat: value, density and draws by the closed form.
BxDFCase ClosedForm(const char* stack) {
    const auto make = [=](const SampledWavelengths&, Arena& arena) -> const BxDF* {
        layered::LayeredOptions options;
        options.estimator = layered::test::FindEstimator("auto");
        options.pdf = layered::test::FindPdf("approximate");
        return layered::test::FindStackCase(stack).MakeBxDF(arena, options);
    };
    return {.name = std::string("closed_form_") + stack,
            .make = make,
            .tolerance = 1e-4,
            .takesMoreNumbers = true};
}

BxDFCase TintedMetalCase() {
    BxDFCase row = Case<TintedConductorBxDF<GGX>>(
        "tinted_metal_ggx_a030", Alphas(0.3f, 0.3f),
        TintedMetal(Lanes(0.1f, 0.4f, 0.5f, 0.9f), Lanes(0.9f, 0.2f, 0, 1), 0.8f));
    // Near its dip the reflectance is a small difference.
    row.tolerance = 1e-4;
    return row;
}

/// Films and tints.
std::vector<BxDFCase> ColoredCases() {
    const SampledSpectrum one(1), varied = Lanes(0.1f, 0.4f, 0.5f, 0.9f);
    const Alphas smooth(0, 0);
    return {
        Lossless<RoughDiffuseBxDF>("rough_diffuse_white", one, 0.8f),
        Case<RoughDiffuseBxDF>("rough_diffuse_varied", varied, 0.5f),
        TintedMetalCase(),
        Case<TintedDielectricBxDF<GGX>>("tinted_glass_ggx_a030", Alphas(0.3f, 0.3f),
                                        TintedDielectric(1.5f, {}, varied, Lanes(1, 0.8f, 0.3f, 0))),
        Case<TintedDielectricBxDF<GGX>>("tinted_film_smooth_inverse", smooth,
                                        TintedDielectric(1 / 1.5f, Film(350, 0.2f), varied, one)),
        Lossless<FilmedDielectricBxDF<GGX>>("film_smooth_15", smooth, FilmedDielectric(1.5f, Film(350, 0))),
        Lossless<FilmedDielectricBxDF<GGX>>("film_soap", Alphas(0.3f, 0.3f),
                                            FilmedDielectric(1, Film(250, 0))),
        Case<FilmedDielectricBxDF<GGX>>("film_absorbing_inverse", smooth,
                                        FilmedDielectric(1 / 1.5f, Film(350, 0.4f))),
        FilmedGlass<GGX>("film_ggx_a030_15", 0.3f, 1.5f, Film(350, 0)),
        FilmedGlass<Beckmann>("film_absorbing_beckmann_a020_inverse", 0.2f, 1 / 1.5f, Film(800, 0.2f)),
        Case<FilmedConductorBxDF<GGX>>("film_metal_ggx_a020", Alphas(0.2f, 0.2f),
                                       FilmedMetal(CopperEta(), CopperK(), Film(300, 0))),
        Case<FilmedConductorBxDF<Beckmann>>("film_metal_smooth", smooth,
                                            FilmedMetal(CopperEta(), CopperK(), Film(300, 0.3f))),
        Stochastic(
            Case<FilmedMultiscatterConductorBxDF<GGX>>("film_multiscatter_metal_ggx_a060", Alphas(0.6f, 0.6f),
                                                       FilmedMetal(CopperEta(), CopperK(), Film(300, 0)))),
    };
}

/// Flakes in a window of some of them.
template <class Distribution>
BxDFCase Flakes(const char* name, Alphas alphas, float roughness, const FlakeOptics& optics, float halfAxis,
                float areaShare) {
    const FlakeWindow window(3.3, -1.8, {halfAxis, 0}, {0, 0.7f * halfAxis});
    BxDFCase row = Case<FlakesBxDF<Distribution>>(name, alphas, roughness, optics,
                                                  FlakesInWindow{FlakeField(7), window, areaShare});
    row.takesThreeNumbers = true;
    row.sharesLight = true;  // see Flakes.SampledEnergyIsThatOfMicrofacets for the mean
    row.numSamples = 100000;
    // The kernel ends at its radius with a slope.
    row.tolerance = 2e-5 + 1e-5 / double(roughness);
    return row;
}
std::vector<BxDFCase> FlakesCases() {
    const FlakeOptics metal = FlakeOptics::Metal(CopperEta(), CopperK(), {}, 0);
    const FlakeOptics pearl = FlakeOptics::Plate(1.2f, Film(250, 0), 0.1f);
    BxDFCase endless = Case<FlakesBxDF<GGX>>("flakes_endless", Alphas(0.3f, 0.1f), 0.05f, pearl, 0.6f);
    endless.takesThreeNumbers = true;
    return {
        Flakes<GGX>("flakes_few", {0.3f, 0.3f}, 0.2f, metal, 0.12f, 0.1f),
        Flakes<GGX>("flakes_pearl", {0.2f, 0.2f}, 0.2f, pearl, 0.2f, 0.04f),
        Flakes<Beckmann>("flakes_many", {0.3f, 0.15f}, 0.2f, metal, 0.25f, 0.02f),
        Flakes<Beckmann>("flakes_none", {0.2f, 0.2f}, 0.2f, pearl, 1e-4f, 1.f),
        endless,
    };
}

/// Captured materials: narrow, rough, white, and without a diffuse lobe.
std::vector<BxDFCase> SvbrdfCases() {
    const SampledSpectrum one(1), zero(0), varied = Lanes(0.1f, 0.4f, 0.5f, 0.9f);
    const auto captured = [](const char* name, SampledSpectrum albedo, SampledSpectrum specular,
                             float alpha) {
        BxDFCase row = Case<SvbrdfBxDF>(name, albedo, specular, alpha, true);
        row.tolerance = ToleranceOf(alpha, alpha);
        row.takesThreeNumbers = true;
        return row;
    };
    return {
        captured("svbrdf_a002", varied, SampledSpectrum(0.04f), 0.02f),
        captured("svbrdf_a020", varied, one - varied, 0.2f),
        captured("svbrdf_white_a060", one, SampledSpectrum(0.5f), 0.6f),
        captured("svbrdf_white_a100", one, zero, 1),
        captured("svbrdf_mirror_a0001", zero, one, 0.001f),
    };
}

std::vector<BxDFCase> PlainCases() {
    const SampledSpectrum one(1), zero(0), varied = Lanes(0.1f, 0.4f, 0.5f, 0.9f);
    const Alphas smooth(0, 0);
    return {
        Lossless<DiffuseBxDF>("diffuse_white", one),
        Case<DiffuseBxDF>("diffuse_varied", varied),
        Case<DiffuseBxDF>("diffuse_black", zero),
        Case<DiffuseTransmissionBxDF>("diffusetransmission_varied", varied, one - varied),
        Lossless<DiffuseTransmissionBxDF>("diffusetransmission_lossless", SampledSpectrum(0.25f),
                                          SampledSpectrum(0.75f)),
        Case<DiffuseTransmissionBxDF>("diffusetransmission_only", zero, varied),
        Case<ConductorBxDF<GGX>>("conductor_smooth", smooth, one, SampledSpectrum(3)),
        Lossless<ConductorBxDF<Beckmann>>("conductor_mirror", smooth, zero, one),
        Metal<GGX>("conductor_ggx_a0001", 0.001f, 0.001f),
        Metal<GGX>("conductor_ggx_a002", 0.02f, 0.02f),
        Metal<GGX>("conductor_ggx_a020", 0.2f, 0.2f),
        Metal<GGX>("conductor_ggx_a100", 1, 1),
        Metal<GGX>("conductor_ggx_a005_a040", 0.05f, 0.4f),
        Metal<GGX>("conductor_ggx_a080_a010", 0.8f, 0.1f),
        Metal<Beckmann>("conductor_beckmann_a0001", 0.001f, 0.001f),
        Metal<Beckmann>("conductor_beckmann_a010", 0.1f, 0.1f),
        Metal<Beckmann>("conductor_beckmann_a100", 1, 1),
        Metal<Beckmann>("conductor_beckmann_a005_a040", 0.05f, 0.4f),
        Lossless<DielectricBxDF<GGX>>("dielectric_smooth_15", smooth, 1.5f),
        Lossless<DielectricBxDF<GGX>>("dielectric_smooth_inverse", smooth, 1 / 1.5f),
        Lossless<DielectricBxDF<GGX>>("dielectric_index_1", Alphas(0.3f, 0.3f), 1.f),
        Glass<GGX>("dielectric_ggx_a002_15", 0.02f, 0.02f, 1.5f),
        Glass<GGX>("dielectric_ggx_a030_15", 0.3f, 0.3f, 1.5f),
        Glass<GGX>("dielectric_ggx_a100_15", 1, 1, 1.5f),
        Glass<GGX>("dielectric_ggx_a030_inverse", 0.3f, 0.3f, 1 / 1.5f),
        Glass<GGX>("dielectric_ggx_a010_a050_15", 0.1f, 0.5f, 1.5f),
        Glass<GGX>("dielectric_ggx_a020_11", 0.2f, 0.2f, 1.1f),
        Glass<Beckmann>("dielectric_beckmann_a005_15", 0.05f, 0.05f, 1.5f),
        Glass<Beckmann>("dielectric_beckmann_a030_15", 0.3f, 0.3f, 1.5f),
        Glass<Beckmann>("dielectric_beckmann_a040_a010_inverse", 0.4f, 0.1f, 1 / 1.5f),
        Lossless(OfMaterial("thindielectric_15", "\"thindielectric\" \"float eta\" 1.5")),
        Hair("hair_white", {.h = -0.9f, .sigma_a = zero, .alpha = 0.035f}),
        Hair("hair_smooth", {.h = 0.5f, .sigma_a = varied, .beta_m = 0.15f, .beta_n = 0.2f, .alpha = 0.1f}),
        Hair("hair_rough", {.h = 0.1f, .sigma_a = varied, .beta_m = 1, .beta_n = 1}),
        Stochastic(Lossless<MultiscatterConductorBxDF<GGX>>("multiscatter_mirror_ggx_a080",
                                                            Alphas(0.8f, 0.8f), zero, one)),
        Stochastic(Case<MultiscatterConductorBxDF<Beckmann>>("multiscatter_metal_beckmann_a090_a030",
                                                             Alphas(0.9f, 0.3f), CopperLike())),
        Stochastic(Lossless<MultiscatterDielectricBxDF<GGX>>("multiscatter_glass_ggx_a060_15",
                                                             Alphas(0.6f, 0.6f), 1.5f)),
        Stochastic(Lossless<MultiscatterDielectricBxDF<Beckmann>>(
            "multiscatter_glass_beckmann_a080_a030_inverse", Alphas(0.8f, 0.3f), 1 / 1.5f)),
        Stochastic(Case<NoisyDiffuse>("stochastic_diffuse", 0.8f)),
        ForcedDiffuse(),
        Layered("coat_030_diffuse_080", "bidirectional"),
        ClosedForm("coat_030_diffuse_080"),
        Layered("coat_030_metal_010_beckmann", "unidirectional"),
        Layered("pane_020_010", "bidirectional"),
        Layered("coat_030_metal_010_beckmann", "halfvector", "belcour"),
        Layered("pane_020_010", "bidirectional", "belcour"),
    };
}

}  // namespace

const std::vector<BxDFCase>& BxDFCases() {
    static const std::vector<BxDFCase> all = [] {
        std::vector<BxDFCase> cases = PlainCases();
        for (BxDFCase& row : ColoredCases()) cases.push_back(std::move(row));
        for (BxDFCase& row : FlakesCases()) cases.push_back(std::move(row));
        for (BxDFCase& row : SvbrdfCases()) cases.push_back(std::move(row));
        return cases;
    }();
    return all;
}

const std::vector<NamedDirection>& OutgoingDirections() {
    const auto at = [](float cosTheta, float phi) {
        return SphericalDirection(std::sqrt(1 - cosTheta * cosTheta), cosTheta, phi);
    };
    static const std::vector<NamedDirection> directions = {{"normal", {0, 0, 1}},
                                                           {"45deg", at(std::sqrt(0.5f), 0.4f)},
                                                           {"grazing", at(0.05f, 2.1f)},
                                                           {"below", at(-0.6f, 4)}};
    return directions;
}

BxDFValue NoisyDiffuse::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection)) return {};
    const float noise = 2 * context.rng->Uniform();
    return {SampledSpectrum(reflectance_ * InvPi * noise), PdfUniformHemisphere()};
}

std::optional<BxDFSample> NoisyDiffuse::Sample(Vec3 wo, const BxDFRandom& u,
                                               const BxDFContext& context) const {
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection)) return std::nullopt;
    Vec3 wi = SampleCosineHemisphere(u.direction);
    if (wi.z == 0) return std::nullopt;
    wi.z = std::copysign(wi.z, wo.z);
    return BxDFSample{.wi = wi,
                      .weight = SampledSpectrum(reflectance_ * (0.5f + context.rng->Uniform())),
                      .pdf = PdfUniformHemisphere(),
                      .lobe = Lobes::DiffuseReflection,
                      .pdfExact = false};
}

}  // namespace lacquer::test
