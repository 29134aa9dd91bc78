#include "cmd/images/image_arguments.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "cmd/choices.h"
#include "cmd/command_support.h"
#include "compare/metrics.h"
#include "pbrt/core/error.h"
#include "pbrt/image/operations.h"

namespace lacquer::cmd {
namespace {

std::string WindowText(const Image& image) {
    const Bounds2i w = image.Window();
    const Int2 full = image.FrameResolution();
    return fmt::format("x {}..{}, y {}..{} of {} x {}", w.min.x, w.max.x, w.min.y, w.max.y, full.x, full.y);
}

std::vector<std::string> SortedChannels(const Image& image, const std::string& ignored) {
    std::vector<std::string> channels = image.Channels();
    std::erase(channels, ignored);
    std::sort(channels.begin(), channels.end());
    return channels;
}

}  // namespace

Image ReadImageArgument(const std::string& path, ColorEncoding encoding) {
    try {
        return ReadImage(path, encoding, {});
    } catch (const SceneError& e) {
        // A reader of textures blames the scene; here it is the file that the user named.
        const std::string prefix = path + ": ";
        const std::string& message = e.Message();
        throw FileError(path, message.starts_with(prefix) ? message.substr(prefix.size()) : message);
    }
}

void AddImage(CLI::App& app, std::string& path) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("image", path, "The image to read")->type_name(kFile)->required();
}

void AddImageList(CLI::App& app, std::vector<std::string>& paths, const char* description) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("images", paths, description)
        ->type_name(kFile)
        ->required()
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void AddOutfile(CLI::App& app, std::string& path) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("--outfile", path, "Image to write; the extension chooses the format")
        ->type_name(kFile)
        ->required();
}

void CheckDifferent(const char* option, const std::string& path, const std::string& outfile) {
    if (path.empty()) return;
    std::error_code error;
    const auto whole = [&](const std::string& p) {
        return std::filesystem::weakly_canonical(std::filesystem::absolute(p), error);
    };
    if (whole(path) == whole(outfile))
        throw CLI::ValidationError(
            fmt::format("{} \"{}\": expected another file than --outfile", option, Excerpt(path)));
}

void AddChannels(CLI::App& app, std::vector<std::string>& names) {
    app.add_option("--channels", names, "Only these channels, with commas between; default: all")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

std::vector<int> ChannelsOf(const Image& image, const std::vector<std::string>& names) {
    std::vector<int> channels;
    for (const std::string& name : names) {
        CheckName("--channels", name, image.Channels());
        channels.push_back(image.FindChannel(name));
        if (std::count(channels.begin(), channels.end(), channels.back()) > 1)
            BadOption("channels", fmt::format("{}", fmt::join(names, ",")),
                      fmt::format("each channel once, and {} is there twice", name));
    }
    for (int c = 0; names.empty() && c < image.NumChannels(); ++c) channels.push_back(c);
    return channels;
}

void RequireColors(const Image& image, const std::string& path) {
    if (ColorChannels(image).empty())
        throw FileError(path, fmt::format("has no colours, only {}", fmt::join(image.Channels(), ", ")));
}

bool HoldsBytes(const std::string& path) {
    const std::string extension = ExtensionOf(path);
    for (const char* floats : {"exr", "tif", "tiff", "pfm", "hdr"})
        if (extension == floats) return false;
    return true;
}

compare::Box BoxOfImage(const char* option, const std::string& text, const Image& image) {
    try {
        compare::Box box = compare::ParseBox(text, image.FrameResolution());
        const Bounds2i window = image.Window();
        box.pixels = box.pixels.Intersect(window);
        if (box.pixels.IsEmpty())
            throw std::invalid_argument(
                fmt::format("box \"{}\": the image holds no pixel of it, only {}", text, WindowText(image)));
        box.pixels.min -= window.min;
        box.pixels.max -= window.min;
        return box;
    } catch (const std::invalid_argument& e) {
        throw CLI::ValidationError(fmt::format("{}: {}", option, e.what()));
    }
}

std::string Mismatch(const Image& first, const Image& second) {
    const Int2 a = first.Resolution(), b = second.Resolution();
    if (a != b) return fmt::format("it has {} x {} pixels, not {} x {}", b.x, b.y, a.x, a.y);
    if (first.Window() != second.Window() || first.FrameResolution() != second.FrameResolution())
        return fmt::format("it shows another part of the image: {}, not {}", WindowText(second),
                           WindowText(first));
    if (first.HasRGB() && second.HasRGB() && first.ColorSpace() != second.ColorSpace())
        return fmt::format("its colours are in {}, not in {} (lacquer convert --colorspace changes that)",
                           second.ColorSpace()->Name(), first.ColorSpace()->Name());
    return {};
}

std::string ChannelMismatch(const Image& first, const Image& second, const std::string& ignored) {
    if (SortedChannels(first, ignored) == SortedChannels(second, ignored)) return {};
    return fmt::format("it has the channels {}, not {}", fmt::join(second.Channels(), ", "),
                       fmt::join(first.Channels(), ", "));
}

void WarnOfNonFinite(const Image& image, const std::string& name, Observer* observer) {
    const compare::NonFinite found = compare::FindNonFinite(image, image.Channels());
    if (!found.Any()) return;
    const Int2 place = found.pixel + image.Window().min;
    observer->Warn(fmt::format("{}: {} values are NaN and {} infinite; the first is {} at x {}, y {}", name,
                               found.nan, found.inf, found.channel, place.x, place.y));
}

std::optional<int> IntMetadata(const Image& image, const std::string& name) {
    const auto it = image.metadata.find(name);
    if (it == image.metadata.end()) return {};
    const int* value = std::get_if<int>(&it->second);
    return value ? std::optional(*value) : std::nullopt;
}

}  // namespace lacquer::cmd
