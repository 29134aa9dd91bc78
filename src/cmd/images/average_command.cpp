// lacquer average and lacquer error: means of several images, and how far each is from a reference.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "compare/metrics.h"

namespace lacquer::cmd {
namespace {

namespace fs = std::filesystem;

bool IsSameFile(const fs::path& a, const fs::path& b) {
    std::error_code ignored;
    return a == b || fs::equivalent(a, b, ignored);
}

/// Files; one name that is no file stands for all whose names begin with it, as in imgtool.
/// @param result  is none of these: an earlier run may have written it
std::vector<std::string> ExpandNames(const std::vector<std::string>& names, const std::string& result) {
    std::error_code ignored;
    if (names.size() != 1 || fs::exists(names[0], ignored)) return names;
    const fs::path prefix(names[0]);
    const fs::path folder = prefix.has_parent_path() ? prefix.parent_path() : fs::path(".");
    std::vector<std::string> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
        if (entry.is_regular_file(ignored) && !IsSameFile(entry.path(), result) &&
            entry.path().filename().string().starts_with(prefix.filename().string()))
            found.push_back((prefix.has_parent_path() ? entry.path() : entry.path().filename()).string());
    std::sort(found.begin(), found.end());
    if (found.empty()) throw FileError(names[0], "no file has this name, and none begins with it");
    return found;
}

/// All of one size and with the same channels. Errors: FileError.
std::vector<Image> ReadAll(const std::vector<std::string>& paths) {
    std::vector<Image> images;
    for (const std::string& path : paths) {
        Image image = ReadImageArgument(path);
        if (!images.empty()) {
            std::string why = Mismatch(images[0], image);
            if (why.empty()) why = ChannelMismatch(images[0], image);
            if (!why.empty()) throw FileError(path, fmt::format("does not fit {}: {}", paths[0], why));
        }
        images.push_back(std::move(image));
    }
    return images;
}

// ---- average ----

struct AverageArguments {
    std::vector<std::string> images;
    std::string outfile;
    bool quiet = false;
};

void AddAverageOptions(CLI::App& app, AverageArguments& a) {
    AddImageList(app, a.images, "Images, or the beginning of their names");
    AddOutfile(app, a.outfile);
    app.add_flag("--quiet", a.quiet, "No information and no warnings");
}

ExitStatus RunAverage(const AverageArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    CheckImageOutput(a.outfile);
    const std::vector<std::string> paths = ExpandNames(a.images, a.outfile);
    const std::vector<Image> images = ReadAll(paths);
    Image result = images[0];
    for (int c = 0; c < result.NumChannels(); ++c) {
        std::vector<int> channels;
        for (const Image& image : images) channels.push_back(image.FindChannel(result.Channels()[size_t(c)]));
        for (int y = 0; y < result.Resolution().y; ++y)
            for (int x = 0; x < result.Resolution().x; ++x) {
                double sum = 0;
                for (size_t i = 0; i < images.size(); ++i) sum += double(images[i].Get({x, y}, channels[i]));
                result.Set({x, y}, c, float(sum / double(images.size())));
            }
    }
    WarnOfNonFinite(result, a.outfile, &console);
    WriteImage(result, a.outfile, result.format == PixelFormat::Half);
    console.Info(fmt::format("{}: the mean of {} images", a.outfile, images.size()));
    return ExitStatus::Complete;
}

constexpr const char* kAverageSynopsis =
    "The mean of several images, each with the same weight. Renders of one image with different samples are\n"
    "better put together by `lacquer merge`, which weighs them by their samples.";

// ---- error ----

struct ErrorArguments {
    std::vector<std::string> images;
    std::string reference, metric = "MSE", errorfile, crop;
    bool quiet = false;
};

void AddErrorOptions(CLI::App& app, ErrorArguments& a) {
    AddImageList(app, a.images, "Images, or the beginning of their names");
    app.add_option("--reference", a.reference, "What they should be")->type_name(kFile)->required();
    app.add_option("--metric", a.metric, "What is measured")
        ->check(OneOf(compare::MetricNames()))
        ->capture_default_str();
    app.add_option("--errorfile", a.errorfile, "An image of the mean error of each pixel")->type_name(kFile);
    app.add_option("--crop", a.crop, "x0,x1,y0,y1: only this part, in fractions or in pixels");
    app.add_flag("--quiet", a.quiet, "No information beside the result");
}

/// The part that --crop names.
Image Cropped(const Image& image, const std::string& crop) {
    if (crop.empty()) return image;
    return image.Part(BoxOfImage("--crop", crop, image).pixels, ChannelsOf(image, {}));
}

ExitStatus RunErrorOfSet(const ErrorArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    if (!a.errorfile.empty()) CheckImageOutput(a.errorfile);
    std::vector<std::string> paths = ExpandNames(a.images, a.errorfile);
    // A prefix may match it as well.
    std::erase_if(paths, [&](const std::string& path) { return IsSameFile(path, a.reference); });
    if (paths.empty()) throw CLI::ValidationError("there is no image beside the reference");
    const compare::Metric metric = *compare::ParseMetric(a.metric);
    const Image reference = Cropped(ReadImageArgument(a.reference), a.crop);
    Image errors;
    std::vector<double> means;
    for (const std::string& path : paths) {
        const Image image = Cropped(ReadImageArgument(path), a.crop);
        std::string why = Mismatch(reference, image);
        if (why.empty()) why = ChannelMismatch(reference, image);
        if (!why.empty()) throw FileError(path, fmt::format("does not fit {}: {}", a.reference, why));
        const Image map = compare::ErrorMap(image, reference, metric, reference.Channels());
        WarnOfNonFinite(image, path, &console);
        means.push_back(
            compare::MeanOfErrors(compare::ErrorOver(map, metric, {{0, 0}, map.Resolution()}), metric));
        if (errors.NumChannels() == 0) {
            errors = map;
        } else {
            for (size_t i = 0; i < errors.Pixels().size(); ++i) errors.Pixels()[i] += map.Pixels()[i];
        }
    }
    double mean = 0, squares = 0;
    for (const double m : means) mean += m / double(means.size());
    for (const double m : means) squares += (m - mean) * (m - mean);
    const double deviation = means.size() > 1 ? std::sqrt(squares / double(means.size() - 1)) : 0;
    if (!std::isfinite(mean)) console.Warn("the error is no number, since images have values that are none");
    fmt::print("{} {:.9g}\tstandard deviation {:.9g}\timages {}\n", a.metric, mean, deviation, means.size());
    if (!a.errorfile.empty()) {
        for (float& value : errors.Pixels()) value /= float(means.size());
        WriteImage(errors, a.errorfile);
    }
    return ExitStatus::Complete;
}

constexpr const char* kErrorSynopsis =
    "The mean error of a set of images against a reference, and how it varies from image to image.";

}  // namespace

LACQUER_REGISTER(CommandKind, "average", (CommandOf<AverageArguments, AddAverageOptions, RunAverage>::Make),
                 {.synopsis = kAverageSynopsis, .footer = kImageStatus});
LACQUER_REGISTER(CommandKind, "error", (CommandOf<ErrorArguments, AddErrorOptions, RunErrorOfSet>::Make),
                 {.synopsis = kErrorSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
