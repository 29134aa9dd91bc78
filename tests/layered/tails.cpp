#include "layered/tails.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace lacquer::layered::test {

namespace {

StackCase Case(std::string name, std::vector<Layer> layers) {
    return {.name = std::move(name), .layers = std::move(layers)};
}

/// A coat over metal, both of one distribution.
StackCase Coated(MicrofacetModel model, float coat, float base, float eta = 1.5f) {
    return Case(fmt::format("{}_{:g}_over_{:g}{}", model == kGGX ? "ggx" : "beckmann", coat, base,
                            eta == 1.5f ? "" : fmt::format("_index_{:g}", eta)),
                {Dielectric(coat, eta, model), Metal(base, model)});
}
StackCase Pane(MicrofacetModel model, float top, float bottom) {
    return Case(fmt::format("{}_pane_{:g}_{:g}", model == kGGX ? "ggx" : "beckmann", top, bottom),
                {Dielectric(top, 1.5f, model), Dielectric(bottom, 1 / 1.5f, model)});
}

/// What the fast subset looks at: the largest tails that there once were among them.
constexpr std::array<std::string_view, 10> kSmall = {
    "beckmann_0.3_over_0.1",      "beckmann_0.8_over_0.05", "beckmann_pane_0.3_0.1", "beckmann_anisotropic",
    "ggx_0.1_over_0.003",         "ggx_0.5_over_0.02",      "ggx_pane_0.05_0.4",     "ggx_two_coats",
    "beckmann_perturbed_brushed", "ggx_perturbed_brushed"};

Vec3 Direction(float deg, float azimuthDeg, float side) {
    const float theta = Radians(deg), phi = Radians(azimuthDeg);
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), side * std::cos(theta)};
}

}  // namespace

const std::vector<StackCase>& ProductStackCases() {
    static const std::vector<StackCase> table = [] {
        std::vector<StackCase> rows;
        for (const MicrofacetModel model : {kBeckmann, kGGX}) {
            for (const auto& [coat, base] : {std::pair(0.3f, 0.1f),
                                             {0.1f, 0.003f},
                                             {0.1f, 0.1f},
                                             {0.05f, 0.3f},
                                             {0.5f, 0.02f},
                                             {0.8f, 0.05f},
                                             {0.05f, 0.05f},
                                             {0.5f, 0.5f},
                                             {0.02f, 0.1f}})
                rows.push_back(Coated(model, coat, base));
            rows.push_back(Coated(model, 0.3f, 0.1f, 2));
            rows.push_back(Coated(model, 0.2f, 0.1f, 1 / 1.3f));
            rows.push_back(Pane(model, 0.3f, 0.1f));
            rows.push_back(Pane(model, 0.05f, 0.05f));
            rows.push_back(Pane(model, 0.05f, 0.4f));
            const char* name = model == kGGX ? "ggx" : "beckmann";
            rows.push_back(Case(fmt::format("{}_three_through", name),
                                {Dielectric(0.3f, 1.5f, model), Dielectric(0.2f, 1.2f, model),
                                 Dielectric(0.1f, 1 / 1.8f, model)}));
            rows.push_back(
                Case(fmt::format("{}_two_coats", name),
                     {Dielectric(0.2f, 1.3f, model), Dielectric(0.1f, 1.2f, model), Metal(0.1f, model)}));
        }
        rows.push_back(Case("beckmann_anisotropic", {Dielectric(Alphas(0.4f, 0.1f), 1.5f, kBeckmann),
                                                     Rotated(60, Metal(Alphas(0.3f, 0.05f), kBeckmann))}));
        for (const MicrofacetModel model : {kBeckmann, kGGX}) {
            const char* name = model == kGGX ? "ggx" : "beckmann";
            rows.push_back(
                Case(fmt::format("{}_brushed", name),
                     {Dielectric(0.1f, 1.5f, model), Rotated(40, Metal(Alphas(0.3f, 0.05f), model))}));
            rows.push_back(
                Case(fmt::format("{}_perturbed_coat", name),
                     {Tilted({0.3f, -0.2f, 1}, Dielectric(0.3f, 1.5f, model)), Metal(0.1f, model)}));
            rows.push_back(Case(fmt::format("{}_perturbed_brushed", name),
                                {Tilted({-0.2f, 0.2f, 1}, Dielectric(0.1f, 1.5f, model)),
                                 Turned({0.3f, 0.2f, 1}, 40, Metal(Alphas(0.3f, 0.05f), model))}));
            rows.push_back(Case(fmt::format("{}_perturbed_pane", name),
                                {Turned({0.2f, 0.3f, 1}, 30, Dielectric(Alphas(0.2f, 0.1f), 1.5f, model)),
                                 Tilted({-0.3f, 0, 1}, Dielectric(0.1f, 1 / 1.5f, model))}));
        }
        rows.push_back(Case("mixed_0.3_over_0.1", {Dielectric(0.3f, 1.5f), Metal(0.1f, kBeckmann)}));
        for (StackCase& row : rows) row.isSmall = std::count(kSmall.begin(), kSmall.end(), row.name) > 0;
        return rows;
    }();
    return table;
}

std::vector<TailQuery> TailQueriesOf(const Stack& stack) {
    struct Angles {
        float out, in, turn;
    };
    static constexpr Angles kAngles[] = {
        // Mirrors, and what passes straight through.
        {30, 30, 0},
        {75, 75, 0},
        {85, 85, 0},
        {89, 89, 0},
        {89.5f, 89.5f, 0},
        // One direction grazes.
        {89, 20, 0},
        {20, 89.5f, 0},
        {89.5f, 60, 0},
        {70, 85, 30},
        // Off the lobe.
        {75, 20, 0},
        {30, 70, 90},
        {75, 40, 180},
        {89, 60, 120},
    };
    std::vector<TailQuery> queries;
    for (const float side : {1.f, -1.f}) {
        if (side < 0 && !Transmits(stack)) continue;
        for (const Angles& a : kAngles)
            queries.push_back({fmt::format("{:g} {:g} {:g}{}", a.out, a.in, a.turn, side < 0 ? " below" : ""),
                               Direction(a.out, 25, 1), Direction(a.in, 205 + a.turn, side)});
    }
    return queries;
}

Tail MeasureTail(const LayeredEstimator& estimator, const Stack& stack, const TailQuery& query,
                 int maxVertices, int numEstimates, uint64_t seed) {
    Rng rng(seed);
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
    double sum = 0, squares = 0, largest = 0;
    for (int i = 0; i < numEstimates; ++i) {
        const double x =
            double(estimator.Evaluate(stack, query.wo, query.wi, context, maxVertices).Average());
        sum += x;
        squares += x * x;
        largest = std::max(largest, x);
    }
    Tail tail;
    tail.mean = sum / numEstimates;
    if (!(tail.mean > 0)) return tail;
    const double meanSquare = squares / numEstimates / (tail.mean * tail.mean);
    tail.deviation = std::sqrt(std::max(0., meanSquare - 1));
    tail.largest = largest / tail.mean;
    return tail;
}

}  // namespace lacquer::layered::test
