// Materials of scene files, evaluated at pairs of directions.
#include "measure/scene_material.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <filesystem>
#include <fstream>

#include "measure/bsdf_survey.h"
#include "measure/measure_fixtures.h"

namespace lacquer::measure::scene_material_test {
namespace {

using test::DirectionAt;
using test::FromText;

constexpr const char* kStack = R"(
    MakeNamedMaterial "top" "string type" "dielectric" "float roughness" .3 "bool remaproughness" false
    MakeNamedMaterial "varnish" "string type" "slab" "rgb sigma_t" [1 1 1] "rgb albedo" [.5 .7 .95]
    MakeNamedMaterial "metal" "string type" "conductor" "float roughness" .3 "bool remaproughness" false
    MakeNamedMaterial "m" "string type" "layered" "string stack" ["top" "varnish" "metal"])";

ColorMean At(const SceneMaterial& material, Vec3 wo, Vec3 wi, int64_t numBatches, double scale = 1) {
    Rng rng(Hash(7, numBatches));
    return material.bsdf->Evaluate(wo, wi, TransportMode::Radiance, numBatches, rng, scale);
}

TEST(LoadMaterial, ReadsAFile) {
    const auto path = std::filesystem::temp_directory_path() / "lacquer-load-material.pbrt";
    std::ofstream(path) << "WorldBegin MakeNamedMaterial \"red\" \"string type\" \"diffuse\" \"rgb "
                           "reflectance\" [.9 .1 .1]";
    const SceneMaterial red = LoadMaterial(path.string(), "red");
    std::filesystem::remove(path);
    EXPECT_EQ(red.setup.entity.type, "diffuse");
    const glm::dvec3 f = At(red, DirectionAt(10, 0), DirectionAt(50, 90), 1).Mean();
    // R/pi, as far as 64 wavelengths integrate the smooth spectrum of an RGB colour (about 1e-3).
    EXPECT_NEAR(f.x * double(Pi), 0.9, 3e-3);
    EXPECT_NEAR(f.y * double(Pi), 0.1, 3e-3);
    EXPECT_THROW(LoadMaterial(path.string(), "red"), FileError);
}

TEST(BsdfSubject, EvaluateTakesNoFactorOfItsOwn) {
    const SceneMaterial gray =
        FromText(R"(MakeNamedMaterial "m" "string type" "diffuse" "rgb reflectance" [.5 .5 .5])", "m");
    for (const int64_t batches : {1, 2, 17}) {
        const ColorMean f = At(gray, DirectionAt(30, 0), DirectionAt(70, 10), batches, 2);
        EXPECT_EQ(f.Count(), batches);
        EXPECT_NEAR(f.Luminance(), 2 * 0.5 / double(Pi), 2e-4);
        EXPECT_NEAR(f.LuminanceError(), 0, 1e-8);  // exact models have no noise
    }
    EXPECT_EQ(At(gray, DirectionAt(30, 0), DirectionAt(110, 10), 1).Luminance(), 0);  // the other side
}

TEST(BsdfSubject, EvaluateSaysHowNoisyItIs) {
    const SceneMaterial stack = FromText(kStack, "m");
    ASSERT_TRUE(IsLayered(*stack.bsdf));
    const Vec3 wo = DirectionAt(30, 0), wi = DirectionAt(40, 170);
    const ColorMean few = At(stack, wo, wi, 2000), many = At(stack, wo, wi, 8000);
    EXPECT_NEAR(few.Luminance(), many.Luminance(),
                5 * std::hypot(few.LuminanceError(), many.LuminanceError()));
    // Four times the samples: half the error, which is itself known to some 10 % from 2000 values of heavy
    // tails. An error that did not fall (a factor of 1) or fell as the count (a factor of 4) would show.
    EXPECT_NEAR(few.LuminanceError() / many.LuminanceError(), 2, 0.6);
    EXPECT_LT(many.LuminanceError(), 0.05 * many.Luminance());
}

TEST(SurveyBsdf, FillsWhatWasAskedForAndTellsItsProgress) {
    class Counter final : public Observer {
      public:
        void Begin(const std::string& name, int64_t total, const std::string&) override {
            names.push_back(name);
            totals.push_back(total);
            done.emplace_back(0);
        }
        void Advance(int64_t units) override { done.back() += units; }
        std::vector<std::string> names;
        std::vector<int64_t> totals;
        std::deque<std::atomic<int64_t>> done;
    };
    const SceneMaterial stack = FromText(kStack, "m");
    Counter counter;
    const BsdfSurveyOptions options{.thetaDeg = 30, .phiDeg = 20, .resolution = 16, .samples = 1, .seed = 3};
    const BsdfResult r = SurveyBsdf(options, {{"a", stack.bsdf.get()}, {"b", stack.bsdf.get()}}, &counter);
    EXPECT_EQ(counter.names, (std::vector<std::string>{"samples", "a", "b"}));
    for (size_t i = 0; i < counter.totals.size(); ++i)
        EXPECT_EQ(counter.done[i], counter.totals[i]) << counter.names[i];
    ASSERT_EQ(r.estimators.size(), 2u);
    EXPECT_EQ(r.interfaces.size(), 2u);
    EXPECT_FALSE(r.transmits);
    EXPECT_TRUE(r.isStochastic);
    // One material twice, by different numbers: close, and not the same bits.
    const ColorMean &a = r.estimators[0].energy.reflected, &b = r.estimators[1].energy.reflected;
    EXPECT_NE(a.Luminance(), b.Luminance());
    EXPECT_NEAR(a.Luminance(), b.Luminance(), 6 * std::hypot(a.LuminanceError(), b.LuminanceError()));
    // Nobody has to listen, and then everything is the same.
    const BsdfResult again = SurveyBsdf(options, {{"a", stack.bsdf.get()}}, nullptr);
    EXPECT_EQ(again.estimators[0].energy.reflected.Luminance(), a.Luminance());
}

}  // namespace
}  // namespace lacquer::measure::scene_material_test
