// What tests of commands begin with.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "support/statistics.h"

namespace lacquer::cmd {

/// A folder for one test, with a scene in it; empty again each time.
class SceneFolder : public testing::Test {
  protected:
    explicit SceneFolder(const char* scene) : scene_(scene) {}
    void SetUp() override {
        using namespace ::lacquer::test;
        folder_ =
            std::filesystem::path(testing::TempDir()) / ("lacquer-" + std::to_string(SeedOf(FullTestName())));
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directory(folder_);
        std::ofstream(ScenePath()) << scene_;
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string ScenePath() const { return (folder_ / "scene.pbrt").string(); }

    std::filesystem::path folder_;

  private:
    const char* scene_;
};

}  // namespace lacquer::cmd
