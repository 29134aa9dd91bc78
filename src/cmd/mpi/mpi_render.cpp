#include "cmd/mpi/mpi_render.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/mpi/manager.h"
#include "cmd/mpi/worker.h"
#include "cmd/render/render_job.h"
#include "cmd/report_error.h"
#include "mpi/messenger.h"
#include "pbrt/core/loaded_module.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {
namespace {

constexpr const char* kModule = "liblacquer_mpi.so";
constexpr const char* kPurpose =
    "which --mpi needs and is built where there is an MPI (Debian: libopenmpi-dev and openmpi-bin)";

std::unique_ptr<mpi::Messenger> LoadMessenger() {
    const auto make =
        reinterpret_cast<decltype(&LacquerMpi)>(FunctionOfModule(kModule, "LacquerMpi", kPurpose));
    std::unique_ptr<mpi::Messenger> messenger(make(mpi::Messenger::kVersion));
    if (!messenger) RefuseModule(kModule, kPurpose, "it is of another version of Lacquer");
    return messenger;
}

/// What decides by the whole image, or is about one process.
void CheckMpiArguments(const RenderArguments& a) {
    const auto refuse = [](bool isGiven, const char* option, const char* why) {
        if (isGiven) throw CLI::ValidationError(fmt::format("{} does not go with --mpi: {}", option, why));
    };
    refuse(!a.frames.empty(), "--frames", "frames are jobs of their own");
    refuse(a.adaptive, "--adaptive", "pixels get samples by what all of the image needs; see lacquer farm");
    refuse(!a.noiseTarget.empty(), "--noise-target", "it looks at the whole image between samples");
    refuse(a.timeLimit.has_value(), "--time-limit", "a signal stops a job, and leaves image and state");
    refuse(a.options.Values().pixelStats, "--pixelstats", "it measures one process");
    refuse(!a.options.Values().mseReferenceImage.empty(), "--mse-reference-image",
           "it compares whole passes, which there are none of");
    refuse(a.sandbox.isOn, "--sandbox", "MPI needs the network and memory of other processes");
    const bool readsInput =
        a.scenes.empty() || std::find(a.scenes.begin(), a.scenes.end(), "-") != a.scenes.end();
    refuse(readsInput, "a scene from standard input", "only one process gets it");
    for (const std::string& path : a.scenes) {
        std::error_code error;
        refuse(std::filesystem::is_fifo(path, error), "a scene from a pipe", "only one process gets it");
    }
}

/// Ranks on one machine share its processors, unless --nthreads says how many each has.
int ThreadsOf(const RenderArguments& a, const mpi::Messenger& messenger) {
    if (a.threads > 0) return a.threads;
    const int all = int(sysconf(_SC_NPROCESSORS_ONLN)), ranks = messenger.CountHere();
    const int share = std::max(1, (all + ranks - 1) / ranks);
    // Fewer where mpirun has bound this process to some of them.
    return std::min(share, ThreadLimit(0).Threads());
}

/// What another rank than the first does of it: no messages and no files.
RenderArguments ArgumentsOfWorker(RenderArguments a) {
    a.quiet = true;
    a.stats = a.writePartialImages = false;
    for (std::string* path : {&a.statsJson, &a.logFile, &a.checkpoint, &a.resume, &a.displayServer})
        path->clear();
    return a;
}

ExitStatus RunManager(const RenderArguments& arguments, mpi::Messenger* messenger) {
    Console console(ConsoleStyle::Detect(arguments.quiet));
    JobManager manager(messenger);
    ExitStatus status = ExitStatus::Internal;
    try {
        CheckMpiArguments(arguments);
        CheckArguments(arguments);
        if (messenger->Count() > 1)
            console.Info(fmt::format("{} processes, {} of them on this machine with {} threads each",
                                     messenger->Count(), messenger->CountHere(), arguments.threads));
        status = RunRenderJob(arguments, {}, &manager);
    } catch (const std::exception&) {
        status = ReportError(console);
    }
    manager.End(status);
    return status;
}

ExitStatus RunWorker(const RenderArguments& arguments, mpi::Messenger* messenger) {
    JobWorker worker(messenger);
    try {
        ServeRenderJob(arguments, &worker);
    } catch (const std::exception& e) {
        worker.Fail(StatusOfError(), e.what());
    }
    worker.End();
    return ExitStatus::Complete;
}

}  // namespace

ExitStatus RunMpiRender(const RenderArguments& arguments) {
    const std::unique_ptr<mpi::Messenger> messenger = LoadMessenger();
    RenderArguments a = arguments;
    a.threads = ThreadsOf(arguments, *messenger);
    if (messenger->Rank() == 0) return RunManager(a, messenger.get());
    return RunWorker(ArgumentsOfWorker(a), messenger.get());
}

}  // namespace lacquer::cmd
