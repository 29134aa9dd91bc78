// The files of lobe tables: lines of words, and a checksum at the end. docs/gaussfit.md describes them.
#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "gaussfit/lobe/lobe_table.h"
#include "pbrt/core/error.h"

namespace lacquer::gaussfit {

namespace {

constexpr std::string_view kMagic = "lacquer-lobe-table", kChecksumKey = "checksum ";

/// FNV-1a of 64 bits: finds damage, not malice.
uint64_t ChecksumOf(std::string_view text) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : text) hash = (hash ^ uint64_t(uint8_t(c))) * 0x100000001b3u;
    return hash;
}

/// The words of a text, line by line, with errors that name the line.
class TableReader {
  public:
    TableReader(std::string_view text, const std::string& path) : rest_(text), path_(path) {}

    [[noreturn]] void Fail(const std::string& problem) const {
        throw FileError(path_, fmt::format("line {}: {}", line_, problem));
    }
    /// Goes to the next line; false at the end.
    bool NextLine() {
        if (rest_.empty()) return false;
        ++line_;
        const size_t length = std::min(rest_.find('\n'), rest_.size());
        current_ = rest_.substr(0, length);
        rest_.remove_prefix(std::min(length + 1, rest_.size()));
        return true;
    }
    /// The next word of the line, empty at its end.
    std::string_view Word() {
        const size_t start = std::min(current_.find_first_not_of(' '), current_.size());
        current_.remove_prefix(start);
        const size_t length = std::min(current_.find(' '), current_.size());
        const std::string_view word = current_.substr(0, length);
        current_.remove_prefix(length);
        return word;
    }
    std::string_view RestOfLine() {
        const size_t start = std::min(current_.find_first_not_of(' '), current_.size());
        return current_.substr(start);
    }
    template <class T>
    T Number(const char* what) {
        const std::string_view word = Word();
        T value{};
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size())
            Fail(fmt::format("\"{}\" where {} was expected", Excerpt(word), what));
        if constexpr (std::is_floating_point_v<T>)
            if (!std::isfinite(value)) Fail(fmt::format("value out of range: {} is {}", what, value));
        return value;
    }
    void ExpectEndOfLine() {
        if (const std::string_view word = Word(); !word.empty())
            Fail(fmt::format("\"{}\" where the line should end", Excerpt(word)));
    }

  private:
    std::string_view rest_, current_;
    const std::string& path_;
    int line_ = 0;
};

/// The text before the checksum. Errors: no table, another version, truncated, damaged.
std::string_view CheckedBody(std::string_view text, const std::string& path) {
    TableReader first(text, path);
    if (!first.NextLine() || first.Word() != kMagic) throw FileError(path, "is no table of lobes");
    // Before the checksum, which another version may compute in another way.
    if (const std::string_view version = first.Word(); version != fmt::format("{}", LobeTable::kVersion))
        throw FileError(path, fmt::format("is a table of lobes of version {}; this program reads version {}",
                                          Excerpt(version), LobeTable::kVersion));
    const size_t at = text.rfind(fmt::format("\n{}", kChecksumKey));
    if (at == std::string_view::npos || !text.ends_with('\n'))
        throw FileError(path, "is truncated: it does not end with a checksum");
    const std::string_view body = text.substr(0, at + 1);
    std::string_view digits = text.substr(body.size() + kChecksumKey.size());
    digits.remove_suffix(1);
    if (digits != fmt::format("{:016x}", ChecksumOf(body)))
        throw FileError(path, fmt::format("is damaged: its checksum is {:016x}, not {} as it says",
                                          ChecksumOf(body), Excerpt(digits)));
    return body;
}

void ReadControlValues(TableReader& reader, const LobeTable::Content& content, LobePatch* patch) {
    for (int i = 0; i < content.NumControlPoints(); ++i) {
        if (!reader.NextLine()) reader.Fail("the control values end here, too early");
        for (int f = 0; f < content.FieldsPerPoint(); ++f)
            patch->control.push_back(reader.Number<float>("a control value"));
        reader.ExpectEndOfLine();
    }
}

