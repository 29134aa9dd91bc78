#include "materialx/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <pugixml.hpp>
#include <set>

#include "materialx/surfaces.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/scene/statements.h"

namespace lacquer::materialx {
namespace {

constexpr size_t kMaxBytes = size_t(64) << 20;
/// Nodes that an input may go through to its image.
constexpr int kMaxNodes = 64;

/// Numbers between commas; empty if something else stands there.
std::vector<float> NumbersIn(std::string_view text) {
    std::vector<float> numbers;
    while (true) {
        const size_t begin = text.find_first_not_of(" \t\r\n");
        if (begin == std::string_view::npos) return {};
        text.remove_prefix(begin);
        float x = 0;
        const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), x);
        if (error != std::errc() || !std::isfinite(x)) return {};
        numbers.push_back(x);
        text.remove_prefix(size_t(rest - text.data()));
        const size_t next = text.find_first_not_of(" \t\r\n");
        if (next == std::string_view::npos) return numbers;
        if (text[next] != ',') return {};
        text.remove_prefix(next + 1);
    }
}

/// Where an input gets its value from: numbers, or an image times numbers.
struct Source {
    std::vector<float> numbers;  ///< of a value, or factors of the image; empty: a text
    std::string text;            ///< of a value that is no number
    std::string image;           ///< file as it is written; empty: a value
    bool isSRGB = false;
    std::vector<float> tiling = {1, 1};
};

class Translator {
  public:
    explicit Translator(const std::string& path) : path_(path) {
        const FileBytes bytes = ReadFileBytes(path, {}, {kMaxBytes});
        text_ = std::string(bytes.View());
        const pugi::xml_parse_result result = document_.load_buffer(text_.data(), text_.size());
        if (!result)
            throw SceneError(LocAt(result.offset), fmt::format("is no XML: {}", result.description()));
        root_ = document_.child("materialx");
        if (!root_)
            throw SceneError({path, 1, 1}, "is no MaterialX document; expected the element \"materialx\"");
    }

    MaterialText Translate() {
        std::set<std::string> shown;
        for (const pugi::xml_node material : root_.children("surfacematerial")) {
            const pugi::xml_node shader = ShaderOf(material);
            if (!shader) continue;
            Write(NameOf(material), shader);
            shown.insert(NameOf(shader));
        }
        for (const pugi::xml_node node : root_.children())
            if (KindOf(node) && !shown.contains(NameOf(node))) Write(NameOf(node), node);
        if (out_.materials.empty()) {
            std::string kinds;
            for (const SurfaceKind& kind : SurfaceKinds())
                kinds += fmt::format("{}{}", kinds.empty() ? "" : " or ", kind.category);
            throw SceneError({path_, 1, 1},
                             fmt::format("has no surface that is understood; expected {}", kinds));
        }
        return std::move(out_);
    }

  private:
    static std::string NameOf(const pugi::xml_node& node) { return node.attribute("name").value(); }
    static const SurfaceKind* KindOf(const pugi::xml_node& node) {
        for (const SurfaceKind& kind : SurfaceKinds())
            if (kind.category == node.name()) return &kind;
        return nullptr;
    }

    // ---- Places ----

    FileLoc LocAt(ptrdiff_t offset) const {
        FileLoc loc{path_, 1, 1};
        for (ptrdiff_t i = 0; i < offset && size_t(i) < text_.size(); ++i) {
            ++loc.column;
            if (text_[size_t(i)] != '\n') continue;
            ++loc.line;
            loc.column = 1;
        }
        return loc;
    }
    FileLoc LocOf(const pugi::xml_node& node) const { return LocAt(node.offset_debug()); }
    [[noreturn]] void Fail(const pugi::xml_node& node, const std::string& message) const {
        throw SceneError(LocOf(node), message);
    }
    void Warn(const pugi::xml_node& node, const std::string& message) {
        out_.warnings.push_back({Diagnostic::Severity::Warning, LocOf(node), message});
    }

    // ---- Nodes ----

    /// A node beside `from`, or at the root.
    pugi::xml_node Find(const pugi::xml_node& from, const std::string& name) const {
        for (const pugi::xml_node scope : {from.parent(), root_})
            if (const pugi::xml_node found = scope.find_child_by_attribute("name", name.c_str()))
                return found;
        return {};
    }

    pugi::xml_node ShaderOf(const pugi::xml_node& material) {
        const pugi::xml_node input = material.find_child_by_attribute("input", "name", "surfaceshader");
        const std::string name = input.attribute("nodename").value();
        const pugi::xml_node shader = name.empty() ? pugi::xml_node() : Find(material, name);
        if (!shader)
            Fail(material,
                 fmt::format("the material \"{}\" names no surface shader that is there", NameOf(material)));
        if (KindOf(shader)) return shader;
        Warn(shader, fmt::format("the surface \"{}\" is a {}, which is not understood", NameOf(shader),
                                 shader.name()));
        return {};
    }

