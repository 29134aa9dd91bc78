// The choice of a method for each query: what it goes by, what it says, and that it wins.
#include "layered/estimators/query_plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "layered/connection_walk.h"
#include "layered/estimators/light_forecast.h"
#include "layered/random_queries.h"
#include "support/statistics.h"

namespace lacquer::layered::test::query_plan_test {

using namespace lacquer::test;

namespace {

constexpr int kAll = kMaxPathVertices;
constexpr QueryPlan kConnections = {};

Vec3 Direction(float degrees, float azimuthDegrees = 0) {
    const float theta = Radians(degrees);
    return SphericalDirection(std::sin(theta), std::cos(theta), Radians(azimuthDegrees));
}
StackCase Coated(float alphaCoat, float alphaBase, MicrofacetModel model = kBeckmann) {
    StackCase row;
    row.layers = {Dielectric(alphaCoat, 1.5f, model), Metal(alphaBase, model)};
    return row;
}
QueryPlan PlanOf(const StackCase& row, Vec3 wo, Vec3 wi) {
    Arena arena;
    return PlanQuery(row.Build(arena), wo, wi, kAll);
}

/// Mean and variance of the average of the wavelengths.
template <class Estimate>
RunningMean Measure(int count, uint64_t seed, const Estimate& estimate) {
    Rng rng(seed);
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng, false};
    RunningMean mean;
    for (int i = 0; i < count; ++i) mean.Add(double(estimate(context).Average()));
    return mean;
}

// ---- The forecast -----------------------------------------------------------------------------------------

// Against estimates under random coats, in their lobes. Others are forecast for the same coats seen from
// exchanged directions, as a control.
TEST(LightForecast, KnowsWhatLongerPathsCarry) {
    constexpr int kQueries = 60, kSamples = 4000;
    int numNear = 0, numNearOfOthers = 0, found = 0;
    double other = 1;
    for (uint64_t k = 0; found < kQueries; ++k) {
        const RandomQuery query = MakeRandomQuery(SeedOf(fmt::format("{} {}", FullTestName(), k)));
        Arena arena;
        const Stack stack = query.row.Build(arena);
        LightForecast forecast;
        if (stack.Last() != 1 || stack.interfaces[1].transmits || !stack.slabs[0].IsClear() ||
            !ForecastLight(stack, query.wo, query.wi, Infinity, &forecast) || forecast.reflectsTotally)
            continue;
        const MicrofacetSurface &coat = *FacetsOf(stack.interfaces[0]),
                                &base = *FacetsOf(stack.interfaces[1]);
        if (coat.eta < 1 || forecast.exponent > 4) continue;
        const auto light = [&](int maxVertices, KnownPaths known) {
            return Measure(Scaled(kSamples), Hash(k),
                           [&](const BxDFContext& context) {
                               return ConnectionWalk<WalkPolicy>(stack, context, maxVertices, known)
                                   .Estimate(query.wo, query.wi);
                           })
                .Mean();
        };
        const double all = light(kAll, {}), longer = light(kAll, {3});
        if (!(longer > 0 && all > longer)) continue;
        ++found;
        const double measured = longer / (all - longer);
        const double told = double(LightOfLongerPaths(forecast, coat, base));
        const auto isNear = [&](double x) { return std::abs(std::log(x / measured)) < std::log(4.); };
        numNear += isNear(told);
        numNearOfOthers += isNear(other);
        other = told;
    }
    // Measured: 57 and 29.
    EXPECT_GT(numNear, 0.8 * kQueries);
    EXPECT_LT(numNearOfOthers, 0.65 * kQueries);
}

// ---- The plan ---------------------------------------------------------------------------------------------

TEST(QueryPlan, GoesWithTheDirections) {
    using enum PathMethod;
    const StackCase smoothBase = Coated(0.5f, 0.02f), rough = Coated(0.1f, 0.5f), equal = Coated(0.2f, 0.2f);
    const QueryPlan onLobe = PlanOf(smoothBase, Direction(20), Direction(20, 180));
    EXPECT_EQ(onLobe.shortest, Product);
    EXPECT_EQ(onLobe.rest, Connection);
    EXPECT_LT(onLobe.restProbability, 0.7f);
    // Where longer paths carry all of it, they are made each time.
    for (const float degrees : {70.f, 75.f, 80.f, 85.f, 89.5f})
        for (const float azimuth : {0.f, 90.f, 180.f}) {
            const QueryPlan off = PlanOf(smoothBase, Direction(degrees), Direction(20, azimuth));
            EXPECT_TRUE(off.shortest == Connection || off.restProbability > 0.9f)
                << degrees << " " << azimuth;
            const QueryPlan rougher = PlanOf(Coated(0.8f, 0.05f), Direction(degrees), Direction(20, azimuth));
            EXPECT_TRUE(rougher.shortest == Connection || rougher.restProbability > 0.9f) << degrees;
        }
    EXPECT_EQ(PlanOf(rough, Direction(30), Direction(40, 170)).shortest, LongPathWalk);
    EXPECT_EQ(PlanOf(equal, Direction(30), Direction(30, 180)).rest, LongPathWalk);
    EXPECT_EQ(PlanOf(equal, Direction(30), Direction(30, 180)).shortest, Product);
    EXPECT_EQ(PlanOf(Coated(0.02f, 0.02f), Direction(60), Direction(10)).shortest, Connection);
    EXPECT_EQ(PlanOf(Coated(0.02f, 0.02f, kGGX), Direction(60), Direction(10)).shortest, Connection);

    StackCase pane, coats;
    pane.layers = {Dielectric(0.1f, 1.5f, kBeckmann), Dielectric(0.1f, 1 / 1.5f, kBeckmann)};
    EXPECT_EQ(PlanOf(pane, Direction(30), -Direction(32)).shortest, Product);
    EXPECT_EQ(PlanOf(pane, Direction(30), -Direction(32, 180)).shortest, Connection);
    coats.layers = {Dielectric(0.1f, 1.5f, kBeckmann), Dielectric(0.1f, 1.2f, kBeckmann),
                    Metal(0.1f, kBeckmann)};
    EXPECT_EQ(PlanOf(coats, Direction(30), Direction(30, 180)).shortest, PairProduct);
    EXPECT_EQ(PlanOf(coats, Direction(30), Direction(60)).shortest, Connection);
    EXPECT_EQ(PlanOf(coats, Direction(85), Direction(30)).shortest, Connection);
}

// A coat over metal brushed at right angles to the plane of the directions, or with a normal that turns the
// mirror's direction by 20 degrees.
TEST(QueryPlan, KnowsWhereFacetsAreTurned) {
    using enum PathMethod;
    for (const MicrofacetModel model : {kBeckmann, kGGX}) {
        StackCase brushed, perturbed;
        brushed.layers = {Dielectric(0.1f, 1.5f, model), Rotated(90, Metal(Alphas(0.25f, 0.02f), model))};
        const float tangent = std::tan(Radians(10.f));
        perturbed.layers = {Dielectric(0.05f, 1.5f, model), Tilted({tangent, 0, 1}, Metal(0.02f, model))};
        EXPECT_EQ(PlanOf(brushed, Direction(30), Direction(30, 180)).shortest, Product);
        EXPECT_EQ(PlanOf(brushed, Direction(25, 40), Direction(25, 140)).shortest, Product) << "along it";
        EXPECT_EQ(PlanOf(brushed, Direction(50), Direction(5, 180)).shortest, Connection) << "across";
        // Inside, 10 degrees of the metal are 20 of the light, and some 32 outside.
        EXPECT_EQ(PlanOf(perturbed, Direction(0.1f), Direction(32)).shortest, Product);
        EXPECT_EQ(PlanOf(perturbed, Direction(30), Direction(30, 180)).shortest, Connection);
    }
    StackCase pane;
    pane.layers = {Tilted({0.2f, 0, 1}, Dielectric(0.05f, 1.5f, kBeckmann)),
                   Tilted({0.2f, 0.1f, 1}, Dielectric(0.1f, 1 / 1.5f, kBeckmann))};
    EXPECT_EQ(PlanOf(pane, Direction(10), -Direction(11)).shortest, Product);
    EXPECT_EQ(PlanOf(pane, Direction(10), -Direction(60)).shortest, Connection);
    // Below the horizon of the coat nothing is to be planned.
    StackCase steep;
    steep.layers = {Tilted({0.5f, 0, 1}, Dielectric(0.1f, 1.5f, kBeckmann)), Metal(0.1f, kBeckmann)};
    EXPECT_EQ(PlanOf(steep, Direction(80, 180), Direction(30)).shortest, Connection);
}

TEST(QueryPlan, ProbabilitiesAreProbabilities) {
    for (uint64_t k = 0; k < 2000; ++k) {
        const RandomQuery query =
            MakeRandomQuery(SeedOf(fmt::format("{} {}", FullTestName(), k)), k % 2 != 0);
        const float share = PlanOf(query.row, query.wo, query.wi).restProbability;
        EXPECT_TRUE(share > 0.1f && share <= 1) << query.Describe();
    }
}

/// All plans against connections alone.
TEST(QueryPlan, AllPlansHaveTheSameMean) {
    using enum PathMethod;
    Arena arena;
    const Stack stack = Coated(0.3f, 0.3f).Build(arena);
    const Vec3 wo = Direction(20), wi = Direction(30, 170);
    const auto difference = [&](const QueryPlan& plan, int maxVertices, uint64_t seed) {
        return Measure(Scaled(20000), seed, [&](const BxDFContext& context) {
            return EstimateByPlan(plan, stack, wo, wi, context, maxVertices) -
                   ConnectionWalk<WalkPolicy>(stack, context, kAll).Estimate(wo, wi);
        });
    };
    for (const QueryPlan& plan :
         {kConnections, QueryPlan{LongPathWalk, LongPathWalk, 1}, QueryPlan{Product, LongPathWalk, 1},
          QueryPlan{Product, LongPathWalk, 0.5f}, QueryPlan{Product, Connection, 0.3f},
          QueryPlan{PairProduct, Connection, 1}}) {
        EXPECT_TRUE(Passes(FullTestName() + fmt::format("{} {} {}", int(plan.shortest), int(plan.rest),
                                                        plan.restProbability),
                           1e-4,
                           [&](uint64_t seed) { return ZTest(difference(plan, kAll, seed), 0, 0, "plan"); }));
        // The control: without the longest paths.
        const RunningMean less = difference(plan, 5, SeedOf(FullTestName()));
        EXPECT_GT(std::abs(less.Mean()), 5 * less.StandardError()) << int(plan.shortest);
    }
}

// ---- Against connections
// ------------------------------------------------------------------------------------

/// Time of an estimate in units of what connections take, as measured in release builds; the worse end of it.
double CostOf(const QueryPlan& plan) {
    constexpr double kProduct = 0.4, kLongPaths = 1.1, kPairs = 2.5;
    switch (plan.shortest) {
        case PathMethod::Product:
            return kProduct +
                   double(plan.restProbability) * (plan.rest == PathMethod::LongPathWalk ? kLongPaths : 1);
        case PathMethod::PairProduct:
            return kPairs;
        case PathMethod::LongPathWalk:
            return kLongPaths;
        case PathMethod::Connection:
            break;
    }
    return 1;
}

/// Efficiency against connections over random queries, time counted and not measured, sorted. Queries that
/// are left to connections are no news and do not count.
/// @param isTurned  of MakeRandomQuery()
/// @param planOf  (stack, query) -> a plan
template <class PlanFunction>
std::vector<double> EfficienciesOf(int count, bool isTurned, const PlanFunction& planOf) {
    constexpr int kSamples = 3000;
    // What no image shows is no noise [1/sr].
    constexpr double kFloor = 1e-4;
    std::vector<double> values;
    for (uint64_t k = 0; int(values.size()) < count; ++k) {
        const RandomQuery query = MakeRandomQuery(SeedOf(fmt::format("{} {}", FullTestName(), k)), isTurned);
        Arena arena;
        const Stack stack = query.row.Build(arena);
        const QueryPlan plan = planOf(stack, query);
        if (plan.shortest == PathMethod::Connection) continue;
        const auto variance = [&](const QueryPlan& method, uint64_t seed) {
            const RunningMean mean = Measure(Scaled(kSamples), seed, [&](const BxDFContext& context) {
                return EstimateByPlan(method, stack, query.wo, query.wi, context, kAll);
            });
            return mean.Variance() + Sqr(kFloor);
        };
        values.push_back(variance(kConnections, Hash(k, 0)) / (variance(plan, Hash(k, 1)) * CostOf(plan)));
    }
    std::sort(values.begin(), values.end());
    return values;
}

// What product_bench --battery measures with a clock, with fewer queries and without it. The control is one
// division for all directions: half vectors and a fifth of the walks wherever a coat lies on metal.
TEST(QueryPlan, WinsWhereItLeavesConnections) {
    constexpr int kQueries = 100;
    const auto quantile = [&](const std::vector<double>& values, double q) {
        return values[size_t(q * double(values.size() - 1))];
    };
    const auto plan = [](const Stack& stack, const RandomQuery& query) {
        return PlanQuery(stack, query.wo, query.wi, kAll);
    };
    const std::vector<double> plans = EfficienciesOf(kQueries, false, plan);
    // Measured: 1.1 and 3.1; 0.15 and 0.6 of the control.
    EXPECT_GT(quantile(plans, 0.05), 0.8);
    EXPECT_GT(quantile(plans, 0.5), 2);
    // With anisotropic facets and perturbed normals.
    const std::vector<double> turned = EfficienciesOf(kQueries / 2, true, plan);
    EXPECT_GT(quantile(turned, 0.05), 0.7) << quantile(turned, 0.05);
    EXPECT_GT(quantile(turned, 0.5), 2) << quantile(turned, 0.5);
    const std::vector<double> control =
        EfficienciesOf(kQueries, false, [](const Stack& stack, const RandomQuery& query) {
            const bool isCoat =
                stack.Last() == 1 && query.wo.z > 0 && query.wi.z > 0 && !stack.interfaces[1].transmits;
            return isCoat ? QueryPlan{PathMethod::Product, PathMethod::Connection, 0.2f} : kConnections;
        });
    EXPECT_LT(quantile(control, 0.05), 0.4);
    EXPECT_LT(quantile(control, 0.5), 1);
}

}  // namespace
}  // namespace lacquer::layered::test::query_plan_test
