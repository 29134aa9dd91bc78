// A layered material that only this test knows shows up in `lacquer info`, and `lacquer compare` varies it.
// The control is the same material, registered without saying that it is layered.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cmd/compare/compare_command.h"
#include "cmd/scene_folder.h"
#include "cmd/scenes/scene_info.h"
#include "pbrt/base/material.h"
#include "support/scoped_registration.h"

namespace lacquer::cmd::new_material_test {
namespace {

namespace fs = std::filesystem;
using Registered = test::ScopedRegistration<MaterialKind>;

constexpr const char* kNewMaterialScene = R"(
Film "rgb" "integer xresolution" 4 "integer yresolution" 4 "string filename" "new.exr"
Sampler "independent" "integer pixelsamples" 2
LookAt 0 0 3  0 0 0  0 1 0
Camera "perspective" "float fov" 30
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
MakeNamedMaterial "wax" "string type" "waxed" "string profile" "wax.txt" "float roughness" .2
NamedMaterial "wax"
Shape "sphere"
)";

/// A coat over a diffuse base that reads a file as well.
std::unique_ptr<Material> CreateWaxed(const MaterialArgs& args) {
    const std::string path = args.params.PathOf("profile");
    if (!fs::exists(path)) args.params.Fail("profile", path + " is not there");
    return Registry<MaterialKind>::Find("coateddiffuse")(args);
}

class NewMaterial : public SceneFolder {
  protected:
    NewMaterial() : SceneFolder(kNewMaterialScene) {}
    void SetUp() override {
        SceneFolder::SetUp();
        std::ofstream(folder_ / "wax.txt") << "wax";
    }

    SceneSurvey Survey() const { return SurveyScene({{ScenePath(), std::nullopt}}); }

    /// What `compare` says on standard error, and its results.
    std::string Compare(const std::string& vary, nlohmann::json* results) const {
        CompareArguments a;
        a.scenes = {ScenePath()};
        a.out = (folder_ / "out").string();
        a.estimators = {"bidirectional", "forward"};
        a.equalSamples = 2;
        a.referenceSpp = 16;
        a.runs = 2;
        a.vary = vary;
        testing::internal::CaptureStderr();
        testing::internal::CaptureStdout();
        RunCompare(a);
        testing::internal::GetCapturedStdout();
        std::ifstream in(folder_ / "out" / "results.json");
        *results = nlohmann::json::parse(in);
        return testing::internal::GetCapturedStderr();
    }
};

TEST_F(NewMaterial, ShowsUpInInfoWithItsFile) {
    const Registered waxed("waxed", CreateWaxed, {.isLayered = true});
    const SceneSurvey survey = Survey();
    const auto use = std::find_if(survey.materials.begin(), survey.materials.end(),
                                  [](const MaterialUse& m) { return m.name == "wax"; });
    ASSERT_NE(use, survey.materials.end());
    EXPECT_EQ(use->type, "waxed");
    EXPECT_EQ(use->estimator, "auto");
    EXPECT_EQ(use->pdf, "auto");
    const auto file = std::find_if(survey.files.begin(), survey.files.end(), [](const ListedFile& f) {
        return fs::path(f.path).filename() == "wax.txt";
    });
    ASSERT_NE(file, survey.files.end());
    EXPECT_EQ(file->role, "material");
    EXPECT_EQ(file->bytes, 3u);
    EXPECT_EQ(survey.files.size(), 2u);
    EXPECT_NE(SceneInfoText(survey).find("wax      waxed  auto       auto"), std::string::npos)
        << SceneInfoText(survey);
}

TEST_F(NewMaterial, IsVariedByCompare) {
    const Registered waxed("waxed", CreateWaxed, {.isLayered = true});
    nlohmann::json results;
    const std::string said = Compare("wax.roughness=0.1,0.4", &results);
    EXPECT_EQ(said.find("no layered material"), std::string::npos) << said;
    ASSERT_EQ(results["variants"].size(), 2u);
    EXPECT_EQ(results["variants"][1]["label"], "wax.roughness = 0.4");
}

TEST_F(NewMaterial, IsNotTakenForLayeredUnlessItSaysSo) {
    const Registered waxed("waxed", CreateWaxed);
    const SceneSurvey survey = Survey();
    for (const MaterialUse& m : survey.materials) EXPECT_EQ(m.estimator, "") << m.name;
    nlohmann::json results;
    const std::string said = Compare("", &results);
    EXPECT_NE(said.find("the scene has no layered material"), std::string::npos) << said;
}

}  // namespace
}  // namespace lacquer::cmd::new_material_test
