#include "cmd/render/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/render/render_job.h"
#include "cmd/report_error.h"
#include "cmd/version.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/json_reader.h"
#include "pbrt/scene/asset_cache.h"

namespace lacquer::cmd {
namespace {

using nlohmann::ordered_json;
constexpr int kMaxFrames = 1 << 20;

std::vector<std::string> Split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
    return parts;
}

/// "7", "1-5" or "1-9x2".
struct FrameRange {
    int first = 0, last = 0, step = 1;
};
std::optional<FrameRange> ParseRange(const std::string& text) {
    std::istringstream in(text);
    FrameRange range;
    if (!std::isdigit((unsigned char)in.peek()) || !(in >> range.first)) return {};
    range.last = range.first;
    char c = 0;
    if (in.peek() == '-' && !(in >> c >> range.last)) return {};
    if (in.peek() == 'x' && !(in >> c >> range.step)) return {};
    const bool isWhole = in.peek() == std::char_traits<char>::eof();
    if (!isWhole || range.step < 1 || range.last < range.first) return {};
    return range;
}

bool HasFrame(const std::string& name) { return name.find('#') != std::string::npos; }

/// A number, or several with blanks between.
std::vector<double> Numbers(const std::string& text) {
    std::istringstream in(text);
    std::vector<double> numbers;
    double number = 0;
    while (in >> number) numbers.push_back(number);
    return in.eof() ? numbers : std::vector<double>();
}

/// "FROM:TO" for each of so many frames; empty if it is no such thing.
std::vector<std::string> Between(const std::string& text, size_t count) {
    const size_t colon = text.find(':');
    if (colon == std::string::npos) return {};
    const std::vector<double> from = Numbers(text.substr(0, colon)), to = Numbers(text.substr(colon + 1));
    if (from.empty() || from.size() != to.size()) return {};
    std::vector<std::string> values;
    for (size_t i = 0; i < count; ++i) {
        const double t = count > 1 ? double(i) / double(count - 1) : 0;
        std::string value;
        for (size_t k = 0; k < from.size(); ++k)
            value += fmt::format("{}{:.9g}", k > 0 ? " " : "", (1 - t) * from[k] + t * to[k]);
        values.push_back(value);
    }
    return values;
}

/// What --vary sets, with a value for each frame.
compare::Variation VariationOf(const std::string& text, size_t numFrames) {
    try {
        compare::Variation variation = compare::ParseVariation(text);
        if (variation.values.size() == 1)
            if (const auto values = Between(variation.values[0], numFrames); !values.empty())
                variation.values = values;
        if (variation.values.size() == numFrames) return variation;
        throw std::invalid_argument(fmt::format("{} values for {} frames; expected one for each, or FROM:TO",
                                                variation.values.size(), numFrames));
    } catch (const std::invalid_argument& e) {
        throw CLI::ValidationError(fmt::format("--vary {}: {}", Excerpt(text), e.what()));
    }
}

/// What is written must have the frame's number in its name, or the last frame would be all that is left.
void CheckNames(const RenderArguments& a) {
    const SceneOptions& options = a.options.Values();
    const std::pair<const char*, const std::string&> outputs[] = {
        {"outfile", a.outfile},  {"checkpoint", a.checkpoint},
        {"resume", a.resume},    {"stats-json", a.statsJson},
        {"log-file", a.logFile}, {"mse-reference-out", options.mseReferenceOut}};
    for (const auto& [option, name] : outputs)
        if (!HasFrame(name) && !name.empty() && name != "-")
            BadOption(option, name, "# in place of the frame's number, as in image.####.exr");
    if (a.outfile.empty())
        throw CLI::ValidationError("--frames needs --outfile, with # in place of the frame's number");
    if (a.vary.empty() && std::none_of(a.scenes.begin(), a.scenes.end(), HasFrame))
        throw CLI::ValidationError(
            "--frames: all frames would be the same; expected # in the name of a scene file, or --vary");
    if (a.restart && a.summary.empty())
        throw CLI::ValidationError("--restart needs the --summary that says which frames are complete");
}

/// The file that tells how each frame ended.
class Summary {
  public:
    /// @param restarts  goes on from what is there
    Summary(const std::string& path, bool restarts) : path_(path) {
        std::error_code error;
        if (path.empty()) return;
        CheckOutputFile(path);
        if (restarts && std::filesystem::exists(path, error)) Read();
    }

    /// True for a frame that was complete, and whose image is still there.
    bool IsComplete(int frame, const std::string& image) const {
        std::error_code error;
        const auto entry = frames_.find(frame);
        return entry != frames_.end() && entry->second["status"] == int(ExitStatus::Complete) &&
               entry->second["image"] == image && std::filesystem::exists(image, error);
    }
    void Add(int frame, const std::string& image, ExitStatus status, double took) {
        frames_[frame] = {{"frame", frame}, {"image", image}, {"status", int(status)}, {"seconds", took}};
        if (path_.empty()) return;
        ordered_json all = ordered_json::array();
        for (const auto& [number, entry] : frames_) all.push_back(entry);
        WriteText(path_,
                  JsonText({{"software", fmt::format("Lacquer {}", kVersion)}, {"frames", all}}, 1) + "\n");
    }

