#include "pbrt/shapes/ply_header.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <utility>

namespace lacquer {

namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames = {{
    {"char", PlyType::Int8},
    {"int8", PlyType::Int8},
    {"uchar", PlyType::UInt8},
    {"uint8", PlyType::UInt8},
    {"short", PlyType::Int16},
    {"int16", PlyType::Int16},
    {"ushort", PlyType::UInt16},
    {"uint16", PlyType::UInt16},
    {"int", PlyType::Int32},
    {"int32", PlyType::Int32},
    {"uint", PlyType::UInt32},
    {"uint32", PlyType::UInt32},
    {"float", PlyType::Float32},
    {"float32", PlyType::Float32},
    {"double", PlyType::Float64},
    {"float64", PlyType::Float64},
}};

constexpr size_t kMaxElementKinds = 256;

// A word of the file, cut to what fits a message.
std::string Quote(std::string_view word) {
    std::string quoted = "\"";
    for (const char c : word.substr(0, 40)) quoted += c >= ' ' && c < 127 ? c : '?';
    return quoted + (word.size() > 40 ? "...\"" : "\"");
}

// Reads the lines of the header and makes its elements.
class HeaderParser {
  public:
    HeaderParser(std::string_view bytes, const PlyContext& context) : bytes_(bytes), context_(context) {}

    PlyHeader Parse() {
        if (NextLine() != "ply")
            context_.FailAtLine(
                1, fmt::format("{} is no PLY header; \"ply\" is expected on the first line", Quote(line_)));
        while (true) {
            Split(NextLine());
            if (words_.empty() || words_[0] == "comment" || words_[0] == "obj_info") continue;
            if (words_[0] == "end_header") break;
            if (words_[0] == "format")
                ParseFormat();
            else if (words_[0] == "element")
                ParseElement();
            else if (words_[0] == "property")
                ParseProperty();
            else
                Fail(fmt::format(
                    "{} starts no header line; \"format\", \"element\", \"property\", \"comment\" or "
                    "\"end_header\" is expected",
                    Quote(words_[0])));
        }
        if (!formatSeen_)
            Fail("the header ends without a format; \"format ascii 1.0\" or a binary one is expected");
        header_.size = position_;
        header_.numLines = lineNumber_;
        return std::move(header_);
    }

  private:
    [[noreturn]] void Fail(const std::string& message) const { context_.FailAtLine(lineNumber_, message); }

    // Lines may end with LF, CR LF, or CR alone.
    std::string_view NextLine() {
        constexpr size_t kMaxLine = 4096;
        ++lineNumber_;
        const std::string_view rest = bytes_.substr(position_, kMaxLine);
        const size_t end = rest.find_first_of("\r\n");
        line_ = rest.substr(0, end);
        if (end == std::string_view::npos) {
            if (lineNumber_ > 1) Fail("the header ends in the middle; a line \"end_header\" is expected");
            return line_;
        }
        position_ += end + 1;
        if (rest[end] == '\r' && end + 1 < rest.size() && rest[end + 1] == '\n') ++position_;
        return line_;
    }

    void Split(std::string_view line) {
        words_.clear();
        size_t i = 0;
        while ((i = line.find_first_not_of(" \t", i)) != std::string_view::npos) {
            const size_t end = std::min(line.find_first_of(" \t", i), line.size());
            words_.push_back(line.substr(i, end - i));
            i = end;
        }
    }

    void ParseFormat() {
        if (words_.size() != 3 || words_[2] != "1.0")
            Fail("a malformed format; \"format ascii 1.0\" is expected");
        if (words_[1] == "ascii")
            header_.format = PlyHeader::Format::Ascii;
        else if (words_[1] == "binary_little_endian")
            header_.format = PlyHeader::Format::LittleEndian;
        else if (words_[1] == "binary_big_endian")
            header_.format = PlyHeader::Format::BigEndian;
        else
            Fail(fmt::format(
                "unknown format {}; \"ascii\", \"binary_little_endian\" or \"binary_big_endian\" is expected",
                Quote(words_[1])));
        formatSeen_ = true;
    }