    /// What an input is connected to; none if it has a value.
    pugi::xml_node ConnectedTo(const pugi::xml_node& input) const {
        if (const auto graphName = input.attribute("nodegraph")) {
            const pugi::xml_node graph =
                root_.find_child_by_attribute("nodegraph", "name", graphName.value());
            if (!graph) Fail(input, fmt::format("there is no node graph \"{}\"", graphName.value()));
            const std::string wanted = input.attribute("output").value();
            const pugi::xml_node output =
                wanted.empty() ? graph.child("output")
                               : graph.find_child_by_attribute("output", "name", wanted.c_str());
            if (!output)
                Fail(input,
                     fmt::format("the node graph \"{}\" has no output \"{}\"", graphName.value(), wanted));
            return Named(output, output);
        }
        return Named(input, input.parent());
    }
    /// The node that an input or an output names. @param beside  what it stands beside
    pugi::xml_node Named(const pugi::xml_node& input, const pugi::xml_node& beside) const {
        const auto name = input.attribute("nodename");
        if (!name) return {};
        const pugi::xml_node node = Find(beside, name.value());
        if (!node) Fail(input, fmt::format("there is no node \"{}\"", name.value()));
        return node;
    }
    /// An input of a node, or that of its graph which it stands for.
    pugi::xml_node InputOf(const pugi::xml_node& node, const char* name) const {
        const pugi::xml_node input = node.find_child_by_attribute("input", "name", name);
        if (const auto interface = input.attribute("interfacename"))
            return node.parent().find_child_by_attribute("input", "name", interface.value());
        return input;
    }

    /// Empty, after a warning, where a node is not understood.
    std::optional<Source> SourceOf(const pugi::xml_node& input, int depth = 0) {
        if (depth > kMaxNodes) Fail(input, "the nodes of this input go round in a circle, or are too many");
        const pugi::xml_node node = ConnectedTo(input);
        if (!node) return ValueOf(input);
        const std::string_view category = node.name();
        if (category == "constant") return SourceOf(InputOf(node, "value"), depth + 1);
        if (category == "image" || category == "tiledimage") return ImageOf(node);
        if (category == "multiply") return ProductOf(node, depth);
        if (category == "dot" || category == "convert" || category == "normalmap")
            return SourceOf(InputOf(node, "in"), depth + 1);
        Warn(node, fmt::format("the node \"{}\" is a {}, which is not understood: \"{}\" keeps its default; "
                               "understood are image, "
                               "tiledimage, constant, multiply, convert and normalmap",
                               NameOf(node), category, NameOf(input)));
        return {};
    }

    std::optional<Source> ValueOf(const pugi::xml_node& input) const {
        Source source;
        source.text = input.attribute("value").value();
        source.numbers = NumbersIn(source.text);
        return source;
    }

    std::optional<Source> ImageOf(const pugi::xml_node& node) const {
        const pugi::xml_node file = InputOf(node, "file");
        Source source;
        source.numbers = {1};
        source.image = file.attribute("value").value();
        if (source.image.empty()) Fail(node, fmt::format("the image \"{}\" names no file", NameOf(node)));
        std::string space;
        for (pugi::xml_node at = file; at && space.empty(); at = at.parent())
            space = at.attribute("colorspace").value();
        source.isSRGB = space == "srgb_texture" || space == "sRGB" || space == "srgb_displayp3";
        if (const std::vector<float> tiling = NumbersIn(InputOf(node, "uvtiling").attribute("value").value());
            tiling.size() == 2)
            source.tiling = tiling;
        return source;
    }

    /// An image times a constant, either way round; or two constants.
    std::optional<Source> ProductOf(const pugi::xml_node& node, int depth) {
        std::optional<Source> a = SourceOf(InputOf(node, "in1"), depth + 1),
                              b = SourceOf(InputOf(node, "in2"), depth + 1);
        if (!a || !b) return {};
        if (a->image.empty()) std::swap(a, b);
        if (!b->image.empty() || a->numbers.empty() || b->numbers.empty()) {
            Warn(node, fmt::format("\"{}\" multiplies what is not one image and constants; it is left out",
                                   NameOf(node)));
            return {};
        }
        Source product = *a;
        product.numbers.resize(std::max(a->numbers.size(), b->numbers.size()), a->numbers.back());
        for (size_t i = 0; i < product.numbers.size(); ++i)
            product.numbers[i] *= b->numbers[std::min(i, b->numbers.size() - 1)];
        return product;
    }

    // ---- Directives ----

    void Write(const std::string& name, const pugi::xml_node& shader) {
        const SurfaceKind& kind = *KindOf(shader);
        std::string parameters;
        std::set<std::string_view> known = {};
        for (const SurfaceInput& wanted : kind.inputs) {
            known.insert(wanted.name);
            parameters += ParameterOf(wanted, InputOf(shader, std::string(wanted.name).c_str()), name);
        }
        for (const pugi::xml_node input : shader.children("input"))
            if (!known.contains(NameOf(input)))
                Warn(input, fmt::format("a {} has no input \"{}\"", kind.category, NameOf(input)));
        out_.text +=
            fmt::format("MakeNamedMaterial {} \"string type\" \"openpbr\"{}\n", QuotedText(name), parameters);
        out_.materials.push_back(name);
    }

