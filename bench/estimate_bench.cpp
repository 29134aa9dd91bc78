// CPU time of the forward runs and gradients of the estimation from photographs, and where it goes.
//
// usage: estimate_bench [resolution ...]
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "cpu_time.h"
#include "estimate/photo_simulator.h"

namespace lacquer::bench {
namespace {

using namespace lacquer::estimate;  // NOLINT: all of this file is about it

/// Least CPU time of a call over several [ms].
double MillisecondsOf(const std::function<void(int)>& call) {
    double least = 1e30, all = 0;
    for (int i = 0; i < 40 && (i < 5 || all < 1); ++i) {
        const double start = CpuSeconds();
        call(i);
        const double time = CpuSeconds() - start;
        all += time;
        least = std::min(least, time);
    }
    return 1e3 * least;
}

void TimeModel(const MaterialModel& model, int resolution) {
    PhotoSettings settings;
    settings.resolution = resolution;
    const PhotoSimulator simulator(model, settings, {});
    Vector x(Eigen::Index(simulator.Parameters().Size()));
    for (size_t i = 0; i < simulator.Parameters().Size(); ++i)
        x[Eigen::Index(i)] = simulator.Parameters()[i].prior.mean;
    const auto all = simulator.AllParameters(x);
    const MapGrid grid = settings.Grid();
    const auto run = model.MakeRun(grid, {}, {});
    const FlashPhoto photo(grid, settings.distance, settings.brdf);
    Surface surface;
    PlanarImage linear, toned;
    const double seed = MillisecondsOf([&](int i) { run->SetSeed(uint64_t(i)); });
    const double surfaceTime = MillisecondsOf([&](int i) {
        auto p = all;
        p[size_t(std::max(model.Find("frequency"), 0))] *= 1 + 1e-9 * i;  // nothing kept of the last run
        run->Forward(p, &surface);
    });
    const double photoTime = MillisecondsOf([&](int) {
        photo.Forward(surface, {all[0], 10, 0, 0}, &linear);
    });
    const double tone = MillisecondsOf([&](int) { ApplyTone(settings.tone, linear, &toned); });
    const double forward = MillisecondsOf([&](int i) { simulator.Simulate(x, uint64_t(i)); });
    Vector by = Vector::Ones(Eigen::Index(simulator.SummaryNames().size()));
    const double gradient = MillisecondsOf([&](int) { simulator.SimulateForGradient(x, 1)->Gradient(by); });
    const PhotoSimulator smooth(model, settings, {},
                                model.ReflectanceKind() == Reflectance::Metal
                                    ? DefaultSummaries(model)
                                    : std::vector<std::string>{"colour", "rings", "spectrum"});
    by = Vector::Ones(Eigen::Index(smooth.SummaryNames().size()));
    const double gradientWithout =
        MillisecondsOf([&](int) { smooth.SimulateForGradient(x, 1)->Gradient(by); });
    std::printf("%-8s %4d %8.2f %8.2f %8.2f %8.2f %10.2f %10.2f %10.2f\n", std::string(model.Name()).c_str(),
                resolution, seed, surfaceTime, photoTime, tone, forward, gradient, gradientWithout);
}

void TimeSummaries(int resolution) {
    PhotoSettings settings;
    settings.resolution = resolution;
    const PhotoSimulator leather(LeatherModel(), settings, {}, {"colour"});
    Vector x(Eigen::Index(leather.Parameters().Size()));
    for (size_t i = 0; i < leather.Parameters().Size(); ++i)
        x[Eigen::Index(i)] = leather.Parameters()[i].prior.mean;
    const PlanarImage image = leather.Photograph(x, 1);
    for (const std::string_view family : SummaryFamilies()) {
        SummarySet set({std::string(family)}, settings.Grid());
        std::vector<double> values(set.Size()), by(set.Size(), 1.);
        const double forward = MillisecondsOf([&](int) {
            PlanarImage copy = set.TakeImage();
            copy = image;
            set.Forward(std::move(copy), values);
        });
        const double backward = MillisecondsOf([&](int) { set.Backward(by); });
        std::printf("%-14s %4d %5zu %10.2f %10.2f\n", std::string(family).c_str(), resolution, set.Size(),
                    forward, backward);
    }
}

}  // namespace
}  // namespace lacquer::bench

int main(int argc, char** argv) {
    std::vector<int> resolutions;
    for (int i = 1; i < argc; ++i) resolutions.push_back(std::atoi(argv[i]));
    if (resolutions.empty()) resolutions = {64, 128, 256, 512};
    std::printf(
        "CPU ms: seed, surface, photograph, tone curve; a forward run with a fresh seed and the default\n"
        "summaries; a gradient with a fixed seed, with and without the pyramid\n");
    for (const int resolution : resolutions)
        for (const auto* model : lacquer::estimate::AllModels())
            lacquer::bench::TimeModel(*model, resolution);
    std::printf("summaries: how many, CPU ms forward and backward\n");
    for (const int resolution : resolutions) lacquer::bench::TimeSummaries(resolution);
}
