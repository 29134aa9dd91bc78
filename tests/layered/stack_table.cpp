// The table of stacks.
#include "layered/stack_cases.h"

namespace lacquer::layered::test {

namespace {

/// In both subsets.
StackCase Small(std::string name, std::vector<Layer> layers) {
    return {.name = std::move(name), .layers = std::move(layers), .isSmall = true};
}
/// In the full set only.
StackCase Full(std::string name, std::vector<Layer> layers) {
    return {.name = std::move(name), .layers = std::move(layers)};
}
StackCase Lossless(StackCase row) {
    row.isLossless = true;
    return row;
}
StackCase Smooth(StackCase row) {
    row.isSmooth = true;
    return row;
}

void AddClearCoats(std::vector<StackCase>& t) {
    const float up = 1 / 1.5f;
    t.insert(
        t.end(),
        {
            // One interface: nothing to estimate, everything is f0.
            Small("single_glass_030", {Dielectric(0.3f, 1.5f)}),
            // A rough coat on a base: GGX and Beckmann, from mirror-like to rough, also swapped.
            Small("coat_030_metal_010", {Dielectric(0.3f, 1.5f), Metal(0.1f)}),
            Small("coat_030_metal_010_beckmann", {Dielectric(0.3f, 1.5f, kBeckmann), Metal(0.1f, kBeckmann)}),
            Full("coat_005_metal_005", {Dielectric(0.05f, 1.5f), Metal(0.05f)}),
            Full("coat_005_metal_050_beckmann", {Dielectric(0.05f, 1.5f, kBeckmann), Metal(0.5f, kBeckmann)}),
            Full("coat_070_metal_100", {Dielectric(0.7f, 1.5f), Metal(1)}),
            Full("coat_050_metal_002", {Dielectric(0.5f, 1.5f), Metal(0.02f)}),
            Full("coat_010_metal_030_mixed", {Dielectric(0.1f, 1.3f, kBeckmann), Metal(0.3f, kGGX)}),
            Full("coat_dense_030_metal_020", {Dielectric(0.3f, 2.4f), Metal(0.2f)}),
            Full("coat_thin_index_metal_020", {Dielectric(0.4f, 1.1f), Metal(0.2f)}),
            Small("coat_030_mirror_020", {Dielectric(0.3f, 1.5f), Mirror(0.2f)}),
            // Smooth parts in all places.
            Small("smooth_coat_metal_020", {Dielectric(0, 1.5f), Metal(0.2f)}),
            Small("smooth_coat_diffuse_050", {Dielectric(0, 1.5f), Diffuse(0.5f)}),
            Full("smooth_coat_diffuse_white", {Dielectric(0, 1.5f), Diffuse(1)}),
            Small("coat_020_mirror_smooth", {Dielectric(0.2f, 1.5f), Mirror(0)}),
            Smooth(Full("smooth_coat_mirror_smooth", {Dielectric(0, 1.5f), Mirror(0)})),
            Full("smooth_middle", {Dielectric(0.2f, 1.5f), Dielectric(0, 1.2f), Metal(0.2f)}),
            Full("two_smooth_over_diffuse", {Dielectric(0, 1.3f), Dielectric(0, 1.3f), Diffuse(0.7f)}),
            Full("thin_pane_over_metal", {ThinPane(1.5f), Metal(0.3f)}),
            // Diffuse bases.
            Small("coat_030_diffuse_080", {Dielectric(0.3f, 1.5f), Diffuse(0.8f)}),
            Full("coat_030_diffuse_white", {Dielectric(0.3f, 1.5f), Diffuse(1)}),
            Full("coat_010_diffuse_coloured",
                 {Dielectric(0.1f, 1.5f, kBeckmann), Diffuse(Lanes(0.05f, 0.3f, 0.6f, 0.95f))}),
            // Nothing: first, in the middle, last.
            Small("nothing_over_metal", {Nothing(), Metal(0.3f)}),
            Full("nothing_over_coat", {Nothing(), Dielectric(0.3f, 1.5f), Metal(0.2f)}),
            Full("coat_over_nothing_over_metal", {Dielectric(0.3f, 1.5f), Nothing(), Metal(0.2f)}),
            Full("glass_over_nothing", {Dielectric(0.3f, 1.5f), Nothing()}),
            Full("glass_between_nothings", {Nothing(), Dielectric(0.2f, up), Nothing()}),
            // Black.
            Small("coat_over_black", {Dielectric(0.3f, 1.5f), Black()}),
            Full("black_first", {Black(), Metal(0.2f)}),
            Full("smooth_coat_over_black", {Dielectric(0, 1.5f), Black()}),
        });
}

void AddSheets(std::vector<StackCase>& t) {
    const float up = 1 / 1.5f;
    t.insert(
        t.end(),
        {
            // Light passes: equal and different indices outside.
            Small("pane_020_010", {Dielectric(0.2f, 1.5f), Dielectric(0.1f, up)}),
            Full("pane_005_050_beckmann",
                 {Dielectric(0.05f, 1.5f, kBeckmann), Dielectric(0.5f, up, kBeckmann)}),
            Small("pane_smooth_rough", {Dielectric(0, 1.5f), Dielectric(0.3f, up)}),
            Full("pane_rough_smooth", {Dielectric(0.3f, 1.5f), Dielectric(0, up)}),
            Full("water_under_glass", {Dielectric(0.2f, 1.5f), Dielectric(0.3f, 1.33f / 1.5f)}),
            Full("oil_on_water_on_glass",
                 {Dielectric(0.1f, 1.47f), Dielectric(0.05f, 1.33f / 1.47f), Dielectric(0.2f, 1.5f / 1.33f)}),
            Full("into_thinner", {Dielectric(0.3f, up), Dielectric(0.2f, 1 / 1.2f)}),
            Small("three_panes", {Dielectric(0.1f, 1.5f), Dielectric(0.2f, up), Dielectric(0.3f, 1.5f)}),
            Full("five_interfaces", {Dielectric(0.1f, 1.5f), Dielectric(0.1f, up), Dielectric(0.2f, 1.3f),
                                     Dielectric(0.2f, 1.2f), Metal(0.3f)}),
            Full("five_interfaces_pass", {Dielectric(0.3f, 1.5f), Dielectric(0, up), DiffuseSheet(0.3f, 0.6f),
                                          Dielectric(0.2f, 1.5f), Dielectric(0.1f, up)}),
            Small("diffuse_sheet_first", {DiffuseSheet(0.4f, 0.5f), Dielectric(0.2f, 1.5f)}),
            Full("diffuse_sheet_last", {Dielectric(0.2f, 1.5f), DiffuseSheet(0.2f, 0.7f)}),
            Full("two_diffuse_sheets", {DiffuseSheet(0.5f, 0.5f), DiffuseSheet(0.2f, 0.8f)}),
            Full("diffuse_sheet_over_metal", {DiffuseSheet(0, 0.9f), Metal(0.2f)}),
            // Light goes straight on through what reflects at facets.
            Small("coat_flakes_diffuse",
                  {Dielectric(0, 1.5f), Flakes(0.3f), Diffuse(Lanes(0.1f, 0.3f, 0.6f, 0.9f))}),
            Full("flakes_first", {Flakes(0.2f), Metal(0.3f)}),
            Full("rough_coat_pearls_flakes",
                 {Dielectric(0.2f, 1.5f), Flakes(0.3f, true), Flakes(0.2f), Diffuse(0.5f)}),
            Full("flakes_last", {Dielectric(0.1f, 1.5f), Flakes(0.3f)}),
            // Anisotropic, rotated, with a perturbed normal.
            Small("aniso_coat_aniso_metal",
                  {Dielectric(Alphas(0.1f, 0.4f), 1.5f), Metal(Alphas(0.4f, 0.1f))}),
            Small("aniso_metal_turned_30", {Dielectric(0.1f, 1.5f), Rotated(30, Metal(Alphas(0.05f, 0.4f)))}),
            Full("aniso_beckmann_turned_90", {Dielectric(Alphas(0.3f, 0.1f), 1.5f, kBeckmann),
                                              Rotated(90, Metal(Alphas(0.1f, 0.4f), kBeckmann))}),
            Full("aniso_pane", {Rotated(45, Dielectric(Alphas(0.05f, 0.3f), 1.5f)),
                                Rotated(-20, Dielectric(Alphas(0.3f, 0.1f), up))}),
            Small("leaning_coat", {Tilted({0.2f, 0.1f, 1}, Dielectric(0.2f, 1.5f)), Metal(0.2f)}),
            Small("leaning_metal", {Dielectric(0.1f, 1.5f), Tilted({-0.3f, 0.2f, 1}, Metal(0.2f))}),
            Full("leaning_aniso_metal",
                 {Dielectric(0.1f, 1.5f), Tilted({0.3f, 0.3f, 1}, Metal(Alphas(0.05f, 0.5f)))}),
            Full("leaning_smooth_coat", {Tilted({0.3f, 0, 1}, Dielectric(0, 1.5f)), Diffuse(0.6f)}),
            Small("leaning_aniso_beckmann",
                  {Tilted({0.2f, -0.1f, 1}, Dielectric(0.2f, 1.5f, kBeckmann)),
                   Turned({-0.3f, 0.2f, 1}, 35, Metal(Alphas(0.3f, 0.08f), kBeckmann))}),
            Full("leaning_aniso_ggx", {Turned({0.2f, -0.1f, 1}, -25, Dielectric(Alphas(0.1f, 0.3f), 1.5f)),
                                       Turned({-0.3f, 0.2f, 1}, 35, Metal(Alphas(0.2f, 0.05f)))}),
            Full("leaning_both_sides_beckmann",
                 {Tilted({0.2f, 0, 1}, Dielectric(0.2f, 1.5f, kBeckmann)),
                  Turned({0, -0.25f, 1}, 50, Dielectric(Alphas(0.05f, 0.2f), up, kBeckmann))}),
            Full("leaning_three", {Tilted({0.1f, 0, 1}, Dielectric(0.1f, 1.5f)),
                                   Turned({0, 0.2f, 1}, 30, Dielectric(Alphas(0.1f, 0.3f), 1.2f)),
                                   Tilted({-0.2f, 0.1f, 1}, Dielectric(0.2f, 1 / 1.8f))}),
            Full("leaning_both_sides", {Tilted({0.2f, 0, 1}, Dielectric(0.2f, 1.5f)),
                                        Tilted({0, -0.25f, 1}, Dielectric(0.2f, up))}),
        });
}

void AddMedia(std::vector<StackCase>& t) {
    const float up = 1 / 1.5f;
    const SampledSpectrum varied = Lanes(0.1f, 0.5f, 2, 8), albedos = Lanes(0.95f, 0.8f, 0.5f, 0.99f),
                          rgb = Lanes(0.5f, 0.7f, 0.95f, 0.95f);
    t.insert(
        t.end(),
        {
            // Absorption only.
            Small("coat_absorber_metal", {Dielectric(0.2f, 1.5f), Absorber(0.5f), Metal(0.2f)}),
            Full("coat_absorber_varied_diffuse", {Dielectric(0.2f, 1.5f), Absorber(varied), Diffuse(0.8f)}),
            Full("smooth_absorber_smooth_rough", {Dielectric(0, 1.5f), Absorber(0.3f), Dielectric(0.3f, up)}),
            // Scattering at several thicknesses, albedos and lobes; V1 to V3 are the papers' validation
            // stacks.
            Small("v1", {Dielectric(0.05f, 1.5f, kBeckmann), Medium(SampledSpectrum(1), rgb, HG(0.5f)),
                         Copper(0.05f, kBeckmann)}),
            Full("v2", {Dielectric(0.05f, 1.5f, kBeckmann), Medium(SampledSpectrum(2), rgb, HG(0.9f)),
                        Copper(0.01f, kBeckmann)}),
            Full("v3", {Dielectric(0.05f, 1.5f, kBeckmann), Medium(SampledSpectrum(5), rgb, HG(0.95f)),
                        Copper(0.01f, kBeckmann)}),
            Small("coat_medium_metal", {Dielectric(0.3f, 1.5f), Medium(1, 0.9f, Isotropic()), Metal(0.2f)}),
            Full("coat_thin_medium_metal",
                 {Dielectric(0.3f, 1.5f), Medium(0.01f, 0.9f, HG(0.3f)), Metal(0.2f)}),
            Small("nothing_thin_medium_black", {Nothing(), Medium(0.01f, 0.9f, HG(0.3f)), Black()}),
            Full("nothing_thinnest_medium_nothing", {Nothing(), Medium(0.001f, 1, Isotropic()), Nothing()}),
            Small("coat_thick_medium_metal",
                  {Dielectric(0.2f, 1.5f), Medium(20, 0.9f, HG(0.5f)), Metal(0.2f)}),
            Full("coat_thick_white_medium_white",
                 {Dielectric(0.2f, 1.5f), Medium(20, 1, Isotropic()), Diffuse(1)}),
            Small("sheet_thick_white_medium", {Nothing(), Medium(20, 1, HG(0.8f)), Nothing()}),
            Full("coat_white_medium_mirror", {Dielectric(0.3f, 1.5f), Medium(2, 1, HG(-0.4f)), Mirror(0.1f)}),
            Full("coat_black_medium_metal",
                 {Dielectric(0.3f, 1.5f), Medium(0.5f, 0, Isotropic()), Metal(0.1f)}),
            Small("smooth_medium_diffuse", {Dielectric(0, 1.5f), Medium(1, 0.9f, HG(0.5f)), Diffuse(0.5f)}),
            Full("smooth_medium_smooth",
                 {Dielectric(0, 1.5f), Medium(1, 0.95f, HG(0.5f)), Dielectric(0, up)}),
            Smooth(Lossless(Small("lossless_smooth_medium_mirror",
                                  {Dielectric(0, 1.5f), Medium(2, 1, HG(0.5f)), Mirror(0)}))),
            Smooth(Lossless(Small("lossless_smooth_medium_smooth",
                                  {Dielectric(0, 1.5f), Medium(1, 1, Isotropic()), Dielectric(0, up)}))),
            Smooth(Lossless(
                Full("lossless_two_media", {Dielectric(0, 1.5f), Medium(0.5f, 1, HG(0.7f)),
                                            Dielectric(0, 1.2f), Medium(2, 1, HG(-0.3f)), Mirror(0)}))),
            Small("medium_under_nothing", {Nothing(), Medium(1, 0.8f, HG(0.7f)), Diffuse(0.5f)}),
            Small("rough_pane_medium",
                  {Dielectric(0.3f, 1.5f), Medium(1, 0.9f, HG(0.6f)), Dielectric(0.1f, up)}),
            Full("water_medium_glass",
                 {Dielectric(0.2f, 1.33f), Medium(0.7f, 0.95f, HG(0.2f)), Dielectric(0.3f, 1.5f / 1.33f)}),
            Full("medium_peaked", {Dielectric(0.1f, 1.5f), Medium(3, 0.99f, HG(0.97f)), Metal(0.3f)}),
            Small("medium_varied", {Dielectric(0.2f, 1.5f), Medium(varied, albedos, HG(0.4f)), Metal(0.2f)}),
            Full("medium_varied_pane",
                 {Dielectric(0.2f, 1.5f), Medium(varied, albedos, HG(0.8f)), Dielectric(0.2f, up)}),
            Full("medium_extreme_lanes",
                 {Dielectric(0.2f, 1.5f), Medium(Lanes(0, 0.01f, 1, 20), SampledSpectrum(0.9f), HG(0.2f)),
                  Diffuse(0.5f)}),
            Small("two_media", {Dielectric(0.2f, 1.5f), Medium(0.5f, 0.9f, HG(0.7f)), Dielectric(0.1f, 1.2f),
                                Medium(1, 0.8f, Isotropic()), Metal(0.2f)}),
            Full("medium_between_clear", {Dielectric(0.2f, 1.5f), Dielectric(0.1f, up),
                                          Medium(1, 0.9f, HG(0.5f)), Dielectric(0.2f, 1.5f), Metal(0.2f)}),
            Full("four_interfaces_media", {Dielectric(0.1f, 1.5f), Medium(0.5f, 0.9f, HG(0.5f)),
                                           Dielectric(0.2f, 0.8f), Absorber(0.2f), Dielectric(0.1f, 1.25f),
                                           Medium(0.3f, 0.99f, HG(0.9f)), Dielectric(0.3f, up)}),
            Full("leaning_coat_medium_leaning_metal",
                 {Tilted({0.2f, 0, 1}, Dielectric(0.2f, 1.5f)), Medium(1, 0.8f, HG(0.5f)),
                  Tilted({0, 0.3f, 1}, Metal(0.3f))}),
            Full("aniso_medium_aniso", {Dielectric(Alphas(0.05f, 0.25f), 1.5f), Medium(0.5f, 0.9f, HG(0.5f)),
                                        Rotated(60, Metal(Alphas(0.3f, 0.1f)))}),
            Full("diffuse_sheet_medium",
                 {DiffuseSheet(0.4f, 0.5f), Medium(1, 0.9f, HG(0.5f)), DiffuseSheet(0.3f, 0.6f)}),
            Full("medium_under_diffuse_sheet_metal",
                 {DiffuseSheet(0.4f, 0.5f), Medium(0.5f, 0.9f, HG(0.5f)), Metal(0.1f)}),
            Full("black_coat_medium", {Dielectric(0.3f, 1.5f), Medium(1, 0.9f, HG(0.5f)), Black()}),
        });
}

void AddPhases(std::vector<StackCase>& t) {
    const float up = 1 / 1.5f;
    const Vec3 diagonal{0.5f, 0.5f, 0}, steep{0.5f, 0, 0.7f};
    t.insert(
        t.end(),
        {
            Small("vmf_pane", {Dielectric(0.2f, 1.5f), Medium(1, 0.95f, VMF(8)), Dielectric(0.2f, up)}),
            Full("vmf_peaked_metal", {Dielectric(0.1f, 1.5f), Medium(2, 0.95f, VMF(60)), Metal(0.2f)}),
            Full("table_metal", {Dielectric(0.2f, 1.5f), Medium(1, 0.95f, Rainbow()), Metal(0.2f)}),
            Small("spectral_table_pane",
                  {Dielectric(0.2f, 1.5f), Medium(1, 0.95f, SpectralRainbow()), Dielectric(0.2f, up)}),
            Full("spectral_table_of_fibres_varied",
                 {Nothing(),
                  Medium(Lanes(0.5f, 0.8f, 1.2f, 2), Lanes(0.5f, 0.95f, 0.8f, 0.99f),
                         Mixture(1, SpectralRainbow(), 1, Fibres(diagonal, 0.1f))),
                  Metal(0.2f)}),
            Lossless(Smooth(Full("lossless_spectral_table",
                                 {Dielectric(0, 1.5f), Medium(2, 1, SpectralRainbow()), Mirror(0)}))),
            Full("mixture_diffuse", {Dielectric(0.2f, 1.5f),
                                     Medium(1, 0.95f, Mixture(3, HG(0.85f), 1, HG(-0.3f))), Diffuse(0.4f)}),
            Small("sggx_fibres_metal",
                  {Dielectric(0.2f, 1.5f), Medium(1, 0.9f, SggxFibres(diagonal, 0.2f)), Metal(0.2f)}),
            Full("sggx_sheets_pane", {Dielectric(0.2f, 1.5f), Medium(1, 0.9f, SggxSheets({0, 0.3f, 1}, 0.3f)),
                                      Dielectric(0.1f, up)}),
            Small("oriented_ensemble_pane",
                  {Dielectric(0.2f, 1.5f), Medium(1, 0.95f, OrientedEnsemble(steep)), Dielectric(0.1f, up)}),
            Full("oriented_ensemble_mixture",
                 {Nothing(), Medium(2, 1, Mixture(1, OrientedEnsemble(diagonal), 1, Fibres(steep, 0.1f))),
                  Diffuse(0.3f)}),
            Small("fibres_metal",
                  {Dielectric(0.2f, 1.5f), Medium(1, 0.9f, Fibres(diagonal, 0.1f)), Metal(0.2f)}),
            Full("fibres_sheet", {Nothing(), Medium(3, 0.95f, Fibres(steep, 0.05f)), Nothing()}),
            Full(
                "fibres_mixture",
                {Nothing(), Medium(2, 0.9f, Mixture(1, Fibres(diagonal, 0.1f), 1, HG(0.5f))), Diffuse(0.3f)}),
            // The authors' density counts both sides of a flake: twice the one of FibrePhase.
            Full("v4",
                 {Dielectric(Alphas(0.05f, 0.25f), 1.5f, kBeckmann),
                  Medium(SampledSpectrum(1), Lanes(0.5f, 0.7f, 0.95f, 0.95f), Fibres(diagonal, 0.05f)),
                  Dielectric(0.01f, 1.2f / 1.5f, kBeckmann),
                  Medium(SampledSpectrum(1), Lanes(0.5f, 0.95f, 0.5f, 0.5f), Fibres({0.5f, -0.5f, 0}, 0.05f)),
                  Copper(0.05f, kBeckmann)}),
            Smooth(Lossless(Full("lossless_fibres",
                                 {Dielectric(0, 1.5f), Medium(1, 1, Fibres(diagonal, 0.1f)), Mirror(0)}))),
            Small(
                "medium_coloured",
                {Dielectric(0.2f, 1.5f),
                 Medium(Lanes(0.5f, 0.8f, 1.2f, 2), Lanes(0.5f, 0.95f, 0.8f, 0.99f), HG(0.4f)), Metal(0.2f)}),
        });
}

/// Boundaries that keep nothing between their facets.
void AddRescattering(std::vector<StackCase>& t) {
    const float up = 1 / 1.5f;
    const auto round = [](float alpha) { return Alphas(alpha, alpha); };
    t.insert(
        t.end(),
        {
            Small("rescattering_coat_050_metal_050",
                  {RescatteringDielectric(round(0.5f), 1.5f), RescatteringMetal(round(0.5f))}),
            Small("rescattering_pane",
                  {RescatteringDielectric(round(0.6f), 1.5f), RescatteringDielectric(round(0.4f), up)}),
            Full("rescattering_beckmann", {RescatteringDielectric(round(0.7f), 1.5f, kBeckmann),
                                           RescatteringMetal(round(0.9f), kBeckmann)}),
            Full("rescattering_below_single", {Dielectric(0.3f, 1.5f), RescatteringMetal(round(0.7f))}),
            Full("rescattering_above_single", {RescatteringDielectric(round(0.7f), 1.5f), Metal(0.2f)}),
            Full("smooth_over_rescattering_metal", {Dielectric(0, 1.5f), RescatteringMetal(round(0.8f))}),
            Full("rescattering_over_diffuse", {RescatteringDielectric(round(0.6f), 1.5f), Diffuse(0.8f)}),
            Full("rescattering_aniso_leaning",
                 {RescatteringDielectric(Alphas(0.2f, 0.6f), 1.5f),
                  Tilted({0.2f, 0.1f, 1}, RescatteringMetal(Alphas(0.6f, 0.2f)))}),
            Full("rescattering_coat_medium_metal",
                 {RescatteringDielectric(round(0.4f), 1.5f), Medium(1, 0.9f, HG(0.5f)),
                  RescatteringMetal(round(0.5f))}),
            Lossless(Small("lossless_rescattering_coat_mirror",
                           {RescatteringDielectric(round(0.5f), 1.5f), RescatteringMirror(round(0.7f))})),
            Lossless(Full("lossless_rescattering_medium_pane",
                          {RescatteringDielectric(round(0.3f), 1.5f, kBeckmann), Medium(1, 1, Isotropic()),
                           RescatteringDielectric(round(0.5f), up)})),
        });
}

/// Long paths, and light that runs out.
void AddExtremes(std::vector<StackCase>& t) {
    const float up = 1 / 1.5f;
    const std::vector<Layer> sheets(5, DiffuseSheet(0.8f, 0.2f)), manySheets(20, DiffuseSheet(0.5f, 0.5f));
    std::vector<Layer> nothings(62, Nothing()), passing(12, Nothing());
    nothings.front() = Dielectric(0, 1.5f);
    nothings.push_back(Diffuse(1));
    passing.push_back(Medium(2, 0.9f, HG(0.3f)));
    passing.push_back(Diffuse(0.8f));
    t.insert(
        t.end(),
        {
            Small("five_bright_sheets", sheets),
            Full("twenty_sheets", manySheets),
            Full("dense_coat_white", {Dielectric(0.2f, 4), Diffuse(1)}),
            // Light that the coat throws back passes all of them twice, again and again.
            Small("smooth_coat_sixty_nothings_white", nothings),
            Small("twelve_nothings_medium", passing),
            Smooth(Lossless(Full("lossless_smooth_thin_medium_mirror",
                                 {Dielectric(0, 1.5f), Medium(0.003f, 1, HG(0.5f)), Mirror(0)}))),
            Smooth(Lossless(Full("lossless_smooth_thinnest_medium_smooth",
                                 {Dielectric(0, 1.5f), Medium(0.001f, 1, Isotropic()), Dielectric(0, up)}))),
            // Nothing is left of most light when it meets a medium with different extinctions.
            Small("ink_over_coloured_medium",
                  {Dielectric(0.3f, 1.5f), Absorber(100), DiffuseSheet(0.25f, 0.25f),
                   Medium(Lanes(1, 1, 2, 3), SampledSpectrum(0.9f), Isotropic()), Diffuse(0.5f)}),
        });
}

}  // namespace

const std::vector<StackCase>& StackCases() {
    static const std::vector<StackCase> table = [] {
        std::vector<StackCase> rows;
        AddClearCoats(rows);
        AddSheets(rows);
        AddMedia(rows);
        AddPhases(rows);
        AddRescattering(rows);
        AddExtremes(rows);
        return rows;
    }();
    return table;
}

}  // namespace lacquer::layered::test
