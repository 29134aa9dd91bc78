// The command line of `lacquer compare`.
#include <fmt/format.h>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/compare/candidates.h"
#include "cmd/compare/compare_command.h"

namespace lacquer::cmd {

namespace {

/// `--estimators A,B,...` and its like.
CLI::Option* AddList(CLI::App& app, const char* option, std::vector<std::string>& names,
                     compare::Subject subject, const std::string& help) {
    return app.add_option(option, names, help)
        ->type_name("A,B,...")
        ->check(IsCandidate(subject))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void AddLists(CLI::App& app, CompareArguments& a) {
    using enum compare::Subject;
    CLI::Option* lists[] = {
        AddList(
            app, "--estimators", a.estimators, Estimators,
            "Estimators of the layered materials, with commas between; NAME/PDF chooses the density as well")
            ->capture_default_str(),
        AddList(app, "--integrators", a.integrators, Integrators,
                "Compares integrators instead of estimators"),
        AddList(app, "--samplers", a.samplers, Samplers, "Compares samplers instead of estimators"),
        AddList(app, "--light-samplers", a.lightSamplers, LightSamplers,
                "Compares light samplers of the integrator instead of estimators"),
        AddList(app, "--denoisers", a.denoisers, Denoisers,
                "Compares denoisers instead of estimators, and what they take; none: the image as it is")};
    for (CLI::Option* one : lists)
        for (CLI::Option* other : lists)
            if (one != other) one->excludes(other);
}

}  // namespace

void AddCompareOptions(CLI::App& app, CompareArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("scene", a.scenes, "Scene files, read one after another as one scene (-: standard input)")
        ->type_name(kFile)
        ->required()
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--out", a.out, "Folder for the report and the images; made if it is not there")
        ->type_name(kFolder)
        ->required();
    AddLists(app, a);
    app.add_option("--baseline", a.baseline,
                   "The one of them that others are compared with; default: the first");
    CLI::Option* time =
        app.add_option("--time", a.time, "Seconds of each render, without loading")->capture_default_str();
    app.add_option("--equal-samples", a.equalSamples, "Samples per pixel of each render, instead of a time")
        ->check(CLI::Range(1, 1 << 24))
        ->excludes(time);
    app.add_option("--runs", a.runs, "Renders of each of them")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    app.add_option("--reference", a.reference,
                   "Image to measure against; default: one is rendered, and kept in FOLDER")
        ->type_name(kFile);
    CLI::Option* spp = app.add_option("--reference-spp", a.referenceSpp, "Samples per pixel of the reference")
                           ->check(CLI::Range(16, 1 << 24));
    app.add_option("--reference-time", a.referenceTime,
                   "Seconds for the reference; default: 16 times that of a run")
        ->excludes(spp);
    app.add_option("--reference-by,--reference-estimator", a.referenceBy,
                   "What renders the reference, of the kind that is compared; default: estimator halfvector, "
                   "integrator volpath, the scene's sampler or light sampler; never denoised")
        ->type_name("NAME");
    app.add_option(
           "--box", a.boxes,
           "NAME:x0,x1,y0,y1: part of the image, in pixels or as fractions; default: the scene's own, from "
           "its comments \"# box\"")
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option(
        "--vary", a.vary,
        "MATERIAL.PARAMETER=A,B,... (or camera, light@1, ... for a material): repeats all for each value");
    app.add_option("--resolution", a.resolution, "WxH, instead of the scene's");
    app.add_option("--seed", a.seed, "First seed; every render has its own")->check(CLI::Range(0, 1 << 30));
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No progress and no warnings");
}

namespace {

constexpr const char* kCompareSynopsis =
    "Compares estimators of layered materials, integrators, samplers, light samplers or denoisers at equal\n"
    "time, and makes a report to look at.\n"
    "Usage: lacquer compare [OPTIONS] scene.pbrt ... --out DIR";
constexpr const char* kCompareFooter = R"(
Exit status: 0 the report is written; 1 wrong usage; 2 the scene is wrong; 3 a file cannot be read or
written; 129, 130 or 143 stopped by a signal (the report holds what was finished).)";

}  // namespace

LACQUER_REGISTER(CommandKind, "compare", (CommandOf<CompareArguments, AddCompareOptions, RunCompare>::Make),
                 {.synopsis = kCompareSynopsis, .footer = kCompareFooter});

}  // namespace lacquer::cmd
