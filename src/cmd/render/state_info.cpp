#include "cmd/render/state_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "cmd/console.h"
#include "pbrt/film/state_file.h"

namespace lacquer::cmd {
namespace {

using nlohmann::json;

std::string Listed(const json& names) {
    const auto list = names.get<std::vector<std::string>>();
    return list.empty() ? "none" : fmt::format("{}", fmt::join(list, ", "));
}

/// "samples 0 to 7 of all pixels; of some up to 9".
std::string HeldSamples(const StatePart& part, const Bounds2i& pixels) {
    const std::string most =
        part.least == part.most ? "" : fmt::format("; some have up to {} samples", part.most);
    if (part.least == 0) return fmt::format("none that all of {} have{}", PixelsInWords(part.pixels), most);
    return SamplesInWords(SampleBox{part.pixels, part.first, part.first + part.least}, pixels) + most;
}

}  // namespace

StateInfo ReadStateInfo(const std::string& path) {
    StateInfo info{path, StateHeader::Read(path, ReadStateFile(path).header)};
    info.bytes = std::filesystem::file_size(path);
    const auto age = std::filesystem::file_time_type::clock::now() - std::filesystem::last_write_time(path);
    info.ageSeconds = std::max(0.0, std::chrono::duration<double>(age).count());
    return info;
}

json StateInfoJson(const StateInfo& info) {
    const StateHeader& h = info.header;
    json parts = json::array();
    for (const StatePart& part : h.parts)
        parts.push_back({{"pixels", BoundsJson(part.pixels)},
                         {"first_sample", part.first},
                         {"samples", part.least},
                         {"most_samples", part.most}});
    return {{"kind", "state"},
            {"file", info.path},
            {"bytes", info.bytes},
            {"age_seconds", info.ageSeconds},
            {"scene", h.name},
            {"scene_files", h.scene},
            {"film", h.film.at("film").at("type")},
            {"integrator", h.film.at("integrator")},
            {"sampler", h.film.at("sampler")},
            {"full_resolution", h.film.at("resolution")},
            {"pixels", BoundsJson(h.pixels)},
            {"samples_per_pixel", h.samplesPerPixel},
            {"parts", parts},
            {"outputs", h.film.at("outputs")},
            {"passes", h.film.at("passes")},
            {"settings", h.settings},
            {"program", h.program},
            {"render_seconds", h.seconds}};
}

std::string StateInfoText(const StateInfo& info) {
    const json all = StateInfoJson(info);
    const StateHeader& h = info.header;
    const auto text = [&](const char* name) { return all.at(name).get<std::string>(); };
    std::string lines = fmt::format("{}: a state, {:.3g} MB, written {} ago, undamaged\n", info.path,
                                    double(info.bytes) / 1e6, FormatSeconds(info.ageSeconds));
    lines += fmt::format("  scene: {} ({} files); integrator {}, sampler {}\n", text("scene"), h.scene.size(),
                         text("integrator"), text("sampler"));
    lines += fmt::format("  film: {}, {} x {} pixels, of them {}\n", text("film"),
                         all.at("full_resolution").at(0).get<int>(),
                         all.at("full_resolution").at(1).get<int>(), PixelsInWords(h.pixels));
    for (const StatePart& part : h.parts) lines += fmt::format("  holds: {}\n", HeldSamples(part, h.pixels));
    lines += fmt::format("  of {} samples per pixel; rendered for {}\n", h.samplesPerPixel,
                         FormatSeconds(h.seconds));
    lines += fmt::format("  outputs: {}; passes: {}\n", Listed(all.at("outputs")), Listed(all.at("passes")));
    return lines;
}

}  // namespace lacquer::cmd
