// lacquer farm: a render in parts, for engines that run commands on many machines.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/farm/farm_files.h"
#include "cmd/scenes/scene_arguments.h"
#include "pbrt/base/film.h"
#include "pbrt/base/integrator.h"
#include "pbrt/base/sampler.h"
#include "pbrt/scene/factory.h"

namespace lacquer::cmd {
namespace {

namespace fs = std::filesystem;

/// Everything that the command line of `farm` can say.
struct FarmArguments {
    std::string action, scene, outfile, folder, program, options, resolution;
    int jobs = 0;
    std::optional<int> spp;
    bool byRows = false, quiet = false;
    std::optional<double> checkpointEvery;
    std::vector<std::string> slurm;
};

const std::vector<std::string> kActions = {"split"};

/// From `begin` to `end` in `count` parts that differ by at most one. @return  their ends
std::vector<int> EndsOf(int begin, int end, int count) {
    std::vector<int> ends;
    for (int i = 1; i <= count; ++i) ends.push_back(begin + int(int64_t(end - begin) * i / count));
    return ends;
}

class FarmSplit {
  public:
    explicit FarmSplit(const FarmArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        if (a_.scene == "-")
            throw CLI::ValidationError("farm: the scene must be a file; every task reads it");
        CheckImageOutput(a_.outfile);
        const SceneDescription scene = ParseInputs(ReadSceneArguments({a_.scene}), &console_);
        plan_.program = a_.program.empty() ? fs::read_symlink("/proc/self/exe").string() : a_.program;
        plan_.scene = Absolute(a_.scene);
        plan_.outfile = Absolute(a_.outfile);
        plan_.folder = Absolute(a_.folder);
        plan_.options = a_.options;
        if (a_.checkpointEvery) plan_.options += fmt::format(" --checkpoint-every {}", *a_.checkpointEvery);
        if (a_.spp) plan_.options += fmt::format(" --spp {}", *a_.spp);
        if (!a_.resolution.empty()) plan_.options += " --resolution " + ShellWord(a_.resolution);
        CheckOptions();
        if (Registry<IntegratorKind>::TraitsOf(scene.integrator.type).mutationsPerPixel)
            throw CLI::ValidationError(fmt::format(
                "integrator \"{}\" follows Markov chains across the image, which cannot be divided",
                scene.integrator.type));
        if (a_.byRows)
            DivideRows(scene);
        else
            DivideSamples(scene);
        MakeOutputFolder(a_.folder);
        WriteFarmFiles(plan_, a_.slurm);
        console_.Info(fmt::format("{}: {} tasks in tasks.txt, then merge.sh; with Slurm: sh {}/submit.sh",
                                  plan_.folder, plan_.parts.size(), plan_.folder));
        return ExitStatus::Complete;
    }

  private:
    /// Of the renders: those that do not go with how they are divided, however they are spelt.
    void CheckOptions() const {
        CheckTheirOwnOptions();
        const std::string options = NormalizedName(a_.options);
        if (options.find("noisetarget") != std::string::npos)
            throw CLI::ValidationError(
                "--render-options: --noise-target decides how many samples there are, and tasks cannot agree "
                "on it; say --spp");
        if (a_.byRows && options.find("adaptive") != std::string::npos)
            throw CLI::ValidationError(
                "--rows does not go with --adaptive, which divides the samples of the whole image; leave "
                "--rows out");
    }

    /// What tasks are told by `farm split`: with their own word for it they would render something else,
    /// which merging finds out at the end.
    void CheckTheirOwnOptions() const {
        std::istringstream words(a_.options);
        for (std::string word; words >> word;) {
            if (!word.starts_with('-')) continue;
            const std::string name = NormalizedName(word.substr(0, word.find('=')));
            for (const char* own : {"--spp", "--resolution", "--outfile"})
                if (name == NormalizedName(own))
                    throw CLI::ValidationError(fmt::format(
                        "--render-options: {} is an option of farm split itself, which divides by it", own));
            for (const char* own : {"--sample-range", "--pixelbounds", "--cropwindow", "--pixel", "--quick",
                                    "--frames", "--mpi", "--checkpoint", "--resume"})
                if (name == NormalizedName(own))
                    throw CLI::ValidationError(fmt::format(
                        "--render-options: {} does not go with tasks, which farm split divides the render "
                        "into",
                        own));
        }
    }

    static std::string Absolute(const std::string& path) {
        std::string absolute = fs::absolute(path).lexically_normal().string();
        while (absolute.size() > 1 && absolute.back() == '/') absolute.pop_back();
        return absolute;
    }

