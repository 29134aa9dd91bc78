#include "cmd/estimate/layered_synthetic.h"

#include <fmt/format.h>

#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>

#include "cmd/command_support.h"
#include "cmd/estimate/layered_problem.h"
#include "estimate/layered/noisy_measurement.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {

using namespace estimate;
namespace {

using Json = nlohmann::ordered_json;

/// Of a truth, over those of a simulation.
constexpr int kMoreSamples = 16;

/// The directions of --simulate and --sbc: those of the data that are given, or lobes.
Measurement Directions(const EstimateArguments& a) {
    Measurement m;
    if (!a.photo.empty()) return ReadMeasured(a.photo, a.seed);
    m.directions = LobeDirections();
    return m;
}

}  // namespace

ExitStatus SimulateLayers(const EstimateArguments& a, Console* console) {
    const ThreadLimit threads(a.threads);
    CheckOutputFile(a.simulate);
    LayeredProblem problem = ReadLayeredScene(a, console);
    SetMeasurement(a, Directions(a), &problem);
    Measurement& m = problem.measurement;
    const Vector start = problem.parameters->Start();
    Random random(a.seed, uint64_t(0x7472757468));
    const double noise = problem.space->SamplePrior(random)[start.size()];
    const Vector all = problem.reflectance->Measure(start, random.Bits(), kMoreSamples);
    const Eigen::Index channels = m.IsColor() ? 3 : 1, rows = m.NumRows();
    m.values = all.head(rows * channels).reshaped(channels, rows).transpose();
    m.deviations = all.tail(rows * channels).reshaped(channels, rows).transpose();
    for (double& value : m.values.reshaped()) value *= std::exp(noise * random.Normal());
    if (!(m.values.minCoeff() > 0))
        throw SceneError({a.scene},
                         "the material reflects nothing in some of the directions; expected ones in which "
                         "it does");
    WriteText(a.simulate, MeasurementCsv(m, !problem.IsExact()));
    Json truth;
    truth["material"] = problem.parameters->Material();
    truth["seed"] = a.seed;
    for (Eigen::Index i = 0; i < start.size(); ++i)
        truth["parameters"][(*problem.space)[size_t(i)].name] = start[i];
    truth["parameters"][kNoiseName] = noise;
    WriteText(a.simulate + ".json", JsonText(truth, 2) + "\n");
    console->Info(fmt::format("{}: {} directions with noise of {:.2g} %; its parameters are in {}.json",
                              a.simulate, rows, 100 * noise, a.simulate));
    return ExitStatus::Complete;
}

ExitStatus CalibrateLayers(const EstimateArguments& a, Console* console) {
    const ThreadLimit threads(a.threads);
    LayeredProblem problem = ReadLayeredScene(a, console);
    SetMeasurement(a, Directions(a), &problem);
    Console::CatchSignals();
    LobeOptions options = LobeOptionsOf(a);
    const Eigen::Index m = problem.reflectance->NumValues();
    const Vector typical = problem.reflectance->Measure(problem.parameters->Start(), a.seed, kMoreSamples);
    const NoisyMeasurement measurements(
        *problem.space, problem.Simulator().SummaryNames(),
        [&](const Vector& x, uint64_t seed) { return problem.reflectance->Measure(x, seed, kMoreSamples); },
        kFloorOfPeak * typical.head(m).maxCoeff());
    const Runs prior = RunLobePrior(problem.Simulator(), options, nullptr, console);
    console->Begin("replicates", a.calibration, "replicates");
    const InferenceMethod method = [&](const Vector& summaries, uint64_t seed) {
        LobeOptions ofReplicate = options;
        ofReplicate.seed = seed;
        return FindLobePosterior(problem.Simulator(), *problem.space, *problem.coordinates,
                                 measurements.Observed(summaries), prior, ofReplicate)
            .draws.y;
    };
    const CalibrationReport report = Calibrate(
        measurements, method, {.replicates = a.calibration, .seed = Hash(a.seed, uint64_t(2))}, console);
    console->End();
    fmt::print("{}", report.ToString());
    if (Console::Signal() != 0) return Console::StatusOfSignal();
    return report.Passes() ? ExitStatus::Complete : ExitStatus::NotConverged;
}

}  // namespace lacquer::cmd
