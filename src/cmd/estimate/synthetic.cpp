// Synthetic photographs: one with its truth, and many that test the method.
#include <fmt/format.h>

#include <csignal>

#include "cmd/command_support.h"
#include "cmd/estimate/estimate_job.h"
#include "cmd/estimate/material_files.h"
#include "cmd/estimate/posterior_files.h"
#include "estimate/calibration/simulation_based.h"
#include "estimate/emulator/emulated_posterior.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

/// The image whose file, read with the same tone curve, has these values.
Image ImageOf(const PlanarImage& photo, const EstimateArguments& a) {
    Image image({photo.size, photo.size}, {"R", "G", "B"});
    const ColorEncoding srgb{ColorEncoding::Kind::SRGB, 1};
    // Formats of bytes hold sRGB codes: those that the camera would have written.
    const std::string extension = ExtensionOf(a.simulate);
    const bool isLinear = extension == "exr" || extension == "pfm" || extension == "hdr";
    const ColorEncoding tone = ReadingOf(a).tone;
    for (int y = 0; y < photo.size; ++y)
        for (int x = 0; x < photo.size; ++x)
            for (int c = 0; c < 3; ++c) {
                const auto code = float(photo.Channel(size_t(c))[size_t(y) * size_t(photo.size) + size_t(x)]);
                image.Set({x, y}, c, isLinear ? tone.ToLinear(code) : srgb.ToLinear(code));
            }
    return image;
}

}  // namespace

ExitStatus SimulatePhotograph(const EstimateArguments& a, Console* console) {
    const PhotoSettings settings = PhotoSettingsOf(a, nullptr);
    const std::unique_ptr<PhotoSimulator> simulator = SimulatorOf(a, settings, a.summaries);
    for (const std::string& warning : simulator->Warnings()) console->Warn("warning: " + warning);
    CheckOutputFile(a.simulate);
    Random random(a.seed, 0);
    const Vector parameters = simulator->Parameters().SamplePrior(random);
    const uint64_t seed = Hash(a.seed, uint64_t(1));
    WriteImage(ImageOf(simulator->Photograph(parameters, seed), a), a.simulate);
    if (!a.out.empty()) {
        CheckOutputFolder(a.out);
        MakeOutputFolder(a.out);
        WriteMaterialFiles(a.out, MaterialOf(a, *simulator, parameters, seed));
    }
    const std::string truth = a.simulate + ".json";
    WriteTruth(truth, a, *simulator, parameters);
    console->Info(fmt::format("{}: {} seen from {:.4g} cm, {:.4g} cm wide; its parameters are in {}",
                              a.simulate, a.model, settings.distance, settings.extent, truth));
    return ExitStatus::Complete;
}

ExitStatus CalibrateMethod(const EstimateArguments& a, Console* console) {
    const ThreadLimit threads(a.threads);
    const std::unique_ptr<PhotoSimulator> simulator =
        SimulatorOf(a, PhotoSettingsOf(a, nullptr), a.summaries);
    CheckSomethingIsFree(*simulator);
    Console::CatchSignals();
    EmulationOptions options;
    options.seed = a.seed;
    const Runs prior = RunPrior(*simulator, options, nullptr, console);
    const InferenceMethod method = [&](const Vector& observed, uint64_t seed) {
        EmulationOptions ofReplicate = options;
        ofReplicate.seed = seed;
        return EmulatePosterior(*simulator, observed, prior, ofReplicate).draws.y;
    };
    const CalibrationReport report = Calibrate(
        *simulator, method, {.replicates = a.calibration, .seed = Hash(a.seed, uint64_t(2))}, console);
    fmt::print("{}", report.ToString());
    if (Console::Signal() != 0) return Console::StatusOfSignal();
    return report.Passes() ? ExitStatus::Complete : ExitStatus::NotConverged;
}

}  // namespace lacquer::cmd