    void ParseElement() {
        PlyElement element;
        element.line = lineNumber_;
        if (words_.size() != 3) Fail("a malformed element; \"element name count\" is expected");
        element.name = std::string(words_[1]);
        const std::string_view count = words_[2];
        const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
        if (error != std::errc() || end != count.data() + count.size() || element.count < 0)
            Fail(fmt::format("{} is no count of elements; a whole number is expected", Quote(count)));
        if (header_.elements.size() >= kMaxElementKinds)
            Fail(fmt::format("more than {} kinds of elements are declared", kMaxElementKinds));
        for (const PlyElement& other : header_.elements)
            if (other.name == element.name)
                Fail(fmt::format("element {} is declared twice", Quote(element.name)));
        header_.elements.push_back(std::move(element));
    }

    PlyType ParseType(std::string_view word) const {
        for (const auto& [name, type] : kTypeNames)
            if (name == word) return type;
        Fail(fmt::format(
            "unknown type {}; one of char, uchar, short, ushort, int, uint, float, double is expected",
            Quote(word)));
    }

    void ParseProperty() {
        if (header_.elements.empty()) Fail("a property before the first element; \"element\" is expected");
        PlyProperty property;
        if (words_.size() == 3 && words_[1] != "list") {
            property.type = ParseType(words_[1]);
        } else if (words_.size() == 5 && words_[1] == "list") {
            property.countType = ParseType(words_[2]);
            if (property.countType == PlyType::Float32 || property.countType == PlyType::Float64)
                Fail("the count of a list is a float; an integer type is expected");
            property.type = ParseType(words_[3]);
        } else {
            Fail(
                "a malformed property; \"property type name\" or \"property list type type name\" is "
                "expected");
        }
        property.name = std::string(words_.back());
        header_.elements.back().properties.push_back(std::move(property));
    }

    std::string_view bytes_, line_;
    const PlyContext& context_;
    size_t position_ = 0;
    int64_t lineNumber_ = 0;
    bool formatSeen_ = false;
    std::vector<std::string_view> words_;
    PlyHeader header_;
};

// The fewest bytes that one element takes: in text a digit and a separator for each value.
size_t MinimumBytes(const PlyElement& element, PlyHeader::Format format) {
    size_t bytes = 0;
    for (const PlyProperty& property : element.properties) {
        if (format == PlyHeader::Format::Ascii)
            bytes += 2;
        else
            bytes += PlyTypeSize(property.countType.value_or(property.type));
    }
    return bytes;
}

}  // namespace

void PlyContext::Fail(const std::string& message) const {
    throw SceneError(loc_, fmt::format("{}: {}", path_, message));
}

void PlyContext::FailAtLine(int64_t line, const std::string& message) const {
    throw SceneError(loc_, fmt::format("{}:{}: {}", path_, line, message));
}

void PlyContext::FailAtByte(size_t offset, const std::string& message) const {
    throw SceneError(loc_, fmt::format("{}: byte {}: {}", path_, offset, message));
}

size_t PlyTypeSize(PlyType type) {
    constexpr unsigned char kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return kSizes[size_t(type)];
}

PlyHeader ParsePlyHeader(std::string_view bytes, const PlyContext& context) {
    PlyHeader header = HeaderParser(bytes, context).Parse();
    // The last value of a text file needs no separator.
    size_t left = bytes.size() - header.size + (header.format == PlyHeader::Format::Ascii ? 1 : 0);
    for (const PlyElement& element : header.elements) {
        const size_t each = MinimumBytes(element, header.format);
        if (each == 0) continue;
        if (size_t(element.count) > left / each)
            context.FailAtLine(element.line,
                               fmt::format("{} elements {} are declared; the file has room for {} at most",
                                           element.count, Quote(element.name), left / each));
        left -= size_t(element.count) * each;
    }
    return header;
}

}  // namespace lacquer
