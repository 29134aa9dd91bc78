// Product estimators against the walks of "bidirectional" on the short paths that they make in another way,
// and their parts alone. The long paths and all kinds of stacks are the agreement test's.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "layered/agreement.h"
#include "layered/connection_walk.h"
#include "layered/paths/products/pair_walk.h"

namespace lacquer::layered::test::product_estimators_test {

namespace {

struct Row {
    std::string name;
    std::vector<Layer> layers;
    int maxVertices = 3;
    bool transmits = false;
    bool hasPairs = true;  ///< pair products take part
};

std::vector<Row> ReflectingRows() {
    const Layer coat = Dielectric(0.2f, 1.5f, kBeckmann), metal = Metal(0.2f, kBeckmann);
    return {
        {"figure_5", {Dielectric(0.3f, 1.5f, kBeckmann), Metal(0.1f, kBeckmann)}},
        {"smooth_over_rough", {Dielectric(0.05f, 1.5f, kBeckmann), Metal(0.3f, kBeckmann)}},
        {"rough", {Dielectric(0.5f, 1.5f, kBeckmann), Mirror(0.5f, kBeckmann)}},
        {"dense", {Dielectric(0.2f, 2.2f, kBeckmann), metal}},
        {"absorber", {coat, Absorber(Lanes(0.2f, 0.5f, 1, 2)), metal}},
        {"medium", {coat, Medium(1, 0.8f, HG(0.5f)), metal}},
        {"ggx", {Dielectric(0.3f, 1.5f), Metal(0.2f)}},
        {"ggx_smooth_base", {Dielectric(0.3f, 1.5f), Metal(0.1f)}},
        {"ggx_over_beckmann", {Dielectric(0.1f, 1.5f), Absorber(0.3f), Metal(0.05f, kBeckmann)}},
        {"mixed", {coat, Metal(0.2f)}},
        {"pane_mirrored", {coat, Dielectric(0.3f, 1 / 1.5f, kBeckmann)}},
        {"turned_tangent", {Rotated(30, coat), Rotated(70, metal)}},
        {"two_coats", {Dielectric(0.2f, 1.3f, kBeckmann), Dielectric(0.1f, 1.2f, kBeckmann), metal}, 5},
        {"two_coats_absorber",
         {Dielectric(0.1f, 1.3f, kBeckmann), Absorber(0.3f), Dielectric(0.3f, 1.2f, kBeckmann),
          Absorber(0.2f), metal},
         5},
        {"two_coats_diffuse",
         {Dielectric(0.2f, 1.3f, kBeckmann), Dielectric(0.2f, 1.2f, kBeckmann), Diffuse(0.5f)},
         5},
        {"three_coats",
         {Dielectric(0.1f, 1.3f, kBeckmann), Dielectric(0.1f, 1.2f, kBeckmann),
          Dielectric(0.1f, 1.2f, kBeckmann), Metal(0.15f, kBeckmann)},
         7},
        // Light that is reflected between the coats, which direct paths leave to walks.
        {"strong_middle",
         {Dielectric(0.1f, 1.5f, kBeckmann), Dielectric(0.1f, 1.5f, kBeckmann), Mirror(0.1f, kBeckmann)},
         5},
        {"two_coats_all",
         {Dielectric(0.2f, 1.3f, kBeckmann), Dielectric(0.1f, 1.2f, kBeckmann), Metal(0.1f, kBeckmann)},
         kMaxPathVertices},
        {"smooth_base", {Dielectric(0.1f, 1.5f, kBeckmann), Metal(0.02f, kBeckmann)}, 7},
        {"smooth_base_all", {Dielectric(0.1f, 1.5f, kBeckmann), Metal(0.02f, kBeckmann)}, kMaxPathVertices},
        {"figure_5_all", {Dielectric(0.3f, 1.5f, kBeckmann), Metal(0.1f, kBeckmann)}, kMaxPathVertices},
        // Long paths: light is trapped, and some of it scatters on its way.
        {"dense_all", {Dielectric(0.3f, 2.2f, kBeckmann), Mirror(0.2f, kBeckmann)}, kMaxPathVertices},
        {"medium_all",
         {coat, Medium(Lanes(0.1f, 0.3f, 0.6f, 1), SampledSpectrum(0.8f), HG(0.5f)), Mirror(0.3f, kBeckmann)},
         kMaxPathVertices},
    };
}

std::vector<Row> TransmittingRows() {
    const float up = 1 / 1.5f;
    const Layer top = Dielectric(0.2f, 1.5f, kBeckmann), bottom = Dielectric(0.1f, up, kBeckmann);
    return {
        {"pane", {top, bottom}, 2, true},
        {"pane_absorber", {top, Absorber(Lanes(0.2f, 0.5f, 1, 2)), bottom}, 2, true},
        {"pane_medium", {top, Medium(1, 0.8f, HG(0.5f)), bottom}, 2, true},
        {"pane_ggx", {Dielectric(0.3f, 1.5f), Dielectric(0.2f, up)}, 2, true},
        {"into_glass", {Dielectric(0.2f, 1.3f, kBeckmann), Dielectric(0.3f, 1.2f, kBeckmann)}, 2, true},
        {"three",
         {Dielectric(0.3f, 1.3f, kBeckmann), Dielectric(0.2f, 1.2f, kBeckmann),
          Dielectric(0.1f, 1 / 1.56f, kBeckmann)},
         3,
         true},
        {"three_smoother",
         {Dielectric(0.05f, 1.3f, kBeckmann), Dielectric(0.1f, 1.4f, kBeckmann),
          Dielectric(0.05f, 1 / 1.5f, kBeckmann)},
         3,
         true},
        {"three_ggx",
         {Dielectric(0.2f, 1.3f), Dielectric(0.2f, 1.2f, kBeckmann), Dielectric(0.1f, 1 / 1.56f)},
         3,
         true},
        {"four",
         {Dielectric(0.2f, 1.3f, kBeckmann), Dielectric(0.1f, 1.2f, kBeckmann),
          Dielectric(0.2f, 1 / 1.2f, kBeckmann), Dielectric(0.1f, 1 / 1.3f, kBeckmann)},
         4,
         true},
        {"smooth_pane", {Dielectric(0.03f, 1.5f, kBeckmann), Dielectric(0.03f, up, kBeckmann)}, 4, true},
        {"pane_all", {top, bottom}, kMaxPathVertices, true},
    };
}

std::vector<Row> AllRows() {
    std::vector<Row> rows = ReflectingRows();
    for (Row& row : TransmittingRows()) rows.push_back(row);
    return rows;
}

struct Query {
    Vec3 wo, wi;
    TransportMode mode;
};

/// Where smooth interfaces would send light, near it, and far from it; from both sides; both modes in turn.
std::vector<Query> QueriesOf(const Row& row, const Stack& stack) {
    std::vector<Query> queries;
    const bool fromBelow = Transmits(stack);
    int count = 0;
    for (const float side : {1.f, -1.f}) {
        if (side < 0 && !fromBelow) continue;
        for (const float thetaDeg : {0.f, 30.f, 65.f}) {
            const float sine = std::sin(Radians(thetaDeg));
            const Vec3 wo = SphericalDirection(sine, std::cos(Radians(thetaDeg)), 0.7f) * side;
            for (const Vec3 offset : {Vec3(0, 0, 0), Vec3(0.1f, -0.05f, 0)}) {
                const float eta = row.transmits ? (side > 0 ? stack.eta : 1 / stack.eta) : 1.f;
                Vec3 wi(-wo.x / eta + offset.x, -wo.y / eta + offset.y, 0);
                const float sine2 = wi.x * wi.x + wi.y * wi.y;
                if (sine2 > 0.95f) continue;
                wi.z = std::sqrt(1 - sine2) * (row.transmits ? -side : side);
                queries.push_back(
                    {wo, wi, count++ % 2 ? TransportMode::Importance : TransportMode::Radiance});
            }
        }
    }
    return queries;
}

using Estimate =
    std::function<SampledSpectrum(const Stack&, const Query&, const BxDFContext&, int maxVertices)>;

Estimate ByName(const std::string& name) {
    return [estimator = FindEstimator(name)](const Stack& stack, const Query& q, const BxDFContext& context,
                                             int maxVertices) {
        return estimator->Evaluate(stack, q.wo, q.wi, context, maxVertices);
    };
}

RunningMean MeanOf(const Estimate& estimate, const Stack& stack, const Query& q, int maxVertices, int n,
                   uint64_t seed) {
    RunningMean mean;
    Rng rng(seed);
    const BxDFContext context{q.mode, Lobes::BothSides, &rng, false};
    // The lanes differ; a weighted sum sees errors of each.
    const SampledSpectrum weights = Lanes(0.4f, 0.3f, 0.2f, 0.1f);
    for (int i = 0; i < n; ++i) mean.Add(double((estimate(stack, q, context, maxVertices) * weights).Sum()));
    return mean;
}

/// Differences of an estimate from "bidirectional" over all queries of some rows.
struct Verdict {
    int numTests = 0;
    double worstZ = 0;
    double sumZ = 0;  ///< of all relative differences together
    std::string worst;
};

/// A query of a row, and its number there.
struct NumberedQuery {
    const Row& row;
    const Stack& stack;
    Query query;
    int number;
};

/// The mean of n values of "bidirectional": the same for all that is compared with it, and made once.
const RunningMean& ReferenceOf(const NumberedQuery& q, int n) {
    static const Estimate bidirectional = ByName("bidirectional");
    static std::map<std::string, RunningMean> means;
    const std::string name = fmt::format("{} {} {} {}", q.row.name, q.number, q.row.maxVertices, n);
    const auto [mean, isNew] = means.try_emplace(name);
    if (isNew) mean->second = MeanOf(bidirectional, q.stack, q.query, q.row.maxVertices, n, SeedOf(name));
    return mean->second;
}

/// A mean and that of "bidirectional". A difference of more than kSuspicious standard errors must show itself
/// again, with 16 times as many values: rare bright ones make a mean and its error too small together.
std::pair<RunningMean, RunningMean> MeansOf(const Estimate& estimate, const NumberedQuery& q, int n,
                                            uint64_t seed) {
    const auto measure = [&](int count, uint64_t s) {
        return std::pair(MeanOf(estimate, q.stack, q.query, q.row.maxVertices, count, s),
                         ReferenceOf(q, count));
    };
    const auto first = measure(n, seed);
    const auto& [a, b] = first;
    const double error = std::hypot(a.StandardError(), b.StandardError());
    return std::abs(a.Mean() - b.Mean()) > kSuspicious * error ? measure(16 * n, Hash(seed)) : first;
}

Verdict Compare(const Estimate& estimate, const std::vector<Row>& rows, int n, const std::string& name) {
    Verdict v;
    double difference = 0, variance = 0;
    for (const Row& row : rows) {
        Arena arena;
        const Stack stack = StackCase{.name = row.name, .layers = row.layers}.Build(arena);
        int number = 0;
        for (const Query& q : QueriesOf(row, stack)) {
            const uint64_t seed = SeedOf(name + row.name + std::to_string(v.numTests));
            const auto [a, b] = MeansOf(estimate, {row, stack, q, number++}, n, seed);
            const double error = std::hypot(a.StandardError(), b.StandardError());
            ++v.numTests;
            if (!(b.Mean() > 0)) continue;
            const double z = (a.Mean() - b.Mean()) / error;
            if (std::abs(z) > std::abs(v.worstZ)) {
                v.worstZ = z;
                v.worst = fmt::format("{} at {} degrees: {:.5g} +- {:.2g}, bidirectional {:.5g} +- {:.2g}",
                                      row.name, Degrees(SafeACos(q.wo.z)), a.Mean(), a.StandardError(),
                                      b.Mean(), b.StandardError());
            }
            difference += a.Mean() / b.Mean() - 1;
            variance += Sqr(error / b.Mean());
        }
    }
    v.sumZ = difference / std::sqrt(variance);
    return v;
}

constexpr int kValues = 4000;

/// Both judgements; `alpha` is each one's.
bool IsRight(const Verdict& v, double alpha) {
    return NormalTwoSided(v.worstZ) >= SidakAlpha(alpha, v.numTests) && NormalTwoSided(v.sumZ) >= alpha;
}

// ---- Unbiasedness -------------------------------------------------------------------------------------

// Power: a single query has a standard error of 1 to 3 %, the sum over all queries one of 0.2 %, so that an
// error of 1 % of all is found. The controls below fail both judgements.
void ExpectMeansOfBidirectional(std::initializer_list<const char*> estimators) {
    // Not fewer under sanitizers: the tails of a few hundred values make their mean's error look too small.
    for (const char* name : estimators) {
        const Verdict v = Compare(ByName(name), AllRows(), kValues, FullTestName() + name);
        EXPECT_TRUE(IsRight(v, 5e-4)) << name << ": " << v.worst << "; worst of " << v.numTests << ": "
                                      << v.worstZ << " sigma, together " << v.sumZ;
        testing::Test::RecordProperty(
            name, fmt::format("worst {} sigma of {}, together {}", v.worstZ, v.numTests, v.sumZ));
    }
}

// What estimators do by default, and all strategies for paths of any length.
TEST(ProductMeans, AgreeWithBidirectionalOnShortPaths) {
    ExpectMeansOfBidirectional({"pairproduct", "multiproduct", "pairproduct:all:99999"});
}
// Other choices of strategies and events, made of the same parts (PairWalk.EachStrategyAloneIsUnbiased).
TEST(ProductMeansLong, AgreeWithBidirectionalOnShortPaths) {
    ExpectMeansOfBidirectional(
        {"pairproduct:middle:99999", "pairproduct:all", "multiproduct:5", "multiproduct:7"});
}

class ProductEstimators : public testing::TestWithParam<const char*> {};

TEST_P(ProductEstimators, SameNumbersGiveTheSameValue) {
    for (const Row& row : AllRows()) {
        Arena arena;
        const Stack stack = StackCase{.name = row.name, .layers = row.layers}.Build(arena);
        for (const Query& q : QueriesOf(row, stack)) {
            const Estimate estimate = ByName(GetParam());
            Rng a(SeedOf(row.name)), b(SeedOf(row.name));
            for (int i = 0; i < 3; ++i)
                EXPECT_TRUE(estimate(stack, q, {q.mode, Lobes::BothSides, &a, false}, row.maxVertices) ==
                            estimate(stack, q, {q.mode, Lobes::BothSides, &b, false}, row.maxVertices));
        }
    }
}

/// Where no product is possible the estimators are "bidirectional", number by number.
TEST_P(ProductEstimators, FallBackToBidirectional) {
    const Layer coat = Dielectric(0.2f, 1.5f, kBeckmann), metal = Metal(0.2f, kBeckmann);
    const std::vector<std::vector<Layer>> stacks = {
        {Dielectric(0, 1.5f), metal},
        {coat, Mirror(0)},
        {coat, Diffuse(0.5f)},
        {coat, Metal(Alphas(0.1f, 0.3f), kBeckmann)},
        {Dielectric(Alphas(0.1f, 0.3f), 1.5f, kBeckmann), metal},
        {coat, Tilted({0.1f, 0, 1}, metal)},
        {coat, Metal(0.0015f, kBeckmann)},               // below the tables
        {Dielectric(0.2f, 1.01f, kBeckmann), metal},     // index below the tables
        {Dielectric(0.2f, 3, kBeckmann), metal},         // and above
        {Dielectric(0.2f, 1 / 1.5f, kBeckmann), metal},  // the outside has the larger index
        {Nothing(), metal},
        {coat},
    };
    for (size_t k = 0; k < stacks.size(); ++k) {
        Arena arena;
        const Stack stack = StackCase{.name = "", .layers = stacks[k]}.Build(arena);
        const Vec3 wo = Normalize(Vec3(0.3f, 0.2f, 1)), wi = Normalize(Vec3(-0.2f, -0.2f, 1));
        Rng a(SeedOf(FullTestName())), b = a;
        EXPECT_FALSE(PairWalk<>(stack, {TransportMode::Radiance, Lobes::BothSides, &a}, 3).Set(wo, wi)) << k;
        for (int i = 0; i < 20; ++i)
            EXPECT_TRUE(ByName(GetParam())(stack, {wo, wi, {}}, {{}, Lobes::BothSides, &a, false}, 10) ==
                        ByName("bidirectional")(stack, {wo, wi, {}}, {{}, Lobes::BothSides, &b, false}, 10))
                << k;
    }
}

// Through three dielectrics, too: the one in the middle needs lobes for what passes, not for reflections.
TEST_P(ProductEstimators, FallBackToBidirectionalThroughThreeInterfaces) {
    const Layer coat = Dielectric(0.3f, 1.5f, kBeckmann), last = Dielectric(0.1f, 1 / 1.5f, kBeckmann);
    for (const float eta : {1.0001f, 1.03f, 0.98f, 3.f}) {
        Arena arena;
        const Stack stack =
            StackCase{.name = "", .layers = {coat, Dielectric(0.1f, eta, kBeckmann), last}}.Build(arena);
        const Vec3 wo = Normalize(Vec3(0.3f, 0.2f, 1)), wi = Normalize(Vec3(-0.2f, -0.2f, -1));
        Rng a(SeedOf(FullTestName())), b = a;
        EXPECT_FALSE(PairWalk<>(stack, {TransportMode::Radiance, Lobes::BothSides, &a}, 3).Set(wo, wi))
            << eta;
        for (int i = 0; i < 20; ++i)
            EXPECT_TRUE(ByName(GetParam())(stack, {wo, wi, {}}, {{}, Lobes::BothSides, &a, false}, 10) ==
                        ByName("bidirectional")(stack, {wo, wi, {}}, {{}, Lobes::BothSides, &b, false}, 10))
                << eta;
    }
}

// Directions in the horizon and across it, on stacks of all kinds: values stay finite and not negative.
TEST_P(ProductEstimators, ValuesAreValidAtGrazing) {
    const Estimate estimate = ByName(GetParam());
    for (const Row& row : AllRows()) {
        Arena arena;
        const Stack stack = StackCase{.name = row.name, .layers = row.layers}.Build(arena);
        Rng rng(SeedOf(FullTestName() + row.name));
        for (int i = 0; i < 200; ++i) {
            const float z = 1e-6f * std::pow(1e6f, rng.Uniform());
            const Vec3 wo = SphericalDirection(std::sqrt(1 - z * z), z, 2 * Pi * rng.Uniform());
            const float y = 1e-6f * std::pow(1e6f, rng.Uniform());
            const Vec3 wi =
                SphericalDirection(std::sqrt(1 - y * y), row.transmits ? -y : y, 2 * Pi * rng.Uniform());
            const auto value =
                estimate(stack, {wo, wi, {}}, {{}, Lobes::BothSides, &rng, false}, row.maxVertices);
            EXPECT_TRUE(value.IsValid()) << row.name << " " << z << " " << y;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(, ProductEstimators,
                         testing::Values("pairproduct", "pairproduct:middle:99999", "pairproduct:all",
                                         "pairproduct:all:99999", "multiproduct", "multiproduct:5",
                                         "multiproduct:7"),
                         [](const testing::TestParamInfo<const char*>& p) {
                             std::string name = p.param;
                             std::erase(name, ':');
                             return name;
                         });

// The comparison above is of products, not of fallbacks.
TEST(PairWalk, TakesPartInTheRowsOfTheComparison) {
    for (const Row& row : AllRows()) {
        Arena arena;
        const Stack stack = StackCase{.name = row.name, .layers = row.layers}.Build(arena);
        Rng rng;
        for (const Query& q : QueriesOf(row, stack)) {
            const int n = row.name == "two_coats_diffuse" ? 3 : row.maxVertices;
            EXPECT_TRUE(PairWalk<>(stack, {q.mode, Lobes::BothSides, &rng}, n).Set(q.wo, q.wi)) << row.name;
        }
    }
}

// ---- Strategies ---------------------------------------------------------------------------------------

template <class Policy>
Estimate PairsWith() {
    return [](const Stack& stack, const Query& q, const BxDFContext& context, int maxVertices) {
        PairWalk<Policy> walk(stack, context, maxVertices);
        return walk.Set(q.wo, q.wi) ? walk.Estimate() : SampledSpectrum(0);
    };
}

/// Rows with two strategies for each path and nothing else.
std::vector<Row> PairRows() {
    return {
        {"coat", {Dielectric(0.2f, 1.5f, kBeckmann), Metal(0.2f, kBeckmann)}},
        {"absorber",
         {Dielectric(0.2f, 1.5f, kBeckmann), Absorber(Lanes(0.2f, 0.5f, 1, 2)), Metal(0.3f, kBeckmann)}},
        {"ggx", {Dielectric(0.3f, 1.5f), Metal(0.3f)}},
        {"pane_mirrored", {Dielectric(0.3f, 1.5f, kBeckmann), Dielectric(0.3f, 1 / 1.5f, kBeckmann)}},
        {"two_coats",
         {Dielectric(0.2f, 1.3f, kBeckmann), Dielectric(0.1f, 1.2f, kBeckmann), Metal(0.2f, kBeckmann)},
         5},
    };
}

/// One strategy, unweighted: the one whose walk from the light has so many directions more.
template <int kDifference>
struct Only : PairPolicy {
    static constexpr int kOnlyDifference = kDifference;
};
template <int kDifference>
struct OnlyOfAll : AllPairStrategies {
    static constexpr int kOnlyDifference = kDifference;
};
struct ForgetsOthers : PairPolicy {
    static constexpr bool kCountsOthers = false;
};
struct ForgetsOthersOfAll : AllPairStrategies {
    static constexpr bool kCountsOthers = false;
};
struct ForgetsJacobian : PairPolicy {
    static constexpr bool kCountsJacobian = false;
};
/// Draws as if there were no own draws.
struct ManyOwnSamples : PairPolicy {
    static constexpr float kOwnSamples = 0.6f, kOwnPerAlpha2 = 2;
};

// Each strategy alone, without weights, has the right mean: so the densities p_m are those of what is drawn,
// and f over their sum weights each sample by p_m over the sum, a partition of unity.
TEST(PairWalk, EachStrategyAloneIsUnbiased) {
    const std::vector<Row> even = PairRows();
    std::vector<Row> odd;
    for (const Row& row : AllRows())
        if (row.name == "four") odd.push_back(row);
    std::vector<Row> longer = PairRows();
    for (Row& row : longer) row.maxVertices = 9;
    struct Part {
        const char* name;
        Estimate estimate;
        const std::vector<Row>& rows;
    };
    const Part parts[] = {{"light 1", PairsWith<Only<1>>(), even},
                          {"camera 1", PairsWith<Only<-1>>(), even},
                          {"both", PairsWith<PairPolicy>(), even},
                          {"own draws", PairsWith<ManyOwnSamples>(), even},
                          {"light 2", PairsWith<Only<2>>(), odd},
                          {"camera 2", PairsWith<Only<-2>>(), odd},
                          {"middle", PairsWith<Only<0>>(), odd},
                          {"all three", PairsWith<PairPolicy>(), odd},
                          {"light", PairsWith<OnlyOfAll<99>>(), longer},
                          {"camera", PairsWith<OnlyOfAll<-99>>(), longer},
                          {"paper's", PairsWith<AllPairStrategies>(), longer}};
    for (const Part& part : parts) {
        const Verdict v = Compare(part.estimate, part.rows, Scaled(kValues), FullTestName() + part.name);
        EXPECT_TRUE(IsRight(v, 1e-4)) << part.name << ": " << v.worst << "; " << v.worstZ << " sigma of "
                                      << v.numTests << ", together " << v.sumZ;
    }
}

TEST(PairWalkLong, ControlsAreSeen) {
    const Estimate scaled = [](const Stack& stack, const Query& q, const BxDFContext& context, int n) {
        return PairsWith<PairPolicy>()(stack, q, context, n) * 1.02f;
    };
    for (const auto& [name, estimate] :
         {std::pair("other", PairsWith<ForgetsOthers>()),
          std::pair("other of all", PairsWith<ForgetsOthersOfAll>()),
          std::pair("jacobian", PairsWith<ForgetsJacobian>()), std::pair("two per cent", scaled)}) {
        const Verdict v = Compare(estimate, PairRows(), kValues / 2, FullTestName() + name);
        EXPECT_FALSE(IsRight(v, 5e-4)) << name << ": " << v.worstZ << ", together " << v.sumZ;
    }
}

// ---- Noise --------------------------------------------------------------------------------------------

/// Root of the mean variance over directions in and near the lobe, of paths of at most three vertices.
double NoiseOf(const std::string& name, const Row& row) {
    Arena arena;
    const Stack stack = StackCase{.name = row.name, .layers = row.layers}.Build(arena);
    double variance = 0;
    for (const Query& q : QueriesOf(row, stack))
        variance +=
            MeanOf(ByName(name), stack, q, 3, Scaled(4000), SeedOf(FullTestName() + name)).Variance() *
            Sqr(double(q.wi.z));
    return std::sqrt(variance);
}

// What the products are for: an error in a lobe, a product or a derivative is not biased, only noisy.
// Measured are 4 and 8; the standard error of each quotient is below 10 %.
TEST(ProductNoise, IsBelowThatOfBidirectional) {
    const Row coat{"coat", {Dielectric(0.1f, 1.5f, kBeckmann), Metal(0.1f, kBeckmann)}};
    const double reference = NoiseOf("bidirectional", coat);
    EXPECT_GT(reference / NoiseOf("pairproduct", coat), 2.5);
    EXPECT_GT(reference / NoiseOf("multiproduct", coat), 5);
    const Row pane{
        "pane", {Dielectric(0.1f, 1.5f, kBeckmann), Dielectric(0.1f, 1 / 1.5f, kBeckmann)}, 2, true};
    EXPECT_GT(NoiseOf("bidirectional", pane) / NoiseOf("pairproduct", pane), 8);
}

}  // namespace
}  // namespace lacquer::layered::test::product_estimators_test