    void CheckJobs(int most, const char* what) const {
        if (a_.jobs > most)
            BadOption("jobs", fmt::format("{}", a_.jobs), fmt::format("at most {}, {}", most, what));
    }

    FilmOverrides Overrides() const {
        FilmOverrides film;
        if (!a_.resolution.empty()) film.resolution = ParseResolution("resolution", a_.resolution);
        film.filename = a_.outfile;
        return film;
    }

    /// All that a part needs to know of the film is its size.
    std::unique_ptr<Film> MakeFilm(const SceneDescription& d) const {
        const Params params = MakeParams(d.film, "film", d.FilesOf(d.film));
        auto filter = FactoryOf<FilterKind>(d.filter)(MakeParams(d.filter, "filter", d.FilesOf(d.filter)));
        return FactoryOf<FilmKind>(d.film)({params, Overrides(), std::move(filter)});
    }

    /// As it will be for all parts, whichever samples they take: some take others than are asked for.
    void DivideSamples(const SceneDescription& d) {
        const Params params = MakeParams(d.sampler, "sampler", d.FilesOf(d.sampler));
        const int samples =
            FactoryOf<SamplerKind>(d.sampler)({params, MakeFilm(d)->Resolution(), a_.spp})->SamplesPerPixel();
        CheckJobs(samples, "the samples per pixel; with --rows, the rows of the image");
        int begin = 0;
        for (const int end : EndsOf(0, samples, a_.jobs)) {
            plan_.parts.push_back(fmt::format("--sample-range {}:{}", begin, end));
            begin = end;
        }
    }

    void DivideRows(const SceneDescription& d) {
        if (Registry<IntegratorKind>::TraitsOf(d.integrator.type).makesSplats)
            throw CLI::ValidationError(
                fmt::format("--rows: integrator \"{}\" traces light that lands in all rows; without --rows, "
                            "the samples of each pixel are divided",
                            d.integrator.type));
        const Bounds2i pixels = MakeFilm(d)->PixelBounds();
        CheckJobs(pixels.Height(), "the rows of the image");
        int begin = pixels.min.y;
        for (const int end : EndsOf(pixels.min.y, pixels.max.y, a_.jobs)) {
            plan_.parts.push_back(
                fmt::format("--pixelbounds {},{},{},{}", pixels.min.x, pixels.max.x, begin, end));
            begin = end;
        }
    }

    const FarmArguments& a_;
    Console console_;
    FarmPlan plan_;
};

void AddFarmOptions(CLI::App& app, FarmArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("action", a.action, "split: writes the tasks of one image")
        ->required()
        ->check(OneOf(kActions));
    app.add_option("scene", a.scene, "Scene file, at the same path on all machines")
        ->type_name(kFile)
        ->required();
    app.add_option("--jobs", a.jobs, "Tasks to divide it into")->required()->check(CLI::Range(1, 1 << 20));
    app.add_option("--outfile", a.outfile, "Image to make in the end")->type_name(kFile)->required();
    app.add_option("--folder", a.folder,
                   "Folder for tasks and states, on a file system that all machines share")
        ->type_name(kFolder)
        ->required();
    app.add_flag("--rows", a.byRows, "Divide the rows of the image, and not the samples of each pixel");
    app.add_option("--spp", a.spp, "Samples per pixel of the whole, instead of the scene's")
        ->check(CLI::Range(1, 1 << 24));
    app.add_option("--resolution", a.resolution, "WxH, instead of the scene's");
    app.add_option("--render-options", a.options,
                   "Further options of every render, in one argument: \"--aov depth --nthreads 8\"");
    AddCheckpointInterval(app, a.checkpointEvery);
    app.add_option("--program", a.program,
                   "The lacquer of the other machines; by default, the path of this one");
    app.add_option("--slurm", a.slurm, "Further option of sbatch, as in \"--time=4:00:00\"; may be repeated")
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_flag("--quiet", a.quiet, "No information and no warnings");
}

ExitStatus RunFarm(const FarmArguments& arguments) { return FarmSplit(arguments).Run(); }

constexpr const char* kFarmSynopsis =
    "Divides a render into tasks for many machines, which restart by themselves, and whose sum has the bits\n"
    "of one render: for Slurm, or any engine that runs commands (docs/farm.md).";
constexpr const char* kFarmFooter = R"(
Exit status: 0 the tasks are written; 1 wrong usage; 2 the scene is wrong; 3 a file cannot be read or
written.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "farm", (CommandOf<FarmArguments, AddFarmOptions, RunFarm>::Make),
                 {.synopsis = kFarmSynopsis, .footer = kFarmFooter});

}  // namespace lacquer::cmd
