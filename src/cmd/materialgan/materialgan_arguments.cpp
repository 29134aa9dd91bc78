#include "cmd/materialgan/materialgan_arguments.h"

#include <fmt/format.h>

#include "cmd/choices.h"
#include "cmd/materialgan/evaluation_cases.h"

namespace lacquer::cmd {
namespace {

void AddShared(CLI::App& app, MaterialganArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option(
           "--nthreads", a.threads,
           "Threads; 0: all processors, and one for what a generator of at most 128 x 128 texels makes")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    app.add_flag("--quiet", a.quiet, "No progress");
}

void AddSeed(CLI::App& app, MaterialganArguments& a) {
    app.add_option("--seed", a.seed, "Of all random numbers")->check(Unsigned())->capture_default_str();
}

void AddFile(CLI::App& app, MaterialganArguments& a) {
    app.add_option("file", a.file, "The generator; shipped: the one that comes with Lacquer")
        ->required()
        ->type_name(kFile);
}

void AddFolder(CLI::App& app, MaterialganArguments& a) {
    app.add_option("--out", a.out, "Folder of the results; made if it is not there")
        ->required()
        ->type_name(kFolder);
}

void AddTrain(CLI::App& app, MaterialganArguments& a) {
    AddShared(app, a);
    app.add_option("--out", a.out,
                   "The generator. Beside x.safetensors, x.training.safetensors is the state, stored every "
                   "minute, and "
                   "x.preview.png shows materials, what becomes of them, and samples")
        ->required()
        ->type_name(kFile);
    app.add_option(
           "--objective", a.objective,
           "vae: to be the decoder of an autoencoder; gan: against a discriminator, which takes machines "
           "that are many times as fast as a processor")
        ->check(OneOf({"vae", "gan"}))
        ->capture_default_str();
    app.add_option("--resolution", a.resolution, "Texels along an edge; a power of two")
        ->check(CLI::Range(8, 1024))
        ->capture_default_str();
    app.add_option("--maps", a.featureMaps, "Feature maps at the coarsest resolutions and at the finest")
        ->type_name("MAX:MIN")
        ->capture_default_str();
    app.add_option("--batch", a.batch, "Materials a step")->check(CLI::Range(1, 4096))->capture_default_str();
    auto* hours =
        app.add_option("--hours", a.hours, "Time of the training, earlier runs included")->check(Positive());
    auto* steps =
        app.add_option("--steps", a.steps, "Steps of the training, earlier runs included")->check(Positive());
    hours->excludes(steps);
    app.add_flag("--resume", a.resume,
                 "Goes on from the state; objective, shape, batch and seed are those of the state");
    AddSeed(app, a);
}

void AddSample(CLI::App& app, MaterialganArguments& a) {
    AddShared(app, a);
    AddFile(app, a);
    AddFolder(app, a);
    app.add_option("--count", a.count, "Materials")->check(CLI::Range(1, 10000))->capture_default_str();
    app.add_option("--psi", a.psi, "Below 1: nearer to the mean")
        ->check(CLI::Range(0., 2.))
        ->capture_default_str();
    AddSeed(app, a);
}

void AddMaterials(CLI::App& app, MaterialganArguments& a) {
    AddShared(app, a);
    AddFolder(app, a);
    app.add_option("--count", a.count, "Materials")->check(CLI::Range(1, 10000))->capture_default_str();
    app.add_option("--resolution", a.resolution, "Texels along an edge; a power of two")
        ->check(CLI::Range(8, 1024))
        ->capture_default_str();
    AddSeed(app, a);
}

void AddProject(CLI::App& app, MaterialganArguments& a) {
    AddShared(app, a);
    AddFile(app, a);
    app.add_option("maps", a.maps, "Folder with dif.png, nom.png, rgh.png and spe.png")
        ->required()
        ->type_name(kFolder);
    AddFolder(app, a);
    app.add_option("--space", a.space,
                   "Latents that move: one w, one for each layer, noise as well, or noise")
        ->check(OneOf({"w", "w+", "w+n", "n"}))
        ->capture_default_str();
    app.add_option("--iterations", a.iterations, "Steps")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
}

void AddMorph(CLI::App& app, MaterialganArguments& a) {
    AddShared(app, a);
    AddFile(app, a);
    app.add_option("from", a.latentsA, "Folder with latent.safetensors")->required()->type_name(kFolder);
    app.add_option("to", a.latentsB, "The same of the other material")->required()->type_name(kFolder);
    AddFolder(app, a);
    app.add_option("--steps", a.count, "Materials, both ends included")
        ->check(CLI::Range(2, 1000))
        ->capture_default_str();
}

void AddEvaluate(CLI::App& app, MaterialganArguments& a) {
    AddShared(app, a);
    AddFile(app, a);
    app.add_option("--count", a.count, "Materials")->check(CLI::Range(1, 10000))->capture_default_str();
    app.add_option("--views", a.views, "Photographs that are fitted")
        ->check(CLI::IsMember(EvaluationCounts()))
        ->capture_default_str();
    app.add_option("--iterations", a.fitIterations, "Of the fit of latents")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    AddLatentMoves(app, a.capture.prior);
    app.add_option("--final-resolution", a.capture.finalResolution,
                   "Texels along an edge of materials and photographs, the generator's times a power of two; "
                   "default: the generator's")
        ->check(CLI::Range(1, 4096));
    app.add_option("--refine", a.capture.refine, "Of texels, after each doubling of the resolution")
        ->check(CLI::Range(0, 1000000));
    app.add_option("--texel-iterations", a.texelIterations, "Of the fits of texels")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    app.add_option("--prior-weight", a.priorWeight,
                   "Of the latents' distributions; default: by the number of photographs")
        ->check(CLI::NonNegativeNumber);
    app.add_option("--total-variation", a.capture.totalVariation, "Of the smooth fit of texels")
        ->check(CLI::Range(0., 1e3))
        ->capture_default_str();
    app.add_option("--out", a.out, "The numbers of each material, as JSON")->type_name(kFile);
    app.add_option("--sheet", a.sheet,
                   "Image of the first materials, and of what texels and the generator make of them")
        ->type_name(kFile);
    AddSeed(app, a);
}

void AddInfo(CLI::App& app, MaterialganArguments& a) {
    AddShared(app, a);
    AddFile(app, a);
}

void AddCapture(CLI::App& app, MaterialganArguments& a) { AddCaptureOptions(app, a.capture); }

struct CommandEntry {
    const char *name, *description;
    void (*add)(CLI::App& app, MaterialganArguments& arguments);
    ExitStatus (*run)(const MaterialganArguments& arguments);
};
constexpr CommandEntry kCommands[] = {
    {"train", "Trains a generator on procedural materials", AddTrain, RunTrain},
    {"materials", "Makes the materials by formula that evaluate takes, of all families in turn", AddMaterials,
     RunMaterials},
    {"sample", "Makes materials of random numbers", AddSample, RunSample},
    {"project", "Finds the latents of given maps", AddProject, RunProject},
    {"morph", "Goes from one material to another through latents", AddMorph, RunMorph},
    {"evaluate", "Compares fits of known materials with the generator and without", AddEvaluate, RunEvaluate},
    {"capture", "Makes maps from photographs, as lacquer capture does, which calls it for --prior",
     AddCapture, RunCaptureWithPrior},
    {"info", "Tells what a generator is", AddInfo, RunInfo},
};

}  // namespace

std::vector<MaterialganCommand> AddMaterialganCommands(CLI::App& app, MaterialganArguments& a) {
    std::vector<MaterialganCommand> commands;
    for (const CommandEntry& entry : kCommands) {
        CLI::App* command = app.add_subcommand(entry.name, entry.description);
        entry.add(*command, a);
        ExpectFiniteNumbers(*command);
        commands.push_back({command, entry.run});
    }
    app.require_subcommand(1);
    return commands;
}

std::vector<CommandHelp> MaterialganHelp() {
    std::vector<CommandHelp> help;
    MaterialganArguments unused;
    for (const CommandEntry& entry : kCommands) {
        CLI::App command(entry.description, fmt::format("lacquer-materialgan {}", entry.name));
        entry.add(command, unused);
        help.push_back(Describe(command, entry.name));
    }
    return help;
}

}  // namespace lacquer::cmd
