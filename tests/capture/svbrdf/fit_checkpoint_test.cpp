// Fits that are stopped, and go on from the state that they left.
#include "capture/svbrdf/fit_checkpoint.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "capture/svbrdf/made_maps.h"
#include "capture/svbrdf/pixel_fit.h"
#include "capture/svbrdf/scratch_folder.h"
#include "pbrt/core/error.h"
#include "support/stopping_observer.h"

namespace lacquer::capture::fit_checkpoint_test {
namespace {

using lacquer::test::StoppingObserver;

constexpr int kSize = 16, kIterations = 40;  // 20 of half the size come first
const FitCheckpoint::Problem kProblem = {{"--iterations", "40"}, {"photographs", "abc"}};

struct Photographs {
    ViewSet views = test::GridViews(3);
    std::vector<RectifiedImage> images;
    Photographs() {
        views.views[1].isTest = true;
        images = test::RenderViews(test::MadeMaps(kSize, test::Pattern::Tiles, 4), views);
    }
};

/// A fit with its light, and the steps that it told.
struct Told {
    FitResult fit;
    std::vector<FitStep> steps;
};
Told FitWith(const Photographs& p, FitCheckpoint* checkpoint, Observer* observer = nullptr) {
    Told told;
    FitSettings settings;
    settings.iterations = kIterations;
    settings.fitLightPower = true;
    settings.testEvery = 7;
    settings.afterStep = [&](const FitStep& step) { told.steps.push_back(step); };
    settings.checkpoint = checkpoint;
    told.fit = FitFromConstant(p.views, p.images, {}, settings, observer);
    return told;
}

std::string ErrorOf(const std::string& path, const FitCheckpoint::Problem& problem) {
    try {
        FitCheckpoint(path, problem).Load();
    } catch (const FileError& e) {
        return e.what();
    }
    return "none";
}

TEST(FitCheckpoint, GoesOnToTheSameBits) {
    const Photographs p;
    const Told whole = FitWith(p, nullptr);
    const test::ScratchFolder folder;
    const std::string path = folder.File("state");
    for (const int units : {1, 13, 20, 21, 47, 60}) {
        FitCheckpoint first(path, kProblem);
        StoppingObserver observer(units);
        const Told part = FitWith(p, &first, &observer);
        EXPECT_EQ(part.fit.end, units < 60 ? FitResult::End::Stopped : FitResult::End::Finished);
        FitCheckpoint second(path, kProblem);
        second.Load();
        const Told rest = FitWith(p, &second);
        EXPECT_EQ(rest.fit.end, FitResult::End::Finished);
        EXPECT_EQ(rest.fit.maps.values, whole.fit.maps.values) << units;
        EXPECT_EQ(rest.fit.lightPower, whole.fit.lightPower);
        EXPECT_EQ(rest.fit.inputRmse, whole.fit.inputRmse);
        ASSERT_EQ(rest.steps.size(), whole.steps.size());
        for (size_t i = 0; i < rest.steps.size(); ++i) {
            EXPECT_EQ(rest.steps[i].iteration, whole.steps[i].iteration);
            EXPECT_EQ(rest.steps[i].testRmse, whole.steps[i].testRmse);
        }
        second.Remove();
        EXPECT_FALSE(std::filesystem::exists(path));
    }
}

// The control: a fit that takes the maps and not the moments comes to others.
TEST(FitCheckpoint, MapsAloneAreNotAState) {
    const Photographs p;
    FitSettings settings;
    settings.iterations = kIterations;
    const Maps start = ConstantMaps(kSize);
    const FitResult whole = FitMaps(p.views, p.images, start, settings);
    StoppingObserver observer(kIterations / 2);
    const FitResult half = FitMaps(p.views, p.images, start, settings, &observer);
    settings.iterations = kIterations / 2;
    EXPECT_NE(FitMaps(p.views, p.images, half.maps, settings).maps.values, whole.maps.values);
}

TEST(FitCheckpoint, SaysWhatItDoesNotTake) {
    const Photographs p;
    const test::ScratchFolder folder;
    const std::string path = folder.File("state");
    FitCheckpoint checkpoint(path, kProblem);
    StoppingObserver observer(13);
    FitWith(p, &checkpoint, &observer);
    EXPECT_EQ(ErrorOf(path, kProblem), "none");
    EXPECT_NE(ErrorOf(path, {{"--iterations", "50"}}).find("--iterations 40, and this one has 50"),
              std::string::npos);
    EXPECT_NE(ErrorOf(path, {{"--prior", "x"}}).find("--prior none"), std::string::npos);
    EXPECT_NE(ErrorOf(folder.File("nothing"), kProblem), "none");

    std::filesystem::resize_file(path, std::filesystem::file_size(path) - 4);
    EXPECT_NE(ErrorOf(path, kProblem), "none");
    WriteSafetensors(path, {}, {{"format", "another"}});
    EXPECT_NE(ErrorOf(path, kProblem).find("no checkpoint"), std::string::npos);
    for (const char* fits : {"{", "[1]", R"({"texels 8":{}})",
                             R"({"texels 8":{"iteration":3,"numbers":{},"tensors":["values"]}})"}) {
        WriteSafetensors(path, {},
                         {{"format", "lacquer-capture-checkpoint 1"}, {"problem", "{}"}, {"fits", fits}});
        EXPECT_NE(ErrorOf(path, {}), "none") << fits;
    }
}

// A header may be whole and its states not.
TEST(FitCheckpoint, StatesThatLackSomethingAreDamage) {
    const Photographs p;
    const test::ScratchFolder folder;
    const std::string path = folder.File("state");
    const auto error = [&](const FitState& state) -> std::string {
        FitCheckpoint(path, kProblem).Write("texels 8", state);
        FitCheckpoint checkpoint(path, kProblem);
        checkpoint.Load();
        try {
            FitWith(p, &checkpoint);
        } catch (const FileError& e) {
            return e.what();
        }
        return "none";
    };
    EXPECT_NE(error({}).find("damaged"), std::string::npos);
    EXPECT_NE(error({-1, {}, {}, {}}).find("damaged"), std::string::npos);
    EXPECT_NE(error({kIterations + 1, {}, {}, {}}).find("damaged"), std::string::npos);
    EXPECT_NE(error({2, {{"input rmse", {1, 2}}, {"test rmse", {1}}}, {}, {}}).find("damaged"),
              std::string::npos);
}

}  // namespace
}  // namespace lacquer::capture::fit_checkpoint_test
