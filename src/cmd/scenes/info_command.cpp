// lacquer info: what images and scenes hold.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "cmd/printable.h"
#include "cmd/render/state_info.h"
#include "cmd/report_error.h"
#include "cmd/scenes/scene_info.h"
#include "pbrt/film/state_file.h"

namespace lacquer::cmd {
namespace {

/// Everything that the command line of `info` can say.
struct InfoArguments {
    std::vector<std::string> files;
    bool json = false;
};

using nlohmann::json;

/// What the values of one channel are like. Least, greatest and mean are those of the finite values.
struct ChannelSummary {
    std::string name;
    double min = std::numeric_limits<double>::infinity(), max = -min, sum = 0;
    int64_t finite = 0, nan = 0, inf = 0;
    double Mean() const { return sum / double(finite); }
};

std::vector<ChannelSummary> Summarize(const Image& image) {
    std::vector<ChannelSummary> summaries(size_t(image.NumChannels()));
    for (size_t c = 0; c < summaries.size(); ++c) summaries[c].name = image.Channels()[c];
    for (size_t i = 0; i < image.Pixels().size(); ++i) {
        ChannelSummary& s = summaries[i % summaries.size()];
        const auto value = double(image.Pixels()[i]);
        if (std::isnan(value)) {
            ++s.nan;
        } else if (std::isinf(value)) {
            ++s.inf;
        } else {
            s.min = std::min(s.min, value);
            s.max = std::max(s.max, value);
            s.sum += value;
            ++s.finite;
        }
    }
    return summaries;
}

const char* FormatName(const Image& image) {
    switch (image.format) {
        case PixelFormat::Byte:
            return "8-bit";
        case PixelFormat::Half:
            return "16-bit";
        case PixelFormat::Float:
            break;
    }
    return "32-bit";
}

/// With no more digits than the float has: 0.64 rather than 0.639999986.
json ToJson(float value) {
    return std::isfinite(value) ? json(std::stod(fmt::format("{}", value))) : json(fmt::format("{}", value));
}

/// Rows of a matrix that acts on column vectors.
json ToJson(const glm::mat4& m) {
    json rows = json::array();
    for (int row = 0; row < 4; ++row) {
        rows.push_back(json::array());
        for (int column = 0; column < 4; ++column) rows.back().push_back(ToJson(m[column][row]));
    }
    return rows;
}

json ToJson(const MetadataValue& value) {
    if (const auto* matrix = std::get_if<glm::mat4>(&value)) return ToJson(*matrix);
    if (const auto* number = std::get_if<int>(&value)) return *number;
    if (const auto* number = std::get_if<float>(&value)) return ToJson(*number);
    if (const auto* text = std::get_if<std::string>(&value)) return *text;
    json numbers = json::array();
    for (const float number : std::get<std::vector<float>>(value)) numbers.push_back(ToJson(number));
    return numbers;
}

json ToJson(const std::string& path, const Image& image) {
    const Bounds2i window = image.Window();
    json channels = json::array();
    for (const ChannelSummary& s : Summarize(image)) {
        const bool any = s.finite > 0;
        channels.push_back({{"name", s.name},
                            {"min", any ? json(s.min) : json()},
                            {"max", any ? json(s.max) : json()},
                            {"mean", any ? json(s.Mean()) : json()},
                            {"nan", s.nan},
                            {"inf", s.inf}});
    }
    json metadata = json::object();
    for (const auto& [name, value] : image.metadata) metadata[name] = ToJson(value);
    return {{"kind", "image"},
            {"file", path},
            {"resolution", {image.Resolution().x, image.Resolution().y}},
            {"data_window",
             {{"x0", window.min.x}, {"x1", window.max.x}, {"y0", window.min.y}, {"y1", window.max.y}}},
            {"full_resolution", {image.FrameResolution().x, image.FrameResolution().y}},
            {"format", FormatName(image)},
            {"color_space", image.HasRGB() ? json(image.ColorSpace()->Name()) : json()},
            {"channels", channels},
            {"metadata", metadata}};
}

std::string ToText(const std::string& path, const Image& image) {
    const Bounds2i window = image.Window();
    const Int2 full = image.FrameResolution();
    std::string text =
        fmt::format("{}: {} x {} pixels, {} channels, {}\n", PrintableName(path), image.Resolution().x,
                    image.Resolution().y, image.NumChannels(), FormatName(image));
    text += fmt::format("  data window: x {}..{}, y {}..{} of {} x {}\n", window.min.x, window.max.x,
                        window.min.y, window.max.y, full.x, full.y);
    if (image.HasRGB()) text += fmt::format("  colour space: {}\n", image.ColorSpace()->Name());
    text += fmt::format("  {:<14}{:>14}{:>14}{:>14}{:>10}{:>10}\n", "channel", "min", "max", "mean", "NaN",
                        "infinite");
    for (const ChannelSummary& s : Summarize(image)) {
        const auto number = [&](double v) { return s.finite > 0 ? fmt::format("{:.6g}", v) : "-"; };
        text += fmt::format("  {:<14}{:>14}{:>14}{:>14}{:>10}{:>10}\n", PrintableName(s.name), number(s.min),
                            number(s.max), number(s.Mean()), s.nan, s.inf);
    }
    for (const auto& [name, value] : image.metadata) {
        const auto* string = std::get_if<std::string>(&value);
        text += fmt::format("  {}: {}\n", PrintableName(name),
                            string ? PrintableName(*string) : JsonText(ToJson(value)));
    }
    return text;
}

bool IsScene(const std::string& path) { return path == "-" || IsSceneName(path); }

void AddInfoOptions(CLI::App& app, InfoArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option(
           "files", a.files,
           "Images, states, and scene files (.pbrt, .pbrt.gz; -: standard input), which make one scene")
        ->type_name(kFile)
        ->required()
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_flag("--json", a.json,
                 "An array of one JSON object for each image and state, and one for the scene");
}

ExitStatus RunInfo(const InfoArguments& arguments) {
    Console console(ConsoleStyle::Detect(false));
    ExitStatus status = ExitStatus::Complete;
    json all = json::array();
    const auto describe = [&](const auto& read, const auto& toJson, const auto& toText) {
        try {
            const auto content = read();
            if (arguments.json)
                all.push_back(toJson(content));
            else
                fmt::print("{}", Printable(toText(content)));
        } catch (const CLI::ValidationError&) {
            throw;
        } catch (const std::exception&) {
            status = ReportError(console);
        }
    };
    std::vector<std::string> scenes;
    for (const std::string& path : arguments.files)
        if (IsScene(path))
            scenes.push_back(path);
        else if (IsStateFile(path))
            describe([&] { return ReadStateInfo(path); }, StateInfoJson, StateInfoText);
        else
            describe([&] { return ReadImageArgument(path); },
                     [&](const Image& image) { return ToJson(path, image); },
                     [&](const Image& image) { return ToText(path, image); });
    if (!scenes.empty())
        describe([&] { return SurveyScene(ReadSceneArguments(scenes)); }, SceneInfoJson, SceneInfoText);
    if (arguments.json) fmt::print("{}\n", JsonText(all, 2));
    return status;
}

constexpr const char* kInfoSynopsis =
    "Tells what images hold: size, channels with their ranges, metadata. Values are linear. Tells what a "
    "scene\n"
    "holds, without rendering it: image, counts, materials, textures, memory, files, and what looks wrong; "
    "and\n"
    "what states of renders hold: which samples of which pixels, and whether they are damaged.";
constexpr const char* kInfoFooter = R"(
Exit status: 0 all is told; 1 wrong usage; 2 the scene is wrong; 3 a file cannot be read.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "info", (CommandOf<InfoArguments, AddInfoOptions, RunInfo>::Make),
                 {.synopsis = kInfoSynopsis, .footer = kInfoFooter});

}  // namespace lacquer::cmd
