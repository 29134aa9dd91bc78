#include "cmd/scenes/scene_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace lacquer::cmd {
namespace {

using nlohmann::json;
using Counts = std::map<std::string, int64_t>;

/// "1 234 567": groups of three digits.
std::string Number(int64_t value) {
    std::string digits = std::to_string(value);
    for (auto at = std::ptrdiff_t(digits.size()) - 3; at > 0; at -= 3) digits.insert(size_t(at), " ");
    return digits;
}

std::string Bytes(uint64_t bytes) {
    const auto value = double(bytes);
    if (value < 1e3) return fmt::format("{} B", bytes);
    if (value < 1e6) return fmt::format("{:.1f} kB", value / 1e3);
    return value < 1e9 ? fmt::format("{:.1f} MB", value / 1e6) : fmt::format("{:.2f} GB", value / 1e9);
}

/// "10 trianglemesh, 2 sphere"; "none".
std::string List(const Counts& counts) {
    std::string text;
    for (const auto& [name, count] : counts)
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", Number(count), name);
    return text.empty() ? "none" : text;
}

/// Rows of a table with columns as wide as they need be, two blanks between.
class Table {
  public:
    explicit Table(std::vector<std::string> head) : rows_{std::move(head)} {}
    void Add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
    std::string Text() const {
        if (rows_.size() == 1) return {};
        std::vector<size_t> widths(rows_[0].size(), 0);
        for (const auto& row : rows_)
            for (size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
        std::string text;
        for (const auto& row : rows_) {
            std::string line = "   ";
            for (size_t c = 0; c < row.size(); ++c) line += fmt::format(" {:<{}} ", row[c], widths[c]);
            text += line.erase(line.find_last_not_of(' ') + 1) + "\n";
        }
        return text;
    }

  private:
    std::vector<std::vector<std::string>> rows_;
};

std::string Entry(const char* name, const std::string& value) {
    return fmt::format("  {:<14}{}\n", name, value);
}

std::string Size(Int2 r) { return fmt::format("{} x {}", r.x, r.y); }

std::string ImageLines(const SceneSurvey& s) {
    std::string text = fmt::format("{}: {} pixels, {} {} each, to {}\n", s.name, Size(s.resolution),
                                   s.samplesPerPixel, s.samplesPerPixel == 1 ? "sample" : "samples", s.image);
    if (s.pixels.Area() != int64_t(s.resolution.x) * s.resolution.y)
        text += Entry("part", fmt::format("x {}..{}, y {}..{}", s.pixels.min.x, s.pixels.max.x,
                                          s.pixels.min.y, s.pixels.max.y));
    text += Entry("camera", s.camera);
    text += Entry("film", fmt::format("{}, filter {}, colour space {}", s.film, s.filter, s.colorSpace));
    text += Entry("sampler", s.sampler);
    return text + Entry("integrator", s.integrator);
}

std::string ContentLines(const SceneSurvey& s) {
    std::string text = Entry("shapes", List(s.shapes));
    text += Entry("primitives",
                  fmt::format("{} triangles, {} others", Number(s.triangles), Number(s.otherPrimitives)));
    if (s.objects + s.instances > 0)
        text +=
            Entry("objects", fmt::format("{}, placed by {} instances: {} primitives in the scene",
                                         Number(s.objects), Number(s.instances), Number(s.placedPrimitives)));
    text += Entry("lights", List(s.lights));
    if (!s.areaLights.empty())
        text += Entry("area lights",
                      fmt::format("{} shapes, {} primitives", List(s.areaLights), Number(s.emitters)));
    text += Entry("media", List(s.media));
    text += Entry("materials", List(s.materialTypes));
    Table layered({"layered", "type", "estimator", "pdf", "shapes"});
    for (const MaterialUse& m : s.materials)
        if (!m.estimator.empty()) layered.Add({m.name, m.type, m.estimator, m.pdf, Number(m.shapes)});
    return text + layered.Text();
}

std::string TextureLines(const SceneSurvey& s) {
    Counts types;
    Table table({"image", "of", "size", "memory"});
    for (const TextureUse& t : s.textures) {
        ++types[t.type];
        if (!t.file.empty())
            table.Add({t.file, fmt::format("texture \"{}\"", t.name), Size(t.resolution),
                       t.isShared ? "shared" : Bytes(t.bytes)});
    }
    for (const ImageUse& i : s.images) table.Add({i.file, i.user, Size(i.resolution), Bytes(i.bytes)});
    return Entry("textures", List(types)) + table.Text();
}

std::string MemoryLine(const MemoryForecast& m) {
    return Entry(
        "memory",
        fmt::format("{}: geometry {}, acceleration {}, textures {}, other images {}, media {}, film {}",
                    Bytes(m.Total()), Bytes(m.geometry), Bytes(m.accelerationStructure), Bytes(m.textures),
                    Bytes(m.images), Bytes(m.media), Bytes(m.film)));
}

std::string FileLines(const SceneSurvey& s) {
    uint64_t sum = 0;
    Table table({"file", "of", "size"});
    for (const ListedFile& f : s.files) {
        sum += f.bytes;
        table.Add({f.path, f.role, Bytes(f.bytes)});
    }
    return Entry("files", fmt::format("{}, {}", s.files.size(), Bytes(sum))) + table.Text();
}

json ToJson(const MemoryForecast& m) {
    return {{"geometry", m.geometry}, {"acceleration_structure", m.accelerationStructure},
            {"textures", m.textures}, {"images", m.images},
            {"media", m.media},       {"film", m.film},
            {"total", m.Total()}};
}

json MaterialsJson(const SceneSurvey& s) {
    json list = json::array();
    for (const MaterialUse& m : s.materials) {
        if (m.name == "@0" && !m.isUsed) continue;  // the format's default, which nobody wrote
        json entry = {
            {"name", m.name}, {"type", m.type}, {"place", m.place}, {"shapes", m.shapes}, {"used", m.isUsed}};
        entry["estimator"] = m.estimator.empty() ? json() : json(m.estimator);
        entry["pdf"] = m.pdf.empty() ? json() : json(m.pdf);
        list.push_back(entry);
    }
    return list;
}

json TexturesJson(const SceneSurvey& s) {
    json list = json::array();
    for (const TextureUse& t : s.textures) {
        json entry = {{"name", t.name}, {"place", t.place}, {"value", t.value}, {"type", t.type}};
        const bool isImage = !t.file.empty();
        entry["file"] = isImage ? json(t.file) : json();
        entry["resolution"] = isImage ? json({t.resolution.x, t.resolution.y}) : json();
        entry["bytes"] = isImage ? json(t.bytes) : json();
        entry["shared"] = t.isShared;
        list.push_back(entry);
    }
    return list;
}

}  // namespace

std::string SceneInfoText(const SceneSurvey& s) {
    std::string text =
        ImageLines(s) + ContentLines(s) + TextureLines(s) + MemoryLine(s.memory) + FileLines(s);
    if (s.warnings.empty()) text += Entry("warnings", "none");
    for (const std::string& warning : s.warnings) text += "  " + warning + "\n";
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c != '\n' && std::iscntrl((unsigned char)c); }, ' ');
    return text;
}

