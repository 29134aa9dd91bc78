// lacquer-materialgan sample, project, morph and info.
#include <fmt/format.h>

#include <filesystem>
#include <iostream>

#include "cmd/capture/map_fitter.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/materialgan/evaluation_cases.h"
#include "cmd/materialgan/generator_path.h"
#include "cmd/materialgan/map_files.h"
#include "cmd/materialgan/materialgan_arguments.h"
#include "cmd/printable.h"
#include "materialgan/latent_fit.h"
#include "materialgan/maps_sheet.h"

namespace lacquer::cmd {
namespace {

namespace fs = std::filesystem;
using materialgan::LatentSpace;
using materialgan::MaterialPrior;

constexpr const char* kSheetName = "sheet.png";
/// Materials on a sheet, which somebody is to look at.
constexpr size_t kMaxShown = 32, kMaxNote = 200;

std::string PathIn(const std::string& folder, const std::string& name) {
    return (fs::path(folder) / name).string();
}

/// At most kMaxShown of many, both ends among them.
std::vector<capture::Maps> Shown(const std::vector<capture::Maps>& all) {
    const size_t count = std::min(all.size(), kMaxShown);
    std::vector<capture::Maps> shown;
    for (size_t i = 0; i < count; ++i) shown.push_back(all[i * (all.size() - 1) / (count - 1)]);
    return shown;
}

LatentSpace SpaceOf(const std::string& name) {
    if (name == "w") return LatentSpace::W;
    if (name == "w+") return LatentSpace::WPlus;
    return name == "n" ? LatentSpace::Noise : LatentSpace::WPlusNoise;
}

}  // namespace

ExitStatus RunMaterials(const MaterialganArguments& a) {
    if ((a.resolution & (a.resolution - 1)) != 0)
        BadOption("resolution", fmt::to_string(a.resolution), "a power of two");
    MakeOutputFolder(a.out);
    std::vector<capture::Maps> materials;
    for (int i = 0; i < a.count; ++i) {
        const EvaluationCase known = EvaluationCaseOf(i, a.resolution, a.seed);
        WriteMapImages(known.truth, PathIn(a.out, fmt::format("{:04}-{}", i, known.family)));
        materials.push_back(known.truth);
    }
    WriteImage(materialgan::MapsSheet({materials}), PathIn(a.out, kSheetName));
    return ExitStatus::Complete;
}

ExitStatus RunSample(const MaterialganArguments& a) {
    CheckOutputFolder(a.out);
    const MaterialPrior prior(GeneratorPath(a.file));
    UseThreads(prior, a.threads);
    MakeOutputFolder(a.out);
    std::vector<capture::Maps> shown;
    prior.VisitSamples(a.count, a.psi, a.seed, [&](int i, const capture::Maps& maps) {
        WriteMapImages(maps, PathIn(a.out, fmt::format("{:04}", i)));
        if (shown.size() < kMaxShown) shown.push_back(maps);
    });
    WriteImage(materialgan::MapsSheet({shown}), PathIn(a.out, kSheetName));
    return ExitStatus::Complete;
}

ExitStatus RunProject(const MaterialganArguments& a) {
    CheckOutputFolder(a.out);
    std::error_code ignored;
    if (fs::equivalent(a.maps, a.out, ignored))
        throw FileError(a.out, "--out wants another folder than that of the maps");
    const capture::Maps maps = ReadMapImages(a.maps);
    const MaterialPrior prior(GeneratorPath(a.file));
    UseThreads(prior, a.threads);
    if (maps.size != prior.Config().resolution)
        throw FileError(a.maps,
                        fmt::format("has maps of {} x {} texels, and the generator makes {} x {}", maps.size,
                                    maps.size, prior.Config().resolution, prior.Config().resolution));
    MakeOutputFolder(a.out);
    Console console(ConsoleStyle::Detect(a.quiet));
    Console::CatchSignals();
    const materialgan::Projection projection =
        ProjectMaps(prior, maps, SpaceOf(a.space), a.iterations, &console);
    SaveLatents(projection.latents, prior, PathIn(a.out, kLatentName));
    WriteMapImages(projection.maps, a.out);
    WriteImage(materialgan::MapsSheet({{maps, projection.maps}}), PathIn(a.out, kSheetName));
    console.Info(fmt::format("{}: error {:.4f} of the maps' range", a.out, projection.rmse));
    return console.ShouldStop() ? Console::StatusOfSignal() : ExitStatus::Complete;
}

ExitStatus RunMorph(const MaterialganArguments& a) {
    CheckOutputFolder(a.out);
    const MaterialPrior prior(GeneratorPath(a.file));
    UseThreads(prior, a.threads);
    const auto from = materialgan::LoadLatents(PathIn(a.latentsA, kLatentName), prior),
               to = materialgan::LoadLatents(PathIn(a.latentsB, kLatentName), prior);
    MakeOutputFolder(a.out);
    const std::vector<capture::Maps> morph = prior.Morph(from, to, a.count);
    // Below them what a blend of the maps is.
    std::vector<capture::Maps> blend;
    for (size_t i = 0; i < morph.size(); ++i) {
        blend.push_back(
            materialgan::BlendMaps(morph.front(), morph.back(), double(i) / double(morph.size() - 1)));
        WriteMapImages(morph[i], PathIn(a.out, fmt::format("{:04}", i)));
    }
    WriteImage(materialgan::MapsSheet({Shown(morph), Shown(blend)}), PathIn(a.out, kSheetName));
    return ExitStatus::Complete;
}

ExitStatus RunInfo(const MaterialganArguments& a) {
    const MaterialPrior prior(GeneratorPath(a.file));
    UseThreads(prior, a.threads);
    const materialgan::GeneratorConfig& c = prior.Config();
    std::cout << fmt::format(
        "resolution       {} x {}\n"
        "feature maps     {} to {}\n"
        "styled layers    {}, with {} columns of w+\n"
        "latents          {} in z and w, {} layers between them\n"
        "parameters       {}\n"
        "encoder          {}\n",
        c.resolution, c.resolution, c.NumFeatureMaps(4), c.NumFeatureMaps(c.resolution), c.NumLayers(),
        c.NumColumns(), c.latentSize, c.mappingLayers, prior.NumParameters(),
        prior.HasEncoder() ? "yes" : "no");
    for (const auto& [key, value] : prior.Notes())
        std::cout << fmt::format("{:<16} {}\n", PrintableName(key.substr(0, kMaxNote)),
                                 PrintableName(value.substr(0, kMaxNote)));
    return ExitStatus::Complete;
}

}  // namespace lacquer::cmd
