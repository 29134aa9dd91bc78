#include <algorithm>

#include "light_fixtures.h"
#include "pbrt/core/parallel.h"
#include "pbrt/lights/light_bounds.h"
#include "support/statistics.h"

namespace lacquer::test::light_sampler_test {
namespace {

/// Lights of every kind at random places, and the shapes that some of them need.
struct RandomScene {
    std::vector<std::unique_ptr<Shape>> shapes;
    std::vector<std::unique_ptr<Light>> lights;
    std::vector<const Light*> pointers;

    void Add(std::unique_ptr<Light> light) { lights.push_back(std::move(light)); }
    void Add(std::unique_ptr<Shape> shape, std::vector<Parameter> parameters) {
        for (auto& light : MakeAreaLights(*shape, std::move(parameters))) lights.push_back(std::move(light));
        shapes.push_back(std::move(shape));
    }
    void Finish() {
        for (const auto& light : lights) light->Preprocess(Bounds3(Point3(-10), Point3(10)));
        for (const auto& light : lights) pointers.push_back(light.get());
    }
};

Vec3 RandomVector(Rng* rng, float size) {
    return size * (2.f * Vec3(rng->Uniform(), rng->Uniform(), rng->Uniform()) - Vec3(1));
}
std::vector<float> Numbers(Vec3 v) { return {v.x, v.y, v.z}; }

RandomScene MakeScene(uint64_t seed, int numLights, bool withDistant) {
    Rng rng(seed);
    RandomScene scene;
    for (int i = 0; i < numLights; ++i) {
        const Vec3 from = RandomVector(&rng, 5), to = RandomVector(&rng, 5);
        const float scale = std::exp(4 * rng.Uniform());
        const Parameter s = FloatParam("scale", {scale});
        const Parameter f = FloatParam("from", Numbers(from), "point3"),
                        t = FloatParam("to", Numbers(to), "point3");
        switch (rng.UniformInt(5)) {
            case 0:
                scene.Add(MakeLight("point", {f, s}));
                break;
            case 1:
                scene.Add(MakeLight("spot", {f, t, s, FloatParam("coneangle", {5 + 170 * rng.Uniform()}),
                                             FloatParam("conedeltaangle", {90 * rng.Uniform()})}));
                break;
            case 2:
                scene.Add(std::make_unique<Ball>(from, 0.1f + rng.Uniform()), {s});
                break;
            default: {
                // Two of them: anywhere, or in one plane and nearly one box.
                const Vec3 edgeX = RandomVector(&rng, 0.7f), edgeY = RandomVector(&rng, 0.7f);
                const Vec3 second = rng.Uniform() < 0.5f ? 0.02f * edgeX : RandomVector(&rng, 1);
                scene.Add(std::make_unique<Parallelogram>(from, edgeX, edgeY, std::vector{Vec3(0), second}),
                          {s, BoolParam("twosided", rng.Uniform() < 0.3f)});
            }
        }
    }
    if (withDistant) {
        scene.Add(MakeLight("distant", {}));
        scene.Add(MakeLight("infinite",
                            {FloatParam("portal", {-1, 0, -2, -1, 1, -2, 1, 1, -2, 1, 0, -2}, "point3")}));
        scene.Add(MakeLight("infinite", {}));
    }
    scene.Finish();
    return scene;
}

LightReference RandomReference(Rng* rng) {
    LightReference ref(RandomVector(rng, 7));
    if (rng->Uniform() < 0.7f) ref.n = ref.ns = Normalize(RandomVector(rng, 1));
    return ref;
}

std::unique_ptr<LightSampler> MakeSampler(const std::string& name, const RandomScene& scene) {
    return Registry<LightSamplerKind>::Find(name)(scene.pointers);
}

class LightSamplers : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, LightSamplers, testing::Values("uniform", "power", "bvh", "exhaustive"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(LightSamplers, ProbabilitiesSumUpToOne) {
    for (const bool withDistant : {false, true}) {
        for (const int numLights : {2, 3, 4, 60}) {
            const RandomScene scene = MakeScene(SeedOf(FullTestName()), numLights, withDistant);
            const auto sampler = MakeSampler(GetParam(), scene);
            Rng rng(SeedOf(FullTestName()));
            for (int i = 0; i < 50; ++i) {
                const LightReference ref = RandomReference(&rng);
                double sum = 0;
                for (const Light* light : scene.pointers) sum += double(sampler->Pmf(ref, light));
                EXPECT_LE(sum, 1 + 1e-5);  // some hundred roundings
                // The tree has dead ends: a cluster may promise light that none of its parts can send this
                // way. FrequenciesFollowProbabilities checks that draws fail just as often.
                const bool hasDeadEnds = GetParam() == std::string("bvh");
                EXPECT_GE(sum, hasDeadEnds ? 0 : 1 - 1e-5);
            }
        }
    }
}

/// Chi-square of drawn lights against their probabilities, the last cell being draws without a light; every
/// other light is expected more often by `tilt`, the others less.
Outcome FrequenciesAgainstPmf(const char* name, uint64_t seed, int numLights, double tilt) {
    constexpr int kSamples = 100000;
    const RandomScene scene = MakeScene(seed, numLights, true);
    const auto sampler = MakeSampler(name, scene);
    Rng rng(seed);
    const LightReference ref = RandomReference(&rng);
    std::vector<double> observed(scene.pointers.size() + 1), expected(scene.pointers.size() + 1);
    double sum = 0;
    for (size_t i = 0; i < scene.pointers.size(); ++i) {
        const double pmf = double(sampler->Pmf(ref, scene.pointers[i]));
        expected[i] = kSamples * pmf * (i % 2 ? 1 + tilt : 1 - tilt);
        sum += pmf;
    }
    expected.back() = kSamples * std::max(0., 1 - sum);
    for (int i = 0; i < kSamples; ++i) {
        const auto s = sampler->Sample(ref, rng.Uniform());
        if (s && std::abs(s->p - sampler->Pmf(ref, s->light)) > 1e-5f * s->p)
            return {0, "another probability"};
        const auto at =
            s ? std::find(scene.pointers.begin(), scene.pointers.end(), s->light) : scene.pointers.end();
        ++observed[size_t(at - scene.pointers.begin())];
    }
    return ChiSquareTest(observed, expected);
}

TEST_P(LightSamplers, FrequenciesFollowProbabilities) {
    // Few are weighed in another way than many.
    for (const int numLights : {2, 4, 40}) {
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(numLights), 1e-4, [&](uint64_t seed) {
            return FrequenciesAgainstPmf(GetParam(), seed, numLights, 0);
        }));
        // Power: a relative error of 4 % adds 100000 * 0.04^2 = 160 to a chi-square of 60 +- 11, or fewer.
        EXPECT_LT(FrequenciesAgainstPmf(GetParam(), SeedOf(FullTestName()), numLights, 0.04).pValue, 1e-4);
    }
}

TEST_P(LightSamplers, EveryLightThatContributesCanBeDrawn) {
    Rng rng(SeedOf(FullTestName()));
    const SampledWavelengths lambda = Wavelengths();
    for (int trial = 0; trial < 20; ++trial) {
        const int numLights = trial % 4 < 2 ? 30 : 3;
        const RandomScene scene = MakeScene(Hash(SeedOf(FullTestName()), trial), numLights, trial % 2 == 0);
        const auto sampler = MakeSampler(GetParam(), scene);
        for (int r = 0; r < 30; ++r) {
            const LightReference ref = RandomReference(&rng);
            for (const Light* light : scene.pointers) {
                if (light->IsUniformInfinite() || sampler->Pmf(ref, light) > 0) continue;
                for (int i = 0; i < 30; ++i) {
                    const auto s = light->SampleLi(ref, rng.Uniform2D(), lambda);
                    EXPECT_FALSE(s && s->L) << "a light that shines has no probability";
                }
            }
        }
    }
}

TEST_P(LightSamplers, LeaveOutUniformInfiniteLights) {
    const RandomScene scene = MakeScene(1, 3, true);
    const auto sampler = MakeSampler(GetParam(), scene);
    EXPECT_EQ(sampler->Pmf(LightReference(Point3(0)), scene.pointers.back()), 0.f);
}

TEST_P(LightSamplers, NoLightsNoSample) {
    const RandomScene scene;
    EXPECT_FALSE(MakeSampler(GetParam(), scene)->Sample(LightReference(Point3(0)), 0.5f));
    RandomScene uniform;
    uniform.Add(MakeLight("infinite", {}));
    uniform.Finish();
    EXPECT_FALSE(MakeSampler(GetParam(), uniform)->Sample(LightReference(Point3(0)), 0.5f));
}

TEST_P(LightSamplers, OneLightIsAlwaysDrawn) {
    for (const char* type : {"point", "distant"}) {
        RandomScene scene;
        scene.Add(MakeLight(type, {}));
        scene.Finish();
        const auto sampler = MakeSampler(GetParam(), scene);
        const LightReference ref(Point3(1, 2, 3));
        for (const float u : {0.f, 0.5f, OneMinusEpsilon}) {
            const auto s = sampler->Sample(ref, u);
            ASSERT_TRUE(s);
            EXPECT_EQ(s->p, 1.f);
        }
        EXPECT_EQ(sampler->Pmf(ref, scene.pointers[0]), 1.f);
        EXPECT_EQ(sampler->Pmf(ref, nullptr), 0.f);
    }
}

TEST_P(LightSamplers, CoincidentAndCollinearLightsAreHandled) {
    RandomScene scene;
    for (int i = 0; i < 1000; ++i) {
        const float x = i < 500 ? 0.f : std::pow(1.1f, float(i - 500));  // up to 5e20
        scene.Add(MakeLight("point", {FloatParam("from", {x, 0, 0}, "point3")}));
    }
    scene.Finish();
    const auto sampler = MakeSampler(GetParam(), scene);
    // At the lights themselves, too, where distances are zero.
    for (const Point3 p : {Point3(0), Point3(1, 0, 0), Point3(0, 3, 0), Point3(1e20f, 0, 0)}) {
        const LightReference ref(p);
        double sum = 0;
        for (const Light* light : scene.pointers) sum += double(sampler->Pmf(ref, light));
        EXPECT_NEAR(sum, 1, 1e-4);  // light in all directions: no dead ends
        for (const float u : {0.f, 0.3f, OneMinusEpsilon}) EXPECT_TRUE(sampler->Sample(ref, u));
    }
}

/// Shares of the second of two lights from many places in front of the first, smallest and largest.
std::pair<float, float> SharesOfSecond(const RandomScene& scene) {
    const auto sampler = MakeSampler("bvh", scene);
    Rng rng(SeedOf(FullTestName()));
    std::pair<float, float> range(1, 0);
    for (int i = 0; i < 1000; ++i) {
        const LightReference ref(Point3(RandomVector(&rng, 2)) + Vec3(0, 0, 2.01f));
        const float pmf = sampler->Pmf(ref, scene.pointers[1]);
        range = {std::min(range.first, pmf), std::max(range.second, pmf)};
    }
    return range;
}
/// A unit square, and a parallelogram somewhere.
RandomScene SquareAnd(Point3 corner, Vec3 edgeX, Vec3 edgeY) {
    RandomScene scene;
    scene.Add(std::make_unique<Parallelogram>(Point3(0), Vec3(1, 0, 0), Vec3(0, 1, 0)), {});
    scene.Add(std::make_unique<Parallelogram>(corner, edgeX, edgeY), {});
    scene.Finish();
    return scene;
}

/// The largest difference between shares by the tree and those by each light's own importance with a part of
/// all draws given evenly, for lights without extent at random places.
/// @param even  that part over the others
float LargestDifferenceToExhaustive(int numLights, float even) {
    Rng rng(SeedOf(FullTestName()) + uint64_t(numLights));
    RandomScene scene;
    for (int i = 0; i < numLights; ++i)
        scene.Add(MakeLight("point", {FloatParam("from", Numbers(RandomVector(&rng, 5)), "point3"),
                                      FloatParam("scale", {std::exp(4 * rng.Uniform())})}));
    scene.Finish();
    const auto tree = MakeSampler("bvh", scene), all = MakeSampler("exhaustive", scene);
    float largest = 0;
    for (int i = 0; i < 200; ++i) {
        const LightReference ref = RandomReference(&rng);
        const auto numShining = float(std::ranges::count_if(
            scene.pointers, [&](const Light* light) { return all->Pmf(ref, light) > 0; }));
        for (const Light* light : scene.pointers) {
            const float own = all->Pmf(ref, light),
                        expected = own > 0 ? (own + even / numShining) / (1 + even) : 0;
            largest = std::max(largest, std::abs(tree->Pmf(ref, light) - expected));
        }
    }
    return largest;
}

TEST(BvhLightSampler, AFewLightsHaveTheSharesOfTheirImportancesAndEvenOnes) {
    for (const int few : {2, 3, 5, 8}) {
        EXPECT_LT(LargestDifferenceToExhaustive(few, 0.3f), 1e-3f) << few;
        EXPECT_GT(LargestDifferenceToExhaustive(few, 0.f), 0.02f) << few;
    }
    EXPECT_GT(LargestDifferenceToExhaustive(9, 0.3f), 0.02f) << "by the tree, which sees clusters";
}

TEST(LightClusterLanes, HaveTheImportancesOfTheirClusters) {
    Rng rng(SeedOf(FullTestName()));
    int zeros = 0, inside = 0;
    for (int i = 0; i < 30000; ++i) {
        std::array<LightCluster, LightClusterLanes::kLanes> clusters;
        LightClusterLanes lanes;
        const int count = 1 + int(rng.UniformInt(LightClusterLanes::kLanes));
        for (int k = 0; k < count; ++k) {
            LightBounds b;
            const Point3 corner(RandomVector(&rng, 3));
            const float size = rng.Uniform() < 0.3f ? 0.f : 3 * rng.Uniform();
            b.bounds = Bounds3(corner).Union(Bounds3(corner + Vec3(size, size * rng.Uniform(), 0)));
            b.axis = Normalize(RandomVector(&rng, 1));
            b.cosTheta_o = rng.Uniform() < 0.3f ? (rng.Uniform() < 0.5f ? 1.f : -1.f) : 2 * rng.Uniform() - 1;
            b.cosTheta_e = rng.Uniform();
            b.power = std::exp(40 * (rng.Uniform() - 0.5f));
            b.twoSided = rng.Uniform() < 0.3f;
            lanes.Set(k, clusters[size_t(k)] = LightCluster(b, 1));
        }
        const LightReference ref = RandomReference(&rng);
        const LaneFloats found = Importance(lanes, ref);
        for (int k = 0; k < LightClusterLanes::kLanes; ++k) {
            const float wanted = k < count ? Importance(clusters[size_t(k)], ref) : 0.f;
            zeros += k < count && wanted == 0;
            inside += k < count &&
                      DistanceSquared(clusters[size_t(k)].center, ref.p) < clusters[size_t(k)].radiusSquared;
            // Sines of small angles keep fewer digits.
            EXPECT_NEAR(found[k], wanted, 2e-3f * wanted) << i << ", lane " << k;
        }
    }
    EXPECT_GT(zeros, 100);
    EXPECT_GT(inside, 100);
}

TEST(BvhLightSampler, FlatEmittersOfOneBoxHaveTheSharesOfTheirPowers) {
    const auto same = SharesOfSecond(SquareAnd({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    EXPECT_EQ(same, std::pair(0.5f, 0.5f));
    const auto nearly = SharesOfSecond(SquareAnd({0.03f, 0, 0}, {1, 0, 0}, {0, 0.96f, 0}));
    EXPECT_NEAR(nearly.first, 0.96f / 1.96f, 1e-6f);
    EXPECT_EQ(nearly.first, nearly.second);
}

TEST(BvhLightSampler, OthersHaveSharesByPlace) {
    const auto vary = [](const RandomScene& scene) {
        const auto [low, high] = SharesOfSecond(scene);
        return high > low + 0.01f;
    };
    EXPECT_TRUE(vary(SquareAnd({0.2f, 0, 0}, {1, 0, 0}, {0, 1, 0}))) << "beside it";
    EXPECT_TRUE(vary(SquareAnd({0.4f, 0.4f, 0}, {0.2f, 0, 0}, {0, 0.2f, 0}))) << "within it";
    EXPECT_TRUE(vary(SquareAnd({0, 0, 0.04f}, {1, 0, 0}, {0, 1, 0}))) << "before it";
    EXPECT_TRUE(vary(SquareAnd({0, 0, 0}, {1, 0, 0.04f}, {0, 1, 0}))) << "inclined";
    EXPECT_TRUE(vary(SquareAnd({0, 0, 0}, {0, 1, 0}, {1, 0, 0}))) << "facing away";
}

/// Variance, over choices of light and points on it, of unshadowed irradiance; the mean goes to `mean`.
double VarianceOfIrradiance(const char* name, const RandomScene& scene, double* mean) {
    const auto sampler = MakeSampler(name, scene);
    LightReference ref(Point3(0, 0, 0));
    ref.n = ref.ns = Vec3(0, 0, 1);
    Rng rng(SeedOf(FullTestName()));
    RunningMean sum;
    for (int i = 0; i < 50000; ++i) {
        const auto chosen = sampler->Sample(ref, rng.Uniform());
        const auto s = chosen ? chosen->light->SampleLi(ref, rng.Uniform2D(), Wavelengths()) : std::nullopt;
        sum.Add(s ? double(s->L[0] * AbsDot(s->wi, ref.n) / (s->pdf * chosen->p)) : 0.);
    }
    *mean = sum.Mean();
    return sum.Variance();
}

/// So many that halves of the tree are built by several threads.
TEST(BvhLightSampler, ItsTreeIsTheSameWhateverTheThreads) {
    const RandomScene scene = MakeScene(SeedOf(FullTestName()), 3000, true);
    std::vector<std::unique_ptr<LightSampler>> samplers;
    for (const int threads : {1, 2, 7}) {
        const ThreadLimit limit(threads);
        samplers.push_back(MakeSampler("bvh", scene));
    }
    Rng rng(1);
    for (int i = 0; i < 20; ++i) {
        const LightReference ref = RandomReference(&rng);
        double sum = 0;
        for (const Light* light : scene.pointers) {
            const float pmf = samplers[0]->Pmf(ref, light);
            sum += double(pmf);
            ASSERT_EQ(samplers[1]->Pmf(ref, light), pmf);
            ASSERT_EQ(samplers[2]->Pmf(ref, light), pmf);
        }
        EXPECT_LE(sum, 1 + 1e-4);
        EXPECT_GE(sum, 0.9) << "of dead ends there are few";
    }
}

TEST(BvhLightSampler, IsFarLessNoisyThanUniformAmongManyLights) {
    const RandomScene scene = MakeScene(SeedOf(FullTestName()), 500, false);
    double uniformMean, bvhMean;
    const double uniform = VarianceOfIrradiance("uniform", scene, &uniformMean);
    const double bvh = VarianceOfIrradiance("bvh", scene, &bvhMean);
    EXPECT_LT(bvh, uniform / 4);
    EXPECT_NEAR(bvhMean, uniformMean, 5 * std::sqrt((uniform + bvh) / 50000));
}

}  // namespace
}  // namespace lacquer::test::light_sampler_test
