#include "product_stacks.h"

#include <fmt/format.h>

#include "pbrt/bxdfs/conductor.h"
#include "pbrt/core/sampling.h"

namespace lacquer::bench {
namespace {

using test::kBeckmann;
using test::kGGX;
using test::Layer;
using test::StackBuilder;
using test::Tilted;
using test::Turned;
using Layers = std::vector<Layer>;

/// Words for stacks whose Beckmann interfaces draw facets by one of the samplers.
struct Words {
    SlopeSampler sampler;
    MicrofacetModel model = kBeckmann;

    Layer Coat(Alphas alphas, float eta = 1.5f) const {
        if (model == kGGX) return test::Dielectric(alphas, eta, kGGX);
        return [=, way = sampler](StackBuilder& b) {
            b.AddInterface(NewDielectric(b.Memory(), way, alphas, eta), eta);
        };
    }
    Layer Coat(float alpha, float eta = 1.5f) const { return Coat(Alphas(alpha, alpha), eta); }
    /// Gray, reflects 0.9 straight on.
    Layer Metal(Alphas alphas) const {
        const SampledSpectrum eta(0.2f), k(2.56f);
        if (model == kGGX)
            return [=](StackBuilder& b) {
                b.AddInterface(b.Memory().New<ConductorBxDF<TrowbridgeReitz>>(alphas, eta, k));
            };
        return [=, way = sampler](StackBuilder& b) {
            b.AddInterface(NewConductor(b.Memory(), way, alphas, eta, k));
        };
    }
    Layer Metal(float alpha) const { return Metal(Alphas(alpha, alpha)); }
};

std::string Cell(float top, float bottom) { return fmt::format("{:g} over {:g}", top, bottom); }

Configuration CoatedMetal(MicrofacetModel model, float top, float bottom, int maxVertices) {
    return {Cell(top, bottom),
            [=](SlopeSampler s) {
                const Words w{s, model};
                return Layers{w.Coat(top), w.Metal(bottom)};
            },
            Lobes::Reflection, maxVertices};
}

ConfigurationGroup Grid(std::string name, std::string title, MicrofacetModel model, int maxVertices,
                        bool isCoarse) {
    const std::vector<float> alphas =
        isCoarse ? std::vector{0.05f, 0.2f, 0.5f} : std::vector{0.05f, 0.1f, 0.2f, 0.3f, 0.5f};
    ConfigurationGroup group{std::move(name), std::move(title), {}, model == kBeckmann};
    for (const float top : alphas)
        for (const float bottom : alphas) group.rows.push_back(CoatedMetal(model, top, bottom, maxVertices));
    return group;
}

ConfigurationGroup Sheets(std::string name, std::string title, MicrofacetModel model) {
    ConfigurationGroup group{std::move(name), std::move(title), {}, model == kBeckmann};
    for (const float alpha : {0.5f, 0.3f, 0.1f, 0.05f})
        group.rows.push_back({Cell(alpha, alpha),
                              [=](SlopeSampler s) {
                                  const Words w{s, model};
                                  return Layers{w.Coat(alpha), w.Coat(alpha, 1 / 1.5f)};
                              },
                              Lobes::Transmission, 2});
    return group;
}

/// Both interfaces with alpha_x / alpha_y = ratio about a mean alpha; `crossed`: the lower one turned by a
/// right angle.
ConfigurationGroup Anisotropic(std::string name, MicrofacetModel model, float ratio) {
    ConfigurationGroup group{std::move(name),
                             fmt::format("f_010, {}, alpha_x / alpha_y = {:g} on both",
                                         model == kBeckmann ? "Beckmann" : "GGX", ratio),
                             {},
                             model == kBeckmann};
    const float stretch = std::sqrt(ratio);
    const auto add = [&](float top, float bottom, bool isCrossed) {
        const float lower = isCrossed ? 1 / stretch : stretch;
        group.rows.push_back({Cell(top, bottom) + (isCrossed ? " crossed" : ""),
                              [=](SlopeSampler s) {
                                  const Words w{s, model};
                                  return Layers{w.Coat({top * stretch, top / stretch}),
                                                w.Metal({bottom * lower, bottom / lower})};
                              },
                              Lobes::Reflection, 3});
    };
    add(0.3f, 0.1f, false);
    add(0.1f, 0.1f, false);
    add(0.1f, 0.3f, false);
    add(0.2f, 0.1f, true);
    return group;
}

/// What normal maps and brushes make of a coat over metal and of a pane.
ConfigurationGroup Perturbed(std::string name, std::string title, MicrofacetModel model, int maxVertices) {
    ConfigurationGroup group{std::move(name), std::move(title), {}, model == kBeckmann};
    const Vec3 left{-0.2f, 0.1f, 1}, right{0.25f, 0.15f, 1};
    const auto add = [&](std::string row, auto layers, Lobes side = Lobes::Reflection) {
        const int most = side == Lobes::Transmission && maxVertices == 3 ? 2 : maxVertices;
        group.rows.push_back({std::move(row),
                              [=](SlopeSampler s) {
                                  return layers(Words{s, model});
                              },
                              side, most});
    };
    add("0.3 over 0.1, coat", [=](const Words& w) {
        return Layers{Tilted(left, w.Coat(0.3f)), w.Metal(0.1f)};
    });
    add("0.1 over 0.1, base", [=](const Words& w) {
        return Layers{w.Coat(0.1f), Tilted(left, w.Metal(0.1f))};
    });
    add("0.1 over 0.3, both", [=](const Words& w) {
        return Layers{Tilted(left, w.Coat(0.1f)), Tilted(right, w.Metal(0.3f))};
    });
    add("0.05 over brushed, base", [=](const Words& w) {
        return Layers{w.Coat(0.05f), Turned(left, 35, w.Metal({0.3f, 0.06f}))};
    });
    add("0.2 over brushed, both", [=](const Words& w) {
        return Layers{Tilted(right, w.Coat(0.2f)), Turned(left, 35, w.Metal({0.3f, 0.06f}))};
    });
    add(
        "brushed 0.1 through 0.1, both",
        [=](const Words& w) {
            return Layers{Turned(left, -20, w.Coat({0.05f, 0.2f})), Tilted(right, w.Coat(0.1f, 1 / 1.5f))};
        },
        Lobes::Transmission);
    return group;
}

/// Two dielectrics over metal, or three dielectrics, of the same three alphas.
ConfigurationGroup Triples(std::string name, std::string title, MicrofacetModel model, Lobes side,
                           int maxVertices) {
    ConfigurationGroup group{std::move(name), std::move(title), {}, model == kBeckmann};
    for (const auto& [a, b, c] : {std::array{0.3f, 0.2f, 0.1f}, std::array{0.1f, 0.1f, 0.1f},
                                  std::array{0.05f, 0.1f, 0.2f}, std::array{0.3f, 0.3f, 0.3f}})
        group.rows.push_back({fmt::format("{:g} over {:g} over {:g}", a, b, c),
                              [=, top = a, middle = b, bottom = c](SlopeSampler s) {
                                  const Words w{s, model};
                                  const bool passes = side == Lobes::Transmission;
                                  return Layers{w.Coat(top), w.Coat(middle, 1.2f),
                                                passes ? w.Coat(bottom, 1 / 1.8f) : w.Metal(bottom)};
                              },
                              side, maxVertices});
    return group;
}

/// Three dielectrics over metal: one pass has 7 vertices.
ConfigurationGroup Quadruples() {
    ConfigurationGroup group{"quadruple_full", "full f, four interfaces, Beckmann, reflection", {}};
    for (const auto& [top, bottom] : {std::array{0.1f, 0.1f}, std::array{0.2f, 0.1f}, std::array{0.1f, 0.3f}})
        group.rows.push_back(
            {Cell(top, bottom),
             [=, a = top, b = bottom](SlopeSampler s) {
                 const Words w{s};
                 return Layers{w.Coat(a, 1.3f), w.Coat(a, 1.2f), w.Coat(a, 1.2f), w.Metal(b)};
             },
             Lobes::Reflection, layered::kMaxPathVertices});
    return group;
}

/// Three dielectrics of equal alphas around a middle boundary that hardly bends light.
ConfigurationGroup NearlyEqualIndices() {
    ConfigurationGroup group{"middle", "f_012, three dielectrics, Beckmann: alpha, middle index", {}};
    for (const float alpha : {0.1f, 0.3f, 0.5f})
        for (const float eta : {1.02f, 1.05f, 1.1f, 1.15f, 1.2f, 1.3f})
            group.rows.push_back(
                {fmt::format("{:g}, {:g}", alpha, eta),
                 [=](SlopeSampler s) {
                     const Words w{s};
                     return Layers{w.Coat(alpha), w.Coat(alpha, eta), w.Coat(alpha, 1 / (1.5f * eta))};
                 },
                 Lobes::Transmission, 3});
    return group;
}

ConfigurationGroup AbsorbingSlabs() {
    ConfigurationGroup group{"absorbing", "absorbing slab of thickness .1 .3 .5 1, Beckmann", {}};
    for (const int maxVertices : {3, layered::kMaxPathVertices})
        for (const auto& [top, bottom] :
             {std::array{0.3f, 0.1f}, std::array{0.1f, 0.1f}, std::array{0.1f, 0.3f}})
            group.rows.push_back(
                {Cell(top, bottom) + (maxVertices == 3 ? " f_010" : " full"),
                 [=, a0 = top, a1 = bottom](SlopeSampler s) {
                     const Words w{s};
                     return Layers{w.Coat(a0), test::Absorber(test::Lanes(0.1f, 0.3f, 0.5f, 1)), w.Metal(a1)};
                 },
                 Lobes::Reflection, maxVertices});
    return group;
}

ConfigurationGroup CoatedDiffuse() {
    ConfigurationGroup group{"diffuse", "coated diffuse, full f: coat alpha, slab's thickness, albedo", {}};
    for (const MicrofacetModel model : {kBeckmann, kGGX})
        for (const float alpha : {0.05f, 0.3f})
            for (const float thickness : {0.f, 0.5f})
                group.rows.push_back(
                    {fmt::format("{} {:g}, {:g}, 0.5", model == kGGX ? "ggx" : "beckmann", alpha, thickness),
                     [=](SlopeSampler s) {
                         const Words w{s, model};
                         return Layers{w.Coat(alpha), test::Absorber(thickness), test::Diffuse(0.5f)};
                     }});
    return group;
}

/// True if light that is not followed through specular interfaces only leaves on a side.
bool Scatters(const test::StackCase& row, Lobes side) {
    constexpr int kWalks = 2000, kEnough = 20;
    Arena arena;
    layered::LayeredOptions options;
    options.estimator = test::FindEstimator("bidirectional");
    const layered::LayeredBxDF& bxdf = *row.MakeBxDF(arena, options);
    Rng rng(Hash(side));
    const BxDFContext context{TransportMode::Radiance, side, &rng};
    int found = 0;
    for (int i = 0; i < kWalks; ++i) {
        const Vec3 wo = SampleCosineHemisphere(rng.Uniform2D());
        const auto sample = bxdf.Sample(wo, {0.999f, rng.Uniform2D()}, context);
        found += sample && !sample->IsSpecular();
    }
    return found >= kEnough;
}

/// All stacks that the truth tests know: what "auto" must not spoil.
ConfigurationGroup TestedStacks() {
    ConfigurationGroup group{"tested", "full f, the stacks of the truth tests", {}, false};
    for (const test::StackCase& row : test::StackCases())
        for (const Lobes side : {Lobes::Reflection, Lobes::Transmission})
            if (Scatters(row, side))
                group.rows.push_back({row.name + (side == Lobes::Transmission ? " through" : ""),
                                      [&row](SlopeSampler) { return row.layers; }, side});
    return group;
}

}  // namespace

std::vector<ConfigurationGroup> ProductConfigurations(bool isCoarse) {
    const auto triples = [](const char* name, const char* component, Lobes side, int maxVertices,
                            MicrofacetModel model = kBeckmann) {
        return Triples(
            name,
            fmt::format("{}, three interfaces, {}, {}", component, model == kBeckmann ? "Beckmann" : "GGX",
                        side == Lobes::Transmission ? "transmission" : "reflection"),
            model, side, maxVertices);
    };
    constexpr int kFull = layered::kMaxPathVertices;
    return {
        {"figure5",
         "f_010, Beckmann, figure 5 of [Xia et al. 2020]",
         {CoatedMetal(kBeckmann, 0.3f, 0.1f, 3)}},
        Grid("grid", "f_010, Beckmann, roughness grid", kBeckmann, 3, isCoarse),
        Grid("full", "full f, Beckmann, roughness grid", kBeckmann, kFull, isCoarse),
        Sheets("sheet", "f_01 through two dielectrics, Beckmann", kBeckmann),
        Anisotropic("anisotropic2", kBeckmann, 2.25f),
        Anisotropic("anisotropic4", kBeckmann, 4),
        Anisotropic("ggx_anisotropic2", kGGX, 2.25f),
        Anisotropic("ggx_anisotropic4", kGGX, 4),
        Perturbed("perturbed", "f_010 and f_01, Beckmann, perturbed normals", kBeckmann, 3),
        Perturbed("perturbed_full", "full f, Beckmann, perturbed normals", kBeckmann, kFull),
        Perturbed("ggx_perturbed", "f_010 and f_01, GGX, perturbed normals", kGGX, 3),
        Perturbed("ggx_perturbed_full", "full f, GGX, perturbed normals", kGGX, kFull),
        Grid("ggx", "f_010, GGX, roughness grid", kGGX, 3, isCoarse),
        Grid("ggx_full", "full f, GGX, roughness grid", kGGX, kFull, isCoarse),
        Sheets("ggx_sheet", "f_01 through two dielectrics, GGX", kGGX),
        triples("triple", "f_010", Lobes::Reflection, 3),
        triples("triple_full", "full f", Lobes::Reflection, kFull),
        Quadruples(),
        triples("triple_through", "f_012", Lobes::Transmission, 3),
        triples("triple_through_full", "full f", Lobes::Transmission, kFull),
        triples("ggx_triple_full", "full f", Lobes::Reflection, kFull, kGGX),
        triples("ggx_triple_through", "f_012", Lobes::Transmission, 3, kGGX),
        triples("ggx_triple_through_full", "full f", Lobes::Transmission, kFull, kGGX),
        NearlyEqualIndices(),
        AbsorbingSlabs(),
        CoatedDiffuse(),
        TestedStacks(),
    };
}

}  // namespace lacquer::bench