  private:
    void Read() {
        const FileBytes bytes = ReadFileBytes(path_, {}, {.maxBytes = size_t(1) << 30});
        const JsonReader json(bytes.View(), path_, "the summary of a sequence of frames");
        for (size_t i = 0; i < json.At("/frames").size(); ++i) {
            const std::string entry = fmt::format("/frames/{}", i);
            const ordered_json& image = json.At(entry + "/image");
            if (!image.is_string()) json.Fail(entry + "/image", "expected the name of an image");
            const int frame = int(json.Number(entry + "/frame", 0, 1e9));
            frames_[frame] = {{"frame", frame},
                              {"image", image},
                              {"status", int(json.Number(entry + "/status", 0, 255))},
                              {"seconds", json.Number(entry + "/seconds", 0, 1e12)}};
        }
    }

    std::string path_;
    std::map<int, ordered_json> frames_;
};

}  // namespace

std::vector<int> ParseFrames(const std::string& text) {
    std::vector<int> frames;
    for (const std::string& part : Split(text, ',')) {
        const auto range = ParseRange(part);
        if (!range) BadOption("frames", text, "frames from 0 on, as in 1-5,8,10-20x5");
        if ((range->last - range->first) / range->step + int(frames.size()) >= kMaxFrames)
            BadOption("frames", text, fmt::format("at most {} frames", kMaxFrames));
        for (int64_t frame = range->first; frame <= range->last; frame += range->step)
            frames.push_back(int(frame));
    }
    if (frames.empty()) BadOption("frames", text, "frames from 0 on, as in 1-5,8,10-20x5");
    if (std::set<int>(frames.begin(), frames.end()).size() != frames.size())
        BadOption("frames", text, "each frame once");
    return frames;
}

std::string WithFrame(const std::string& name, int frame) {
    const size_t begin = name.find('#');
    if (begin == std::string::npos) return name;
    size_t end = name.find_first_not_of('#', begin);
    if (end == std::string::npos) end = name.size();
    if (name.find('#', end) != std::string::npos)
        throw CLI::ValidationError(
            fmt::format("\"{}\": expected one number of the frame, as in image.####.exr", Excerpt(name)));
    return name.substr(0, begin) + fmt::format("{:0{}}", frame, end - begin) + name.substr(end);
}

std::vector<RenderArguments> ArgumentsOfFrames(const RenderArguments& a) {
    const std::vector<int> frames = ParseFrames(a.frames);
    CheckNames(a);
    std::vector<compare::Variation> variations;
    for (const std::string& text : a.vary) variations.push_back(VariationOf(text, frames.size()));
    std::vector<RenderArguments> all;
    for (size_t i = 0; i < frames.size(); ++i) {
        RenderArguments& one = all.emplace_back(a);
        for (std::string& scene : one.scenes) scene = WithFrame(scene, frames[i]);
        for (std::string* name : {&one.outfile, &one.checkpoint, &one.resume, &one.statsJson, &one.logFile})
            *name = WithFrame(*name, frames[i]);
        for (const auto field : {&SceneOptions::mseReferenceImage, &SceneOptions::mseReferenceOut})
            if (const std::string& name = a.options.Values().*field; !name.empty())
                one.options.Set(field, WithFrame(name, frames[i]));
        for (const compare::Variation& v : variations)
            one.settings.push_back({v.target, {v.values[i]}, v.defaultType});
    }
    return all;
}

ExitStatus RunSequence(const RenderArguments& a) {
    const std::vector<int> frames = ParseFrames(a.frames);
    std::vector<RenderArguments> all = ArgumentsOfFrames(a);
    if (a.sandbox.isOn) EnterSandboxOf(all, a.summary);
    Console console(ConsoleStyle::Detect(a.quiet));
    Summary summary(a.summary, a.restart);
    const auto assets = std::make_shared<AssetCache>(BuildOptionsOf(all[0]).textures, &console);
    ExitStatus worst = ExitStatus::Complete;
    for (size_t i = 0; i < frames.size() && Console::Signal() == 0; ++i) {
        RenderArguments& one = all[i];
        if (a.restart && summary.IsComplete(frames[i], one.outfile)) continue;
        console.Info(fmt::format("frame {} ({} of {})", frames[i], i + 1, frames.size()));
        std::error_code error;
        if (a.restart && one.resume.empty() && std::filesystem::exists(one.checkpoint, error))
            one.resume = one.checkpoint;
        const Clock::time_point start = Clock::now();
        ExitStatus status = ExitStatus::Complete;
        try {
            status = RunRenderJob(one, assets);
        } catch (const std::exception&) {
            status = ReportError(console);
        }
        summary.Add(frames[i], one.outfile, status, SecondsSince(start));
        if (worst == ExitStatus::Complete) worst = status;
    }
    return Console::Signal() != 0 ? Console::StatusOfSignal() : worst;
}

}  // namespace lacquer::cmd
