#include <array>
#include <stdexcept>

#include "estimate/summary/summary.h"
#include "estimate/summary/vgg.h"
#include "pbrt/core/check.h"
#include "pbrt/core/error.h"

namespace lacquer::estimate {
namespace {

struct Family {
    std::string_view name;
    std::unique_ptr<Summary> (*make)(const MapGrid& grid);
};
constexpr std::array<Family, 8> kFamilies{{
    {"colour", MakeColorSummary},
    {"rings", MakeRingSummary},
    {"columns", MakeColumnSummary},
    {"spectrum", MakeSpectrumSummary},
    {"columnspectrum", MakeColumnSpectrumSummary},
    {"pyramid", MakePyramidSummary},
    {"histogram", MakeHistogramSummary},
    {"gram", MakeGramSummary},
}};

std::string UnknownFamily(const std::string& name) {
    std::vector<std::string> known;
    for (const Family& family : kFamilies) known.emplace_back(family.name);
    return fmt::format("there are no summaries \"{}\"{}", name, DidYouMean(name, known));
}

}  // namespace

std::unique_ptr<Summary> MakeSummary(std::string_view name, const MapGrid& grid) {
    LACQUER_CHECK(grid.size >= 64 && grid.size % 16 == 0);
    for (const Family& family : kFamilies)
        if (family.name == name) return family.make(grid);
    return nullptr;
}

std::span<const std::string_view> SummaryFamilies() {
    static const auto kNames = [] {
        std::array<std::string_view, kFamilies.size()> names;
        for (size_t i = 0; i < names.size(); ++i) names[i] = kFamilies[i].name;
        return names;
    }();
    return kNames;
}

SummarySet::SummarySet(const std::vector<std::string>& families, const MapGrid& grid,
                       const std::shared_ptr<const VggWeights>& vgg) {
    for (const std::string& name : families) {
        if (name == "vgg" && !vgg) throw std::invalid_argument("summaries \"vgg\" need a file of weights");
        auto family = name == "vgg" ? MakeVggSummary(grid, vgg) : MakeSummary(name, grid);
        if (!family) throw std::invalid_argument(UnknownFamily(name));
        names_.insert(names_.end(), family->Names().begin(), family->Names().end());
        families_.push_back(std::move(family));
    }
    const size_t pixels = grid.NumPoints();
    input_.luminance.resize(pixels);
    byInput_.luminance.resize(pixels);
    byInput_.image = PlanarImage(grid.size);
}

void SummarySet::Forward(PlanarImage image, std::span<double> values) {
    input_.image = std::move(image);
    const auto r = input_.image.Channel(0), g = input_.image.Channel(1), b = input_.image.Channel(2);
    for (size_t i = 0; i < r.size(); ++i)
        input_.luminance[i] =
            kLuminanceWeights[0] * r[i] + kLuminanceWeights[1] * g[i] + kLuminanceWeights[2] * b[i];
    size_t first = 0;
    for (const auto& family : families_) {
        family->Forward(input_, values.subspan(first, family->Size()));
        first += family->Size();
    }
}

const PlanarImage& SummarySet::Backward(std::span<const double> by) {
    std::fill(byInput_.luminance.begin(), byInput_.luminance.end(), 0.);
    std::fill(byInput_.image.values.begin(), byInput_.image.values.end(), 0.);
    size_t first = 0;
    for (const auto& family : families_) {
        family->Backward(input_, by.subspan(first, family->Size()), &byInput_);
        first += family->Size();
    }
    for (size_t k = 0; k < 3; ++k) {
        const auto channel = byInput_.image.Channel(k);
        for (size_t i = 0; i < channel.size(); ++i)
            channel[i] += kLuminanceWeights[k] * byInput_.luminance[i];
    }
    return byInput_.image;
}

}  // namespace lacquer::estimate
