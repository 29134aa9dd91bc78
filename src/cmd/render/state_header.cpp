#include "cmd/render/state_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>

#include "cmd/command_support.h"
#include "cmd/render/film_record.h"
#include "cmd/version.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/hash_bytes.h"
#include "pbrt/core/json_number.h"

namespace lacquer::cmd {
namespace {

using nlohmann::ordered_json;

/// What decides on the bits of a result beside the sources: another compiler or processor may round
/// otherwise.
ordered_json Program() {
    std::string vectors = "SSE2";
#ifdef __AVX2__
    vectors = "AVX2";
#endif
#ifdef __AVX512F__
    vectors = "AVX-512";
#endif
    // Raised by whatever draws other samples for the same scene: states of the two do not belong together.
    constexpr int kSampling = 2;
    return {
        {"version", kVersion}, {"sampling", kSampling}, {"compiler", __VERSION__}, {"instructions", vectors}};
}

std::string HexHash(std::string_view bytes) { return fmt::format("{:016x}", HashOfBytes(bytes)); }

/// Name without folders, so that a scene may move, and hash of the contents.
void AddFile(const std::string& path, std::map<std::string, std::string>* files) {
    constexpr size_t kMax = size_t(1) << 40;
    const FileBytes bytes = ReadFileBytes(path, {}, {.maxBytes = kMax});
    (*files)[std::filesystem::path(path).filename().string()] += HexHash(bytes.View()) + " ";
}

ordered_json FilesOf(const RenderSetup& setup, const std::vector<std::string>& sceneFiles) {
    std::vector<std::string> paths = sceneFiles;
    for (const FileUse& use : setup.files) paths.push_back(use.path);
    std::sort(paths.begin(), paths.end());
    paths.erase(std::unique(paths.begin(), paths.end()), paths.end());
    std::map<std::string, std::string> files;
    for (const std::string& path : paths)
        if (std::filesystem::is_regular_file(path)) AddFile(path, &files);
    return files;
}

/// Values of a sampler: some depend on how many samples a pixel gets, others do not.
std::string ProbeOf(const Sampler& prototype, const Bounds2i& pixels) {
    constexpr int kSamples = 9, kDimensions = 12;
    const std::unique_ptr<Sampler> sampler = prototype.Clone();
    std::string values;
    for (const Int2 pixel : {pixels.min, pixels.max - 1})
        for (int sample = 0; sample < kSamples; ++sample) {
            sampler->StartPixelSample(pixel, sample);
            for (int d = 0; d < kDimensions; ++d) values += fmt::format("{} ", sampler->Get1D());
        }
    return HexHash(values);
}

Bounds2i BoundsOf(const ordered_json& json) {
    const auto number = [&](size_t i) { return WholeNumber<int>(json.at(i)); };
    return {{number(0), number(2)}, {number(1), number(3)}};
}

/// Numbers that a render can have written.
void Check(const std::string& path, const StatePart& part, const Bounds2i& pixels) {
    const bool isInside = !part.pixels.IsEmpty() && part.pixels.Intersect(pixels) == part.pixels;
    if (!isInside || part.first < 0 || part.least < 0 || part.most < part.least ||
        part.most > std::numeric_limits<int>::max() - part.first)
        throw FileError(path, "this state is damaged: its samples are none that a render takes");
}

/// The first entry that differs, in words; empty if none does.
std::string FirstDifference(const ordered_json& expected, const ordered_json& other, const char* what) {
    for (const auto& [key, value] : expected.items()) {
        if (!other.contains(key)) return fmt::format("{}\"{}\" is missing in the state", what, key);
        if (other[key] != value)
            return value.is_string() && value.get<std::string>().size() > 40
                       ? fmt::format("{}\"{}\" has changed", what, key)
                       : fmt::format("{}\"{}\" is {} now and was {}", what, key, JsonText(value),
                                     JsonText(other[key]));
    }
    for (const auto& [key, value] : other.items())
        if (!expected.contains(key)) return fmt::format("{}\"{}\" is no longer used", what, key);
    return {};
}

}  // namespace

std::string StateHeader::Text() const {
    ordered_json all = ordered_json::array();
    for (const StatePart& part : parts)
        all.push_back({{"pixels", BoundsJson(part.pixels)},
                       {"first", part.first},
                       {"least", part.least},
                       {"most", part.most}});
    return JsonText({{"program", program},
                     {"scene", scene},
                     {"settings", settings},
                     {"film", film},
                     {"name", name},
                     {"samplerValues", samplerValues},
                     {"samplesPerPixel", samplesPerPixel},
                     {"pixels", BoundsJson(pixels)},
                     {"parts", all},
                     {"filterSamples", filterSamples},
                     {"halfBlock", halfBlock},
                     {"seconds", seconds}});
}

StateHeader StateHeader::Read(const std::string& path, const std::string& text) {
    try {
        const ordered_json json = ordered_json::parse(text);
        StateHeader header{json.at("program"), json.at("scene"), json.at("settings"), json.at("film")};
        CheckFilmRecord(header.film);
        header.name = json.at("name");
        header.samplerValues = json.at("samplerValues");
        header.samplesPerPixel = WholeNumber<int>(json.at("samplesPerPixel"));
        header.pixels = BoundsOf(json.at("pixels"));
        for (const ordered_json& part : json.at("parts")) {
            header.parts.push_back({BoundsOf(part.at("pixels")), WholeNumber<int>(part.at("first")),
                                    WholeNumber<int>(part.at("least")), WholeNumber<int>(part.at("most"))});
            Check(path, header.parts.back(), header.pixels);
        }
        header.filterSamples = WholeNumber<int>(json.at("filterSamples"));
        header.halfBlock = WholeNumber<int>(json.at("halfBlock"));
        header.seconds = json.at("seconds");
        return header;
    } catch (const nlohmann::json::exception&) {
        throw FileError(path, "is no state of a render that this program can read");
    }
}

StateHeader HeaderOf(const RenderSetup& setup, const std::vector<std::string>& sceneFiles,
                     const std::string& text, const AovBuffer* aovs, const PassSet* passes,
                     ordered_json settings) {
    settings["resolution"] = {setup.film->Resolution().x, setup.film->Resolution().y};
    settings["seed"] = setup.generatorSeed;
    for (const SceneOption& option : OptionTable()) {
        const auto add = [&](auto field) { settings[option.name] = setup.options.*field; };
        if (option.changesImage) std::visit(add, option.field);
    }
    settings["aov"] = aovs ? aovs->OutputNames() : std::vector<std::string>();
    settings["passes"] = passes ? passes->Layers() : std::vector<std::string>();
    StateHeader header{Program(), FilesOf(setup, sceneFiles), std::move(settings)};
    header.pixels = setup.film->PixelBounds();
    header.samplerValues = ProbeOf(*setup.sampler, {Int2(0), setup.film->Resolution()});
    header.samplesPerPixel = setup.samplesPerPixel;
    if (!text.empty()) header.scene["<stdin>"] = HexHash(text);
    return header;
}

std::string Difference(const StateHeader& expected, const StateHeader& other) {
    std::string difference = FirstDifference(expected.program, other.program, "the program's ");
    if (difference.empty()) difference = FirstDifference(expected.scene, other.scene, "the scene's file ");
    if (difference.empty()) difference = FirstDifference(expected.settings, other.settings, "");
    if (difference.empty() && expected.samplerValues != other.samplerValues)
        difference = fmt::format(
            "the sampler's seed has changed, or the number of samples, on which the values of some samplers "
            "depend; it was --spp {}",
            other.samplesPerPixel);
    return difference;
}

nlohmann::ordered_json BoundsJson(const Bounds2i& b) { return {b.min.x, b.max.x, b.min.y, b.max.y}; }

std::string PixelsInWords(const Bounds2i& b) {
    return fmt::format("[{}, {}, {}, {}]", b.min.x, b.max.x, b.min.y, b.max.y);
}

}  // namespace lacquer::cmd
