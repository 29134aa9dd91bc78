#include "cmd/render/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "cmd/command_support.h"
#include "cmd/version.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/hash_bytes.h"
#include "pbrt/film/passes.h"
#include "pbrt/film/state_file.h"

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
    return {{"version", kVersion}, {"compiler", __VERSION__}, {"instructions", vectors}};
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
    return JsonText({{"program", program},
                     {"scene", scene},
                     {"settings", settings},
                     {"samplerValues", samplerValues},
                     {"samplesPerPixel", samplesPerPixel},
                     {"samples", {{"first", firstSample}, {"end", endSample}, {"taken", numSamples}}},
                     {"filterSamples", filterSamples},
                     {"halfBlock", halfBlock},
                     {"seconds", seconds}});
}

StateHeader StateHeader::Read(const std::string& path, const std::string& text) {
    try {
        const ordered_json json = ordered_json::parse(text);
        const ordered_json& samples = json.at("samples");
        StateHeader header{json.at("program"), json.at("scene"), json.at("settings")};
        header.samplerValues = json.at("samplerValues");
        header.samplesPerPixel = json.at("samplesPerPixel");
        header.firstSample = samples.at("first");
        header.endSample = samples.at("end");
        header.numSamples = samples.at("taken");
        header.filterSamples = json.at("filterSamples");
        header.halfBlock = json.at("halfBlock");
        header.seconds = json.at("seconds");
        return header;
    } catch (const nlohmann::json::exception&) {
        throw FileError(path, "is no state of a render that this program can read");
    }
}

StateHeader HeaderOf(const RenderSetup& setup, const std::vector<std::string>& sceneFiles,
                     const std::string& text, const AovBuffer* aovs, const PassSet* passes,
                     ordered_json settings) {
    const Bounds2i bounds = setup.film->PixelBounds();
    settings["resolution"] = {setup.film->Resolution().x, setup.film->Resolution().y};
    settings["pixelbounds"] = {bounds.min.x, bounds.max.x, bounds.min.y, bounds.max.y};
    settings["seed"] = setup.generatorSeed;
    for (const SceneOption& option : OptionTable()) {
        const auto add = [&](auto field) { settings[option.name] = setup.options.*field; };
        if (option.changesImage) std::visit(add, option.field);
    }
    settings["aov"] = aovs ? aovs->OutputNames() : std::vector<std::string>();
    settings["passes"] = passes ? passes->Layers() : std::vector<std::string>();
    StateHeader header{Program(), FilesOf(setup, sceneFiles), std::move(settings)};
    header.samplerValues = ProbeOf(*setup.sampler, bounds);
    header.samplesPerPixel = setup.sampler->SamplesPerPixel();
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

RenderCheckpoint::RenderCheckpoint(std::string resume, std::string path, double interval, Console* console)
    : resume_(std::move(resume)), path_(std::move(path)), interval_(interval), console_(console) {
    std::error_code error;
    if (!path_.empty() && std::filesystem::exists(path_, error) &&
        (resume_.empty() || !std::filesystem::equivalent(path_, resume_, error)))
        throw FileError(path_, fmt::format("is there already; to go on from it, add --resume {}; to begin "
                                           "anew, remove it",
                                           path_));
    if (!path_.empty()) {
        CheckOutputFile(path_);
        lock_.emplace(path_);
    }
    if (resume_.empty()) return;
    StateFile file = ReadStateFile(resume_);
    resumed_ = StateHeader::Read(resume_, file.header);
    stored_ = std::move(file.arrays);
}

std::optional<int> RenderCheckpoint::FilterSamples() const {
    if (resumed_) return resumed_->filterSamples;
    return {};
}

void RenderCheckpoint::Attach(StateHeader header, Film* film, AovBuffer* aovs) {
    header_ = std::move(header);
    film_ = film;
    aovs_ = aovs;
    if (!resumed_) return;
    std::string why = Difference(header_, *resumed_);
    if (!why.empty()) throw FileError(resume_, fmt::format("is the state of another render: {}", why));
    const int taken = resumed_->numSamples;
    if (taken > header_.endSample - header_.firstSample)
        throw FileError(
            resume_, fmt::format("has {} samples in each pixel, more than the {} that are asked for", taken,
                                 header_.endSample - header_.firstSample));
    std::vector<StateArray> arrays;
    film->AppendState(&arrays);
    if (aovs) aovs->AppendState("outputs: ", &arrays);
    why = AddState(stored_, arrays);
    if (!why.empty()) throw FileError(resume_, fmt::format("does not fit this render: {}", why));
    stored_.clear();
    header_.halfBlock = resumed_->halfBlock;
    header_.filterSamples = resumed_->filterSamples;
}

void RenderCheckpoint::AddTo(RenderOptions* options) {
    if (!IsUsed()) return;
    options->halfBlock = header_.halfBlock;
    options->resumes = resumed_.has_value();
    if (path_.empty()) return;
    options->checkpointInterval = interval_;
    options->checkpoint = [this](double seconds) {
        // The next one may be better; the last one must be.
        try {
            Write(seconds);
        } catch (const FileError& e) {
            console_->Warn(e.Message());
        }
    };
}

void RenderCheckpoint::Write(double seconds) {
    const std::vector<int> counts = film_->SampleCounts();
    header_.numSamples = *std::min_element(counts.begin(), counts.end());
    header_.seconds = SecondsBefore() + seconds;
    std::vector<StateArray> arrays;
    film_->AppendState(&arrays);
    if (aovs_) aovs_->AppendState("outputs: ", &arrays);
    WriteStateFile(path_, header_.Text(), arrays);
}

void RenderCheckpoint::Finish(double seconds) {
    if (!path_.empty()) Write(seconds);
}

}  // namespace lacquer::cmd
