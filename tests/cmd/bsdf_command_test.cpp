// `lacquer bsdf` from arguments to files.
#include "cmd/bsdf/bsdf_command.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "cmd/scene_folder.h"
#include "pbrt/image/image.h"

namespace lacquer::cmd::bsdf_command_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBsdfScene = R"(
WorldBegin
MakeNamedMaterial "coat" "string type" "dielectric" "float roughness" .3 "bool remaproughness" false
MakeNamedMaterial "varnish" "string type" "slab" "rgb sigma_t" [1 1 1] "rgb albedo" [.5 .7 .95]
MakeNamedMaterial "metal" "string type" "conductor" "float roughness" .3 "bool remaproughness" false
MakeNamedMaterial "lacquered" "string type" "layered" "string stack" ["coat" "varnish" "metal"]
)";

class BsdfCommand : public SceneFolder {
  protected:
    BsdfCommand() : SceneFolder(kBsdfScene) {}

    BsdfArguments Arguments(const std::string& material) const {
        BsdfArguments a;
        a.scenes = {ScenePath()};
        a.material = material;
        a.wi = "40,30";
        a.out = (folder_ / "out").string();
        a.resolution = 16;
        a.samples = 1;
        a.quiet = true;
        return a;
    }
    nlohmann::json Table() const {
        std::ifstream in(folder_ / "out" / "table.json");
        return nlohmann::json::parse(in);
    }
    std::vector<std::string> Files() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder_ / "out"))
            names.push_back(entry.path().filename().string());
        std::sort(names.begin(), names.end());
        return names;
    }
};

TEST_F(BsdfCommand, WritesImagesAndTablesOfAPlainMaterial) {
    ASSERT_EQ(RunBsdf(Arguments("metal")), ExitStatus::Complete);
    EXPECT_EQ(Files(), (std::vector<std::string>{"density-reflection.exr", "exact-reflection.exr",
                                                 "exact.png", "pdf-reflection.exr", "samples-reflection.exr",
                                                 "sheet.png", "table.json", "table.txt"}));
    const nlohmann::json table = Table();
    EXPECT_EQ(table["estimators"].size(), 1u);
    EXPECT_EQ(table["angles_degrees"].size(), 18u);
    EXPECT_FALSE(table["stochastic"]);
    EXPECT_LT(double(table["estimators"][0]["reciprocity"]["max_relative_error"]), 1e-3);
}

TEST_F(BsdfCommand, RemovesWhatAnEarlierSurveyLeft) {
    BsdfArguments a = Arguments("lacquered");
    a.estimators = {"forward", "bidirectional"};
    ASSERT_EQ(RunBsdf(a), ExitStatus::Complete);
    EXPECT_TRUE(fs::exists(folder_ / "out" / "forward.png"));
    std::ofstream(folder_ / "out" / "mine.png") << "kept";
    std::ofstream(folder_ / "other.png") << "kept";
    // A list that was tampered with leads nowhere else.
    nlohmann::json table = Table();
    for (const char* name : {"../other.png", "table.txt", "..", ""}) table["files"].push_back(name);
    std::ofstream(folder_ / "out" / "table.json") << table;
    a.estimators = {"bidirectional"};
    ASSERT_EQ(RunBsdf(a), ExitStatus::Complete);
    for (const char* name : {"forward.png", "forward-reflection.exr"})
        EXPECT_FALSE(fs::exists(folder_ / "out" / name)) << name;
    for (const char* name : {"bidirectional.png", "mine.png", "table.txt", "../other.png"})
        EXPECT_TRUE(fs::exists(folder_ / "out" / name)) << name;
}

TEST_F(BsdfCommand, ShowsBothSidesOfWhatTransmits) {
    ASSERT_EQ(RunBsdf(Arguments("coat")), ExitStatus::Complete);
    EXPECT_EQ(Files().size(), 12u);
    const Image image = ReadImage((folder_ / "out" / "exact-transmission.exr").string(), {}, {});
    EXPECT_EQ(image.Resolution(), Int2(16));
    EXPECT_EQ(image.Channels(), (std::vector<std::string>{"R", "G", "B", "Noise.Y"}));
    EXPECT_FALSE(image.HasNonFinite());
    EXPECT_EQ(image.Get({0, 0}, 0), 0);
}

