#include "cmd/materialgan/evaluation_cases.h"

#include <array>
#include <map>

#include "materialgan/procedural/procedural.h"
#include "pbrt/core/rng.h"

namespace lacquer::cmd {
namespace {

using materialgan::Family;

/// Of the sample, and of the cameras above it [cm].
constexpr double kEdge = 6.848, kHeight = 16;
constexpr int kHeldOutEvery = 5;
/// Not the seeds that a training has.
constexpr uint64_t kSeeds = 0x6576616c;

/// Which of a grid of 3 x 3 are taken, in rows from the top.
const std::map<int, std::vector<int>> kGridViews = {{1, {4}},
                                                    {3, {0, 5, 7}},
                                                    {5, {4, 0, 2, 6, 8}},
                                                    {7, {0, 1, 2, 3, 5, 6, 7}},
                                                    {9, {0, 1, 2, 3, 4, 5, 6, 7, 8}}};

}  // namespace

EvaluationCase EvaluationCaseOf(int index, int size, uint64_t seed) {
    const bool isHeldOut = index % kHeldOutEvery == kHeldOutEvery - 1;
    const int trained = index - index / kHeldOutEvery;
    const auto family = isHeldOut ? Family::Dots : Family(trained % materialgan::kNumTrainedFamilies);
    return {materialgan::FamilyName(family),
            materialgan::ProceduralMaterial(family, size, Hash(seed, index, kSeeds)), isHeldOut};
}

const std::vector<int>& EvaluationCounts() {
    static const std::vector<int> counts = [] {
        std::vector<int> all;
        for (const auto& [count, views] : kGridViews) all.push_back(count);
        return all;
    }();
    return counts;
}

capture::ViewSet EvaluationViews(int count) {
    capture::ViewSet set;
    set.size = kEdge;
    const double step = 0.365 * kEdge;
    for (const int i : kGridViews.at(count)) {
        const capture::Point p{(i % 3 - 1) * step, (1 - i / 3) * step, kHeight};
        set.views.push_back({"", p, p, false});
    }
    for (const double x : {-1., 1.})
        for (const double y : {-1., 1.}) {
            const capture::Point p{0.18 * kEdge * x, 0.18 * kEdge * y, 14. / 16 * kHeight};
            set.views.push_back({"", p, p, true});
            set.views.push_back(
                {"", {0, 0, kHeight}, {0.88 * kEdge * x, 0.88 * kEdge * y, 10. / 16 * kHeight}, true});
        }
    return set;
}

}  // namespace lacquer::cmd