json SceneInfoJson(const SceneSurvey& s) {
    json images = json::array(), files = json::array();
    for (const ImageUse& i : s.images)
        images.push_back({{"file", i.file},
                          {"user", i.user},
                          {"resolution", {i.resolution.x, i.resolution.y}},
                          {"bytes", i.bytes}});
    for (const ListedFile& f : s.files)
        files.push_back({{"file", f.path}, {"role", f.role}, {"bytes", f.bytes}});
    return {
        {"kind", "scene"},
        {"file", s.name},
        {"image", s.image},
        {"resolution", {s.resolution.x, s.resolution.y}},
        {"pixels",
         {{"x0", s.pixels.min.x}, {"x1", s.pixels.max.x}, {"y0", s.pixels.min.y}, {"y1", s.pixels.max.y}}},
        {"samples_per_pixel", s.samplesPerPixel},
        {"camera", s.camera},
        {"film", s.film},
        {"color_space", s.colorSpace},
        {"filter", s.filter},
        {"sampler", s.sampler},
        {"integrator", s.integrator},
        {"accelerator", s.accelerator},
        {"shapes", s.shapes},
        {"triangles", s.triangles},
        {"other_primitives", s.otherPrimitives},
        {"objects", s.objects},
        {"instances", s.instances},
        {"placed_primitives", s.placedPrimitives},
        {"lights", s.lights},
        {"area_lights", s.areaLights},
        {"emitting_primitives", s.emitters},
        {"material_types", s.materialTypes},
        {"materials", MaterialsJson(s)},
        {"textures", TexturesJson(s)},
        {"images", images},
        {"media", s.media},
        {"memory_bytes", ToJson(s.memory)},
        {"files", files},
        {"warnings", s.warnings}};
}

}  // namespace lacquer::cmd