TEST_F(BsdfCommand, EstimatorsOfAStackAgreeWithItsSamples) {
    BsdfArguments a = Arguments("lacquered");
    a.estimators = {"unidirectional", "bidirectional"};
    a.samples = 8;
    ASSERT_EQ(RunBsdf(a), ExitStatus::Complete);
    const nlohmann::json table = Table();
    ASSERT_EQ(table["estimators"].size(), 2u);
    EXPECT_TRUE(table["stochastic"]);
    EXPECT_EQ(table["interface_losses"].size(), 2u);
    const auto& samples = table["samples"]["reflected_without_specular"];
    for (const auto& e : table["estimators"]) {
        const auto& energy = e["energy"]["reflected"];
        const double sigma = std::hypot(double(samples["luminance_standard_error"]),
                                        double(energy["luminance_standard_error"]));
        // At 2 % each an error of a tenth is seen; the false alarm rate is that of 5 standard errors.
        EXPECT_LT(sigma, 0.02 * double(samples["luminance"]));
        EXPECT_NEAR(double(samples["luminance"]), double(energy["luminance"]), 5 * sigma) << e["name"];
    }
}

TEST_F(BsdfCommand, DefaultIsEachEstimatorOnce) {
    ASSERT_EQ(RunBsdf(Arguments("lacquered")), ExitStatus::Complete);
    std::set<std::string> names;
    const nlohmann::json table = Table();
    for (const auto& e : table["estimators"]) EXPECT_TRUE(names.insert(e["name"]).second);
    EXPECT_TRUE(names.contains("bidirectional"));
    EXPECT_TRUE(names.contains("auto"));
}

TEST_F(BsdfCommand, RefusesWhatMakesNoSense) {
    const auto refused = [&](const std::function<void(BsdfArguments&)>& change) {
        BsdfArguments a = Arguments("metal");
        change(a);
        try {
            RunBsdf(a);
        } catch (const CLI::ValidationError& e) {
            return std::string(e.what());
        }
        return std::string("nothing");
    };
    EXPECT_EQ(refused([](auto& a) { a.wi = "40"; }),
              "--wi \"40\": expected THETA,PHI in degrees, THETA between 0 and 180");
    EXPECT_NE(refused([](auto& a) { a.wi = "90,0"; }), "nothing");
    EXPECT_NE(refused([](auto& a) { a.wi = "nan,0"; }), "nothing");
    EXPECT_NE(refused([](auto& a) { a.wi = "40,30,20"; }), "nothing");
    EXPECT_NE(refused([](auto& a) { a.uv = "x"; }), "nothing");
    EXPECT_NE(refused([](auto& a) { a.layeredPdf = "exact"; }), "nothing");
    EXPECT_NE(refused([](auto& a) { a.estimators = {"fast"}; }), "nothing");
    EXPECT_EQ(refused([](auto& a) { a.estimators = {"forward"}; }),
              "--estimator is for layered materials; \"metal\" is a conductor, whose value is exact");
    EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(BsdfCommand, UnknownMaterialIsAnErrorOfTheScene) {
    EXPECT_THROW(RunBsdf(Arguments("metall")), SceneError);
    EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(BsdfCommand, AFolderThatCannotBeMadeIsAnErrorOfTheFile) {
    BsdfArguments a = Arguments("metal");
    a.out = (folder_ / "missing" / "out").string();
    EXPECT_THROW(RunBsdf(a), FileError);
    a.out = (folder_ / "scene.pbrt").string();
    EXPECT_THROW(RunBsdf(a), FileError);
}

TEST_F(BsdfCommand, TheSameSeedGivesTheSameNumbers) {
    const auto numbers = [&](int seed) {
        BsdfArguments a = Arguments("metal");
        a.seed = seed;
        RunBsdf(a);
        nlohmann::json table = Table();
        for (auto& e : table["estimators"]) e.erase("cost");
        table.erase("seed");
        return table;
    };
    const nlohmann::json first = numbers(1);
    EXPECT_EQ(first, numbers(1));
    EXPECT_NE(first, numbers(2));
}

}  // namespace
}  // namespace lacquer::cmd::bsdf_command_test
