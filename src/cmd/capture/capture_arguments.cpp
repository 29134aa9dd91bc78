#include "cmd/capture/capture_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cmd/choices.h"
#include "cmd/command_support.h"

namespace lacquer::cmd {
namespace {

constexpr int kDefaultResolution = 256;
constexpr const char* kLightExpected = "auto, one number above 0, or three with commas between";
constexpr double kMaxFlash = 1000;  // [cm]
constexpr const char* kFlashExpected = "three numbers with commas between, as 1.5,0,0";

void RefuseBoth(bool first, bool second, const std::string& what) {
    if (first && second) throw CLI::ValidationError(what);
}

void AddPhotographOptions(CLI::App& app, CaptureArguments& a) {
    app.add_option(
           "photos", a.photos,
           "Photographs with the card in them, or folders of such: by one camera, zoom and focus fixed")
        ->type_name(kFile)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--out", a.out, "Folder for maps, material and report; it is made if need be")
        ->type_name(kFolder);
    app.add_option("--card", a.card,
                   "Write the card, as a drawing to be printed at 100 %, and do nothing else")
        ->type_name(kFile);
    app.add_option("--size", a.size, "Outer edge of the printed square of tags [cm]; default: 17")
        ->check(CLI::Range(1., 500.));
    app.add_option("--depth", a.depth, "How far the sample lies below the card [cm]; default: 0.1")
        ->check(CLI::Range(0., 10.));
    app.add_option("--focal", a.focal, "Focal length [pixels]; default: found, or of the files' metadata")
        ->check(Positive());
    app.add_option("--flash", a.flash,
                   "X,Y,Z of the light from the camera [cm]: to the right, up, ahead; default: 0,0,0");
    app.add_option("--response", a.response, "How values of the files stand for light; default: gamma2.2")
        ->check(OneOf({"gamma2.2", "srgb", "linear"}));
    app.add_option("--views", a.views,
                   "views.json of photographs that are rectified already, instead of photographs of a card")
        ->type_name(kFile);
    app.add_option("--hold-out", a.holdOut,
                   "Photographs that are not fitted but judge the result, from among those given")
        ->check(CLI::Range(0, 1000));
}

void AddFitOptions(CLI::App& app, CaptureArguments& a) {
    app.add_option("--resolution", a.resolution,
                   "Texels along an edge while fitting; default: 256, or those of the generator")
        ->check(CLI::Range(16, 4096));
    app.add_option("--final-resolution", a.finalResolution,
                   "The same of the maps, --resolution times a power of two; default: as fitted, but with a "
                   "generator "
                   "256 at least")
        ->check(CLI::Range(16, 8192));
    app.add_option("--iterations", a.iterations, "Steps of the fit")->check(CLI::Range(1, 1000000));
    app.add_option("--refine", a.refine, "Steps after each doubling of the resolution")
        ->check(CLI::Range(0, 100000));
    app.add_option("--total-variation", a.totalVariation,
                   "How much neighbouring texels are drawn together; 0: not at all")
        ->check(CLI::Range(0., 1e3));
    app.add_option("--light", a.light,
                   "Power of the light [cm^2]: a number, R,G,B, or auto to find it; default: 1500, or what "
                   "views.json says");
    app.add_option("--frames", a.numFrames,
                   "Also turntable.0001.pbrt and so on, for a film in which all that is shown turns once")
        ->check(CLI::Range(0, 9999));
    app.add_option("--as", a.as, "What the material is in scenes: the model itself, or made of others")
        ->check(OneOf({"svbrdf", "mix", "coated"}));
}

void AddPriorOptions(CLI::App& app, PriorArguments& a) {
    CLI::Option* prior =
        app.add_option("--prior", a.file,
                       "A generator of materials, among whose maps those of the sample are sought first; "
                       "shipped: the one that comes with Lacquer; none: each texel by itself")
            ->type_name(kFile);
    app.add_option("--prior-iterations", a.iterations, "Steps of the fit among those")
        ->check(CLI::Range(1, 1000000))
        ->needs(prior);
    app.add_option(
           "--prior-weight", a.weight,
           "How much likely latents are preferred; 0: not at all; default: by the number of photographs")
        ->check(CLI::Range(0., 1e3))
        ->needs(prior);
    for (CLI::Option* option : AddLatentMoves(app, a)) option->needs(prior);
    app.add_flag("--trust-prior", a.trust,
                 "Keep the generator's maps even where it cannot explain the photographs")
        ->needs(prior);
}

}  // namespace

std::vector<CLI::Option*> AddLatentMoves(CLI::App& app, PriorArguments& a) {
    return {
        app.add_option(
               "--strategy", a.strategy,
               "Latents that move: 1, styles and then noise; 2, both at once; 3, in turns of ten steps")
            ->check(CLI::Range(1, 3)),
        app.add_option("--optimizer", a.optimizer, "Adam, or the sign of the gradient as was published")
            ->check(OneOf({"adam", "sign"})),
        app.add_option("--features", a.features,
                       "What photographs are compared by besides their pixels: none, steerable, or a file "
                       "with the weights of VGG-19 (safetensors)")
            ->type_name(kFile),
        app.add_option(
               "--start", a.start,
               "What the encoder makes of a fit of texels, the better of two published starts, or both to "
               "the end; default: the encoder, if the generator has one")
            ->check(OneOf({"encoder", "two", "full"})),
    };
}

void AddCaptureOptions(CLI::App& app, CaptureArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    AddPhotographOptions(app, a);
    AddFitOptions(app, a);
    AddPriorOptions(app, a.prior);
    app.add_flag("--resume", a.resume,
                 "Go on where a run with the same options was stopped, from DIR/checkpoint.safetensors");
    app.add_option("--time-limit", a.timeLimit, "Stop after so many seconds, and write what there is")
        ->check(Positive());
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No progress and no warnings");
}

void CheckCaptureArguments(const CaptureArguments& a) {
    if (a.out.empty()) throw CLI::ValidationError("--out is required: the folder for the maps");
    if (a.photos.empty() == a.views.empty())
        throw CLI::ValidationError(a.photos.empty()
                                       ? "photographs are required, or --views with rectified ones"
                                       : "--views is instead of photographs of a card; both are given");
    for (const std::string& photo : a.photos)
        if (photo.empty()) throw CLI::ValidationError("a photograph has no name: \"\"");
    RefuseBoth(!a.views.empty(), a.focal.has_value(),
               "--focal has no effect with --views, which has cameras");
    RefuseBoth(!a.views.empty(), !a.flash.empty(), "--flash has no effect with --views, which has lights");
    RefuseBoth(!a.views.empty(), !a.response.empty(), "--response has no effect with --views, which has one");
    RefuseBoth(!a.views.empty(), a.size || a.depth,
               "--size and --depth are of a card and have no effect with --views");
    if (a.CardDepth() >= a.CardSize())
        BadOption("depth", fmt::to_string(a.CardDepth()), "less than the size of the card");
    LightPowerOf(a);
    FlashOf(a);
    if (!a.prior.IsGiven()) SizesOf(a);
}

CaptureSizes SizesOf(const CaptureArguments& a, int generatorSize) {
    if (generatorSize > 0 && a.resolution && *a.resolution != generatorSize)
        BadOption("resolution", fmt::to_string(*a.resolution),
                  fmt::format("{}, which is the generator's", generatorSize));
    const int first = generatorSize > 0 ? generatorSize : a.resolution.value_or(kDefaultResolution);
    const int last =
        a.finalResolution.value_or(generatorSize > 0 ? std::max(first, kDefaultResolution) : first);
    int reached = first;
    while (reached < last) reached *= 2;
    if (reached != last)
        BadOption("final-resolution", fmt::to_string(last),
                  fmt::format("{} times a power of two, such as {}", first, reached));
    return {first, last};
}

capture::Response ResponseOf(const CaptureArguments& a) {
    if (a.response == "srgb") return capture::Response::SRGB;
    return a.response == "linear" ? capture::Response::Linear : capture::Response::Gamma22;
}

capture::ExportAs ExportOf(const CaptureArguments& a) {
    if (a.as == "mix") return capture::ExportAs::Mix;
    return a.as == "coated" ? capture::ExportAs::Coated : capture::ExportAs::Svbrdf;
}

bool FitsLight(const CaptureArguments& a) { return a.light == "auto"; }

std::optional<std::array<double, 3>> LightPowerOf(const CaptureArguments& a) {
    if (a.light.empty() || FitsLight(a)) return {};
    const std::vector<double> n = NumbersBetweenCommas(a.light);
    if (n.size() != 1 && n.size() != 3) BadOption("light", a.light, kLightExpected);
    for (const double value : n) {
        if (!(value > 0)) BadOption("light", a.light, kLightExpected);
        if (value > capture::kMaxLightPower || value < 1 / capture::kMaxLightPower)
            BadOption("light", a.light,
                      fmt::format("powers from {:g} to {:g} cm^2", 1 / capture::kMaxLightPower,
                                  capture::kMaxLightPower));
    }
    return n.size() == 1 ? std::array{n[0], n[0], n[0]} : std::array{n[0], n[1], n[2]};
}

std::array<double, 3> FlashOf(const CaptureArguments& a) {
    if (a.flash.empty()) return {};
    const std::vector<double> n = NumbersBetweenCommas(a.flash);
    if (n.size() != 3) BadOption("flash", a.flash, kFlashExpected);
    for (const double x : n)
        if (std::abs(x) > kMaxFlash)
            BadOption("flash", a.flash, fmt::format("a light within {:g} cm of the camera", kMaxFlash));
    return {n[0], n[1], n[2]};
}

}  // namespace lacquer::cmd