    std::string ParameterOf(const SurfaceInput& wanted, const pugi::xml_node& input,
                            const std::string& material) {
        if (!input) return wanted.fallback.empty() ? "" : Constant(wanted, NumbersIn(wanted.fallback));
        if (wanted.kind == InputKind::Ignored) {
            Warn(input, fmt::format("\"{}\" has no counterpart and is left out", wanted.name));
            return "";
        }
        const std::optional<Source> source = SourceOf(input);
        if (!source) return wanted.fallback.empty() ? "" : Constant(wanted, NumbersIn(wanted.fallback));
        if (wanted.kind == InputKind::Bool)
            return fmt::format("\n    \"bool {}\" {}", wanted.parameter,
                               source->text == "true" ? "true" : "false");
        if (wanted.kind == InputKind::Normal) {
            if (source->image.empty()) return "";
            return fmt::format("\n    \"string {}\" {}", wanted.parameter, QuotedText(PathOf(source->image)));
        }
        if (!source->image.empty()) return Texture(wanted, *source, material);
        if (source->numbers.empty() || (wanted.kind == InputKind::Color && source->numbers.size() != 3))
            Fail(input, fmt::format("\"{}\" is \"{}\"; expected {}", wanted.name, source->text,
                                    wanted.kind == InputKind::Color ? "three numbers with commas between"
                                                                    : "a number"));
        return Constant(wanted, source->numbers);
    }

    static std::string Constant(const SurfaceInput& wanted, std::vector<float> numbers) {
        for (float& x : numbers) x *= wanted.factor;
        if (wanted.kind == InputKind::Color)
            return fmt::format("\n    \"rgb {}\" [{} {} {}]", wanted.parameter, numbers[0], numbers[1],
                               numbers[2]);
        float mean = 0;
        for (const float x : numbers) mean += x / float(numbers.size());
        if (wanted.kind == InputKind::FilmInNano)
            return mean > 0 ? fmt::format("\n    \"float {}\" {} \"float thin_film_weight\" 1",
                                          wanted.parameter, mean)
                            : "";
        return fmt::format("\n    \"float {}\" {}", wanted.parameter, mean);
    }

    /// A texture before the material, and the parameter that names it.
    std::string Texture(const SurfaceInput& wanted, const Source& source, const std::string& material) {
        const bool isColor = wanted.kind == InputKind::Color;
        std::vector<float> factors = source.numbers;
        for (float& x : factors) x *= wanted.factor;
        factors.resize(isColor ? 3 : 1, factors.back());
        const char* type = isColor ? "spectrum" : "float";
        const std::string name = fmt::format("{}: {}", material, wanted.name), image = name + " image";
        const bool isScaled = std::any_of(factors.begin(), factors.end(), [](float x) { return x != 1; });
        // v grows upward in both.
        out_.text +=
            fmt::format("Texture {} \"{}\" \"imagemap\" \"string filename\" {} \"string encoding\" \"{}\"",
                        QuotedText(isScaled ? image : name), type, QuotedText(PathOf(source.image)),
                        source.isSRGB ? "sRGB" : "linear");
        if (source.tiling != std::vector<float>{1, 1})
            out_.text +=
                fmt::format(" \"float uscale\" {} \"float vscale\" {}", source.tiling[0], source.tiling[1]);
        out_.text += "\n";
        if (isScaled) {
            out_.text += fmt::format("Texture {} \"{}\" \"scale\" \"texture tex\" {} ", QuotedText(name),
                                     type, QuotedText(image));
            out_.text += isColor
                             ? fmt::format("\"rgb scale\" [{} {} {}]\n", factors[0], factors[1], factors[2])
                             : fmt::format("\"float scale\" {}\n", factors[0]);
        }
        const char* film = wanted.kind == InputKind::FilmInNano ? " \"float thin_film_weight\" 1" : "";
        return fmt::format("\n    \"texture {}\" {}{}", wanted.parameter, QuotedText(name), film);
    }

    /// Of an image: as it is written from the document's folder.
    std::string PathOf(const std::string& file) const {
        const std::filesystem::path image(file);
        return image.is_absolute() ? file : (std::filesystem::path(path_).parent_path() / image).string();
    }

    std::string path_, text_;
    pugi::xml_document document_;
    pugi::xml_node root_;
    MaterialText out_;
};

}  // namespace

MaterialText ReadDocument(const std::string& path) { return Translator(path).Translate(); }

bool IsDocumentName(const std::string& path) { return path.ends_with(".mtlx"); }

}  // namespace lacquer::materialx