/// Reads what follows the key of one line.
void ReadEntry(std::string_view key, TableReader& reader, LobeTable::Content* content) {
    if (key == "option") {
        const std::string name(reader.Word());
        content->options.emplace_back(name, reader.RestOfLine());
    } else if (key == "eta") {
        content->etaMin = reader.Number<double>("an index");
        content->etaMax = reader.Number<double>("an index");
        reader.ExpectEndOfLine();
    } else if (key == "grazing-cosine") {
        content->grazingCosineMin = reader.Number<double>("a cosine");
        reader.ExpectEndOfLine();
    } else if (key == "patch") {
        LobePatch patch;
        patch.alphaMin = reader.Number<double>("alpha");
        patch.alphaMax = reader.Number<double>("alpha");
        const std::string_view angles = reader.Word();
        if (angles != "by-spread" && angles != "by-cosine")
            reader.Fail(fmt::format("\"{}\" where by-spread or by-cosine was expected", Excerpt(angles)));
        patch.anglesBySpread = angles == "by-spread";
        reader.ExpectEndOfLine();
        ReadControlValues(reader, *content, &patch);
        content->patches.push_back(std::move(patch));
    } else {
        reader.Fail(fmt::format("unknown entry \"{}\"", Excerpt(key)));
    }
}

/// The model and the shape of the control grid, which must be what this program was built for.
void ReadModel(TableReader& reader, LobeTable::Content* content) {
    if (!reader.NextLine() || reader.Word() != "model") reader.Fail("no entry \"model\"");
    const std::string_view name = reader.RestOfLine();
    content->model = FindLobeModel(name);
    if (!content->model) reader.Fail(fmt::format("unknown model \"{}\"", Excerpt(name)));
    if (!reader.NextLine() || reader.Word() != "shape") reader.Fail("no entry \"shape\"");
    const std::string expected =
        fmt::format("components {} cosine-power {} degrees {} {} {}", content->model->numComponents,
                    content->model->cosinePower, content->EtaDegree(), kLobeAlphaDegree, kLobeThetaDegree);
    if (const std::string_view shape = reader.RestOfLine(); shape != expected)
        reader.Fail(
            fmt::format("value out of range: shape \"{}\", expected \"{}\"", Excerpt(shape), expected));
}

}  // namespace

LobeTable LobeTable::Parse(std::string_view text, const std::string& path) {
    TableReader reader(CheckedBody(text, path), path);
    reader.NextLine();
    Content content;
    ReadModel(reader, &content);
    while (reader.NextLine()) {
        const std::string_view key = reader.Word();
        ReadEntry(key, reader, &content);
    }
    return {std::move(content), path};
}

std::string LobeTable::ToText() const {
    const Content& c = content_;
    std::string text = fmt::format("{} {}\nmodel {}\nshape components {} cosine-power {} degrees {} {} {}\n",
                                   kMagic, kVersion, c.model->name, c.model->numComponents,
                                   c.model->cosinePower, c.EtaDegree(), kLobeAlphaDegree, kLobeThetaDegree);
    text += fmt::format("eta {} {}\ngrazing-cosine {}\n", c.etaMin, c.etaMax, c.grazingCosineMin);
    for (const auto& [name, value] : c.options) text += fmt::format("option {} {}\n", name, value);
    for (const LobePatch& patch : c.patches) {
        text += fmt::format("patch {} {} {}\n", patch.alphaMin, patch.alphaMax,
                            patch.anglesBySpread ? "by-spread" : "by-cosine");
        const size_t numFields = size_t(c.FieldsPerPoint());
        for (size_t i = 0; i < patch.control.size(); ++i)
            text += fmt::format("{}{}", patch.control[i], (i + 1) % numFields == 0 ? '\n' : ' ');
    }
    return text + fmt::format("{}{:016x}\n", kChecksumKey, ChecksumOf(text));
}

}  // namespace lacquer::gaussfit
